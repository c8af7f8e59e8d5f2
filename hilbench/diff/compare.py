"""Compares two captures, signal by signal.

Both are laid over each other at the first change that they have in common, and compared until the first of them ends.
If the other one has changes after that, they are different, unless that end is marked as one, or no more is asked for.

Within a signal, the n-th change of one belongs to the n-th of the other. They agree if every change leads to the same
value, and comes at the same time up to a tolerance; or, where times are not to matter, if no two changes come in
reversed order, of one signal or of two. Changes at the same time, up to the tolerance, are in no order.
"""

from __future__ import annotations

import difflib
import fnmatch
import statistics
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from hilbench.diff.capture import Capture, Track, Value, shown
from hilbench.errors import UsageError
from hilbench.nearest import did_you_mean

__all__ = ["Beyond", "Change", "Comparison", "Divergence", "Options", "SignalReport", "around", "compare", "span"]

_SHOWN_NAMES = 20
_NEAR = 0.55


@dataclass(frozen=True, slots=True, kw_only=True)
class Options:
    """How to compare.

    Attributes:
        pins: patterns of the names to compare, such as ``brain.PB*`` or ``PB*``; none for all.
        order_only: whether only the order matters.
        tolerance_ns: how far times may be apart.
        until_ns: how long to compare, from the first common change on; None until the first recording ends.
        common: whether a recording may end while the other one goes on.
    """

    pins: tuple[str, ...] = ()
    order_only: bool = False
    tolerance_ns: int = 0
    until_ns: int | None = None
    common: bool = False

    def wants(self, name: str) -> bool:
        """Say whether a signal is to be compared."""
        return not self.pins or any(_matches(pin, name) for pin in self.pins)


def _matches(pattern: str, name: str) -> bool:
    return any(fnmatch.fnmatchcase(one, pattern) for one in (name, _short(name)))


def _short(name: str) -> str:
    return name.partition(".")[2] or name


@dataclass(frozen=True, slots=True, kw_only=True)
class Change:
    """A change of a signal in both captures, or in one of them.

    Attributes:
        signal: which.
        a_ns: when in A, in its own time; None if it is not there.
        b_ns: the same in B.
        a: to which value in A.
        b: the same in B.
        late_ns: how much later in B than in A, once they are laid over each other; None if it is not in both.
        at_ns: when, from the first common change on: the earlier of both.
    """

    signal: str
    a_ns: int | None
    b_ns: int | None
    a: Value
    b: Value
    late_ns: int | None
    at_ns: int

    @property
    def same(self) -> bool:
        """Whether both have it, with the same value."""
        return self.late_ns is not None and self.a == self.b and type(self.a) is type(self.b)


@dataclass(frozen=True, slots=True, kw_only=True)
class Divergence:
    """Where the captures part.

    Attributes:
        kind: ``value``, ``missing in A``, ``missing in B``, ``time``, ``order``, ``level`` or ``end``.
        change: the change at which they do.
        text: what is different, for people.
    """

    kind: str
    change: Change
    text: str


@dataclass(frozen=True, slots=True, kw_only=True)
class SignalReport:
    """How a signal compares.

    Attributes:
        name: of the signal.
        changes: what happened, those of both and those of one.
        a: how many changes A has of it, and
        b: B.
        equal: how many agree before the first that does not.
        remark: what could not be compared, for people.
        divergence: the first that does not; None if all agree.
    """

    name: str
    changes: Sequence[Change]
    a: int
    b: int
    equal: int
    remark: str
    divergence: Divergence | None

    @property
    def late_ns(self) -> list[int]:
        """How late the changes of B are that have the same value as that of A."""
        return [change.late_ns for change in self.changes if change.same and change.late_ns is not None]

    @property
    def median_ns(self) -> float | None:
        """Median of it."""
        return statistics.median(self.late_ns) if self.late_ns else None

    @property
    def largest_ns(self) -> int | None:
        """The one that is farthest from 0."""
        return max(self.late_ns, key=abs, default=None)


@dataclass(frozen=True, slots=True, kw_only=True)
class Beyond:
    """What lies beyond the end of the comparison, in one of the captures.

    Attributes:
        goes_on_ns: how long it goes on.
        changes: the changes that would have been compared there, had the other one gone on, in order of time.
    """

    goes_on_ns: int
    changes: Sequence[Change]


@dataclass(frozen=True, kw_only=True)
class Comparison:
    """How two captures compare.

    Attributes:
        a: the first.
        b: the second.
        options: how they were compared.
        anchor: signal, value and times in A and B of the first common change; None if there is none.
        span_ns: how long was compared, from the first common change on.
        signals: the signals that both know, by name.
        left_out: signals that could not be compared, and why.
        a_beyond: what A has after that, and
        b_beyond: B.
    """

    a: Capture
    b: Capture
    options: Options
    anchor: Change | None
    span_ns: int
    signals: Sequence[SignalReport]
    left_out: Mapping[str, str]
    a_beyond: Beyond
    b_beyond: Beyond

    @cached_property
    def first(self) -> Divergence | None:
        """The first divergence of all; of what lies beyond the end only if there is no other."""
        return self._within or self._early()

    @property
    def empty(self) -> bool:
        """Whether there was nothing to compare: no change is in both, and none in one that the other should have."""
        return self._within is None and not any(signal.equal for signal in self.signals)

    @cached_property
    def _within(self) -> Divergence | None:
        found = [signal.divergence for signal in self.signals if signal.divergence is not None]
        if self.options.order_only and (reversed_ := self._reversed()) is not None:
            found.append(reversed_)
        return min(found, key=lambda one: (one.change.at_ns, one.change.signal), default=None)

    def _early(self) -> Divergence | None:
        """Say whether one ends before it is complete, as far as can be known, while the other goes on."""
        if self.options.common:
            return None
        hardly = 2 * self.span_ns < min(self.a.end_ns, self.b.end_ns)
        for side, capture, other, beyond in (("A", self.a, "B", self.b_beyond), ("B", self.b, "A", self.a_beyond)):
            if beyond.changes and (hardly or not capture.complete):
                first, more = beyond.changes[0], len(beyond.changes) - 1
                value = shown(first.a if other == "A" else first.b)
                rest = f" and {more} change{'' if more == 1 else 's'} more" if more else ""
                since = "the first change in common" if self.anchor is not None else "the beginning"
                text = f"{side} ends {span(self.span_ns)} after {since}, and {other} goes on: "
                text += f"{first.signal} -> {value}{rest} not compared"
                return Divergence(kind="end", change=first, text=text)
        return None

    def changes(self) -> list[Change]:
        """Return the changes of all signals, in order of time."""
        every = [change for signal in self.signals for change in signal.changes]
        return sorted(every, key=lambda change: (change.at_ns, change.signal))

    def _reversed(self) -> Divergence | None:
        """Return the first change that comes before another one in A and after it in B."""
        slack = self.options.tolerance_ns
        pairs = [change for change in self.changes() if change.same]
        pairs.sort(key=lambda change: (change.a_ns or 0, change.b_ns or 0))
        latest: Change | None = None
        before = 0
        for change in pairs:
            while _a(pairs[before]) < _a(change) - slack:
                if latest is None or _b(pairs[before]) > _b(latest):
                    latest = pairs[before]
                before += 1
            if latest is not None and _b(latest) > _b(change) + slack:
                earlier = f"{latest.signal} -> {shown(latest.a)}"
                text = f"{change.signal} -> {shown(change.a)} comes after {earlier} in A, before it in B"
                return Divergence(kind="order", change=change, text=text)
        return None


def _a(change: Change) -> int:
    return change.a_ns or 0


def _b(change: Change) -> int:
    return change.b_ns or 0


def compare(a: Capture, b: Capture, options: Options) -> Comparison:
    """Compare two captures.

    Raises:
        UsageError: they have no signal in common, or none that is wanted, or a pattern matches none.
    """
    _check_patterns(a, b, options)
    pairs, left_out = _pairs(a, b, options)
    if not pairs:
        raise _nothing(a, b, options, left_out)
    anchor = _anchor(pairs)
    a0, b0 = (_a(anchor), _b(anchor)) if anchor is not None else (0, 0)
    limits = [] if options.until_ns is None else [options.until_ns]
    span_ns = min(a.end_ns - a0, b.end_ns - b0, *limits)
    laid = _Laid(a0, b0, span_ns, options)
    return Comparison(
        a=a,
        b=b,
        options=options,
        anchor=anchor,
        span_ns=span_ns,
        signals=[laid.report(one, other) for one, other in pairs],
        left_out=left_out,
        a_beyond=Beyond(goes_on_ns=a.end_ns - a0 - span_ns, changes=laid.beyond(pairs, in_a=True)),
        b_beyond=Beyond(goes_on_ns=b.end_ns - b0 - span_ns, changes=laid.beyond(pairs, in_a=False)),
    )


def _check_patterns(a: Capture, b: Capture, options: Options) -> None:
    names = sorted({*a.tracks, *b.tracks})
    for pattern in options.pins:
        if not any(_matches(pattern, name) for name in names):
            near = difflib.get_close_matches(pattern, [*names, *map(_short, names)], n=1, cutoff=_NEAR)
            hint = did_you_mean(pattern, near or names[:_SHOWN_NAMES], "they have")
            raise UsageError("matches no signal", where=f"--pins {pattern}", hint=hint)


def _pairs(a: Capture, b: Capture, options: Options) -> tuple[list[tuple[Track, Track]], dict[str, str]]:
    """Return the signals of both, and why others are left out."""
    pairs, left_out = [], {}
    fold = not (a.floats and b.floats)
    for name in sorted({*a.tracks, *b.tracks}):
        one, other = a.track(name), b.track(name)
        if not options.wants(name):
            continue
        if one is None or other is None:
            if one or other:
                left_out[name] = "only in B" if one is None else "only in A"
        elif one.without_frames is not other.without_frames:
            side = "A" if one.without_frames else "B"
            left_out[name] = f"{side} has bytes in the place of its edges (hilbench run --edges records both)"
        else:
            if one.initial_known is not other.initial_known:
                one, other = one.begun(), other.begun()
            pairs.append((one.folded(other), other.folded(one)) if fold else (one, other))
    return pairs, left_out


def _nothing(a: Capture, b: Capture, options: Options, left_out: Mapping[str, str]) -> UsageError:
    if options.pins:
        hint = f"they have {', '.join(sorted({*a.tracks, *b.tracks})[:_SHOWN_NAMES])}"
        return UsageError("no signal that both recordings have", where=f"--pins {' '.join(options.pins)}", hint=hint)
    hint = f"A has {_some(a)}, B {_some(b)}: --map says which is which"
    both = [f"{name}: {why}" for name, why in left_out.items() if not why.startswith("only in")]
    return UsageError("nothing to compare in these recordings", where="diff", hint="; ".join(both) or hint)


def _some(capture: Capture) -> str:
    names = list(capture.tracks)
    return ", ".join(names[:4]) + (", ..." if len(names) > 4 else "") if names else "none"


def _anchor(pairs: Iterable[tuple[Track, Track]]) -> Change | None:
    """Return the first change of a signal that is its first in both captures, and to the same value.

    The first is the one that is earliest in both together, so that A and B can change places.
    """
    found = [
        _change(one, other, 0, 0, 0)
        for one, other in pairs
        if one.times_ns and other.times_ns and one.values[0] == other.values[0]
    ]
    return min(found, key=lambda change: (_a(change) + _b(change), change.signal), default=None)


def _change(one: Track, other: Track, at: int, a0: int, b0: int) -> Change:
    """Return the change number `at` of a signal."""
    a_ns = one.times_ns[at] if at < len(one) else None
    b_ns = other.times_ns[at] if at < len(other) else None
    times = [ns - zero for ns, zero in ((a_ns, a0), (b_ns, b0)) if ns is not None]
    return Change(
        signal=one.name,
        a_ns=a_ns,
        b_ns=b_ns,
        a=one.values[at] if a_ns is not None else None,
        b=other.values[at] if b_ns is not None else None,
        late_ns=times[1] - times[0] if len(times) == 2 else None,
        at_ns=min(times),
    )


def _alone(signal: str, ns: int, value: Value, at_ns: int, *, in_a: bool) -> Change:
    """Return a change of one of both."""
    a_ns, b_ns = (ns, None) if in_a else (None, ns)
    a, b = (value, None) if in_a else (None, value)
    return Change(signal=signal, a_ns=a_ns, b_ns=b_ns, a=a, b=b, late_ns=None, at_ns=at_ns)


class _Laid:
    """Two captures, laid over each other: what is at a0 in one is at b0 in the other."""

    def __init__(self, a0: int, b0: int, span_ns: int, options: Options) -> None:
        self._a0 = a0
        self._b0 = b0
        self._span_ns = span_ns
        self._options = options

    def report(self, one: Track, other: Track) -> SignalReport:
        """Compare a signal."""
        until_ns = self._until(one, other)
        a, b = one.until(self._a0 + until_ns), other.until(self._b0 + until_ns)
        changes = [_change(a, b, at, self._a0, self._b0) for at in range(max(len(a), len(b)))]
        wrong = self._level(a, b)
        equal = 0
        for change in changes if wrong is None else ():
            wrong = self._wrong(change, until_ns)
            if wrong is not None:
                break
            equal += change.same
        return SignalReport(
            name=one.name,
            changes=changes,
            a=len(a),
            b=len(b),
            equal=equal,
            remark=self._remark(one, other),
            divergence=wrong,
        )

    def beyond(self, pairs: Iterable[tuple[Track, Track]], *, in_a: bool) -> list[Change]:
        """Return what A or B has of these signals after the end; of one that is summarised, nothing can be said."""
        after_ns = self._span_ns + self._options.tolerance_ns
        zero, last_ns = self._a0 if in_a else self._b0, self._options.until_ns
        found = []
        for pair in pairs:
            track = pair[0] if in_a else pair[1]
            for ns, value in (
                zip(track.times_ns, track.values, strict=True) if self._until(*pair) == self._span_ns else ()
            ):
                if after_ns < ns - zero and (last_ns is None or ns - zero <= last_ns):
                    found.append(_alone(track.name, ns, value, ns - zero, in_a=in_a))
        return sorted(found, key=lambda change: (change.at_ns, change.signal))

    def _until(self, one: Track, other: Track) -> int:
        pairs = ((one.summarised_from_ns, self._a0), (other.summarised_from_ns, self._b0))
        limits = [limit - zero - 1 for limit, zero in pairs if limit is not None]
        return min([self._span_ns, *limits])

    def _remark(self, one: Track, other: Track) -> str:
        which = [side for side, track in (("A", one), ("B", other)) if track.summarised_from_ns is not None]
        if not which:
            return ""
        seconds = max(0, self._until(one, other)) / 1e9
        return f"too fast: {' and '.join(which)} summarise its edges; compared for {seconds:.3f} s"

    def _level(self, a: Track, b: Track) -> Divergence | None:
        if not (a.initial_known and b.initial_known) or a.initial is b.initial:
            return None
        zero = min(-self._a0, -self._b0)
        change = Change(signal=a.name, a_ns=None, b_ns=None, a=a.initial, b=b.initial, late_ns=None, at_ns=zero)
        text = f"{a.name} begins with {shown(a.initial)} in A, with {shown(b.initial)} in B"
        return Divergence(kind="level", change=change, text=text)

    def _wrong(self, change: Change, until_ns: int) -> Divergence | None:
        """Say what is wrong with a change."""
        tolerance_ns = self._options.tolerance_ns
        if change.late_ns is None:
            if change.at_ns + tolerance_ns > until_ns:
                return None  # the other one may come when nobody looks any more
            side, value = ("B", change.a) if change.b_ns is None else ("A", change.b)
            text = f"{change.signal} -> {shown(value)} is missing in {side}"
            return Divergence(kind=f"missing in {side}", change=change, text=text)
        if not change.same:
            text = f"{change.signal} -> {shown(change.a)} in A, -> {shown(change.b)} in B"
            return Divergence(kind="value", change=change, text=text)
        if not self._options.order_only and abs(change.late_ns) > tolerance_ns:
            late = f"{span(abs(change.late_ns))} {'later' if change.late_ns > 0 else 'earlier'} in B than in A"
            return Divergence(kind="time", change=change, text=f"{change.signal} -> {shown(change.a)} comes {late}")
        return None


def span(ns: float) -> str:
    """Return a span of time with the unit that suits it."""
    for unit, factor in (("s", 1e9), ("ms", 1e6), ("us", 1e3)):
        if abs(ns) >= factor:
            return f"{ns / factor:.6g} {unit}"
    return f"{ns:.6g} ns"


def around(comparison: Comparison, before: int, after: int) -> Iterator[Change]:
    """Return the changes around the first divergence."""
    first = comparison.first
    if first is None:
        return
    changes = comparison.changes()
    if first.kind == "level":
        changes.insert(0, first.change)
    elif first.kind == "end":
        changes.append(first.change)
    at = next(at for at, change in enumerate(changes) if change is first.change)
    yield from changes[max(0, at - before) : at + after + 1]
