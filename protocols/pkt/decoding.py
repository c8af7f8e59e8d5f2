"""The frames of PKT! for people who look at a line, from either end: the first byte tells commands from reports."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from protocols.common.checksum import Checksum
from protocols.common.decoding import Decoder, ReaderDecoder, Speaker, fields_of
from protocols.common.items import Item, Kind
from protocols.common.layout import Body, Region, laid_out
from protocols.pkt.codes import ReportId
from protocols.pkt.commands import COMMANDS, Command, decode_command, encode_command
from protocols.pkt.crc import CRC_BYTES, INITIAL, crc16_from
from protocols.pkt.errors import RemoteProtocolError
from protocols.pkt.framing import Dropped, Frame, FrameReader, encode_frame
from protocols.pkt.options import FrameTimer, Framing, FramingOptions, Resync, Schema
from protocols.pkt.reports import Report, decode_report, encode_report

__all__ = ["DecodeOptions", "checksum", "decoder", "encode", "regions"]


@dataclass(frozen=True, slots=True, kw_only=True)
class DecodeOptions:
    """How the frames are read.

    Attributes:
        framing: where a payload ends.
        schema: what stands in it.
    """

    framing: Framing = field(default=Framing.LEN, metadata={"help": "a length byte, or up to the newline"})
    schema: Schema = field(default=Schema.V2, metadata={"help": "what stands in a payload"})


def decoder(options: DecodeOptions, speaker: Speaker) -> Decoder:
    """Return a decoder; frames of both ends may be mixed."""
    del speaker
    framing = FramingOptions(
        framing=options.framing,
        resync=Resync.SCAN,
        timer=FrameTimer.OFF,
        tolerant_newline=options.framing is Framing.TERM,
    )
    return ReaderDecoder(
        FrameReader(framing),
        rejected=Dropped,
        senseless=RemoteProtocolError,
        body="payload",
        item=partial(_item, schema=options.schema),
    )


def encode(message: Command | Report, options: DecodeOptions) -> bytes:
    """Return the frame of a command or of a report.

    Raises:
        LocalProtocolError: the schema does not have it, or a value does not fit its place.
    """
    if isinstance(message, Report):
        payload = encode_report(message, options.schema)
    else:
        payload = encode_command(message, options.schema)
    return encode_frame(payload, FramingOptions(framing=options.framing))


def regions(raw: bytes, options: DecodeOptions, *, sent: bool) -> list[Region]:
    """Return what the bytes of a sound frame are."""
    del sent
    has_length = options.framing is Framing.LEN
    payload = raw[5 if has_length else 4 : -3]
    body = Body(payload, _reader_of(payload, options.schema), RemoteProtocolError)
    middle = body.sizes("id" if _is_report(payload) else "opcode")
    length = [("length", 1)] if has_length else []
    return laid_out(raw, [("sync word", 4), *length, *middle, ("CRC", 2), ("end", 1)])


def checksum(options: DecodeOptions) -> Checksum:
    """Return how a frame is checked: by a CRC over its payload alone."""
    first = 5 if options.framing is Framing.LEN else 4
    return Checksum(value=crc16_from, begin=INITIAL, first=first, stop=-3, at=-3, size=CRC_BYTES, order="big")


def _item(frame: Frame, schema: Schema) -> Item:
    message = _reader_of(frame.payload, schema)(frame.payload)
    name = type(message).__name__ if _is_report(frame.payload) else _command_name(frame.payload[0], schema)
    return Item(kind=Kind.FRAME, name=name, raw=frame.raw, fields=fields_of(message), message=message)


def _is_report(payload: bytes) -> bool:
    return bool(payload) and payload[0] >= ReportId.GENERAL


def _reader_of(payload: bytes, schema: Schema) -> Callable[[bytes], Any]:
    read = decode_report if _is_report(payload) else decode_command
    return lambda data: read(data, schema)


def _command_name(opcode: int, schema: Schema) -> str:
    spec = COMMANDS[schema].get(opcode)
    return f"opcode {opcode:02X}" if spec is None else spec.name
