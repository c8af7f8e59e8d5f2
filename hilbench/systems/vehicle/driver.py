"""Who drives a car through a vehicle-interface board: the driving stack along its path, or a hand at the joystick.

The board decides who of them rules, by its mode. The demo driver is the driving stack; whoever presses a key takes over
as a person in the car does, by the joystick's switch. A hand that lets go brakes until the car stands: that is the dead
man, and it is also what the hand does while nobody drives in MANUAL.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

from hilbench.bench import Bench
from hilbench.clock import NS_PER_MS, NS_PER_S, EventClass
from hilbench.driving.control import Request, RequestError
from hilbench.driving.driver import DEAD_MAN_NS
from hilbench.systems.vehicle.driven_car import DrivenCar
from hilbench.systems.vehicle.driving_stack import DrivingStack
from hilbench.systems.vehicle.hands import VehicleHands, stick_code
from protocols.autoware import (
    AckermannControlCommand,
    AgentState,
    ControlMode,
    HazardLights,
    HazardLightsCommand,
    TurnIndicators,
    TurnIndicatorsCommand,
)
from protocols.carla import X_AXIS, Y_AXIS
from targets.robots.driving_stack import PathDriver, Pose
from worlds.scenes import Start

__all__ = ["DEMO", "MODES", "STEER", "CarCrew", "CarDriver"]

DEMO = "path-follower"
"""The demo driver: the driving stack's stand-in, along the test track."""
MODES = {"AUTOWARE": ControlMode.AUTONOMOUS, "MANUAL": ControlMode.MANUAL}
STEER = 0.3
"""Of the joystick's way to the side, at a whole stick of ours: 0.31 rad at the tyres, a circle of 9 m (choice)."""
LAMPS = ("off", "left", "right", "hazard")

_STEP_NS = 50 * NS_PER_MS
_PRESS_AGAIN_NS = 1200 * NS_PER_MS
"""Longer than the board's debounce, 1 s (protocols.carla.DEADLINES)."""
_ASK_AGAIN_NS = 3 * NS_PER_S
"""How long the demo driver leaves a board in MANUAL before it asks for AUTOWARE, so that a person sees it (choice)."""
_OPEN_AGAIN_NS = NS_PER_S
_STANDS_M_S = 0.05
_KEPT = 64


@dataclass(frozen=True, slots=True, kw_only=True)
class CarCrew:
    """Who is around the board.

    Attributes:
        car: the simulator's side, with the car.
        stack: the driving stack.
        path: who follows the path.
        hands: who stands beside the board for us; None where a person does, whose joystick and lights nobody here sees.
        start: where the car began.
    """

    car: DrivenCar
    stack: DrivingStack
    path: PathDriver
    hands: VehicleHands | None
    start: Start


class CarDriver:
    """See the module.

    Args:
        bench: whose time passes.
        crew: who is around the board.
        demo: whether the driving stack is to drive.
        on_command: called when the driving stack commands.

    Attributes:
        demo: whether AUTOWARE is asked for again where the board is in MANUAL.
    """

    def __init__(
        self, bench: Bench, crew: CarCrew, *, demo: bool, on_command: Callable[[], None] = lambda: None
    ) -> None:
        self.demo = demo
        self._bench = bench
        self._crew = crew
        self._on_command = on_command
        self._follows = demo
        self._held_until_ns: int | None = None
        self._wanted = (0.0, 0.0)
        self._stick = (0.0, 0.0)
        self._stack_on = self._simulator_on = True
        self._let_go = "nobody"
        self.who = ("", 0.0, 0.0)
        self._pressed_ns: int | None = None
        self._manual_since_ns = 0
        self._opened_ns = bench.now_ns
        crew.stack.open()
        crew.stack.drive_with(self._command)
        self._step()

    # --- as every driver

    @property
    def by_hand(self) -> bool:
        """Whether there is a joystick that we can move."""
        return self._crew.hands is not None

    @property
    def commands(self) -> Mapping[str, Callable[[Request], None]]:
        """What can be asked of the crew beside driving, by the names of actions."""
        return {
            "mode": self._request,
            **({"press": lambda _: self._press()} if self.by_hand else {}),
            "stack": lambda request: self._set_stack(on=_is_on(request)),
            "simulator": lambda request: self._set_simulator(on=_is_on(request)),
            "lamps": self._set_lamps,
            "restart": lambda _: self._restart(),
        }

    def take(self, forward: float, turn: float, *, pad: bool = False) -> None:
        """Drive by hand, see `Drives`: a game pad moves the joystick no farther than keys do."""
        del pad
        self.demo = False
        self._let_go = "dead man"
        self._wanted = (forward, turn)
        self._held_until_ns = self._bench.now_ns + DEAD_MAN_NS
        self._hold()

    def stop(self) -> None:
        """Stop with all the car has, whoever rules: the driving stack commands speed 0, the stick is pulled back."""
        self.demo = self._follows = False
        self._held_until_ns = None
        self._let_go = "nobody"
        self._hold()

    def begin_demo(self) -> None:
        """Let the driving stack drive, and ask for AUTOWARE."""
        self.demo = self._follows = True
        self._held_until_ns = None
        self._let_go = "nobody"
        self._ask("AUTOWARE")
        self._hold()

    def look(self) -> Mapping[str, object]:
        """Return what a person would see in the car and at the board."""
        car, path, now_ns = self._crew.car, self._crew.path, self._bench.now_ns
        dynamics, mode = car.body.dynamics, self._crew.stack.mode
        command = car.simulator.host.wish
        pose = dynamics.pose
        place = path.path.place(pose.x_m, pose.y_m)
        hands = self._crew.hands
        return {
            "reported": "" if mode is None else ControlMode(mode).name if mode in set(ControlMode) else str(mode),
            "stack_on": self._stack_on,
            "simulator_on": self._simulator_on,
            "stick": None if hands is None else [round(share, 3) for share in self._stick],
            "pressed": self._pressed_ns is not None and now_ns - self._pressed_ns < NS_PER_S // 2,
            "lights": None if hands is None else sorted(hands.lights()),
            "lamps": None if hands is None else list(hands.lamps()),
            "speed_m_s": round(dynamics.lon_speed_m_s, 3),
            "tyre_rad": round(dynamics.steering_rad, 4),
            "offset_m": round(place.offset_m, 3),
            "command": "" if command is None else type(command).__name__,
        }

    # --- what happens by itself

    def _step(self) -> None:
        now_ns, stack = self._bench.now_ns, self._crew.stack
        if self._stack_on and stack.state is AgentState.CLOSED and now_ns - self._opened_ns >= _OPEN_AGAIN_NS:
            self._open_stack()
        if stack.mode != ControlMode.MANUAL:
            self._manual_since_ns = now_ns
        elif self.demo and now_ns - self._manual_since_ns >= _ASK_AGAIN_NS:
            self._manual_since_ns = now_ns
            self._ask("AUTOWARE")
        self._hold()
        del self._crew.car.simulator.published[:-_KEPT]
        self._bench.scheduler.after(_STEP_NS, self._step, order=EventClass.CONTROL, source="~driver")

    def _hold(self) -> None:
        """Hold the stick where it is to be now, and say who drives."""
        now_ns = self._bench.now_ns
        autoware = self._crew.stack.mode == ControlMode.AUTONOMOUS
        if self._held_until_ns is not None and now_ns >= self._held_until_ns:
            self._held_until_ns = None
        if self._held_until_ns is not None:
            forward, turn = self._wanted
            if autoware and (self._pressed_ns is None or now_ns - self._pressed_ns >= _PRESS_AGAIN_NS):
                self._press()
            self._move_stick(-turn * STEER, forward)
            self._say("user", forward, turn)
            return
        stands = abs(self._crew.car.body.dynamics.lon_speed_m_s) < _STANDS_M_S
        self._move_stick(0.0, 0.0 if autoware or stands else -1.0)
        self._say(DEMO if autoware and self._follows else self._let_go)

    def _command(self) -> AckermannControlCommand | None:
        pose = self._crew.car.body.dynamics.pose
        where = Pose(x_m=pose.x_m, y_m=pose.y_m, yaw_rad=pose.yaw_rad)
        stack, path = self._crew.stack, self._crew.path
        if stack.mode != ControlMode.AUTONOMOUS:
            path.place = None  # somebody else drives, and may be anywhere by now
        velocity = stack.velocity
        command = path.command(where, velocity.longitudinal_velocity if velocity else 0.0, stack.stamp)
        self._on_command()
        if self._follows:
            return command
        return replace(command, speed=0.0, acceleration=0.0, jerk=0.0)  # 0: as fast as the car can

    def _move_stick(self, right: float, forward: float) -> None:
        if self._crew.hands is not None and (right, forward) != self._stick:
            self._stick = (right, forward)
            self._crew.hands.set_joystick(stick_code(X_AXIS, -right), stick_code(Y_AXIS, forward))

    def _say(self, who: str, forward: float = 0.0, turn: float = 0.0) -> None:
        if (who, forward, turn) != self.who:
            self.who = (who, forward, turn)
            self._bench.record("driver", "drive", who=who, forward=forward, turn=turn)

    # --- what is asked for

    def _request(self, request: Request) -> None:
        name = str(request.get("mode"))
        if name not in MODES:
            raise RequestError(f"mode is {' or '.join(MODES)}")
        if not self._stack_on:
            raise RequestError("the driving stack is paused, so it sends no requests")
        self._held_until_ns = None
        self._let_go = "nobody"
        self._follows = name == "AUTOWARE"
        self.demo = self._follows and self.by_hand  # a person at the board is not asked twice
        self._ask(name)

    def _ask(self, name: str) -> None:
        def answered(success: bool | None) -> None:
            said = "no answer" if success is None else "granted" if success else "refused"
            self._bench.record("answer", "stack", mode=name, said=said)

        if self._stack_on:
            self._crew.stack.request_mode(MODES[name], answered)

    def _press(self) -> None:
        self.demo = False
        self._pressed_ns = self._bench.now_ns
        if self._crew.hands is not None:
            self._crew.hands.press()

    def _set_stack(self, *, on: bool) -> None:
        if on == self._stack_on:
            return
        self._stack_on = on
        if on:
            self._open_stack()
        elif self._crew.stack.state is not AgentState.CLOSED:
            self._crew.stack.close()

    def _open_stack(self) -> None:
        self._opened_ns = self._bench.now_ns
        self._crew.stack.open()
        self._crew.stack.drive_with(self._command)

    def _set_simulator(self, *, on: bool) -> None:
        statuses = self._crew.car.statuses
        if on and not self._simulator_on:
            statuses.start(self._crew.car.status_hz)
        elif not on:
            statuses.stop()
        self._simulator_on = on

    def _set_lamps(self, request: Request) -> None:
        which = str(request.get("which"))
        if which not in LAMPS:
            raise RequestError(f"which is one of {', '.join(LAMPS)}")
        if not self._stack_on:
            raise RequestError("the driving stack is paused, so it sends no requests")
        turn = {"left": TurnIndicators.ENABLE_LEFT, "right": TurnIndicators.ENABLE_RIGHT}.get(which)
        hazard = HazardLights.ENABLE if which == "hazard" else HazardLights.DISABLE
        stack = self._crew.stack
        stack.publish(TurnIndicatorsCommand(stamp=stack.stamp, command=turn or TurnIndicators.DISABLE))
        stack.publish(HazardLightsCommand(stamp=stack.stamp, command=hazard))

    def _restart(self) -> None:
        """Put the car back to where it began, at rest: it has no reverse gear to get away from a wall."""
        start = self._crew.start
        self._crew.car.place(start.x_m, start.y_m, start.yaw_rad)
        self._crew.path.place = None


def _is_on(request: Request) -> bool:
    on = request.get("on")
    if not isinstance(on, bool):
        raise RequestError("on is true or false")
    return on
