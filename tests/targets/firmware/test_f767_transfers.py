"""Each defect of I2C and ADC of the STM32F767 is found by the self-test that has to find it."""

from __future__ import annotations

import pytest

from targets.mcu.stm32.adc import Adc, Internal
from targets.mcu.stm32.adc_sequences import Group
from targets.mcu.stm32.adc_unit import Unit
from targets.mcu.stm32.converters import Converters
from targets.mcu.stm32.i2c import I2c
from targets.mcu.stm32.i2c_wire import Wire
from tests.targets.firmware.defect import Defect, finds_it, some

LIMIT_MS = 50

DEFECTS = [
    # those of DMA are in measure/core_defects.py
    # --- I2C
    Defect("no STOP after a NACK", "i2c", I2c, "_refused", "self._end()", "pass"),
    Defect("START stays", "i2c", I2c, "_refused", "self[CR2] &= ~START", "pass"),
    Defect("eight clocks", "i2c", Wire, "_send", "9 * timing.bit", "8 * timing.bit"),
    Defect("a STOP takes no time", "i2c", Wire, "stop", "timing.bit, end", "1, end"),
    Defect("BUSY stays", "i2c", I2c, "_stopped", "~(BUSY | TC | TCR)", "~(TC | TCR)"),
    Defect("ICR clears nothing", "i2c", I2c, "write_ICR", "~(value & CLEARED_BY_ICR)", "-1"),
    Defect("TXE cannot be set", "i2c", I2c, "write_ISR", "self[ISR] |= dropped", "pass"),
    Defect("PE breaks nothing off", "i2c", I2c, "_switched", "self._break_off()", "pass"),
    Defect("START without PE", "i2c", I2c, "write_CR2", "value &= ~ONLY_SET", "pass"),
    Defect("STOPIE is not looked at", "i2c", I2c, "_update", "isr & cr1 & SAME_BIT", "isr & SAME_BIT"),
    # --- ADC
    Defect("no sampling time", "adc", Unit, "_proceed", "_SAMPLING_HALVES[self._sampling(group.channel)]", "6"),
    Defect("always twelve bits", "adc", Unit, "_bits", "BITS[self.values[CR1] >> 24 & 3]", "12"),
    Defect("DR leaves EOC", "adc", Unit, "read", "self.values[SR] &= ~EOC", "pass"),
    Defect("no watchdog", "adc", Unit, "_watch", "self.values[SR] |= AWD", "pass"),
    Defect("no overrun", "adc", Unit, "_keep_regular", "cr2 & EOCS or (cr2", "False and (cr2"),
    Defect("an overrun behind the last transfer", "adc", Unit, "_last_transfer", "self._dma_over = True", "pass"),
    Defect("SCAN is not looked at", "adc", Unit, "_start_regular", "if cr1 & SCAN", "if False"),
    Defect("discontinuous begins anew", "adc", Group, "start", "if not steps or", "if True or"),
    Defect("injected without offset", "adc", Unit, "_keep_injected", "self.values[JOFR1 + 4 * rank]", "0"),
    Defect("injected the other way round", "adc", Unit, "_injected_sequence", "range(4 - count, 4)", "range(count)"),
    Defect("no trigger", "adc", Unit, "_regular_edge", "self._start_regular()", "pass"),
    Defect("the battery is not divided", "adc", Internal, "volts", "self.vbat_volts / 4", "self.vbat_volts"),
    Defect("no common flags", "adc", Adc, "read_CSR", "unit.values[SR]", "0"),
    Defect("no interrupt", "adc", Converters, "_drive_irq", "any(unit.interrupt for unit in self._units)", "False"),
]


@pytest.mark.parametrize("defect", some(DEFECTS, 2))
def test_it_is_found(start, put_in, defect):
    put_in(defect)
    assert finds_it(start(f"f767-{defect.test}").to(LIMIT_MS)), "the self-test passes all the same"
