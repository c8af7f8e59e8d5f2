"""One 16-bit ADC of an STM32H7: its registers, and conversions one after the other (RM0433 section 25.4).

A conversion takes the sampling time of its channel and half a clock for each bit, and half a clock more. The voltage
counts as it is at the end of the sampling time. Choices where the manual is silent, besides those of `adc16_data` and
`adc16_power`:

* A conversion begins at the cycle of its trigger, without latency; a sequence goes on without a gap.
* A source charges the sampling capacitor at once, whatever its resistance.
* A trigger of a group that is active already is ignored.
* An injected group that is triggered breaks off the regular conversion under way, which begins anew afterwards; what
  was summed up of an oversampled channel is kept if ROVSM is clear.
* Settings that software must not change while conversions are asked for take effect with the next one; that is noted.
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction

from targets.mcu.stm32.adc16_data import code, conversion_clocks, result
from targets.mcu.stm32.adc16_power import Power
from targets.mcu.stm32.adc16_registers import (
    ADCAL,
    ADCALDIF,
    ADCALLIN,
    ADDIS,
    ADEN,
    ADRDY,
    ADSTART,
    ADSTP,
    AUTDLY,
    AWD1EN,
    BOOST,
    CFGR,
    CFGR2,
    CONT,
    CR,
    DISCEN,
    DMNGT,
    DR,
    EOC,
    EOS,
    EOSMP,
    FLAGS,
    IER,
    ISR,
    JADSTART,
    JADSTP,
    JAUTO,
    JAWD1EN,
    JDISCEN,
    JDR1,
    JEOC,
    JEOS,
    JSQR,
    OVR,
    OVRMOD,
    PCSEL,
    REGISTERS,
    ROVSE,
    ROVSM,
    SMPR1,
    SMPR2,
    SQR1,
    SQR2,
    SQR3,
    SQR4,
    TROVS,
)
from targets.mcu.stm32.adc16_settings import (
    injected_sequence,
    less_offset,
    resolution,
    sampling,
    sequence,
    steps,
    watch,
)
from targets.mcu.stm32.adc_sequences import Group
from targets.mcu.stm32.clocked_wait import ClockedWait
from targets.mcu.stm32.converters import Ends
from targets.mcu.timebase import Timebase

__all__ = ["Unit"]

_RISING, _FALLING = 1, 2
_ONE_SHOT, _DFSDM = 1, 2  # values of DMNGT
_RUNNING = ADSTART | JADSTART
_FIXED = {CFGR, CFGR2, SMPR1, SMPR2, SQR1, SQR2, SQR3, SQR4, PCSEL}
"""What software must not change while regular conversions are asked for."""


class Unit:
    """See the module.

    Args:
        name: ``ADC1``.
        time: the chip's cycles and events.
        ends: what it is connected to.

    Attributes:
        values: of the registers, by offset.
        on_flags: called when flags or their enables have changed.
        on_enable: called when ADEN was set.
        power: what wakes it up.
    """

    def __init__(self, name: str, time: Timebase, ends: Ends) -> None:
        self.name = name
        self.on_flags: Callable[[], None] = lambda: None
        self.on_enable: Callable[[], None] = lambda: None
        self.values = {register.offset: register.reset for register in REGISTERS}
        self.power = Power(time, self.values, ends.note)
        self.power.on_flags = self._update
        self._ends = ends
        self._note = ends.note
        self._wait = ClockedWait(time)
        self._regular, self._injected = Group(), Group()
        self._converting: Group | None = None
        self._sampled = 0
        self._sum, self._summed = 0, 0
        self._dma_over = False
        ends.request.on_last = self._last_transfer

    # --- what the controller calls

    def reset(self) -> None:
        """Go to the state after reset."""
        self.values.update({register.offset: register.reset for register in REGISTERS})
        self.power.reset()
        self._stop_all()
        self._dma_over = False
        self._listen()
        self._update()

    def set_clock(self, cycles: Fraction) -> None:
        """Let a clock take so many cycles from now on; 0 stands still."""
        self._wait.set_rate(cycles)
        self.power.wait.set_rate(cycles)

    @property
    def interrupt(self) -> bool:
        """Whether a flag is set whose interrupt is enabled."""
        return bool(self.values[ISR] & self.values[IER] & FLAGS)

    def read(self, offset: int) -> int:
        """Read a register."""
        if offset == DR:
            self._take()
        elif JDR1 <= offset < JDR1 + 16:
            self.values[ISR] &= ~JEOC
            self._update()
        return self.values[offset]

    def write(self, offset: int, value: int) -> None:
        """Write a register; `value` has the writable bits, and the others as they are."""
        if offset == CR:
            self._control(value)
        elif offset == ISR:
            self._clear(value)
        else:
            if offset in _FIXED and self.values[CR] & ADSTART and value != self.values[offset]:
                self._note(
                    "misuse", _name(offset), "changed while ADSTART is set: it counts from the next conversion on"
                )
            self.values[offset] = value
            if offset in (CFGR, JSQR):
                self._listen()
            self._update()

    def _clear(self, flags: int) -> None:
        self.values[ISR] &= ~(flags & FLAGS)
        if flags & EOC:
            self._proceed()
        self._update()

    def _take(self) -> None:
        """DR is read."""
        self.values[ISR] &= ~EOC
        self._proceed()
        self._update()

    # --- CR

    def _control(self, value: int) -> None:
        self.power.set_supply(value)
        kept = BOOST | ADCALLIN | ADCALDIF
        self.power.move_linearity(value)
        self.values[CR] = self.values[CR] & ~kept | value & kept
        if value & ADCAL:
            self.power.calibrate()
        if value & ADDIS and self.values[CR] & ADEN:
            self._disable()
        elif value & ADEN and not self.values[CR] & ADEN:
            self.power.switch_on()
            if self.values[CR] & ADEN:
                self.on_enable()
        self._start_and_stop(value)
        self._listen()
        self._update()

    def _disable(self) -> None:
        if self.values[CR] & _RUNNING:
            self._note("misuse", "CR.ADDIS", "written while conversions are asked for (ADSTART, JADSTART): no effect")
        else:
            self.power.switch_off()

    def _start_and_stop(self, value: int) -> None:
        if not self.values[CR] & ADEN:
            if self.values[CR] & _RUNNING:  # the supply has gone
                self._stop_all()
            elif value & _RUNNING:
                self._note("misuse", "CR.ADSTART", "written while ADEN is clear: nothing is converted")
            return
        if value & ADSTP and self.values[CR] & ADSTART:
            self._stop(self._regular, ADSTART)
        elif value & ADSTART and not self.values[CR] & ADSTART:
            self._ask(ADSTART)
        if value & JADSTP and self.values[CR] & JADSTART:
            self._stop(self._injected, JADSTART)
        elif value & JADSTART and not self.values[CR] & JADSTART:
            self._ask(JADSTART)

    def _ask(self, bit: int) -> None:
        if not self.values[ISR] & ADRDY and self.power.wait.pending:
            self._note("misuse", "CR.ADSTART", "written before ADRDY: the first results may be wrong")
        self.values[CR] |= bit
        if bit == ADSTART:
            self._dma_over = False
            if not self.values[CFGR] >> 10 & 3:
                self._start_regular()
        elif not self.values[JSQR] >> 7 & 3:
            self._start_injected()

    def _stop(self, group: Group, bit: int) -> None:
        self.values[CR] &= ~bit
        group.reset()
        if group is self._regular:
            self._sum = self._summed = 0
        if self._converting is group:
            self._wait.stop()
            self._converting = None
            self._proceed()

    def _stop_all(self) -> None:
        self._wait.stop()
        self._converting = None
        self.values[CR] &= ~_RUNNING
        self._regular.reset()
        self._injected.reset()
        self._sum = self._summed = 0

    # --- triggers

    def _listen(self) -> None:
        cfgr, jsqr, running = self.values[CFGR], self.values[JSQR], self.values[CR]
        for name, signals, hear, wanted, number in (
            (
                "CFGR.EXTSEL",
                self._ends.triggers,
                self._regular_edge,
                running & ADSTART and cfgr >> 10 & 3,
                cfgr >> 5 & 0x1F,
            ),
            (
                "JSQR.JEXTSEL",
                self._ends.injected_triggers,
                self._injected_edge,
                running & JADSTART and jsqr >> 7 & 3,
                jsqr >> 2 & 0x1F,
            ),
        ):
            for own, signal in signals.items():
                callback = hear if wanted and own == number else None
                if signal.on_change != callback:
                    signal.on_change = callback
            if wanted and number not in signals:
                self._note("unmodelled", name, f"trigger {number} is not modelled: it never comes")

    def _regular_edge(self, level: bool) -> None:
        if self.values[CFGR] >> 10 & (_RISING if level else _FALLING):
            self._start_regular()
            self._update()

    def _injected_edge(self, level: bool) -> None:
        if self.values[JSQR] >> 7 & (_RISING if level else _FALLING):
            self._start_injected()
            self._update()

    def _start_regular(self, *, follows: bool = False) -> None:
        if self._regular.active:
            return
        self._regular.start(sequence(self.values), steps(self.values))
        self._proceed(follows=follows)

    def _start_injected(self, *, follows: bool = False) -> None:
        if self._injected.active:
            return
        self._injected.start(injected_sequence(self.values), 1 if self.values[CFGR] & JDISCEN else 0)
        if self._converting is self._regular:
            self._wait.stop()
            self._converting = None
            if self.values[CFGR2] & ROVSM:
                self._sum = self._summed = 0
        self._proceed(follows=follows)

    # --- conversions

    def _proceed(self, *, follows: bool = False) -> None:
        """Begin the next conversion, if nothing is under way; the injected group first."""
        if self._converting is not None:
            return
        group = self._injected if self._injected.active else self._regular
        if not group.active:
            return
        if group is self._regular and self.values[CFGR] & AUTDLY and self.values[ISR] & EOC:
            return
        self._converting = group
        self._wait.start(sampling(self.values, group.channel), self._sample, follows=follows)

    def _sample(self) -> None:
        group = self._converting
        assert group is not None
        bits = resolution(self.values)
        self._sampled = code(self._ends.volts(group.channel), self._ends.reference_volts, bits)
        if group is self._regular:
            self.values[ISR] |= EOSMP
            self._update()
        self._wait.start(conversion_clocks(bits), self._converted, follows=True)

    def _converted(self) -> None:
        group = self._converting
        assert group is not None
        self._converting = None
        if group is self._injected:
            self._keep_injected()
        else:
            self._keep_regular()
        self._proceed(follows=True)
        self._update()

    def _keep_injected(self) -> None:
        rank, channel = self._injected.rank, self._injected.channel
        self.values[JDR1 + 4 * rank] = result(less_offset(self.values, channel, self._sampled), 0)
        self.values[ISR] |= JEOC | watch(self.values, channel, self._sampled, JAWD1EN)
        self._injected.advance()
        if not self._injected.active and self._injected.over:
            self.values[ISR] |= JEOS
        if not self._injected.active and not self.values[JSQR] >> 7 & 3 and not self.values[CFGR] & JAUTO:
            self.values[CR] &= ~JADSTART

    def _keep_regular(self) -> None:
        if self.values[CFGR2] & ROVSE and not self._summed_up():
            return
        channel = self._regular.channel
        self.values[ISR] |= watch(self.values, channel, self._sampled, AWD1EN)
        self._store(result(less_offset(self.values, channel, self._sampled), self.values[CFGR2] >> 28))
        self._regular.advance()
        if not self._regular.active:
            self._group_over(self._regular.over)

    def _summed_up(self) -> bool:
        """Add to the sum of an oversampled channel; say whether it is complete, and then have it in `_sampled`."""
        control = self.values[CFGR2]
        self._sum += self._sampled
        self._summed += 1
        if self._summed <= control >> 16 & 0x3FF:
            if control & TROVS:
                self._regular.active = False  # each trigger adds one
            return False
        self._sampled = self._sum >> (control >> 5 & 0xF)
        self._sum = self._summed = 0
        return True

    def _store(self, word: int) -> None:
        """Put a result into DR, unless the last one was not read and is to be preserved."""
        if self.values[ISR] & EOC:
            self.values[ISR] |= OVR
        if not self.values[ISR] & OVR or self.values[CFGR] & OVRMOD:
            self.values[DR] = word
            self.values[ISR] |= EOC

    def _group_over(self, whole: bool) -> None:
        """A trigger of the regular group was served; `whole` if the sequence has come to its end."""
        cfgr = self.values[CFGR]
        if whole:
            self.values[ISR] |= EOS
            if cfgr & JAUTO:
                self._start_injected(follows=True)
        if cfgr & CONT and not cfgr & DISCEN:
            self._start_regular(follows=True)
        elif not cfgr >> 10 & 3:
            self.values[CR] &= ~ADSTART

    # --- lines

    def _last_transfer(self) -> None:
        """The DMA controller has made the last transfer of its count: in one-shot mode nothing more is asked for."""
        if self.values[CFGR] & DMNGT == _ONE_SHOT:
            self._dma_over = True

    def _update(self) -> None:
        mode = self.values[CFGR] & DMNGT
        wanted = mode not in (0, _DFSDM) and self.values[ISR] & (EOC | OVR) == EOC and not self._dma_over
        if wanted is not self._ends.request.level:
            self._ends.request.set(wanted)
        self.on_flags()


def _name(offset: int) -> str:
    return next(register.name for register in REGISTERS if register.offset == offset)
