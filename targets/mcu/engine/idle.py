"""Has loops passed over in which a program waits: waiting costs no host time, and every trace stays the same.

Loops that change nothing the engine finds by itself: ``b .``, polling of a status flag or of a variable, delay loops on
a tick. It looks for them now and then, and at once after a register was read several times in a row.

Loops that poll a counter do change something; most of them can be passed over too (`counted`). Trying that is slow, so
it is tried the less often the more often it was in vain.
"""

from __future__ import annotations

from targets.mcu.bus import Bus
from targets.mcu.engine.api import Stop
from targets.mcu.engine.core_engine import CoreEngine, Loop, Skip
from targets.mcu.engine.counted import CountedLoops
from targets.mcu.timebase import Timebase

__all__ = ["IdleSkipper"]

_SHORTEST_WAIT, _LONGEST_WAIT, _GROWTH = 160, 1 << 20, 4  # instructions between two attempts
_FEWEST_POLLS, _MOST_POLLS = 4, 1 << 14
_FEWEST_TURNS = 12  # of a loop that waits for a counter, for its attempt to have been worth it


class IdleSkipper:
    """Executes like the engine does, but passes over loops in which the program waits.

    Args:
        engine: executes.
        bus: tells of accesses to registers.
        time: tells when something happens next.
        memory: the RAM.
    """

    def __init__(self, engine: CoreEngine, bus: Bus, time: Timebase, memory: bytearray) -> None:
        self._engine = engine
        self._counted = CountedLoops(engine, bus, time, memory)
        self._wait = _SHORTEST_WAIT
        engine.polls_wanted = _FEWEST_POLLS

    @property
    def found(self) -> Loop | None:
        """The loop in which the program waited last, since `restart`; None if it did not."""
        return self._engine.loop

    def restart(self) -> None:
        """Something has happened, and the program may go elsewhere."""
        self._engine.forget_loop()

    def run(self, target: int) -> Stop:
        """Execute up to cycle `target` or less; the same as `CoreEngine.go` in every effect."""
        engine = self._engine
        stop = engine.go(target, skip=Skip.LOOPS)
        if engine.counting:
            return self._pass_counting(target)
        if engine.polled_often:
            self._reckon_polls(engine.loop is not None)
        return stop

    def look(self, target: int) -> Stop:
        """Execute a period of the loop in which the program waits, if there is one; `found` says whether."""
        return self._engine.go(target, skip=Skip.LOOK_ONCE)

    def _pass_counting(self, target: int) -> Stop:
        """The program is in a loop that reads a counter, and nothing has happened since: pass over it if possible."""
        known = self._counted.pass_known(target)
        stop, turns = self._counted.pass_new(target) if known is None else known
        worth_it = turns >= _FEWEST_TURNS
        self._wait = _SHORTEST_WAIT if worth_it else min(self._wait * _GROWTH, _LONGEST_WAIT)
        self._engine.look_after(self._wait)
        self._reckon_polls(worth_it)
        return stop

    def _reckon_polls(self, worth_it: bool) -> None:
        engine = self._engine
        if worth_it:
            engine.polls_wanted = _FEWEST_POLLS
        elif engine.polled_often:
            engine.polls_wanted = min(engine.polls_wanted * _GROWTH, _MOST_POLLS)
        engine.polled_often = False
