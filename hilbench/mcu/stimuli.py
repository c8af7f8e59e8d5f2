"""Does stimuli: drives pins, sends bytes, pushes buttons, at their bench time.

What happens to a pin happens at the first cycle of its chip that is not before the time. Bytes follow each other at the
rate of the line. What one stimulus does to a pin or a bus ends with the next one for the same. Each is an event of the
journal.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from fractions import Fraction
from functools import partial
from itertools import count

from hilbench.bench import Bench
from hilbench.benchfile.bench_file import BenchFile, PinEnd, TerminalEnd, is_checker_end
from hilbench.benchfile.stimulus import Hold, Ramp, Reset, Send, Square, Stick, Stimulus
from hilbench.clock import NS_PER_S, EventClass
from hilbench.errors import UsageError
from hilbench.mcu.far_ends import FarEnds
from hilbench.mcu.seams import Machine
from targets.mcu.pins import Pin
from targets.parts import Direction, part_class

__all__ = ["Stimuli"]

Course = Iterator[tuple[int, bool | float | None]]
"""Bench times in ns, and what is on a pin from each of them on: a level, volts, or nothing."""


class Stimuli:
    """See the module.

    Args:
        bench: whose time it is.
        bench_file: what is wired to what.
        machines: the chips, by board.
        far_ends: of the USARTs' lines.
    """

    def __init__(self, bench: Bench, bench_file: BenchFile, machines: Mapping[str, Machine], far_ends: FarEnds) -> None:
        self._bench = bench
        self._bench_file = bench_file
        self._machines = machines
        self._far_ends = far_ends
        self._turns: dict[tuple[str, str], int] = {}

    def add(self, stimulus: Stimulus) -> None:
        """Have a stimulus happen, its time counted from now on.

        Raises:
            UsageError: something on the bench drives that pin or has that line already, or the chip has no such bus.
        """
        self._check(stimulus)
        self._book(stimulus, self._bench.now_ns + stimulus.at_ns, stimulus.times)

    # --- what cannot be done

    def _check(self, stimulus: Stimulus) -> None:
        board, target = stimulus.board, stimulus.target
        by = ""
        if isinstance(stimulus.action, Send):
            by = self._who_has_line(f"{board}.{target}")
        elif isinstance(stimulus.action, Stick):
            if target.upper() not in self._machines[board].chip.i2cs:
                raise UsageError(f"{board} has no modelled I2C interface '{target}'", where=stimulus.text)
        elif not isinstance(stimulus.action, Reset):
            by = self._who_drives(PinEnd(board=board, pin=target))
        if by:
            raise UsageError(f"{by} already", where=stimulus.text, hint="take that out of the bench file")

    def _who_has_line(self, end: str) -> str:
        for link in self._bench_file.links:
            others = [other for other in link.ends if other != end]
            if end in link.ends and not any(map(is_checker_end, others)):
                return f"{' and '.join(others)} sends on the line of {end}"
        return ""

    def _who_drives(self, pin: PinEnd) -> str:
        for net in self._bench_file.nets:
            if pin in net.pins:
                drivers = [*net.supplies, *(str(end) for end in net.terminals if self._is_output(end))]
                return f"{drivers[0]} drives {pin}" if drivers else ""
        return ""

    def _is_output(self, end: TerminalEnd) -> bool:
        terminals = part_class(self._bench_file.parts[end.part].kind).TERMINALS
        return any(one.name == end.terminal and one.direction is Direction.OUT for one in terminals)

    # --- when

    def _book(self, stimulus: Stimulus, ns: int, times: int) -> None:
        begin = self._begins(stimulus, ns)
        if begin is not None:  # in the chip's own time, which is exact
            self._machines[stimulus.board].at_ns(ns, begin)
        act = partial(self._happen, stimulus, ns, times)
        self._bench.scheduler.at(ns, act, order=EventClass.INPUT, source=f"{stimulus.board}.{stimulus.target}")

    def _happen(self, stimulus: Stimulus, ns: int, times: int) -> None:
        name = f"{stimulus.board}.{stimulus.target}"
        self._bench.record("stimulus", name, text=stimulus.text)
        if isinstance(stimulus.action, Send):
            self._far_ends[name].write(stimulus.action.data)
        if stimulus.every_ns and times != 1:
            self._book(stimulus, ns + stimulus.every_ns, max(times - 1, 0))

    def _begins(self, stimulus: Stimulus, ns: int) -> Callable[[], None] | None:
        """Return what happens to the chip; None where it is told by its line."""
        machine, action = self._machines[stimulus.board], stimulus.action
        match action:
            case Send():
                return None
            case Reset():
                return partial(machine.reset, "PIN")
            case Stick():
                return partial(self._stick, stimulus.board, stimulus.target, action)
            case Ramp():
                return partial(self._ramp, stimulus.board, stimulus.target, action)
            case Hold() | Square():
                return partial(self._begin, stimulus.board, stimulus.target, _course(action, ns))

    # --- what

    def _begin(self, board: str, name: str, course: Course) -> None:
        self._go_on(board, name, self._next_turn(board, name), course)

    def _ramp(self, board: str, name: str, ramp: Ramp) -> None:
        self._next_turn(board, name)
        self._machines[board].chip.pins[name].drive_ramp(ramp.from_volts, ramp.to_volts, in_ns=ramp.in_ns)

    def _next_turn(self, board: str, name: str) -> int:
        turn = self._turns[board, name] = self._turns.get((board, name), 0) + 1
        return turn

    def _go_on(self, board: str, name: str, turn: int, course: Course) -> None:
        machine = self._machines[board]
        for ns, value in course:
            if ns > machine.now_ns:
                machine.at_ns(ns, partial(self._put, board, name, turn, value, course))
                return
            _drive(machine.chip.pins[name], value)

    def _put(self, board: str, name: str, turn: int, value: bool | float | None, course: Course) -> None:
        if self._turns[board, name] == turn:
            _drive(self._machines[board].chip.pins[name], value)
            self._go_on(board, name, turn, course)

    def _stick(self, board: str, interface: str, action: Stick) -> None:
        machine = self._machines[board]
        bus = machine.chip.i2cs[interface.upper()].bus
        turn = self._next_turn(board, interface)
        (bus.stick if action.stuck else bus.unstick)()

        def let_go() -> None:
            if self._turns[board, interface] == turn:
                bus.unstick()

        if action.for_ns:
            machine.at_ns(machine.now_ns + action.for_ns, let_go)


def _drive(pin: Pin, value: bool | float | None) -> None:
    if isinstance(value, float):
        pin.drive_volts(value)
    else:
        pin.drive(value)


def _course(action: Hold | Square, ns: int) -> Course:
    if isinstance(action, Hold):
        yield ns, action.value
    else:
        yield from _wave(action, ns)
    if action.for_ns:
        yield ns + action.for_ns, None


def _wave(square: Square, ns: int) -> Course:
    period_ns = Fraction(NS_PER_S) / square.hz
    end_ns = ns + square.for_ns if square.for_ns else None
    for edge in count():
        periods, low = divmod(edge, 2)
        at_ns = ns + int(period_ns * (periods + square.duty * low))
        if end_ns is not None and at_ns >= end_ns:
            return
        yield at_ns, not low
