"""Gathers what a run shows beside its verdicts: coverage and fidelity of virtual peers, exactness of real-time benches.

It only looks at what the cases leave behind, when they are over: nothing here puts an event into a journal.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import asdict
from typing import Any

from hilbench.cases import VirtualCase
from hilbench.check.observations import Coverage, IgnoredCommand, Ledger, Pace, PortCounters, TouchedFeature
from hilbench.clock import NS_PER_S, Scheduler
from hilbench.links import Port
from hilbench.pioneer.robot import OBEYED, UNKNOWN
from protocols.p2os import CLIENT_TABLE, SERVER_TABLE, Role, Table, command_name
from protocols.p2os.states import State, Trigger
from targets.robots.pioneer.ledger import LEDGER, Fidelity, LedgerEntry

AnyTable = Mapping[tuple[Any, Any], Any]
"""Edges by state and trigger, of any protocol."""

TABLES: Mapping[Role, Table] = {Role.SERVER: SERVER_TABLE, Role.CLIENT: CLIENT_TABLE}


class VirtualObserver:
    """Adds up what the virtual cases of a run went through."""

    def __init__(self) -> None:
        self._visits: dict[Role, Counter[tuple[State, Trigger]]] = {}
        self._cases: dict[tuple[int, str], list[str]] = {}
        self._robots = 0

    def take(self, case: VirtualCase) -> None:
        """Look at a case that is over, before its bench is closed."""
        for connection in case.connections():
            self._visits.setdefault(connection.role, Counter()).update(connection.visits)
        commands = case.commands_seen()
        if commands is None:
            return
        self._robots += 1
        for command in sorted(commands):
            self._cases.setdefault(command, []).append(case.case.id)

    def coverage(self) -> tuple[Coverage, ...]:
        """Return the coverage of each role that was tested, the server's first."""
        return tuple(
            coverage_of(role.value, TABLES[role], self._visits[role]) for role in TABLES if role in self._visits
        )

    def ledger(self) -> Ledger | None:
        """Return the fidelity of the virtual robot; None if none was built."""
        if not self._robots:
            return None
        counts = Counter(entry.fidelity for entry in LEDGER)
        incomplete = [entry for entry in LEDGER if entry.fidelity is not Fidelity.MODELLED]
        touched = [self._touched(entry) for entry in (*incomplete, *self._strangers())]
        return Ledger(
            modelled=counts[Fidelity.MODELLED],
            partly=counts[Fidelity.PARTLY],
            absent=counts[Fidelity.ABSENT],
            touched=tuple(feature for feature in touched if feature is not None),
            ignored=tuple(
                IgnoredCommand(command=command_name(number), reason=outcome, case_ids=tuple(case_ids))
                for (number, outcome), case_ids in sorted(self._cases.items())
                if outcome not in {OBEYED, UNKNOWN}
            ),
        )

    def _touched(self, entry: LedgerEntry) -> TouchedFeature | None:
        found = {key: case_ids for key, case_ids in self._cases.items() if key[0] in entry.commands}
        if not found:
            return None
        return TouchedFeature(
            feature=entry.feature,
            fidelity=entry.fidelity.value,
            note=entry.note,
            commands=tuple(dict.fromkeys(command_name(number) for number, _ in sorted(found))),
            case_ids=tuple(dict.fromkeys(case_id for case_ids in found.values() for case_id in case_ids)),
        )

    def _strangers(self) -> Iterable[LedgerEntry]:
        """Return an entry for the commands that came and are nowhere in the ledger."""
        listed = {number for entry in LEDGER for number in entry.commands}
        numbers = sorted({number for number, outcome in self._cases if outcome == UNKNOWN} - listed)
        if numbers:
            note = "no command of the robot: it counts as traffic and has no effect"
            yield LedgerEntry(feature="unknown commands", commands=tuple(numbers), fidelity=Fidelity.ABSENT, note=note)


def coverage_of(peer: str, table: AnyTable, visits: Mapping[tuple[Any, Any], int]) -> Coverage:
    """Return how much of a state table was gone through.

    Args:
        peer: whose table it is.
        table: the whole machine; the state of its first edge is where it begins.
        visits: how often each edge was taken; edges that are not in the table do not count.
    """
    states = dict.fromkeys(state for (state, _), edge in table.items() for state in (state, edge.next_state))
    taken = [edge for edge in table if visits.get(edge)]
    entered = {next(iter(table))[0], *(state for state, _ in taken), *(table[edge].next_state for edge in taken)}
    return Coverage(
        peer=peer,
        states=len(states),
        states_missed=tuple(state.name for state in states if state not in entered),
        edges=len(table),
        edges_missed=tuple(f"{state.name} {trigger.name}" for state, trigger in table if (state, trigger) not in taken),
    )


def pace_of(scheduler: Scheduler) -> Pace | None:
    """Return how well the host kept up with a scheduler; None if it runs free."""
    factor = scheduler.real_time_factor
    if factor is None:
        return None
    late = scheduler.lateness
    return Pace(
        lateness_p50_s=late.quantile_ns(0.5) / NS_PER_S,
        lateness_p99_s=late.quantile_ns(0.99) / NS_PER_S,
        lateness_max_s=late.max_ns / NS_PER_S,
        slips=scheduler.slips,
        slipped_s=scheduler.slipped_ns / NS_PER_S,
        real_time_factor=factor,
    )


def counters_of(ports: Iterable[Port]) -> PortCounters | None:
    """Return the sum of the counters of ports; None if there are none."""
    counters = [asdict(port.counters) for port in ports]
    if not counters:
        return None
    return PortCounters(**{name: sum(counted[name] for counted in counters) for name in counters[0]})
