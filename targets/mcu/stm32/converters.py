"""Common to the ADCs of all families: what a converter is connected to, and converters behind one interrupt."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Generic, Protocol, TypeVar

from targets.mcu.registers import Peripheral
from targets.mcu.services import InputSignal, Services
from targets.mcu.stm32.adc_noise import AdcNoise
from targets.mcu.stm32.dma_requests import Requests

__all__ = ["UNIT_SIZE", "Converters", "Ends", "Note"]

UNIT_SIZE = 0x100
"""How far the registers of one converter lie from those of the next."""

Note = Callable[[str, str, str], None]


class KeptRequest(Protocol):
    """A DMA request whose level can be asked for.

    Attributes:
        level: as last set.
        on_last: called after the last transfer of the count that a stream was given, where a controller says so.
    """

    @property
    def level(self) -> bool:
        """See the class."""

    @property
    def on_last(self) -> Callable[[], None] | None:
        """See the class."""

    @on_last.setter
    def on_last(self, listener: Callable[[], None] | None) -> None: ...

    def set(self, level: bool) -> None:
        """Drive the request."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Ends:
    """What a converter is connected to.

    Attributes:
        volts: returns the voltage at a channel.
        reference_volts: VREF+.
        request: the DMA request.
        triggers: listeners to the regular triggers, by EXTSEL,
        injected_triggers: and to those of the injected group, by JEXTSEL.
        note: notes something about a register.
    """

    volts: Callable[[int], float]
    reference_volts: float
    request: KeptRequest
    triggers: Mapping[int, InputSignal]
    injected_triggers: Mapping[int, InputSignal]
    note: Note


class Converter(Protocol):
    """One of them, as its block sees it."""

    @property
    def interrupt(self) -> bool:
        """Whether a flag is set whose interrupt is enabled."""

    def reset(self) -> None:
        """Go to the state after reset."""


UnitT = TypeVar("UnitT", bound=Converter)


class Converters(Peripheral, Generic[UnitT]):
    """Converters that share a clock and an interrupt.

    Args:
        name: of the block; registers that are of none of its converters have it.
        base: address of the first converter.
        services: what the chip offers. Used: inputs ``TIMx_TRGO`` inside the chip, the interrupt.
        irq: number of the interrupt.
    """

    _units: Sequence[UnitT]

    def __init__(self, name: str, base: int, services: Services, *, irq: int) -> None:
        super().__init__(name, base, services)
        self._irq = services.irq(irq)
        self._irq_level = False

    def _ends(
        self,
        unit: str,
        *,
        volts: Callable[[str, int], float],
        requests: Requests,
        reference_volts: float,
        triggers: Mapping[int, str],
        injected_triggers: Mapping[int, str],
        noise: AdcNoise,
    ) -> Ends:
        """Tie a converter to what is around it; voltages go by its name and channel, triggers are names of signals."""
        return Ends(
            volts=noise.on(unit, partial(volts, unit)),
            reference_volts=reference_volts,
            request=requests.line(unit),
            triggers={number: self.services.input(signal) for number, signal in triggers.items()},
            injected_triggers={number: self.services.input(signal) for number, signal in injected_triggers.items()},
            note=partial(self._note_of, unit),
        )

    def note(self, kind: str, where: str, text: str) -> None:
        """Note something; registers of a converter have its name already."""
        self.services.notes.add(kind, where if where.startswith("ADC") else f"{self.name}_{where}", text)

    def _note_of(self, unit: str, kind: str, where: str, text: str) -> None:
        self.note(kind, f"{unit}_{where}", text)

    def reset(self) -> None:
        """Go to the state after reset."""
        super().reset()
        for unit in self._units:
            unit.reset()
        self.after_clock_change()

    def _drive_irq(self) -> None:
        level = any(unit.interrupt for unit in self._units)
        if level is not self._irq_level:
            self._irq_level = level
            self._irq.set(level)
