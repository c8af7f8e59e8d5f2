"""A mutant put to the test: the suites are run against it until a clause fails."""

from __future__ import annotations

import contextlib
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any
from unittest.mock import patch

import msgspec

from hilbench.check.results import CaseResult
from hilbench.check.runner import run_suites
from hilbench.clock import Scheduler
from hilbench.errors import UnavailableError
from hilbench.judging.provider import CaseInfo
from hilbench.judging.verdicts import Verdict
from hilbench.links import Port
from hilbench.terminal.options import CheckOptions
from measure.mutants.derived.mutant import Acting, Fault, Group, Mutant
from measure.mutants.derived.relay import Relay
from measure.mutants.derived.subjects import Subject, opened
from measure.mutants.derived.tape import edge_of, machine_of
from measure.mutants.wire import Way
from protocols.state_machine import StateMachine

__all__ = ["Outcome", "tried"]

_SCALE = {Fault.HALVED: 0.5, Fault.TWICE: 2.0}


class Outcome(msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True):
    """What came of a mutant.

    Attributes:
        cases: in how many cases it does something that the right peer does not.
        found_by: the clauses that failed first; empty if none did.
        case: the case in which they did.
        cause: what this case says.
        error: the case broke down instead of failing.
        inconclusive: cases that were inconclusive until then.
        lost: why its process had to be ended; empty if it came to its end.
    """

    cases: int
    found_by: tuple[str, ...] = ()
    case: str = ""
    cause: str = ""
    error: bool = False
    inconclusive: tuple[str, ...] = ()
    lost: str = ""

    @property
    def found(self) -> bool:
        """Whether something showed that the peer is wrong."""
        return bool(self.found_by or self.lost)


@dataclass(slots=True)
class _Watch:
    """Takes the results as they come.

    Attributes:
        unsound: cases that the right peer does not pass either.
    """

    unsound: Collection[str]
    failed: CaseResult | None = None
    inconclusive: tuple[str, ...] = ()

    def take(self, result: CaseResult, _number: int, _total: int) -> None:
        if result.id in self.unsound:
            return
        if result.verdict in (Verdict.FAIL, Verdict.ERROR) and self.failed is None:
            self.failed = result
        elif result.verdict is Verdict.INCONCLUSIVE:
            self.inconclusive += (result.id,)


def tried(
    subject: Subject,
    mutant: Mutant,
    cases: Sequence[str],
    *,
    at_port: bool,
    by_hand: bool = False,
    unsound: Collection[str] = (),
    seed: int = 0,
    through: str = "",
) -> Outcome:
    """Run cases against a mutant until one of them fails.

    Args:
        subject: who is wrong.
        mutant: how.
        cases: those that may show it.
        at_port: the subject is somebody else's.
        by_hand: and somebody stands beside it.
        unsound: cases whose verdict says nothing, since the right peer does not pass them either.
        seed: of the run.
        through: a door of this machine that the lines pass; see `opened`.
    """
    if not cases:
        return Outcome(cases=0)
    watch = _Watch(unsound)
    select = subject.selects(" or ".join(_word(case) for case in cases))
    options = CheckOptions(bench=subject.bench, suites=subject.suites, select=select, seed=seed)
    readings = {way: subject.reading(way) for way in Way}
    on_line = mutant.fault.group not in (Group.TIMER, Group.EDGE)

    def relay(scheduler: Scheduler, port: Port) -> Port:
        if not on_line or isinstance(port, Relay) or subject.line not in port.name:
            return port
        acting = Acting(mutant, readings[mutant.way])
        lanes = {"on_said": acting} if mutant.way is Way.OUT else {"on_heard": acting}
        return Relay(scheduler, port, readings[Way.OUT], readings[Way.IN], **lanes)  # type: ignore[arg-type]

    with opened(subject, relay, at_port=at_port, by_hand=by_hand, through=through) as provider, _wrong(mutant):
        open_case = provider.open_case

        @contextlib.contextmanager
        def until_found(case: CaseInfo) -> Iterator[Any]:
            if watch.failed is not None:
                raise UnavailableError("a clause has failed", where=mutant.id)
            with open_case(case) as bench:
                yield bench

        provider.open_case = until_found  # type: ignore[method-assign]
        run_suites(options, provider, on_result=watch.take)
    failed = watch.failed
    if failed is None:
        return Outcome(cases=len(cases), inconclusive=watch.inconclusive)
    return Outcome(
        cases=len(cases),
        found_by=failed.failed_clause_ids or failed.clause_ids,
        case=failed.id,
        cause=failed.cause,
        error=failed.verdict is Verdict.ERROR,
        inconclusive=watch.inconclusive,
    )


def _word(case: str) -> str:
    """The case as a word of a selection: parentheses have a meaning there, and end the word."""
    return case.partition("(")[0].split()[0]


@contextlib.contextmanager
def _wrong(mutant: Mutant) -> Iterator[None]:
    """Put a fault of a timer or an edge into every machine of the kind it is of."""
    group = mutant.fault.group
    if group is Group.TIMER:
        with patch.object(StateMachine, "start", _scaled(mutant, StateMachine.start)):
            yield
    elif group is Group.EDGE:
        with patch.object(StateMachine, "fire", _refusing(mutant, StateMachine.fire)):
            yield
    else:
        yield


def _scaled(mutant: Mutant, start: Any) -> Any:
    def scaled(machine: Any, timer: Any, after_s: float | None, **more: Any) -> None:
        its = (machine_of(machine), timer.name) == (mutant.message, mutant.name)
        start(machine, timer, after_s if after_s is None or not its else after_s * _SCALE[mutant.fault], **more)

    return scaled


def _refusing(mutant: Mutant, fire: Any) -> Any:
    def refusing(machine: Any, trigger: Any) -> None:
        if (machine_of(machine), edge_of(machine.state, trigger)) != (mutant.message, mutant.name):
            fire(machine, trigger)
            return
        right = machine.table
        machine.table = _without(mutant.fault, right, machine.state, trigger)
        try:
            fire(machine, trigger)
        finally:
            machine.table = right

    return refusing


def _without(fault: Fault, table: Mapping[Any, Any], state: Any, trigger: Any) -> Mapping[Any, Any]:
    cells = dict(table)
    if fault is Fault.REFUSED:
        cells.pop((state, trigger), None)
    elif fault is Fault.STAYS:
        cells[state, trigger] = replace(cells[state, trigger], next_state=state)
    else:
        cells[state, trigger] = replace(cells[state, trigger], actions=())
    return MappingProxyType(cells)
