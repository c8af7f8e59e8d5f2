"""RTC with a calendar in BCD (RM0410 section 32; the same in F4, L0, L4 and F3 but for single bits).

It runs on RTCCLK alone, whatever HCLK does: ticks are counted from bench time, and flags come at the tick at which they
fall due. Choices where the manual says "around" or nothing at all: INITF, ALRxWF and WUTWF follow 2 ticks after what
lets them rise; counting begins 4 ticks after INIT is cleared, with both prescalers anew; a shift happens with the next
tick of the asynchronous prescaler, a new calibration counts 3 of these later; shadow registers are copied with every
even tick. The calibration is spread evenly, where silicon leaves out or adds pulses in a window of 8 to 32 seconds. A
time stamp is taken at its edge. ADD1H and SUB1H move the calendar by an hour, over midnight too.

Not modelled: tampering, the reference clock, outputs (calibration, alarm), a faulty crystal.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from fractions import Fraction

from targets.mcu.fidelity import Fidelity
from targets.mcu.registers import Peripheral, Register
from targets.mcu.services import Services
from targets.mcu.stm32.rtc_calendar import Alarm, date_register, seconds_of, time_register
from targets.mcu.stm32.ticks import Ticks

__all__ = ["Rtc"]

TR, DR, CR, ISR, PRER, WUTR = 0x00, 0x04, 0x08, 0x0C, 0x10, 0x14
ALRMAR, ALRMBR, WPR, SSR, SHIFTR = 0x1C, 0x20, 0x24, 0x28, 0x2C
TSTR, TSDR, TSSSR, CALR, TAMPCR, ALRMASSR, ALRMBSSR, OR, BKP0R = 0x30, 0x34, 0x38, 0x3C, 0x40, 0x44, 0x48, 0x4C, 0x50
BACKUP_WORDS = 32

WUCKSEL, TSEDGE, REFCKON, BYPSHAD, FMT = 0x7, 1 << 3, 1 << 4, 1 << 5, 1 << 6
ALRAE, ALRBE, WUTE, TSE = 1 << 8, 1 << 9, 1 << 10, 1 << 11
ALRAIE, ALRBIE, WUTIE, TSIE = 1 << 12, 1 << 13, 1 << 14, 1 << 15
ADD1H, SUB1H = 1 << 16, 1 << 17
ALRAWF, ALRBWF, WUTWF, SHPF, INITS, RSF, INITF, INIT = (1 << bit for bit in range(8))
ALRAF, ALRBF, WUTF, TSF, TSOVF, RECALPF = 1 << 8, 1 << 9, 1 << 10, 1 << 11, 1 << 12, 1 << 16
CLEARABLE = 0x7F00
KEYS = (0xCA, 0x53)
TRIGGERS = ("RTC_ALRA", "RTC_ALRB")  # the flags of the alarms, for who is triggered by them
ALARM_LINE, STAMP_LINE, WAKE_LINE = "EXTI17", "EXTI21", "EXTI22"
OPEN = frozenset({ISR, WPR, TAMPCR, OR, *range(BKP0R, BKP0R + 4 * BACKUP_WORDS, 4)})
"""What the key does not protect; of ISR only INIT is."""

_FIRST_DATE = 0x2101
ALLOWED_AFTER, STARTS_AFTER, RECALIBRATED_AFTER = 2, 4, 3
_NO_OUTPUT = "the reference clock and the outputs of the RTC (REFCKON, COE, OSEL, POL, COSEL) are not modelled"


def _registers() -> Iterator[Register]:
    yield Register("TR", TR, 0, 0x7F_7F7F, live=True)
    yield Register("DR", DR, _FIRST_DATE, 0xFF_FF3F, live=True)
    yield Register("CR", CR, 0, 0xFF_FF7F, REFCKON | 0xF8_0000 & ~(1 << 18), fidelity=Fidelity.PARTLY, note=_NO_OUTPUT)
    yield Register("ISR", ISR, 0x7, 0x1_7FFF)
    yield Register("PRER", PRER, 0x7F_00FF, 0x7F_7FFF)
    yield Register("WUTR", WUTR, 0xFFFF, 0xFFFF)
    yield Register("ALRMAR", ALRMAR)
    yield Register("ALRMBR", ALRMBR)
    yield Register("WPR", WPR, 0, 0xFF)
    yield Register("SSR", SSR, 0, 0, live=True)
    yield Register("SHIFTR", SHIFTR, 0, 0x8000_7FFF)
    for name, offset in (("TSTR", TSTR), ("TSDR", TSDR), ("TSSSR", TSSSR)):
        yield Register(name, offset, 0, 0)
    yield Register("CALR", CALR, 0, 0xE1FF, fidelity=Fidelity.PARTLY, note="spread evenly, not over a window")
    yield Register("TAMPCR", TAMPCR, 0, 0x1FF_FFFF, fidelity=Fidelity.ABSENT, note="nothing is ever tampered with")
    yield Register("ALRMASSR", ALRMASSR, 0, 0x0F00_7FFF)
    yield Register("ALRMBSSR", ALRMBSSR, 0, 0x0F00_7FFF)
    yield Register("OR", OR, 0, 0xF, fidelity=Fidelity.PARTLY, note="the outputs of the RTC are not modelled")
    for index in range(BACKUP_WORDS):
        yield Register(f"BKP{index}R", BKP0R + 4 * index)


@dataclass(frozen=True, slots=True)
class _Start:
    """From where the calendar counts.

    Attributes:
        tick: of RTCCLK, at which this held,
        phase: with this part of a calibrated tick gone,
        prescaled: and so many whole ones of the present tick of the asynchronous prescaler.
        count: of the sub-second counter.
        seconds: since the year 00 began.
    """

    tick: int
    phase: Fraction
    prescaled: int
    count: int
    seconds: int


class Rtc(Peripheral):
    """The real-time clock.

    Args:
        base: address of its first register.
        services: what the chip offers.
        rtc_hz: returns the rate of RTCCLK, None while it stands still; `clock_changed` is to be called when it changes.
        backup_writable: says whether the backup domain is open (PWR_CR1.DBP).
        exti_lines: the lines of EXTI for alarms, for time stamps and tampering, and for the wake-up timer.

    Attributes:
        on_wake: called at an alarm, wake-up or time stamp whose interrupt is enabled: it ends Standby.
    """

    def __init__(
        self,
        base: int,
        services: Services,
        *,
        rtc_hz: Callable[[], Fraction | None],
        backup_writable: Callable[[], bool] = lambda: True,
        exti_lines: tuple[str, str, str] = (ALARM_LINE, STAMP_LINE, WAKE_LINE),
    ) -> None:
        self._backup_writable = backup_writable
        super().__init__("RTC", base, services)
        self.on_wake: Callable[[], None] = lambda: None
        self._alarm_line, self._stamp_line, self._wake_line = (services.output(name) for name in exti_lines)
        self._triggers = tuple(services.output(name) for name in TRIGGERS)
        self._stamp = services.input("RTC_TS")
        self._ticks = Ticks(self.time, rtc_hz)
        self._clear()

    def registers_of(self) -> Iterator[Register]:
        """Return the registers."""
        return _registers()

    def _clear(self) -> None:
        self._keys = 0  # how many have been given
        self._running = True
        self._first_weekday = 0
        self._start = _Start(self._ticks.now(), Fraction(0), 0, 0, 0)
        self._start = _Start(self._ticks.now(), Fraction(0), 0, self._reload, 0)
        self._shown: tuple[int, int] | None = None  # seconds and count that a read has frozen
        self._copied_from = 0  # the tick from which on shadow registers are copied
        self._factor = Fraction(1)
        self._wake_second: int | None = None  # at which the wake-up comes that counts seconds

    # --- what the chip calls

    def reset(self) -> None:
        """A reset of the chip reaches the shadow registers, RSF and INIT (RM0410 section 32.3.9)."""
        self._ticks.refresh()
        self[ISR] &= ~(RSF | INIT)
        self._shown = None
        if self[ISR] & INITF:
            self._leave_initialization()
        self._await_copy()

    def reset_backup(self) -> None:
        """A reset of the backup domain clears everything."""
        super().reset()
        self._ticks.forget_all()
        self._stamp.on_change = None
        self._clear()
        self._drive()

    def clock_changed(self) -> None:
        """RTCCLK has another rate, or stands still, or runs again."""
        self._ticks.refresh()

    def before_clock_change(self) -> None:
        """Count up to now."""
        self._ticks.refresh()

    def after_clock_change(self) -> None:
        """Perhaps RTCCLK is another one."""
        self._ticks.refresh()

    # --- the calendar

    @property
    def _reload(self) -> int:
        return self[PRER] & 0x7FFF

    @property
    def _divider(self) -> int:
        return (self[PRER] >> 16 & 0x7F) + 1

    def _calendar(self, tick: int) -> _Start:
        """Return the calendar at a tick."""
        start = self._start
        if not self._running or tick <= start.tick:
            return start
        exact = start.phase + (tick - start.tick) * self._factor
        whole = int(exact)
        steps, prescaled = divmod(start.prescaled + whole, self._divider)
        count, seconds = start.count - steps, start.seconds
        if count < 0:
            more, rest = divmod(-count - 1, self._reload + 1)
            count, seconds = self._reload - rest, seconds + 1 + more
        return _Start(tick, exact - whole, prescaled, count, seconds)

    def _tick_of(self, seconds: int, count: int) -> int:
        """Return the tick at which the calendar will be there."""
        start = self._start
        if seconds == start.seconds:
            steps = start.count - count
        else:
            steps = start.count + 1 + (seconds - start.seconds - 1) * (self._reload + 1) + self._reload - count
        exact = (steps * self._divider - start.prescaled - start.phase) / self._factor
        return start.tick + -(-exact.numerator // exact.denominator)

    def _settle(self) -> _Start:
        """Count from the present on."""
        self._start = self._calendar(self._ticks.now())
        return self._start

    def _move(self, seconds: int, count: int) -> None:
        """Set the calendar to another moment, within the same tick of the prescaler."""
        start = self._settle()
        self._keep_waiting(seconds - start.seconds)
        self._start = _Start(start.tick, start.phase, start.prescaled, count, seconds)
        self._plan()

    # --- reading it

    def _keep_waiting(self, moved: int) -> None:
        """The calendar goes elsewhere: what is left until the wake-up stays the same."""
        if self._wake_second is not None:
            self._wake_second += moved

    def _shadow(self) -> tuple[int, int] | None:
        """Return what shadow registers show: seconds and sub-second count; None before the first copy."""
        ticks = self._ticks.now()
        if self[CR] & BYPSHAD:
            now = self._calendar(ticks)
            return now.seconds, now.count
        if self._shown is not None:
            return self._shown
        copied = ticks & ~1
        if copied < self._copied_from:
            return None
        now = self._calendar(copied)
        return now.seconds, now.count

    def read_TR(self) -> int:
        """Return the time; the date stands still until it is read, too."""
        shown = self._freeze()
        return 0 if shown is None else time_register(shown[0], half_days=bool(self[CR] & FMT))

    def read_SSR(self) -> int:
        """Return the sub-second count; time and date stand still until the date is read."""
        shown = self._freeze()
        return 0 if shown is None else shown[1]

    def read_DR(self) -> int:
        """Return the date; all three go on."""
        self._ticks.refresh()
        shown, self._shown = self._shadow(), None
        return _FIRST_DATE if shown is None else date_register(shown[0], self._first_weekday)

    def _freeze(self) -> tuple[int, int] | None:
        self._ticks.refresh()
        shown = self._shadow()
        if not self[CR] & BYPSHAD:
            self._shown = shown
        return shown

    # --- writing

    def write(self, offset: int, value: int) -> None:
        """Write the word at `offset`, if backup domain and key allow it."""
        self._ticks.refresh()
        if not self._backup_writable():
            self.note("misuse", "DBP", "a write while PWR_CR1.DBP is clear is lost")
        elif self._keys < len(KEYS) and offset not in OPEN:
            self.note("misuse", "WPR", "a write without the keys 0xCA and 0x53 in WPR before it is lost")
        else:
            super().write(offset, value)

    def write_WPR(self, value: int) -> None:
        """Take a key: whatever is not the second behind the first locks."""
        if value == KEYS[0]:
            self._keys = 1
        else:
            self._keys = 2 if value == KEYS[1] and self._keys == 1 else 0

    def read_WPR(self) -> int:
        """Write-only."""
        return 0

    def _needs_initialization(self, name: str) -> bool:
        if self[ISR] & INITF:
            return False
        self.note("misuse", name, "can be written in initialization mode only (ISR.INITF)")
        return True

    def write_TR(self, value: int) -> None:
        """Set the time, in initialization mode."""
        if not self._needs_initialization("TR"):
            self._set(date_register(self._start.seconds, self._first_weekday), value)

    def write_DR(self, value: int) -> None:
        """Set the date, in initialization mode."""
        if not self._needs_initialization("DR"):
            self._set(value, time_register(self._start.seconds, half_days=bool(self[CR] & FMT)))

    def _set(self, date: int, time: int) -> None:
        seconds, self._first_weekday = seconds_of(date, time, half_days=bool(self[CR] & FMT))
        self._keep_waiting(seconds - self._start.seconds)
        self._start = _Start(self._ticks.now(), Fraction(0), 0, self._reload, seconds)
        self[ISR] = self[ISR] | INITS if date >> 16 & 0xFF else self[ISR] & ~INITS

    def write_PRER(self, value: int) -> None:
        """Set both prescalers, in initialization mode."""
        if not self._needs_initialization("PRER"):
            self[PRER] = value
            self._start = _Start(self._ticks.now(), Fraction(0), 0, self._reload, self._start.seconds)

    def write_ISR(self, value: int) -> None:
        """Flags and RSF are cleared by writing 0; INIT as written, if the keys were given."""
        self[ISR] &= value | ~(CLEARABLE | RSF)
        if not value & RSF:
            self._await_copy()
        if self._keys == len(KEYS):
            self._initialize(bool(value & INIT))
        elif value & INIT:
            self.note("misuse", "WPR", "INIT without the keys 0xCA and 0x53 in WPR before it is lost")
        self._drive()

    def _initialize(self, wanted: bool) -> None:
        if wanted and not self[ISR] & INIT:
            self[ISR] |= INIT
            self._ticks.after("INITF", ALLOWED_AFTER, self._stop)
        elif not wanted and self[ISR] & INIT:
            self[ISR] &= ~INIT
            self._ticks.forget("INITF")
            if self[ISR] & INITF:
                self._leave_initialization()

    def _stop(self) -> None:
        self._settle()
        self._running = False
        self[ISR] = self[ISR] & ~RSF | INITF
        self._plan()

    def _leave_initialization(self) -> None:
        self[ISR] &= ~INITF
        self._start = _Start(self._ticks.now() + STARTS_AFTER, Fraction(0), 0, self._reload, self._start.seconds)
        self._running = True
        self._await_copy()
        self._plan()

    def _await_copy(self) -> None:
        """Let RSF rise with the next copy."""
        self[ISR] &= ~RSF
        self._shown = None
        following = (self._ticks.now() | 1) + 1
        self._ticks.forget("RSF")
        if not self[CR] & BYPSHAD:
            self._copied_from = following
            self._ticks.at("RSF", following, self._copied)

    def _copied(self) -> None:
        if not self[ISR] & (INITF | SHPF):
            self[ISR] |= RSF

    def write_CR(self, value: int) -> None:
        """Alarms, wake-up, time stamps, modes; ADD1H and SUB1H move the calendar and read 0."""
        old = self[CR]
        self[CR] = value & ~(ADD1H | SUB1H)
        if bool(value & ADD1H) is not bool(value & SUB1H):
            start = self._settle()
            self._move(start.seconds + (3600 if value & ADD1H else -3600), start.count)
        for enable, flag in ((ALRAE, ALRAWF), (ALRBE, ALRBWF), (WUTE, WUTWF)):
            self._allow(flag, enabled=bool(value & enable), was=bool(old & enable))
        if value & WUTE and not old & WUTE:
            self._begin_waiting()
        elif not value & WUTE:
            self._wake_second = None
            self._ticks.forget("WUTF")
        if (value ^ old) & BYPSHAD:
            self._await_copy()
        self._stamp.on_change = self._stamped if value & TSE else None
        self._plan()
        self._drive()

    def _allow(self, flag: int, *, enabled: bool, was: bool) -> None:
        """Let registers of an alarm or of the wake-up be written only while it is disabled."""
        name = f"allow {flag}"
        if enabled:
            self._ticks.forget(name)
            self[ISR] &= ~flag
        elif was:
            self._ticks.after(name, ALLOWED_AFTER, lambda: self._raise(flag))

    def _raise(self, flag: int) -> None:
        self[ISR] |= flag

    def _allowed(self, name: str, flag: int) -> bool:
        if self[ISR] & (flag | INITF):
            return True
        self.note("misuse", name, "cannot be written while it is enabled")
        return False

    def write_WUTR(self, value: int) -> None:
        """Set how long to wait."""
        if self._allowed("WUTR", WUTWF):
            self[WUTR] = value

    def write_ALRMAR(self, value: int) -> None:
        """Set what alarm A waits for."""
        self._write_alarm("ALRMAR", ALRMAR, ALRAWF, value)

    def write_ALRMBR(self, value: int) -> None:
        """Set what alarm B waits for."""
        self._write_alarm("ALRMBR", ALRMBR, ALRBWF, value)

    def write_ALRMASSR(self, value: int) -> None:
        """Set the sub-seconds that alarm A waits for."""
        self._write_alarm("ALRMASSR", ALRMASSR, ALRAWF, value)

    def write_ALRMBSSR(self, value: int) -> None:
        """Set the sub-seconds that alarm B waits for."""
        self._write_alarm("ALRMBSSR", ALRMBSSR, ALRBWF, value)

    def _write_alarm(self, name: str, offset: int, flag: int, value: int) -> None:
        if self._allowed(name, flag):
            self[offset] = value
            self._plan()

    def write_SHIFTR(self, value: int) -> None:
        """Shift the calendar by a part of a second with the next tick of the prescaler."""
        now = self._settle()
        if self[ISR] & SHPF or now.count > 0x7FFF:
            self.note(
                "misuse", "SHIFTR", "a shift while another is pending, or while SS has more than 15 bits, is lost"
            )
            return
        self[ISR] = self[ISR] & ~RSF | SHPF
        ticks = -(-((self._divider - now.prescaled - now.phase) / self._factor) // 1)
        self._ticks.after("SHPF", int(ticks), lambda: self._shift(value))

    def read_SHIFTR(self) -> int:
        """Write-only."""
        return 0

    def _shift(self, value: int) -> None:
        self[ISR] &= ~SHPF
        now = self._settle()
        self._move(now.seconds + (value >> 31), now.count + (value & 0x7FFF))
        self._await_copy()

    def write_CALR(self, value: int) -> None:
        """Make the clock faster or slower."""
        if self[ISR] & RECALPF:
            self.note("misuse", "CALR", "a calibration while another is pending is lost")
            return
        self[CALR] = value
        self[ISR] |= RECALPF
        self._ticks.after("RECALPF", RECALIBRATED_AFTER * self._divider, self._recalibrate)

    def _recalibrate(self) -> None:
        self[ISR] &= ~RECALPF
        self._settle()
        added, left_out = (512 if self[CALR] & 1 << 15 else 0), self[CALR] & 0x1FF
        self._factor = 1 + Fraction(added - left_out, (1 << 20) + left_out - added)
        self._plan()

    # --- what falls due

    def _plan(self) -> None:
        """Look for the next alarms and, if it counts seconds, the next wake-up."""
        self._plan_alarm(ALRAF)
        self._plan_alarm(ALRBF)
        if self._wake_second is not None:
            self._plan_seconds(self._wake_second)

    def _plan_alarm(self, flag: int) -> None:
        name = f"alarm {flag}"
        offset, sub_seconds = (ALRMAR, ALRMASSR) if flag == ALRAF else (ALRMBR, ALRMBSSR)
        self._ticks.forget(name)
        if not self[CR] & flag or not self._running:  # ALRAE and ALRBE are where their flags are in ISR
            return
        now = self._settle()
        alarm = Alarm(self[offset], self[sub_seconds], bool(self[CR] & FMT), self._first_weekday)
        found = alarm.after(now.seconds, now.count, self._reload)
        if found is not None:
            self._ticks.at(name, self._tick_of(*found), lambda: self._alarmed(flag))

    def _alarmed(self, flag: int) -> None:
        self[ISR] |= flag
        self._plan_alarm(flag)
        self._drive()
        if self[CR] & (ALRAIE if flag == ALRAF else ALRBIE):
            self.on_wake()

    def _begin_waiting(self) -> None:
        """Begin a wait of WUT + 1 ticks of what WUCKSEL chooses: RTCCLK by 16, 8, 4, 2, or seconds."""
        choice = self[CR] & WUCKSEL
        if choice & 0b100:
            self._wake_second = self._settle().seconds + self[WUTR] + 1 + (0x1_0000 if choice & 0b010 else 0)
            self._plan_seconds(self._wake_second)
        else:
            self._ticks.after("WUTF", (self[WUTR] + 1) * (16 >> choice), self._waited)

    def _plan_seconds(self, second: int) -> None:
        self._settle()
        if self._running:
            self._ticks.at("WUTF", self._tick_of(second, self._reload), self._waited)
        else:
            self._ticks.forget("WUTF")

    def _waited(self) -> None:
        self[ISR] |= WUTF
        self._begin_waiting()
        self._drive()
        if self[CR] & WUTIE:
            self.on_wake()

    def _stamped(self, level: bool) -> None:
        """Take a time stamp at the edge that TSEDGE chooses."""
        if level is bool(self[CR] & TSEDGE):
            return
        if self[ISR] & TSF:
            self[ISR] |= TSOVF
            return
        now = self._calendar(self._ticks.now())
        self[TSTR] = time_register(now.seconds, half_days=bool(self[CR] & FMT))
        self[TSDR] = date_register(now.seconds, self._first_weekday) & 0xFFFF
        self[TSSSR] = now.count
        self[ISR] |= TSF
        self._drive()
        if self[CR] & TSIE:
            self.on_wake()

    def _drive(self) -> None:
        """Drive the lines to EXTI."""
        flags, enabled = self[ISR], self[CR]
        alarms = flags & (ALRAF | ALRBF) & enabled >> 4
        self._alarm_line.set(bool(alarms))
        self._wake_line.set(bool(flags & WUTF and enabled & WUTIE))
        self._stamp_line.set(bool(flags & TSF and enabled & TSIE))
        for output, flag in zip(self._triggers, (ALRAF, ALRBF), strict=True):
            output.set(bool(flags & flag))
