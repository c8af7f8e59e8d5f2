"""The frames of each protocol: bytes in, items out, in order and without a gap."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, fields
from typing import Any, Protocol

from hilbench.decode.carla_decoder import CarlaDecoder
from hilbench.decode.items import Item, Kind
from protocols import autoware, p2os, pkt

__all__ = ["DECODERS", "DecodeOptions", "Decoder", "Speaker"]

Speaker = str
"""Who sends a stream: ``host``, ``target``, or nothing if that is not known."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DecodeOptions:
    """How bytes are read.

    Attributes:
        framing: PKT!: where a payload ends.
        schema: PKT!: what stands in it.
    """

    framing: pkt.Framing = pkt.Framing.LEN
    schema: pkt.Schema = pkt.Schema.V2


class Decoder(Protocol):
    """Reads one stream."""

    def feed(self, data: bytes) -> Iterable[Item]:
        """Take bytes; return what they complete."""

    def finish(self) -> Iterable[Item]:
        """Return what is left when nothing more comes."""


class PktDecoder:
    """PKT!, either end: commands and reports are told apart by their first byte."""

    def __init__(self, options: DecodeOptions, speaker: Speaker) -> None:
        del speaker
        frames = pkt.FramingOptions(
            framing=options.framing,
            resync=pkt.Resync.SCAN,
            timer=pkt.FrameTimer.OFF,
            tolerant_newline=options.framing is pkt.Framing.TERM,
        )
        self._schema = options.schema
        self._reader = pkt.FrameReader(frames)

    def feed(self, data: bytes) -> Iterator[Item]:
        """See `Decoder`."""
        return map(self._item, self._reader.receive(data, 0))

    def finish(self) -> Iterator[Item]:
        """See `Decoder`."""
        return map(self._item, self._reader.reset())

    def _item(self, found: pkt.Frame | pkt.Dropped) -> Item:
        if isinstance(found, pkt.Dropped):
            return Item(kind=Kind.DROPPED, name=found.reason.value, raw=found.data)
        is_report = found.payload[0] >= pkt.ReportId.GENERAL
        try:
            said = (pkt.decode_report if is_report else pkt.decode_command)(found.payload, self._schema)
        except pkt.RemoteProtocolError as error:
            return Item(kind=Kind.UNREADABLE, name=str(error), raw=found.raw)
        name = type(said).__name__ if is_report else self._command_name(found.payload[0])
        return Item(kind=Kind.FRAME, name=name, raw=found.raw, fields=_fields(said))

    def _command_name(self, opcode: int) -> str:
        spec = pkt.COMMANDS[self._schema].get(opcode)
        return f"opcode {opcode:02X}" if spec is None else spec.name


class P2osDecoder:
    """P2OS: what a robot sends, or what a client sends to it."""

    def __init__(self, options: DecodeOptions, speaker: Speaker) -> None:
        del options
        self._of_host = speaker == "host"
        self._reader = p2os.FrameReader()

    def feed(self, data: bytes) -> Iterator[Item]:
        """See `Decoder`."""
        return map(self._item, self._reader.receive(data, 0))

    def finish(self) -> Iterator[Item]:
        """See `Decoder`."""
        return map(self._item, self._reader.reset())

    def _item(self, found: p2os.Frame | p2os.Dropped) -> Item:
        if isinstance(found, p2os.Dropped):
            return Item(kind=Kind.DROPPED, name=found.reason.value, raw=found.data)
        try:
            return self._command(found) if self._of_host else self._packet(found)
        except p2os.RemoteProtocolError as error:
            return Item(kind=Kind.UNREADABLE, name=str(error), raw=found.raw)

    def _command(self, found: p2os.Frame) -> Item:
        command = p2os.decode_command(found.body)
        fields = {} if command.argument is None else {"argument": command.argument}
        return Item(kind=Kind.FRAME, name=p2os.command_name(command.number), raw=found.raw, fields=fields)

    def _packet(self, found: p2os.Frame) -> Item:
        packet = p2os.decode_packet(found.body, connected=False)
        return Item(kind=Kind.FRAME, name=type(packet).__name__, raw=found.raw, fields=_fields(packet))


class AutowareDecoder:
    """The stand-in link of the driving stack, either end: ids tell them apart."""

    def __init__(self, options: DecodeOptions, speaker: Speaker) -> None:
        del options, speaker
        self._reader = autoware.FrameReader()

    def feed(self, data: bytes) -> Iterator[Item]:
        """See `Decoder`."""
        return map(self._item, self._reader.receive(data))

    def finish(self) -> Iterator[Item]:
        """See `Decoder`."""
        return map(self._item, self._reader.reset())

    def _item(self, found: autoware.Frame | autoware.Dropped) -> Item:
        if isinstance(found, autoware.Dropped):
            return Item(kind=Kind.DROPPED, name=found.reason.value, raw=found.data)
        try:
            said = autoware.decode_message(found.payload)
        except autoware.RemoteProtocolError as error:
            return Item(kind=Kind.UNREADABLE, name=str(error), raw=found.raw)
        if isinstance(said, autoware.UnknownMessage):
            return Item(kind=Kind.FRAME, name=f"message {said.id:02X}", raw=found.raw, fields={"body": said.body})
        fields = {name: _stamp(value) for name, value in _fields(said).items()}
        return Item(kind=Kind.FRAME, name=type(said).__name__, raw=found.raw, fields=fields)


DECODERS: Mapping[str, Callable[[DecodeOptions, Speaker], Decoder]] = {
    "pkt": PktDecoder,
    "p2os": P2osDecoder,
    "autoware": AutowareDecoder,
    "carla": CarlaDecoder,
}
"""By the name of the protocol."""


def _fields(message: Any) -> dict[str, object]:
    return {field.name: getattr(message, field.name) for field in fields(message)}


def _stamp(value: object) -> object:
    """A time as seconds with all their digits; anything else as it is."""
    return f"{value.sec}.{value.nanosec:09}" if isinstance(value, autoware.Time) else value
