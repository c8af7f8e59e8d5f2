"""Mutants made from the state tables: every edge removed, led elsewhere, and its actions dropped or replaced.

Of the states an edge could lead to instead, two are taken: its own (it goes nowhere) or, where that is right, the first
of the machine; and one on the far side of the machine. Every table that comes out is made once.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from measure.mutants.mutant import Edge, Family, Mutant
from protocols.p2os import CLIENT_TABLE, SERVER_TABLE, ClientState, ServerState
from protocols.p2os.states import Action, State, Table, Transition, Trigger

_OTHER_REPLY = {
    Action.ECHO: Action.IDENTIFY,
    Action.IDENTIFY: Action.ECHO,
    Action.REFUSE: Action.ECHO_0,
    Action.SEND_SYNC0: Action.SEND_SYNC1,
    Action.SEND_SYNC1: Action.SEND_SYNC2,
    Action.SEND_SYNC2: Action.SEND_SYNC0,
    Action.SEND_CLOSE_OLD: Action.SEND_PULSE,
    Action.SEND_OPEN: Action.SEND_PULSE,
    Action.REPEAT_OPEN: Action.SEND_CLOSE,
    Action.REQUEST_CONFIG: Action.SEND_PULSE,
    Action.SEND_PULSE: Action.SEND_DISABLE,
    Action.SEND_DISABLE: Action.SEND_PULSE,
    Action.SEND_CLOSE: Action.SEND_PULSE,
    Action.REPORT_CONNECTED: Action.REPORT_FAILED,
    Action.REPORT_FAILED: Action.REPORT_CONNECTED,
    Action.REPORT_LOST: Action.REPORT_DISCONNECTED,
    Action.REPORT_DISCONNECTED: Action.REPORT_LOST,
}
"""What is done instead of an action that shows on the line or to the user."""

_HOME: dict[type, State] = {ServerState: ServerState.WAIT, ClientState: ClientState.IDLE}
_FAR: dict[State, State] = {
    ServerState.WAIT: ServerState.OPEN,
    ServerState.WAIT1: ServerState.READY,
    ServerState.WAIT2: ServerState.WAIT,
    ServerState.READY: ServerState.WAIT1,
    ServerState.OPEN: ServerState.READY,
}
"""For the server's states one that is neither the same nor next to it."""


def server_mutants() -> list[Mutant]:
    """Return the mutants of the server's table."""
    return _mutants(Family.SERVER_TABLE, SERVER_TABLE)


def client_mutants() -> list[Mutant]:
    """Return the mutants of the client's table."""
    return _mutants(Family.CLIENT_TABLE, CLIENT_TABLE)


def _mutants(family: Family, table: Table) -> list[Mutant]:
    found: list[Mutant] = []
    for (state, trigger), edge in table.items():
        made: set[Transition | None] = set()
        for suffix, what, becomes in _variants(state, edge):
            if becomes in made:
                continue
            made.add(becomes)
            mutant = Mutant(
                id=f"{family.value.removesuffix('-table')}:{state.name}/{trigger.name}:{suffix}",
                family=family,
                what=f"{_name(state, trigger)}: {what}",
                edges=(Edge(state, trigger, becomes),),
            )
            found.append(mutant)
    return found


def _name(state: State, trigger: Trigger) -> str:
    return f"{state.name} + {trigger.name}"


def _variants(state: State, edge: Transition) -> Iterator[tuple[str, str, Transition | None]]:
    yield "removed", "ignored", None
    for target in _targets(state, edge):
        yield (
            f"to-{target.name}",
            f"goes to {target.name}, not {edge.next_state.name}",
            replace(edge, next_state=target),
        )
    for index, action in enumerate(edge.actions):
        rest = (*edge.actions[:index], *edge.actions[index + 1 :])
        yield f"no-{action.name}", f"does not {action.value}", replace(edge, actions=rest)
        if other := _OTHER_REPLY.get(action):
            changed = (*edge.actions[:index], other, *edge.actions[index + 1 :])
            yield (
                f"{action.name}-{other.name}",
                f"does not {action.value}, but {other.value}",
                replace(edge, actions=changed),
            )


def _targets(state: State, edge: Transition) -> list[State]:
    near = state if edge.next_state is not state else _HOME[type(state)]
    far = _FAR.get(edge.next_state, ClientState.LOST)
    return [target for target in dict.fromkeys((near, far)) if target is not edge.next_state]
