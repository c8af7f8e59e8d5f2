"""One converter of an STM32F2, F4 or F7: its registers, and conversions one after the other (RM0410 section 15.3).

A conversion takes the sampling time of its channel and one clock for each bit. The voltage counts as it is at the end
of the sampling time. Choices where the manual is silent, besides those of `adc_format`:

* A conversion begins at the cycle of its trigger; the prescaler has no phase of its own.
* A source charges the sampling capacitor at once, whatever its resistance.
* A trigger of a group that is active already is ignored. SWSTART and JSWSTART work beside external triggers.
* An injected group that is triggered breaks off the regular conversion under way, which begins anew afterwards.
* In discontinuous mode EOC is set after each conversion. Without SCAN the first channel of a group is converted alone.
* An overrun keeps the old value in DR, ends the regular group, and lets no trigger of it through until OVR is cleared;
  what was not read until then does not count any more.
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction

from targets.mcu.registers import Register
from targets.mcu.stm32.adc_format import BITS, aligned, code, injected, outside
from targets.mcu.stm32.adc_sequences import Group
from targets.mcu.stm32.converters import Ends
from targets.mcu.timebase import Event, Timebase

__all__ = ["REGISTERS", "Unit"]

SR, CR1, CR2, SMPR1, SMPR2 = range(0x00, 0x14, 4)
JOFR1, HTR, LTR, SQR1, SQR2, SQR3, JSQR, JDR1, DR = 0x14, 0x24, 0x28, 0x2C, 0x30, 0x34, 0x38, 0x3C, 0x4C

AWD, EOC, JEOC, JSTRT, STRT, OVR = (1 << bit for bit in range(6))
FLAGS = AWD | EOC | JEOC | JSTRT | STRT | OVR

EOCIE, AWDIE, JEOCIE, SCAN, AWDSGL, JAUTO, DISCEN, JDISCEN = (1 << bit for bit in range(5, 13))
JAWDEN, AWDEN, OVRIE = 1 << 22, 1 << 23, 1 << 26
ADON, CONT = 1 << 0, 1 << 1
DMA, DDS, EOCS, ALIGN = (1 << bit for bit in range(8, 12))
JSWSTART, SWSTART = 1 << 22, 1 << 30
_RISING, _FALLING = 1, 2
_SAMPLING_HALVES = (6, 30, 56, 112, 168, 224, 288, 960)
"""How many halves of a clock sampling takes, by the value of SMPx."""
_STABILISATION_S = Fraction(3, 1_000_000)
"""The longest time from ADON to the first conversion, t_STAB (DS11532, ADC characteristics)."""

REGISTERS = (
    Register("SR", SR, 0, FLAGS),
    Register("CR1", CR1, 0, 0x07C0_FFFF),
    Register("CR2", CR2, 0, 0x7F7F_0F03),
    Register("SMPR1", SMPR1, 0, 0x07FF_FFFF),
    Register("SMPR2", SMPR2, 0, 0x3FFF_FFFF),
    *(Register(f"JOFR{number + 1}", JOFR1 + 4 * number, 0, 0xFFF) for number in range(4)),
    Register("HTR", HTR, 0xFFF, 0xFFF),
    Register("LTR", LTR, 0, 0xFFF),
    Register("SQR1", SQR1, 0, 0x00FF_FFFF),
    Register("SQR2", SQR2, 0, 0x3FFF_FFFF),
    Register("SQR3", SQR3, 0, 0x3FFF_FFFF),
    Register("JSQR", JSQR, 0, 0x003F_FFFF),
    *(Register(f"JDR{number + 1}", JDR1 + 4 * number, 0, 0) for number in range(4)),
    Register("DR", DR, 0, 0),
)


class Unit:
    """See the module.

    Args:
        name: ``ADC1``.
        time: the chip's cycles and events.
        ends: what it is connected to.

    Attributes:
        values: of the registers, by offset.
        on_interrupt: called when `interrupt` has changed.
        clock_cycles: HCLK cycles of a clock of the converter; 0 while it stands still. Set it by `set_clock`.
    """

    def __init__(self, name: str, time: Timebase, ends: Ends) -> None:
        self.name = name
        self.on_interrupt: Callable[[], None] = lambda: None
        self._interrupts = False
        self.clock_cycles = 0
        self.values = {register.offset: register.reset for register in REGISTERS}
        self._time = time
        self._ends = ends
        self._note = ends.note
        self._regular, self._injected = Group(), Group()
        self._converting: Group | None = None
        self._event: Event | None = None
        self._then: Callable[[], None] = lambda: None
        self._left_halves: Fraction | int = 0
        self._sampled = 0
        self._unread = False
        self._dma_over = False
        self._on_since = Fraction(0)
        self._stable = False  # t_STAB has passed since
        ends.request.on_last = self._last_transfer

    # --- what the controller calls

    def reset(self) -> None:
        """Go to the state after reset."""
        self.values.update({register.offset: register.reset for register in REGISTERS})
        self._power_off()
        self._listen()
        self._update()

    @property
    def interrupt(self) -> bool:
        """Whether a flag is set whose interrupt is enabled."""
        flags, enables = self.values[SR], self.values[CR1]
        return bool(
            (flags & EOC and enables & EOCIE)
            or (flags & AWD and enables & AWDIE)
            or (flags & JEOC and enables & JEOCIE)
            or (flags & OVR and enables & OVRIE)
        )

    def set_clock(self, cycles: int) -> None:
        """Go on at another rate; 0 stands still."""
        if self._converting is not None and self.clock_cycles:
            assert self._event is not None
            self._left_halves = Fraction(2 * (self._event.cycle - self._time.now), self.clock_cycles)
            self._time.cancel(self._event)
        self.clock_cycles = cycles
        if self._converting is not None and cycles:
            self._event = self._time.after(-int(-self._left_halves * cycles // 2), self._then)

    def read(self, offset: int) -> int:
        """Read a register."""
        value = self.values[offset]
        if offset == DR:
            self._unread = False
            self.values[SR] &= ~EOC
            self._update()
        return value

    def write(self, offset: int, value: int) -> None:
        """Write a register, with what may not be written already put in."""
        if offset == SR:
            if self.values[SR] & ~value & OVR:
                self._unread = False
            self.values[SR] &= value
        elif offset == CR2:
            self._write_control(value)
        else:
            self.values[offset] = value
        self._update()

    def _write_control(self, value: int) -> None:
        before, self.values[CR2] = self.values[CR2], value & ~(SWSTART | JSWSTART)
        if not value & ADON:
            self._power_off()
        elif not before & ADON:
            self._on_since, self._stable = self._time.seconds(self._time.now), False
        if not value & DMA:
            self._dma_over = False
        self._listen()
        if before & value & ADON:
            if value & JSWSTART:
                self._start_injected()
            if value & SWSTART:
                self._start_regular()
        elif value & (SWSTART | JSWSTART):
            self._note("misuse", "CR2.SWSTART", "a start together with ADON, or without, has no effect")

    def _power_off(self) -> None:
        self._time.cancel(self._event)
        self._converting = None
        self._regular.reset()
        self._injected.reset()
        self._unread = False
        self._dma_over = False

    # --- triggers

    def _listen(self) -> None:
        control = self.values[CR2]
        for shift, signals, hear in (
            (24, self._ends.triggers, self._regular_edge),
            (16, self._ends.injected_triggers, self._edge),
        ):
            wanted = control & ADON and control >> shift + 4 & 3
            for number, signal in signals.items():
                callback = hear if wanted and number == control >> shift & 0xF else None
                if signal.on_change != callback:
                    signal.on_change = callback
            if wanted and control >> shift & 0xF not in signals:
                where = "CR2.EXTSEL" if shift == 24 else "CR2.JEXTSEL"
                self._note("unmodelled", where, f"trigger {control >> shift & 0xF} is not modelled: it never comes")

    def _regular_edge(self, level: bool) -> None:
        if self.values[CR2] >> 28 & (_RISING if level else _FALLING):
            self._start_regular()
            self._update()

    def _edge(self, level: bool) -> None:
        if self.values[CR2] >> 20 & (_RISING if level else _FALLING):
            self._start_injected()
            self._update()

    def _start_regular(self) -> None:
        if self._regular.active or self.values[SR] & OVR:
            return
        cr1 = self.values[CR1]
        sequence = self._sequence() if cr1 & SCAN else self._sequence()[:1]
        self._regular.start(sequence, (cr1 >> 13 & 7) + 1 if cr1 & DISCEN else 0)
        self.values[SR] |= STRT
        self._check_start()
        self._proceed()

    def _start_injected(self) -> None:
        if self._injected.active:
            return
        cr1 = self.values[CR1]
        sequence = self._injected_sequence() if cr1 & SCAN else self._injected_sequence()[:1]
        self._injected.start(sequence, 1 if cr1 & JDISCEN else 0)
        self.values[SR] |= JSTRT
        self._check_start()
        if self._converting is self._regular:
            self._time.cancel(self._event)
            self._converting = None
        self._proceed()

    def _check_start(self) -> None:
        if self._stable:
            return
        self._stable = self._time.seconds(self._time.now) >= self._on_since + _STABILISATION_S
        if not self._stable:
            text = "a conversion was started within 3 us of ADON: its result may be wrong"
            self._note("misuse", "CR2.ADON", text)

    def _sequence(self) -> list[int]:
        words = (self.values[SQR3], self.values[SQR2], self.values[SQR1])
        return [words[rank // 6] >> 5 * (rank % 6) & 0x1F for rank in range((self.values[SQR1] >> 20 & 0xF) + 1)]

    def _injected_sequence(self) -> list[int]:
        """JSQ4 is the last of them, however many there are."""
        count = (self.values[JSQR] >> 20 & 3) + 1
        return [self.values[JSQR] >> 5 * rank & 0x1F for rank in range(4 - count, 4)]

    # --- conversions

    def _proceed(self) -> None:
        """Begin the next conversion, if nothing is under way; the injected group first."""
        if self._converting is not None:
            return
        group = self._injected if self._injected.active else self._regular
        if group.active:
            self._converting = group
            self._after(_SAMPLING_HALVES[self._sampling(group.channel)], self._sample)

    def _sampling(self, channel: int) -> int:
        if channel < 10:
            return self.values[SMPR2] >> 3 * channel & 7
        return self.values[SMPR1] >> 3 * (channel - 10) & 7 if channel < 19 else 0

    def _after(self, halves: int, action: Callable[[], None]) -> None:
        self._then = action
        self._left_halves = halves
        if self.clock_cycles:
            self._event = self._time.after(halves * self.clock_cycles // 2, action)

    @property
    def _bits(self) -> int:
        return BITS[self.values[CR1] >> 24 & 3]

    def _sample(self) -> None:
        assert self._converting is not None
        bits = self._bits
        self._sampled = code(self._ends.volts(self._converting.channel), self._ends.reference_volts, bits)
        self._after(2 * bits, self._converted)

    def _converted(self) -> None:
        group = self._converting
        assert group is not None
        self._converting = None
        self._watch(group)
        if group is self._injected:
            self._keep_injected()
        else:
            self._keep_regular()
        self._proceed()
        self._update()

    def _watch(self, group: Group) -> None:
        cr1 = self.values[CR1]
        if not cr1 & (JAWDEN if group is self._injected else AWDEN):
            return
        if cr1 & AWDSGL and group.channel != cr1 & 0x1F:
            return
        if outside(self._sampled, self._bits, self.values[LTR], self.values[HTR]):
            self.values[SR] |= AWD

    def _keep_injected(self) -> None:
        rank, left = self._injected.rank, bool(self.values[CR2] & ALIGN)
        value = injected(self._sampled, self.values[JOFR1 + 4 * rank], self._bits, left=left)
        self.values[JDR1 + 4 * rank] = value
        self._injected.advance()
        if not self._injected.active and self._injected.over:
            self.values[SR] |= JEOC

    def _keep_regular(self) -> None:
        cr1, cr2 = self.values[CR1], self.values[CR2]
        if self._unread and (cr2 & EOCS or (cr2 & DMA and not self._dma_over)):
            self.values[SR] |= OVR
            self._regular.reset()
            return
        self.values[DR] = aligned(self._sampled, self._bits, left=bool(cr2 & ALIGN))
        self._unread = True
        self._regular.advance()
        ended = not self._regular.active
        if ended or cr2 & EOCS or cr1 & DISCEN:
            self.values[SR] |= EOC
        if ended and self._regular.over:
            self._sequence_over(cr1, cr2)

    def _sequence_over(self, cr1: int, cr2: int) -> None:
        if cr1 & JAUTO:
            self._start_injected()
        if cr2 & CONT and not cr1 & DISCEN:
            self._start_regular()

    # --- lines

    def _last_transfer(self) -> None:
        """The DMA controller has made the last transfer of its count: without DDS nothing more is asked for."""
        if not self.values[CR2] & DDS:
            self._dma_over = True

    def _update(self) -> None:
        control = self.values[CR2]
        wanted = self._unread and control & DMA and not self._dma_over and not self.values[SR] & OVR
        if bool(wanted) is not self._ends.request.level:
            self._ends.request.set(bool(wanted))
        if self.interrupt is not self._interrupts:
            self._interrupts = not self._interrupts
            self.on_interrupt()
