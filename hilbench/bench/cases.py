"""What the bench of every case has, as its suite sees it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import Any

from hilbench.bench import Bench
from hilbench.bench.line_end import LineEnd
from hilbench.bench.line_evidence import in_order, in_words
from hilbench.bench.line_faults import LineFaults
from hilbench.bench.line_peer import LinePeer
from hilbench.bench.looking_on import look_on
from hilbench.bench.margins import Margins
from hilbench.bench.state_reporter import Observed, Senses
from hilbench.bench.watch import Watch
from hilbench.clock import NS_PER_S
from hilbench.journal import Journal
from hilbench.judging.doubt import Doubt
from hilbench.judging.provider import CaseInfo, CaseView
from hilbench.judging.verdicts import Verdict
from hilbench.links import Port

_LINES_SHOWN = 14
"""Of evidence, of several lines together (choice)."""


class CaseBase:
    """What is the same for every kind of target.

    Args:
        bench: whose time and journal the case uses.
        case: what is known of it.
        faults: what goes wrong on its line, if anything does.

    Attributes:
        on_lacks: asked by `lacks`; where something of the bench is emulated, it answers.
    """

    _senses: Senses = MappingProxyType({})
    """What the ends of timers mean, for a view and for margins."""

    def __init__(self, bench: Bench, case: CaseInfo, faults: LineFaults | None = None) -> None:
        self.bench = bench
        self.case = case
        self._faults = faults
        self._hash = ""
        self._watch: Watch | None = None
        self._margins: Margins | None = None
        self._began_ns = bench.now_ns
        self.on_lacks: Callable[[], str] = str
        bench.journal.begin_case(case.id, bench.now_ns)

    @property
    def now_ns(self) -> int:
        """Bench time in nanoseconds."""
        return self.bench.now_ns

    @property
    def journal(self) -> Journal:
        """The journal of the run."""
        return self.bench.journal

    def finish(self, verdict: str, cause: str) -> None:
        """Take the verdict into the journal and close the case's part of it."""
        if self.bench.scheduler.locked:
            self.bench.record("host-lateness", "checker", uncertainty_s=float(self.uncertainty_s()))
        self.bench.record("verdict", "checker", verdict=verdict, cause=cause)
        if self._margins is not None:
            self._margins.end()
            if verdict not in {Verdict.PASS.value, Verdict.NOT_APPLICABLE.value}:
                self._margins.record()
        self._hash = self.bench.journal.end_case(self.bench.now_ns)

    def uncertainty_s(self) -> float:
        """Return how far off any time of the case may be, until now, in seconds."""
        return self.bench.uncertainty_s(self._began_ns)

    def doubt(self) -> Doubt:
        """Return how late this bench and a served one were in the case, until now."""
        since_ns = self._began_ns
        late = {
            "this bench": self.bench.own_lateness(since_ns),
            "the served bench": self.bench.far_lateness(since_ns),
            "this host's handing on of bytes": self.bench.way_lateness(since_ns),
        }
        most_ns = max(one.whole_ns for one in late.values())
        # What is small beside the other is no cause.
        cause = " and ".join(f"{name} {one}" for name, one in late.items() if 4 * one.whole_ns >= max(most_ns, 1))
        whole_ns = sum(one.whole_ns for one in late.values())
        return Doubt(lateness_s=whole_ns / NS_PER_S, cause=cause, lived=self.bench.far_lived(since_ns))

    def lacks(self) -> str:
        """Return on what that is not modelled a target waits, for people; empty if on nothing of the kind."""
        return self.on_lacks()

    def case_hash(self) -> str:
        """Return the hash over the canonical events of this case; empty in real time, where it would mean nothing."""
        return "" if self.bench.scheduler.locked else self._hash

    def evidence(self) -> Sequence[str]:
        """Return the latest packets, and the faults that struck."""
        return [*self._packets(), *(self._faults.evidence() if self._faults is not None else ())]

    def afterwards(self) -> Sequence[str]:
        """Look on, and return what that shows; see `look_on`."""
        return look_on(self.bench, self._ends())

    def _ends(self) -> Mapping[str, LineEnd]:
        """Return the checker's ends of the lines, by the names of the lines."""
        return self._peers()

    def _peers(self) -> Mapping[str, LinePeer[Any]]:
        """Return those of them that are peers."""
        return {}

    def _packets(self) -> Sequence[str]:
        """Return the latest packets, as lines."""
        peers = self._peers()
        if len(peers) == 1:
            return next(iter(peers.values())).evidence()
        lines = [(at_ns, f"{name:9} {words}") for name, peer in peers.items() for at_ns, words in peer.passed()]
        shown = [in_words(*line) for line in in_order(lines)][-_LINES_SHOWN:]
        return [*shown, *(f"{name} {line.lstrip()}" for name, peer in peers.items() for line in peer.silence())]

    def keep_margins(self) -> None:
        """Keep from now on how much time timers have left; it goes into the journal with a verdict that is no pass."""
        self._margins = Margins(self.bench, self._machines_seen, self._senses)

    def watch(self) -> None:
        """Keep from now on what a view of the case needs."""
        self._watch = Watch(self.bench, self._machines_seen, self._lines_seen, self._senses)

    def view(self) -> CaseView:
        """Return what there is to be seen now."""
        assert self._watch is not None
        return self._watch.view(self._about_view())

    def _machines_seen(self) -> Mapping[str, Observed]:
        """Return the state machines that can be looked at, by their source in the journal."""
        return {}

    def _lines_seen(self) -> Mapping[str, Port]:
        """Return the checker's ends of the lines."""
        return {name: peer.port for name, peer in self._peers().items()}

    def _about_view(self) -> Mapping[str, Any]:
        """Return what the header of a journal says to those who show it; see `hilbench.bench.about`."""
        return {}
