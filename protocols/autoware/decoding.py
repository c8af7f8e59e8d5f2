"""The frames of the driving stack's stand-in link for people who look at it, from either end: ids tell them apart."""

from __future__ import annotations

from protocols import autoware
from protocols.common.decoding import Decoder, NoOptions, ReaderDecoder, Speaker, fields_of
from protocols.common.flagged import frame_regions
from protocols.common.items import Item, Kind
from protocols.common.layout import Region

__all__ = ["decoder", "encode", "regions"]


def decoder(options: NoOptions, speaker: Speaker) -> Decoder:
    """Return a decoder; frames of both ends may be mixed."""
    del options, speaker
    return ReaderDecoder(
        autoware.FrameReader(),
        rejected=autoware.Dropped,
        senseless=autoware.RemoteProtocolError,
        body="payload",
        item=_item,
    )


def encode(message: autoware.Message | autoware.UnknownMessage, options: NoOptions) -> bytes:
    """Return the frame of a message.

    Raises:
        LocalProtocolError: a number does not fit its field.
    """
    del options
    return autoware.encode_frame(autoware.encode_message(message))


def regions(raw: bytes, options: NoOptions, *, sent: bool) -> list[Region]:
    """Return the parts of a sound frame as it stands on the line, where an escaped byte takes two."""
    del options, sent
    return frame_regions(raw, autoware.FramingOptions(), autoware.decode_message, autoware.RemoteProtocolError, "id")


def _item(frame: autoware.Frame) -> Item:
    message = autoware.decode_message(frame.payload)
    if isinstance(message, autoware.UnknownMessage):
        return Item(kind=Kind.FRAME, name=f"message {message.id:02X}", raw=frame.raw, fields={"body": message.body})
    fields = {name: _stamp(value) for name, value in fields_of(message).items()}
    return Item(kind=Kind.FRAME, name=type(message).__name__, raw=frame.raw, fields=fields, message=message)


def _stamp(value: object) -> object:
    """A time as seconds with all their digits; anything else as it is."""
    return f"{value.sec}.{value.nanosec:09}" if isinstance(value, autoware.Time) else value
