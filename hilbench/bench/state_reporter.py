"""Reports to the journal what nothing else does: where state machines, their timers and counters, and lines are.

It looks and never touches. After each event of the journal it looks at the timers, so that it knows when each of them
was set anew, and with how much time left; ten times a second it writes what has changed. What a run hash is made of has
none of it: only a live bench has a reporter.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from enum import Enum
from types import MappingProxyType
from typing import Any, Protocol, runtime_checkable

from hilbench.bench import Bench
from hilbench.bench.recorded_pins import RecordedPins
from hilbench.bench.reported_tables import ReportedTables
from hilbench.clock import NS_PER_MS, NS_PER_S, EventClass
from hilbench.links import Port

__all__ = [
    "REPORT_EVERY_NS",
    "CountsMisses",
    "Observed",
    "Sense",
    "Senses",
    "StateReporter",
    "Watched",
    "describe_line",
    "describe_machine",
    "left_ns",
]

REPORT_EVERY_NS = 100 * NS_PER_MS
_PACE_NS = 2 * NS_PER_S
"""The bench time over which the present pace is counted (choice)."""
_WHOLE_EVERY = 50
"""How often, in turns, everything is written and not what has changed alone: a journal that is rotated stays readable
(choice: 5 s)."""


class Observed(Protocol):
    """One end of a protocol, as far as it is looked at."""

    @property
    def state(self) -> Any:
        """Where it is."""

    @property
    def visits(self) -> Mapping[tuple[Any, Any], int]:
        """How often each edge of its table was taken."""

    @property
    def deadlines(self) -> Mapping[Any, int]:
        """When each timer that runs will run out, in ns of bench time."""

    @property
    def counters(self) -> Any:
        """What it has counted: a dataclass of whole numbers."""

    @property
    def table(self) -> Mapping[tuple[Any, Any], Any]:
        """Its edges by state and trigger."""


@runtime_checkable
class CountsMisses(Protocol):
    """An end that does something only after so many deadlines in a row."""

    @property
    def misses(self) -> Mapping[Any, tuple[int, int]]:
        """How many deadlines of each kind were missed in a row, and how many may be."""


class Sense(Enum):
    """What it means that a timer ends before it has run out."""

    WATCHDOG = "nothing; restarting it is how it is fed"
    WAIT = "what was waited for has come"
    REST = "nothing, and running out means nothing either"


Senses = Mapping[str, Mapping[str, Sense]]
"""The sense of timers, by machine and timer; those that are not named are watchdogs."""

_NO_SENSES: Mapping[str, Sense] = MappingProxyType({})


def left_ns(deadline_ns: int | None, next_ns: int | None, now_ns: int, sense: Sense) -> int | None:
    """Return how much time was left of a timer when it was set anew, or when what it waited for came.

    Args:
        deadline_ns: when it would have run out; None if it did not run.
        next_ns: when it will run out now; None if it runs no longer.
        now_ns: bench time.
        sense: what its end means.

    Returns:
        The time in ns, 0 if it ran out; None if it had no margin, as one that was ended.
    """
    if deadline_ns is None or sense is Sense.REST:
        return None
    left = max(0, deadline_ns - now_ns)
    return left if next_ns is not None or not left or sense is Sense.WAIT else None


@dataclass(slots=True)
class _Timer:
    """A timer, as seen so far.

    Attributes:
        deadline_ns: when it runs out; None while it does not run.
        span_ns: how long it was set for.
        margin_ns: how much was left when it was set anew the last time, or what it waited for came; None before.
        worst_ns: the least that was ever left; 0 once it has run out.
        rest: whether nothing is wrong when it runs out.
    """

    deadline_ns: int | None = None
    span_ns: int = 0
    margin_ns: int | None = None
    worst_ns: int | None = None
    rest: bool = False

    def look(self, deadline_ns: int | None, now_ns: int, sense: Sense) -> bool:
        """Take its deadline; say whether it is another one."""
        if deadline_ns == self.deadline_ns:
            return False
        left = left_ns(self.deadline_ns, deadline_ns, now_ns, sense)
        if left is not None:
            self.margin_ns = left
            self.worst_ns = left if self.worst_ns is None else min(self.worst_ns, left)
        self.deadline_ns = deadline_ns
        if deadline_ns is not None:
            self.span_ns = deadline_ns - now_ns
        return True


@dataclass(slots=True)
class Watched:
    """A state machine, as reported so far.

    Attributes:
        observed: the machine.
        senses: what the ends of its timers mean.
        The others are what was reported last.
    """

    observed: Observed
    senses: Mapping[str, Sense] = field(default_factory=dict)
    visits: dict[tuple[Any, Any], int] = field(default_factory=dict)
    counters: dict[str, int] = field(default_factory=dict)
    timers: dict[str, _Timer] = field(default_factory=dict)
    timers_moved: bool = False
    misses: dict[str, list[int]] = field(default_factory=dict)
    reported_misses: dict[str, list[int]] = field(default_factory=dict)
    state: str = ""
    at: object = None
    since_ns: int = 0
    counts: CountsMisses | None = field(init=False)

    def __post_init__(self) -> None:
        self.counts = self.observed if isinstance(self.observed, CountsMisses) else None

    def look(self, now_ns: int) -> None:
        """Look at state and timers; whoever looks often enough knows when it came there, and when each was set anew."""
        at = self.observed.state
        if at is not self.at:
            self.at, self.since_ns = at, now_ns
        deadlines = {timer.name: deadline_ns for timer, deadline_ns in self.observed.deadlines.items()}
        for name in self.timers.keys() | deadlines.keys():
            sense = self.senses.get(name, Sense.WATCHDOG)
            timer = self.timers.setdefault(name, _Timer(rest=sense is Sense.REST))
            self.timers_moved = timer.look(deadlines.get(name), now_ns, sense) or self.timers_moved
        if self.counts is not None:
            for kind, (count, most) in self.counts.misses.items():
                worst = self.misses.get(kind.name, [0, most, 0])[2]
                self.misses[kind.name] = [count, most, max(worst, count)]

    def news(self, *, whole: bool) -> dict[str, object]:
        """Return what has changed since the last call, or everything there is."""
        if whole:
            self.visits, self.counters, self.state, self.timers_moved = {}, {}, "", bool(self.timers)
            self.reported_misses = {}
        news: dict[str, object] = {}
        if self.observed.state.name != self.state:
            news |= {"state": self.observed.state.name, "since_ns": self.since_ns}
            self.state = self.observed.state.name
        visits = self._visits()
        if visits:
            self.visits |= visits
            news["visits"] = [[state.name, trigger.name, count] for (state, trigger), count in visits.items()]
        counters = {name: n for name, n in asdict(self.observed.counters).items() if n != self.counters.get(name)}
        if counters:
            self.counters |= counters
            news["counters"] = counters
        if self.timers_moved:
            news["timers"] = {name: asdict(timer) for name, timer in sorted(self.timers.items())}
            self.timers_moved = False
        if self.misses != self.reported_misses:
            self.reported_misses = {name: list(about) for name, about in self.misses.items()}
            news["misses"] = self.reported_misses
        return news

    def _visits(self) -> dict[tuple[Any, Any], int]:
        """Return what has changed; a machine that was reset has taken none of its edges."""
        now = self.observed.visits
        known = dict.fromkeys((*self.visits, *now))
        return {edge: now.get(edge, 0) for edge in known if now.get(edge, 0) != self.visits.get(edge)}


class StateReporter:
    """See the module. It is the listener of the bench's journal, and flushes it whenever it has reported something.

    Args:
        bench: whose journal is written.
        machines: what is looked at, by the name that the journal knows it by.
        lines: the operator's ends of the lines, as above.
        senses: what the ends of timers mean.
        views: what else is looked at, by the kind of its event; nothing is reported where nothing changed.

    Attributes:
        after: called after each turn.
        standing: what was reported once and still stands; repeated for those who come late, or had to pass over
            some of the journal.
    """

    def __init__(
        self,
        bench: Bench,
        machines: Mapping[str, Observed],
        lines: Mapping[str, Port],
        *,
        senses: Senses = MappingProxyType({}),
        views: Mapping[str, Callable[[], Mapping[str, object]]] = MappingProxyType({}),
    ) -> None:
        self._bench = bench
        self._machines = {name: Watched(observed, senses.get(name, _NO_SENSES)) for name, observed in machines.items()}
        self._lines = lines
        self._views = views
        self._reported_views: dict[str, Mapping[str, object]] = {}
        self._reported_lines: dict[str, dict[str, Any]] = {}
        self._turn = 0
        self.after: list[Callable[[], None]] = []
        self.standing: Callable[[], Mapping[str, object]] | None = None
        self._tables = ReportedTables(bench)
        self._pins = RecordedPins()
        for event in bench.journal.recent:
            self._pins.take(event)
        bench.journal.on_event = self._look
        self._report()

    def _look(self, event: Mapping[str, Any]) -> None:
        self._pins.take(event)
        now_ns = self._bench.now_ns
        for machine in self._machines.values():
            machine.look(now_ns)

    def _report(self) -> None:
        whole = self._turn % _WHOLE_EVERY == 0
        self._turn += 1
        for name, machine in self._machines.items():
            machine.look(self._bench.now_ns)
            if news := machine.news(whole=whole):
                self._bench.record("machine", name, **news)
        for name, port in self._lines.items():
            self._report_line(name, port, whole=whole)
        for kind, look in self._views.items():
            seen = look()
            if whole or seen != self._reported_views.get(kind):
                self._reported_views[kind] = seen
                self._bench.record(kind, "bench", **seen)
        self._tables.report(whole=whole)
        if whole and self.standing is not None:
            self._bench.record("standing", "bench", **self.standing(), pins=self._pins.standing())
        self._report_pace()
        for act in self.after:
            act()
        self._bench.journal.flush_step()
        self._bench.scheduler.after(REPORT_EVERY_NS, self._report, order=EventClass.CHECK, source="~reporter")

    def _recent_factor(self) -> float:
        """Return bench time in host time of late: what is lost is what bench time stood still."""
        scheduler = self._bench.scheduler
        span_ns = min(_PACE_NS, scheduler.now_ns)
        return span_ns / (span_ns + scheduler.slipped_since_ns(scheduler.now_ns - span_ns)) if span_ns else 1.0

    def _report_line(self, name: str, port: Port, *, whole: bool) -> None:
        about = describe_line(port)
        if whole or about != self._reported_lines.get(name):
            self._reported_lines[name] = about
            self._bench.record("link", name, **about)

    def _report_pace(self) -> None:
        scheduler = self._bench.scheduler
        factor = scheduler.real_time_factor
        if factor is None:
            return
        late = scheduler.lateness
        self._bench.record(
            "host-pace",
            "bench",
            factor=round(factor, 4),
            recent=round(self._recent_factor(), 4),
            p50_ns=late.quantile_ns(0.5),
            p99_ns=late.quantile_ns(0.99),
            max_ns=late.max_ns,
            slips=scheduler.slips,
            slipped_ns=scheduler.slipped_ns,
        )


def describe_line(port: Port) -> dict[str, Any]:
    """Return how one end of a line is: its name, whether it is up, its rate, what waits, its counters."""
    about = {"port": port.name, "up": port.line_is_up, "baud": port.baud, "pending": port.pending}
    return {**about, **asdict(port.counters)}


def describe_machine(observed: Observed) -> dict[str, Any]:
    """Return a state machine for the header of a journal: its states and triggers with their texts, its edges."""
    edges = [(state, trigger, edge.next_state) for (state, trigger), edge in observed.table.items()]
    states: Counter[Enum] = Counter()
    for state, _, following in edges:
        states.update((state, following))
    kinds = list(dict.fromkeys(type(state) for state in states))
    return {
        "begins": observed.state.name,
        "states": {state.name: str(state.value) for kind in kinds for state in kind if state in states},
        "triggers": {trigger.name: str(trigger.value) for _, trigger, _ in edges},
        "edges": [[state.name, trigger.name, following.name] for state, trigger, following in edges],
    }
