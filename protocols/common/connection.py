"""What each end of a line has, whatever is spoken on it: a machine that can be looked at and is driven by time."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Mapping
from enum import Enum
from typing import ClassVar, Generic

from protocols.state_machine import ActionT, CountersT, Edge, EventT, StateMachine, StateT, TimerT, TriggerT

__all__ = ["MachineConnection"]


class MachineConnection(ABC, Generic[StateT, TriggerT, ActionT, TimerT, EventT, CountersT]):
    """One end of a line with a state machine.

    Attributes:
        MISUSE: the class of the errors of the protocol that say that the program asks for what is not possible now.
        role: which end.
    """

    MISUSE: ClassVar[type[Exception]]
    role: Enum
    _machine: StateMachine[StateT, TriggerT, ActionT, TimerT, EventT, CountersT]

    @property
    def state(self) -> StateT:
        """Where the machine is."""
        return self._machine.state

    @property
    def counters(self) -> CountersT:
        """What was seen and dropped since the connection was made."""
        return self._machine.counters

    @property
    def visits(self) -> Counter[tuple[StateT, TriggerT]]:
        """How often each edge of the role's state table was taken."""
        return self._machine.visits

    @property
    def deadlines(self) -> Mapping[TimerT, int]:
        """When each of the timers that run now will run out, in ns of bench time."""
        return self._machine.deadlines

    @property
    def table(self) -> Mapping[tuple[StateT, TriggerT], Edge[StateT, ActionT]]:
        """The state table that is in force."""
        return self._machine.table

    def advance(self, now_ns: int) -> list[EventT]:
        """Lets happen what is due at `now_ns`, in the order of its time."""
        self._run_due(now_ns)
        return self._machine.fetch()

    def _user(self, trigger: TriggerT, now_ns: int) -> list[EventT]:
        """Does what the program asks for.

        Raises:
            MISUSE: the state has no such edge; nothing is changed then.
        """
        self._check_edge(trigger)
        self._run_due(now_ns)
        self._machine.fire(trigger)
        return self._machine.fetch()

    def _check_edge(self, trigger: TriggerT) -> None:
        if not self._machine.has_edge(trigger):
            what = f"a {self.role.value} in state {self.state.name} cannot {trigger.name.lower()}"
            raise self.MISUSE(what)

    @abstractmethod
    def _run_due(self, now_ns: int) -> int:
        """Lets everything happen that is due, each at its time, and returns the time that counts as now."""
