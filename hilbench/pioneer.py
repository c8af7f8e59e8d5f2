"""The virtual Pioneer: its controller, its body in a world, and the loop that closes through both.

Every physics step has the same order. At tick k the world is moved from tick k-1 to tick k with the wheel commands
given at tick k-1; then the controller senses the world as it is at tick k and commands the wheels for the next slice.
So the controller acts on what is true now, and its command takes effect from now on: a latency of at most one step.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from hilbench.bench import Bench
from hilbench.clock import ClockDomain, EventClass
from hilbench.config import BenchFile
from hilbench.devices import DeviceActor
from hilbench.journal import metres, radians
from hilbench.links import Port
from protocols.p2os import robot_parameters
from targets.robots.pioneer import CommandIgnored, CommandObeyed, NotModelled, PioneerRobot, RobotSettings
from worlds.scenes import Scene
from worlds.vehicles.pioneer_2dx import Pioneer2dxBody
from worlds.world import World, open_world

VEHICLE = "pioneer-2dx"
TRUTH_HZ = 10
"""How often the true pose goes into the journal; as often as the robot reports its own idea of it."""

OBEYED = "obeyed"
UNKNOWN = "not modelled"

RobotFactory = Callable[[RobotSettings, Pioneer2dxBody, int], PioneerRobot]


def make_robot(settings: RobotSettings, body: Pioneer2dxBody, seed: int) -> PioneerRobot:
    """Make the controller as it is meant to be; what takes its place in a test may be a faulty one."""
    return PioneerRobot(settings, body, seed=seed)


@dataclass(frozen=True, slots=True, kw_only=True)
class PioneerPlan:
    """What a virtual Pioneer is built from.

    Attributes:
        scene: name of a built-in scene, or a loaded one.
        physics: ``bullet`` or ``plane``.
        step_hz: physics steps per second.
        settings: what is in the controller's FLASH.
        make_robot: makes the controller.
    """

    scene: str | Scene = "empty"
    physics: str = "bullet"
    step_hz: int = 240
    settings: RobotSettings
    make_robot: RobotFactory = make_robot


class VirtualPioneer:
    """A Pioneer in its world, on a bench.

    Args:
        bench: whose time it lives in.
        port: its end of the host line.
        plan: what to build.
        seed: of everything random in it.

    Attributes:
        commands: the commands that came, each with what became of it: `OBEYED`, `UNKNOWN`, or why it had no effect.
    """

    def __init__(self, bench: Bench, port: Port, plan: PioneerPlan, *, seed: int) -> None:
        self._bench = bench
        self._port = port
        self.world: World = open_world(plan.scene, VEHICLE, physics=plan.physics, step_hz=plan.step_hz, seed=seed)
        self.body = Pioneer2dxBody(self.world, sonar_poses=sonar_poses(plan.settings.subclass))
        self.robot = plan.make_robot(plan.settings, self.body, seed)
        self.robot.line = port
        self.commands: set[tuple[int, str]] = set()
        self.actor = DeviceActor(
            bench, self.robot, port, name="robot", on_event=self._note_command, after=self._follow_baud
        )
        self._domain = ClockDomain(plan.step_hz)
        self._dt_s = 1 / plan.step_hz
        self._epoch_ns = bench.now_ns
        self._tick = 0
        self._truth_every = max(1, plan.step_hz // TRUTH_HZ)
        self._follow_baud()
        self._book_step()

    def close(self) -> None:
        """Give the world back."""
        self.world.close()

    def _book_step(self) -> None:
        self._tick += 1
        when_ns = self._epoch_ns + self._domain.ns(self._tick)
        self._bench.scheduler.at(when_ns, self._step, order=EventClass.PHYSICS, source="world")

    def _step(self) -> None:
        self.world.step()
        self.robot.control_step(self._bench.now_ns, self._dt_s)
        self.actor.settle()
        if self._tick % self._truth_every == 0:
            self._record_truth()
        self._book_step()
        self._bench.journal.flush_step()

    def _record_truth(self) -> None:
        pose = self.world.pose()
        x_m, y_m, z_m = pose.position_m
        self._bench.record(
            "pose", "world", x_m=metres(x_m), y_m=metres(y_m), z_m=metres(z_m), yaw_rad=radians(pose.yaw_rad)
        )

    def _note_command(self, event: object) -> None:
        match event:
            case CommandObeyed(command=command):
                self.commands.add((command.number, OBEYED))
            case CommandIgnored(command=command, reason=reason):
                self.commands.add((command.number, reason.value))
            case NotModelled(command=number):
                self.commands.add((number, UNKNOWN))

    def _follow_baud(self) -> None:
        if self._port.baud and self._port.baud != self.robot.host_baud:
            self._port.baud = self.robot.host_baud
            self._bench.record("baud", "robot", baud=self.robot.host_baud)


def sonar_poses(subclass: str) -> list[tuple[float, float, float]]:
    """Return where a robot's sonar discs sit: x and y in metres, direction in radians, by disc number."""
    poses = robot_parameters(subclass).sonars
    return [(pose.x_mm / 1000, pose.y_mm / 1000, pose.th_rad) for pose in poses if pose is not None]


def plan_of(bench_file: BenchFile) -> PioneerPlan:
    """Return the plan for the one robot of a bench file."""
    settings = bench_file.robot().settings
    for link in bench_file.links:
        if any(end.endswith(".host") for end in link.ends):
            settings = replace(settings, host_baud=link.baud)
    world = bench_file.world
    return PioneerPlan(scene=world.scene, physics=world.physics, step_hz=world.step_hz, settings=settings)
