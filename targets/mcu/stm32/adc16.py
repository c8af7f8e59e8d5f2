"""The 16-bit ADCs of an STM32H7 that share a clock and an interrupt: ADC1 with ADC2, or ADC3 alone (RM0433 section 25).

The converters stand in `adc16_unit`. Here are the addresses, the clock, the interrupt they have in common, and the
channels inside the chip. Dual modes are not modelled: each converter works alone.

On revision V the clock is divided by two once more, whatever CKMODE says (RM0433, ADC clocks; ST's driver, too, which
reckons so in `ADC_ConfigureBoostMode`).

Choices: at a pin that floats, or at a channel that leads nowhere or is not preselected (PCSEL), stands 0 V.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial

from targets.mcu.fidelity import Fidelity
from targets.mcu.registers import Register
from targets.mcu.services import Services
from targets.mcu.stm32.adc16_registers import BOOST, CR, ISR, PCSEL, REGISTERS
from targets.mcu.stm32.adc16_unit import Unit
from targets.mcu.stm32.adc_noise import QUIET, AdcNoise
from targets.mcu.stm32.converters import UNIT_SIZE, Converters
from targets.mcu.stm32.dma_requests import Requests

__all__ = ["Adc16", "Inside"]

CSR, CCR, CDR, CDR2 = 0x300, 0x308, 0x30C, 0x310
DUAL, DUAL_SETTINGS = 0x1F, 0xCF00
VREFEN, TSEN, VBATEN = 1 << 22, 1 << 23, 1 << 24
PRESCALERS = (1, 2, 4, 6, 8, 10, 12, 16, 32, 64, 128, 256)
"""By CCR.PRESC; what is above them is reserved, and counts as the last one (choice)."""
_SYNCHRONOUS = (0, 1, 2, 4)  # what CKMODE divides the bus clock by
_BOOST_MHZ = (Fraction(25, 4), Fraction(25, 2), Fraction(25), Fraction(50))
"""How fast the converter may run by BOOST, on revision V (RM0433, ADC_CR; DS12117, ADC characteristics)."""
_DUAL_NOTE = "dual modes are not modelled: each converter works alone"


@dataclass(frozen=True, slots=True, kw_only=True)
class Inside:
    """What the channels inside the chip see.

    Attributes:
        vrefint_volts: the internal reference; 1.216 V typical (DS12117, embedded reference voltage).
        temperature_c: of the die; 25 degrees is assumed.
        at_30_volts: what the sensor gives at 30 degrees; 0.62 V typical,
        volts_per_c: and its slope; 2 mV typical (DS12117, temperature sensor characteristics).
        vbat_volts: at the pin VBAT, which is divided by four; 3.3 V is assumed.
    """

    vrefint_volts: float = 1.216
    temperature_c: float = 25.0
    at_30_volts: float = 0.62
    volts_per_c: float = 0.002
    vbat_volts: float = 3.3

    def volts(self, source: str, control: int) -> float:
        """Return the voltage of ``VREFINT``, ``SENSE`` or ``VBAT``, 0 unless it is switched on in `control`, CCR."""
        if source == "VREFINT" and control & VREFEN:
            return self.vrefint_volts
        if source == "SENSE" and control & TSEN:
            return self.sensor_volts(self.temperature_c)
        if source == "VBAT" and control & VBATEN:
            return self.vbat_volts / 4
        return 0.0

    def sensor_volts(self, temperature_c: float) -> float:
        """Return what the sensor gives at a temperature."""
        return self.at_30_volts + (temperature_c - 30.0) * self.volts_per_c


class Adc16(Converters[Unit]):
    """Converters and what they share.

    Args:
        name: ``ADC12``, as the clock gate is called.
        base: address of the first converter.
        services: what the chip offers. Used: inputs ``TIMx_TRGO`` inside the chip, the interrupt.
        units: names of the converters.
        requests: where the DMA requests, by these names, come from.
        irq: number of the interrupt.
        kernel_hz: rate of the asynchronous clock.
        volts: returns the voltage at a pin of a converter, by its name and channel; None where nothing is.
        inside: what else stands at channels, by name of the converter and channel; see `Inside.volts`.
        reference_volts: VREF+.
        triggers: names of signals by EXTSEL, as far as they are modelled,
        injected_triggers: and by JEXTSEL.
        noise: of what they read.

    Attributes:
        internal: what the channels inside the chip see; a test may replace it.
    """

    def __init__(
        self,
        name: str,
        base: int,
        services: Services,
        *,
        units: Sequence[str],
        requests: Requests,
        irq: int,
        kernel_hz: Callable[[], Fraction],
        volts: Callable[[str, int], float | None],
        inside: Mapping[str, Mapping[int, str]],
        reference_volts: float,
        triggers: Mapping[int, str],
        injected_triggers: Mapping[int, str],
        noise: AdcNoise = QUIET,
    ) -> None:
        self._names = units
        super().__init__(name, base, services, irq=irq)
        self.internal = Inside()
        self._kernel_hz = kernel_hz
        self._volts = volts
        self._inside = inside
        self._clock_hz = Fraction(0)
        self._units = [
            Unit(
                unit,
                self.time,
                self._ends(
                    unit,
                    volts=self._volts_at,
                    noise=noise,
                    requests=requests,
                    reference_volts=reference_volts,
                    triggers=triggers,
                    injected_triggers=injected_triggers,
                ),
            )
            for unit in units
        ]
        for number, unit in enumerate(self._units):
            unit.on_flags = self._drive_irq
            unit.on_enable = partial(self._check_rate, unit)
            for register in REGISTERS:
                offset = UNIT_SIZE * number + register.offset
                self._readers[offset] = partial(unit.read, register.offset)
                if register.writable:
                    self._writers[offset] = partial(self._write_unit, number, register.offset)

    def registers_of(self) -> Iterable[Register]:
        """Return the registers of each converter and the common ones."""
        for number, unit in enumerate(self._names):
            for register in REGISTERS:
                yield replace(register, name=f"{unit}_{register.name}", offset=UNIT_SIZE * number + register.offset)
        yield Register("CSR", CSR, 0, 0)
        yield Register("CCR", CCR, 0, 0x01FF_CF1F, DUAL | DUAL_SETTINGS, fidelity=Fidelity.PARTLY, note=_DUAL_NOTE)
        yield Register("CDR", CDR, 0, 0, fidelity=Fidelity.ABSENT, note=_DUAL_NOTE)
        yield Register("CDR2", CDR2, 0, 0, fidelity=Fidelity.ABSENT, note=_DUAL_NOTE)

    # --- what the chip calls

    def after_clock_change(self) -> None:
        """Go on at the new rate."""
        control = self[CCR]
        if mode := control >> 16 & 3:
            cycles = Fraction(2 * _SYNCHRONOUS[mode] * self.services.clocks.pclk("AHB"))
        else:
            prescaler = PRESCALERS[min(control >> 18 & 0xF, len(PRESCALERS) - 1)]
            kernel_hz = self._kernel_hz()
            cycles = 2 * prescaler * self.time.hclk_hz / kernel_hz if kernel_hz else Fraction(0)
        self._clock_hz = self.time.hclk_hz / cycles if cycles else Fraction(0)
        for unit in self._units:
            unit.set_clock(cycles)

    # --- registers

    def _write_unit(self, number: int, offset: int, value: int) -> None:
        unit = self._units[number]
        unit.write(offset, value)
        self[UNIT_SIZE * number + offset] = unit.values[offset]
        self[UNIT_SIZE * number + CR] = unit.values[CR]

    def _check_rate(self, unit: Unit) -> None:
        most = _BOOST_MHZ[(unit.values[CR] & BOOST) >> 8]
        if not self._clock_hz:
            self.note("misuse", f"{unit.name}_CR.ADEN", "the clock of the converter stands still: ADRDY never comes")
        elif self._clock_hz > most * 1_000_000:
            rate = float(self._clock_hz) / 1e6
            text = f"the converter runs at {rate:g} MHz, and with this BOOST {float(most):g} MHz is the most"
            self.note("misuse", f"{unit.name}_CR.BOOST", text)

    def read_CSR(self) -> int:
        """Return the flags of both converters."""
        return sum((unit.values[ISR] & 0x7FF) << 16 * number for number, unit in enumerate(self._units))

    def write_CCR(self, value: int) -> None:
        """Set the clock and switch the channels inside."""
        self[CCR] = value
        self.after_clock_change()

    # --- voltages

    def _volts_at(self, unit: str, channel: int) -> float:
        if source := self._inside.get(unit, {}).get(channel):
            return self.internal.volts(source, self[CCR])
        values = self._units[self._names.index(unit)].values
        if not values[PCSEL] >> channel & 1:
            self.note("misuse", f"{unit}_PCSEL", f"channel {channel} is converted without being preselected: 0 V")
            return 0.0
        volts = self._volts(unit, channel)
        if volts is None:
            self.note("misuse", f"{unit}.INP{channel}", "nothing drives this channel, or it leads nowhere: 0 V")
            return 0.0
        return volts
