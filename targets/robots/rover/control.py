"""Between commands and motors: throttles, and the speed controllers with what they know of the wheels.

Sources: manual, nhorro/ceai2020 rover_firmware/doc/index.md, chapters on the PID controller and the tachometers; G2 at
6058e92, controllers/pid.cpp, actuators/motor/l298n_motor_control.cpp, application.cpp `read_tachometers`.
"""

from __future__ import annotations

import math
import statistics
from collections.abc import Sequence

from protocols.pkt import MotorFlag
from targets.robots.rover.behaviour import BodyQuirks
from targets.robots.rover.plant import WHEELS, Wheel

__all__ = ["Motors", "SpeedController", "Tachometers"]

CONTROL_S = 0.02
"""Time between two turns of the speed controllers (manual, table of tasks: 50 Hz)."""

_NS_PER_S = 1_000_000_000
_FORGET_NS = _NS_PER_S
"""A wheel without a slot for this long stands (G2 application.cpp `read_tachometers`)."""
_FASTEST_RPM = 1000.0
"""A faster reading is taken for a bounce (G2, as above)."""
_WINDOW = 3


class Tachometers:
    """What the firmware makes of the slots: the time between two of them, and the median of three readings.

    Args:
        quirks: see `BodyQuirks`.

    Attributes:
        rpm: without a sign, of each wheel.
    """

    def __init__(self, quirks: BodyQuirks) -> None:
        self._limit_rpm = quirks.shown_limit_rpm
        self._slots = quirks.slots
        self._held = quirks.speed_held
        self._windows = [list(quirks.median_begins) for _ in range(WHEELS)]
        self.rpm = [0.0] * WHEELS

    def read(self, wheels: Sequence[Wheel], now_ns: int) -> None:
        """Takes a reading of each wheel."""
        for number, wheel in enumerate(wheels):
            window = self._windows[number]
            window.append(self._reading_rpm(wheel.edge_times_ns, now_ns))
            del window[: len(window) - _WINDOW]
            rpm = statistics.median(window)
            self.rpm[number] = 0.0 if self._limit_rpm is not None and rpm > self._limit_rpm else rpm

    def side_rpm(self, side: int) -> float:
        """The speed of a pair: the slower of its two (G2; their mean is an alternative at compile time)."""
        return min(self.rpm[side], self.rpm[side + 2])

    def _reading_rpm(self, edge_times_ns: Sequence[int], now_ns: int) -> float:
        """The speed by the last two slots; while the next one is late, the speed at which it would come now."""
        if len(edge_times_ns) < 2:
            return 0.0
        age_ns, gap_ns = now_ns - edge_times_ns[-1], edge_times_ns[-1] - edge_times_ns[-2]
        if age_ns >= _FORGET_NS or not 0 < gap_ns <= _FORGET_NS:
            return 0.0
        rpm = 60 * _NS_PER_S / (self._slots * (gap_ns if self._held else max(gap_ns, age_ns)))
        return rpm if rpm <= _FASTEST_RPM else 0.0


class SpeedController:
    """Proportional, integral, differential; the output is kept to -1..1.

    Args:
        quirks: the gains at power-up.
    """

    def __init__(self, quirks: BodyQuirks) -> None:
        self._windup = quirks.windup
        self.set_gains(quirks.kp, quirks.kd, quirks.ki)

    def set_gains(self, kp: float, kd: float, ki: float) -> None:
        """Takes gains and forgets its sums."""
        self.kp, self.kd, self.ki = kp, kd, ki
        self.reset()

    def reset(self) -> None:
        """Forgets its sums."""
        self._sum = self._error_before = 0.0

    def process(self, setpoint_rpm: float, measured_rpm: float) -> float:
        """The throttle for a speed, after `CONTROL_S`."""
        error = setpoint_rpm - measured_rpm
        before, self._sum = self._sum, self._sum + error * CONTROL_S
        slope = (error - self._error_before) / CONTROL_S
        self._error_before = error
        throttle = self.kp * error + self.ki * self._sum + self.kd * slope
        if abs(throttle) > 1 and not self._windup:
            self._sum = before
        return 0.0 if math.isnan(throttle) else min(1.0, max(-1.0, throttle))


class Motors:
    """Both pairs.

    Args:
        quirks: see `BodyQuirks`.

    Attributes:
        throttles: left and right pair, as they are reported.
        setpoints_rpm: as above.
        pid: the controllers set the throttles.
    """

    def __init__(self, quirks: BodyQuirks) -> None:
        self.throttles = [0.0, 0.0]
        self.setpoints_rpm = [0.0, 0.0]
        self.pid = False
        self.controllers = tuple(SpeedController(quirks) for _ in range(2))
        self._mode_resets = quirks.mode_resets_controllers

    def set_throttles(self, a: float, b: float, flags: int) -> None:
        """Manual mode, with these throttles for the pairs that the flags name."""
        self.pid = False
        self._set(self.throttles, (a, b), flags)

    def set_setpoints(self, a_rpm: float, b_rpm: float, flags: int) -> None:
        """Speed control, with these speeds for the pairs that the flags name."""
        if not self.pid and self._mode_resets:
            for controller in self.controllers:
                controller.reset()
        self.pid = True
        self._set(self.setpoints_rpm, (a_rpm, b_rpm), flags)

    def set_gains(self, kp: float, kd: float, ki: float) -> None:
        """Gains for both controllers."""
        for controller in self.controllers:
            controller.set_gains(kp, kd, ki)

    def stop(self) -> None:
        """Both pairs off, until they are commanded again."""
        self.pid = False
        self.throttles[:] = self.setpoints_rpm[:] = [0.0, 0.0]

    def control(self, tachometers: Tachometers) -> None:
        """One turn of the speed controllers; the direction of a wheel is taken from its last throttle."""
        if not self.pid:
            return
        for side, controller in enumerate(self.controllers):
            measured_rpm = math.copysign(tachometers.side_rpm(side), self.throttles[side])
            self.throttles[side] = controller.process(self.setpoints_rpm[side], measured_rpm)

    @property
    def duties(self) -> tuple[float, float]:
        """What reaches the motor driver: -1..1 of full voltage, left and right pair."""
        left, right = (0.0 if math.isnan(one) else min(1.0, max(-1.0, one)) for one in self.throttles)
        return left, right

    def _set(self, which: list[float], values: tuple[float, float], flags: int) -> None:
        for side, flag in enumerate((MotorFlag.A, MotorFlag.B)):
            if flags & flag:
                which[side] = values[side]
