"""What passed a line last, as lines of a report: ``>`` was sent from this end, ``<`` came from the other."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from hilbench.bench.timed_reader import TimedReader
from hilbench.clock import NS_PER_S
from protocols.common.decoding import Decoder
from protocols.common.item_words import said
from protocols.common.items import Item, Kind

__all__ = ["Passed", "Written", "in_order", "in_words", "silence", "words_of"]

Passed = tuple[int, str]
"""Bench time in ns, and what passed then, in words."""

_LONGEST_WORDS, _LONGEST_BYTES = 120, 64
_WRITES_KEPT = 4
_SILENCE_NS = NS_PER_S // 2
"""A line is called silent after this time (choice): five times the usual 100 ms between reports."""


def in_words(at_ns: int, words: str) -> str:
    """Return a line of a report."""
    return f"{at_ns / NS_PER_S:10.4f} s  {words}"


def silence(now_ns: int, reader: TimedReader[Any], *, frames: bool, last_ns: int | None = None) -> list[str]:
    """Return a line that says what did not come, if there is anything to be said.

    Args:
        now_ns: bench time.
        reader: counts what came.
        frames: frames, or bytes that are none, are shown.
        last_ns: when the last frame came, if there was one.
    """
    if not reader.bytes_received:
        return [in_words(now_ns, "nothing received")]
    texts = []
    if not frames:
        since = f"({reader.bytes_received} bytes in all)" if last_ns is None else f"since {last_ns / NS_PER_S:.4f} s"
        texts.append(f"no frame received {since}")
    silent_ns = now_ns - reader.last_byte_ns
    if silent_ns >= _SILENCE_NS:
        texts.append(f"nothing received for {silent_ns / NS_PER_S:.1f} s")
    return [in_words(now_ns, "; ".join(texts))] if texts else []


def in_order(*passed: Iterable[Passed]) -> Sequence[Passed]:
    """Return what passed in the order of time."""
    return sorted((one for some in passed for one in some), key=lambda one: one[0])


def words_of(raw: bytes, decoder: Decoder | None) -> str:
    """Return bytes with what they say, if they are frames.

    Args:
        raw: the bytes.
        decoder: reads them; None where nobody does.
    """
    return _said(raw, [] if decoder is None else [*decoder.feed(raw), *decoder.finish()])


def _said(raw: bytes, read: Sequence[Item]) -> str:
    more = f" ... ({len(raw)} bytes)" if len(raw) > _LONGEST_BYTES else ""
    data = f"{raw[:_LONGEST_BYTES].hex(' ').upper()}{more}"
    if not read or any(item.kind is not Kind.FRAME or item.raw == item.message for item in read):
        return data
    words = "  ".join(map(said, read))
    return f"{words if len(words) <= _LONGEST_WORDS else words[: _LONGEST_WORDS - 1] + '…'}  [{data}]"


@dataclass(slots=True, kw_only=True)
class _Run:
    """The same bytes, written once or several times with nothing else between them."""

    data: bytes
    found: Sequence[Any]
    began_ns: int
    at_ns: int
    times: int = 1

    @property
    def often(self) -> str:
        return f", {self.times} times since {self.began_ns / NS_PER_S:.4f} s" if self.times > 1 else ""


class Written:
    """Keeps what was written last.

    Args:
        make: makes who reads what is written, from its beginning on: what a frame is called may depend on those before.
    """

    def __init__(self, make: Callable[[], Decoder | None]) -> None:
        self._make = make
        self._runs: deque[_Run] = deque(maxlen=_WRITES_KEPT)
        self._decoder: Decoder | None = None

    def add(self, data: bytes, at_ns: int) -> None:
        """Take what is written at a bench time."""
        if self._decoder is None:
            self._decoder = self._make()
        found = () if self._decoder is None else self._decoder.find(data)
        if self._runs and self._runs[-1].data == data:
            run = self._runs[-1]
            run.found, run.at_ns, run.times = found, at_ns, run.times + 1
        else:
            self._runs.append(_Run(data=data, found=found, began_ns=at_ns, at_ns=at_ns))

    def clear(self) -> None:
        """Forget it: what comes now is the beginning of something."""
        self._runs.clear()
        self._decoder = None

    def passed(self) -> list[Passed]:
        """Return it in words; what was written again and again is one line, at its last time."""
        return [(run.at_ns, f">  {self._words_of(run)}{run.often}") for run in self._runs]

    def _words_of(self, run: _Run) -> str:
        read = [] if self._decoder is None else [self._decoder.read(found) for found in run.found]
        if b"".join(item.raw for item in read) == run.data:
            return _said(run.data, read)
        return words_of(run.data, self._make())  # a piece of a frame, or one that ends with what comes next
