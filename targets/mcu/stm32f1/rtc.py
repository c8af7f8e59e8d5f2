"""RTC of the STM32F103 (RM0008 section 18): a counter of 32 bits behind a prescaler of 20, with an alarm.

It runs on RTCCLK alone, whatever HCLK does, through resets, Stop and Standby. The counter is arithmetic: nothing
happens while nobody waits. An event is planned for a flag that is clear; so a clock that nobody reads costs one event
after its start, and one for the alarm.

A second is told one RTCCLK cycle before the counter shows it, and the alarm with the end of the second that ALR names
(section 18.3.5, figures 180 and 181).

Choices where the manual is silent:

* What is written in configuration mode counts 3 ticks of RTCCLK ("at least") after CNF was cleared, all at once; RTOFF
  is 0 meanwhile. A new prescaler begins its first second then; a new counter value does not touch the prescaler.
* RSF rises with the first tick after it was cleared. A read before that gives the present value all the same.
* EXTI line 17 sees an alarm whether ALRIE is set or not.
* The calibration (BKP_RTCCR.CAL) is spread evenly over its 2^20 pulses.
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from typing import ClassVar

from targets.mcu.registers import Peripheral, Register
from targets.mcu.services import Services
from targets.mcu.stm32.ticks import Ticks

__all__ = ["ALRF", "SECF", "Rtc"]

CRH, CRL, PRLH, PRLL, DIVH, DIVL, CNTH, CNTL, ALRH, ALRL = range(0x00, 0x28, 4)
SECF, ALRF, OWF, RSF, CNF, RTOFF = (1 << bit for bit in range(6))
FLAGS = SECF | ALRF | OWF
HALF, WORD = 0xFFFF, 0xFFFF_FFFF
IRQ = 3
ALARM_LINE = "EXTI17"
WRITING_TICKS = 3
FAR_TICKS = 1 << 40
"""What falls due later, in a year at the earliest, is planned anew then; an alarm may be 100 000 years away."""
_CALIBRATION_PULSES = 1 << 20


class Rtc(Peripheral):
    """The real-time clock.

    Args:
        base: address of CRH.
        services: what the chip offers. Used: interrupt 3, the output ``EXTI17``.
        rtc_hz: returns the rate of RTCCLK, None while it stands still; `clock_changed` is to be called when it changes.
        backup_writable: says whether PWR_CR.DBP opens the backup domain; without it writes are lost.
        calibration: returns BKP_RTCCR.CAL: how many of 2^20 pulses are left out.

    Attributes:
        on_alarm: called at each alarm; it ends Standby.
        on_pulse: called with True and, a tick of RTCCLK later, with False at what `tell` asks for.
    """

    REGISTERS: ClassVar[tuple[Register, ...]] = (
        Register("CRH", CRH, 0, 0x7),
        Register("CRL", CRL, RTOFF, 0x1F),
        Register("PRLH", PRLH, 0, 0xF),
        Register("PRLL", PRLL, 0x8000, HALF),
        Register("DIVH", DIVH, 0, 0, live=True),
        Register("DIVL", DIVL, 0x8000, 0, live=True),
        Register("CNTH", CNTH, 0, HALF, live=True),
        Register("CNTL", CNTL, 0, HALF, live=True),
        Register("ALRH", ALRH, HALF, HALF),
        Register("ALRL", ALRL, HALF, HALF),
    )

    def __init__(
        self,
        base: int,
        services: Services,
        *,
        rtc_hz: Callable[[], Fraction | None],
        backup_writable: Callable[[], bool] = lambda: True,
        calibration: Callable[[], int] = lambda: 0,
    ) -> None:
        super().__init__("RTC", base, services)
        self.on_alarm: Callable[[], None] = lambda: None
        self.on_pulse: Callable[[bool], None] = lambda _level: None
        self._told = 0
        self._rtc_hz = rtc_hz
        self._calibration = calibration
        self._writable = backup_writable
        self._irq = services.irq(IRQ)
        self._line = services.output(ALARM_LINE)
        self._ticks = Ticks(self.time, self._calibrated_hz)
        self._clear()

    def _clear(self) -> None:
        self._pending: dict[int, int] = {}
        self._from_tick = self._ticks.now()  # at which the prescaler was loaded and the counter was
        self._from_count = 0  # this
        self._prescaler = 0x8000
        self._alarm = WORD

    def _calibrated_hz(self) -> Fraction | None:
        hz = self._rtc_hz()
        return None if hz is None else hz * (_CALIBRATION_PULSES - self._calibration()) / _CALIBRATION_PULSES

    # --- what the chip calls

    def reset(self) -> None:
        """A reset of the chip reaches CRH and CRL only (RM0008 section 18.3.2)."""
        self[CRH], self[CRL] = 0, RTOFF
        self._pending.clear()
        self._ticks.forget("write")
        self._plan()
        self._drive()

    def reset_backup(self) -> None:
        """A reset of the backup domain clears everything."""
        super().reset()
        self._ticks.forget_all()
        self._clear()
        self._plan()
        self._drive()

    def clock_changed(self) -> None:
        """RTCCLK has another rate, or stands still, or runs again; or is calibrated otherwise."""
        self._ticks.refresh()

    def tell(self, flag: int) -> None:
        """Have `on_pulse` called at each second (`SECF`) or alarm (`ALRF`), also while the flag is set; 0: no more."""
        self._told = flag
        self._plan()

    # --- what it counts

    @property
    def count_now(self) -> int:
        """The counter."""
        return self._from_count + (self._ticks.now() - self._from_tick) // self._period & WORD

    @property
    def alarm_comes(self) -> bool:
        """Whether the clock runs, so that there will be an alarm."""
        return self._ticks.runs

    @property
    def _period(self) -> int:
        return self._prescaler + 1

    def read_DIVH(self) -> int:
        """Return the upper bits of what is left of the second."""
        return self._left() >> 16

    def read_DIVL(self) -> int:
        """Return the lower bits of what is left of the second."""
        return self._left() & HALF

    def _left(self) -> int:
        return self._prescaler - (self._ticks.now() - self._from_tick) % self._period

    def read_CNTH(self) -> int:
        """Return the upper half of the counter."""
        return self.count_now >> 16

    def read_CNTL(self) -> int:
        """Return the lower half of the counter."""
        return self.count_now & HALF

    def read_PRLH(self) -> int:
        """Write-only."""
        return 0

    def read_PRLL(self) -> int:
        """Write-only."""
        return 0

    def read_ALRH(self) -> int:
        """Write-only."""
        return 0

    def read_ALRL(self) -> int:
        """Write-only."""
        return 0

    # --- what is written

    def write(self, offset: int, value: int) -> None:
        """As of every peripheral, if the backup domain is open; all but CRH and CRL in configuration mode alone."""
        if not self._writable():
            self.note("misuse", self._name_of(offset), "a write is lost: PWR_CR.DBP is not set")
        elif offset in (CRH, CRL) or offset not in self.registers:
            super().write(offset, value)
        elif not self[CRL] & CNF or not self[CRL] & RTOFF:
            why = "CNF is not set" if self[CRL] & RTOFF else "RTOFF is 0: the write before it still goes on"
            self.note("misuse", self._name_of(offset), f"a write is lost: {why}")
        else:
            self._pending[offset] = value & self.registers[offset].writable

    def _name_of(self, offset: int) -> str:
        return self.registers[offset].name if offset in self.registers else f"0x{offset:02X}"

    def write_CRH(self, value: int) -> None:
        """Enable interrupts."""
        self[CRH] = value
        self._drive()

    def write_CRL(self, value: int) -> None:
        """Clear flags by writing 0; enter configuration mode, or leave it, which writes."""
        before = self[CRL]
        self[CRL] = before & (value | ~(FLAGS | RSF)) & ~CNF | value & CNF
        if before & CNF & ~value and self._pending:
            self[CRL] &= ~RTOFF
            self._ticks.after("write", WRITING_TICKS, self._written)
        self._plan()
        self._drive()

    def _synchronise(self) -> None:
        if not self[CRL] & RSF and not self._ticks.due("sync"):
            self._ticks.after("sync", 1, self._synchronised)

    def _synchronised(self) -> None:
        self[CRL] |= RSF

    def _written(self) -> None:
        """Take over what was written in configuration mode."""
        written, self._pending = self._pending, {}
        now, count = self._ticks.now(), self.count_now
        left_over = (now - self._from_tick) % self._period
        self._prescaler = _merged(self._prescaler, written.get(PRLH), written.get(PRLL))
        self._alarm = _merged(self._alarm, written.get(ALRH), written.get(ALRL))
        self._from_count = _merged(count, written.get(CNTH), written.get(CNTL))
        self._from_tick = now if PRLH in written or PRLL in written else now - left_over
        if not self._prescaler:
            self.note("misuse", "PRLL", "a prescaler of 0 is not to be used: the flag of the second may be missed")
        self[CRL] |= RTOFF
        self._plan()

    # --- what falls due

    def _plan(self) -> None:
        """Plan the next moment of each flag that is clear."""
        self._synchronise()
        second = (self._ticks.now() + 1 - self._from_tick) // self._period + 1  # the next one that is still to be told
        count = self._from_count + second - 1
        to_alarm, to_overflow = self._alarm - count & WORD, WORD - count & WORD
        for flag, name, seconds, action in (
            (SECF, "second", 0, self._second),
            (ALRF, "alarm", to_alarm, self._alarmed),
            (OWF, "overflow", to_overflow, self._overflowed),
        ):
            tick = self._from_tick + (second + seconds) * self._period - 1
            if self[CRL] & flag and not self._told & flag:
                self._ticks.forget(name)
            elif tick - self._ticks.now() > FAR_TICKS:
                self._ticks.after(name, FAR_TICKS, self._plan)
            else:
                self._ticks.at(name, tick, action)

    def _second(self) -> None:
        self._rise(SECF)

    def _overflowed(self) -> None:
        self._rise(OWF)

    def _alarmed(self) -> None:
        self._rise(ALRF)
        self._line.set(True)
        self._line.set(False)
        self.on_alarm()

    def _rise(self, flag: int) -> None:
        self[CRL] |= flag
        self._drive()
        if self._told & flag:
            self.on_pulse(True)
            self._ticks.after("pulse", 1, lambda: self.on_pulse(False))
            self._plan()

    def _drive(self) -> None:
        self._irq.set(bool(self[CRL] & self[CRH] & FLAGS))


def _merged(value: int, high: int | None, low: int | None) -> int:
    """Return a value of two halves of which some were written."""
    high_half = value >> 16 if high is None else high
    low_half = value & HALF if low is None else low
    return high_half << 16 | low_half
