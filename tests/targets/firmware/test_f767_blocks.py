"""Each defect of ports, USART and timers of the STM32F767 is found by the self-test that has to find it."""

from __future__ import annotations

import pytest

from targets.mcu.irq_lines import _Source
from targets.mcu.stm32.gpio import Gpio
from targets.mcu.stm32.pin_functions import PinFunctions
from targets.mcu.stm32.tim.core import TimerCore
from targets.mcu.stm32.tim.effects import TimerEffects
from targets.mcu.stm32.tim.timer import Timer
from targets.mcu.stm32.usart import Usart
from targets.mcu.stm32.usart_receiver import Receiver
from tests.targets.firmware.defect import Defect, finds_it, some

LIMIT_MS = 50

DEFECTS = [
    # --- ports
    Defect("pulls the other way", "pins", Gpio, "_configure", "_PULLS[self[PUPDR]", "_PULLS[~self[PUPDR]"),
    Defect("the lock does not lock", "pins", Gpio, "_unlocked", "if not locked", "if True"),
    Defect("no function is chosen", "pins", PinFunctions, "_enter", "self._signals.route_all(name, carriers)", "pass"),
    # --- USART; those of flags and data are in measure/core_defects.py
    Defect("OVER8 is not looked at", "serial", Usart, "_divider", "if not self[CR1] & OVER8", "if True"),
    Defect("CR1 has no M1", "serial", Usart, "_configure", "cr1 & (M0 | M1), 8", "cr1 & M0, 8"),
    Defect("TXINV alone", "serial", Usart, "_configure", "tx.inverted = bool(cr2 & TXINV)", "tx.half_duplex = False"),
    Defect("no timeout", "serial", Usart, "_timed_out", "self[ISR] |= RTOF", "pass"),
    Defect(
        "a timeout of double length", "serial", Receiver, "_schedule_idle", "16 * self.timeout", "32 * self.timeout"
    ),
    Defect("UE keeps the flags", "serial", Usart, "_stop", "self[ISR] = self.registers[ISR].reset", "pass"),
    Defect("BRR is never locked", "serial", Usart, "_permitted", "if stays_enabled else 0", "if False else 0"),
    Defect("the kernel clock is PCLK", "serial", Usart, "_bit_cycles", "/ kernel_hz", "/ (self.time.hclk_hz / 4)"),
    Defect("RXFRQ does nothing", "serial", Usart, "write_RQR", "self[ISR] &= ~RXNE", "pass"),
    # --- timers
    Defect("no copy of UIF", "timers", Timer, "_shown", "(UIFCPY if self[SR] & UIF else 0)", "0"),
    Defect("no flags of units without pins", "timers", TimerCore, "_on_match", "| units << 12 & CC56_FLAGS", ""),
    Defect("B2G does nothing", "timers", Timer, "write_EGR", "(B2IF if value & B2G else 0)", "0"),
    Defect("B2IF does not ask", "timers", TimerCore, "_settle", "(flags | (flags & B2IF) >> 1)", "flags"),
    Defect("the fourth bit of SMS", "timers", Timer, "_slave_mode", "value >> 13 & 8", "0"),
    Defect("combined mode does not start", "timers", TimerEffects, "_act_on_trigger", "(TRIGGER, ", "(TRIGGER, -"),
    Defect(
        "shared interrupts", "timers", _Source, "set", "level or any(source.level for source in self._others)", "level"
    ),
]


@pytest.mark.parametrize("defect", some(DEFECTS, 2))
def test_it_is_found(start, put_in, defect):
    put_in(defect)
    assert finds_it(start(f"f767-{defect.test}").to(LIMIT_MS)), "the self-test passes all the same"
