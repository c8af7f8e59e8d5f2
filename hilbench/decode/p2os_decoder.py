"""The frames of P2OS."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from hilbench.decode.items import Item, Kind
from hilbench.decode.reading import DecodeOptions, Speaker, fields_of
from protocols import p2os

__all__ = ["P2osDecoder"]


class P2osDecoder:
    """P2OS: what a robot sends, or what a client sends to it."""

    def __init__(self, options: DecodeOptions, speaker: Speaker) -> None:
        del options
        self._of_host = speaker == "host"
        self._reader = p2os.FrameReader()

    def feed(self, data: bytes) -> Iterator[Item]:
        """See `Decoder`."""
        return map(self.read, self.find(data))

    def find(self, data: bytes) -> Sequence[p2os.Frame | p2os.Dropped]:
        """See `Decoder`."""
        return self._reader.receive(data, 0)

    def sort(self, found: p2os.Frame | p2os.Dropped) -> bytes | None:
        """See `Decoder`."""
        return None if isinstance(found, p2os.Dropped) else found.body[:1]

    def finish(self) -> Iterator[Item]:
        """See `Decoder`."""
        return map(self.read, self._reader.reset())

    def read(self, found: p2os.Frame | p2os.Dropped) -> Item:
        """See `Decoder`."""
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
        return Item(kind=Kind.FRAME, name=type(packet).__name__, raw=found.raw, fields=fields_of(packet))
