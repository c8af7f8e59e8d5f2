"""A channel of the DAC: what it holds, its triggers, its waves, and the voltage at its pin (RM0008 section 12.3).

The digital half works whether or not EN is set (section 12.3.1): data registers, triggers, requests and DOR go on, and
EN connects the output to the pin, whatever the port has configured it as. A pin that the port drives stays with the
port.

Choices where the manual is silent:

* The trigger EXTI9 is an edge of line 9 that EXTI has chosen by RTSR or FTSR, whatever it masks.
* What is held goes on to DOR when TEN falls.
* A trigger takes what is held when it comes, although DOR shows it three cycles of APB1 later (one after a software
  trigger): what DMA brings meanwhile is for the next trigger. A trigger while one is on its way is lost.
* The noise or triangle that is added is that before the trigger, so the first sum has 0xAAA or 0 of it; a sum above
  0xFFF is 0xFFF ("without overflow").
* A load under way stands still with the clock of APB1, and a trigger then is lost.
* The voltage follows DOR at once, and EN too: settling (3 us) and wake-up (6.5 us; DS5792, DAC characteristics) are
  left out. The buffer reaches both rails, and has 1 Ohm; without it the output has 15 kOhm, the most of DS5792.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

from targets.mcu.pins import Pin, Source
from targets.mcu.services import DmaRequest, InputSignal, Services
from targets.mcu.timebase import Event, Timebase

__all__ = ["CHANNEL_BITS", "EN", "FULL", "MAMP", "TRIGGERS", "TSEL", "VALUE_LINE_TRIGGERS", "Channel"]

EN, BOFF, TEN, TSEL, WAVE, MAMP, DMAEN = 1 << 0, 1 << 1, 1 << 2, 7 << 3, 3 << 6, 0xF << 8, 1 << 12
"""Of CR, of the lower channel."""
CHANNEL_BITS = 0x1FFF
FULL = 0xFFF
_BY_SOFTWARE = 7
_NOISE, _SEED = 1, 0xAAA
_BUFFER_OHMS, _BARE_OHMS = 1.0, 15_000.0
TRIGGERS: Mapping[int, str] = MappingProxyType(
    {0: "TIM6_TRGO", 1: "TIM8_TRGO", 2: "TIM7_TRGO", 3: "TIM5_TRGO", 4: "TIM2_TRGO", 5: "TIM4_TRGO", 6: "EXTI9_EDGE"}
)
"""By TSEL; 7 is software (RM0008 table 74)."""
VALUE_LINE_TRIGGERS: Mapping[int, str] = MappingProxyType({**TRIGGERS, 1: "TIM3_TRGO", 3: "TIM15_TRGO"})
"""The same on the value line up to medium density (RM0041 section 11.3.6)."""
_CYCLES_BY_TRIGGER, _CYCLES_BY_SOFTWARE = 3, 1


class Channel:
    """One channel.

    Args:
        number: 0 or 1.
        services: what the chip offers. Used: inputs ``TIMx_TRGO`` and ``EXTI9_EDGE``, DMA requests ``DAC_CH1`` and
            ``DAC_CH2``, the clock of APB1.
        pin: where it puts out its voltage; VREF+ is the supply of the pins.
        triggers: signals by TSEL.

    Attributes:
        number: 0 or 1.
        held: DHR, 12 bits.
        put_out: DOR.
        on_underrun: called at a trigger that comes before the request of the last one was served, which ends requests
            until DMAEN is set anew; None for a converter that does not know.
    """

    def __init__(self, number: int, services: Services, pin: Pin, triggers: Mapping[int, str]) -> None:
        self.number = number
        self.held = 0
        self.put_out = 0
        self.on_underrun: Callable[[], None] | None = None
        self._time = services.time
        self._pin = pin
        self._request: DmaRequest = services.dma(f"DAC_CH{number + 1}")
        self._triggers: Mapping[int, InputSignal] = {
            select: services.input(signal) for select, signal in triggers.items()
        }
        self._clock = services.clocks.pclk("APB1")
        self._load: _Load | None = None
        self._by_trigger = False
        self._asked = self._underrun = False
        self.reset()

    def reset(self) -> None:
        """Go to the state after reset."""
        self.held = self.put_out = self._control = self._step = 0
        self._noise = _SEED
        self._drop_load()
        self._end_requests()
        self._listen()
        self._drive()

    def set_up(self, control: int) -> None:
        """Follow the channel's half of CR."""
        changed, self._control = control ^ self._control, control
        if not control & WAVE:
            self._noise, self._step = _SEED, 0
        if changed & DMAEN and not control & DMAEN:
            self._end_requests()
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
        self._asked = False  # a word by whomever serves a request (choice)
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
                self._ask()

    def _ask(self) -> None:
        if self._underrun:
            return
        if self._asked and self.on_underrun is not None:
            self._request.set(False)
            self._underrun = True
            self.on_underrun()
        else:
            self._asked = True
            self._request.pulse()

    def _end_requests(self) -> None:
        self._request.set(False)
        self._asked = self._underrun = False

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
        return min(word, FULL)

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
        self.put_out = word
        self._drive()

    def _drive(self) -> None:
        if not self._control & EN:
            self._pin.put_out(None)
            return
        volts = self._pin.chip.vdd_volts * self.put_out / FULL
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
