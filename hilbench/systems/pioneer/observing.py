"""Adds up what the virtual Pioneers of a run went through: state tables, and what the model leaves out."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping

from hilbench.bench.observing import coverage_of
from hilbench.judging.observations import Coverage, IgnoredCommand, Ledger, TouchedFeature
from hilbench.systems.pioneer.cases import VirtualCase
from hilbench.systems.pioneer.robot import OBEYED, UNKNOWN
from protocols.p2os import CLIENT_TABLE, SERVER_TABLE, Role, Table, command_name
from protocols.p2os.states import State, Trigger
from targets.robots.pioneer.ledger import LEDGER, Fidelity, LedgerEntry

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
