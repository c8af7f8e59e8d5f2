"""The self-tests of high density can fail, as those in `test_defects`; for C see `measure.core_defects`."""

from __future__ import annotations

import functools

import pytest

from targets.mcu.pins import Pin
from targets.mcu.stm32.tim.effects import TimerEffects
from targets.mcu.stm32f1.afio import Afio
from targets.mcu.stm32f1.chip import Stm32f103
from targets.mcu.stm32f1.dac import Dac
from targets.mcu.stm32f1.dac_channel import Channel
from targets.mcu.stm32f1.dma import Dma
from targets.mcu.stm32f1.input_choice import InputChoice
from targets.mcu.stm32f1.rcc import Rcc
from tests.targets.firmware.defect import Defect, finds_it, some

DEFECTS = [
    # --- data and registers of the DAC
    Defect(
        "both halves of a dual register are the lower", "dac", Dac, "_write_data", "value >> shift * index", "value"
    ),
    Defect("eight bits are sixteen", "dac", Dac, "_write_data", "8 if form == BYTE_DUAL else 16", "16"),
    Defect("TSEL is free while EN is set", "dac", Dac, "write_CR", "if old >> shift & value >> shift & EN", "if False"),
    Defect("SWTRIG is for one channel", "dac", Dac, "write_SWTRIGR", "value >> channel.number & 1", "value & 1"),
    Defect("reset keeps DOR", "dac", Channel, "reset", "self.put_out = ", ""),
    # --- triggers
    Defect("EN gates the digital half", "dac", Channel, "hold", "if not", "if self._control & EN and not"),
    Defect("TEN is not looked at", "dac", Channel, "hold", "if not self._control & TEN", "if True"),
    Defect("any timer triggers", "dac", Channel, "_listen", "if select == chosen", "if select < 6"),
    Defect("no EXTI9", "dac", Channel, "_listen", "if select == chosen", "if select == chosen != 6"),
    Defect("both edges trigger", "dac", Channel, "_edge", "if level and", "if"),
    Defect(
        "SWTRIG triggers whoever has TEN",
        "dac",
        Channel,
        "trigger_by_software",
        "self._control & TSEL == _BY_SOFTWARE << 3",
        "True",
    ),
    Defect("clearing TEN loads nothing", "dac", Channel, "set_up", "self._load_held()", "pass"),
    # --- DMA
    Defect("no request", "dac", Channel, "_ask", "self._request.pulse()", "pass"),
    Defect("DMAEN is not looked at", "dac", Channel, "_edge", "if self._control & DMAEN", "if True"),
    Defect(
        "software asks for DMA",
        "dac",
        Channel,
        "trigger_by_software",
        "self._triggered(_CYCLES_BY_SOFTWARE)",
        "self._triggered(_CYCLES_BY_SOFTWARE); self._request.pulse()",
    ),
    Defect("all requests go to DMA1", "dac", Dma, "serves", "name in names", "False"),
    # --- waves
    Defect("noise stands still", "dac", Channel, "_with_wave", "self._noise = _next_noise(self._noise)", "pass"),
    Defect("noise is not masked", "dac", Channel, "_with_wave", "self._noise & amplitude", "self._noise"),
    Defect("the triangle is a saw", "dac", Channel, "_with_wave", "2 * amplitude - step", "step - amplitude - 1"),
    Defect("the amplitude is half", "dac", Channel, "_with_wave", ", 11) + 1) - 1", ", 11)) - 1 or 1"),
    Defect("a sum overflows", "dac", Channel, "_with_wave", "min(word, FULL)", "word & FULL"),
    Defect("WAVE cleared keeps the noise", "dac", Channel, "set_up", "if not control & WAVE", "if False"),
    # --- the pin
    Defect("the pin has nothing of it", "dac", Pin, "put_out", "self._analog = source", "pass"),
    Defect("EN is not looked at", "dac", Channel, "_drive", "if not self._control & EN", "if False"),
    # --- timers, and how they are connected
    Defect("no remap", "high-density", Afio, "write_MAPR", "(old ^ value) & _TIM5CH4_IREMAP", "False"),
    Defect(
        "the remap hears nobody", "high-density", InputChoice, "choose", "chosen.on_change = self._on_change", "pass"
    ),
    Defect(
        "the pin is heard all the same", "high-density", InputChoice, "choose", "self._both[inside]", "self._both[0]"
    ),
    Defect("no clock of the LSI", "high-density", Rcc, "_set_tree", "self.lsi_hz if self._lsi.ready", "none if True"),
    Defect(
        "TIM7 has the interrupt of TIM6",
        "high-density",
        Stm32f103,
        "_make_timers",
        "else self._services_of(name), kinds[name]",
        'else self._services_of(name), kinds["TIM6" if name == "TIM7" else name]',
    ),
    Defect(
        "TIM8 has the masters of TIM1",
        "high-density",
        Stm32f103,
        "_make_timers",
        "else self._services_of(name), kinds[name]",
        'else self._services_of(name), replace(kinds[name], internal_triggers=("TIM5", "TIM2", "TIM3", "TIM4"))'
        ' if name == "TIM8" else kinds[name]',
    ),
    Defect("UG is not put out", "high-density", TimerEffects, "_reinitialise", "self._pulse_trgo()", "pass"),
    Defect(
        "requests of TIM5 and TIM8 go nowhere",
        "high-density",
        Dma,
        "serves",
        "name in names for names",
        'name in names and name[:4] not in ("TIM5", "TIM8") for names',
    ),
    Defect("UART4 asks DMA1", "high-density", Dma, "serves", "name in names", 'name in names and name[:4] != "UART"'),
]


@pytest.fixture(scope="module")
def takes_ms():
    """How long a self-test takes without a defect: ``takes_ms(start, name)``."""

    @functools.cache
    def measure(start, name):
        return start(name).to(1000).machine.ended.ns / 1e6

    return measure


@pytest.mark.parametrize("defect", some(DEFECTS, 2))
def test_it_is_found(start, takes_ms, put_in, defect):
    name = f"selftest-{defect.test}"
    usual_ms = takes_ms(start, name)
    put_in(defect)
    assert finds_it(start(name).to(1.5 * usual_ms + 1)), "the self-test passes all the same"
