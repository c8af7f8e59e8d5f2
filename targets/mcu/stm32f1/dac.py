"""The converters to analog of high-density devices: two channels, at PA4 and PA5 (RM0008 section 12).

The digital half works whether or not EN is set (section 12.3.1): data registers, triggers, requests and DOR go on, and
EN connects the output to the pin, whatever the port has configured it as. A pin that the port drives stays with the
port.

Choices where the manual is silent:

* The trigger EXTI9 is a rising edge at the pin that AFIO has chosen for line 9, whatever EXTI masks. SWTRIGR reads 0.
* What is held goes on to DOR when TEN falls.
* A data register reads as what its channel holds now, whichever register has put it there; after DHR8R the lowest four
  bits are 0.
* A trigger takes what is held when it comes, although DOR shows it three cycles of APB1 later (one after a software
  trigger): what DMA brings meanwhile is for the next trigger. A trigger while one is on its way is lost.
* The noise or triangle that is added is that before the trigger, so the first sum has 0xAAA or 0 of it; a sum above
  0xFFF is 0xFFF ("without overflow").
* TSEL and MAMP keep their values while EN was set before and stays set.
* A load under way stands still with the clock of APB1, and a trigger then is lost.
* The voltage follows DOR at once, and EN too: settling (3 us) and wake-up (6.5 us; DS5792, DAC characteristics) are
  left out. The buffer reaches both rails, and has 1 Ohm; without it the output has 15 kOhm, the most of DS5792.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import partial
from types import MappingProxyType

from targets.mcu.fidelity import Fidelity
from targets.mcu.pins import Pins, Source
from targets.mcu.registers import Peripheral, Register
from targets.mcu.services import DmaRequest, InputSignal, Services
from targets.mcu.timebase import Event, Timebase

__all__ = ["Dac"]

CR, SWTRIGR = 0x00, 0x04
RIGHT, LEFT, BYTE, RIGHT_DUAL, LEFT_DUAL, BYTE_DUAL = range(6)
_DATA = {
    0x08: ("DHR12R1", RIGHT, 0x0FFF),
    0x0C: ("DHR12L1", LEFT, 0xFFF0),
    0x10: ("DHR8R1", BYTE, 0x00FF),
    0x14: ("DHR12R2", RIGHT, 0x0FFF),
    0x18: ("DHR12L2", LEFT, 0xFFF0),
    0x1C: ("DHR8R2", BYTE, 0x00FF),
    0x20: ("DHR12RD", RIGHT_DUAL, 0x0FFF_0FFF),
    0x24: ("DHR12LD", LEFT_DUAL, 0xFFF0_FFF0),
    0x28: ("DHR8RD", BYTE_DUAL, 0xFFFF),
}
DOR = (0x2C, 0x30)

EN, BOFF, TEN, TSEL, WAVE, MAMP, DMAEN = 1 << 0, 1 << 1, 1 << 2, 7 << 3, 3 << 6, 0xF << 8, 1 << 12
_CHANNEL_BITS = 0x1FFF
_BY_SOFTWARE = 7
_NOISE, _SEED = 1, 0xAAA
_FULL = 0xFFF
_PINS = ("PA4", "PA5")
_BUFFER_OHMS, _BARE_OHMS = 1.0, 15_000.0
_TRIGGERS = MappingProxyType(
    {0: "TIM6_TRGO", 1: "TIM8_TRGO", 2: "TIM7_TRGO", 3: "TIM5_TRGO", 4: "TIM2_TRGO", 5: "TIM4_TRGO", 6: "EXTI9"}
)
"""By TSEL; 7 is software."""
_CYCLES_BY_TRIGGER, _CYCLES_BY_SOFTWARE = 3, 1
_ANALOG = "the output follows DOR and EN at once, and the buffer reaches both rails (choice)"


class Dac(Peripheral):
    """The DAC.

    Args:
        base: address of CR.
        services: what the chip offers. Used: inputs ``TIMx_TRGO`` and ``EXTI9``, DMA requests ``DAC_CH1`` and
            ``DAC_CH2``, the clock of APB1.
        pins: the pins of the chip, whose supply is VREF+.
    """

    REGISTERS = (
        Register("CR", CR, 0, _CHANNEL_BITS << 16 | _CHANNEL_BITS, fidelity=Fidelity.PARTLY, note=_ANALOG),
        Register("SWTRIGR", SWTRIGR, 0, 0x3),
        *(Register(name, offset, 0, writable) for offset, (name, _, writable) in _DATA.items()),
        Register("DOR1", DOR[0], 0, 0),
        Register("DOR2", DOR[1], 0, 0),
    )

    def __init__(self, base: int, services: Services, pins: Pins) -> None:
        super().__init__("DAC", base, services)
        self._channels = tuple(_Channel(number, self, services, pins) for number in range(2))
        for offset, (name, form, _) in _DATA.items():
            both = form >= RIGHT_DUAL
            channels = self._channels if both else (self._channels[name.endswith("2")],)
            self._readers[offset] = partial(self._read_data, channels, form)
            self._writers[offset] = partial(self._write_data, channels, form)

    # --- what the chip calls

    def reset(self) -> None:
        """Go to the state after reset: outputs off, nothing held."""
        super().reset()
        for channel in self._channels:
            channel.reset()

    def after_clock_change(self) -> None:
        """Go on at the new rate of APB1."""
        cycles = self.services.clocks.pclk("APB1") if self.clocked else 0
        for channel in self._channels:
            channel.set_clock(cycles)

    # --- registers

    def write_CR(self, value: int) -> None:
        """Set up both channels."""
        for channel in self._channels:
            shift, old = 16 * channel.number, self[CR]
            frozen = TSEL | MAMP if old >> shift & value >> shift & EN else 0
            if (old ^ value) >> shift & frozen:
                text = f"TSEL{channel.number + 1} and MAMP{channel.number + 1} keep their values while EN is set"
                self.note("misuse", f"CR.EN{channel.number + 1}", text)
            value = value & ~(frozen << shift) | old & frozen << shift
        self[CR] = value
        for channel in self._channels:
            channel.set_up(value >> 16 * channel.number & _CHANNEL_BITS)

    def read_SWTRIGR(self) -> int:
        """Write-only."""
        return 0

    def write_SWTRIGR(self, value: int) -> None:
        """Trigger the channels that wait for software; at once, for both at the same cycle."""
        for channel in self._channels:
            if value >> channel.number & 1:
                channel.trigger_by_software()

    def _read_data(self, channels: Iterable[_Channel], form: int) -> int:
        held = [channel.held for channel in channels]
        shift = 8 if form == BYTE_DUAL else 16
        return sum(_shown(word, form) << shift * index for index, word in enumerate(held))

    def _write_data(self, channels: Iterable[_Channel], form: int, value: int) -> None:
        shift = 8 if form == BYTE_DUAL else 16
        for index, channel in enumerate(channels):
            channel.hold(_taken(value >> shift * index, form))


class _Channel:
    """One channel.

    Attributes:
        number: 0 or 1.
        held: DHR, 12 bits.
    """

    def __init__(self, number: int, dac: Dac, services: Services, pins: Pins) -> None:
        self.number = number
        self.held = 0
        self._dac = dac
        self._time = services.time
        self._pin = pins[_PINS[number]]
        self._vref_volts = pins.vdd_volts
        self._request: DmaRequest = services.dma(f"DAC_CH{number + 1}")
        self._triggers: Mapping[int, InputSignal] = {
            select: services.input(signal) for select, signal in _TRIGGERS.items()
        }
        self._clock = services.clocks.pclk("APB1")
        self._load: _Load | None = None
        self._by_trigger = False
        self.reset()

    def reset(self) -> None:
        """Go to the state after reset."""
        self.held = self._control = self._step = 0
        self._noise = _SEED
        self._drop_load()
        self._request.set(False)
        self._listen()
        self._drive()

    def set_up(self, control: int) -> None:
        """Follow the channel's half of CR."""
        changed, self._control = control ^ self._control, control
        if not control & WAVE:
            self._noise, self._step = _SEED, 0
        if changed & DMAEN and not control & DMAEN:
            self._request.set(False)
        self._listen()
        if changed & TEN and not control & TEN:
            self._drop_load()
            self._load_held()
        self._drive()

    def set_clock(self, cycles: int) -> None:
        """Go on with that many HCLK cycles per cycle of APB1; 0 stands still."""
        if self._load is not None:
            self._load.set_clock(self._clock, cycles)
        self._clock = cycles

    # --- data and triggers

    def hold(self, word: int) -> None:
        """Take a word into DHR; without a trigger it goes on to DOR by itself."""
        self.held = word
        if not self._control & TEN:
            self._load_held()

    def trigger_by_software(self) -> None:
        """SWTRIG was set."""
        if self._control & TEN and self._control & TSEL == _BY_SOFTWARE << 3:
            self._triggered(_CYCLES_BY_SOFTWARE)

    def _listen(self) -> None:
        chosen = (self._control & TSEL) >> 3 if self._control & TEN else _BY_SOFTWARE
        for select, signal in self._triggers.items():
            listener = self._edge if select == chosen else None
            if signal.on_change != listener:
                signal.on_change = listener

    def _edge(self, level: bool) -> None:
        if level and self._clock:
            self._triggered(_CYCLES_BY_TRIGGER)
            if self._control & DMAEN:
                self._request.pulse()

    def _triggered(self, cycles: int) -> None:
        if self._load is None or not self._by_trigger:
            self._drop_load()
            word = self._with_wave(self.held)
            self._by_trigger = True
            self._begin_load(cycles, lambda: self._loaded(word))

    def _with_wave(self, word: int) -> int:
        """Return a word with noise or triangle added, which then go on."""
        wave = (self._control & WAVE) >> 6
        amplitude = (1 << min((self._control & MAMP) >> 8, 11) + 1) - 1
        if wave == _NOISE:
            word += self._noise & amplitude
            self._noise = _next_noise(self._noise)
        elif wave:
            step = self._step % (2 * amplitude)
            word += step if step <= amplitude else 2 * amplitude - step
            self._step = step + 1
        return min(word, _FULL)

    # --- DOR

    def _load_held(self) -> None:
        if self._load is None:
            self._by_trigger = False
            self._begin_load(1, lambda: self._loaded(self.held))

    def _begin_load(self, cycles: int, action: Callable[[], None]) -> None:
        self._load = _Load(self._time, cycles * self._clock, cycles, action)

    def _drop_load(self) -> None:
        if self._load is not None:
            self._load.cancel()
            self._load = None

    def _loaded(self, word: int) -> None:
        self._load = None
        self._dac[DOR[self.number]] = word
        self._drive()

    def _drive(self) -> None:
        if not self._control & EN:
            self._pin.put_out(None)
            return
        volts = self._vref_volts * self._dac[DOR[self.number]] / _FULL
        self._pin.put_out(Source(volts, _BARE_OHMS if self._control & BOFF else _BUFFER_OHMS))


class _Load:
    """A word on its way to DOR.

    Args:
        time: cycles and events.
        hclk_cycles: from now on; 0 while the clock stands still.
        cycles: the same in cycles of APB1.
        action: what happens then.
    """

    def __init__(self, time: Timebase, hclk_cycles: int, cycles: int, action: Callable[[], None]) -> None:
        self._time = time
        self._left = cycles
        self._action = action
        self._event: Event | None = time.after(hclk_cycles, action) if hclk_cycles else None

    def cancel(self) -> None:
        """Have it not happen."""
        self._time.cancel(self._event)

    def set_clock(self, before: int, now: int) -> None:
        """Go on at another rate."""
        if self._event is not None:
            self._left = -((self._time.now - self._event.cycle) // before)
            self._time.cancel(self._event)
            self._event = None
        if now:
            self._event = self._time.after(self._left * now, self._action)


def _next_noise(word: int) -> int:
    """Return the next state of the LFSR: x^12 + x^6 + x^4 + x + 1, and out of 0 a 1 (RM0008 section 12.3.8)."""
    into = (word ^ word >> 1 ^ word >> 4 ^ word >> 6) & 1 if word else 1
    return word >> 1 | into << 11


def _taken(value: int, form: int) -> int:
    """Return the 12 bits that a write gives to a channel."""
    if form in (BYTE, BYTE_DUAL):
        return (value & 0xFF) << 4
    return value >> 4 & _FULL if form in (LEFT, LEFT_DUAL) else value & _FULL


def _shown(word: int, form: int) -> int:
    """Return how a register shows 12 bits."""
    if form in (BYTE, BYTE_DUAL):
        return word >> 4
    return word << 4 if form in (LEFT, LEFT_DUAL) else word
