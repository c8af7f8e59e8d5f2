"""A car that is driven through a vehicle-interface board: what cases of `vehicle_drive` do, and the truth they see.

The driving stack's stand-in follows the middle line of the track: it knows where the car is from the world, as the
original's stack knows it from its localisation, and how fast from the board's reports alone.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable
from dataclasses import dataclass

from hilbench.bench import Bench
from hilbench.bench.world_runner import WorldRunner
from hilbench.check import Violation
from hilbench.clock import NS_PER_S
from hilbench.errors import InternalError
from hilbench.links import Port
from hilbench.mcu.board_case import BoardCase
from hilbench.suites._vehicle import vehicle_bench
from hilbench.systems.vehicle.car_simulator import Published
from hilbench.systems.vehicle.driven_car import DrivenCar
from hilbench.systems.vehicle.driving_stack import COMMAND_HZ
from hilbench.systems.vehicle.hands import VehicleHands, stick_code
from hilbench.systems.vehicle.micro_ros_peer import driving_stack
from hilbench.systems.vehicle.micro_ros_settings import MicroRosSettings
from protocols.autoware import AckermannControlCommand, ControlMode, SteeringReport, VelocityReport
from protocols.carla import X_AXIS, Y_AXIS, AckermannCommand, ManualCommand, Mode
from targets.robots.driving_stack import DriverSettings, Path, PathDriver, Pose
from worlds.vehicles.car import CarBody

__all__ = ["Drive", "DriveBench", "Moment", "drive_bench"]

ASTRAY_M = 5.0
"""Off the middle line; more than a lane's width. A choice."""

STARTED_WITHIN_S = 3.0
"""How long a board may take from power-on until it drives; our choice. It finds the agent within a ping."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DriveBench:
    """What a drive needs.

    Attributes:
        bench: time and journal.
        simulator: the far end of the simulator's line.
        stack: the same of the driving stack's.
        body: the car.
        runner: who moves its world.
        hands: who stands beside the board.
        micro_ros: the agent at the driving stack's line; None for the stand-in link.
    """

    bench: Bench
    simulator: Port
    stack: Port
    body: CarBody
    runner: WorldRunner
    hands: VehicleHands
    micro_ros: MicroRosSettings | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Moment:
    """The car after a step of the physics.

    Attributes:
        at_s: bench time.
        x_m: position in the scene, of the rear axle.
        y_m: as above.
        yaw_rad: + left.
        speed_m_s: forwards.
        lateral_speed_m_s: + left.
        accel_m_s2: how the speed changes.
        turn_rad_s: + left.
        steering_rad: of the tyres, + left.
        offset_m: how far from the middle of the lane, + left.
        touches: an obstacle.
    """

    at_s: float
    x_m: float
    y_m: float
    yaw_rad: float
    speed_m_s: float
    lateral_speed_m_s: float
    accel_m_s2: float
    turn_rad_s: float
    steering_rad: float
    offset_m: float
    touches: bool

    @property
    def lateral_m_s2(self) -> float:
        """Speed times turn rate."""
        return self.speed_m_s * self.turn_rad_s


class Drive:
    """See the module. It begins when it is made, power just on, and ends with the bench.

    Args:
        there: what it needs.
        habits: of the driver.

    Attributes:
        bench: time and journal.
        car: the simulator's side.
        stack: the driving stack.
        driver: the stack's stand-in.
        hands: who stands beside the board.
        moments: the truth, after each step.
        reports: what the board said of the car's motion, each with its bench time in s.
        asked: what the driving stack asked for, as above.
        half_lane_m: how far the middle of the car may be off the middle line.
    """

    def __init__(self, there: DriveBench, habits: DriverSettings | None = None) -> None:
        self.bench = there.bench
        self.hands = there.hands
        self._body = there.body
        lane = there.runner.world.scene.lane
        assert lane is not None
        self.path = Path(lane.center_m, closed=lane.closed)
        self.half_lane_m = (lane.width_m - there.body.parameters.width_m) / 2
        self.driver = PathDriver(self.path, habits)
        self.car = DrivenCar(there.bench, there.simulator, there.body, there.runner)
        self.stack = driving_stack(there.bench, there.stack, there.micro_ros)
        self.moments: list[Moment] = []
        self.reports: list[tuple[float, VelocityReport | SteeringReport]] = []
        self.asked: list[tuple[float, AckermannControlCommand]] = []
        self.stack.subscribe(VelocityReport, self._hear)
        self.stack.subscribe(SteeringReport, self._hear)
        self._near_m: float | None = None
        self._look(there.bench.now_ns, there.bench.now_ns)
        there.runner.after.append(self._look)
        self.stack.open()

    # --- what is done

    def follow(self, rate_hz: float = COMMAND_HZ) -> None:
        """The stack drives along the track from now on, with so many commands a second."""
        self.stack.drive_with(self._command, rate_hz)

    def start(self) -> None:
        """Have the stack drive, and wait until the car does.

        Raises:
            Violation: it does not.
        """
        self.follow()
        if not self.until(lambda: self.now.speed_m_s > 0.5, STARTED_WITHIN_S):
            raise Violation(
                f"the car stands {STARTED_WITHIN_S:g} s after power-on, though it is commanded", self.said()
            )

    def reach(self, speed_m_s: float, within_s: float = 15.0) -> None:
        """Drive until the car is as fast as that.

        Raises:
            Violation: it does not become so.
        """
        if not self.until(lambda: self.now.speed_m_s >= speed_m_s, within_s):
            raise Violation(f"{self.now.speed_m_s:.2f} m/s after {within_s:g} s, not {speed_m_s:g}", self.said())

    def ask(self, mode: ControlMode) -> bool | None:
        """Ask the board for a mode; return what it answers."""
        answers: list[bool | None] = []
        self.stack.request_mode(mode, answers.append)
        self.until(lambda: bool(answers), 1.5)
        return answers[0] if answers else None

    def stick(self, right: float = 0.0, forward: float = 0.0) -> None:
        """Move the joystick, by shares of the way beyond the dead band, -1 to 1.

        Below its middle X steers to the right: the board says minus x, and CARLA's steer is positive to the right.
        """
        self.hands.set_joystick(stick_code(X_AXIS, -right), stick_code(Y_AXIS, forward))

    def wait(self, duration_s: float) -> Moment:
        """Let time pass; return the car then."""
        self.go(duration_s)
        return self.now

    def emergency(self, within_s: float) -> float:
        """Wait for the emergency's first frame; return the bench time of its last byte, in s.

        Raises:
            Violation: none comes.
        """
        since_s = self.now_s

        def found() -> list[float]:
            return [one.ns / NS_PER_S for one in self.published(since_s) if one.mode == Mode.EMERGENCY]

        if not self.until(lambda: bool(found()), within_s):
            raise Violation(f"no emergency within {within_s:g} s", self.said())
        return found()[0]

    def go(self, duration_s: float) -> None:
        """Let time pass."""
        self.bench.run_for(duration_s)

    def until(self, condition: Callable[[], bool], within_s: float) -> bool:
        """Let time pass until something is so; say whether it is."""
        return self.bench.run_until(condition, within_s)

    # --- what is seen

    @property
    def now(self) -> Moment:
        """The car, now."""
        return self.moments[-1]

    @property
    def is_astray(self) -> bool:
        """The car is so far off its lane, or leans on something, that nothing will come of it."""
        return self.now.touches or abs(self.now.offset_m) > ASTRAY_M

    @property
    def now_s(self) -> float:
        """Bench time."""
        return self.bench.now_ns / NS_PER_S

    def since(self, at_s: float) -> list[Moment]:
        """The truth since a bench time."""
        return self.moments[bisect_left(self.moments, at_s, key=lambda moment: moment.at_s) :]

    def between(self, begin_s: float, end_s: float) -> list[Moment]:
        """The truth between two bench times, and the moment before."""
        first = bisect_left(self.moments, begin_s, key=lambda moment: moment.at_s)
        last = bisect_left(self.moments, end_s, key=lambda moment: moment.at_s)
        return self.moments[max(0, first - 1) : last + 1]

    def published(self, since_s: float = 0.0) -> list[Published]:
        """What the board has commanded the car since a bench time, with the modes of its frames."""
        return [one for one in self.car.simulator.published if one.ns / NS_PER_S >= since_s]

    def commanded(self, since_s: float = 0.0) -> list[tuple[float, AckermannCommand | ManualCommand]]:
        """The same without the modes, each with its bench time in s."""
        return [(one.ns / NS_PER_S, one.command) for one in self.published(since_s)]

    def said(self) -> list[str]:
        """The latest commands to the car, for a report."""
        return [f"{one.ns / NS_PER_S:9.3f} s  mode {one.mode}  {one.command}" for one in self.published()[-5:]]

    def _command(self) -> AckermannControlCommand | None:
        velocity = self.stack.velocity
        pose = self._body.dynamics.pose
        where = Pose(x_m=pose.x_m, y_m=pose.y_m, yaw_rad=pose.yaw_rad)
        command = self.driver.command(where, velocity.longitudinal_velocity if velocity else 0.0, self.stack.stamp)
        self.asked.append((self.now_s, command))
        return command

    def _hear(self, report: VelocityReport | SteeringReport) -> None:
        self.reports.append((self.now_s, report))

    def _look(self, now_ns: int, _next_ns: int) -> None:
        dynamics = self._body.dynamics
        pose = dynamics.pose
        near_m = self.driver.place.s_m if self.driver.place else self._near_m
        place = self.path.place(pose.x_m, pose.y_m, near_m=near_m, within_m=20.0)
        self._near_m = place.s_m
        self.moments.append(
            Moment(
                at_s=now_ns / NS_PER_S,
                x_m=pose.x_m,
                y_m=pose.y_m,
                yaw_rad=pose.yaw_rad,
                speed_m_s=dynamics.lon_speed_m_s,
                lateral_speed_m_s=dynamics.lat_speed_m_s,
                accel_m_s2=dynamics.lon_accel_m_s2,
                turn_rad_s=dynamics.yaw_rate_rad_s,
                steering_rad=dynamics.steering_rad,
                offset_m=place.offset_m,
                touches=self._body.touches(),
            )
        )


def drive_bench(bench: BoardCase) -> DriveBench:
    """What a drive needs, of the bench of a case: an emulated board, a joystick, and a car in its world."""
    vehicle = vehicle_bench(bench)
    body = bench.emulated.surroundings.body
    if not isinstance(body, CarBody) or vehicle.hands is None:
        raise InternalError("the case needs a car and somebody beside its board, and has not said so")
    return DriveBench(
        bench=bench.bench,
        simulator=vehicle.simulator.port,
        stack=vehicle.stack.port,
        body=body,
        runner=bench.runner,
        hands=vehicle.hands,
        micro_ros=bench.emulated.bench_file.settings_of(MicroRosSettings),
    )
