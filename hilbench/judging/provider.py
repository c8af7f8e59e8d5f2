"""What the check engine needs of a bench: the seam between judging and running.

The engine knows cases, clauses and verdicts; a provider knows targets, links and worlds. It gives each case a bench
and says beforehand what its benches can do.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from typing import Any, Protocol, runtime_checkable

from hilbench.judging.doubt import Doubt

RECORDING = "recording"
"""The capability of a bench that is only listened to. A case that needs it sends nothing."""

ANSWERS = "far end that answers: it is a recording"
"""What every other case misses there."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CaseSetup:
    """How the bench of a case differs from the bench file; for benches of emulated boards.

    Attributes:
        variant: the variant of the bench, by its name in the bench file; empty for the bench itself.
        program: the program that the board runs, by its name in the bench file; empty for its firmware.
        settings: settings of parts, by part and setting.
    """

    variant: str = ""
    program: str = ""
    settings: Mapping[str, Mapping[str, object]] = field(default_factory=dict)

    @property
    def needs(self) -> frozenset[str]:
        """The capabilities that a bench needs for it."""
        there = f" in variant '{self.variant}'" if self.variant else ""
        needs = {f"part '{part}'{there}" for part in self.settings}
        if self.variant:
            needs.add(f"variant '{self.variant}'")
        if self.program:
            needs.add(f"program '{self.program}'{there}")
        return frozenset(needs)


PLAIN_SETUP = CaseSetup()
"""The bench as its file says."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CaseInfo:
    """What a provider is given about a case.

    Attributes:
        id: suite, function and parameters, as in ``lamp/it_is_lit[2]``; the same wherever it runs.
        clause_ids: the clauses it checks.
        seed: of this case alone, so that selection and order change nothing; 0 to 2**63 - 1.
        scene: the scene it asks for; empty for that of the bench file.
        needs: the capabilities it was declared to need; all of them are there.
        by_hand: those of them for which somebody beside the target is asked.
        setup: how else its bench is to differ from that of the bench file.
    """

    id: str
    clause_ids: tuple[str, ...]
    seed: int
    scene: str = ""
    needs: frozenset[str] = frozenset()
    by_hand: frozenset[str] = frozenset()
    setup: CaseSetup = PLAIN_SETUP


def case_seed(run_seed: int, case_id: str) -> int:
    """Derive the seed of a case from that of the run: the first 63 bits of a SHA-256 over both."""
    digest = hashlib.sha256(f"{run_seed}\n{case_id}".encode()).digest()
    return int.from_bytes(digest[:8], "big") >> 1


class CaseBench(Protocol):
    """The bench of one case, from just before it to just after.

    Whatever else a suite asks for by a fixture (``peer``, ``world``, ``journal``, ``client``, ``server``) is an
    attribute of this object. A capability that the provider names must have its attribute.
    """

    @property
    def now_ns(self) -> int:
        """Bench time in nanoseconds; the engine takes differences only."""

    def evidence(self) -> Sequence[str]:
        """Return lines that show what happened last, such as the latest frames; asked for when a case does not pass."""

    def finish(self, verdict: str, cause: str) -> None:
        """Take the verdict into the journal; called once, before `case_hash` and before the bench closes."""

    def case_hash(self) -> str:
        """Return the hash over the canonical events of this case, in hex; empty for a bench in real time."""


@runtime_checkable
class BenchProvider(Protocol):
    """Opens benches for cases.

    Making one must be cheap: ``--list`` makes one and opens nothing.
    """

    @property
    def capabilities(self) -> frozenset[str]:
        """What its benches can do, to be compared with the needs of the cases."""

    def describe(self) -> Mapping[str, str]:
        """Name the parts of the bench for the first line of the report, in order.

        The keys ``bench``, ``target`` and ``physics`` are expected; others may follow.
        """

    def open_case(self, case: CaseInfo) -> AbstractContextManager[CaseBench]:
        """Open the bench of one case; leaving the context closes it.

        Raises:
            UnavailableError: the target is not there, or no longer there. Nothing further is then run.
        """

    def close(self) -> None:
        """Give everything back. Called once, also after an error."""


@runtime_checkable
class Choosing(Protocol):
    """What a provider may have besides: the suites that are meant where none is named."""

    @property
    def suites(self) -> Sequence[str]:
        """Names of shipped suites, or paths."""


@runtime_checkable
class Attended(Protocol):
    """What a provider may have besides: somebody beside the target, who does what he is asked for."""

    @property
    def by_hand(self) -> frozenset[str]:
        """The capabilities that he brings, for clauses that allow it; empty where nobody was named."""


@runtime_checkable
class Preparing(Protocol):
    """What a provider may have besides: a look at what is to run, before the first case."""

    def prepare(self, cases: Sequence[CaseInfo]) -> None:
        """Make sure that there is what these cases need; called once they are selected, and not to list them.

        Raises:
            UnavailableError: something is not there. Nothing is then run.
        """


@runtime_checkable
class Lines(Protocol):
    """Where what happens is written down, line by line."""

    def append(self, lines: bytes) -> None:
        """Add whole lines that another of the same kind has written.

        Raises:
            UnavailableError: they cannot be written.
        """

    def flush_step(self) -> None:
        """Write what has happened so far; raises as `append`."""


@runtime_checkable
class Journalled(Protocol):
    """What a provider may have besides, if each of its benches is made anew: then cases may run beside each other."""

    @property
    def recorded_in(self) -> Lines:
        """Where its cases are recorded, one after the other; nothing is recorded before the first of them begins."""


@runtime_checkable
class Doubtful(Protocol):
    """What the bench of a case may have besides: how far its times can be trusted; where time is virtual, wholly."""

    def uncertainty_s(self) -> float:
        """Return how far off any time of the case may be, until now, in seconds."""

    def doubt(self) -> Doubt:
        """Return how late things were in the case; called once, before `CaseBench.finish`."""


@runtime_checkable
class Lacking(Protocol):
    """What the bench of a case may have besides: a target that is emulated, and what its emulation lacks."""

    def lacks(self) -> str:
        """Return on what that is not modelled the target waits, for people; empty if it waits on nothing of the kind.

        Called once, of a case that did not pass, before `CaseBench.finish`.
        """


@runtime_checkable
class Following(Protocol):
    """What the bench of a case may have besides: what the target does after the case failed."""

    def afterwards(self) -> Sequence[str]:
        """Look on for a moment, and return lines that show what came then; called once, after `CaseBench.finish`."""


@runtime_checkable
class Timed(Protocol):
    """What the bench of a case may have besides: timers that can be looked at, such as watchdogs."""

    def keep_margins(self) -> None:
        """Keep from now on how much time is left of each when it is set anew; called once, before the case begins.

        `CaseBench.finish` takes it into the journal, outside of the hash, where the verdict is no pass.
        """


@dataclass(frozen=True, slots=True, kw_only=True)
class CaseView:
    """What there is to be seen of a case at one moment, for those who draw it.

    Attributes:
        about: what the header of a journal says to those who show it: state machines, boards, the world.
        events: what happened in the case until then, as in the journal.
    """

    about: Mapping[str, Any]
    events: Sequence[Mapping[str, Any]]


@runtime_checkable
class Viewable(Protocol):
    """What the bench of a case may have besides: a view of it."""

    def watch(self) -> None:
        """Keep from now on what a view needs; called once, before the case begins."""

    def view(self) -> CaseView:
        """Return what there is to be seen now; called once, after `CaseBench.finish`."""
