"""What a check does to a rover, and sees of it, beside its line: the same words whatever stands there."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Protocol

from hilbench.bench import Bench
from hilbench.bench.operator import Beside
from hilbench.benchfile.bench_file import BenchFile
from hilbench.errors import InternalError
from hilbench.judging.provider import CaseInfo
from hilbench.mcu.board_case import BoardBench, BoardCase
from hilbench.mcu.terminals import PinInput
from hilbench.systems.rover.peer import RoverPeer
from protocols.pkt import Position, Profile
from targets.parts.l298n import bridge_shares
from targets.parts.neo6m.geodesy import Geodetic, Tangent, geodetic_of
from targets.parts.neo6m.settings import Neo6mSettings
from targets.robots.rover import Rocking, RoverRobot, Sensed
from worlds.vehicles.rover_4wd import WHEELS, Rover4wdBody

__all__ = [
    "HANDS",
    "MODEL_HANDS",
    "REOPEN",
    "TURNS",
    "BoardHands",
    "ModelHands",
    "OperatorHands",
    "RoverBench",
    "RoverHands",
    "RoverOnBoard",
    "hands_on",
]

REOPEN = "reopen"
"""The capability of a bench whose line can be closed and opened again."""

HANDS = frozenset({"led", "wheels", "duty", "imu", "gps", "boot"})
"""The capabilities of a bench that has all of them, as the clauses name them."""

MODEL_HANDS = HANDS | {"sensed", "turned", "sky", "carried", "air"}
"""Those at a model, whose sensors sense what they are told to: it has no body in a world."""

TURNS = ("about its vertical axis", "over its sides", "over its nose")
"""The ways in which a rover is turned to and fro: about z, x and y."""

CARRIED_DEG = 0.01
"""How far the model is carried (choice): 1.1 km to the north, and nearly as much to the east."""

_NEEDED_PARTS = {"duty": "l298n", "wheels": "dc-motor", "imu": "mpu9250", "gps": "neo6m"}

NEAR_DEG = 0.001
"""110 m along a meridian."""

PWM_PERIOD_NS = 20_000_000
"""Of the motors' voltage: 50 Hz, the default of Mbed OS that no firmware changes."""

Four = tuple[float, float, float, float]


class RoverHands(Protocol):
    """Somebody who stands beside the rover."""

    @property
    def can(self) -> frozenset[str]:
        """What he does and sees in the case, by the names of `HANDS`."""

    def led_is_lit(self) -> bool:
        """Look at the test LED."""

    def hold_wheels(self, held: bool) -> None:
        """Hold all wheels, or let them go."""

    def wheels_rpm(self) -> Four:
        """Return the true speeds of the wheels, in the order of their tachometers, negative backwards."""

    def duties(self) -> tuple[float, float]:
        """Return what reaches the motors of the left and the right pair: -1 to 1 of what the driver can put out."""

    def position(self) -> Position | None:
        """Return where the rover truly is; None if nobody knows it in figures: `stands_at` is asked."""

    def stands_at(self, position: Position) -> bool:
        """Say whether the rover is within 100 m of a place."""

    def sense(self, sensed: Sensed) -> None:
        """Let its inertial sensor sense this."""

    def place(self, position: Position | None) -> None:
        """Let its GPS receiver be there; None takes its view of the sky."""

    def face_north(self) -> None:
        """Have the rover stand level, its front towards magnetic north."""

    def turn(self, way: str) -> None:
        """Begin to turn the rover slowly to and fro in one of `TURNS`, and go on."""

    def put_down(self) -> None:
        """Turn it no more."""

    def cover_sky(self, covered: bool) -> None:
        """Take the GPS receiver's view of the sky until it has no fix, or give it back until it has one."""

    def carry(self) -> None:
        """Carry the rover at least 200 m away."""

    def air_is_between(self, low_c: float, high_c: float) -> bool:
        """Say whether the air around the rover is that warm."""


class RoverBench(Protocol):
    """A bench with a rover, as the cases of its suites see it."""

    @property
    def case(self) -> CaseInfo:
        """What is known of the case."""

    @property
    def peer(self) -> RoverPeer:
        """The checker's end of the rover's line."""

    @property
    def hands(self) -> RoverHands | None:
        """Who stands beside the rover; None if nobody does."""

    def reopen(self, closed_s: float) -> None:
        """Close the line for so long, in seconds, and open it again; where the bench has `REOPEN`."""


class ModelHands:
    """At a behavioural rover.

    Args:
        robot: the rover.
    """

    can = MODEL_HANDS

    def __init__(self, robot: RoverRobot) -> None:
        self._robot = robot
        self._covered = robot.position

    def led_is_lit(self) -> bool:
        """See `RoverHands`."""
        return self._robot.lit

    def hold_wheels(self, held: bool) -> None:
        """See `RoverHands`."""
        self._robot.plant.force(0.0 if held else None)

    def wheels_rpm(self) -> Four:
        """See `RoverHands`."""
        lf, rf, lb, rb = (wheel.rpm for wheel in self._robot.plant.wheels)
        return lf, rf, lb, rb

    def duties(self) -> tuple[float, float]:
        """See `RoverHands`."""
        return self._robot.duties

    def position(self) -> Position:
        """See `RoverHands`."""
        assert self._robot.position is not None
        return self._robot.position

    def sense(self, sensed: Sensed) -> None:
        """See `RoverHands`."""
        self._robot.sensed = sensed

    def place(self, position: Position | None) -> None:
        """See `RoverHands`."""
        self._robot.position = position

    def stands_at(self, position: Position) -> bool:
        """See `RoverHands`."""
        return _are_near(position, self.position())

    def face_north(self) -> None:
        """See `RoverHands`; it does."""

    def turn(self, way: str) -> None:
        """See `RoverHands`."""
        self._robot.rocking = Rocking(axis=(2, 0, 1)[TURNS.index(way)])

    def put_down(self) -> None:
        """See `RoverHands`."""
        self._robot.rocking = None

    def cover_sky(self, covered: bool) -> None:
        """See `RoverHands`."""
        if covered:
            self._covered = self._robot.position
        self._robot.position = None if covered else self._covered

    def carry(self) -> None:
        """See `RoverHands`."""
        here = self.position()
        self._robot.position = Position(
            latitude_deg=here.latitude_deg + CARRIED_DEG, longitude_deg=here.longitude_deg + CARRIED_DEG
        )

    def air_is_between(self, low_c: float, high_c: float) -> bool:
        """See `RoverHands`; its sensor is as warm as the air."""
        return low_c <= self._robot.sensed.temperature_c <= high_c


class BoardHands:
    """At an emulated board with an L298N, motors and a world around it.

    Args:
        board_bench: the bench.
    """

    can = HANDS

    def __init__(self, board_bench: BoardBench) -> None:
        self._bench: Bench = board_bench.bench
        self._there = board_bench
        plans = board_bench.emulated.bench_file.parts
        self._motors = [name for name, plan in plans.items() if plan.kind == "dc-motor"]
        driver = next(name for name, plan in plans.items() if plan.kind == "l298n")
        self._left, self._right = (
            (self._input(driver, enable), self._input(driver, first), self._input(driver, second))
            for enable, first, second in (("ena", "in1", "in2"), ("enb", "in3", "in4"))
        )

    def led_is_lit(self) -> bool:
        """See `RoverHands`; it is the first light of the board."""
        return self._there.board.is_lit()

    def hold_wheels(self, held: bool) -> None:
        """See `RoverHands`."""
        for name in self._motors:
            self._there.emulated.surroundings.parts.set(name, {"hold": float(held)})

    def wheels_rpm(self) -> Four:
        """See `RoverHands`."""
        lf, rf, lb, rb = (self._body.wheel(name).speed_rad_s * 60 / math.tau for name in WHEELS)
        return lf, rf, lb, rb

    def duties(self) -> tuple[float, float]:
        """See `RoverHands`: the mean over the last period."""
        now_ns = self._bench.now_ns
        from_ns = max(0, now_ns - PWM_PERIOD_NS)
        left = bridge_shares(*self._left, from_ns, now_ns)
        right = bridge_shares(*self._right, from_ns, now_ns)
        return left.forward - left.backward, right.forward - right.backward

    def position(self) -> Position:
        """See `RoverHands`: by the settings of the GPS receiver, on the ellipsoid, near its origin."""
        plan = next(one for one in self._there.emulated.bench_file.parts.values() if one.kind == "neo6m")
        x_m, y_m, _ = self._body.world.pose().position_m
        return _position_at(plan.settings, x_m, y_m)

    def sense(self, sensed: Sensed) -> None:
        """See `RoverHands`; its sensors sense the world."""
        del sensed
        raise InternalError("what the sensors of a board sense cannot be chosen")

    def place(self, position: Position | None) -> None:
        """See `RoverHands`; likewise."""
        del position
        raise InternalError("what the sensors of a board sense cannot be chosen")

    def stands_at(self, position: Position) -> bool:
        """See `RoverHands`."""
        return _are_near(position, self.position())

    def face_north(self) -> None:
        """See `RoverHands`; it does where a case begins."""

    def turn(self, way: str) -> None:
        """See `RoverHands`; it stands in a world."""
        del way
        raise InternalError("a rover in a world is in nobody's hands")

    def put_down(self) -> None:
        """See `RoverHands`; likewise."""
        raise InternalError("a rover in a world is in nobody's hands")

    def cover_sky(self, covered: bool) -> None:
        """See `RoverHands`; likewise."""
        del covered
        raise InternalError("the sky of a world cannot be covered")

    def carry(self) -> None:
        """See `RoverHands`; likewise."""
        raise InternalError("a rover in a world is in nobody's hands")

    def air_is_between(self, low_c: float, high_c: float) -> bool:
        """See `RoverHands`; likewise."""
        del low_c, high_c
        raise InternalError("a world has no air")

    @property
    def _body(self) -> Rover4wdBody:
        body = self._there.emulated.surroundings.body
        if not isinstance(body, Rover4wdBody):
            raise InternalError("the vehicle of this bench is no rover")
        return body

    def _input(self, part: str, terminal: str) -> PinInput:
        for net in self._there.emulated.bench_file.nets:
            if any((end.part, end.terminal) == (part, terminal) for end in net.terminals) and net.pins:
                pin = net.pins[0]
                return PinInput(self._bench, self._there.boards[pin.board].pin(pin.pin))
        raise InternalError(f"'{part}.{terminal}' leads to no pin")


class OperatorHands:
    """At a rover at a port, as far as somebody is asked there.

    Args:
        beside: who is asked.
    """

    def __init__(self, beside: Beside) -> None:
        self._beside = beside
        self._held = False

    @property
    def can(self) -> frozenset[str]:
        """See `RoverHands`."""
        return self._beside.case.by_hand

    def led_is_lit(self) -> bool:
        """See `RoverHands`."""
        return self._beside.ask("led") == "lit"

    def hold_wheels(self, held: bool) -> None:
        """See `RoverHands`; whoever holds them is not asked again."""
        if held != self._held:
            self._beside.ask("hold-wheels" if held else "release-wheels")
            self._held = held

    def boot(self, peer: RoverPeer) -> None:
        """Have the board begin anew; what it said before is discarded while it is held in reset."""
        self._beside.ask("hold-reset")
        peer.forget()
        self._beside.ask("release-reset")

    def wheels_rpm(self) -> Four:
        """See `RoverHands`; nobody's eye tells it."""
        raise InternalError("a clause that needs the speed of wheels is not by hand")

    def duties(self) -> tuple[float, float]:
        """See `RoverHands`."""
        raise InternalError("a clause that needs the motors' voltage is not by hand")

    def position(self) -> None:
        """See `RoverHands`."""

    def stands_at(self, position: Position) -> bool:
        """See `RoverHands`; by a map."""
        return self._beside.ask("position", f"{position.latitude_deg:.5f}", f"{position.longitude_deg:.5f}") == "yes"

    def face_north(self) -> None:
        """See `RoverHands`."""
        self._beside.ask("face-north")

    def turn(self, way: str) -> None:
        """See `RoverHands`."""
        self._beside.ask("turn", way)

    def put_down(self) -> None:
        """See `RoverHands`."""
        self._beside.ask("put-down")

    def cover_sky(self, covered: bool) -> None:
        """See `RoverHands`."""
        self._beside.ask("cover-sky" if covered else "uncover-sky")

    def carry(self) -> None:
        """See `RoverHands`."""
        self._beside.ask("carry")

    def air_is_between(self, low_c: float, high_c: float) -> bool:
        """See `RoverHands`."""
        return self._beside.ask("air", f"{low_c:.0f}", f"{high_c:.0f}") == "yes"

    def sense(self, sensed: Sensed) -> None:
        """See `RoverHands`; likewise."""
        del sensed
        raise InternalError("a clause that chooses what is sensed is not by hand")

    def place(self, position: Position | None) -> None:
        """See `RoverHands`; likewise."""
        del position
        raise InternalError("a clause that chooses what is sensed is not by hand")


class RoverOnBoard:
    """A bench of an emulated board, as the cases of a rover see it.

    Args:
        board_case: the bench; one of its links leads to the checker.
        profile: what the rover is to be spoken to in.
    """

    def __init__(self, board_case: BoardCase, profile: Profile) -> None:
        emulated = board_case.emulated
        port = emulated.far_ends.reacting(emulated.bench_file.checker_lines[""])
        self.case = board_case.case
        self.there = board_case
        self.peer = RoverPeer(board_case.bench, port, profile)
        self.hands = BoardHands(board_case)

    def reopen(self, closed_s: float) -> None:
        """See `RoverBench`: a UART sees nothing of it, and what it says meanwhile is lost."""
        self.peer.run(closed_s)
        self.peer.forget()


def hands_on(bench_file: BenchFile) -> Iterable[str]:
    """Return what a bench of boards can do for the cases of a rover."""
    kinds = {plan.kind for plan in bench_file.parts.values()}
    if "" in bench_file.checker_lines and bench_file.boards:
        yield "PKT!"
        yield "server"
        yield "boot"
        yield REOPEN
        if "l298n" in kinds:
            yield "led"
        yield from (name for name, kind in _NEEDED_PARTS.items() if kind in kinds)


def _are_near(one: Position, other: Position) -> bool:
    """Say whether two places are within about 100 m of each other."""
    apart_deg = abs(one.latitude_deg - other.latitude_deg), abs(one.longitude_deg - other.longitude_deg)
    return max(apart_deg) <= NEAR_DEG


def _position_at(settings: Neo6mSettings, x_m: float, y_m: float) -> Position:
    """Return the position of a place in the scene, by where its origin is and where its x axis looks to."""
    origin = Geodetic(latitude_deg=settings.latitude_deg, longitude_deg=settings.longitude_deg, height_m=0.0)
    bearing = math.radians(settings.x_axis_bearing_deg)
    east_m = x_m * math.sin(bearing) - y_m * math.cos(bearing)
    north_m = x_m * math.cos(bearing) + y_m * math.sin(bearing)
    place = geodetic_of(Tangent(origin).place((east_m, north_m, 0.0)))
    return Position(latitude_deg=place.latitude_deg, longitude_deg=place.longitude_deg)
