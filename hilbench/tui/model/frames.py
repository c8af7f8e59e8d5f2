"""The frames on the operator's line, read from the bytes that the journal holds."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from hilbench.decode.decoders import DECODERS, DecodeOptions, Decoder
from hilbench.decode.items import Item, Kind
from hilbench.decode.lines import said
from protocols import pkt

__all__ = ["KEPT_FRAMES", "FrameModel", "FramesModel"]

KEPT_FRAMES = 2000

Event = Mapping[str, Any]


@dataclass(frozen=True, slots=True, kw_only=True)
class FrameModel:
    """A frame, or bytes that are none.

    Attributes:
        number: counted from 1, since the journal began.
        ns: bench time at which it was handed over, or complete.
        sent: whether the operator sent it.
        item: what it says.
    """

    number: int
    ns: int
    sent: bool
    item: Item

    @property
    def good(self) -> bool:
        """Whether it is sound and says something."""
        return self.item.kind is Kind.FRAME

    @property
    def text(self) -> str:
        """What it says in one line."""
        return said(self.item)


class FramesModel:
    """The latest frames of both directions, in the order in which they came.

    Args:
        live: what the header of the journal says of the bench.
    """

    def __init__(self, live: Event) -> None:
        self.frames: deque[FrameModel] = deque(maxlen=KEPT_FRAMES)
        self.protocol = str(live.get("protocol", ""))
        self.options = _options(live)
        self._operator = live.get("operator")
        self._count = 0
        self._decoders: dict[bool, Decoder] = {}
        if self.protocol in DECODERS:
            make = DECODERS[self.protocol]
            ends = ("target", "host") if live.get("side") == "target" else ("host", "target")
            self._decoders = {True: make(self.options, ends[0]), False: make(self.options, ends[1])}

    @property
    def count(self) -> int:
        """How many there were in all."""
        return self._count

    def take(self, event: Event) -> list[FrameModel]:
        """Take bytes that the operator sent or heard; return the frames that they complete."""
        if event.get("source") != self._operator or not self._decoders:
            return []
        sent = event["kind"] == "tx"
        found = []
        for item in self._decoders[sent].feed(bytes.fromhex(event["data"])):
            self._count += 1
            found.append(FrameModel(number=self._count, ns=event["ns"], sent=sent, item=item))
        self.frames.extend(found)
        return found

    def matching(self, pattern: str, count: int) -> list[FrameModel]:
        """Return the latest frames that a filter lets pass, oldest first.

        Args:
            pattern: words that all must stand in a frame's line, in any case; ``-word`` must not, ``>`` is sent, ``<``
                is heard, ``!`` is not sound.
            count: how many at most.
        """
        words = pattern.lower().split()
        found: list[FrameModel] = []
        for frame in reversed(self.frames):
            if all(_passes(word, frame) for word in words):
                found.append(frame)
                if len(found) == count:
                    break
        return found[::-1]


def _options(live: Event) -> DecodeOptions:
    framing = pkt.Framing[live["framing"]] if "framing" in live else pkt.Framing.LEN
    schema = pkt.Schema[live["schema"]] if "schema" in live else pkt.Schema.V2
    return DecodeOptions(framing=framing, schema=schema)


def _passes(word: str, frame: FrameModel) -> bool:
    match word:
        case ">":
            return frame.sent
        case "<":
            return not frame.sent
        case "!":
            return not frame.good
    if word.startswith("-") and len(word) > 1:
        return word[1:] not in frame.text.lower()
    return word in frame.text.lower()
