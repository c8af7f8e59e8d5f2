"""The self-tests of the blocks of the STM32H753: each check holds, however they are run, and finds what it is for."""

from __future__ import annotations

import pytest

from targets.mcu.stm32 import adc16_settings, adc16_unit
from targets.mcu.stm32.adc16 import Adc16
from targets.mcu.stm32.adc16_power import Power
from targets.mcu.stm32.adc16_unit import Unit
from targets.mcu.stm32.clocked_wait import ClockedWait
from targets.mcu.stm32.dmamux import DmaMux
from targets.mcu.stm32.usart import Usart
from targets.mcu.stm32.usart_fifo import FifoUsart
from targets.mcu.stm32h7.dma_reach import DmaReach
from tests.targets.firmware.defect import Defect, finds_it, some

CHECKS = {"adc16": 38, "dmamux": 19, "lptim": 75, "spi": 68, "usart-fifo": 32}
NOTES = {
    "adc16": ["ADC3_CR.ADEN", "ADC3_CR.ADCAL"],
    "dmamux": ["DTCM"],
    "lptim": ["LPTIM1_CR", "LPTIM1_IER"],
    "spi": ["SPI1_CFG1"],
    "usart-fifo": ["USART2_CR1", "USART2_PRESC"],
}
LIMIT_MS = {"adc16": 25, "dmamux": 2, "lptim": 40, "spi": 4, "usart-fifo": 6}
OTHER_TIMING = pytest.mark.exhaustive("the other timing model; the gate has golden traces with it")


@pytest.mark.exhaustive("golden traces of the same images hold every line that they say")
@pytest.mark.parametrize("name", CHECKS)
@pytest.mark.parametrize("timing", ["flat", pytest.param("table", marks=OTHER_TIMING)])
def test_every_check_holds(start, name, timing):
    run = start(f"h753-{name}", timing=timing).to(LIMIT_MS[name])
    passed, failed = run.checks
    assert (len(passed), failed) == (CHECKS[name], [])
    assert (run.machine.ended.kind, run.machine.ended.status) == ("exit", 0)
    assert [note.where for note in run.machine.notes.all] == NOTES[name]


@pytest.mark.exhaustive("each self-test in other ways; the gate has fifteen images so in traces/test_goldens.py")
@pytest.mark.parametrize("name", ["dmamux", "lptim", "spi", "usart-fifo"])
def test_it_ends_at_the_same_cycle_however_it_is_run(start, name):
    def end(step_ns=None, **options):
        run = start(f"h753-{name}", **options).to(LIMIT_MS[name], step_ns=step_ns)
        return run.machine.ended, run.console

    assert end() == end(step_ns=77_777, skip_idle=False)


FIFO, MUX, ADC = "usart-fifo", "dmamux", "adc16"
DEFECTS = [
    # --- USART; those of flags and data are in measure/core_defects.py
    Defect("RXFRQ leaves the FIFO", FIFO, Usart, "write_RQR", "self._kept.unread = 0", "pass"),
    Defect(
        "PRESC divides nothing", FIFO, FifoUsart, "_bit_cycles", "* PRESCALERS[min(self[PRESC], ", "* (1, 1)[min(0, "
    ),
    Defect("PRESC is not locked", FIFO, FifoUsart, "write_PRESC", "self._permitted(PRESC, value)", "value"),
    Defect("no TXFE after a reset", FIFO, FifoUsart, "write_CR1", "(TXFE if self._has_fifos else 0)", "0"),
    # --- DMA
    Defect("a channel leads nowhere else", MUX, DmaMux, "_lead", "self._listeners[channel]()", "pass"),
    Defect(
        "DTCM is within reach",
        MUX,
        DmaReach,
        "_check",
        "if address < _ITCM_END or _DTCM <= address < _DTCM_END:",
        "if False:",
    ),
    Defect("the controllers share a channel", MUX, DmaMux, "outlet", "[channel]", "[channel % 8]"),
    # --- ADC
    Defect("the clock of revision Y", ADC, Adc16, "after_clock_change", "2 * prescaler", "prescaler"),
    Defect("LDORDY without a regulator", ADC, Power, "_supplied", "|= LDORDY", "&= ~LDORDY"),
    Defect("ADEN in deep power-down", ADC, Power, "_is_supplied", "return False", "return True"),
    Defect("linearity costs nothing", ADC, Power, "calibrate", "LINEARITY_CLOCKS if linear else ", ""),
    Defect("no words of linearity", ADC, Power, "_calibrated", "|= LINCALRDYW", "&= ~LINCALRDYW"),
    Defect("no half clocks", ADC, adc16_unit, "conversion_clocks", "bits + 1", "bits"),
    Defect("DR leaves EOC", ADC, Unit, "_take", "self.values[ISR] &= ~EOC", "pass"),
    Defect("ADSTART stays", ADC, Unit, "_group_over", "&= ~ADSTART", "&= -1"),
    Defect("JSQ begins a bit too low", ADC, adc16_unit, "injected_sequence", "9 + 6", "8 + 6"),
    Defect("offsets are added", ADC, adc16_settings, "with_offset", "value - (", "value + ("),
    Defect("sums are not shifted", ADC, Unit, "_summed_up", "self._sum >> (control >> 5 & 0xF)", "self._sum"),
    Defect("no watchdog", ADC, adc16_settings, "outside", "full < low or full > high", "False"),
    Defect("an overrun is nothing", ADC, Unit, "_store", "|= OVR", "|= 0"),
    Defect("OVRMOD does nothing", ADC, Unit, "_store", " or self.values[CFGR] & OVRMOD", ""),
    Defect("one shot without end", ADC, Unit, "_last_transfer", "self._dma_over = True", "pass"),
    Defect("no trigger", ADC, Unit, "_regular_edge", "self._start_regular()", "pass"),
    Defect("waits add up", ADC, ClockedWait, "start", "ticks * self._cycles", "(ticks + 1) * self._cycles"),
]


@pytest.mark.parametrize("defect", some(DEFECTS, 2))
def test_it_is_found(start, put_in, defect):
    put_in(defect)
    assert finds_it(start(f"h753-{defect.test}").to(LIMIT_MS[defect.test])), "the self-test passes all the same"
