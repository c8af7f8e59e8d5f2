"""Gathers what a run shows beside its verdicts: coverage and fidelity of virtual peers, exactness of real-time benches.

It only looks at what the cases leave behind, when they are over: nothing here puts an event into a journal.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import asdict
from typing import Any

from hilbench.clock import NS_PER_S, Scheduler
from hilbench.judging.observations import Coverage, Pace, PortCounters
from hilbench.links import Port

AnyTable = Mapping[tuple[Any, Any], Any]
"""Edges by state and trigger, of any protocol."""


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
