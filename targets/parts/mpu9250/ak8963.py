"""The magnetometer in the package: an AK8963, at 0x0C (its data sheet MS1356-E, RM-MPU-9250A-00 section 5).

Choices where the data sheet is silent: the field is that at the end of the measurement; a mode that is set while
another one is on takes effect at once and is noted; INFO is 0x9A, as parts answer; outside the fuse ROM mode the
sensitivity adjustments read 0 (the data sheet: "not correct"); TS1, TS2 and the external trigger do nothing.
"""

from __future__ import annotations

from collections.abc import Callable

from targets.parts.mpu9250.notes import Notes
from targets.parts.track import Vector

__all__ = ["AK8963_ADDRESS", "MEASUREMENT_NS", "Ak8963", "sensitivity"]

AK8963_ADDRESS = 0x0C

MEASUREMENT_NS = 7_200_000
"""How long a measurement takes, typically (MS1356-E section 5.3)."""

_DEVICE_ID, _INFO = 0x48, 0x9A
_WIA, _INFO_AT, _ST1, _HXL, _HZH, _ST2, _CNTL1, _CNTL2, _ASTC = 0x00, 0x01, 0x02, 0x03, 0x08, 0x09, 0x0A, 0x0B, 0x0C
_TS1, _TS2, _I2CDIS, _ASAX, _ASAZ = 0x0D, 0x0E, 0x0F, 0x10, 0x12
_DISABLE = 0x1B
_POWER_DOWN, _SINGLE, _SLOW, _TRIGGER, _FAST, _SELF_TEST, _FUSE_ROM = 0x0, 0x1, 0x2, 0x4, 0x6, 0x8, 0xF
_PERIODS_NS = {_SLOW: 125_000_000, _FAST: 10_000_000}
_ONCE = (_SINGLE, _SELF_TEST)
_MODES = (_POWER_DOWN, _SINGLE, _SLOW, _TRIGGER, _FAST, _SELF_TEST, _FUSE_ROM)
_WAIT_NS = 100_000
"""From power-down to another mode, at least (MS1356-E section 6.3)."""

_UT_PER_LSB_14, _UT_PER_LSB_16 = 0.6, 0.15
_GREATEST_14, _GREATEST_16 = 8190, 32760
_OVERFLOW_UT = 4912.0
_SELF_TEST_UT = (0.0, 0.0, -300.0)
"""The middle of -200..200, -200..200, -3200..-800 in 16 bits (RM section 5.11)."""


def sensitivity(code: int) -> float:
    """What a measurement has to be multiplied with for a code in ASAX, ASAY or ASAZ (MS1356-E section 8.3.11)."""
    return (code - 128) * 0.5 / 128 + 1


class Ak8963:
    """The magnetometer as an I2C slave; see the module. `advance` lets its time pass.

    Args:
        field_ut: called with the number of the measurement and a time in ns; the field in its own axes.
        codes: ASAX, ASAY, ASAZ.
        notes: takes what is not modelled.
    """

    def __init__(self, field_ut: Callable[[int, int], Vector], codes: tuple[int, ...], notes: Notes) -> None:
        self._field_ut = field_ut
        self._codes = codes
        self._notes = notes
        self._enabled = True
        self._measured = 0
        self._pointer = 0
        self._pointer_set = True
        self._reset()

    def _reset(self) -> None:
        self._mode = _POWER_DOWN
        self._wide = False
        self._self_test = False
        self._ready = self._overrun = self._overflow = False
        self._protected = self._skipped = False
        self._data = bytes(_HZH - _HXL + 1)
        self._due_ns: int | None = None
        self._rested_ns: int | None = None

    def advance(self, now_ns: int) -> None:
        """Finish the measurements that end until then."""
        while self._due_ns is not None and self._due_ns <= now_ns:
            due_ns = self._due_ns
            self._finish(due_ns)
            period_ns = _PERIODS_NS.get(self._mode)
            self._due_ns = None if period_ns is None else due_ns + period_ns
            if self._mode in _ONCE:
                self._mode, self._rested_ns = _POWER_DOWN, due_ns

    # --- as a slave

    def address(self, address: int, read: bool, now_ns: int) -> bool:
        """Acknowledge its address."""
        self.advance(now_ns)
        if address != AK8963_ADDRESS or not self._enabled:
            return False
        self._pointer_set = read
        return True

    def write(self, byte: int, now_ns: int) -> bool:
        """Take the register's address, then values."""
        self.advance(now_ns)
        if not self._pointer_set:
            self._pointer, self._pointer_set = byte, True
        else:
            self._write(self._pointer, byte, now_ns)
            self._pointer = _next(self._pointer)
        return True

    def read(self, now_ns: int) -> int:
        """Return the value of the register whose turn it is."""
        self.advance(now_ns)
        value = self._read(self._pointer)
        self._pointer = _next(self._pointer)
        return value

    def end(self, now_ns: int) -> None:
        """Nothing depends on it."""

    # --- registers

    def _read(self, address: int) -> int:
        if _HXL <= address <= _HZH:
            self._protected = self._mode in _PERIODS_NS
            self._ready = self._overrun = False
            return self._data[address - _HXL]
        if address == _ST2:
            return self._read_status_2()
        fixed = {
            _WIA: _DEVICE_ID,
            _INFO_AT: _INFO,
            _ST1: self._ready | self._overrun << 1,
            _CNTL1: self._mode | self._wide << 4,
            _ASTC: self._self_test << 6,
        }
        if _ASAX <= address <= _ASAZ:
            return self._read_fuse(address - _ASAX)
        return fixed.get(address, 0)

    def _read_status_2(self) -> int:
        self._ready, self._overrun = False, self._skipped
        self._protected = self._skipped = False
        return self._overflow << 3 | self._wide << 4

    def _read_fuse(self, axis: int) -> int:
        if self._mode == _FUSE_ROM:
            return self._codes[axis]
        self._notes.note(
            "AK8963: ASAX to ASAZ are read outside the fuse ROM mode, what they give is not correct; here 0"
        )
        return 0

    def _write(self, address: int, value: int, now_ns: int) -> None:
        if address == _CNTL1:
            self._wide = bool(value & 0x10)
            self._set_mode(value & 0xF, now_ns)
        elif address == _CNTL2:
            if value & 1:
                self._reset()
        elif address == _ASTC:
            self._self_test = bool(value & 0x40)
        elif address == _I2CDIS:
            self._enabled = value != _DISABLE
        elif address in (_TS1, _TS2):
            self._notes.note("AK8963: TS1 and TS2 are for the factory's tests, they do nothing here")

    def _set_mode(self, mode: int, now_ns: int) -> None:
        if mode not in _MODES:
            self._notes.note(f"AK8963: mode 0x{mode:X} is prohibited; powered down")
            mode = _POWER_DOWN
        if mode == _TRIGGER:
            self._notes.note("AK8963: the external trigger is not modelled, nothing will be measured")
        if mode != _POWER_DOWN:
            self._check_rest(mode, now_ns)
        elif self._mode != _POWER_DOWN:
            self._rested_ns = now_ns
        self._mode = mode
        self._due_ns = now_ns + MEASUREMENT_NS if mode in _PERIODS_NS or mode in _ONCE else None

    def _check_rest(self, mode: int, now_ns: int) -> None:
        if self._mode not in (_POWER_DOWN, mode):
            self._notes.note("AK8963: the mode is changed without power-down in between")
        elif self._rested_ns is not None and now_ns - self._rested_ns < _WAIT_NS and self._mode == _POWER_DOWN:
            self._notes.note("AK8963: a mode is set less than 100 us after power-down")

    # --- measurements

    def _finish(self, at_ns: int) -> None:
        self._measured += 1
        if self._protected:
            self._skipped = True
            return
        field_ut = self._field_ut(self._measured, at_ns)
        if self._mode == _SELF_TEST and self._self_test:
            # The response is given after the adjustment, so the axes' sensitivities are taken out again here.
            field_ut = _SELF_TEST_UT
        step_ut, greatest = (_UT_PER_LSB_16, _GREATEST_16) if self._wide else (_UT_PER_LSB_14, _GREATEST_14)
        counts = (
            max(-greatest, min(greatest, round(part / step_ut / sensitivity(code))))
            for part, code in zip(field_ut, self._codes, strict=True)
        )
        self._data = b"".join(count.to_bytes(2, "little", signed=True) for count in counts)
        self._overflow = sum(map(abs, field_ut)) >= _OVERFLOW_UT
        self._overrun = self._ready and self._mode in _PERIODS_NS
        self._ready = True


def _next(address: int) -> int:
    """Where the counter of a burst goes: around in 00 to 0C and in 10 to 12 (MS1356-E section 7.2); else nowhere."""
    if address <= _ASTC:
        return (address + 1) % (_ASTC + 1)
    if _ASAX <= address <= _ASAZ:
        return _ASAX + (address - _ASAX + 1) % 3
    return address
