"""Frames of DDS-XRCE for people who look at them, from either end: ids tell submessages apart."""

from __future__ import annotations

import dataclasses
from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from enum import Enum

from protocols import xrce
from protocols.common.decoding import Decoder, NoOptions, ReaderDecoder, Speaker, fields_of
from protocols.common.flagged import frame_regions
from protocols.common.items import Item, Kind
from protocols.common.layout import Body, Region, laid_out

__all__ = ["Message", "decoder", "encode", "regions"]

_EITHER = xrce.FramingOptions(framing=xrce.Framing.EITHER)
_LENGTH_BYTES = 2
_NOT_SHOWN = ("little_endian",)


@dataclass(frozen=True, slots=True, kw_only=True)
class Message:
    """A message: its header, and what is said in it, read or not."""

    header: xrce.Header
    submessages: tuple[xrce.Submessage | xrce.RawSubmessage, ...]


def encode(message: Message, options: NoOptions) -> bytes:
    """The serial frame of a message.

    Raises:
        LocalProtocolError: something does not fit its field.
    """
    del options
    body = xrce.pack_submessages(map(xrce.encode_submessage, message.submessages))
    return xrce.encode_frame(xrce.encode_message(message.header, body))


def decoder(options: NoOptions, speaker: Speaker) -> Decoder:
    """Return a decoder of serial frames, or of messages behind their lengths, whichever the stream begins with."""
    del options, speaker
    return ReaderDecoder(
        xrce.LineReader(_EITHER),
        rejected=xrce.Dropped,
        senseless=xrce.RemoteProtocolError,
        body="payload",
        item=_item,
        sort=_sort,
    )


def regions(raw: bytes, options: NoOptions, *, sent: bool) -> list[Region]:
    """Return the parts of a sound frame as it stands on the line, where an escaped byte takes two."""
    del options, sent
    if raw[:1] == b"\x7e":
        return frame_regions(raw, _EITHER, _message, xrce.RemoteProtocolError, "session")
    middle = Body(raw[_LENGTH_BYTES:], _message, xrce.RemoteProtocolError).sizes("session")
    return laid_out(raw, [("length", _LENGTH_BYTES), *middle])


def _item(frame: xrce.Frame) -> Item:
    header, said = _read(frame.payload)
    name = "+".join(type(one).__name__ for one in said) or "nothing"
    message = Message(header=header, submessages=tuple(said))
    return Item(kind=Kind.FRAME, name=name, raw=frame.raw, fields=_fields(header, said), message=message)


def _sort(frame: xrce.Frame) -> Hashable:
    """Which stream, and which submessages."""
    try:
        header, body = xrce.decode_header(frame.payload)
        return header.stream_id, *(raw.id for raw in xrce.split_submessages(body))
    except xrce.RemoteProtocolError:
        return ()


def _read(message: bytes) -> tuple[xrce.Header, Sequence[xrce.Submessage]]:
    header, body = xrce.decode_header(message)
    return header, [xrce.decode_submessage(raw) for raw in xrce.split_submessages(body)]


def _fields(header: xrce.Header, said: Sequence[xrce.Submessage]) -> dict[str, object]:
    """The header's fields, and those of the submessages; of several each with its place."""
    found: dict[str, object] = {"session": header.session_id, "stream": header.stream_id, "sequence": header.sequence}
    if header.client_key is not None:
        found["client_key"] = header.client_key
    for place, one in enumerate(said, 1):
        for name, value in fields_of(one).items():
            if name not in _NOT_SHOWN:
                found[name if len(said) == 1 else f"{name}_{place}"] = _words(value)
    return found


def _words(value: object) -> object:
    """Numbers, texts and bytes as they are; what is put together as its fields that say something."""
    if isinstance(value, Enum):
        return value.name
    if not dataclasses.is_dataclass(value) or isinstance(value, type):
        return value
    told = {name: _words(one) for name, one in fields_of(value).items() if one is not None}
    inner = ", ".join(f"{name}={one.hex() if isinstance(one, bytes) else one}" for name, one in told.items())
    return f"{type(value).__name__}({inner})"


def _message(payload: bytes) -> object:
    """A message as one dataclass, for who looks which bytes are which field."""
    found = _fields(*_read(payload))
    made = dataclasses.make_dataclass("Message", [*found])
    return made(**found)
