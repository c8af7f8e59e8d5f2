"""The frames of the driving stack's stand-in link."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from hilbench.decode.items import Item, Kind
from hilbench.decode.reading import DecodeOptions, Speaker, fields_of
from protocols import autoware

__all__ = ["AutowareDecoder"]


class AutowareDecoder:
    """The stand-in link of the driving stack, either end: ids tell them apart."""

    def __init__(self, options: DecodeOptions, speaker: Speaker) -> None:
        del options, speaker
        self._reader = autoware.FrameReader()

    def feed(self, data: bytes) -> Iterator[Item]:
        """See `Decoder`."""
        return map(self.read, self.find(data))

    def find(self, data: bytes) -> Sequence[autoware.Frame | autoware.Dropped]:
        """See `Decoder`."""
        return self._reader.receive(data)

    def sort(self, found: autoware.Frame | autoware.Dropped) -> bytes | None:
        """See `Decoder`."""
        return None if isinstance(found, autoware.Dropped) else found.payload[:1]

    def finish(self) -> Iterator[Item]:
        """See `Decoder`."""
        return map(self.read, self._reader.reset())

    def read(self, found: autoware.Frame | autoware.Dropped) -> Item:
        """See `Decoder`."""
        if isinstance(found, autoware.Dropped):
            return Item(kind=Kind.DROPPED, name=found.reason.value, raw=found.data)
        try:
            said = autoware.decode_message(found.payload)
        except autoware.RemoteProtocolError as error:
            return Item(kind=Kind.UNREADABLE, name=str(error), raw=found.raw)
        if isinstance(said, autoware.UnknownMessage):
            return Item(kind=Kind.FRAME, name=f"message {said.id:02X}", raw=found.raw, fields={"body": said.body})
        fields = {name: _stamp(value) for name, value in fields_of(said).items()}
        return Item(kind=Kind.FRAME, name=type(said).__name__, raw=found.raw, fields=fields)


def _stamp(value: object) -> object:
    """A time as seconds with all their digits; anything else as it is."""
    return f"{value.sec}.{value.nanosec:09}" if isinstance(value, autoware.Time) else value
