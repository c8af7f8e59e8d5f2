"""What a recording says of signals: a journal, or a capture by a logic analyser, in one form.

A signal is a pin, the words of a part, the bytes of a line or the summaries of a fast pin. It has a name and what
happened on it, in order of time.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

__all__ = ["END_NS", "Capture", "Track", "Value", "shown"]

END_NS = 2**62
"""Times of a capture are before it, as those of a journal are: some 146 years."""

Value = bool | int | str | None
"""A level (None: floats), a word, a byte as two hexadecimal digits, or a text."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Track:
    """What happened on one signal.

    Attributes:
        name: ``brain.PB7``; with what it is behind a space, if it is no pin: ``brain.usart1 tx``.
        times_ns: when something happened, in the recording's own time, not decreasing.
        values: what each led to.
        levels: whether these are the levels of a wire.
        initial: the level before the first edge, and
        initial_known: whether the recording says so.
        without_frames: whether the edges of serial frames are left out, because their bytes are recorded.
        summarised_from_ns: from here on the recording has only summaries; None if it has everything.
    """

    name: str
    times_ns: Sequence[int]
    values: Sequence[Value]
    levels: bool = True
    initial: bool | None = None
    initial_known: bool = False
    without_frames: bool = False
    summarised_from_ns: int | None = None

    def __len__(self) -> int:
        return len(self.times_ns)

    def until(self, last_ns: int) -> Track:
        """Return what happened up to and including a time."""
        count = sum(1 for ns in self.times_ns if ns <= last_ns)
        return replace(self, times_ns=self.times_ns[:count], values=self.values[:count])

    def begun(self) -> Track:
        """Return it with what happened at its very beginning as the level that it begins with."""
        if self.initial_known or not self.levels or not self.times_ns or self.times_ns[0] > 0:
            return self
        count = sum(1 for ns in self.times_ns if ns <= 0)
        level = self.values[count - 1]
        return replace(
            self,
            times_ns=self.times_ns[count:],
            values=self.values[count:],
            initial=level if isinstance(level, bool) else None,
            initial_known=level is not None,
        )

    def folded(self, other: Track) -> Track:
        """Return it as somebody saw it who cannot tell that a wire floats: that reads low.

        A level before the first edge that is not known is taken from the other recording: what floats there reads as
        whatever the analyser makes of it, and what is pulled up reads high.
        """
        if not self.levels:
            return self
        level = initial = (self if self.initial_known else other).initial is True
        times, values = [], []
        for ns, value in zip(self.times_ns, self.values, strict=True):
            if (value is True) is not level:
                level = value is True
                times.append(ns)
                values.append(level)
        return replace(self, times_ns=times, values=values, initial=initial)


@dataclass(frozen=True, slots=True, kw_only=True)
class Capture:
    """A recording.

    Attributes:
        label: what to call it: the name of the file, and the case.
        kind: what sort of recording, for people.
        tracks: the signals by name.
        end_ns: until when it goes, in its own time.
        boards: the boards of which it has every pin: one that is not among the tracks has done nothing.
        floats: whether it can tell that a wire floats.
        case: the case that it is of, in a journal that has several.
        complete: whether it says that its end is the end, as a journal does that was closed; a capture cannot.
        remarks: what a person must know of it.
    """

    label: str
    kind: str
    tracks: Mapping[str, Track]
    end_ns: int
    boards: frozenset[str] = frozenset()
    floats: bool = False
    case: str = ""
    complete: bool = False
    remarks: tuple[str, ...] = ()

    def track(self, name: str) -> Track | None:
        """Return a signal, an empty one if it is known to have done nothing, or None if nothing is known of it.

        A journal has the bytes of every line of its boards, but not the levels of the line (``brain.usart1.tx``).
        """
        known = self.tracks.get(name)
        board, _, rest = name.partition(".")
        quiet = board in self.boards and (" " in rest or "." not in rest)
        return Track(name=name, times_ns=(), values=(), levels=" " not in name) if known is None and quiet else known


def shown(value: Value) -> str:
    """Return a value as people read it."""
    if value is None:
        return "z"
    return str(int(value)) if isinstance(value, bool) else str(value)
