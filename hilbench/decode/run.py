"""Streams into lines: a decoder for each stream, offsets, and what it all comes to."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from hilbench.errors import PluginError, UsageError
from hilbench.plugins.protocol import ProtocolPlugin
from hilbench.recordings.chunks import Chunk
from hilbench.recordings.lines import json_line, text_line
from protocols.common.decoding import Decoder, Speaker
from protocols.common.items import Item, Kind

__all__ = ["Totals", "decode"]

_LINES_AT_ONCE = 512


@dataclass(slots=True)
class Totals:
    """What the bytes came to.

    Attributes:
        frames: frames that say something.
        unreadable: sound frames that do not.
        dropped: bytes that belong to no sound frame.
        resyncs: how often a frame was found behind such bytes.
    """

    frames: int = 0
    unreadable: int = 0
    dropped: int = 0
    resyncs: int = 0

    @property
    def clean(self) -> bool:
        """Every byte belongs to a frame that says something."""
        return not (self.unreadable or self.dropped)

    def __str__(self) -> str:
        text = _counted(self.frames, "frame")
        if self.unreadable:
            text += f", {_counted(self.unreadable, 'sound frame')} without sense"
        if self.dropped:
            text += f", {_counted(self.dropped, 'byte')} in no frame, {_counted(self.resyncs, 'resynchronisation')}"
        return text


def _counted(number: int, what: str) -> str:
    return f"{number} {what}" + ("" if number == 1 else "s")


class _Stream:
    """One stream, with its place in it."""

    def __init__(self, decoder: Decoder) -> None:
        self.decoder = decoder
        self.offset = 0
        self.fed = 0
        self._lost = False

    def place(self, item: Item, totals: Totals) -> int:
        """Return the offset of an item, and count it."""
        offset = self.offset
        self.offset += len(item.raw)
        if item.kind is Kind.DROPPED:
            totals.dropped += len(item.raw)
            self._lost = True
            return offset
        totals.resyncs += self._lost
        self._lost = False
        totals.frames += item.kind is Kind.FRAME
        totals.unreadable += item.kind is Kind.UNREADABLE
        return offset


def decode(
    chunks: Iterable[Chunk],
    protocol: ProtocolPlugin,
    options: object,
    *,
    streams: frozenset[str],
    speaker: Speaker,
    as_json: bool,
    totals: Totals,
) -> Iterator[str]:
    """Yield lines, several at a time, as the bytes come.

    Args:
        chunks: the bytes.
        protocol: what is spoken.
        options: how its frames are read, its own record.
        streams: the streams to look at; empty for all.
        speaker: who sends, where the source does not say; empty for the target.
        as_json: as JSON instead of for people.
        totals: where it is counted.

    Raises:
        UnavailableError: the source cannot be read; what was read before has been yielded.
        UsageError: one of `streams` is not there; the others have been yielded.
        PluginError: the decoder has lost bytes, or made some up.
    """
    make_line = json_line if as_json else text_line
    known: dict[str, _Stream] = {}
    there: dict[str, None] = {}
    for chunk in chunks:
        there[chunk.stream] = None
        if streams and chunk.stream not in streams:
            continue
        if chunk.stream not in known:
            known[chunk.stream] = _Stream(protocol.decoder(options, speaker or chunk.speaker or "target"))
        stream = known[chunk.stream]
        stream.fed += len(chunk.data)
        lines = [
            make_line(item, stream.place(item, totals), chunk.stream, chunk.ns)
            for item in stream.decoder.feed(chunk.data)
        ]
        yield from _together(lines)
    for name, stream in known.items():
        yield from _together(
            [make_line(item, stream.place(item, totals), name, None) for item in stream.decoder.finish()]
        )
        if stream.offset != stream.fed:
            message = f"its decoder makes {stream.offset} bytes of {stream.fed}: each byte belongs into one item"
            raise PluginError(message, where=f"protocol '{protocol.name}'")
    _check_names(streams, [name for name in there if name])


def _check_names(asked: frozenset[str], there: Sequence[str]) -> None:
    for name in sorted(asked.difference(there)):
        known = f"there are: {', '.join(there)}" if there else "only a journal with bytes in it has streams"
        raise UsageError(f"no stream '{name}'", where="--stream", hint=known)


def _together(lines: list[str]) -> Iterator[str]:
    for at in range(0, len(lines), _LINES_AT_ONCE):
        yield "\n".join(lines[at : at + _LINES_AT_ONCE])
