"""When a timer does something: its one event, its flags and requests, and what it lets out (RM0008 chapters 14, 15).

How it stays exact and cheap: the counter is arithmetic (`counting`), brought to the present cycle whenever something
happens. The timer has at most one event of its own in the queue: the next tick at which something becomes visible, a
flag that is still clear, a request, a trigger somebody listens to, an edge at a pin somebody listens at. So SR is exact
at any time without being computed, and a timer with all its flags set, running free, costs nothing.

What an event causes at the same cycle comes in this order: flags and interrupt lines, then requests, triggers and pins
as they arose.

Choice: any update event stops a timer in one-pulse mode, that of UG too.
"""

from __future__ import annotations

import abc
from collections import deque
from collections.abc import Callable, Iterable

from targets.mcu.registers import Peripheral, Register
from targets.mcu.services import DmaRequest, OutputSignal, Services, Watch
from targets.mcu.stm32.tim.breaks import BreakInput, Breaks
from targets.mcu.stm32.tim.counting import Compare, Counting
from targets.mcu.stm32.tim.inputs import TickClock
from targets.mcu.stm32.tim.kinds import KINDS, Kind
from targets.mcu.stm32.tim.outputs import Gate, OutputStage
from targets.mcu.stm32.tim.registers import (
    B2IF,
    BDTR,
    CC56_FLAGS,
    CC_FLAGS,
    CCDS,
    CEN,
    CR1,
    CR2,
    DIER,
    EVERY_OFFSET,
    MMS_COMPARE,
    MMS_ENABLE,
    MMS_UPDATE,
    MODES,
    OPM,
    SR,
    UDE,
    UIF,
)
from targets.mcu.stm32.tim.slave import GATED, SlaveController
from targets.mcu.timebase import Event

__all__ = ["TimerCore"]


class TimerCore(Peripheral, abc.ABC):
    """A timer without the ways to set it up, and without the reactions of `slave.Reactions`.

    Args:
        name: ``TIM1``.
        base: address.
        services: what the chip offers.
        kind: which registers it has, its bus, interrupts and masters; those of the STM32F1's timer if left out.
    """

    def __init__(self, name: str, base: int, services: Services, kind: Kind | None = None) -> None:
        self.kind = kind = kind or KINDS[name]
        super().__init__(name, base, services)
        # what it lacks reads as if it were never set
        resets = {offset: register.reset for offset, register in self.registers.items()}
        self._values = dict.fromkeys(EVERY_OFFSET, 0) | resets
        self._clock = TickClock(self.time)
        self._counting = Counting(
            self._on_update,
            self._on_match,
            self._before_ref,
            self._on_ref,
            self._edges_asked,
            bits=kind.bits,
            units=kind.compares,
        )
        self._queue: deque[tuple[Callable[..., None], tuple[object, ...]]] = deque()
        self._settling = False
        self._event: Event | None = None
        self._requests = 0
        self._advancing = False
        self._irqs = [(services.irq(number), mask) for mask, number in kind.irqs.items()]
        self._dma_update = self._dma("UP")
        self._dma_trigger = self._dma("TRIG")
        self._dma_com = self._dma("COM")
        self._dma_channels = [self._dma(f"CH{number}") for number in range(1, 5)]
        self._burst: DmaRequest | None = None
        self._burst_index = 0
        self._trgo = services.output(f"{name}_TRGO")
        self._gate = Gate(
            advanced=kind.advanced,
            cycle_of=self._clock.cycle_of,
            queue=lambda signal, level: self._queue.append((signal.set, (level,))),
        )
        self._stages = [self._stage(unit) for unit in self._counting.units[: kind.channels]]
        self._live_stages: list[OutputStage] = []
        self._trgo_is_live = False
        self._master = kind.master_mode or 0
        self._all_units = (1 << kind.compares) - 1
        self._slave = SlaveController(name, services, self._clock, kind.internal_triggers, self)
        self._breaks = Breaks(*self._break_inputs()) if kind.advanced else None
        self._trgo.refresh = self._refresh
        for signal in self._outputs():
            signal.on_watch = self._watched
        self._clock.change(services.clocks.timer(kind.bus))
        self._watched()

    def registers_of(self) -> Iterable[Register]:
        """Return the registers of this kind of timer."""
        return sorted(self.kind.registers, key=lambda register: register.offset)

    def _dma(self, request: str) -> DmaRequest:
        return self.services.dma(f"{self.name}_{request}") if self.kind.requests else _NoRequest()

    def _break_inputs(self) -> list[BreakInput]:
        names = ("BKIN", "BKIN2") if self.kind.second_break else ("BKIN",)
        inputs = [self.services.input(f"{self.name}_{name}") for name in names]
        return [BreakInput(signal, self._break_changed, second=index > 0) for index, signal in enumerate(inputs)]

    def _stage(self, unit: Compare) -> OutputStage:
        name = f"{self.name}_CH{unit.number + 1}"
        has_complement = self.kind.advanced and unit.number < self.kind.complements
        complement = self.services.output(f"{name}N") if has_complement else None
        event = self.services.output(f"{self.name}_CC{unit.number + 1}")
        return OutputStage(unit, self._gate, self.services.output(name), complement, event)

    def _outputs(self) -> list[OutputSignal]:
        all_of = [(stage.signal, stage.complement, stage.event) for stage in self._stages]
        return [signal for of_one in all_of for signal in of_one if signal is not None] + [self._trgo]

    # --- time

    def _sync(self) -> None:
        tick = self._clock.now
        if tick > self._counting.tick:
            self._advancing = True
            self._counting.advance(tick)
            self._advancing = False
        for stage in self._stages:
            stage.reach(tick)

    def _settle(self) -> None:
        """Bring interrupt lines and the event up to date, then let out what waits in the queue."""
        flags = self[SR]
        requests = (flags | (flags & B2IF) >> 1) & self[DIER]  # both breaks have one interrupt
        if requests != self._requests:
            self._requests = requests
            for line, mask in self._irqs:
                line.set(bool(requests & mask))
        self._plan()
        if self._settling:
            return
        self._settling = True
        try:
            while self._queue:
                action, arguments = self._queue.popleft()
                action(*arguments)
        finally:
            self._settling = False

    def _happened(self) -> None:
        self._event = None
        self._sync()
        self._settle()

    def _plan(self) -> None:
        tick = self._next_tick() if self._clock.cycles else None
        event = self._event
        if tick is None:
            self.time.cancel(event)
            self._event = None
            return
        cycle = self._clock.cycle_of(tick)
        if event is None or event.cycle != cycle:
            self.time.cancel(event)
            self._event = self.time.at(cycle, self._happened)

    def _next_tick(self) -> int | None:
        edges = 0
        ticks = []
        for stage in self._live_stages:
            if stage.follows:
                edges |= stage.bit
            if stage.due is not None:
                ticks.append(stage.due)
        mode = self._master_mode()
        if mode > MMS_COMPARE:
            edges |= 1 << (mode - 4)
        tick = self._counting.next_event(
            update=self._wants_update(mode), matches=self._wants_matches(mode), edges=edges
        )
        if tick is not None:
            ticks.append(tick)
        return min(ticks, default=None)

    def _master_mode(self) -> int:
        """Return MMS, or -1 while nobody listens to TRGO."""
        return self._master if self._trgo_is_live else -1

    def _wants_update(self, master_mode: int) -> bool:
        return (
            not self[SR] & UIF
            or bool(self[CR1] & OPM)
            or bool(self[DIER] & UDE)
            or master_mode == MMS_UPDATE
            or bool(self[CR2] & CCDS and self[DIER] & CC_FLAGS << 8)
            or (self._breaks is not None and self._breaks.waits_for_update)
            or any(unit.cleared for unit in self._counting.units)
        )

    def _wants_matches(self, master_mode: int) -> int:
        missing = ~self[SR]
        flags = missing & CC_FLAGS
        if not self[CR2] & CCDS:
            flags |= self[DIER] >> 8 & CC_FLAGS
        return (flags >> 1 | (missing & CC56_FLAGS) >> 12 | (master_mode == MMS_COMPARE)) & self._all_units

    # --- what the counter reports

    def _on_update(self) -> None:
        self[SR] |= UIF
        if self[DIER] & UDE:
            self._request(self._dma_update)
        self._updated()

    def _updated(self) -> None:
        """An update event, whether or not it sets UIF."""
        if self[CR2] & CCDS:
            for number in range(4):
                if self[DIER] & 0x200 << number:
                    self._request(self._dma_channels[number])
        if self._master_mode() == MMS_UPDATE:
            self._pulse_trgo()
        if self[CR1] & OPM and self[CR1] & CEN:
            self[CR1] &= ~CEN
            self._set_running()
        if self._breaks is not None and self._breaks.waits_for_update:
            self[BDTR] |= self._breaks.enable()
            self._set_main_enable()
        if self._slave.etrf_level():
            self._clear_by_etrf()

    def _on_match(self, units: int) -> None:
        self[SR] |= units << 1 & CC_FLAGS | units << 12 & CC56_FLAGS
        requested = units & self[DIER] >> 9
        if requested and not self[CR2] & CCDS:
            for number in range(4):
                if requested >> number & 1:
                    self._request(self._dma_channels[number])
        if units & 1 and self._master_mode() == MMS_COMPARE:
            self._pulse_trgo()

    def _before_ref(self, unit: Compare, tick: int) -> None:
        if unit.number < len(self._stages):
            self._stages[unit.number].reach(tick - 1)

    def _on_ref(self, unit: Compare, tick: int) -> None:
        # a counter that waits for its first clock is ahead; what software does to OCxREF meanwhile happens now
        tick = unit.since = min(tick, self._clock.now)
        if unit.number >= len(self._stages):
            return
        # the counter's edges fall at its ticks; others may fall in between, where the bus is faster than the timer
        self._stages[unit.number].changed(tick, self._clock.cycle_of(tick) if self._advancing else self.time.now)
        if self._master_mode() == 4 + unit.number:
            self._queue.append((self._trgo.set, (unit.out,)))

    def _request(self, request: DmaRequest) -> None:
        self._burst, self._burst_index = request, 0
        self._queue.append((request.pulse, ()))

    def _pulse_trgo(self) -> None:
        self._queue.append((self._trgo.set, (True,)))
        self._queue.append((self._trgo.set, (False,)))

    # --- outputs and who watches them

    def _watched(self) -> None:
        for stage in self._stages:
            stage.look_round()
        self._live_stages = [stage for stage in self._stages if stage.watch is Watch.LIVE]
        self._trgo_is_live = self._trgo.watch() is Watch.LIVE
        self._plan()

    def _edges_asked(self) -> int:
        return sum(stage.bit for stage in self._stages if stage.watch is not Watch.NOBODY and stage.follows)

    def _refresh(self) -> None:
        """Somebody wants the level or the record of a pin."""
        self._sync()
        for stage in self._stages:
            stage.show(self._clock.now)
        if self._trgo.watch() is Watch.NOBODY:
            self._trgo.set(self._trgo_level())

    def _trgo_level(self) -> bool:
        mode = self._master
        if mode == MMS_ENABLE:
            return bool(self[CR1] & CEN) and (self._slave.mode != GATED or self._slave.trigger_level())
        return mode > MMS_COMPARE and self._counting.units[mode - 4].out

    def _changed_outputs(self) -> None:
        tick = self._clock.now
        for stage in self._stages:
            stage.reach(tick)
            stage.changed(tick, self._clock.cycle_of(tick) if self._advancing else self.time.now)
            stage.offer(self._refresh)
        self._changed_trgo()

    def _changed_trgo(self) -> None:
        if self._trgo_is_live:
            self._queue.append((self._trgo.set, (self._trgo_level(),)))

    def _set_main_enable(self) -> None:
        gate, breaks = self._gate, self._breaks
        if breaks is not None:
            for stage in self._stages:
                stage.reach(self._clock.now)
            gate.off_state_run, gate.off_state_idle = breaks.off_states(self[BDTR])
            if gate.main_enable and not breaks.enabled(self[BDTR]):
                gate.idle_since = self._clock.now
            gate.main_enable = breaks.enabled(self[BDTR])
            self._changed_outputs()

    def _clear_by_etrf(self) -> None:
        for unit in self._counting.units:
            if self._mode_bits(unit.number) & 0x80:
                self._counting.clear(unit)

    def _mode_bits(self, number: int) -> int:
        """Return the byte of CCMRx for a channel."""
        return self[MODES[number >> 1]] >> 8 * (number & 1) & 0xFF

    def _set_running(self) -> None:
        slave = self._slave
        self._counting.running = (
            bool(self[CR1] & CEN) and not slave.external_clock and (slave.mode != GATED or slave.trigger_level())
        )

    # --- what an edge at an input does

    def begin(self) -> None:
        """Count up to the present cycle."""
        self._sync()

    def end(self) -> None:
        """Tell what has changed."""
        self._settle()

    @abc.abstractmethod
    def captured(self, number: int) -> None:
        """See `slave.Reactions`, for this and the others."""

    @abc.abstractmethod
    def triggered(self, level: bool) -> None:
        """TRGI has changed."""

    @abc.abstractmethod
    def counted(self) -> None:
        """A pulse of the external clock."""

    @abc.abstractmethod
    def turned(self, down: bool, counts: bool) -> None:
        """The encoder has moved."""

    @abc.abstractmethod
    def etrf_changed(self, level: bool) -> None:
        """ETRF has changed."""

    @abc.abstractmethod
    def _break_changed(self, source: BreakInput, level: bool) -> None:
        """A break input has changed."""


class _NoRequest:
    """A request to DMA of a timer that has none."""

    in_c = None

    def set(self, level: bool) -> None:
        """Do nothing."""

    def pulse(self) -> None:
        """Do nothing."""
