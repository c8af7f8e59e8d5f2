"""The controller without its protocol: all parts of the robot and the loop that closes through them."""

from __future__ import annotations

from collections.abc import Callable

from targets.robots.pioneer.auxport import AuxPort
from targets.robots.pioneer.bumpers import BumpGuard
from targets.robots.pioneer.chassis import Chassis
from targets.robots.pioneer.events import BumpStopped, MotorsEnabled, RobotEvent, StallCleared, Stalled
from targets.robots.pioneer.gripper import Gripper
from targets.robots.pioneer.hostbaud import HostBaud
from targets.robots.pioneer.motion import Motion
from targets.robots.pioneer.odometry import Odometer
from targets.robots.pioneer.requests import RequestBook
from targets.robots.pioneer.settings import RobotSettings
from targets.robots.pioneer.sonar import SonarArrays
from targets.robots.pioneer.speed_limits import SessionLimits
from targets.robots.pioneer.stall import WheelStall
from targets.robots.pioneer.userio import UserIo

AUX_PORTS = 3

_STANDING_MM_S = 0.5
"""Below it a wheel stands: a SIP in mm/s shows 0."""


class Controller:
    """Parts are public: commands change them, reports read them, tests and benches may set inputs such as `io`.

    Args:
        settings: What the robot is.
        chassis: Its body.
        seed: Of the odometry's slip noise.
        tell: Receives what happens, for the journal.
    """

    def __init__(
        self, settings: RobotSettings, chassis: Chassis, *, seed: int, tell: Callable[[RobotEvent], None]
    ) -> None:
        self.settings = settings
        self.tell = tell
        self._chassis = chassis
        self.limits = SessionLimits(settings)
        self.motion = Motion(settings, self.limits)
        self.odometer = Odometer(settings, chassis.wheel_angles_rad(), seed)
        self.stalls = WheelStall(settings), WheelStall(settings)
        self.bumpers = BumpGuard(settings)
        self.sonar = SonarArrays(settings, chassis.sonar_range_m)
        self.io = UserIo(settings)
        self.gripper = Gripper()
        self.requests = RequestBook()
        self.aux_ports = tuple(AuxPort(loop_back=settings.aux_loop_back) for _ in range(AUX_PORTS))
        self.host_baud = HostBaud(settings.host_baud, settings.host_baud_trial_ms * 1_000_000)
        self.gains = list(settings.pid_gains)
        self.battery_dv = settings.battery_dv
        self.compass_on = False

    # --- sessions --------------------------------------------------------------------------------------------------

    def start_session(self, now_ns: int) -> None:
        """OPEN: motors stay off, all sonar start by themselves. The pose goes on counting (choice)."""
        self.io.reset()
        self.sonar.reset()
        self.sonar.switch(True, now_ns)

    def end_session(self, now_ns: int) -> None:
        """CLOSE or the line is gone: motors and sonar off, everything a client set is as stored again.

        Motors that were on brake as in an emergency before they release the wheels (choice: no manual lets a robot
        without a client roll on). Outputs of the user I/O and the pose stay.
        """
        self._brake()
        self.sonar.switch(False, now_ns)
        self.limits.reset()
        self.bumpers.reset()
        self.requests.clear()
        for port in self.aux_ports:
            port.cancel()
        self.gains = list(self.settings.pid_gains)
        self.compass_on = False

    def enable(self, on: bool) -> None:
        """Motors on or off; off releases the wheels at once."""
        if not self.motion.enable(on):
            return
        self._tell_motors()
        if not on:
            self._chassis.release_wheels()

    def _brake(self) -> None:
        if not self.motion.motors_on:
            return
        self.motion.brake()
        self._tell_motors()

    def _tell_motors(self) -> None:
        self.tell(MotorsEnabled(enabled=self.motion.motors_on))
        if not self.motion.motors_on:
            for stall in self.stalls:
                stall.clear()

    # --- the loop --------------------------------------------------------------------------------------------------

    def control_step(self, now_ns: int, dt_s: float) -> None:
        """Sense the body as it is now, then drive it for the coming `dt_s` seconds."""
        self.odometer.update(self._chassis.wheel_angles_rad(), now_ns)
        self.motion.observe(self.odometer.travel)
        self._watch_bumpers()
        self._finish_braking()
        if self.motion.motors_on:
            self._watch_stalls(now_ns, dt_s)
        if self.motion.motors_on or self.motion.braking:
            self._drive(dt_s)
        else:
            self._chassis.release_wheels()

    def _watch_bumpers(self) -> None:
        forward_mm_s = sum(self.odometer.wheel_speeds_mm_s()) / 2
        masks = self._chassis.bumpers()
        if self.bumpers.update(masks, forward_mm_s, self.motion.direction, motors_on=self.motion.motors_on):
            self.motion.forget()
            self.tell(BumpStopped(front=self.bumpers.front, rear=self.bumpers.rear))

    def _finish_braking(self) -> None:
        fastest_mm_s = max(map(abs, self.odometer.wheel_speeds_mm_s()))
        if self.motion.braking and self.motion.at_rest and fastest_mm_s < _STANDING_MM_S:
            self.motion.forget()

    def _watch_stalls(self, now_ns: int, dt_s: float) -> None:
        before = self._stalled()
        speeds = self.odometer.wheel_speeds_mm_s()
        for stall, load, speed in zip(self.stalls, self._chassis.motor_loads(), speeds, strict=True):
            stall.update(load, speed, now_ns, dt_s)
        after = self._stalled()
        if after == before:
            return
        self.motion.restart()
        self.tell(Stalled(left=after[0], right=after[1]) if any(after) else StallCleared())

    def _stalled(self) -> tuple[bool, bool]:
        return self.stalls[0].stalled, self.stalls[1].stalled

    def _drive(self, dt_s: float) -> None:
        wanted = self.motion.step(dt_s)
        cut = self._stalled()
        if all(cut):
            self._chassis.release_wheels()
            return
        # one wheel without power: told to turn as it turns anyway, its motor pulls nowhere
        measured = self.odometer.wheel_speeds_mm_s()
        left, right = (is_ if off else want for off, is_, want in zip(cut, measured, wanted, strict=True))
        self._chassis.command_wheels(*self.odometer.wheel_rad_s(left, right))
