"""Passes over loops that wait for a counter (`counting_loop`): exactly up to the turn that leaves, which is executed.

A turn is executed twice before anything is passed over: what peripherals other than counters give must be the same
both times, for a read may change what the next one gives.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

from targets.mcu.bus import Bus
from targets.mcu.engine.api import Reg, Stop, StopKind
from targets.mcu.engine.core_engine import CoreEngine
from targets.mcu.engine.counting_loop import CountingLoop, State, Turns
from targets.mcu.engine.dataflow import Node
from targets.mcu.engine.follower import FLAGS, SP, Follower, NotUnderstood, Place, RegisterRead
from targets.mcu.engine.follower_steps import step
from targets.mcu.engine.timing import FlatTiming
from targets.mcu.registers import Count
from targets.mcu.timebase import Timebase

__all__ = ["CountedLoops"]

_LONGEST_TURN = 96  # instructions
_FEWEST_TURNS, _MOST_TURNS, _GROWTH = 64, 8192, 8  # that are computed at once
_MOST_LOOPS = 256
_RAM_BASE, _FLASH_END = 0x2000_0000, 0x1000_0000
_LIMIT = Stop(StopKind.LIMIT)

_Reads = list[tuple[int, int, bool]]


@dataclass(slots=True)
class _Given:
    """What every turn of a loop gets from peripherals.

    Attributes:
        same: what is the same, by node.
        unknown: but for these bits of it.
        counts: what counts.
        until: the first cycle at which it may not count on.
    """

    same: dict[Node, int] = field(default_factory=dict)
    unknown: dict[Node, int] = field(default_factory=dict)
    counts: dict[RegisterRead, Count] = field(default_factory=dict)
    until: int = 1 << 62


class CountedLoops:
    """Finds loops that wait for counters, and passes over them.

    Args:
        engine: executes.
        bus: tells of accesses to registers.
        time: tells when something happens next.
        memory: the RAM.
    """

    def __init__(self, engine: CoreEngine, bus: Bus, time: Timebase, memory: bytearray) -> None:
        self._engine = engine
        self._bus = bus
        self._time = time
        self._memory = memory
        self._loops: dict[int, CountingLoop] = {}
        self._detours: dict[int, int] = {}

    def pass_known(self, target: int) -> tuple[Stop, int] | None:
        """Execute two turns of the loop that begins here, and pass over more of them; None if no such loop is known.

        Returns:
            how the execution stopped, and how many turns were passed over.
        """
        engine, head = self._engine, self._engine.pc()
        detour = self._detours.get(head)
        if detour is not None:
            stop, goes_on = self._go_on(detour, target)
            head = engine.pc()
            if not goes_on or head not in self._loops:
                self._detours.clear()
                return stop, 0
        loop = self._loops.get(head)
        if loop is None:
            return None
        passed = 0
        stop, reads = self._execute(loop, head, target)
        if reads is not None and loop.is_still(engine.half):
            stop, passed = self._pass(loop, head, reads, target)
        if not passed:
            del self._loops[head]
        return stop, passed

    def pass_new(self, target: int, *, may_go_on: bool = True) -> tuple[Stop, int]:
        """Execute what follows, and if that is a loop that waits for a counter, pass over it; returns as above.

        Args:
            target: the cycle to execute up to at most.
            may_go_on: the head may be looked for further on.
        """
        head = self._engine.pc()
        registers, memory = self._registers(), bytes(self._memory)
        stop, reads, offsets = self._execute_step_by_step(head, target)
        if not reads:
            return stop, 0
        try:
            loop = self._understand(_Before(registers, memory, reads, self._engine.half), head, offsets)
        except NotUnderstood:
            return stop, 0
        if len(self._loops) + len(self._detours) >= _MOST_LOOPS:
            self._loops.clear()
            self._detours.clear()
        if may_go_on and (detour := self._to_the_first_in_part(loop, reads)):
            self._detours[head] = detour
            stop, goes_on = self._go_on(detour, target)
            return self.pass_new(target, may_go_on=False) if goes_on else (stop, 0)
        self._loops[head] = loop
        return self._pass(loop, head, reads, target)

    def _to_the_first_in_part(self, loop: CountingLoop, reads: _Reads) -> int:
        """Return how many instructions there are to the first read of which only some bits are known.

        A turn has to begin there: what was read must not be kept from one turn to the next.
        """
        for read, (address, _value, live) in zip(loop.reads, reads, strict=True):
            if live and self._bus.count(address) is None:
                return loop.offsets[read.instruction][0]
        return 0

    def _go_on(self, instructions: int, target: int) -> tuple[Stop, bool]:
        """Execute some instructions; return how that stopped, and whether nothing else is to be done now."""
        due = self._due(target)
        if self._engine.cycle >= due:
            return _LIMIT, False
        stop = self._engine.run(due, instructions)
        return stop, self._went_on(stop, due)

    def _went_on(self, stop: Stop, due: int) -> bool:
        """Say whether nothing has happened in a run up to `due` but instructions; an access may have lowered that."""
        engine = self._engine
        return stop.kind is StopKind.LIMIT and not engine.reached_limit and engine.limit_cycle == due

    # --- one turn

    def _execute_step_by_step(self, head: int, target: int) -> tuple[Stop, _Reads, list[tuple[int, int]]]:
        """Execute until the program is at `head` again; return what it read, and where its instructions begin."""
        engine, bus = self._engine, self._bus
        began, cycle, writes = engine.instructions, engine.cycle, bus.writes
        offsets = [(0, 0)]
        bus.trace, engine.through_python = [], True
        try:
            for _ in range(_LONGEST_TURN):
                due = self._due(target)
                if engine.cycle >= due:
                    return _LIMIT, [], offsets
                stop = engine.run(due, 1)
                offsets.append((engine.instructions - began, engine.cycle - cycle))
                if not self._went_on(stop, due) or bus.writes != writes:
                    return stop, [], offsets
                if engine.pc() == head:
                    return stop, bus.trace, offsets
        finally:
            bus.trace, engine.through_python = None, False
        return _LIMIT, [], offsets

    def _execute(self, loop: CountingLoop, head: int, target: int) -> tuple[Stop, _Reads | None]:
        """Execute a turn; return what it read, or None if that was not a turn of this loop."""
        engine, bus = self._engine, self._bus
        began, cycle, writes = engine.instructions, engine.cycle, bus.writes
        due = self._due(target)
        if cycle >= due:
            return _LIMIT, None
        bus.trace, engine.through_python = [], True
        try:
            stop = engine.run(due, loop.instructions)
        finally:
            reads, bus.trace, engine.through_python = bus.trace, None, False
        is_turn = (
            self._went_on(stop, due)
            and bus.writes == writes
            and engine.instructions - began == loop.instructions
            and (isinstance(engine.timing, FlatTiming) or engine.cycle - cycle == loop.cycles)
            and engine.pc() == head
        )
        return stop, reads if is_turn else None

    def _understand(self, before: _Before, head: int, offsets: list[tuple[int, int]]) -> CountingLoop:
        """Return the loop of which a turn was executed.

        Raises:
            NotUnderstood: it is none, or not one that can be passed over.
        """
        turn = Follower(before, head)
        turn.at(SP)
        for _ in offsets[1:]:
            step(turn)
        if turn.pc != head or before.is_left or any(read.conditional for read in turn.reads):
            raise NotUnderstood("another way")
        loop = CountingLoop(turn)
        loop.instructions, loop.cycles = offsets[-1]
        loop.offsets = offsets
        found = {place: int(turn.graph.value[node]) for place, node in turn.ends.items()}
        if found != self._state(found):
            raise NotUnderstood("the engine has computed something else")
        return loop

    # --- many turns

    def _pass(self, loop: CountingLoop, head: int, before: _Reads, target: int) -> tuple[Stop, int]:
        """Execute a turn, and pass over as many as are the same way, but for one; that one is executed later."""
        stop, reads = self._execute(loop, head, target)
        given = None if reads is None else self._given(loop, before, reads)
        if given is None:
            return stop, 0
        due = min(self._due(target), given.until)
        most = self._engine.timing.periods_until(due, loop.instructions, loop.cycles)
        state = self._state(loop.starts)
        turns, end = self._same_way(loop, state, most, given)
        loop.usual_turns = turns
        if turns > 0:
            self._skip(loop, turns, end)
        return stop, turns

    def _given(self, loop: CountingLoop, before: _Reads, after: _Reads) -> _Given | None:
        """Return what each turn gets, judging by two; None if nobody knows."""
        if not len(loop.reads) == len(before) == len(after):
            return None
        given = _Given()
        for read, (address_before, before_, _live), (address, value, live) in zip(
            loop.reads, before, after, strict=True
        ):
            if not address_before == address == read.address:
                return None
            count = self._bus.count(address) if live else None
            if count is not None:
                given.counts[read] = count
                given.until = min(given.until, count.until)
                continue
            unknown = self._unknown(read) if live else 0
            if (before_ ^ value) & ~unknown:
                return None
            given.same[read.node] = value
            if unknown:
                given.unknown[read.node] = unknown
        return given

    def _unknown(self, read: RegisterRead) -> int:
        return self._bus.changing(read.address) >> 8 * (read.address & 3) & (1 << 8 * read.size) - 1

    def _same_way(self, loop: CountingLoop, state: State, most: int, given: _Given) -> tuple[int, State]:
        """Return how many turns can be passed over, and the state after them."""
        done, size = 0, min(max(loop.usual_turns, _FEWEST_TURNS), _MOST_TURNS)
        last: Turns | None = None
        last_size = 0
        while done < most:
            size = min(size, most - done)
            values: dict[Node, Any] = dict(given.same)
            for read, count in given.counts.items():
                values[read.node] = self._counted(loop, count, read, done, size)
            turns = Turns(loop, state, size, values, given.unknown)
            if turns.unknown:
                break
            if turns.same_way == 0 and last is not None:
                return done - 1, last.state_after(last_size - 1)
            if turns.same_way < size or done + size == most:
                leave = max(turns.same_way - 1, 0)
                return done + leave, turns.state_after(leave)
            state = turns.state_after(size)
            last, last_size = turns, size
            done += size
            size = min(size * _GROWTH, _MOST_TURNS)
        return 0, state

    def _counted(self, loop: CountingLoop, count: Count, read: RegisterRead, first: int, turns: int) -> Any:
        """Return what a counter gives in each turn."""
        import numpy as np

        instructions, cycles = loop.offsets[read.instruction]
        index = np.arange(first, first + turns, dtype=np.int64)
        cycle = self._cycle_ahead(index * loop.instructions + instructions, index * loop.cycles + cycles)
        value = count.at(cycle).view(np.uint64)
        return value if read.size == 4 else value >> 8 * (read.address & 3) & (1 << 8 * read.size) - 1

    def _cycle_ahead(self, instructions: Any, cycles: Any) -> Any:
        """Return the cycle at which begins what is so many instructions, and so many cycles of them, ahead."""
        engine = self._engine
        if isinstance(engine.timing, FlatTiming):
            return engine.timing.cycle(engine.instructions + instructions)
        return engine.cycle + cycles

    def _skip(self, loop: CountingLoop, turns: int, state: State) -> None:
        engine = self._engine
        instructions, cycles = turns * loop.instructions, turns * loop.cycles
        engine.skip_periods(self._cycle_ahead(instructions, cycles) + 1, loop.instructions, loop.cycles)
        flags = engine.get(Reg.XPSR)
        for place, value in state.items():
            if isinstance(place, tuple):
                address, size = place
                if address >= _RAM_BASE:
                    # code may be there: the turn that is executed next stores once more, by the CPU
                    at = address - _RAM_BASE
                    self._memory[at : at + size] = value.to_bytes(size, "little")
            elif place in FLAGS:
                flags = flags & ~(1 << place) | value << place
            elif place < Reg.SP or place == Reg.LR:
                engine.set(Reg(place), value)
        engine.set(Reg.XPSR, flags)

    # --- what there is

    def _due(self, target: int) -> int:
        due, alarm = self._time.next_cycle(), self._engine.alarm
        return min(target, alarm) if due is None else min(target, due, alarm)

    def _registers(self) -> tuple[int, ...]:
        return struct.unpack_from(f"<{len(Reg)}I", self._engine.fingerprint())

    def _state(self, places: Any) -> State:
        registers, memory, half = self._registers(), self._memory, self._engine.half
        return {place: _value_of(place, registers, memory, half) for place in places}


class _Before:
    """What a turn worked on."""

    def __init__(self, registers: Sequence[int], memory: bytes, reads: _Reads, half: Any) -> None:
        self.core_register = registers.__getitem__
        self.half = half
        self._memory = memory
        self._reads: Iterator[tuple[int, int, bool]] = iter(reads)

    @property
    def is_left(self) -> bool:
        """True if something was read that nobody has asked for."""
        return next(self._reads, None) is not None

    def memory(self, address: int, size: int) -> int | None:
        """Return what memory held, or None."""
        if address < _FLASH_END or _RAM_BASE <= address <= _RAM_BASE + len(self._memory) - size:
            return _in_memory(address, size, self._memory, self.half)
        return None

    def register(self, address: int, _size: int) -> int | None:
        """Return what the next read gave, if it is of this address."""
        read = next(self._reads, None)
        return read[1] if read is not None and read[0] == address else None


def _value_of(place: Place, registers: Sequence[int], memory: bytes | bytearray, half: Any) -> int:
    if isinstance(place, tuple):
        return _in_memory(*place, memory, half)
    if place in FLAGS:
        return bool(registers[Reg.XPSR] >> place & 1)
    return registers[place]


def _in_memory(address: int, size: int, memory: bytes | bytearray, half: Any) -> int:
    if address >= _RAM_BASE:
        at = address - _RAM_BASE
        return int.from_bytes(memory[at : at + size], "little")
    low = address & ~1
    around = b"".join(half(low + step).to_bytes(2, "little") for step in range(0, 6, 2))
    return int.from_bytes(around[address - low : address - low + size], "little")
