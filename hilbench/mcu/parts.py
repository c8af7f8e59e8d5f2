"""The parts of a bench, alive: called at each step of the world, when they are due, and when bytes come in."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial

from hilbench.bench import Bench
from hilbench.bench.world_runner import WorldRunner
from hilbench.benchfile.bench_file import Net, PartPlan
from hilbench.benchfile.order import late_quantities, order_of
from hilbench.benchfile.world_signals import WorldSignals
from hilbench.clock import Entry, EventClass
from hilbench.judging.provider import case_seed
from hilbench.links import Port
from hilbench.mcu.seams import Machine
from hilbench.mcu.terminals import AnalogPinOutput, PinInput, PinOutput
from targets.mcu.pins import Pin
from targets.parts import AnalogOutput, DigitalInput, DigitalOutput, Direction, Part, Ports, part_class

__all__ = ["Parts"]


OnEvent = Callable[[str, object], None]


class _Held:
    """An input that a supply holds."""

    def __init__(self, level: bool) -> None:
        self._level = level

    def level(self) -> bool:
        return self._level

    def level_at(self, ns: int) -> bool:
        del ns
        return self._level

    def mean(self, from_ns: int, to_ns: int) -> float:
        del from_ns, to_ns
        return float(self._level)

    def latch(self) -> bool:
        return self._level

    def changes(self, from_ns: int, to_ns: int) -> list[tuple[int, bool]]:
        del from_ns, to_ns
        return []

    def before_change(self, callback: Callable[[], None]) -> None:
        pass


class _Driven:
    """An output that leads nowhere or to a pin, and what was last put on it.

    Args:
        wire: where it leads; None for nowhere.
    """

    def __init__(self, wire: DigitalOutput | None = None) -> None:
        self.level: bool | None = None
        self._wire = wire

    def set(self, level: bool | None, at_ns: int) -> None:
        self.level = level
        if self._wire is not None:
            self._wire.set(level, at_ns)


class _Actor:
    """Calls one part when it is due."""

    def __init__(self, bench: Bench, name: str, taps: Sequence[OnEvent]) -> None:
        self._bench = bench
        self._name = name
        self._taps = taps
        self._entry: Entry | None = None
        self._entry_ns: int | None = None
        self.part: Part
        self.port: Port | None = None
        self.ahead_ns: int | None = None

    def tell(self, event: object) -> None:
        """Take an event of the part into the journal, at the time at which it was called."""
        if self.ahead_ns is None or self.ahead_ns <= self._bench.now_ns:
            self._record(event)
        else:
            action = partial(self._record, event)
            self._bench.scheduler.at(self.ahead_ns, action, order=EventClass.BYTE, source=self._name)

    def _record(self, event: object) -> None:
        self._bench.record_event(self._name, event)
        for tap in self._taps:
            tap(self._name, event)

    def send(self, data: bytes) -> None:
        """Put bytes of the part on its line."""
        self._bench.record("tx", self._name, data=data)
        if self.port is not None:
            self.port.write(data)

    def set_rate(self, baud: int) -> None:
        """Let the part's end of its line work at another rate."""
        if self.port is not None:
            self.port.baud = baud

    def attach(self, port: Port) -> None:
        """Give the part the end of a line."""
        self.port = port
        port.on_receive = self._received

    def settle(self) -> int | None:
        """Book the next call of the part, after it has been called; return when that is."""
        deadline_ns = self.part.next_deadline_ns()
        if self._entry is not None and deadline_ns == self._entry_ns:
            return deadline_ns
        if self._entry is not None:
            self._bench.scheduler.cancel(self._entry)
            self._entry = None
        if deadline_ns is not None:
            when_ns = max(deadline_ns, self._bench.now_ns)
            self._entry = self._bench.scheduler.at(when_ns, self._due, order=EventClass.TIMER, source=self._name)
            self._entry_ns = deadline_ns
        return deadline_ns

    def _due(self) -> None:
        self._entry = None
        self.part.advance(self._bench.now_ns)
        self.settle()

    def _received(self, data: bytes, at_ns: int) -> None:
        self._bench.record("rx", self._name, data=data)
        self.part.receive(data, at_ns)
        self.settle()


class Parts:
    """The parts of one bench.

    Args:
        bench: whose time they live in.
        plans: what to build.
        machines: the chips, by board.
        nets: what the wires join.
        seed: of everything random in them.

    Attributes:
        by_name: the parts.
        taps: called with the name of a part and each event of it, after it is in the journal.
        senses: whether the parts are shown the world after each step; False where a test shows them something else.
    """

    def __init__(
        self,
        bench: Bench,
        plans: Mapping[str, PartPlan],
        machines: Mapping[str, Machine],
        nets: Sequence[Net],
        *,
        seed: int,
    ) -> None:
        self.taps: list[OnEvent] = []
        self.senses = True
        self._bench = bench
        self._plans = plans
        self._signals: WorldSignals | None = None
        self._values: dict[str, float] = {}
        kinds = {name: part_class(plan.kind) for name, plan in plans.items()}
        self._order = order_of(plans, kinds)
        self._late = {name: late_quantities(kind) for name, kind in kinds.items()}
        self._acting = [name for name in self._order if _overrides(kinds[name], "feed", "before_step")]
        self._sensing = [name for name in plans if _overrides(kinds[name], "after_step", "next_deadline_ns")]
        self._given: dict[str, Mapping[str, float]] = {}
        self._given_before: dict[str, Mapping[str, float]] = {}
        self._actors = {name: _Actor(bench, name, self.taps) for name in plans}
        self._inputs: dict[str, dict[str, DigitalInput]] = {name: {} for name in plans}
        self._outputs: dict[str, dict[str, _Driven]] = {name: _open_outputs(plan) for name, plan in plans.items()}
        self._analogs: dict[str, dict[str, AnalogOutput]] = {name: {} for name in plans}
        self._analog_pins: dict[str, AnalogPinOutput] = {}
        for net in nets:
            self._connect(net, machines)
        self.by_name: dict[str, Part] = {name: self._make(name, plan, seed) for name, plan in plans.items()}

    def attach(self, name: str, port: Port) -> None:
        """Give a part the end of its line."""
        self._actors[name].attach(port)

    def join(self, runner: WorldRunner, wire: Callable[[Sequence[str]], WorldSignals]) -> None:
        """Let the parts drive and sense a vehicle, from the next step of its world on.

        Args:
            runner: who moves its world.
            wire: makes who reads and drives its signals, of the names of those that are read.
        """
        wanted = dict.fromkeys(
            plan.signals[quantity.name]
            for plan in self._plans.values()
            for quantity in part_class(plan.kind).QUANTITIES
            if quantity.direction is Direction.IN and quantity.name in plan.signals
        )
        self._signals = wire(list(wanted))
        self._values = self._signals.read()
        runner.before.append(self._before)
        runner.after.append(self._after)

    def power_on(self) -> None:
        """Switch every part on, now."""
        for name, part in self.by_name.items():
            part.power_on(self._bench.now_ns)
            self._actors[name].settle()

    def settle(self, name: str) -> int | None:
        """Book the next call of a part that was touched directly; return the bench time of it."""
        return self._actors[name].settle()

    @contextlib.contextmanager
    def ahead(self, name: str, now_ns: int) -> Iterator[None]:
        """Let a part be called at a time that the bench has not reached: what it tells belongs there."""
        actor = self._actors[name]
        actor.ahead_ns = now_ns
        try:
            yield
        finally:
            actor.ahead_ns = None

    def set(self, name: str, values: Mapping[str, float]) -> None:
        """Move controls of a part, now; raises `ValueError` as `targets.parts.Part.set` does."""
        self.by_name[name].set(values, self._bench.now_ns)
        self.settle(name)

    def show(self, name: str, values: Mapping[str, float]) -> None:
        """Show a part quantities as they are now, whatever the world is like; those by their own names."""
        now_ns = self._bench.now_ns
        self.by_name[name].after_step(now_ns, now_ns, values, values)
        self.settle(name)

    def driven(self, name: str, terminal: str) -> bool | None:
        """Return what a part drives at a terminal that goes out, wired or not, as far as it has said; None: nothing.

        Raises:
            KeyError: no such part, or no such terminal.
        """
        return self._outputs[name][terminal].level

    def volts(self) -> dict[str, float]:
        """Return the voltages that parts put on pins now, by pin: ``brain.PF12``; those that have put one."""
        now = {pin: output.volts for pin, output in self._analog_pins.items()}
        return {pin: volts for pin, volts in now.items() if volts is not None}

    # --- how they are connected

    def _connect(self, net: Net, machines: Mapping[str, Machine]) -> None:
        for end in net.terminals:
            kind = part_class(self._plans[end.part].kind)
            terminal = next(one for one in kind.TERMINALS if one.name == end.terminal)
            if terminal.analog:
                output = AnalogPinOutput(self._bench, *_pin(net, machines))
                self._analogs[end.part][end.terminal] = output
                self._analog_pins |= dict.fromkeys(map(str, net.pins), output)
            elif terminal.direction is Direction.OUT:
                self._outputs[end.part][end.terminal] = _Driven(PinOutput(*_pin(net, machines)))
            else:
                self._inputs[end.part][end.terminal] = self._input(net, machines)

    def _input(self, net: Net, machines: Mapping[str, Machine]) -> DigitalInput:
        if not net.pins:
            return _Held("3v3" in net.supplies)
        end = net.pins[0]
        return PinInput(self._bench, machines[end.board].chip.pins[end.pin])

    def _make(self, name: str, plan: PartPlan, seed: int) -> Part:
        actor = self._actors[name]
        ports = Ports(
            inputs=self._inputs[name],
            outputs=self._outputs[name],
            analogs=self._analogs[name],
            serial=actor.send,
            rate=actor.set_rate,
            tell=actor.tell,
        )
        actor.part = part_class(plan.kind)(plan.settings, ports, seed=case_seed(seed, f"part {name}"))
        return actor.part

    # --- the world's steps

    def _before(self, now_ns: int, next_ns: int) -> None:
        assert self._signals is not None
        self._given_before, self._given = self._given, {}
        for name in self._acting:
            part, signals = self.by_name[name], self._plans[name].signals
            part.feed(_seen(signals, self._values) | self._taken(name))
            self._given[name] = given = part.before_step(now_ns, next_ns)
            for quantity, value in given.items():
                if quantity in signals:
                    self._signals.drive(signals[quantity], value)

    def _taken(self, name: str) -> dict[str, float]:
        """What other parts give a part for the coming step, or gave it for the last one where it takes that late."""
        late = self._late[name]
        return {
            quantity: self._given_before.get(end.part, {}).get(end.quantity, 0.0)
            if quantity in late
            else self._given[end.part][end.quantity]
            for quantity, end in self._plans[name].sources.items()
        }

    def _after(self, now_ns: int, next_ns: int) -> None:
        assert self._signals is not None
        before, self._values = self._values, self._signals.read()
        if not self.senses:
            return
        for name in self._sensing:
            part, signals, taken = self.by_name[name], self._plans[name].signals, self._taken(name)
            part.after_step(now_ns, next_ns, _seen(signals, before) | taken, _seen(signals, self._values) | taken)
            self._actors[name].settle()


def _overrides(kind: type[Part], *methods: str) -> bool:
    """Whether a kind does something of its own in one of these calls, which are made at each step."""
    return any(getattr(kind, method) is not getattr(Part, method) for method in methods)


def _open_outputs(plan: PartPlan) -> dict[str, _Driven]:
    terminals = part_class(plan.kind).TERMINALS
    return {terminal.name: _Driven() for terminal in terminals if terminal.direction is Direction.OUT}


def _pin(net: Net, machines: Mapping[str, Machine]) -> tuple[Machine, Pin]:
    end = net.pins[0]
    machine = machines[end.board]
    return machine, machine.chip.pins[end.pin]


def _seen(signals: Mapping[str, str], values: Mapping[str, float]) -> dict[str, float]:
    return {quantity: values[signal] for quantity, signal in signals.items() if signal in values}
