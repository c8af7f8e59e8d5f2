"""Each defect of a low-power timer is found by the self-test of one chip or the other that has to find it."""

from __future__ import annotations

import pytest

from targets.mcu.stm32.clock_tree import KernelClockTree
from targets.mcu.stm32.lptim import LowPowerTimer, _Input
from targets.mcu.stm32.lptim_counter import LptimCounter
from targets.mcu.stm32.ticks import Ticks
from targets.mcu.stm32h7.exti import Exti
from tests.targets.firmware.defect import Defect, finds_it, some

LIMIT_MS = 150

F7, H7 = "f767-lptim", "h753-lptim"
DEFECTS = [
    Defect("no delay of values", F7, LowPowerTimer, "_write_value", "self._later(WRITTEN_AFTER)", "self._clock.now()"),
    Defect("CMPOK never comes", F7, LowPowerTimer, "_write_value", "self._raise(flag)", "self._raise(ARROK)"),
    Defect("values never arrive", F7, LowPowerTimer, "_write_value", "self._take(offset, value)", "pass"),
    Defect("prescaled once too often", F7, LowPowerTimer, "_prescaler", "1 << (", "2 << ("),
    Defect("CR takes all while disabled", F7, LowPowerTimer, "write_CR", "if on:", "self[CR] = value\n        if on:"),
    Defect("ICR clears nothing", F7, LowPowerTimer, "write_ICR", "self[ISR] &= ~value", "pass"),
    Defect("an interrupt stays", F7, LowPowerTimer, "write_ICR", "self._requests &= ~value", "pass"),
    Defect(
        "IER asserts what has been", F7, LowPowerTimer, "write_IER", "self._requests &= value", "self._raise(value)"
    ),
    Defect("nobody is asked", F7, LowPowerTimer, "_raise", "|= flags & self[IER]", "|= 0"),
    Defect("IER lets everything through", F7, LowPowerTimer, "_raise", "flags & self[IER]", "flags"),
    Defect("no wake-up by EXTI", F7, LowPowerTimer, "_drive", "self._wake_line.set(wanted)", "pass"),
    Defect("polarity waits", F7, LowPowerTimer, "_show", "self[CFGR] & WAVPOL", "self._settings & WAVPOL"),
    Defect("set-once falls", F7, LowPowerTimer, "_show", "self._settings & WAVE", "False"),
    Defect("one pulse for ever", F7, LowPowerTimer, "_show", "self._settings & WAVE", "True"),
    Defect("no single", F7, LowPowerTimer, "_ask_start", "counter.single = single", "counter.single = False"),
    Defect("a trigger is not waited for", F7, LowPowerTimer, "_ask_start", "if self._settings >> 17 & 3", "if False"),
    Defect("a trigger while it runs", F7, LowPowerTimer, "_trigger_changed", "if self._settings & TIMOUT", "if True"),
    Defect("no timeout", F7, LowPowerTimer, "_trigger_changed", "if self._settings & TIMOUT", "if False"),
    Defect("no EXTTRIG", F7, LowPowerTimer, "_trigger_changed", "self._triggered = True", "return"),
    Defect("fewer edges are lost", F7, LowPowerTimer, "_ask_start", "ready + STARTED_AFTER", "ready"),
    Defect("PRELOAD is not looked at", F7, LowPowerTimer, "_take", "self._settings & PRELOAD", "False"),
    Defect("rising edges alone", F7, LowPowerTimer, "_input_changed", "edges == 2 or", ""),
    Defect("the encoder turns round", F7, LowPowerTimer, "_encode", "is (number == 2)", "is (number == 1)"),
    Defect("DOWN is UP", F7, LowPowerTimer, "_encode", "UP if up else DOWN", "UP"),
    Defect("falling edges count rising", F7, LowPowerTimer, "_encode", "0 if own.level else 1", "0"),
    Defect("no filter", F7, _Input, "_changed", "elif self._samples", "elif False"),
    Defect("compares for equality", F7, LptimCounter, "_match", "last < self.compare", "last != self.compare"),
    Defect("ARR hides CMP", F7, LptimCounter, "_wrap", "self._match(top) | ", ""),
    Defect("a step too few", F7, LptimCounter, "_wrap", "self.restart()", "self.count = 1"),
    Defect("below zero is nothing", F7, LptimCounter, "step", "self.count = self.reload", "self.count = 0"),
    Defect(
        "the output is inverted", F7, LptimCounter, "high", "self.count > self.compare", "self.count <= self.compare"
    ),
    Defect(
        "LSI stands still in Stop",
        F7,
        KernelClockTree,
        "low_power_hz",
        "if peripheral in self.rates.in_stop",
        "if False",
    ),
    Defect("the kernel clock is PCLK", F7, Ticks, "refresh", "self._ask_hz()", "self._time.hclk_hz"),
    Defect("COUNTRST does nothing", H7, LowPowerTimer, "_reset_counter", "self._counter.restart()", "pass"),
    Defect("COUNTRST stays", H7, LowPowerTimer, "_reset_counter", "self[CR] &= ~COUNTRST", "pass"),
    Defect("RSTARE does nothing", H7, LowPowerTimer, "read_CNT", "if self[CR] & RSTARE", "if False"),
    Defect("direct lines never wake", H7, Exti, "unmasks", ">> line % 32 & 1", "& 0"),
]


@pytest.mark.parametrize("defect", some(DEFECTS, 2))
def test_it_is_found(start, put_in, defect):
    put_in(defect)
    assert finds_it(start(defect.test).to(LIMIT_MS)), "the self-test passes all the same"
