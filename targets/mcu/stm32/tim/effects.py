"""What the settings of a timer and the edges at its inputs do (RM0008 chapters 14 and 15).

Choice: the counter counts from one tick after CEN has been set, by software or by a trigger ("the counter starts
counting one clock cycle after setting the CEN bit"); a gate takes effect at once.
"""

from __future__ import annotations

from targets.mcu.stm32.tim.breaks import BreakInput
from targets.mcu.stm32.tim.core import TimerCore
from targets.mcu.stm32.tim.counting import ALONE, BOTH, BY_DIRECTION, EITHER, FROZEN, PWM1, PWM2, Compare
from targets.mcu.stm32.tim.registers import (
    BDTR,
    BIF,
    BKE,
    CCDS,
    CCER,
    CCMR1,
    CCMR2,
    CCPC,
    CCR1,
    CCUS,
    CEN,
    COMDE,
    COMIF,
    COMPARES,
    CR1,
    CR2,
    DIER,
    ETP,
    MMS_COMPARE,
    MMS_RESET,
    MODES,
    SMCR,
    SR,
    TDE,
    TI1S,
    TIF,
    URS,
)
from targets.mcu.stm32.tim.slave import GATED, RESET, RESET_AND_TRIGGER, TRIGGER

__all__ = ["TimerEffects"]


_EXTENDED = (
    (PWM1, ALONE),
    (PWM2, ALONE),
    (FROZEN, ALONE),
    (FROZEN, ALONE),
    (PWM1, EITHER),
    (PWM2, BOTH),
    (PWM1, BY_DIRECTION),
    (PWM2, BY_DIRECTION),
)
"""What the modes from 1000 on are made of: retriggerable one-pulse (missing), reserved, combined, asymmetric PWM."""


class TimerEffects(TimerCore):
    """A timer without its registers; the reactions of `slave.Reactions` are here."""

    # --- what edges do (see `slave.Reactions`)

    def captured(self, number: int) -> None:
        """Capture the counter."""
        flag = 2 << number
        self[SR] |= flag << 8 | flag if self[SR] & flag else flag
        self[CCR1 + 4 * number] = self._counting.cnt
        if self[DIER] & 0x200 << number and not self[CR2] & CCDS:
            self._request(self._dma_channels[number])
        if number == 0 and self._master_mode() == MMS_COMPARE:
            self._pulse_trgo()

    def triggered(self, level: bool) -> None:
        """TRGI has changed."""
        mode = self._slave.mode
        if level and self[CR2] & (CCUS | CCPC) == CCUS | CCPC:
            self._commutate()
        if not mode:
            return
        if level or mode == GATED:
            self[SR] |= TIF
            if self[DIER] & TDE:
                self._request(self._dma_trigger)
        if mode == GATED:
            self._set_running()
            self._changed_trgo()
        elif level:
            self._act_on_trigger(mode)

    def _act_on_trigger(self, mode: int) -> None:
        for unit in self._counting.units:
            if self._mode_bits(unit.number) & 0b100:
                self._counting.trigger_fast(unit)
        if mode in (RESET, RESET_AND_TRIGGER):
            self._reinitialise()
        if mode in (TRIGGER, RESET_AND_TRIGGER) and not self[CR1] & CEN:
            self[CR1] |= CEN
            self._start()

    def counted(self) -> None:
        """Count a pulse of the external clock."""
        if self[CR1] & CEN and (self._slave.mode != GATED or self._slave.trigger_level()):
            self._counting.pulse(self._clock.now)

    def turned(self, down: bool, counts: bool) -> None:
        """Count an edge of the encoder."""
        self._counting.down = down
        self._counting.resolve()
        if counts:
            self.counted()

    def etrf_changed(self, level: bool) -> None:
        """Hold the channels low that ETRF clears."""
        if level:
            self._clear_by_etrf()

    def clock_failed(self) -> None:
        """Break, if BKE is set: the clock security system has found the HSE dead (RM0008 section 14.3.12)."""
        if self[BDTR] & BKE:
            self._break_arrived(BIF)

    def _break_changed(self, source: BreakInput, level: bool) -> None:
        """A break input has changed; once it is released an update event may set MOE (AOE)."""
        self._sync()
        source.level = level
        if source.active:
            self._break_arrived(source.flag)
        self._settle()

    def _break_arrived(self, flags: int) -> None:
        """A break input has become active, or BG was set."""
        if self._breaks is None:
            return
        self._sync()
        self[SR] |= flags
        self[BDTR] = self._breaks.disable(self[BDTR])
        self._set_main_enable()
        self._settle()

    def _reinitialise(self) -> None:
        """Begin anew, by UG or by the trigger."""
        counting = self._counting
        counting.reinitialise()
        if not counting.udis:
            if self[CR1] & URS:
                self._updated()
            else:
                self._on_update()
        if self._master_mode() == MMS_RESET:
            self._pulse_trgo()

    def _commutate(self) -> None:
        self[SR] |= COMIF
        if self[DIER] & COMDE:
            self._request(self._dma_com)
        self._apply_channels(commutation=True)

    def _start(self) -> None:
        self._set_running()
        if self._counting.running:
            self._counting.tick = self._clock.now + 1
        self._changed_trgo()

    # --- settings

    def _apply_channels(self, *, commutation: bool = False) -> None:
        """Put CCMRx and CCER into effect; with CCPC, OCxM, CCxE and CCxNE of channels 1 to 3 wait for a commutation."""
        for unit in self._counting.units:
            bits = self._mode_bits(unit.number)
            waits = bool(self[CR2] & CCPC and not commutation and unit.number < 3)
            if unit.number < len(self._stages):
                self._apply_enables(unit.number, bits, waits=waits)
            self._apply_mode(unit, bits, waits=waits)
        self._counting.moved()
        self._configure_inputs()
        if self._slave.etrf_level():
            self._clear_by_etrf()
        self._set_running()
        self._changed_outputs()

    def _apply_enables(self, number: int, bits: int, *, waits: bool) -> None:
        enables = self[CCER] >> 4 * number & 0xF
        both = self.kind.both_edges and bool(bits & 0b11) and enables & 0b1010 == 0b1010
        slave, stage = self._slave, self._stages[number]
        slave.select[number] = bits & 0b11
        slave.both[number] = both
        slave.inverted[number] = bool(enables & 0b10) and not both
        slave.enabled[number] = bool(enables & 0b1)
        slave.prescalers[number] = 1 << (bits >> 2 & 0b11)
        stage.inverted, stage.n_inverted = bool(enables & 0b10), bool(enables & 0b1000)
        if not waits:
            stage.enabled, stage.n_enabled = bool(enables & 0b1), bool(enables & 0b100)

    def _apply_mode(self, unit: Compare, bits: int, *, waits: bool) -> None:
        was_output, unit.output = unit.output, not bits & 0b11
        if not unit.output:
            self._counting.set_mode(unit, FROZEN)
            return
        if not was_output or not bits & 0b1000:
            unit.ccr_preload = self[COMPARES[unit.number]] & 0xFFFF_FFFF >> 32 - self.kind.bits
            unit.ccr = unit.ccr_preload
        if not waits:
            mode, combination = self._mode_of(unit.number, bits)
            self._counting.set_mode(unit, mode)
            self._counting.combine(unit, combination)

    def _mode_of(self, number: int, bits: int) -> tuple[int, int]:
        """Return OCxM, and what becomes of OCxREF."""
        mode = bits >> 4 & 7
        if not self[MODES[number >> 1]] >> 16 + 8 * (number & 1) & 1:
            return mode, ALONE
        if mode < 4:
            taken = f"it is taken as {_EXTENDED[mode][0]:#05b}"
            self.note("unmodelled", f"CCMR{number // 2 + 1}.OC{number + 1}M", f"{8 + mode:#06b} is missing: {taken}")
        return _EXTENDED[mode]

    def _configure_inputs(self) -> None:
        smcr, modes = self[SMCR], (self[CCMR1] | self[CCMR2] << 16)
        channels = [modes >> 8 * number & 0xFF for number in range(4)]
        self._slave.configure(
            xor=bool(self[CR2] & TI1S),
            filters=[bits >> 4 if bits & 0b11 else 0 for bits in channels],
            etr_code=smcr >> 8 & 0xF,
            etr_inverted=bool(smcr & ETP),
            etr_divider=1 << (smcr >> 12 & 3),
            dts_ticks=self._dts_ticks(),
            com_by_trigger=self[CR2] & (CCUS | CCPC) == CCUS | CCPC,
            etr_clears=any(bits & 0x80 and not bits & 0b11 for bits in channels),
        )

    def _dts_ticks(self) -> int:
        return 1 << min(self[CR1] >> 8 & 3, 2)

    def _set_dead_time(self) -> None:
        if self._breaks is not None:
            self._gate.dead_ticks = self._breaks.dead_time(self[BDTR]) * self._dts_ticks()

    def _set_alignment(self) -> None:
        self._counting.centre = 0 if self._slave.encoder else self[CR1] >> 5 & 3

    def _lock_level(self) -> int:
        return self._breaks.lock_level if self._breaks is not None else 0
