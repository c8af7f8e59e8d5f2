"""AFIO of the STM32F1: which pin carries which signal, and which port an EXTI line has (RM0008 sections 9.3 and 9.4).

The tables `FIXED` and `REMAPS` are the pins of every alternate function of what is modelled (RM0008 tables 38 to 55,
DS5319 table 5). A field with a reserved value leaves the signals where they are (choice) and is noted.

SWJ_CFG is write-only: "when read, the value is undefined" (section 9.4.2). It reads as it was last written (choice):
published board support polls for that, and a change of another field that reads MAPR first leaves the debug pins alone.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import ClassVar

from targets.mcu.fidelity import Fidelity
from targets.mcu.pins import Pins
from targets.mcu.registers import Peripheral, Register
from targets.mcu.services import Services
from targets.mcu.signals import Signals

__all__ = [
    "FIXED",
    "HIGH_VALUE_LINE_REMAPS",
    "MISC_REMAP",
    "MOVED_REQUESTS",
    "REMAPS",
    "VALUE_LINE_REMAPS",
    "Afio",
    "Remap",
]


@dataclass(frozen=True, slots=True)
class Remap:
    """A field of AFIO_MAPR.

    Attributes:
        field: its name.
        shift: its lowest bit.
        mask: its bits, shifted down.
        pins: for each of its values that is not reserved, the pin of each signal.
    """

    field: str
    shift: int
    mask: int
    pins: Mapping[int, Mapping[str, str]]


def _signals(peripheral: str, signals: str, *variants: str) -> tuple[dict[str, str], ...]:
    names = [f"{peripheral}_{signal}" for signal in signals.split()]
    return tuple(dict(zip(names, pins.split(), strict=True)) for pins in variants)


_TIM1 = _signals(
    "TIM1",
    "ETR CH1 CH2 CH3 CH4 BKIN CH1N CH2N CH3N",
    "PA12 PA8 PA9 PA10 PA11 PB12 PB13 PB14 PB15",
    "PA12 PA8 PA9 PA10 PA11 PA6 PA7 PB0 PB1",
    "PE7 PE9 PE11 PE13 PE14 PE15 PE8 PE10 PE12",
)
_TIM2 = _signals(
    "TIM2",
    "ETR CH1 CH2 CH3 CH4",
    "PA0 PA0 PA1 PA2 PA3",
    "PA15 PA15 PB3 PA2 PA3",
    "PA0 PA0 PA1 PB10 PB11",
    "PA15 PA15 PB3 PB10 PB11",
)
_TIM3 = _signals("TIM3", "CH1 CH2 CH3 CH4", "PA6 PA7 PB0 PB1", "PB4 PB5 PB0 PB1", "PC6 PC7 PC8 PC9")
_TIM4 = _signals("TIM4", "CH1 CH2 CH3 CH4", "PB6 PB7 PB8 PB9", "PD12 PD13 PD14 PD15")
_USART1 = _signals("USART1", "TX RX", "PA9 PA10", "PB6 PB7")
_USART2 = _signals("USART2", "CTS RTS TX RX CK", "PA0 PA1 PA2 PA3 PA4", "PD3 PD4 PD5 PD6 PD7")
_USART3 = _signals(
    "USART3",
    "TX RX CK CTS RTS",
    "PB10 PB11 PB12 PB13 PB14",
    "PC10 PC11 PC12 PB13 PB14",
    "PD8 PD9 PD10 PD11 PD12",
)
_SPI1 = _signals("SPI1", "NSS SCK MISO MOSI", "PA4 PA5 PA6 PA7", "PA15 PB3 PB4 PB5")
_I2C1 = _signals("I2C1", "SCL SDA", "PB6 PB7", "PB8 PB9")
_CAN = _signals("CAN", "RX TX", "PA11 PA12", "PB8 PB9", "PD0 PD1")

REMAPS = (
    Remap("SPI1_REMAP", 0, 1, dict(enumerate(_SPI1))),
    Remap("I2C1_REMAP", 1, 1, dict(enumerate(_I2C1))),
    Remap("USART1_REMAP", 2, 1, dict(enumerate(_USART1))),
    Remap("USART2_REMAP", 3, 1, dict(enumerate(_USART2))),
    Remap("USART3_REMAP", 4, 3, dict(zip((0b00, 0b01, 0b11), _USART3, strict=True))),
    Remap("TIM1_REMAP", 6, 3, dict(zip((0b00, 0b01, 0b11), _TIM1, strict=True))),
    Remap("TIM2_REMAP", 8, 3, dict(enumerate(_TIM2))),
    Remap("TIM3_REMAP", 10, 3, dict(zip((0b00, 0b10, 0b11), _TIM3, strict=True))),
    Remap("TIM4_REMAP", 12, 1, dict(enumerate(_TIM4))),
    Remap("CAN_REMAP", 13, 3, dict(zip((0b00, 0b10, 0b11), _CAN, strict=True))),
)
"""The fields of AFIO_MAPR that move signals, and where to."""

VALUE_LINE_REMAPS = (
    Remap("TIM15_REMAP", 0, 1, dict(enumerate(_signals("TIM15", "CH1 CH2", "PA2 PA3", "PB14 PB15")))),
    Remap("TIM16_REMAP", 1, 1, dict(enumerate(_signals("TIM16", "CH1", "PB8", "PA6")))),
    Remap("TIM17_REMAP", 2, 1, dict(enumerate(_signals("TIM17", "CH1", "PB9", "PA7")))),
)
"""The same of AFIO_MAPR2 of the value line (RM0041 section 7.4.7)."""

HIGH_VALUE_LINE_REMAPS = (
    *VALUE_LINE_REMAPS,
    Remap("TIM13_REMAP", 8, 1, dict(enumerate(_signals("TIM13", "CH1", "PC8", "PB0")))),
    Remap("TIM14_REMAP", 9, 1, dict(enumerate(_signals("TIM14", "CH1", "PC9", "PB1")))),
    Remap("TIM12_REMAP", 12, 1, dict(enumerate(_signals("TIM12", "CH1 CH2", "PC4 PC5", "PB12 PB13")))),
)
"""The same of high density."""

MOVED_REQUESTS: Mapping[str, int] = {
    **dict.fromkeys(("TIM1_CH1", "TIM1_CH2"), 1 << 4),
    **dict.fromkeys(("TIM6_UP", "DAC_CH1", "TIM7_UP", "DAC_CH2"), 1 << 11),
}
"""The bits of AFIO_MAPR2 that move requests to DMA: TIM1_DMA_REMAP, TIM67_DAC_DMA_REMAP."""
MISC_REMAP = 1 << 13
"""Of AFIO_MAPR2: DMA2 channel 5 has an interrupt of its own; TIM15 takes the place of TIM5 as a trigger."""

FIXED: Mapping[str, str] = {
    "USART1_CK": "PA8",
    "USART1_CTS": "PA11",
    "USART1_RTS": "PA12",
    "TIM3_ETR": "PD2",
    "TIM4_ETR": "PE0",
    "TIM5_CH1": "PA0",
    "TIM5_CH2": "PA1",
    "TIM5_CH3": "PA2",
    "TIM5_CH4": "PA3",
    "TIM8_CH1": "PC6",
    "TIM8_CH2": "PC7",
    "TIM8_CH3": "PC8",
    "TIM8_CH4": "PC9",
    "TIM8_CH1N": "PA7",
    "TIM8_CH2N": "PB0",
    "TIM8_CH3N": "PB1",
    "TIM8_ETR": "PA0",
    "TIM8_BKIN": "PA6",
    "TIM15_CH1N": "PB15",
    "TIM15_BKIN": "PA9",
    "TIM16_CH1N": "PB6",
    "TIM16_BKIN": "PB5",
    "TIM17_CH1N": "PB7",
    "TIM17_BKIN": "PA10",
    "UART4_TX": "PC10",
    "UART4_RX": "PC11",
    "UART5_TX": "PC12",
    "UART5_RX": "PD2",
    "I2C1_SMBA": "PB5",
    "I2C2_SCL": "PB10",
    "I2C2_SDA": "PB11",
    "I2C2_SMBA": "PB12",
    "SPI2_NSS": "PB12",
    "SPI2_SCK": "PB13",
    "SPI2_MISO": "PB14",
    "SPI2_MOSI": "PB15",
    "SPI3_NSS": "PA15",
    "SPI3_SCK": "PB3",
    "SPI3_MISO": "PB4",
    "SPI3_MOSI": "PB5",
    "MCO": "PA8",
    "WKUP": "PA0",
    "TAMPER": "PC13",
}
"""Signals that always have the same pin."""

_DEBUG_PULLS: Mapping[str, bool | None] = {"PA13": True, "PA14": False, "PA15": True, "PB3": None, "PB4": True}
"""Pins of the debug port and their pulls (RM0008 section 9.3.5): JTMS/SWDIO, JTCK/SWCLK, JTDI, JTDO, NJTRST."""
_DEBUG_PINS = {
    0b000: ("PA13", "PA14", "PA15", "PB3", "PB4"),
    0b001: ("PA13", "PA14", "PA15", "PB3"),
    0b010: ("PA13", "PA14"),
    0b100: (),
}
"""Which of them it keeps, by SWJ_CFG; other values have no effect."""

_SWJ_CFG = 0b111 << 24
_PD01_REMAP = 1 << 15
_TIM5CH4_IREMAP = 1 << 16
_TRIGGERS = {"ADC1_ETRGINJ": 17, "ADC1_ETRGREG": 18, "ADC2_ETRGINJ": 19, "ADC2_ETRGREG": 20}
_EVOE = 1 << 7
_PORTS = "ABCDEFG"
_MAPR2 = Register("MAPR2", 0x1C, writable=1 << 10, ignored=1 << 10, note="FSMC_NADV: there is no FSMC")
_MAPR2_OF_VALUE_LINE = Register(
    "MAPR2",
    0x1C,
    writable=0x1F,
    ignored=0x08,
    fidelity=Fidelity.PARTLY,
    note="CEC_REMAP: there is no CEC",
)
_MAPR2_OF_HIGH_VALUE_LINE = replace(
    _MAPR2_OF_VALUE_LINE,
    writable=0x3F1F,
    ignored=0x0408,
    note="CEC_REMAP, FSMC_NADV: there are no CEC and FSMC",
)


class Afio(Peripheral):
    """AFIO.

    Args:
        name: ``AFIO``.
        base: address.
        services: what the chip offers.
        pins: the pins of the chip.
        signals: the signals it routes.
        shared_oscillator_pins: whether PD0 and PD1 are the pins of the oscillator unless PD01_REMAP is set, as they are
            on packages of up to 64 pins (RM0008 section 9.3.3).
        there: names of the peripherals that the chip has.
        value_line: it has the second register of the value line.

    Attributes:
        on_mapr2: called with the new value of AFIO_MAPR2 of the value line.
        on_tim5_ch4: called with whether channel 4 of TIM5 is connected to the LSI, after a change.
    """

    REGISTERS: ClassVar[tuple[Register, ...]] = (
        Register(
            "EVCR",
            0x00,
            writable=0xFF,
            fidelity=Fidelity.PARTLY,
            note="the pulse of SEV is one HCLK cycle (choice)",
        ),
        Register(
            "MAPR",
            0x04,
            writable=0x071F_FFFF,
            note="SWJ_CFG reads as written (choice)",
        ),
        Register("EXTICR1", 0x08, writable=0xFFFF),
        Register("EXTICR2", 0x0C, writable=0xFFFF),
        Register("EXTICR3", 0x10, writable=0xFFFF),
        Register("EXTICR4", 0x14, writable=0xFFFF),
    )

    def __init__(
        self,
        name: str,
        base: int,
        services: Services,
        pins: Pins,
        signals: Signals,
        *,
        shared_oscillator_pins: bool = True,
        there: Collection[str] = (),
        value_line: bool = False,
    ) -> None:
        has_fsmc = "FSMC" in there
        of_value_line = _MAPR2_OF_HIGH_VALUE_LINE if has_fsmc else _MAPR2_OF_VALUE_LINE
        self._more = (of_value_line,) if value_line else (_MAPR2,) if has_fsmc else ()
        self._remaps2 = (HIGH_VALUE_LINE_REMAPS if has_fsmc else VALUE_LINE_REMAPS) if value_line else ()
        self._has_tim8 = "TIM8" in there
        super().__init__(name, base, services)
        self._shared_oscillator_pins = shared_oscillator_pins
        self._pins = pins
        self._signals = signals
        self._debug_pins: tuple[str, ...] = ()
        self._event_out = signals.output("EVENTOUT")
        self.on_mapr2: Callable[[int], None] = lambda _value: None
        self.on_tim5_ch4: Callable[[bool], None] = lambda _inside: None
        for signal, pin in FIXED.items():
            signals.route(signal, pin)
        self.reset()

    def registers_of(self) -> Iterable[Register]:
        """Return the registers of this chip."""
        return (*self.REGISTERS, *self._more)

    def reset(self) -> None:
        """Every signal goes to its default pin, all debug pins to the debug port, every EXTI line to port A."""
        super().reset()
        for remap in (*REMAPS, *self._remaps2):
            self._route(remap.pins[0])
        self._give_debug_pins(_DEBUG_PINS[0])
        self._give_oscillator_pins(remapped=False)
        self.on_mapr2(0)
        self.on_tim5_ch4(False)
        for line in range(16):
            self._signals.route(f"EXTI{line}", f"PA{line}")
        self._signals.route("EVENTOUT", None)
        self._event_out.set(None)

    # --- remapping

    def trigger_moved(self, field: str) -> bool:
        """Say whether a trigger of a converter is that of TIM8: ``ADC1_ETRGINJ``, ``ADC2_ETRGREG`` and so on."""
        return self._has_tim8 and bool(self[0x04] >> _TRIGGERS[field] & 1)

    def write_MAPR(self, value: int) -> None:
        """Move signals, and keep or free the pins of the debug port."""
        old = self[0x04]
        self[0x04] = value
        self._remap(REMAPS, old, value)
        if (old ^ value) & _PD01_REMAP:
            self._give_oscillator_pins(remapped=bool(value & _PD01_REMAP))
        if (old ^ value) & _TIM5CH4_IREMAP:
            self.on_tim5_ch4(bool(value & _TIM5CH4_IREMAP))
        kept = _DEBUG_PINS.get((value & _SWJ_CFG) >> 24)
        if kept is not None:
            self._give_debug_pins(kept)

    def write_MAPR2(self, value: int) -> None:
        """Move signals."""
        old = self[0x1C]
        self[0x1C] = value
        self._remap(self._remaps2, old, value)
        self.on_mapr2(value)

    def _remap(self, remaps: Iterable[Remap], old: int, value: int) -> None:
        for remap in remaps:
            field = value >> remap.shift & remap.mask
            if field == old >> remap.shift & remap.mask:
                continue
            if field in remap.pins:
                self._route(remap.pins[field])
            else:
                self.note("reserved", f"MAPR.{remap.field}", f"the value {field:#04b} is reserved: nothing is moved")

    def read_MAPR(self) -> int:
        """All as written."""
        if self[0x04] & _SWJ_CFG:
            self.note("assumed", "MAPR.SWJ_CFG", "is write-only and read: it reads as it was last written")
        return self[0x04]

    def _route(self, pins: Mapping[str, str]) -> None:
        for signal, pin in pins.items():
            self._signals.route(signal, pin)

    def _give_debug_pins(self, kept: tuple[str, ...]) -> None:
        for name in self._debug_pins:
            if name not in kept:
                self._pins[name].unclaim()
        for name in kept:
            if name not in self._debug_pins:
                self._pins[name].claim("the debug port", pull=_DEBUG_PULLS[name])
        self._debug_pins = kept

    def _give_oscillator_pins(self, *, remapped: bool) -> None:
        for name in ("PD0", "PD1"):
            if remapped or not self._shared_oscillator_pins:
                self._pins[name].unclaim()
            else:
                self._pins[name].claim("the oscillator HSE", analog=True)

    # --- external interrupts

    def write_EXTICR1(self, value: int) -> None:
        """Choose the ports of lines 0 to 3."""
        self._choose_ports(0x08, 0, value)

    def write_EXTICR2(self, value: int) -> None:
        """Choose the ports of lines 4 to 7."""
        self._choose_ports(0x0C, 4, value)

    def write_EXTICR3(self, value: int) -> None:
        """Choose the ports of lines 8 to 11."""
        self._choose_ports(0x10, 8, value)

    def write_EXTICR4(self, value: int) -> None:
        """Choose the ports of lines 12 to 15."""
        self._choose_ports(0x14, 12, value)

    def _choose_ports(self, offset: int, first: int, value: int) -> None:
        self[offset] = value
        for index in range(4):
            line = first + index
            self._signals.route(f"EXTI{line}", self._pin(value >> 4 * index & 0xF, line))

    def _pin(self, port: int, number: int) -> str | None:
        """Return a pin by its port as registers number them, or None if the chip has no such port."""
        name = f"P{_PORTS[port]}{number}" if port < len(_PORTS) else ""
        return name if name in self._pins else None

    # --- event output

    def write_EVCR(self, value: int) -> None:
        """Choose the pin of EVENTOUT."""
        self[0x00] = value
        pin = self._pin(value >> 4 & 0b111, value & 0xF) if value & _EVOE else None
        self._signals.route("EVENTOUT", pin)
        self._event_out.set(None if pin is None else False)

    def send_event(self) -> None:
        """The core has executed SEV: a pulse on EVENTOUT."""
        if self._event_out.at_pin():
            self._event_out.set(True)
            self.time.after(1, lambda: self._event_out.set(False if self[0x00] & _EVOE else None))
