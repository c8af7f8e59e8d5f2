"""Self-tests can fail: each defect, put into the model, is found by the self-test that has to find it.

A defect is a change of a few words in one method; those of what is in C are in `measure.core_defects`. If the words are
no longer there, the method has changed: then describe the defect anew.
"""

from __future__ import annotations

import functools

import pytest

from targets.mcu.cortexm.core import Core
from targets.mcu.cortexm.dwt import Dwt
from targets.mcu.cortexm.scb import Scb
from targets.mcu.i2c_contest import Contest
from targets.mcu.stm32.exti import Exti
from targets.mcu.stm32.i2c_wire import Wire
from targets.mcu.stm32.iwdg import Iwdg
from targets.mcu.stm32.mco import Choice
from targets.mcu.stm32.oscillator import Oscillator
from targets.mcu.stm32.rcc import BasicRcc
from targets.mcu.stm32.spi_wire import SpiWire
from targets.mcu.stm32.tim.breaks import Breaks
from targets.mcu.stm32.tim.core import TimerCore
from targets.mcu.stm32.tim.counting import Counting
from targets.mcu.stm32.tim.effects import TimerEffects
from targets.mcu.stm32.tim.timer import Timer
from targets.mcu.stm32.usart_base import UsartBase
from targets.mcu.stm32.usart_clock import ClockPin
from targets.mcu.stm32.wwdg import Wwdg
from targets.mcu.stm32f1.adc import Adc
from targets.mcu.stm32f1.bkp import Bkp
from targets.mcu.stm32f1.chip import Stm32f103
from targets.mcu.stm32f1.crc import Crc
from targets.mcu.stm32f1.flash import Flash
from targets.mcu.stm32f1.gpio import Gpio
from targets.mcu.stm32f1.i2c import I2c
from targets.mcu.stm32f1.i2c_block import Block
from targets.mcu.stm32f1.i2c_slave import Slave
from targets.mcu.stm32f1.i2c_smbus import AlertPin, LowLimit
from targets.mcu.stm32f1.pwr import Pwr
from targets.mcu.stm32f1.rcc import Rcc
from targets.mcu.stm32f1.rtc import Rtc
from targets.mcu.stm32f1.usart import Usart
from tests.targets.firmware.defect import Defect, finds_it, some

DEFECTS = [
    # --- USART; flags and data are in C, as DMA is, and so are their defects: see measure/core_defects.py
    Defect("CTS is not looked at", "usart", Usart, "_cts_changed", "self._kept.clear_to_send = not level", "pass"),
    Defect("no LIN break", "usart", Usart, "_lin_break", "self[self.STATUS] |= LBD", "pass"),
    Defect(
        "one wire: nothing is heard of oneself", "usart", UsartBase, "_frame_begins", "self._rx.receive(frame)", "pass"
    ),
    Defect("no clock", "usart-clock", ClockPin, "begin", "if not self._control & CLKEN", "if True"),
    Defect("CPOL is not looked at", "usart-clock", ClockPin, "set", "bool(control & CPOL) if", "False if"),
    Defect("CPOL turns no pulse over", "usart-clock", ClockPin, "begin", "not self._control & CPOL", "True"),
    Defect("CPHA is not looked at", "usart-clock", ClockPin, "begin", "0 if self._control & CPHA else", ""),
    Defect("LBCL is not looked at", "usart-clock", ClockPin, "begin", "bits if self._control & LBCL else", ""),
    Defect("stop bits have a pulse", "usart-clock", ClockPin, "begin", "last + 1)", "last + 2)"),
    Defect("sampled at the end of bits", "usart-clock", ClockPin, "begin", "16 * bit + _HALF for", "16 * bit + 16 for"),
    Defect("nothing comes in", "usart-clock", ClockPin, "_sample", "self._take(self._word)", "pass"),
    Defect(
        "frames come in as without a clock",
        "usart-clock",
        Usart,
        "_run",
        "wanted & ~RE if clocked else wanted",
        "wanted",
    ),
    Defect("a break has a clock", "usart-clock", Usart, "_frame_begins", "if not self._kept.frame_is_break", "if True"),
    # --- ADC; conversions are in C, and their defects in measure/core_defects.py
    Defect("each edge triggers", "adc", Adc, "_edge", "if level:", "if True:"),
    Defect("injected triggers are not heard", "adc", Adc, "_edge", "if level:", "if level and not injected:"),
    Defect("the sensor is cold", "adc", Adc, "_volts_at", "self.internal.volts(channel), 0", "0.0, 0"),
    # --- I2C
    Defect("SB stays", "i2c", I2c, "_write_address", "self[SR1] &= ~SB", "pass"),
    Defect("SB does not wait", "i2c", I2c, "_started", "self._saw = 0", "self._saw = 0; self._wire.stop()"),
    Defect("START stays", "i2c", I2c, "_started", "self[CR1] &= ~START", "pass"),
    Defect("STOP stays", "i2c", I2c, "_stopped", "self[CR1] &= ~STOP", "pass"),
    Defect("everybody acknowledges", "i2c", I2c, "_sent", "if not acknowledged:", "if False:"),
    Defect("MSL is never set", "i2c", I2c, "_started", "MSL | BUSY", "BUSY"),
    Defect("fast mode is as slow", "i2c", I2c, "_set_timing", "ccr & 1 << 15", "0"),
    Defect("DUTY is not looked at", "i2c", I2c, "_set_timing", "ccr & 1 << 14", "0"),
    Defect("no event interrupt", "i2c", Block, "_update", "enables & ITEVTEN", "0"),
    Defect("no error interrupt", "i2c", Block, "_update", "enables & ITERREN", "0"),
    Defect("AF is not cleared", "i2c", I2c, "write_SR1", "value | ~ERRORS", "-1"),
    Defect("SWRST resets nothing", "i2c", I2c, "write_CR1", "self.reset()", "pass"),
    Defect("PE frees nothing", "i2c", I2c, "write_CR1", "self._break_off()", "pass"),
    Defect("EV1 does not hold SCL", "i2c-slave", Slave, "_holds", "self[SR1] & ADDR or", ""),
    Defect("two bytes do not hold SCL", "i2c-slave", Slave, "_holds", "or self._shifted is not None", ""),
    Defect("an empty DR does not hold SCL", "i2c-slave", Slave, "_holds", "or idle", ""),
    Defect("NOSTRETCH is not looked at", "i2c-slave", Slave, "_holds", "or self[CR1] & NOSTRETCH", ""),
    Defect("no overrun", "i2c-slave", Slave, "was_written", "self[SR1] |= OVR", "self._keep(byte)"),
    Defect("no underrun", "i2c-slave", Slave, "is_read", "self[SR1] |= OVR", "pass"),
    Defect("an underrun sends nothing", "i2c-slave", Slave, "is_read", "self._leaving = self[DR]", "0xFF"),
    Defect("no STOPF", "i2c-slave", Slave, "heard_stop", "self[SR1] |= STOPF", "pass"),
    Defect("STOPF after a NACK, too", "i2c-slave", Slave, "was_written", "if not acknowledge or", "if"),
    Defect("STOPF after EV3_2, too", "i2c-slave", Slave, "was_answered", "if not acknowledged or", "if"),
    Defect("STOPF stays", "i2c-slave", I2c, "write_CR1", "self[SR1] &= ~STOPF", "pass"),
    Defect("no EV3_2", "i2c-slave", Slave, "was_answered", "self[SR1] |= AF", "pass"),
    Defect("addresses are answered without ACK", "i2c-slave", Slave, "was_addressed", "!= PE | ACK", "& PE != PE"),
    Defect("TRA is not set", "i2c-slave", Slave, "_match", "TRA if byte & 1", "TRA if False"),
    Defect("no flag says which address", "i2c-slave", Slave, "_match", "state |", "0 |"),
    Defect("a header is enough", "i2c-slave", Slave, "was_addressed", "self._known and", ""),
    Defect(
        "any second byte",
        "i2c-slave",
        Slave,
        "was_written",
        "self._known = byte == second_byte(self[OAR1]) and",
        "self._known =",
    ),
    Defect("a header is no address", "i2c-slave", Slave, "was_addressed", "self._header = True", "return False"),
    Defect("the alert response sets no flag", "i2c-slave", Slave, "was_addressed", "self[SR1] |= SMBALERT", "pass"),
    Defect("what was left is sent", "i2c-slave", Slave, "_end_message", "self._waiting = None", "pass"),
    Defect("flags outlive the message", "i2c-slave", Slave, "_end_message", "self._set_state(OF_A_MESSAGE, 0)", "pass"),
    Defect("a START does not make busy", "i2c-slave", Slave, "heard_start", "self._set_state(BUSY, BUSY)", "pass"),
    Defect("a STOP does not free the bus", "i2c-slave", I2c, "_freed", "self._stuck_changed()", "pass"),
    Defect(
        "a slave may hold SCL for ever",
        "i2c-slave",
        Slave,
        "_watch_own",
        "self[CR1] & (SMBUS | PE) == SMBUS | PE",
        "False",
    ),
    Defect("a master may hold SCL for ever", "i2c-slave", Slave, "heard_pause", "self._paused = low", "pass"),
    Defect("PE = 0 frees the bus", "i2c-slave", I2c, "_break_off", "self.bus.master is not None", "False"),
    Defect("a timeout changes nothing", "i2c-slave", Slave, "_reset_communication", "self._addressed =", "_ ="),
    Defect("a wrong PEC is right", "i2c-slave", Block, "_answer", "byte != self[SR2] >> PEC_SHIFT", "False"),
    Defect("a wrong PEC is acknowledged", "i2c-slave", Block, "_answer", "and not self._pec_wrong", ""),
    Defect("the PEC is 0", "i2c-slave", Block, "_next_byte", "return self[SR2] >> PEC_SHIFT", "return 0"),
    Defect(
        "the PEC is counted", "i2c-slave", Block, "_answer", "self._forget_pec()", "self._forget_pec(); self._count(0)"
    ),
    Defect("no PEC is sent by DMA", "i2c-slave", Block, "_fill", "self._pec_with_dma and", "False and"),
    Defect("no PEC is received by DMA", "i2c-slave", Block, "_answer", "is_pec or self._pec_with_dma", "is_pec"),
    Defect("a START of both is none", "i2c-slave", Wire, "meets", "self._action != self._start or", "True or"),
    Defect("nobody loses", "i2c-slave", Contest, "_begin", "if move.levels != best:", "if False:"),
    Defect("the higher one wins", "i2c-slave", Contest, "_begin", "best = min(", "best = max("),
    Defect("one of two hears no answer", "i2c-slave", Contest, "over", "if other is not bus:", "if False:"),
    Defect("one loses after the byte", "i2c-slave", Contest, "_begin", "clocks * (low + high)", "10 * (low + high)"),
    Defect("no ARLO", "i2c-slave", I2c, "_lost", "| ARLO", ""),
    Defect("the loser takes the bus for free", "i2c-slave", I2c, "_lost", "self.bus.master is not None", "False"),
    Defect("the loser answers at once", "i2c-slave", Slave, "was_addressed", "or self._has_lost", ""),
    # --- SMBus
    Defect("no byte is counted", "smbus", I2c, "_count", "if self[CR1] & ENPEC", "if False"),
    Defect("ENPEC is not looked at", "smbus", I2c, "_count", "self[CR1] & ENPEC", "True"),
    Defect("a repeated START begins anew", "smbus", I2c, "_started", "if not self[SR2] & MSL:", "if True:"),
    Defect("no START begins anew", "smbus", I2c, "_started", "if not self[SR2] & MSL:", "if False:"),
    Defect("PEC stays", "smbus", I2c, "_forget_pec", "self[CR1] &= ~PEC", "pass"),
    Defect("PE clears nothing", "smbus", I2c, "write_CR1", "value & ~CLEARED_WITHOUT_PE", "value"),
    Defect("25 ms for a master, too", "smbus", I2c, "_watch_clock", "MASTER_NS", "LOW_NS"),
    Defect("I2C has the limits of SMBus", "smbus", I2c, "_watch_clock", "self[CR1] & SMBUS and rests", "rests"),
    Defect("no STOP after a timeout", "smbus", I2c, "_timed_out", "& ~START | STOP", "& ~START"),
    Defect("10 ms for all bytes", "smbus", LowLimit, "restart", "self._used_ns = 0", "self._used_ns += 2_000_000"),
    Defect("SMBA stays high", "smbus", AlertPin, "update", "not control & ALERT", "True"),
    Defect("a host hears nothing", "smbus", AlertPin, "_changed", "if not level:", "if False:"),
    Defect("a host hears the end of an alert", "smbus", AlertPin, "_changed", "if not level:", "if True:"),
    Defect("a device listens", "smbus", AlertPin, "update", "control & SMBTYPE", "True"),
    # --- RTC
    Defect("it counts too slowly", "rtc", Rtc, "_period", "self._prescaler + 1", "self._prescaler + 200"),
    Defect("DIV stands still", "rtc", Rtc, "_left", "(self._ticks.now() - self._from_tick)", "0"),
    Defect("DBP is not looked at", "rtc", Rtc, "write", "if not self._writable():", "if False:"),
    Defect("RTOFF never falls", "rtc", Rtc, "write_CRL", "self[CRL] &= ~RTOFF", "pass"),
    Defect("RTOFF stays low", "rtc", Rtc, "_written", "self[CRL] |= RTOFF", "pass"),
    Defect("RSF never rises", "rtc", Rtc, "_synchronised", "self[CRL] |= RSF", "pass"),
    Defect("no alarm", "rtc", Rtc, "_alarmed", "self._rise(ALRF)", "pass"),
    Defect("EXTI sees no alarm", "rtc", Rtc, "_alarmed", "self._line.set(True)", "pass"),
    Defect(
        "an alarm a second early", "rtc", Rtc, "_plan", "self._alarm - count & WORD", "self._alarm - count - 1 & WORD"
    ),
    Defect("no overflow", "rtc", Rtc, "_overflowed", "self._rise(OWF)", "pass"),
    Defect("SECIE is not looked at", "rtc", Rtc, "_drive", "self[CRL] & self[CRH] & FLAGS", "0"),
    Defect("a reset clears the counter", "rtc", Rtc, "reset", "self._pending.clear()", "self._clear()"),
    Defect("CRH survives a reset", "rtc", Rtc, "reset", "self[CRH], self[CRL] = 0, RTOFF", "self[CRL] = RTOFF"),
    Defect("BDRST is not looked at", "rtc", Rtc, "reset_backup", "self._clear()", "pass"),
    Defect("ALR can be read", "rtc", Rtc, "read_ALRL", "return 0", "return self._alarm & 0xFFFF"),
    Defect("RTCCLK is not divided", "rtc-output", Choice, "rate", "clocks[clock] / divider", "clocks[clock]"),
    Defect("nothing is put out", "rtc-output", Stm32f103, "_rtc_puts_out", "carries=True", "pull=True"),
    Defect("the pin is kept", "rtc-output", Stm32f103, "_rtc_puts_out", "pin.unclaim()", "pass"),
    Defect("a second is told once", "rtc-output", Rtc, "_plan", "and not self._told & flag", ""),
    Defect("a pulse never ends", "rtc-output", Rtc, "_rise", "self.on_pulse(False)", "None"),
    Defect("an alarm is every second", "rtc-output", Bkp, "_put_out", "SECF if chosen & ASOS else ALRF", "SECF"),
    Defect("BDRST leaves the output", "rtc-output", Bkp, "reset_backup", "self._put_out()", "pass"),
    # --- SPI: flags and words are in C
    Defect("SCK idles low", "spi", SpiWire, "idle", "self._sck.set(cpol)", "self._sck.set(False)"),
    # --- TIM
    Defect("UG sets UIF in spite of URS", "tim", TimerEffects, "_reinitialise", "if self[CR1] & URS", "if False"),
    Defect("no overcapture", "tim-inputs", TimerEffects, "captured", "flag << 8 | flag if", "flag if"),
    Defect(
        "gated: TIF at the rising edge only",
        "tim-inputs",
        TimerEffects,
        "triggered",
        "if level or mode == GATED",
        "if level",
    ),
    Defect("ARR at once", "tim", Timer, "write_ARR", "if not self[CR1] & ARPE", "if True"),
    Defect(
        "CCR at once",
        "tim",
        Timer,
        "_write_ccr",
        "if not preloaded",
        "if True",
    ),
    Defect("reading CCR keeps CCxIF", "tim-inputs", Timer, "_read_ccr", "if not", "if False and not"),
    Defect("flags are cleared by writing 1", "tim", Timer, "write_SR", "self[SR] & value", "self[SR] & ~value"),
    Defect(
        "break keeps MOE",
        "tim1",
        TimerEffects,
        "_break_arrived",
        "self[BDTR] = self._breaks.disable(self[BDTR])",
        "pass",
    ),
    Defect("no dead time", "tim1", Breaks, "dead_time", "return dtg\n", "return 0\n"),
    Defect(
        "dead time in the long ranges",
        "tim1",
        Breaks,
        "dead_time",
        "(32 + (dtg & 0x1F)) * (8 if dtg < 0xE0 else 16)",
        "dtg",
    ),
    Defect("LOCK is written again", "tim1", Breaks, "permitted", "frozen |= _LOCK", "pass"),
    Defect("AOE is not looked at", "tim1", Breaks, "waits_for_update", "self._bits & (AOE | MOE) == AOE", "False"),
    Defect("one pulse goes on", "tim-inputs", TimerCore, "_updated", "if self[CR1] & OPM and", "if False and"),
    Defect("each overflow is an update", "tim1", Counting, "_cross", "not self.rep and", "True and"),
    Defect("UDIS is not looked at", "tim", Counting, "_cross", "and not self.udis", ""),
    Defect("no flag at a match", "tim", TimerCore, "_on_match", "units << 1 & CC_FLAGS", "0"),
    Defect("UG keeps the prescaler's count", "tim", Counting, "reinitialise", "self.psc_count = 0", "pass"),
    Defect("UG keeps the counter", "tim", Counting, "reinitialise", "self.cnt = self.arr if", "self.cnt = self.cnt if"),
    Defect("the encoder counts up only", "tim-inputs", TimerEffects, "turned", "self._counting.down = down", "pass"),
    Defect(
        "commutation changes nothing",
        "tim1",
        TimerEffects,
        "_commutate",
        "self._apply_channels(commutation=True)",
        "pass",
    ),
    Defect("no COMIF", "tim1", TimerEffects, "_commutate", "self[SR] |= COMIF", "pass"),
    # --- RCC
    Defect(
        "oscillators are ready at once",
        "rcc",
        Oscillator,
        "_start",
        "self._in(self._start_s, True)",
        "self._in(0 * self._start_s, True)",
    ),
    Defect("the PLL is changed while it runs", "rcc", Rcc, "write_CFGR", "if self[CR] & PLLON and", "if False and"),
    Defect("what drives SYSCLK can be switched off", "rcc", Rcc, "write_CR", "kept = self", "kept = 0 and self"),
    Defect("resets of peripherals do nothing", "rcc", Rcc, "_write_resets", "peripheral.reset()", "pass"),
    Defect("the backup domain is open", "rcc", BasicRcc, "write_BDCR", "if not self._backup_writable()", "if False"),
    Defect(
        "RMVF clears nothing",
        "wwdg",
        Rcc,
        "write_CSR",
        "value & ~self.RESET_FLAGS if value & RMVF else value",
        "value | self[self.CSR] & self.RESET_FLAGS",
    ),
    # --- GPIO, EXTI; latches and what is read of levels are in C
    Defect("the lock does not lock", "gpio", Gpio, "_write_configuration", "self._lock.pins", "False"),
    Defect("ODR does not move pulls", "gpio", Gpio, "_set_latch", "self._nibble(number) == _INPUT_PULL", "False"),
    Defect("falling edges are not seen", "exti", Exti, "_listener", "0x08 if level else 0x0C", "0x08"),
    Defect(
        "a masked line is pending",
        "exti",
        Exti,
        "_triggered",
        "if lines & self[0x00]:\n        self[0x14] |= lines & self[0x00]",
        "if lines:\n        self[0x14] |= lines",
    ),
    Defect("PR keeps SWIER", "exti", Exti, "write_PR", "self[0x10] &= ~value", "pass"),
    Defect("PR is cleared by writing 0", "exti", Exti, "write_PR", "self[0x14] &= ~value", "self[0x14] &= value"),
    Defect("events do not wake", "exti", Exti, "_triggered", "self.on_event()", "pass"),
    # --- watchdogs
    Defect("registers without a key", "iwdg", Iwdg, "_update", "if not self._open", "if False"),
    Defect("feeding does nothing", "iwdg", Iwdg, "write_KR", "self._reload(self[RLR])", "pass"),
    Defect("the prescaler is not looked at", "iwdg", Iwdg, "_divider", "min(self[PR], 6)", "0"),
    Defect("updates take no time", "iwdg", Iwdg, "_update", "Fraction(UPDATE_CYCLES)", "Fraction(0)"),
    Defect("no window", "wwdg", Wwdg, "write_CR", "was_on and self._count > self[CFR] & W", "False"),
    Defect("T6 clear does not reset at once", "wwdg", Wwdg, "write_CR", "(too_early or not value & T6)", "too_early"),
    Defect("EWI can be taken back", "wwdg", Wwdg, "write_CFR", "value | (self[CFR] & EWI)", "value"),
    Defect("EWIF is cleared by writing 1", "wwdg", Wwdg, "write_SR", "&= value", "&= ~value"),
    # --- flash, CRC, PWR, BKP
    Defect(
        "what is not erased is programmed",
        "flash",
        Flash,
        "_program_flash",
        "value and self.memory",
        "False and self.memory",
    ),
    Defect(
        "zero is not programmed over something",
        "flash",
        Flash,
        "_program_flash",
        "value and self.memory",
        "self.memory",
    ),
    Defect("no EOP", "flash", Flash, "_end", "set_=EOP, ", ""),
    Defect("write protection does not protect", "flash", Flash, "_is_protected", "return not", "return False and not"),
    Defect("LOCK does not lock", "flash", Flash, "write_CR", "if old & LOCK or", "if False or"),
    Defect("bytes are programmed", "flash", Flash, "program", "if size != 2 or address & 1", "if False"),
    Defect("erasing takes no time", "flash", Flash, "_begin", "+ seconds", "+ 0 * seconds"),
    Defect("IDR is reset too", "crc", Crc, "write_CR", "self[DR] = WORD", "self[DR] = WORD\n        self[4] = 0"),
    Defect(
        "bytes in another order",
        "crc",
        Crc,
        "write_DR",
        "self[DR] ^ value",
        "self[DR] ^ int.from_bytes(value.to_bytes(4, 'little'), 'big')",
    ),
    Defect("backup registers are open", "pwr-bkp", Bkp, "write", "if self._writable()", "if True"),
    Defect("no standby flag", "pwr-bkp", Pwr, "enter_standby", "self[CSR] |= SBF", "pass"),
    Defect("CSBF clears nothing", "pwr-bkp", Pwr, "write_CR", "self[CSR] &= ~SBF", "pass"),
    # --- core
    Defect("the counter stands still", "dwt-itm", Dwt, "read", "self.time.now - self._start", "0"),
    Defect("CYCCNT goes on when stopped", "dwt-itm", Dwt, "gate", "elif not counting and", "elif False and"),
    Defect("SEVONPEND is not looked at", "nvic", Scb, "write_SCR", "bool(value & _SEVONPEND)", "False"),
    Defect("no escalation", "faults", Core, "_may_interrupt", "own < self._execution_priority()", "True"),
    Defect("an escalated SVC is repeated", "faults", Core, "_escalate_call", "PC, behind)", "PC, behind - 2)"),
    Defect("FORCED is not set", "faults", Core, "_fault", "hfsr |= Hfsr.FORCED", "pass"),
]


@pytest.fixture(scope="module")
def takes_ms():
    """How long a self-test takes without a defect: ``takes_ms(start, name)``."""

    @functools.cache
    def measure(start, name):
        return start(name).to(1000).machine.ended.ns / 1e6

    return measure


@pytest.mark.parametrize("defect", some(DEFECTS, 5))
def test_it_is_found(start, takes_ms, put_in, defect):
    name = f"selftest-{defect.test}"
    usual_ms = takes_ms(start, name)
    put_in(defect)
    assert finds_it(start(name).to(1.5 * usual_ms + 1)), "the self-test passes all the same"
