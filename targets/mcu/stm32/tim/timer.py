"""Timers: the registers (RM0008 sections 14.4 and 15.4; RM0410 sections 25.4, 26.4, 27.4 and 28.4)."""

from __future__ import annotations

from targets.mcu.registers import Count
from targets.mcu.stm32.tim.effects import TimerEffects
from targets.mcu.stm32.tim.registers import (
    AF1,
    AF2,
    ARPE,
    ARR,
    B2G,
    B2IF,
    BDTR,
    BG,
    BIF,
    CCER,
    CCMR1,
    CCMR2,
    CCMR3,
    CCR1,
    CEN,
    CKD,
    CNT,
    COMDE,
    COMG,
    COMPARES,
    CR1,
    CR2,
    DCR,
    DIER,
    DIR,
    DMAR,
    ECE,
    PSC,
    RCR,
    SMCR,
    SR,
    TDE,
    TG,
    TIF,
    UDE,
    UDIS,
    UG,
    UIF,
    UIFCPY,
    UIFREMAP,
)
from targets.mcu.stm32.tim.slave import ENCODER_MODES, RESET_AND_TRIGGER

__all__ = ["Timer"]

_IDLE_STATES = 0x5_7F00  # of CR2


class Timer(TimerEffects):
    """One timer: ``Timer("TIM2", 0x4000_0000, services)``, or with its kind, ``F7_KINDS["TIM2"]``.

    Signals: inputs ``TIMx_CH1`` to ``CH4``, ``TIMx_ETR``, ``TIM1_BKIN`` (and ``BKIN2``) and ``TIMy_TRGO`` of the
    masters; outputs ``TIMx_CH1`` to ``CH4``, ``TIM1_CH1N`` to ``CH3N``, ``TIMx_TRGO``. DMA requests ``TIMx_UP``,
    ``TIMx_CH1`` to ``CH4``, ``TIMx_TRIG``, ``TIM1_COM``.
    """

    # --- what the chip calls

    def reset(self) -> None:
        """Go to the state after reset: stopped, outputs released, nothing requested."""
        self._sync()
        super().reset()
        self._master = self.kind.master_mode or 0
        self._counting.reset()
        self._counting.tick = self._clock.now
        self._gate.reset()
        self._burst, self._burst_index = None, 0
        for stage in self._stages:
            stage.reset()
        self._slave.reset()
        if self._breaks is not None:
            self._breaks.reset()
        for request in (self._dma_update, self._dma_trigger, self._dma_com, *self._dma_channels):
            request.set(False)
        self._queue.clear()
        self._changed_outputs()
        self._settle()

    def before_clock_change(self) -> None:
        """Count up to the present cycle at the old rate, and bring the records of the pins up to it."""
        self._sync()
        self._settle()

    def after_clock_change(self) -> None:
        """Count at the new rate; a timer whose clock gate is shut stands still."""
        self._clock.change(self.services.clocks.timer(self.kind.bus) if self.clocked else 0)
        self._counting.tick = max(self._counting.tick, self._clock.now)
        self._slave.replan()
        self._set_running()
        self.time.cancel(self._event)
        self._event = None
        self._settle()

    def is_live(self, offset: int) -> bool:
        """CNT changes while the timer's clock counts, and so does the direction in the centre-aligned modes."""
        counting = self._counting
        return counting.running and (offset == CNT or (offset == CR1 and bool(counting.centre)))

    def count(self, offset: int) -> Count | None:
        """Return how CNT counts up to its next boundary."""
        counting, clock = self._counting, self._clock
        if offset != CNT or not clock.cycles or clock.now < counting.tick:
            return None
        if counting.count_at(clock.now) is None:
            self._sync()
        steps = counting.steps_left()
        if not counting.running or not steps:
            return None
        origin, divider = clock.cycle_of(counting.tick - counting.psc_count), (counting.psc + 1) * clock.cycles
        if self[CR1] & UIFREMAP and self.kind.bits == 32:
            return None
        return Count(self._shown(counting.cnt), origin, divider, until=origin + steps * divider, down=counting.down)

    # --- the counter

    def read_CR1(self) -> int:
        """DIR is the present direction."""
        if self._counting.centre:
            self._sync()
        return self[CR1] & ~DIR | (DIR if self._counting.down else 0)

    def write_CR1(self, value: int) -> None:
        """Start, stop, and the way to count; DIR is read-only in the centre-aligned and encoder modes."""
        self._sync()
        counting, changed, started = self._counting, value ^ self[CR1], value & ~self[CR1] & CEN
        self[CR1] = value
        self._set_alignment()
        if not counting.centre and not self._slave.encoder:
            counting.down = bool(value & DIR)
        counting.udis = bool(value & UDIS)
        if not value & ARPE:
            counting.arr = counting.arr_preload
        counting.moved()
        if changed & CKD:
            self._configure_inputs()
            self._set_dead_time()
            self._changed_outputs()
        if started:
            self._start()
        else:
            self._set_running()
        self._changed_trgo()
        self._settle()

    def read_CNT(self) -> int:
        """Return the counter at the present cycle."""
        counter = self._counting.count_at(self._clock.now)
        if counter is None:
            self._sync()
            counter = self._counting.cnt
        return self._shown(counter)

    def _shown(self, counter: int) -> int:
        """Return CNT, whose highest bit may be a copy of UIF."""
        if not self[CR1] & UIFREMAP:
            return counter
        return counter & ~UIFCPY | (UIFCPY if self[SR] & UIF else 0)

    def write_CNT(self, value: int) -> None:
        """Set the counter; the prescaler goes on."""
        self._sync()
        self._counting.cnt = value
        self._counting.moved()
        self._settle()

    def write_PSC(self, value: int) -> None:
        """Set the prescaler from the next update event on."""
        self._sync()
        self[PSC] = self._counting.psc_preload = value
        self._settle()

    def write_ARR(self, value: int) -> None:
        """Set the end of the counter, at once or (ARPE) from the next update event on."""
        self._sync()
        self[ARR] = self._counting.arr_preload = value
        if not self[CR1] & ARPE:
            self._counting.arr = value
            self._counting.moved()
        self._settle()

    def write_RCR(self, value: int) -> None:
        """Set the repetition counter from the next update event on."""
        self._sync()
        self[RCR] = self._counting.rcr = value
        self._settle()

    # --- events, flags and requests

    def write_DIER(self, value: int) -> None:
        """Enable interrupts and requests; a request that is disabled is dropped."""
        self._sync()
        dropped = self[DIER] & ~value
        self[DIER] = value
        for number, request in enumerate(self._dma_channels):
            if dropped & 0x200 << number:
                request.set(False)
        for bit, request in ((UDE, self._dma_update), (TDE, self._dma_trigger), (COMDE, self._dma_com)):
            if dropped & bit:
                request.set(False)
        self._settle()

    def write_SR(self, value: int) -> None:
        """Clear flags by writing 0; that of a break input stays while it is active."""
        self._sync()
        held = self[SR] & self._breaks.active if self._breaks is not None else 0
        self[SR] = self[SR] & value | held
        self._settle()

    def read_EGR(self) -> int:
        """Write-only: reads 0."""
        return 0

    def write_EGR(self, value: int) -> None:
        """Make events by software: captures first, the update last."""
        self._sync()
        for number in range(min(self.kind.channels, 4)):
            if value & 2 << number:
                self._generate(number)
        if value & TG:
            self[SR] |= TIF
            if self[DIER] & TDE:
                self._request(self._dma_trigger)
        if value & COMG:
            self._commutate()
        if value & (BG | B2G):
            self._break_arrived((BIF if value & BG else 0) | (B2IF if value & B2G else 0))
        if value & UG:
            self._reinitialise()
        self._settle()

    def _generate(self, number: int) -> None:
        if self._counting.units[number].output:
            self._on_match(1 << number)
        else:
            self.captured(number)

    # --- channels

    def write_CCMR1(self, value: int) -> None:
        """Set up channels 1 and 2."""
        self._write_modes(CCMR1, 0, value)

    def write_CCMR2(self, value: int) -> None:
        """Set up channels 3 and 4."""
        self._write_modes(CCMR2, 2, value)

    def write_CCMR3(self, value: int) -> None:
        """Set up channels 5 and 6, which are compare units without pins."""
        self._write_modes(CCMR3, 4, value)

    def _write_modes(self, offset: int, first: int, value: int) -> None:
        self._sync()
        old = self[offset]
        for index in range(2):
            shift = 8 * index
            if self[CCER] >> 4 * (first + index) & 1:  # CCxS can be written only while the channel is off
                value = value & ~(0b11 << shift) | old & 0b11 << shift
            if self._lock_level() >= 3 and not value >> shift & 0b11:
                frozen = 0x1_0078 << shift
                value = value & ~frozen | old & frozen
        self[offset] = value
        self._apply_channels()
        self._settle()

    def write_CCER(self, value: int) -> None:
        """Enable channels and set their polarity; lock level 2 freezes the polarity of outputs."""
        self._sync()
        if self._lock_level() >= 2:
            frozen = sum(0b1010 << 4 * unit.number for unit in self._counting.units if unit.output)
            value = value & ~frozen | self[CCER] & frozen
        self[CCER] = value
        self._apply_channels()
        self._settle()

    def write_CR2(self, value: int) -> None:
        """Set what TRGO is, idle states and preloading; lock level 1 freezes the idle states."""
        self._sync()
        if self._lock_level() >= 1:
            value = value & ~_IDLE_STATES | self[CR2] & _IDLE_STATES
        self[CR2] = value
        self._master = self._master_of(value >> 4 & 7)
        for stage, shift in zip(self._stages, (8, 10, 12, 14), strict=False):
            stage.idle = bool(value >> shift & 1)
            stage.n_idle = bool(value >> shift & 2)
        self._apply_channels()
        self._changed_trgo()
        self._settle()

    def _master_of(self, mode: int) -> int:
        if self.kind.master_mode is not None:
            return self.kind.master_mode
        if mode < self.kind.master_modes:
            return mode
        self.note("reserved", "CR2.MMS", f"{mode:#05b} is reserved: it is taken as 000")
        return 0

    def _read_ccr(self, number: int) -> int:
        """Reading a captured value clears its flag."""
        if not self._counting.units[number].output and self[SR] & 2 << number:
            self[SR] &= ~(2 << number)
            self._settle()
        return self[CCR1 + 4 * number]

    def _write_ccr(self, number: int, value: int) -> None:
        """Set a compare value, at once or (OCxPE) from the next update event on; a captured value is read-only."""
        unit = self._counting.units[number]
        if not unit.output:
            return
        offset, preloaded = COMPARES[number], self._mode_bits(number) & 0b1000
        kept, value = value, value & self._counting.top - 1
        if preloaded and self._counting.will_load_after(self._clock.now):
            self[offset], unit.ccr_preload = kept, value  # with what waits already; nothing else comes of it
            return
        self._sync()
        self[offset], unit.ccr_preload = kept, value
        if not preloaded:
            unit.ccr = value
            self._counting.moved()
        self._settle()

    def read_CCR1(self) -> int:
        """Return the compare or captured value of channel 1."""
        return self._read_ccr(0)

    def read_CCR2(self) -> int:
        """Return the compare or captured value of channel 2."""
        return self._read_ccr(1)

    def read_CCR3(self) -> int:
        """Return the compare or captured value of channel 3."""
        return self._read_ccr(2)

    def read_CCR4(self) -> int:
        """Return the compare or captured value of channel 4."""
        return self._read_ccr(3)

    def write_CCR1(self, value: int) -> None:
        """Set the compare value of channel 1."""
        self._write_ccr(0, value)

    def write_CCR2(self, value: int) -> None:
        """Set the compare value of channel 2."""
        self._write_ccr(1, value)

    def write_CCR3(self, value: int) -> None:
        """Set the compare value of channel 3."""
        self._write_ccr(2, value)

    def write_CCR4(self, value: int) -> None:
        """Set the compare value of channel 4."""
        self._write_ccr(3, value)

    def write_CCR5(self, value: int) -> None:
        """Set the compare value of channel 5, and the channels that are high only while it is."""
        self._sync()
        self._counting.group([bool(value >> bit & 1) for bit in (29, 30, 31)])
        self._write_ccr(4, value)
        self._settle()

    def write_CCR6(self, value: int) -> None:
        """Set the compare value of channel 6."""
        self._write_ccr(5, value)

    def write_AF1(self, value: int) -> None:
        """Keep which sources the break has; the pin cannot be cut off here."""
        self._keep_sources(AF1, value)

    def write_AF2(self, value: int) -> None:
        """Keep which sources the second break has."""
        self._keep_sources(AF2, value)

    def _keep_sources(self, offset: int, value: int) -> None:
        if not value & 1:
            self.note("unmodelled", f"AF{1 + (offset == AF2)}", "the pin of the break input cannot be cut off (BKINE)")
        self[offset] = value

    # --- triggers, break and dead time

    def write_SMCR(self, value: int) -> None:
        """Set the slave mode, its trigger and the external clock."""
        self._sync()
        self[SMCR] = value
        self._slave.mode = self._slave_mode(value)
        self._slave.trigger = value >> 4 & 7
        self._slave.external_clock_2 = bool(value & ECE)
        self._configure_inputs()
        self._set_alignment()
        self._counting.moved()
        self._set_running()
        self._changed_trgo()
        self._settle()

    def _slave_mode(self, value: int) -> int:
        """Return SMS; a reserved one is none."""
        mode = value & 7 | (value >> 13 & 8 if self.kind.extended else 0)
        if mode > RESET_AND_TRIGGER or (self.kind.channels < 4 and mode in ENCODER_MODES):
            self.note("reserved", "SMCR.SMS", f"{mode:#06b} is reserved: it is taken as 0000")
            return 0
        return mode

    def write_BDTR(self, value: int) -> None:
        """Set break, idle states, dead time and MOE."""
        if self._breaks is None:
            return
        self._sync()
        self[BDTR] = self._breaks.permitted(self[BDTR], value)
        self._set_dead_time()
        self._breaks.configure(self[BDTR])
        if active := self._breaks.active:
            self._break_arrived(active)
        self._set_main_enable()
        self._settle()

    # --- bursts

    def _burst_offset(self) -> int:
        return 4 * ((self[DCR] & 0x1F) + self._burst_index)

    def _burst_step(self) -> None:
        self._burst_index += 1
        if self._burst_index <= self[DCR] >> 8 & 0x1F:
            if self._burst is not None:
                self._queue.append((self._burst.pulse, ()))
        else:
            self._burst_index = 0
            self._burst = None

    def read_DMAR(self) -> int:
        """Read the register whose turn it is in the burst."""
        offset = self._burst_offset()
        value = self.read(offset) if offset != DMAR else 0
        self._burst_step()
        self._settle()
        return value

    def write_DMAR(self, value: int) -> None:
        """Write the register whose turn it is in the burst."""
        offset = self._burst_offset()
        if offset != DMAR:
            self.write(offset, value)
        self._burst_step()
        self._settle()
