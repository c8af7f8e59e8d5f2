"""An ideal body and a little bench to put the robot on: bench time, physics steps, and every packet with its time."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import pytest

from protocols.p2os import MAX_COUNT, Command, Frame, FrameReader, ServerPacket, Sip, decode_packet, encode_command
from targets.robots.pioneer import PioneerRobot, RobotEvent, RobotSettings

SYNC0 = bytes.fromhex("FAFB03000000")
SYNC1 = bytes.fromhex("FAFB03010001")
SYNC2 = bytes.fromhex("FAFB03020002")
OPEN = SYNC1
MS = 1_000_000


class FakeChassis:
    """A unicycle that does exactly what its wheels are told, until it meets the wall.

    Attributes:
        wall_m: the front of the robot cannot pass x = wall_m; its wheels then stop dead under full load.
        stuck: wheels (0 left, 1 right) that do not turn, under full load when told to.
        grip: part of the wheels' way that the ground sees; the rest is slip that no encoder notices.
        echoes: sonar ranges by disc, m.
        pressed: bumper masks (front, rear) set by the test; the wall adds the front's middle segment.
    """

    RADIUS_M = 0.0825
    HALF_TRACK_M = 1 / 5.6
    FRONT_M = 0.21
    BUMPER_TRAVEL_M = 0.002

    def __init__(self) -> None:
        self.x_m = self.y_m = self.yaw_rad = 0.0
        self.wall_m = math.inf
        self.stuck: set[int] = set()
        self.grip = 1.0
        self.echoes: dict[int, float] = {}
        self.pressed = (0, 0)
        self.fired: list[int] = []
        self.servo = False
        self._told = (0.0, 0.0)
        self._angles = [0.0, 0.0]
        self._loads = (0.0, 0.0)
        self._at_wall = False

    def command_wheels(self, left_rad_s: float, right_rad_s: float) -> None:
        self.servo, self._told = True, (left_rad_s, right_rad_s)

    def release_wheels(self) -> None:
        self.servo, self._told = False, (0.0, 0.0)

    def wheel_angles_rad(self) -> tuple[float, float]:
        return self._angles[0], self._angles[1]

    def motor_loads(self) -> tuple[float, float]:
        return self._loads

    def bumpers(self) -> tuple[int, int]:
        return self.pressed[0] | (0b00100 if self._at_wall else 0), self.pressed[1]

    def sonar_range_m(self, number: int) -> float | None:
        self.fired.append(number)
        return self.echoes.get(number)

    def step(self, dt_s: float) -> None:
        left, right = (0.0 if side in self.stuck else speed for side, speed in enumerate(self._told))
        loads = [1.0 if side in self.stuck and speed else 0.1 for side, speed in enumerate(self._told)]
        forward = self.grip * (left + right) / 2 * self.RADIUS_M
        turn = self.grip * (right - left) / 2 * self.RADIUS_M / self.HALF_TRACK_M
        reach = self.x_m + self.FRONT_M + forward * math.cos(self.yaw_rad) * dt_s
        self._at_wall = reach >= self.wall_m - self.BUMPER_TRAVEL_M
        blocked = reach >= self.wall_m
        if blocked and forward > 0:
            left = right = forward = turn = 0.0
            loads = [1.0, 1.0]
        self._loads = (loads[0], loads[1]) if self.servo else (0.0, 0.0)
        self._angles[0] += left * dt_s
        self._angles[1] += right * dt_s
        half = turn * dt_s / 2
        chord = forward * dt_s * (math.sin(half) / half if half else 1.0)
        self.x_m += chord * math.cos(self.yaw_rad + half)
        self.y_m += chord * math.sin(self.yaw_rad + half)
        self.yaw_rad += turn * dt_s


@dataclass(frozen=True, slots=True)
class Received:
    at_ns: int
    packet: ServerPacket
    raw: bytes


class Rig:
    """Robot, body and bench time. `steps_hz` physics steps per second."""

    def __init__(self, settings: RobotSettings, *, seed: int = 1, steps_hz: int = 240) -> None:
        self.settings = settings
        self.chassis = FakeChassis()
        self.robot = PioneerRobot(settings, self.chassis, seed=seed)
        self.now_ns = 0
        self.received: list[Received] = []
        self.events: list[RobotEvent] = []
        self.connected = False
        self._hz = steps_hz
        self._steps = 0
        self._reader = FrameReader(max_count=MAX_COUNT)

    # --- time

    def run(self, duration_s: float) -> list[Received]:
        """Let time pass; return what arrived meanwhile."""
        first = len(self.received)
        end_ns = self.now_ns + round(duration_s * 1e9)
        while True:
            step_ns = self._steps * 1_000_000_000 // self._hz
            deadline_ns = self.robot.next_deadline_ns()
            due_ns = step_ns if deadline_ns is None else min(step_ns, max(deadline_ns, self.now_ns))
            if due_ns > end_ns:
                break
            self.now_ns = due_ns
            self._take(self.robot.advance(due_ns))
            if due_ns == step_ns:
                self.robot.control_step(due_ns, 1 / self._hz)
                self.chassis.step(1 / self._hz)
                self._steps += 1
            self.events += self.robot.take_events()
        self.now_ns = end_ns
        return self.received[first:]

    def send(self, data: bytes | str | Command) -> None:
        """Put bytes (or hex, or a command) on the line at this instant."""
        if isinstance(data, Command):
            data = encode_command(data)
        if isinstance(data, str):
            data = bytes.fromhex(data)
        self._take(self.robot.receive(data, self.now_ns))
        self.events += self.robot.take_events()

    def say(self, data: bytes | str | Command, wait_s: float = 0.0) -> list[Received]:
        """Send, let `wait_s` pass, and return everything that arrived."""
        first = len(self.received)
        self.send(data)
        self.run(wait_s)
        return self.received[first:]

    def hang_up(self) -> None:
        self._take(self.robot.line_down(self.now_ns))
        self.events += self.robot.take_events()

    # --- sessions

    def handshake(self) -> None:
        self.connected = False
        for sync in (SYNC0, SYNC1, SYNC2):
            assert self.say(sync, 0.01), "no answer"

    def open(self) -> None:
        self.handshake()
        self.connected = True
        self.send(OPEN)

    def ready(self) -> None:
        """Open session, motors on."""
        self.open()
        self.send("FAFB06043B0100053B")

    # --- what came

    @property
    def sips(self) -> list[Sip]:
        return [r.packet for r in self.received if isinstance(r.packet, Sip)]

    def next_sip(self) -> Sip:
        count = len(self.sips)
        while len(self.sips) == count:
            self.run(0.01)
        return self.sips[-1]

    def told(self, kind: type) -> list[RobotEvent]:
        return [event for event in self.events if isinstance(event, kind)]

    def _take(self, data: bytes) -> None:
        for item in self._reader.receive(data, self.now_ns):
            assert isinstance(item, Frame), f"the robot sent a bad frame: {item}"
            packet = decode_packet(item.body, connected=self.connected)
            self.received.append(Received(at_ns=self.now_ns, packet=packet, raw=item.raw))


@pytest.fixture
def rig() -> Rig:
    """A standard Pioneer 2-DX, waiting for a client."""
    return Rig(RobotSettings())


@pytest.fixture
def make_rig() -> Callable[..., Rig]:
    """Makes rigs: settings, then seed and steps_hz by name."""
    return Rig


@pytest.fixture
def ready(rig: Rig) -> Rig:
    """The same in an open session with its motors on."""
    rig.ready()
    return rig


@pytest.fixture(scope="session")
def rig_class() -> type[Rig]:
    """For properties, which make a rig per example."""
    return Rig
