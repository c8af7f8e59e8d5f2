"""A decoder that is made of a reader says which frames are of one message."""

from __future__ import annotations

import pickle
from enum import Enum

from protocols.common.decoding import ReaderDecoder
from protocols.common.framing import Dropped, Frame, ScanningReader
from protocols.common.items import Item, Kind
from tests.each import each

Reason = Enum("Reason", {"FORM": "no newline"})


def look(held):
    """Text up to a newline."""
    end = held.find(b"\n") + 1
    return Frame(held[:end], held[: end - 1]) if end > 1 else Reason.FORM if end else None


def item(frame):
    return Item(kind=Kind.FRAME, name="text", raw=frame.raw)


def address(frame):
    return frame.payload.partition(b",")[0]


def decoder(**more):
    return ReaderDecoder(
        ScanningReader(look), rejected=Dropped, senseless=ValueError, body="payload", item=item, **more
    )


@each(("more", "sorts"), [({}, [b"G", b"G", None, b"G"]), ({"sort": address}, [b"GGA", b"GLL", None, b"GGA"])])
def test_messages_are_told_apart_by_their_first_byte_or_as_it_is_said(more, sorts):
    made = pickle.loads(pickle.dumps(decoder(**more)))
    assert [made.sort(found) for found in made.find(b"GGA,1\nGLL,2\n\nGGA,3\n")] == sorts
