"""The three ADCs of an STM32F2, F4 or F7, with what they share (RM0410 section 15).

The converters stand in `adc_unit`. Here are the addresses, the prescaler, the interrupt they have in common, and the
channels inside the chip. Dual and triple modes are not modelled: each converter works alone.

Choices: at a channel that leads nowhere, or at a pin that floats, stands 0 V; with VBATE and TSVREFE both set, channel
18 is VBAT (the manual says so), and without either 0 V.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from functools import partial

from targets.mcu.fidelity import Fidelity
from targets.mcu.registers import Register
from targets.mcu.services import Services
from targets.mcu.stm32.adc_noise import QUIET, AdcNoise
from targets.mcu.stm32.adc_unit import CR2, REGISTERS, SR, Unit
from targets.mcu.stm32.converters import UNIT_SIZE, Converters
from targets.mcu.stm32.dma_requests import Requests

__all__ = ["Adc", "Internal"]

CSR, CCR, CDR = 0x300, 0x304, 0x308
MULTI, MULTI_DMA = 0x1F, 0xEF00
VBATE, TSVREFE = 1 << 22, 1 << 23
_PRESCALERS = (2, 4, 6, 8)
_VREFINT, _SENSOR = 17, 18
_DUAL_NOTE = "dual and triple modes are not modelled: each converter works alone"


@dataclass(frozen=True, slots=True, kw_only=True)
class Internal:
    """What the channels inside the chip see.

    Attributes:
        vrefint_volts: the internal reference; 1.21 V typical (DS11532, embedded internal reference voltage).
        temperature_c: of the die; 25 degrees is assumed.
        at_25_volts: what the sensor gives at 25 degrees; 0.76 V typical,
        volts_per_c: and its slope; 2.5 mV typical (DS11532, temperature sensor characteristics).
        vbat_volts: at the pin VBAT, which is divided by four; 3.3 V is assumed.
    """

    vrefint_volts: float = 1.21
    temperature_c: float = 25.0
    at_25_volts: float = 0.76
    volts_per_c: float = 0.0025
    vbat_volts: float = 3.3

    def volts(self, channel: int, control: int) -> float:
        """Return the voltage at a channel of ADC1 from 16 on; `control` is CCR."""
        if channel == _VREFINT and control & TSVREFE:
            return self.vrefint_volts
        if channel == _SENSOR and control & VBATE:
            return self.vbat_volts / 4
        if channel == _SENSOR and control & TSVREFE:
            return self.sensor_volts(self.temperature_c)
        return 0.0

    def sensor_volts(self, temperature_c: float) -> float:
        """Return what the sensor gives at a temperature."""
        return self.at_25_volts + (temperature_c - 25.0) * self.volts_per_c


class Adc(Converters[Unit]):
    """The converters and what they share.

    Args:
        base: address of ADC1_SR.
        services: what the chip offers. Used: inputs ``TIMx_TRGO`` inside the chip, the interrupt.
        requests: where the DMA requests ``ADC1`` to ``ADC3`` come from.
        irq: number of the interrupt.
        bus: whose clock is divided for the converters.
        most_hz: the fastest that the converters work.
        volts: returns the voltage at a pin of a converter, by its name and channel 0 to 15; None where nothing is.
        reference_volts: VREF+.
        triggers: names of signals by EXTSEL, as far as they are modelled,
        injected_triggers: and by JEXTSEL.
        enabled: says whether the clock of a converter is enabled, by its number from 0 on.
        noise: of what they read.

    Attributes:
        internal: what the channels inside the chip see; a test may replace it.
    """

    def __init__(
        self,
        base: int,
        services: Services,
        *,
        requests: Requests,
        irq: int,
        bus: str,
        most_hz: int,
        volts: Callable[[str, int], float | None],
        reference_volts: float,
        triggers: Mapping[int, str],
        injected_triggers: Mapping[int, str],
        noise: AdcNoise = QUIET,
        enabled: Callable[[int], bool],
    ) -> None:
        super().__init__("ADC", base, services, irq=irq)
        self.internal = Internal()
        self._volts = volts
        self._bus = bus
        self._most_hz = most_hz
        self._enabled = enabled
        self._units = [
            Unit(
                name,
                self.time,
                self._ends(
                    name,
                    volts=self._volts_at,
                    noise=noise,
                    requests=requests,
                    reference_volts=reference_volts,
                    triggers=triggers,
                    injected_triggers=injected_triggers,
                ),
            )
            for name in ("ADC1", "ADC2", "ADC3")
        ]
        for number, unit in enumerate(self._units):
            unit.on_interrupt = self._drive_irq
            for register in REGISTERS:
                offset = UNIT_SIZE * number + register.offset
                self._readers[offset] = partial(self._read_unit, number, register.offset)
                if register.writable:
                    self._writers[offset] = partial(self._write_unit, number, register.offset)

    def registers_of(self) -> Iterable[Register]:
        """Return the registers of each converter and the common ones."""
        for number in range(3):
            for register in REGISTERS:
                name, offset = f"ADC{number + 1}_{register.name}", UNIT_SIZE * number + register.offset
                yield replace(register, name=name, offset=offset)
        yield Register("CSR", CSR, 0, 0)
        yield Register("CCR", CCR, 0, 0x00C3_EF1F, MULTI | MULTI_DMA, fidelity=Fidelity.PARTLY, note=_DUAL_NOTE)
        yield Register("CDR", CDR, 0, 0, fidelity=Fidelity.ABSENT, note=_DUAL_NOTE)

    @property
    def clocked(self) -> bool:
        """Always True: each converter has a gate of its own."""
        return True

    @clocked.setter
    def clocked(self, clocked: bool) -> None:
        pass

    # --- what the chip calls

    def after_clock_change(self) -> None:
        """Go on at the new rate."""
        cycles = self.services.clocks.pclk(self._bus) * _PRESCALERS[self[CCR] >> 16 & 3]
        for number, unit in enumerate(self._units):
            unit.set_clock(cycles if self._enabled(number) else 0)

    # --- registers

    def _read_unit(self, number: int, offset: int) -> int:
        if not self._is_clocked(number, "a read while its clock is off gives 0"):
            return 0
        return self._units[number].read(offset)

    def _write_unit(self, number: int, offset: int, value: int) -> None:
        if not self._is_clocked(number, "a write while its clock is off is lost"):
            return
        unit = self._units[number]
        if not unit.clock_cycles:
            self.after_clock_change()  # its gate was opened since
        if offset == CR2 and value & 1 and not unit.values[CR2] & 1:
            self._check_rate()
        unit.write(offset, value)
        self[UNIT_SIZE * number + offset] = unit.values[offset]

    def _is_clocked(self, number: int, text: str) -> bool:
        if not self._enabled(number):
            self.services.notes.add("clock-off", self._units[number].name, text)
            return False
        return True

    def _check_rate(self) -> None:
        cycles = self._units[0].clock_cycles or self._units[1].clock_cycles or self._units[2].clock_cycles
        if cycles and self.time.hclk_hz / cycles > self._most_hz:
            text = f"ADCCLK is {float(self.time.hclk_hz / cycles) / 1e6:g} MHz, and {self._most_hz / 1e6:g} is the most"
            self.note("misuse", "CCR.ADCPRE", text)

    def read_CSR(self) -> int:
        """Return the flags of all converters."""
        return sum(unit.values[SR] << 8 * number for number, unit in enumerate(self._units))

    def write_CCR(self, value: int) -> None:
        """Set the prescaler and switch the channels inside."""
        self[CCR] = value
        self.after_clock_change()

    # --- voltages

    def _volts_at(self, unit: str, channel: int) -> float:
        if channel > 15:
            if unit == "ADC1":
                return self.internal.volts(channel, self[CCR])
            volts = None
        else:
            volts = self._volts(unit, channel)
        if volts is None:
            self.note("misuse", f"{unit}.IN{channel}", "nothing drives this channel, or it leads nowhere: it reads 0 V")
            return 0.0
        return volts
