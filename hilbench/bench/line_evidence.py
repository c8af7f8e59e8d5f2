"""What passed a line last, as lines of a report: ``>`` was sent from this end, ``<`` came from the other."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from hilbench.bench.timed_reader import TimedReader
from hilbench.clock import NS_PER_S
from protocols.common.decoding import Decoder
from protocols.common.item_words import said
from protocols.common.items import Kind

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


def silence(now_ns: int, reader: TimedReader[Any], *, frames: bool) -> list[str]:
    """Return a line that says what did not come, if there is anything to be said.

    Args:
        now_ns: bench time.
        reader: counts what came.
        frames: frames, or bytes that are none, are shown.
    """
    if not reader.bytes_received:
        return [in_words(now_ns, "nothing received")]
    texts = [] if frames else [f"no frame received ({reader.bytes_received} bytes in all)"]
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
    more = f" ... ({len(raw)} bytes)" if len(raw) > _LONGEST_BYTES else ""
    data = f"{raw[:_LONGEST_BYTES].hex(' ').upper()}{more}"
    read = [] if decoder is None else [*decoder.feed(raw), *decoder.finish()]
    if not read or any(item.kind is not Kind.FRAME or item.raw == item.message for item in read):
        return data
    words = "  ".join(map(said, read))
    return f"{words if len(words) <= _LONGEST_WORDS else words[: _LONGEST_WORDS - 1] + '…'}  [{data}]"


@dataclass(slots=True, kw_only=True)
class _Run:
    """The same bytes, written once or several times with nothing else between them."""

    data: bytes
    began_ns: int
    at_ns: int
    times: int = 1

    @property
    def often(self) -> str:
        return f", {self.times} times since {self.began_ns / NS_PER_S:.4f} s" if self.times > 1 else ""


class Written:
    """Keeps what was written last."""

    def __init__(self) -> None:
        self._runs: deque[_Run] = deque(maxlen=_WRITES_KEPT)

    def add(self, data: bytes, at_ns: int) -> None:
        """Take what is written at a bench time."""
        if self._runs and self._runs[-1].data == data:
            self._runs[-1].times += 1
            self._runs[-1].at_ns = at_ns
        else:
            self._runs.append(_Run(data=data, began_ns=at_ns, at_ns=at_ns))

    def clear(self) -> None:
        """Forget it."""
        self._runs.clear()

    def passed(self, decoder: Decoder | None) -> list[Passed]:
        """Return it in words; what was written again and again is one line, at its last time."""
        return [(run.at_ns, f">  {words_of(run.data, decoder)}{run.often}") for run in self._runs]
