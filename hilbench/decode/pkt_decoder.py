"""The frames of PKT!."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from hilbench.decode.items import Item, Kind
from hilbench.decode.reading import DecodeOptions, Speaker, fields_of
from protocols import pkt

__all__ = ["PktDecoder", "pkt_format"]


def pkt_format(options: DecodeOptions) -> tuple[pkt.Framing, pkt.Schema]:
    """Return where a payload ends and what stands in it; the usual where the options do not say."""
    return options.framing or pkt.Framing.LEN, options.schema or pkt.Schema.V2


class PktDecoder:
    """PKT!, either end: commands and reports are told apart by their first byte."""

    def __init__(self, options: DecodeOptions, speaker: Speaker) -> None:
        del speaker
        framing, self._schema = pkt_format(options)
        frames = pkt.FramingOptions(
            framing=framing,
            resync=pkt.Resync.SCAN,
            timer=pkt.FrameTimer.OFF,
            tolerant_newline=framing is pkt.Framing.TERM,
        )
        self._reader = pkt.FrameReader(frames)

    def feed(self, data: bytes) -> Iterator[Item]:
        """See `Decoder`."""
        return map(self.read, self.find(data))

    def find(self, data: bytes) -> Sequence[pkt.Frame | pkt.Dropped]:
        """See `Decoder`."""
        return self._reader.receive(data, 0)

    def sort(self, found: pkt.Frame | pkt.Dropped) -> bytes | None:
        """See `Decoder`."""
        return None if isinstance(found, pkt.Dropped) else found.payload[:1]

    def finish(self) -> Iterator[Item]:
        """See `Decoder`."""
        return map(self.read, self._reader.reset())

    def read(self, found: pkt.Frame | pkt.Dropped) -> Item:
        """See `Decoder`."""
        if isinstance(found, pkt.Dropped):
            return Item(kind=Kind.DROPPED, name=found.reason.value, raw=found.data)
        is_report = found.payload[0] >= pkt.ReportId.GENERAL
        try:
            said = (pkt.decode_report if is_report else pkt.decode_command)(found.payload, self._schema)
        except pkt.RemoteProtocolError as error:
            return Item(kind=Kind.UNREADABLE, name=str(error), raw=found.raw)
        name = type(said).__name__ if is_report else self._command_name(found.payload[0])
        return Item(kind=Kind.FRAME, name=name, raw=found.raw, fields=fields_of(said))

    def _command_name(self, opcode: int) -> str:
        spec = pkt.COMMANDS[self._schema].get(opcode)
        return f"opcode {opcode:02X}" if spec is None else spec.name
