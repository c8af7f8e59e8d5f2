"""Loops that change nothing are not executed: waiting costs no host time, and every trace stays the same.

If a program comes back to the same instruction with the same registers and the same memory, has written no register
and has read only registers that stay as they are until something happens in the chip, then it will do the same over
and over until the next event. Whole periods of it can be accounted for at once. This covers ``b .``, polling of a
status flag and of a variable, and delay loops on a tick that call functions and use the stack.

A period is looked for by executing single instructions, which is slow, so after each event the program runs for a
while first, and longer after every vain attempt; unless it reads the same register several times in a row before that.

Loops that poll a counter do change something; most of them can be passed over too (`counted`).
"""

from __future__ import annotations

from dataclasses import dataclass

from targets.mcu.bus import Bus
from targets.mcu.engine.api import Reg, Stop, StopKind
from targets.mcu.engine.counted import CountedLoops
from targets.mcu.engine.unicorn_engine import UnicornEngine
from targets.mcu.timebase import Timebase

__all__ = ["IdleSkipper", "Loop"]

_SHORTEST_WAIT, _GROWTH = 160, 4
_WAIT_PER_STEP = 8000  # instructions for each one of a vain attempt: attempts then take a fifth of the time at most
_STEP, _READ = 800, 250  # what a step of an attempt and a read of a register take, in instructions
_LONGEST_PERIOD = 128
_MOST_PASSES = 6  # through an instruction, without being in the same state: something is counted there
_FEWEST_POLLS, _MOST_POLLS = 4, 1 << 14
_FEWEST_TURNS = 24  # of a loop that waits for a counter, for its attempt to have been worth it
_LIMIT = Stop(StopKind.LIMIT)


@dataclass(frozen=True, slots=True)
class Loop:
    """A loop that changes nothing.

    Attributes:
        pc: an instruction of it.
        instructions: in one period.
        polled: addresses of the registers that are read in it.
    """

    pc: int
    instructions: int
    polled: tuple[int, ...]


class IdleSkipper:
    """Executes like the engine does, but passes over loops that change nothing.

    Args:
        engine: executes.
        bus: tells of accesses to registers.
        time: tells when something happens next.
        memory: the RAM.

    Attributes:
        found: the loop in which the program waited last, since `restart`; None if it did not.
    """

    def __init__(self, engine: UnicornEngine, bus: Bus, time: Timebase, memory: bytearray) -> None:
        self._engine = engine
        self._bus = bus
        self._time = time
        self._memory = memory
        self._period = 0
        self._steps = 0  # of the last attempt
        self._saved = 0  # by it, in steps
        self._shortest = _SHORTEST_WAIT
        self._wait = _SHORTEST_WAIT
        self.found: Loop | None = None
        self._polled = False
        self._reads = False  # the last attempt was about a loop that reads registers
        self._counted = CountedLoops(engine, bus, time, memory)
        bus.polls_wanted = _FEWEST_POLLS

    def polled(self) -> None:
        """The program has read the same register several times in a row: it may be waiting for it."""
        self._wait = 0
        self._polled = True
        self._engine.cut()

    def restart(self) -> None:
        """Something has happened, and the program may go elsewhere."""
        if self._shortest < self._wait:
            self._wait = self._shortest
        self.found = None

    def run(self, target: int) -> Stop:
        """Execute up to cycle `target` or less; the same as `CpuEngine.run` in every effect."""
        if self._wait <= 0:
            return self._pass(target)
        engine = self._engine
        began = engine.instructions
        stop = engine.run(target, self._wait)
        self._wait -= engine.instructions - began
        return stop

    def _pass(self, target: int) -> Stop:
        """Execute a little, and pass over the loop that this is part of, if there is one."""
        known = self._counted.pass_known(target)
        if known is not None:
            self.found = None
            stop, turns = known
            self._reckon(turns >= _FEWEST_TURNS)
            return stop
        stop = self._look(target, skip=True)
        if self.found is None and self._reads:
            stop, turns = self._counted.pass_new(target)
            if turns >= _FEWEST_TURNS:
                self._reckon(True)
        return stop

    def look(self, target: int) -> Stop:
        """Execute a period of the loop in which the program waits, if there is one; `found` says whether."""
        self._period = 0  # the effect does not depend on what was found before
        return self._look(target, skip=False)

    def _look(self, target: int, *, skip: bool) -> Stop:
        stop, self.found = self._attempt(target, skip=skip)
        self._period = 0 if self.found is None else self.found.instructions
        self._reckon(self.found is not None and self._saved >= self._steps)
        return stop

    def _reckon(self, worth_it: bool) -> None:
        """Say when to try again, after an attempt that was worth it or not."""
        if worth_it:
            self._shortest = _SHORTEST_WAIT
            self._bus.polls_wanted = _FEWEST_POLLS
        else:
            self._shortest = min(self._shortest * _GROWTH, max(_SHORTEST_WAIT, self._steps * _WAIT_PER_STEP))
            if self._polled:
                self._bus.polls_wanted = min(self._bus.polls_wanted * _GROWTH, _MOST_POLLS)
        self._polled = False
        self._wait = self._shortest

    def _attempt(self, target: int, *, skip: bool) -> tuple[Stop, Loop | None]:
        """Execute one period of a loop, if there is one; if it may `skip`, pass over those that fit before `target`."""
        engine, bus = self._engine, self._bus
        before, memory, writes = engine.fingerprint(), bytes(self._memory), bus.writes
        began, cycle = engine.instructions, engine.cycle
        bus.trace = []
        stop = self._run_period(target, before, _MOST_PASSES if skip else _LONGEST_PERIOD)
        polled, bus.trace = bus.trace, None
        ran = engine.instructions - began
        self._saved = self._steps
        goes_on = stop.kind is StopKind.LIMIT and bus.writes == writes and engine.limit_cycle >= self._due(target)
        self._reads = goes_on and bool(polled) and not engine.reached_limit and engine.cycle < self._due(target)
        if (
            goes_on
            and engine.fingerprint() == before
            and not any(live for _address, _value, live in polled)
            and self._memory == memory
        ):
            addresses = tuple(dict.fromkeys(address for address, _value, _live in polled))
            if skip:
                began = engine.instructions
                engine.skip_periods(self._due(target), ran, engine.cycle - cycle)
                passed = engine.instructions - began
                self._saved = (passed + passed // ran * len(polled) * _READ) // _STEP
            return stop, Loop(engine.get(Reg.PC), ran, addresses)
        return stop, None

    def _run_period(self, target: int, before: bytes, passes: int) -> Stop:
        engine = self._engine
        start = engine.pc()
        self._steps = 0
        for instructions in (*([self._period] if self._period else []), *[1] * _LONGEST_PERIOD):
            # what a register access enters comes first, so the target is looked at each time
            due = self._due(target)
            if engine.cycle >= due:
                break
            stop = engine.run(due, instructions)
            self._steps += 1
            if stop.kind is not StopKind.LIMIT or engine.reached_limit or engine.limit_cycle < due:
                return stop
            if engine.pc() == start:
                passes -= 1
                if passes == 0 or engine.fingerprint() == before:
                    return stop
        return _LIMIT

    def _due(self, target: int) -> int:
        due = self._time.next_cycle()
        return target if due is None else min(target, due)
