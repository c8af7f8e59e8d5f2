"""A ground station on a bench: drives a PKT! rover through a port, and knows what the rover last said.

It works on any link: the virtual rover's line, an emulated board's USART, a serial port, a pty, a socket. It is what
our own programs use, and the client that the suite ``pkt-host`` tests when no other is named. Whether the rover speaks
of g or m/s^2, of latitude or longitude first, is the business of the profile it is made with.

While it is connected it asks for 0x80 whenever it has said nothing for a while (`ClientOptions.request_s`), which keeps
the rover's motors from being stopped. Whoever drives by hand and may fall silent sends `stop` or disconnects.
"""

from __future__ import annotations

import math
from collections import Counter, deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

from hilbench.bench import Bench
from hilbench.bench.devices import ClientDevice, DeviceActor
from hilbench.links import Port
from protocols.pkt import (
    BOTH_MOTORS,
    PROFILES,
    ClientOptions,
    ClientState,
    Command,
    Connection,
    EulerImuReport,
    GeneralReport,
    GpsReport,
    ImuReport,
    LedOff,
    LedOn,
    LocalProtocolError,
    MotionReport,
    MotorSpeeds,
    MotorThrottles,
    PacketTotals,
    PidGains,
    Position,
    Profile,
    Report,
    ReportReceived,
    RequestTelemetry,
    Role,
    RoverFound,
    RoverLost,
    Schema,
    SpeedSetpoints,
    Table,
    Transmit,
    acceleration_m_s2,
    attitude_wxyz,
    position,
)
from protocols.pkt.commands import MAX_SPEED

__all__ = ["HISTORY", "Chassis", "GroundStation", "Telemetry"]

HISTORY = 4096
"""How many reports are kept; the newest of each kind is known however long ago it came."""

ReportT = TypeVar("ReportT")


@dataclass(frozen=True, slots=True, kw_only=True)
class Chassis:
    """What a unicycle's motion means for the wheels.

    Attributes:
        wheel_radius_m: of each wheel; 65 mm wheels are common in kits of four motors and a plate (assumed).
        track_m: between the middles of left and right wheels (assumed, as above).
        turn_slip: how much faster the wheels have to run to turn than those of two wheels on one axle: four wheels that
            do not steer are dragged sideways. 1 for no slip; it depends on the floor and has to be measured.
        full_rpm: the wheels' speed at full throttle, for driving without tachometers (assumed).
    """

    wheel_radius_m: float = 0.0325
    track_m: float = 0.140
    turn_slip: float = 1.0
    full_rpm: float = 250.0

    def wheels_rpm(self, speed_m_s: float, turn_rad_s: float) -> tuple[float, float]:
        """The speeds of the left and the right wheels for a motion forward and counter-clockwise."""
        sideways = turn_rad_s * self.track_m / 2 * self.turn_slip
        per_m_s = 60 / (2 * math.pi * self.wheel_radius_m)
        return (speed_m_s - sideways) * per_m_s, (speed_m_s + sideways) * per_m_s


@dataclass(frozen=True, slots=True, kw_only=True)
class Telemetry:
    """The newest report of a kind.

    Attributes:
        ns: bench time at which it came.
        report: what it says.
    """

    ns: int
    report: Report


class GroundStation:
    """Drives a rover through a port.

    Args:
        bench: whose time and journal are used.
        port: the station's end of the line.
        profile: what the rover speaks, and what its numbers mean.
        options: of the client role; those of the profile if None.
        chassis: what a unicycle's motion means for the wheels.
        table: state table of the client role; only tests of the tests give another than the right one.

    Attributes:
        connection: its end of the protocol, with its counters.
        history: the latest reports, oldest first, each with its time.
        counts: how many reports of each kind have come.
        latest: the newest report of each kind.
        failure: why the rover was lost; empty if it is heard, or was never asked.
        on_report: called with each report as it comes.
    """

    def __init__(
        self,
        bench: Bench,
        port: Port,
        profile: Profile = PROFILES["documented"],
        *,
        options: ClientOptions | None = None,
        chassis: Chassis | None = None,
        table: Table | None = None,
    ) -> None:
        self._bench = bench
        self._dialect = profile.dialect
        self.chassis = chassis or Chassis()
        self.options = options or profile.client
        self.connection = Connection(Role.CLIENT, self.options, table=table)
        self.history: deque[Telemetry] = deque(maxlen=HISTORY)
        self.counts: Counter[type[Report]] = Counter()
        self.latest: dict[type[Report], Telemetry] = {}
        self.failure = ""
        self.on_report: Callable[[Telemetry], None] = lambda _telemetry: None
        self._device = ClientDevice(self.connection, Transmit)
        self._actor = DeviceActor(bench, self._device, port, name="station", on_event=self._take)

    # --- what it knows

    @property
    def state(self) -> ClientState:
        """The state of the station's connection."""
        state = self.connection.state
        assert isinstance(state, ClientState)
        return state

    @property
    def totals(self) -> PacketTotals | None:
        """Packets that the rover has accepted and rejected, without the wrapping of its bytes; None before 0x80."""
        return self.connection.totals

    @property
    def general(self) -> GeneralReport | None:
        """The newest 0x80."""
        return self._newest(GeneralReport)

    @property
    def motion(self) -> MotionReport | None:
        """The newest 0x83: wheel speeds, counts, throttles, setpoints."""
        return self._newest(MotionReport)

    @property
    def acceleration_m_s2(self) -> tuple[float, float, float] | None:
        """The newest specific force along X, Y and Z, whatever unit the rover speaks of."""
        imu = self._newest(ImuReport) or self._newest(EulerImuReport)
        return None if imu is None else acceleration_m_s2(imu, self._dialect)

    @property
    def rate_deg_s(self) -> tuple[float, float, float] | None:
        """The newest angular rate about X, Y and Z."""
        imu = self._newest(ImuReport) or self._newest(EulerImuReport)
        return None if imu is None else imu.rate_deg_s

    @property
    def attitude_wxyz(self) -> tuple[float, float, float, float] | None:
        """The newest attitude, scalar first, whatever order the rover speaks in."""
        imu = self._newest(ImuReport)
        return None if imu is None else attitude_wxyz(imu, self._dialect)

    @property
    def position(self) -> Position | None:
        """Where the rover says it is; None before it said so, and while it says two zeros: it does not know."""
        gps = self._newest(GpsReport)
        if gps is None or (gps.first_deg, gps.second_deg) == (0.0, 0.0):
            return None
        return position(gps, self._dialect)

    # --- the link

    def connect(self) -> None:
        """Begin to ask for reports.

        Raises:
            LocalProtocolError: it does so already.
        """
        data = self._device.take(self.connection.connect(self._bench.now_ns))
        self.failure = ""
        self._actor.transmit(data)

    def disconnect(self) -> None:
        """Stop the motors and fall silent.

        Raises:
            LocalProtocolError: it is silent.
        """
        self._actor.transmit(self._device.take(self.connection.disconnect(self._bench.now_ns)))

    def send(self, command: Command) -> None:
        """Send a command; the rover needs no connection for it.

        Raises:
            LocalProtocolError: the schema does not have it, or a number does not fit.
        """
        self._actor.transmit(self.connection.send(command, self._bench.now_ns))

    def request(self) -> None:
        """Ask for 0x80."""
        self.send(RequestTelemetry())

    def switch_led(self, *, lit: bool) -> None:
        """Switch the test LED."""
        self.send(LedOn() if lit else LedOff())

    # --- driving; each raises LocalProtocolError for numbers that do not fit, or commands that the schema does not have

    def drive_motors(self, left: float, right: float, *, flags: int = BOTH_MOTORS) -> None:
        """Give the motors shares of full voltage, -1..1, negative backwards."""
        if self.options.schema is Schema.V2:
            self.send(MotorThrottles(a=left, b=right, flags=flags))
        else:
            self.send(MotorSpeeds(a=_speed(left), b=_speed(right), flags=flags))

    def drive_wheels(self, left_rpm: float, right_rpm: float) -> None:
        """Have the rover keep the speeds of its wheels; in the first two schemas, voltages that might give them."""
        if self.options.schema is Schema.V2:
            self.send(SpeedSetpoints(a_rpm=left_rpm, b_rpm=right_rpm))
        else:
            self.drive_motors(left_rpm / self.chassis.full_rpm, right_rpm / self.chassis.full_rpm)

    def drive(self, speed_m_s: float, turn_rad_s: float = 0.0) -> None:
        """Drive as a unicycle: forward in m/s, counter-clockwise in rad/s."""
        self.drive_wheels(*self.chassis.wheels_rpm(speed_m_s, turn_rad_s))

    def set_gains(self, kp: float, kd: float, ki: float) -> None:
        """Set the gains of the speed controllers: throttle per rpm, per rpm/s, and per rpm s."""
        self.send(PidGains(kp=kp, kd=kd, ki=ki))

    def stop(self) -> None:
        """Take the voltage from all motors."""
        self.drive_motors(0.0, 0.0)

    # --- what it learns

    def _take(self, event: object) -> None:
        match event:
            case ReportReceived(report=report):
                self._keep(report)
            case RoverFound():
                self.failure = ""
            case RoverLost(reason=reason):
                self.failure = str(reason)

    def _keep(self, report: Report) -> None:
        telemetry = Telemetry(ns=self._bench.now_ns, report=report)
        self.history.append(telemetry)
        self.counts[type(report)] += 1
        self.latest[type(report)] = telemetry
        self.on_report(telemetry)

    def _newest(self, kind: type[ReportT]) -> ReportT | None:
        telemetry = self.latest.get(kind)  # type: ignore[arg-type]
        return telemetry.report if telemetry is not None and isinstance(telemetry.report, kind) else None


def _speed(share: float) -> int:
    if not -1 <= share <= 1:
        raise LocalProtocolError(f"{share} is not a share of -1 to 1 of full voltage")
    return round(share * MAX_SPEED)
