"""Low-power timer (RM0410 section 26, RM0433 section 43; the same block in F4, L0, L4, G0, G4, WB).

Registers stand in the domain of the bus; counter and comparators run on the kernel clock that RCC chooses, or on the
edges at IN1. Latencies, where the manual names them or somebody has measured them on silicon of this block:

* The counter clock is the kernel clock behind the prescaler, which runs from ENABLE on; two of its edges after ENABLE
  the timer is enabled ("timer enable").
* ARR and CMP come to the comparators with the third counter clock after the write, and ARROK and CMPOK rise then: two
  to three periods, measured at prescalers 1 and 32 (a G0, whose block has the same registers as the H7's).
* A start by software takes three kernel clocks (RM0440, trigger multiplexer), one by a trigger two counter clocks.
  With the two of ENABLE these are the five edges at IN1 that the manual says are lost.
* COUNTRST acts with the third kernel clock.

Choices: SNGSTRT and CNTSTRT read 1 until the counter starts. Clearing ENABLE stops and clears the counter, and keeps
ARR, CMP and the flags. CNT can always be read; silicon may give nonsense while a clock of its own moves it. CFGR that
is written while ENABLE is set is kept and takes effect with the next ENABLE (a G0 keeps it, too); IER works at once.
ARR and CMP that are written while it is clear are lost. A write to ARR or CMP before the flag of the one before has
risen takes its place. The first direction of the encoder is up. With PRELOAD the flag rises when the value is there,
not when it comes into force. A level at an input that is sampled holds for as many kernel clocks as CKFLT or TRGFLT
say, one without a filter; a trigger without a filter is taken at once.

Not modelled: what silicon does with forbidden settings (they are noted), the autonomous mode of D3, and DBG_LPTIM_STOP,
for time itself stands still while a debugger halts the core.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from types import MappingProxyType

from targets.mcu.fidelity import Fidelity
from targets.mcu.registers import Peripheral, Register
from targets.mcu.services import InputSignal, Services, Watch
from targets.mcu.stm32.lptim_counter import LptimCounter
from targets.mcu.stm32.ticks import Edges, Ticks

__all__ = ["LowPowerTimer", "LptimKind", "inside"]

ISR, ICR, IER, CFGR, CR, CMP, ARR, CNT, CFGR2 = 0x00, 0x04, 0x08, 0x0C, 0x10, 0x14, 0x18, 0x1C, 0x24

EXTTRIG, CMPOK, ARROK, UP, DOWN = 1 << 2, 1 << 3, 1 << 4, 1 << 5, 1 << 6
ENABLE, SNGSTRT, CNTSTRT, COUNTRST, RSTARE = (1 << bit for bit in range(5))
CKSEL, TIMOUT, WAVE, WAVPOL, PRELOAD, COUNTMODE, ENC = 1 << 0, *(1 << bit for bit in range(19, 25))
IN1SEL, IN2SEL = 0xF, 0xF0

ENABLED_AFTER, WRITTEN_AFTER, TRIGGERED_AFTER = 2, 3, 2  # counter clocks
STARTED_AFTER, CLEARED_AFTER = 3, 3  # kernel clocks
_SAMPLES = (0, 2, 4, 8)
"""By CKFLT and TRGFLT."""
_RISING, _FALLING = 1, 2


@dataclass(frozen=True, slots=True, kw_only=True)
class LptimKind:
    """What one of them has.

    Attributes:
        irq: number of its interrupt.
        bus: on which its registers are.
        encoder: whether it has encoder mode, and IN2.
        reset_bits: whether it has COUNTRST and RSTARE.
        inputs: the bits of CFGR2; 0 where there is no such register.
        pin_input: whether its IN1 comes from a pin where CFGR2 chooses 0.
        triggers: by TRIGSEL, input signals.
        missing: by TRIGSEL, what is connected there and not modelled.
        wake_line: the line of EXTI that its interrupt drives; empty for none.
        output_line: the line of EXTI that its output drives; empty for none.
    """

    irq: int
    bus: str = "APB1"
    encoder: bool = True
    reset_bits: bool = False
    inputs: int = 0
    pin_input: bool = True
    triggers: Mapping[int, str]
    missing: Mapping[int, str] = field(default_factory=lambda: MappingProxyType({}))
    wake_line: str = ""
    output_line: str = ""


def inside(name: str) -> str:
    """Return the signal that carries the output of a timer to other blocks, whatever pins do: ``lptim2_out``."""
    return f"{name.lower()}_out"


def _registers(kind: LptimKind) -> Iterator[Register]:
    flags = 0x7F if kind.encoder else 0x1F
    yield Register("ISR", ISR, 0, 0)
    yield Register("ICR", ICR, 0, flags)
    yield Register("IER", IER, 0, flags)
    settings = 0x00FE_EEDF | (ENC if kind.encoder else 0)
    missing = f"triggers that never come: {', '.join(kind.missing.values())}"
    yield Register("CFGR", CFGR, 0, settings, fidelity=Fidelity.PARTLY, note=missing)
    yield Register("CR", CR, 0, 0x1F if kind.reset_bits else 0x07)
    yield Register("CMP", CMP, 0, 0xFFFF)
    yield Register("ARR", ARR, 1, 0xFFFF)
    yield Register("CNT", CNT, 0, 0, live=True, note="every read is right, whatever the clocks")
    if kind.inputs:
        only_pins = "inputs that come from no pin stay low"
        yield Register("CFGR2", CFGR2, 0, kind.inputs, fidelity=Fidelity.PARTLY, note=only_pins)


class LowPowerTimer(Peripheral):
    """A low-power timer.

    Args:
        name: ``LPTIM1``.
        base: address of its first register.
        services: what the chip offers. Used: output signals NAME_OUT and that of `inside`; input signals NAME_IN1,
            NAME_IN2 and those of the triggers.
        kind: what it has.
        kernel_hz: returns the rate of its kernel clock, in Stop mode too; 0 while it stands still.
        wakes: says whether its interrupt may reach the NVIC by itself in Stop mode.
    """

    def __init__(
        self,
        name: str,
        base: int,
        services: Services,
        kind: LptimKind,
        *,
        kernel_hz: Callable[[], Fraction],
        wakes: Callable[[], bool] = lambda: False,
    ) -> None:
        self._kind = kind
        super().__init__(name, base, services)
        self._kernel = Ticks(self.time, lambda: kernel_hz() if self.clocked else None)
        self._clock: Ticks | Edges = self._kernel
        self._counter = LptimCounter()
        self._requests = 0
        self._forget()
        self._wakes = wakes
        self._irq = services.irq(kind.irq)
        self._wake_line = services.output(kind.wake_line) if kind.wake_line else None
        outputs = (f"{name}_OUT", inside(name), *((kind.output_line,) if kind.output_line else ()))
        self._outputs = tuple(services.output(output) for output in outputs)
        for output in self._outputs:
            output.refresh = output.on_watch = self._follow
        self._in1 = _Input("IN1", services.input(f"{name}_IN1"), self._kernel, lambda _level: self._input_changed(1))
        self._in2 = _Input("IN2", services.input(f"{name}_IN2"), self._kernel, lambda _level: self._input_changed(2))
        triggers = {number: services.input(signal) for number, signal in kind.triggers.items()}
        self._triggers = {
            number: _Input(f"trigger {number}", signal, self._kernel, self._trigger_changed)
            for number, signal in triggers.items()
        }

    def registers_of(self) -> Iterator[Register]:
        """Return the registers."""
        return _registers(self._kind)

    def _forget(self) -> None:
        """Be as it is while ENABLE is clear."""
        self._settings = 0  # CFGR as it was when ENABLE was set
        self._origin = 0  # the tick at which the prescaler began
        self._settled = 0  # counter clocks that the counter has seen
        self._up = True
        self._armed = self._triggered = False

    # --- what the chip calls

    def reset(self) -> None:
        """Go to the state after reset."""
        self._disable()
        super().reset()
        self._counter.reload, self._counter.compare = 1, 0
        self._requests = 0
        self._drive()
        self._show()

    def before_clock_change(self) -> None:
        """Count up to now."""
        self._settle()

    def after_clock_change(self) -> None:
        """Go on at the new rate, which may be none; and perhaps Stop has ended."""
        self._kernel.refresh()
        self._drive()

    # --- flags and interrupts

    def read_ICR(self) -> int:
        """Write-only."""
        return 0

    def write_ICR(self, value: int) -> None:
        """Clear flags by writing 1, at once."""
        self._settle()
        self[ISR] &= ~value
        self._requests &= ~value
        self._plan()
        self._drive()

    def write_IER(self, value: int) -> None:
        """Enable interrupts; one whose flag is set already is not asserted (RM0410 section 26.6)."""
        if self[CR] & ENABLE and value != self[IER]:
            self.note("misuse", "IER", "may be written only while ENABLE is clear; here it works at once")
        self._settle()
        self[IER] = value
        self._requests &= value
        self._plan()
        self._drive()

    def _raise(self, flags: int) -> None:
        if flags:
            self[ISR] |= flags
            self._requests |= flags & self[IER]
            self._drive()

    def _drive(self) -> None:
        wanted = bool(self._requests)
        if self._wake_line is not None:
            self._wake_line.set(wanted)
        stopped = not self.services.clocks.pclk(self._kind.bus)
        self._irq.set(wanted and (not stopped or self._wakes()))

    # --- settings

    def write_CFGR(self, value: int) -> None:
        """Keep the settings; only the polarity of the output acts at once, even before ENABLE."""
        if self[CR] & ENABLE and value != self[CFGR]:
            self.note(
                "misuse", "CFGR", "may be written only while ENABLE is clear; it takes effect with the next ENABLE"
            )
        self[CFGR] = value
        self._show()

    def write_CFGR2(self, value: int) -> None:
        """Choose where the inputs come from."""
        if self[CR] & ENABLE and value != self[CFGR2]:
            self.note(
                "misuse", "CFGR2", "may be written only while ENABLE is clear; it takes effect with the next ENABLE"
            )
        self[CFGR2] = value

    def _check_settings(self) -> None:
        """Note what cannot work."""
        settings = self._settings
        if settings >> 1 & 3 == 3:
            self.note("misuse", "CFGR.CKPOL", "3 is not allowed; nothing counts")
        if settings & (ENC | COUNTMODE) and not settings & CKSEL and settings & 0xE00:
            self.note("misuse", "CFGR.PRESC", "has to be 0 where edges at inputs count (COUNTMODE, ENC); it is ignored")
        if settings & ENC and settings & CKSEL:
            self.note("misuse", "CFGR.ENC", "encoder mode needs the internal clock (CKSEL = 0); it is ignored")
        if settings & CKSEL and settings >> 1 & 3 == 2:
            self.note("misuse", "CFGR.CKPOL", "both edges need the internal clock (CKSEL = 0); here both are clocks")
        if not self._kernel.runs and (not settings & CKSEL or settings & 0xD8):
            text = "the kernel clock that RCC chooses stands still: nothing counts, ARROK and CMPOK do not rise"
            self.note("misuse", "CR.ENABLE", text)
        source = settings >> 13 & 7
        if settings >> 17 & 3 and source not in self._triggers:
            name = self._kind.missing.get(source, "nothing")
            self.note(
                "unmodelled", "CFGR.TRIGSEL", f"trigger {source} is {name}, which is not modelled: it never comes"
            )
        chosen = self[CFGR2] if self._kind.inputs else 0
        if (chosen or not self._kind.pin_input) and settings & (CKSEL | COUNTMODE | ENC):
            text = f"CFGR2 = 0x{chosen:X}: inputs that come from no pin are not modelled: they stay low"
            self.note("unmodelled", "CFGR2", text)

    # --- control

    def write_CR(self, value: int) -> None:
        """Enable, start, clear the counter."""
        on = self[CR] & ENABLE
        if not on and value & ~ENABLE:
            self.note("misuse", "CR", "all bits but ENABLE are discarded while ENABLE is clear")
        if not value & ENABLE:
            if on:
                self._note_lost_values()
                self._disable()
            return
        if not on:
            self[CR] = ENABLE
            self._enable()
            return
        self._settle()
        self[CR] = self[CR] & ~RSTARE | value & RSTARE
        if value & COUNTRST and not self[CR] & COUNTRST:
            self[CR] |= COUNTRST
            self._clock.after("COUNTRST", CLEARED_AFTER, self._reset_counter)
        elif value & COUNTRST:
            self.note("misuse", "CR.COUNTRST", "was set while it was set; the second time has no effect")
        if value & (SNGSTRT | CNTSTRT):
            self._ask_start(single=not value & CNTSTRT)
        self._plan()

    def _enable(self) -> None:
        self._settings = settings = self[CFGR]
        self._check_settings()
        self._clock = Edges() if settings & CKSEL else self._kernel
        self._origin = self._clock.now()
        self._settled = 0
        from_pins = self._kind.pin_input and not (self._kind.inputs and self[CFGR2])
        filtered = _SAMPLES[settings >> 3 & 3]
        if settings & (CKSEL | COUNTMODE | ENC) and from_pins:
            self._in1.listen(filtered if settings & CKSEL else max(filtered, 1))
        if self._encodes and from_pins:
            self._in2.listen(max(filtered, 1))
        source = self._triggers.get(settings >> 13 & 7)
        if settings >> 17 & 3 and source is not None:
            source.listen(_SAMPLES[settings >> 6 & 3])
        self._show()

    def _note_lost_values(self) -> None:
        for name in filter(self._clock.due, ("ARR", "CMP")):
            text = f"was written, and ENABLE cleared before {name}OK: it reads as written, the value before holds"
            self.note("misuse", name, text)

    def _disable(self) -> None:
        self._settle()
        for one in (self._in1, self._in2, *self._triggers.values()):
            one.listen(None)
        self._clock.forget_all()
        self._kernel.forget_all()
        self._clock = self._kernel
        self._counter.clear()
        self[CR] = 0
        self._forget()
        self._show()

    @property
    def _encodes(self) -> bool:
        return bool(self._settings & ENC and not self._settings & CKSEL)

    @property
    def _counts_edges(self) -> bool:
        """Whether sampled edges count, not the clock itself."""
        return bool(self._settings & (COUNTMODE | ENC) and not self._settings & CKSEL)

    # --- the counter clock

    @property
    def _prescaler(self) -> int:
        return 1 if self._counts_edges else 1 << (self._settings >> 9 & 7)

    def _clocks(self, tick: int) -> int:
        """Return the edges of the counter clock up to a tick."""
        return (tick - self._origin) // self._prescaler

    def _tick(self, clocks: int) -> int:
        return self._origin + clocks * self._prescaler

    def _later(self, clocks: int) -> int:
        """Return the tick of an edge of the counter clock, so many after now or after the timer is enabled."""
        return self._tick(max(self._clocks(self._clock.now()), ENABLED_AFTER) + clocks)

    def _settle(self, tick: int | None = None) -> None:
        """Let the counter see all edges up to now, or up to a tick before."""
        if not self[CR] & ENABLE or self._counts_edges:
            return
        clocks = self._clocks(self._clock.now() if tick is None else tick)
        if clocks > self._settled:
            steps, self._settled = clocks - self._settled, clocks
            self._raise(self._counter.advance(steps))

    def _plan(self) -> None:
        """Wait for the next thing that the counter does and anybody can see."""
        watched = any(output.watch() is not Watch.NOBODY for output in self._outputs)
        wanted = 0b11 & (~self[ISR] | self[IER] & ~self._requests)
        steps = None if self._counts_edges else self._counter.steps_to_event(wanted, output=watched)
        if steps is None:
            self._clock.forget("count")
        else:
            self._clock.at("count", self._tick(self._settled + steps), self._follow)

    def _follow(self) -> None:
        """Bring everything up to now."""
        self._settle()
        self._show()
        self._plan()

    def _show(self) -> None:
        """Drive the output."""
        counter = self._counter
        high = counter.rose if self._settings & WAVE else counter.high
        level = high is not bool(self[CFGR] & WAVPOL)
        for output in self._outputs:
            output.set(level)

    # --- starting

    def _ask_start(self, *, single: bool) -> None:
        counter = self._counter
        counter.single = single
        if counter.running:
            return
        self[CR] = self[CR] & ~(SNGSTRT | CNTSTRT) | (SNGSTRT if single else CNTSTRT)
        if self._settings >> 17 & 3:
            self._armed = True
            return
        ready = max(self._clock.now(), self._tick(ENABLED_AFTER))
        self._start_at(ready + STARTED_AFTER)

    def _start_at(self, tick: int) -> None:
        def start() -> None:
            self[CR] &= ~(SNGSTRT | CNTSTRT)
            self._settle(tick)
            self._settled = self._clocks(tick)
            self._counter.restart()
            self._counter.running = True
            self._follow()

        self._clock.at("start", tick, start)

    def _reset_counter(self) -> None:
        self._settle()
        self[CR] &= ~COUNTRST
        self._counter.restart()
        self._follow()

    def _trigger_changed(self, level: bool) -> None:
        """An edge at the chosen trigger."""
        if not self._settings >> 17 & (_RISING if level else _FALLING):
            return
        self._settle()
        if self._counter.running:
            if self._settings & TIMOUT:
                self._raise(EXTTRIG)
                self._start_at(self._later(TRIGGERED_AFTER))
        elif self._armed and not (self._triggered and self._settings & WAVE):
            self._triggered = True
            self._raise(EXTTRIG)
            self._start_at(self._later(TRIGGERED_AFTER))

    # --- counting what comes in

    def _input_changed(self, number: int) -> None:
        """A level at an input was accepted."""
        edges = self._settings >> 1 & 3
        if self._encodes:
            self._encode(number, edges)
            return
        if number == 2 or not (edges == 2 or edges == (0 if self._in1.level else 1)):
            return
        if isinstance(self._clock, Edges):
            self._clock.step()
            self._settle()
        else:
            self._raise(self._counter.advance(1))
        self._show()
        self._plan()

    def _encode(self, number: int, edges: int) -> None:
        own, other = (self._in1, self._in2) if number == 1 else (self._in2, self._in1)
        if not self._counter.running or not (edges == 2 or edges == (0 if own.level else 1)):
            return
        up = (own.level is other.level) is (number == 2)
        if up is not self._up:
            self._up = up
            self._raise(UP if up else DOWN)
        self._raise(self._counter.step(up=up))
        self._show()

    # --- values

    def write_ARR(self, value: int) -> None:
        """Set the end of the period."""
        self._write_value(ARR, ARROK, value)

    def write_CMP(self, value: int) -> None:
        """Set the value that matches."""
        self._write_value(CMP, CMPOK, value)

    def _write_value(self, offset: int, flag: int, value: int) -> None:
        name = self.registers[offset].name
        if not self[CR] & ENABLE:
            self.note("misuse", name, "may be written only while ENABLE is set; the value is lost")
            return
        self[offset] = value
        tick = self._later(WRITTEN_AFTER)
        if self._clock.due(name):
            self.note("misuse", name, f"was written before the {name}OK of the write before; the later value counts")

        def arrive() -> None:
            self._settle(tick)
            self._take(offset, value)
            self._raise(flag)
            self._follow()

        self._clock.at(name, tick, arrive)

    def _take(self, offset: int, value: int) -> None:
        """Give a value to its comparator, or let it wait there."""
        counter = self._counter
        if self._settings & PRELOAD and counter.running:
            reload, compare = counter.later
            counter.later = (value, compare) if offset == ARR else (reload, value)
        elif offset == ARR:
            counter.reload = value
        else:
            counter.set_compare(value)

    def read_CNT(self) -> int:
        """Return the counter; RSTARE clears it with that."""
        self._settle()
        count = self._counter.count
        if self[CR] & RSTARE:
            self._counter.restart()
            self._follow()
        return count


class _Input:
    """An input with its glitch filter.

    Args:
        name: which.
        signal: what comes in.
        ticks: the clock that samples it.
        on_level: called with each level that was accepted.

    Attributes:
        level: as accepted.
    """

    def __init__(self, name: str, signal: InputSignal, ticks: Ticks, on_level: Callable[[bool], None]) -> None:
        self.level = False
        self._name = name
        self._signal = signal
        self._ticks = ticks
        self._on_level = on_level
        self._samples = 0

    def listen(self, samples: int | None) -> None:
        """Accept a level that so many samples see, 0 for at once; None: nobody listens."""
        self._samples = samples or 0
        callback = None if samples is None else self._changed
        if self._signal.on_change != callback:
            self._signal.on_change = callback
        self.level = callback is not None and self._signal.level()

    def _changed(self, level: bool) -> None:
        if level is self.level:
            self._ticks.forget(self._name)
        elif self._samples:
            self._ticks.after(self._name, self._samples, self._accept)
        else:
            self._accept()

    def _accept(self) -> None:
        self.level = not self.level
        self._on_level(self.level)
