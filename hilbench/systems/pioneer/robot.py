"""The virtual Pioneer: its controller, its body in a world, and the loop that closes through both.

At tick k the world is moved from tick k-1 to tick k with the wheel commands given at tick k-1; then the controller
senses the world as it is at tick k and commands the wheels for the next slice (`hilbench.bench.world_runner`). So the
controller acts on what is true now, and its command takes effect from now on: a latency of at most one step.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

from hilbench.bench import Bench
from hilbench.bench.devices import DeviceActor
from hilbench.bench.state_reporter import Observed
from hilbench.bench.world_runner import WorldRunner
from hilbench.benchfile.reader import BenchFile
from hilbench.errors import UsageError
from hilbench.links import Port
from hilbench.systems.pioneer.system import VEHICLE
from protocols.p2os import robot_parameters
from targets.robots.pioneer import CommandIgnored, CommandObeyed, NotModelled, PioneerRobot, RobotSettings
from worlds import default_physics
from worlds.scenes import Scene
from worlds.vehicles.pioneer_2dx import Pioneer2dxBody
from worlds.world import World, open_world

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
        physics: `worlds.world.open_world`; the default one if None.
        step_hz: physics steps per second.
        settings: what is in the controller's FLASH.
        make_robot: makes the controller.
    """

    scene: str | Scene = "empty"
    physics: str = field(default_factory=default_physics)
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
        self._make_robot, self._seed = plan.make_robot, seed
        self.world: World = open_world(plan.scene, VEHICLE, physics=plan.physics, step_hz=plan.step_hz, seed=seed)
        self.body = Pioneer2dxBody(self.world, sonar_poses=sonar_poses(plan.settings.subclass))
        self.commands: set[tuple[int, str]] = set()
        self.power_on(plan.settings)
        self.runner = WorldRunner(bench, self.world)
        self.runner.after.append(self._control)
        self._follow_baud()

    def power_on(self, settings: RobotSettings) -> None:
        """Switch the controller on with this in its FLASH; one that was on has no session, and is gone."""
        self.robot = self._make_robot(settings, self.body, self._seed)
        self.robot.line = self._port
        self.actor = DeviceActor(
            self._bench, self.robot, self._port, name="robot", on_event=self._note_command, after=self._follow_baud
        )

    @property
    def machines(self) -> Mapping[str, Observed]:
        """Its state machine, by its source in the journal."""
        return {"robot": self.robot.connection}

    def close(self) -> None:
        """Give the world back."""
        self.world.close()

    def _control(self, now_ns: int, _next_ns: int) -> None:
        self.robot.control_step(now_ns, self.runner.dt_s)
        self.actor.settle()

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
    """Return the plan for the one robot of a bench file.

    Raises:
        UsageError: there is none.
    """
    settings = bench_file.settings_of(RobotSettings)
    if settings is None:
        raise UsageError("names no Pioneer among its targets", where=str(bench_file.path or bench_file.name))
    for link in bench_file.links:
        if any(end.endswith(".host") for end in link.ends):
            settings = replace(settings, host_baud=link.baud)
    world = bench_file.world
    return PioneerPlan(scene=world.scene, physics=world.physics, step_hz=world.step_hz, settings=settings)
