"""A rover that drives through a world: what cases of `rover_motion` do to it, and what they write down of the truth.

Times of the vehicle are those of its world, which is a step ahead of the bench (`hilbench.bench.world_runner`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import TypeVar

from hilbench.check import CaseSetup, Violation, case
from hilbench.clock import NS_PER_S
from hilbench.judging.recorder import unrecorded
from hilbench.mcu.board_case import BoardCase
from hilbench.suites._board_watch import PinEdge
from hilbench.suites._rover import Rover, rover_bench
from protocols.pkt import (
    Dialect,
    GeneralReport,
    GpsReport,
    ImuReport,
    MotionReport,
    MotorThrottles,
    Position,
    RequestTelemetry,
    SpeedSetpoints,
)
from targets.mcu.i2c_bus import I2cBus
from targets.parts.neo6m.settings import Neo6mSettings
from worlds.vehicles.rover_4wd import DEFAULTS, WHEELS

__all__ = [
    "LEFT",
    "NAMES",
    "RIGHT",
    "SLOTS",
    "Four",
    "Moment",
    "Ride",
    "ideal_turn_deg_s",
    "metres_off",
    "numbers_in",
    "on_bench",
]

ReportT = TypeVar("ReportT", ImuReport, MotionReport, GpsReport)
FunctionT = TypeVar("FunctionT", bound=Callable[..., object])
Four = tuple[float, float, float, float]

NAMES = ("left front", "right front", "left back", "right back")
"""The wheels, in the order of their tachometers."""

LEFT, RIGHT = (0, 2), (1, 3)
"""Places of the wheels of a side."""

SLOTS = 20
"""Of a tachometer's disc (the manual's chapter on the tachometers)."""

ENABLES = ("PB11", "PE10")
"""The pins that give the left and the right motors their pulses (the manual's table of pins)."""

FEED_S = 0.4
"""How often a case that lets time pass says something; the rover stops its motors after 1 s of silence."""

_PROFILE = "documented"
_PARTS = ("cells", "driver", "motor_lf", "motor_rf", "motor_lb", "motor_rb", "imu", "gps")


def on_bench(
    *clause_ids: str, lasts_s: float, scene: str = "stand", settings: Mapping[str, Mapping[str, object]] | None = None
) -> Callable[[FunctionT], FunctionT]:
    """Declare a case, in a scene, with settings of parts; the rover runs the documented program."""
    setup = CaseSetup(program=_PROFILE, settings=settings or {})
    needs = {f"part '{part}'" for part in _PARTS}
    return case(*clause_ids, bench_time_s=lasts_s, needs=needs, scene=scene, setup=setup)


@dataclass(frozen=True, slots=True, kw_only=True)
class Moment:
    """The rover in the world after a step of the physics.

    Attributes:
        at_ns: bench time.
        x_m: position in the scene.
        y_m: as above.
        yaw_deg: + to the left, of the scene's x, not wrapped.
        turn_deg_s: rate of turn about the scene's vertical, + to the left.
        wheels_rad: how far the wheels have turned, + forward, not wrapped.
    """

    at_ns: int
    x_m: float
    y_m: float
    yaw_deg: float
    turn_deg_s: float
    wheels_rad: Four

    def rpm_since(self, start: Moment) -> Four:
        """Mean speeds of the wheels since another moment, + forward."""
        span_s = (self.at_ns - start.at_ns) / NS_PER_S
        lf, rf, lb, rb = (
            (now - then) / span_s * 60 / math.tau for now, then in zip(self.wheels_rad, start.wheels_rad, strict=True)
        )
        return lf, rf, lb, rb

    def seen_from(self, start: Moment) -> tuple[float, float]:
        """How far ahead and how far to the left of another moment this is, in m."""
        dx, dy, yaw_rad = self.x_m - start.x_m, self.y_m - start.y_m, math.radians(start.yaw_deg)
        cos, sin = math.cos(yaw_rad), math.sin(yaw_rad)
        return cos * dx + sin * dy, cos * dy - sin * dx


class Ride:
    """See the module. It begins when it is made, power just on, and ends with the bench.

    Args:
        bench: of the case.

    Attributes:
        rover: the rover as its host sees it.
        moments: the truth, after each step.
        edges: of the pins that give the motors their pulses.
    """

    def __init__(self, bench: BoardCase) -> None:
        self._bench = bench
        self.rover = Rover(rover_bench(bench))
        self.moments: list[Moment] = []
        self.edges: list[PinEdge] = []
        for pin in ENABLES:
            bench.board.pin(pin).on_edge(partial(self._edge, pin))
        bench.runner.after.append(self._step)

    # --- what is done

    def go(self, duration_s: float) -> None:
        """Let time pass, and keep the link up."""
        self.rover.keep_alive(duration_s, FEED_S)

    def drive(self, left: float, right: float, for_s: float = 0.0, *, flags: int = 3) -> None:
        """Command throttles, and let time pass."""
        self.rover.peer.send(MotorThrottles(a=left, b=right, flags=flags))
        self.go(for_s)

    def keep(self, left_rpm: float, right_rpm: float, for_s: float = 0.0) -> None:
        """Command wheel speeds, and let time pass."""
        self.rover.peer.send(SpeedSetpoints(a_rpm=left_rpm, b_rpm=right_rpm))
        self.go(for_s)

    def hold(self, wheel: str, held: bool = True) -> None:
        """Hold a wheel in the hand, or let it go: ``lf``, ``rf``, ``lb``, ``rb``."""
        self._bench.emulated.surroundings.parts.set(f"motor_{wheel}", {"hold": float(held)})

    def open_sky(self, share: float) -> None:
        """Let the GPS receiver see so much of the sky."""
        self._bench.emulated.surroundings.parts.set("gps", {"sky": share})

    def place(self, x_m: float, y_m: float, yaw_rad: float = 0.0, z_m: float = 0.0) -> None:
        """Put the rover somewhere else."""
        self._bench.world.place(x_m, y_m, yaw_rad, z_m)

    @property
    def origin(self) -> Position:
        """Where on the earth the scene's origin is."""
        settings = self._gps_settings
        return Position(latitude_deg=settings.latitude_deg, longitude_deg=settings.longitude_deg)

    def east_north_m(self, moment: Moment) -> tuple[float, float]:
        """How far east and north of the scene's origin the rover was."""
        bearing = math.radians(self._gps_settings.x_axis_bearing_deg)
        east_m = moment.x_m * math.sin(bearing) - moment.y_m * math.cos(bearing)
        return east_m, moment.x_m * math.cos(bearing) + moment.y_m * math.sin(bearing)

    @property
    def bus(self) -> I2cBus:
        """The bus of the inertial sensor, to be broken."""
        machine = next(iter(self._bench.emulated.machines.values()))
        return machine.chip.i2cs["I2C1"].bus

    def heard_ns(self) -> int:
        """Let time pass until what was sent last is at the rover's end of the line; return when that is."""
        peer = self.rover.peer
        peer.run(peer.line_s(len(peer.frame_of(RequestTelemetry()))))
        return peer.bench.now_ns

    # --- what is true

    @property
    def now(self) -> Moment:
        """The newest moment; after the first step of the physics."""
        return self.moments[-1]

    def before(self, span_s: float) -> Moment:
        """The moment that is so long before the newest one."""
        return self.at(self.now.at_ns - round(span_s * NS_PER_S))

    def at(self, at_ns: int) -> Moment:
        """The last moment that is not after a time; the first one for what is before it."""
        return next((one for one in reversed(self.moments) if one.at_ns <= at_ns), self.moments[0])

    def rpm(self, over_s: float = 0.2) -> Four:
        """Mean speeds of the wheels over the last ten periods of the pulses."""
        return self.now.rpm_since(self.before(over_s))

    def slots_at(self, at_ns: int) -> Four:
        """How far the wheels have turned at a time, in slots of their discs, taken to turn evenly within a step."""
        after = next((one for one in self.moments if one.at_ns >= at_ns), self.now)
        before = self.at(at_ns)
        share = (at_ns - before.at_ns) / (after.at_ns - before.at_ns) if after is not before else 0.0
        lf, rf, lb, rb = (
            (one + (other - one) * share) * SLOTS / math.tau
            for one, other in zip(before.wheels_rad, after.wheels_rad, strict=True)
        )
        return lf, rf, lb, rb

    def pulses(self, pin: str, since_ns: int) -> list[int]:
        """When pulses began on a motor's pin, since a time."""
        return [edge.at_ns for edge in self.edges if edge.pin == pin and edge.level and edge.at_ns >= since_ns]

    # --- what it says

    @property
    def dialect(self) -> Dialect:
        """What the numbers of its reports mean."""
        return self.rover.peer.profile.dialect

    def motion(self) -> tuple[int, MotionReport]:
        """Wait for a 0x83 that begins later than now; return it with the time of its first byte."""
        mark = self.rover.mark()
        report = numbers_in(self.rover.motion())
        return next(got.start_ns for got, found in self.rover.peer.since(mark, MotionReport) if found is report), report

    def status(self) -> int:
        """Ask for STATUS."""
        with unrecorded():
            report: GeneralReport = self.rover.peer.request()
        if report.status is None:
            raise Violation("0x80 ends before STATUS", self.rover.peer.evidence())
        return report.status

    @property
    def _gps_settings(self) -> Neo6mSettings:
        settings = self._bench.emulated.bench_file.parts["gps"].settings
        assert isinstance(settings, Neo6mSettings)
        return settings

    # --- writing down

    def _step(self, _now_ns: int, next_ns: int) -> None:
        world = self._bench.world
        pose, velocity = world.pose(), world.velocity()
        near_deg = self.moments[-1].yaw_deg if self.moments else 0.0
        yaw_deg = math.degrees(pose.yaw_rad)
        lf, rf, lb, rb = (world.joint(wheel).angle_rad for wheel in WHEELS)
        self.moments.append(
            Moment(
                at_ns=next_ns,
                x_m=pose.position_m[0],
                y_m=pose.position_m[1],
                yaw_deg=near_deg + math.remainder(yaw_deg - near_deg, 360),
                turn_deg_s=math.degrees(velocity.angular_rad_s[2]),
                wheels_rad=(lf, rf, lb, rb),
            )
        )

    def _edge(self, pin: str, _cycle: int, ns: int, level: bool | None) -> None:
        self.edges.append(PinEdge(ns, pin, level))


def numbers_in(report: ReportT) -> ReportT:
    """Return a report, all of whose fields are numbers.

    Raises:
        Violation: one is not.
    """
    for name in report.__slots__:
        field = getattr(report, name)
        if not all(map(math.isfinite, field if isinstance(field, tuple) else (field,))):
            raise Violation(f"{name} of a {type(report).__name__} is no number: {field}")
    return report


def ideal_turn_deg_s(wheels_rpm: Iterable[float]) -> float:
    """Return how fast two wheels on one axle would turn that never slip, + to the left."""
    lf, rf, lb, rb = wheels_rpm
    rim_m_s = ((rf + rb) - (lf + lb)) / 2 * math.tau / 60 * DEFAULTS.wheel_radius_m
    return math.degrees(rim_m_s / DEFAULTS.track_m)


def metres_off(origin: Position, place: Position) -> tuple[float, float]:
    """Return how far east and north of an origin a place near it is, in m, on the WGS 84 ellipsoid."""
    latitude = math.radians(origin.latitude_deg)
    flattening, equator_m = 1 / 298.257223563, 6_378_137.0
    eccentricity = flattening * (2 - flattening)
    bulge = 1 - eccentricity * math.sin(latitude) ** 2
    north_m = math.radians(place.latitude_deg - origin.latitude_deg) * equator_m * (1 - eccentricity) / bulge**1.5
    east_m = math.radians(place.longitude_deg - origin.longitude_deg) * equator_m / math.sqrt(bulge)
    return east_m * math.cos(latitude), north_m
