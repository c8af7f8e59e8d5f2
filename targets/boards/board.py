"""A board: one microcontroller, and what is soldered around it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from itertools import takewhile
from typing import Any, Literal

from targets.mcu.errors import BoardError
from targets.mcu.variants import VARIANTS, ChipName, Variant

__all__ = ["Board", "Button", "Connector", "Led", "Straps"]

_SLOWEST_HSE_HZ = 1_000_000
_FASTEST_LSE_HZ = 1_000_000
_SLOWEST_START_US = 60_000_000
_MOST_NOISE_LSB = 1000


@dataclass(frozen=True, slots=True, kw_only=True)
class Led:
    """A light at a pin.

    Attributes:
        name: what the board calls it.
        pin: port pin, such as ``PC13``.
        active: the level at which it is lit.
    """

    name: str
    pin: str
    active: Literal["low", "high"] = "high"


@dataclass(frozen=True, slots=True, kw_only=True)
class Button:
    """A push button at a pin, with a resistor that gives the level while nobody pushes it.

    Attributes:
        name: what the board calls it.
        pin: port pin, such as ``PC13``.
        active: the level while it is pushed.
    """

    name: str
    pin: str
    active: Literal["low", "high"] = "high"


@dataclass(frozen=True, slots=True, kw_only=True)
class Straps:
    """The levels that the jumpers or resistors put on the boot pins (RM0008 section 3.4, RM0410 2.5, RM0433 2.6).

    Attributes:
        boot0: on an STM32F1, 0 boots from main flash and 1 from system memory or SRAM, by BOOT1; on an STM32F7, where
            the pin is called BOOT, and on an STM32H7 each level has an address in the option bytes.
        boot1: on an STM32F1, the level at PB2, which is BOOT1: with BOOT0 high, 0 is system memory and 1 is SRAM. The
            others have no such pin; leave it at 0.
    """

    boot0: Literal[0, 1] = 0
    boot1: Literal[0, 1] = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class Connector:
    """A header or a plug.

    Attributes:
        name: what the board calls it.
        pins: what its contacts are called on the board, in order; those that are no I/O pin, such as ``3V3``, too.
        usarts: the USARTs that can be reached there.
    """

    name: str
    pins: tuple[str, ...]
    usarts: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Board:
    """Chip, crystals, straps, lights, names of pins.

    Attributes:
        version: version of this format.
        name: what people call the board.
        chip: part number, without package material and temperature range.
        hse_hz: rate of the crystal or clock at OSC_IN, 1 to 25 MHz (STM32F7, H7: 50); left out where there is none.
        lse_hz: rate of the crystal at OSC32_IN; left out where there is none.
        hse_bypass: OSC_IN is driven by a clock rather than a crystal; programs set HSEBYP for that.
        hse_startup_us: from HSEON to HSERDY. Each crystal has its own (DS5319: typically 2 ms). 500 us is a choice:
            StdPeriph's SystemInit gives up after 1280 polls, which at 8 MHz is 0.8 to 2.4 ms, depending on the
            compiler, and boards are known to run such images from the crystal.
        lse_startup_us: from LSEON to LSERDY (DS5319: typically 2.5 s at 25 degrees).
        adc_noise_lsb: standard deviation of what the converters read, in steps of 12 bits; 0 is an ideal one, and what
            a board has is a choice. It is the same in every run, and on each board of this name.
        straps: the boot pins as the board is delivered.
        console: the USART that leads to the host by a debugger or a converter on the board; left out for none.
        leds: the lights.
        buttons: the push buttons, but for that of the reset.
        pull_ups: port pins with a resistor to 3.3 V.
        pull_downs: port pins with a resistor to ground.
        pins: port pin by the name that is printed on the board.
        connectors: headers and plugs.

    Raises:
        ValueError: a pin that the package does not have, a rate out of range. The message begins with the field.
    """

    name: str
    chip: ChipName
    version: Literal[1] = 1
    hse_hz: int | None = None
    lse_hz: int | None = None
    hse_bypass: bool = False
    hse_startup_us: int = 500
    lse_startup_us: int = 2_500_000
    adc_noise_lsb: float = 0.0
    straps: Straps = Straps()
    console: str = ""
    leds: tuple[Led, ...] = ()
    buttons: tuple[Button, ...] = ()
    pull_ups: tuple[str, ...] = ()
    pull_downs: tuple[str, ...] = ()
    pins: dict[str, str] = field(default_factory=dict)
    connectors: tuple[Connector, ...] = ()

    def __post_init__(self) -> None:
        fastest_hz = self.variant.fastest_hse_hz
        if self.hse_hz is not None and not _SLOWEST_HSE_HZ <= self.hse_hz <= fastest_hz:
            raise ValueError(f"hse_hz must be between {_SLOWEST_HSE_HZ} and {fastest_hz}, not {self.hse_hz}")
        if self.lse_hz is not None and not 0 < self.lse_hz <= _FASTEST_LSE_HZ:
            raise ValueError(f"lse_hz must be between 1 and {_FASTEST_LSE_HZ}, not {self.lse_hz}")
        for about, startup_us in (("hse", self.hse_startup_us), ("lse", self.lse_startup_us)):
            if not 0 < startup_us <= _SLOWEST_START_US:
                raise ValueError(f"{about}_startup_us must be between 1 and {_SLOWEST_START_US}, not {startup_us}")
        if not 0 <= self.adc_noise_lsb <= _MOST_NOISE_LSB:
            raise ValueError(f"adc_noise_lsb must be between 0 and {_MOST_NOISE_LSB}, not {self.adc_noise_lsb}")
        self._check_pins("leds", (led.pin for led in self.leds))
        self._check_pins("buttons", (button.pin for button in self.buttons))
        self._check_pins("pull_ups", self.pull_ups)
        self._check_pins("pull_downs", self.pull_downs)
        self._check_pins("pins", self.pins.values())
        self._check_usarts()
        if self.straps.boot1 and self.variant.boot1_pin is None:
            raise ValueError(f"straps set boot1, which the {self.chip} does not have")

    def _check_pins(self, about: str, pins: Iterable[str]) -> None:
        for pin in pins:
            if pin not in self.variant.pins:
                raise ValueError(f"{about} name '{pin}', which the {self.chip} does not have")

    def _check_usarts(self) -> None:
        if self.console and self.console not in self.variant.usarts:
            raise ValueError(f"console names '{self.console}', which the {self.chip} does not have")
        for connector in self.connectors:
            for usart in connector.usarts:
                if usart not in self.variant.usarts:
                    raise ValueError(f"connectors name '{usart}', which the {self.chip} does not have")

    @classmethod
    def from_mapping(cls, data: Mapping[str, Any]) -> Board:
        """Return the board that plain data describe, as TOML gives it.

        Raises:
            BoardError: a key that does not belong, one that is missing, or a value that makes no board.
        """
        try:
            parts: dict[str, Any] = _with_tuples(data)
            parts["straps"] = Straps(**parts.get("straps", {}))
            parts["leds"] = tuple(Led(**led) for led in parts.get("leds", ()))
            parts["buttons"] = tuple(Button(**button) for button in parts.get("buttons", ()))
            parts["connectors"] = tuple(Connector(**_with_tuples(item)) for item in parts.get("connectors", ()))
            if parts["chip"] not in VARIANTS:
                raise BoardError(f"no chip '{parts['chip']}'", hint=f"chips: {', '.join(_nearest(str(parts['chip'])))}")
            return cls(**parts)
        except KeyError as error:
            raise BoardError(f"the key {error} is missing") from None
        except (TypeError, ValueError) as error:
            raise BoardError(str(error)) from None

    @property
    def variant(self) -> Variant:
        """Memory and pins of the chip."""
        return VARIANTS[self.chip]

    @property
    def usarts(self) -> tuple[str, ...]:
        """The USARTs that can be reached, in order, the console first; all of the chip if no connector names any."""
        reached = {usart for connector in self.connectors for usart in connector.usarts}
        found = tuple(usart for usart in self.variant.usarts if usart in reached) or self.variant.usarts
        return tuple(sorted(found, key=lambda usart: usart != self.console))

    def pulled(self, straps: Straps | None = None) -> dict[str, bool]:
        """Return the level to which resistors on the board pull each port pin that has one, BOOT1 among them."""
        levels = {button.pin: button.active == "low" for button in self.buttons}
        levels |= dict.fromkeys(self.pull_downs, False) | dict.fromkeys(self.pull_ups, True)
        boot1_pin = self.variant.boot1_pin
        return levels if boot1_pin is None else {boot1_pin: bool((straps or self.straps).boot1), **levels}

    def port_pin(self, name: str) -> str | None:
        """Return the port pin for a name that is printed on the board, or for its own name; None for no such pin."""
        if name in self.pins:
            return self.pins[name]
        return name if name in self.variant.pins else None


def _nearest(chip: str) -> list[str]:
    """Return the chips that can be chosen, and are most like one that cannot, the nearest first."""
    from difflib import get_close_matches

    name = chip.upper()
    alike = get_close_matches(name, VARIANTS, n=len(VARIANTS), cutoff=0)

    def begins_alike(one: str) -> int:
        return sum(1 for _ in takewhile(lambda pair: pair[0] == pair[1], zip(one, name, strict=False)))

    return sorted(alike, key=begins_alike, reverse=True)[:3]


def _with_tuples(data: Mapping[str, Any]) -> dict[str, Any]:
    return {key: tuple(value) if isinstance(value, list) else value for key, value in data.items()}
