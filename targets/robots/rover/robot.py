"""The rover: its end of the protocol, its wheels and its sensors, on one time base.

As in the firmware everything happens on ticks of 100 Hz: bytes are taken as they come, or polled; tachometers and
speed controllers run on every second tick, and reports go out behind them (nhorro/ceai2020 at 6058e92,
rover_firmware/application.cpp `execute_periodic_tasks`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable

from protocols.pkt import (
    Command,
    CommandReceived,
    CommandRefused,
    Connection,
    EulerImuReport,
    Event,
    GpsReport,
    ImuReport,
    LedOff,
    LedOn,
    MotionReport,
    MotorsMustStop,
    MotorSpeeds,
    MotorThrottles,
    PidGains,
    PidReport,
    Position,
    Report,
    ReportDue,
    ReportId,
    Role,
    Schema,
    SpeedSetpoints,
    Transmit,
    acceleration_raw,
    gps_report,
    quaternion_raw,
)
from protocols.pkt.commands import MAX_SPEED
from targets.robots.rover.behaviour import BEHAVIOURS, Behaviour
from targets.robots.rover.control import Motors, Tachometers
from targets.robots.rover.defects import DEFECTS
from targets.robots.rover.events import LedSwitched, MotorsCommanded, RoverEvent
from targets.robots.rover.plant import Plant
from targets.robots.rover.sensed import Rocking, Sensed
from targets.robots.rover.settings import RoverSettings

__all__ = ["RoverRobot", "behaviour_of"]

_NS_PER_S = 1_000_000_000
_TICK_NS = 10_000_000
_CONTROL_TICKS = 2
_BLINK_TICKS = 100
_IMU_READ = 1
_COMPASS_READ = 2
_NO_ATTITUDE = (math.nan, math.nan, math.nan, math.nan)


def behaviour_of(settings: RoverSettings) -> Behaviour:
    """The behaviour that the settings mean."""
    behaviour = BEHAVIOURS[settings.profile]
    for name in settings.defects:
        behaviour = DEFECTS[name].put_into(behaviour)
    return behaviour


class RoverRobot:
    """A rover from power-on at `power_on_ns`, in ns of bench time.

    Args:
        settings: what it is set to.
        power_on_ns: when it is switched on.
        behaviour: another one than that of the settings.
        connection: another end of the protocol, for tests that must be able to fail.

    Attributes:
        plant: its wheels.
        motors: what they are commanded.
        lit: whether the test LED is on.
        sensed: what its inertial sensor senses at rest.
        rocking: how it is turned to and fro; None at rest.
        position: where its GPS receiver is; None without a fix.
    """

    def __init__(
        self,
        settings: RoverSettings,
        *,
        power_on_ns: int = 0,
        behaviour: Behaviour | None = None,
        connection: Connection | None = None,
    ) -> None:
        self._settings = settings
        self.behaviour = behaviour_of(settings) if behaviour is None else behaviour
        boot_s = self.behaviour.body.boot_s if settings.boot_s is None else settings.boot_s
        epoch_ns = power_on_ns + round(boot_s * _NS_PER_S)
        self.connection = connection or Connection(Role.SERVER, self.behaviour.server, epoch_ns=epoch_ns)
        self.plant = Plant(settings.wheel_lag_s)
        self.motors = Motors(self.behaviour.body)
        self.lit = False
        self.sensed = Sensed(field_mgauss=settings.field_mgauss, temperature_c=settings.temperature_c)
        self.rocking: Rocking | None = None
        self.position: Position | None = Position(
            latitude_deg=settings.latitude_deg, longitude_deg=settings.longitude_deg
        )
        self._tachometers = Tachometers(self.behaviour.body)
        self._epoch_ns = epoch_ns
        self._tick = 0
        self._spoken_to = False
        self._stuck_duties: tuple[float, float] | None = None
        self._events: list[RoverEvent | Event] = []

    @property
    def duties(self) -> tuple[float, float]:
        """What reaches the motor driver: -1..1 of full voltage, left and right pair."""
        return self.motors.duties if self._stuck_duties is None else self._stuck_duties

    # --- a device on a line

    def receive(self, data: bytes, now_ns: int) -> bytes:
        """Takes bytes off the line; returns what to put on it."""
        sent = self.advance(now_ns)
        if now_ns < self._epoch_ns:
            return sent  # still booting: nobody listens
        return sent + self._take(self.connection.receive(data, now_ns), now_ns)

    def advance(self, now_ns: int) -> bytes:
        """Does what is due at a time; returns what to put on the line."""
        sent = b""
        while (tick_ns := self._tick_ns()) <= now_ns:
            if tick_ns:
                sent += self._take(self.connection.advance(tick_ns - 1), tick_ns)
            self._on_tick(tick_ns)
            sent += self._take(self.connection.advance(tick_ns), tick_ns)
        return sent + self._take(self.connection.advance(now_ns), now_ns)

    def next_deadline_ns(self) -> int | None:
        """When `advance` has something to do."""
        due_ns = self.connection.next_deadline_ns()
        return self._tick_ns() if due_ns is None else min(due_ns, self._tick_ns())

    def line_down(self, now_ns: int) -> bytes:
        """The line is gone; a UART does not notice."""
        return self.advance(now_ns)

    def take_events(self) -> Iterable[RoverEvent | Event]:
        """What happened since the last call."""
        events, self._events = self._events, []
        return events

    # --- what happens on a tick

    def _tick_ns(self) -> int:
        return self._epoch_ns + self._tick * _TICK_NS

    def _on_tick(self, tick_ns: int) -> None:
        self.plant.advance(self.duties, tick_ns)
        if self.behaviour.body.led_shared and not self._spoken_to and self._tick % _BLINK_TICKS == 0:
            self._switch_led(not self.lit)
        if self._tick % _CONTROL_TICKS == 0:
            self._tachometers.read(self.plant.wheels, tick_ns)
            self.motors.control(self._tachometers)
        self._tick += 1

    # --- what the host wants

    def _take(self, events: Iterable[Event], now_ns: int) -> bytes:
        sent = b""
        for event in events:
            match event:
                case Transmit(data=data):
                    sent += data
                case ReportDue(report=report):
                    sent += self.connection.send(self._report(report), now_ns)
                case CommandReceived(command=command):
                    self._events.append(event)
                    self._show_packet()
                    self._obey(command)
                case CommandRefused():
                    self._events.append(event)
                    self._show_packet()
                case MotorsMustStop():
                    self._events.append(event)
                    if not self.behaviour.body.stop_reaches_motors:
                        self._stuck_duties = self.duties
                    self.motors.stop()
                    self._tell_motors()
                case _:
                    self._events.append(event)
        return sent

    def _obey(self, command: Command) -> None:
        match command:
            case LedOn() | LedOff():
                self._switch_led(isinstance(command, LedOn))
            case MotorSpeeds(a=a, b=b, flags=flags):
                self.motors.set_throttles(a / MAX_SPEED, b / MAX_SPEED, flags)
                self._stuck_duties = None
                self._tell_motors()
            case MotorThrottles(a=a, b=b, flags=flags):
                self.motors.set_throttles(a, b, flags)
                self._stuck_duties = None
                self._tell_motors()
            case SpeedSetpoints(a_rpm=a_rpm, b_rpm=b_rpm, flags=flags):
                self.motors.set_setpoints(a_rpm, b_rpm, flags)
                self._stuck_duties = None
                self._tell_motors()
            case PidGains(kp=kp, kd=kd, ki=ki):
                self.motors.set_gains(kp, kd, ki)

    def _show_packet(self) -> None:
        self._spoken_to = True
        if self.behaviour.body.led_shared:
            self._switch_led(not self.lit)

    def _switch_led(self, lit: bool) -> None:
        self.lit = lit
        self._events.append(LedSwitched(lit=lit))

    def _tell_motors(self) -> None:
        motors = self.motors
        left, right = motors.throttles
        left_rpm, right_rpm = motors.setpoints_rpm
        event = MotorsCommanded(throttles=(left, right), setpoints_rpm=(left_rpm, right_rpm), pid=motors.pid)
        self._events.append(event)

    # --- what the host receives

    def _report(self, report: ReportId) -> Report:
        makers: dict[ReportId, Callable[[], Report]] = {
            ReportId.IMU: self._imu,
            ReportId.MOTION: self._motion,
            ReportId.GPS: self._gps,
        }
        return makers.get(report, self._pid)()

    def _imu(self) -> Report:
        dialect = self.behaviour.dialect
        sensed = self.sensed if self.rocking is None else self.rocking.sensed(self.sensed, self._tick_ns())
        acceleration = acceleration_raw(sensed.acceleration_m_s2, dialect)
        if self.behaviour.server.schema is Schema.V1:
            return EulerImuReport(
                validity=_IMU_READ,
                acceleration=acceleration,
                rate_deg_s=sensed.rate_deg_s,
                field_mgauss=sensed.field_mgauss,
                temperature_c=sensed.temperature_c,
            )
        return ImuReport(
            validity=_IMU_READ | _COMPASS_READ,
            acceleration=acceleration,
            rate_deg_s=sensed.rate_deg_s,
            field_mgauss=sensed.field_mgauss,
            temperature_c=sensed.temperature_c,
            quaternion=quaternion_raw(
                sensed.attitude_wxyz if self.behaviour.body.attitude_known else _NO_ATTITUDE, dialect
            ),
        )

    def _motion(self) -> Report:
        motors, wheels = self.motors, self.plant.wheels
        lf, rf, lb, rb = self._tachometers.rpm
        return MotionReport(
            rpm=(lf, rf, lb, rb),
            ticks=(wheels[0].ticks, wheels[1].ticks, wheels[2].ticks, wheels[3].ticks),
            throttles=(motors.throttles[0], motors.throttles[1]),
            setpoints_rpm=(motors.setpoints_rpm[0], motors.setpoints_rpm[1]),
        )

    def _gps(self) -> Report:
        if self.position is None or not self.behaviour.body.position_known:
            return GpsReport()
        return gps_report(self.position, self.behaviour.dialect, validity=1)

    def _pid(self) -> Report:
        left = self.motors.controllers[0]
        return PidReport(kp=left.kp, kd=left.kd, ki=left.ki)
