"""ADC1 to ADC3 of the STM32F103 (RM0008 section 11), which are in C: ``adc_f1.c``, the dual modes ``adc_dual.c``.

Here are registers, what starts conversions, and what stands at the channels. Each converter has a clock gate; ADC1 and
ADC2 share an interrupt. That ADCCLK is too fast is noted by RCC.

Choices: at a channel that leads nowhere, or at a pin that floats, stands 0 V; VREF+ is the supply of the pads.
"""

from __future__ import annotations

import ctypes
import enum
import functools
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from types import MappingProxyType
from typing import Any, ClassVar

from targets.mcu.block import BlockInC, PeripheralInC
from targets.mcu.core.library import structure, with_lock_held
from targets.mcu.pins import Pins
from targets.mcu.registers import Register
from targets.mcu.services import InputSignal, IrqLine, Services, drive_in_c
from targets.mcu.stm32.adc_noise import QUIET, AdcNoise

__all__ = ["CHANNELS", "INJECTED_TRIGGERS", "REGULAR_TRIGGERS", "Adc", "Internal"]

CR2 = 0x08
ADON, JEXTTRIG, EXTTRIG, TSVREFE = 1 << 0, 1 << 15, 1 << 20, 1 << 23
_EXTSEL, _JEXTSEL = 17, 12
_SENSOR, _VREFINT = 16, 17
_STABILISATION_S = Fraction(1, 1_000_000)
"""The longest time from ADON to the first conversion, t_STAB (DS5319, ADC characteristics)."""
_CODES = 1 << 12

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
            signal.on_change = None if callback is None else functools.partial(self._hear, counts)

    def level(self) -> bool:
        """Return the level of the one that counts."""
        return (self._other if self._moved() else self._usual).level()

    def holds(self, forget: Callable[[], None]) -> bool:  # noqa: ARG002
        """Nobody knows: either may count at any time."""
        return False

    def at_pin(self) -> bool:
        """Neither is at a pin."""
        return False

    def _hear(self, counts: bool, level: bool) -> None:
        if self._heard is not None and self._moved() is counts:
            self._heard(level)


class _Question(enum.IntEnum):
    """``enum hil_adc_question``."""

    VOLTS = 0
    BEGINS = 1
    STABLE = 2
    LISTENS = 3
    REQUESTS = 4
    DRIVES = 5
    NOTES = 6


_NO_PART = "ADC2 takes no part: it is off, or its {} is not set"
_NO_START = "{} starts nothing: it has to be the trigger that is chosen, and triggers have to be enabled"
_NOTES: tuple[tuple[str, str, str], ...] = (
    ("misuse", "CR2.ADON", "a conversion was started within 1 us of ADON: its result may be wrong"),
    ("misuse", "CR2.SWSTART", "a start together with ADON, or without, has no effect"),
    ("misuse", "CR2.SWSTART", _NO_START.format("SWSTART")),
    ("misuse", "CR2.JSWSTART", _NO_START.format("JSWSTART")),
    ("misuse", "CR2.CAL", "a converter has to be on for two of its clocks to be calibrated"),
    ("misuse", "CR2.CAL", "a conversion was started during the calibration: it is not made"),
    ("reserved", "CR1.DUALMOD", "these bits are those of ADC1 alone"),
    ("reserved", "CR1.DUALMOD", "the mode is reserved: ADC1 works alone"),
    (
        "unmodelled",
        "CR1.DUALMOD",
        "an interleaved mode that an injected group breaks off goes on with another distance",
    ),
    ("misuse", "CR1.DUALMOD", _NO_PART.format("EXTTRIG")),
    ("misuse", "CR1.DUALMOD", _NO_PART.format("JEXTTRIG")),
)
"""By ``enum hil_adc_note``."""

_ASK = ctypes.PYFUNCTYPE(ctypes.c_uint32, ctypes.c_uint32, ctypes.c_uint32)


class _Converter(BlockInC):
    """The part in C.

    Args:
        services: what the chip offers.
        base: address of SR.
        registers: by offset.
        master: of the dual modes, if this is its slave.
        answer: called with what C asks, and a value.

    Attributes:
        inputs: ``struct hil_adc_inputs``.
    """

    def __init__(
        self,
        services: Services,
        base: int,
        registers: Mapping[int, Register],
        master: _Converter | None,
        answer: Callable[[int, int], int],
    ) -> None:
        library = _library()
        self._answer = answer
        self._asked = _ASK(self._ask)
        block = library.hil_adc_new(services.time.queue, master and master.block, self._asked)
        super().__init__(services.time, block, library.hil_adc_free, base=base, registers=registers)
        self.inputs: Any = structure("hil_adc_inputs").from_address(library.hil_adc_inputs_of(self.block))
        self.reset: Callable[[], None] = functools.partial(library.hil_adc_reset, self.block)
        self.trigger: Callable[[bool], None] = functools.partial(library.hil_adc_trigger, self.block)
        self.interrupts: Callable[[ctypes.c_void_p, int], None]
        self.interrupts = functools.partial(library.hil_adc_interrupts, self.block)
        self.transfers: Callable[[ctypes.c_void_p, int], None]
        self.transfers = functools.partial(library.hil_adc_transfers, self.block)
        self._clock: Callable[[int], None] = functools.partial(library.hil_adc_clock, self.block)

    def set_clock(self, cycles: int) -> None:
        """Go on with so many cycles of HCLK for each clock; 0 stands still."""
        for channel in range(len(self.inputs.until)):
            self.forget(channel)
        self._clock(cycles)

    def forget(self, channel: int) -> None:
        """Have C ask anew for the voltage at a channel."""
        self.inputs.until[channel] = 0

    def _ask(self, question: int, value: int) -> int:
        try:
            return self._answer(question, value)
        except BaseException as trouble:  # noqa: BLE001 - ctypes would swallow it
            self.keep(trouble)
        return 0


class Adc(PeripheralInC):
    """One of the converters.

    Args:
        name: ``ADC1``.
        base: address of SR.
        services: what the chip offers. Used: the triggers as inputs, the interrupt, a DMA request of its name but for
            ADC2.
        pins: what stands at its channels.
        irq: number of its interrupt.
        master: the converter whose slave it is in the dual modes, and whose interrupt it shares.
        noise: of its readings.
        remapped: says whether AFIO has put the trigger of TIM8 in the place of EXTI's: ``ADC1_ETRGREG``.

    Attributes:
        internal: what the channels inside the chip see; a test may replace it.
        irq: its interrupt,
        converter: and the part in C.
    """

    REGISTERS: ClassVar[tuple[Register, ...]] = (
        Register("SR", 0x00, 0, 0x1F),
        Register("CR1", 0x04, 0, 0x00CF_FFFF),
        Register("CR2", CR2, 0, 0x00FE_F90F),
        Register("SMPR1", 0x0C, 0, 0x00FF_FFFF),
        Register("SMPR2", 0x10, 0, 0x3FFF_FFFF),
        *(Register(f"JOFR{number}", 0x10 + 4 * number, 0, 0xFFF) for number in range(1, 5)),
        Register("HTR", 0x24, 0xFFF, 0xFFF),
        Register("LTR", 0x28, 0, 0xFFF),
        Register("SQR1", 0x2C, 0, 0x00FF_FFFF),
        Register("SQR2", 0x30, 0, 0x3FFF_FFFF),
        Register("SQR3", 0x34, 0, 0x3FFF_FFFF),
        Register("JSQR", 0x38, 0, 0x003F_FFFF),
        *(Register(f"JDR{number}", 0x38 + 4 * number, 0, 0) for number in range(1, 5)),
        Register("DR", 0x4C, 0, 0),
    )

    converter: _Converter

    def __init__(
        self,
        name: str,
        base: int,
        services: Services,
        *,
        pins: Pins,
        irq: int,
        master: Adc | None = None,
        remapped: Callable[[str], bool] = lambda _field: False,
        noise: AdcNoise = QUIET,
    ) -> None:
        registers = {register.offset: register for register in self.REGISTERS}
        of_master = None if master is None else master.converter
        self.converter = self.in_c = _Converter(services, base, registers, of_master, self._answer)
        super().__init__(name, base, services)
        self._values = self.in_c.values
        self.internal = Internal()
        self._pins = pins
        self._remapped = remapped
        self._noisy = noise.on(name, lambda channel: self._volts_at(channel)[0]) if noise.rms_volts else None
        self.converter.inputs.reference_volts = pins.vdd_volts
        self._step_volts = pins.vdd_volts / (2 * _CODES)  # steps of the code begin at odd multiples of it
        self._forgets = [functools.partial(self.converter.forget, channel) for channel in range(len(CHANNELS[name]))]
        self._on_since_s = Fraction(0)
        self._triggers = (
            (_EXTSEL, EXTTRIG, self._signals(REGULAR_TRIGGERS[name]), functools.partial(self._edge, False)),
            (_JEXTSEL, JEXTTRIG, self._signals(INJECTED_TRIGGERS[name]), functools.partial(self._edge, True)),
        )
        self.irq: IrqLine = master.irq if master else services.irq(irq)
        core = drive_in_c([self.irq])
        if core is not None:
            self.converter.interrupts(core, irq)
        self._request = None if name == "ADC2" else services.dma(name)
        if self._request is not None and (line := self._request.in_c) is not None:
            self.converter.transfers(line.controller, line.number)

    def reset(self) -> None:
        """Go to the state after reset."""
        super().reset()
        self.converter.reset()
        self.after_clock_change()

    def after_clock_change(self) -> None:
        """Go on at the new rate."""
        self.converter.set_clock(int(self.services.clocks.kernel("ADC")) if self.clocked else 0)

    # --- what C asks

    def _answer(self, question: int, value: int) -> int:
        if question == _Question.VOLTS:
            self._sample(value)
        elif question == _Question.BEGINS:
            self._on_since_s = self.time.seconds(self.time.now)
        elif question == _Question.STABLE:
            return self.time.seconds(self.time.now) >= self._on_since_s + _STABILISATION_S
        elif question == _Question.LISTENS:
            self._listen()
        elif question == _Question.REQUESTS:
            if self._request is not None:
                self._request.set(bool(value))
        elif question == _Question.DRIVES:
            self.irq.set(bool(value))
        else:
            self.note(*_NOTES[value])
        return 0

    # --- triggers

    def _signals(self, names: tuple[str, ...]) -> Mapping[int, InputSignal]:
        return {number: self._signal(name) for number, name in enumerate(names)}

    def _signal(self, name: str) -> InputSignal:
        there = self.services.input(name)
        if name not in _REMAPPED:
            return there
        field, other = _REMAPPED[name]
        return _Either(there, self.services.input(other), functools.partial(self._remapped, f"{self.name}_{field}"))

    def _listen(self) -> None:
        control = self[CR2]
        for shift, enable, signals, hear in self._triggers:
            wanted = control & ADON and control & enable
            for number, signal in signals.items():
                callback = hear if wanted and number == control >> shift & 7 else None
                if signal.on_change != callback:
                    signal.on_change = callback

    def _edge(self, injected: bool, level: bool) -> None:
        if level:
            self.converter.trigger(injected)

    # --- voltages

    def _sample(self, channel: int) -> None:
        inputs = self.converter.inputs
        if self._noisy is not None:
            inputs.volts[channel] = self._noisy(channel)
        else:
            inputs.volts[channel], inputs.until[channel] = self._volts_at(channel)

    def _volts_at(self, channel: int) -> tuple[float, int]:
        """Return the voltage at a channel, and the cycle until which it is as good as that; 0: nobody knows."""
        volts: float | None = None
        until = 0
        if channel in (_SENSOR, _VREFINT) and self.name == "ADC1":
            if self[CR2] & TSVREFE:
                return self.internal.volts(channel), 0
        elif channel < len(CHANNELS[self.name]) and (pin := CHANNELS[self.name][channel]) in self._pins:
            volts, until = self._pins[pin].volts_for(self._step_volts, self._forgets[channel])
        if volts is None:
            self.note("misuse", f"IN{channel}", "nothing drives this channel, or it leads nowhere: it reads 0 V")
            return 0.0, until
        return volts, until


@functools.cache
def _library() -> Any:
    """Return the library, with the functions of the converters declared, called with Python's lock held."""
    library: Any = with_lock_held()
    pointer, word = ctypes.c_void_p, ctypes.c_uint32
    library.hil_adc_new.argtypes, library.hil_adc_new.restype = (pointer, pointer, _ASK), pointer
    library.hil_adc_inputs_of.argtypes, library.hil_adc_inputs_of.restype = (pointer,), pointer
    takes: dict[str, tuple[Any, ...]] = {
        "hil_adc_free": (),
        "hil_adc_reset": (),
        "hil_adc_trigger": (ctypes.c_bool,),
        "hil_adc_clock": (word,),
        "hil_adc_interrupts": (pointer, word),
        "hil_adc_transfers": (pointer, word),
    }
    for name, others in takes.items():
        function = getattr(library, name)
        function.argtypes, function.restype = (pointer, *others), None
    return library
