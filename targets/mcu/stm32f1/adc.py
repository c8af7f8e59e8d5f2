"""The ADCs of the STM32F103 (RM0008 section 11): their registers, what starts them, what stands at their channels.

A converter is `adc_unit`, two together are `adc_dual`. Each has a clock gate; ADC1 and ADC2 share an interrupt. That
ADCCLK is too fast is noted by RCC.

Choices: at a channel that leads nowhere, or at a pin that floats, stands 0 V; VREF+ is the supply of the pads.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from types import MappingProxyType
from typing import ClassVar

from targets.mcu.pins import Pins
from targets.mcu.registers import Peripheral, Register
from targets.mcu.services import InputSignal, IrqLine, Services
from targets.mcu.stm32.adc_noise import QUIET, AdcNoise
from targets.mcu.stm32.adc_unit import CR1, CR2, DR
from targets.mcu.stm32.converters import Ends
from targets.mcu.stm32f1.adc_dual import Dual
from targets.mcu.stm32f1.adc_unit import REGISTERS, TSVREFE, F1Unit, RequestLine

__all__ = ["CHANNELS", "INJECTED_TRIGGERS", "REGULAR_TRIGGERS", "Adc", "Internal", "SharedIrq"]

DUALMOD = 0xF_0000
_SENSOR, _VREFINT = 16, 17
_NO_DUAL = ~DUALMOD

_BOTH = (*(f"PA{number}" for number in range(8)), "PB0", "PB1", *(f"PC{number}" for number in range(6)))
_THIRD = ("PA0", "PA1", "PA2", "PA3", "PF6", "PF7", "PF8", "PF9", "PF10", "", "PC0", "PC1", "PC2", "PC3")
CHANNELS: Mapping[str, tuple[str, ...]] = MappingProxyType({"ADC1": _BOTH, "ADC2": _BOTH, "ADC3": _THIRD})
"""The pin of each channel, by converter (DS5319 table 5, DS5792 table 5)."""

_OF_BOTH = ("TIM1_CC1", "TIM1_CC2", "TIM1_CC3", "TIM2_CC2", "TIM3_TRGO", "TIM4_CC4", "EXTI11_EDGE")
_OF_THIRD = ("TIM3_CC1", "TIM2_CC3", "TIM1_CC3", "TIM8_CC1", "TIM8_TRGO", "TIM5_CC1", "TIM5_CC3")
REGULAR_TRIGGERS: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {"ADC1": _OF_BOTH, "ADC2": _OF_BOTH, "ADC3": _OF_THIRD}
)
"""Signals inside the chip by EXTSEL (RM0008 tables 69 and 71)."""
_OF_BOTH_INJECTED = ("TIM1_TRGO", "TIM1_CC4", "TIM2_TRGO", "TIM2_CC1", "TIM3_CC4", "TIM4_TRGO", "EXTI15_EDGE")
_OF_THIRD_INJECTED = ("TIM1_TRGO", "TIM1_CC4", "TIM4_CC3", "TIM8_CC2", "TIM8_CC4", "TIM5_TRGO", "TIM5_CC4")
INJECTED_TRIGGERS: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {"ADC1": _OF_BOTH_INJECTED, "ADC2": _OF_BOTH_INJECTED, "ADC3": _OF_THIRD_INJECTED}
)
"""Signals inside the chip by JEXTSEL (RM0008 tables 70 and 72)."""
_REMAPPED = MappingProxyType({"EXTI11_EDGE": ("ETRGREG", "TIM8_TRGO"), "EXTI15_EDGE": ("ETRGINJ", "TIM8_CC4")})
"""The field of AFIO_MAPR that puts another trigger in the place of one."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Internal:
    """What the channels inside the chip see.

    Attributes:
        vrefint_volts: the internal reference; 1.20 V typical (DS5319, embedded internal reference voltage).
        temperature_c: of the die; 25 degrees is assumed.
        at_25_volts: what the sensor gives at 25 degrees; 1.43 V typical,
        volts_per_c: and how much less for each degree more; 4.3 mV typical (DS5319, temperature sensor).
    """

    vrefint_volts: float = 1.20
    temperature_c: float = 25.0
    at_25_volts: float = 1.43
    volts_per_c: float = 0.0043

    def volts(self, channel: int) -> float:
        """Return the voltage at channel 16 or 17 of ADC1."""
        if channel == _VREFINT:
            return self.vrefint_volts
        return self.at_25_volts - (self.temperature_c - 25.0) * self.volts_per_c


class _Either:
    """A trigger that is one of two signals; see `targets.mcu.services.InputSignal`.

    Args:
        usual: the one,
        other: and the other of them.
        moved: says which it is.
    """

    on_reach: Callable[[], None] | None = None

    def __init__(self, usual: InputSignal, other: InputSignal, moved: Callable[[], bool]) -> None:
        self._usual, self._other = usual, other
        self._moved = moved
        self._heard: Callable[[bool], None] | None = None

    @property
    def on_change(self) -> Callable[[bool], None] | None:
        """Called with the new level of the one that counts; None while nobody listens."""
        return self._heard

    @on_change.setter
    def on_change(self, callback: Callable[[bool], None] | None) -> None:
        self._heard = callback
        for signal, counts in ((self._usual, False), (self._other, True)):
            signal.on_change = None if callback is None else partial(self._hear, counts)

    def level(self) -> bool:
        """Return the level of the one that counts."""
        return (self._other if self._moved() else self._usual).level()

    def at_pin(self) -> bool:
        """Neither is at a pin."""
        return False

    def _hear(self, counts: bool, level: bool) -> None:
        if self._heard is not None and self._moved() is counts:
            self._heard(level)


class SharedIrq:
    """An interrupt line that several peripherals drive: high while any of them wants it."""

    def __init__(self, line: IrqLine) -> None:
        self._line = line
        self._wanted: set[str] = set()

    def set(self, name: str, level: bool) -> None:
        """Say whether the peripheral of that name wants it."""
        (self._wanted.add if level else self._wanted.discard)(name)
        self._line.set(bool(self._wanted))


class Adc(Peripheral):
    """One of the converters.

    Args:
        name: ``ADC1``.
        base: address of SR.
        services: what the chip offers. Used: the triggers as inputs, a DMA request of its name but for ADC2.
        pins: what stands at its channels.
        irq: its interrupt.
        noise: of its readings.
        remapped: says whether AFIO has put the trigger of TIM8 in the place of EXTI's: ``ADC1_ETRGREG``.

    Attributes:
        internal: what the channels inside the chip see; a test may replace it.
    """

    REGISTERS: ClassVar[tuple[Register, ...]] = REGISTERS

    def __init__(
        self,
        name: str,
        base: int,
        services: Services,
        *,
        pins: Pins,
        irq: SharedIrq,
        remapped: Callable[[str], bool] = lambda _field: False,
        noise: AdcNoise = QUIET,
    ) -> None:
        super().__init__(name, base, services)
        self.internal = Internal()
        self._pins = pins
        self._irq = irq
        self._remapped = remapped
        self._dual: Dual | None = None
        request = None if name == "ADC2" else services.dma(name)
        self.unit = F1Unit(
            name,
            services.time,
            Ends(
                volts=noise.on(name, self._volts_at),
                reference_volts=pins.vdd_volts,
                request=RequestLine(request),
                triggers=self._triggers(REGULAR_TRIGGERS[name]),
                injected_triggers=self._triggers(INJECTED_TRIGGERS[name]),
                note=self.note,
            ),
        )
        self.unit.on_interrupt = self._drive_irq
        for register in REGISTERS:
            self._readers[register.offset] = partial(self._read, register.offset)
            if register.writable:
                self._writers[register.offset] = partial(self._write, register.offset)

    def join(self, slave: Adc) -> None:
        """Be the master of the dual modes (ADC1)."""
        self._dual = Dual(self.unit, slave.unit, self.time, self.note)

    def reset(self) -> None:
        """Go to the state after reset."""
        super().reset()
        self.unit.reset()
        if self._dual is not None:
            self._dual.mode_changed()
        self.after_clock_change()

    def after_clock_change(self) -> None:
        """Go on at the new rate."""
        self.unit.set_clock(int(self.services.clocks.kernel("ADC")) if self.clocked else 0)

    # --- registers

    def _read(self, offset: int) -> int:
        value = self.unit.read(offset)
        return self._dual.second_half(value) if offset == DR and self._dual is not None else value

    def _write(self, offset: int, value: int) -> None:
        before = self.unit.values[offset]
        if offset == CR1 and self._dual is None and value & DUALMOD:
            self.note("reserved", "CR1.DUALMOD", "these bits are those of ADC1 alone")
            value &= _NO_DUAL
        self.unit.write(offset, value)
        self[offset] = self.unit.values[offset]
        if offset == CR1 and (value ^ before) & DUALMOD and self._dual is not None:
            self._dual.mode_changed()

    def _drive_irq(self) -> None:
        self._irq.set(self.name, self.unit.interrupt)

    # --- around it

    def _triggers(self, names: tuple[str, ...]) -> Mapping[int, InputSignal]:
        return {number: self._trigger(name) for number, name in enumerate(names)}

    def _trigger(self, name: str) -> InputSignal:
        there = self.services.input(name)
        if name not in _REMAPPED:
            return there
        field, other = _REMAPPED[name]
        return _Either(there, self.services.input(other), partial(self._remapped, f"{self.name}_{field}"))

    def _volts_at(self, channel: int) -> float:
        volts: float | None = None
        if channel in (_SENSOR, _VREFINT) and self.name == "ADC1":
            if self.unit.values[CR2] & TSVREFE:
                return self.internal.volts(channel)
        elif channel < len(CHANNELS[self.name]) and (pin := CHANNELS[self.name][channel]) in self._pins:
            volts = self._pins[pin].volts
        if volts is None:
            self.note("misuse", f"IN{channel}", "nothing drives this channel, or it leads nowhere: it reads 0 V")
            return 0.0
        return volts
