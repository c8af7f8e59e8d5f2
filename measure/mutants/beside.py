"""Somebody beside a target at a port, in bench time: does what a check asks for at one of our own models."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from itertools import pairwise
from typing import Any

from hilbench.bench import Bench
from hilbench.bench.devices import DeviceActor, LinesActor
from hilbench.bench.operator import CANNOT, DONE, Asked
from hilbench.links import Port
from hilbench.systems.rover.hands import ModelHands
from protocols.carla import X_AXIS, Y_AXIS
from protocols.pkt import Position
from targets.robots.rover import RoverRobot
from targets.robots.vehicle_interface import VehicleInterface

__all__ = ["BesideRover", "BesideVehicle", "Person"]

TAKES_S = 3.0
"""How long somebody takes for whatever he is asked for: much longer than any deadline of the protocols."""


class Person:
    """Does what he is asked for at the target, in his own time.

    Attributes:
        asked: the names and words of the requests.
        cannot: the names of those that he refuses.
    """

    def __init__(self, *cannot: str) -> None:
        self.asked: list[tuple[str, ...]] = []
        self.cannot = cannot

    def answer(self, bench: Bench, asked: Asked) -> str:
        """See `hilbench.bench.operator.Somebody`."""
        self.asked.append((asked.name, *asked.words))
        bench.run_for(TAKES_S / 2)
        if asked.name in self.cannot:
            return CANNOT
        said = getattr(self, asked.name.replace("-", "_"))(bench, *asked.words)
        bench.run_for(TAKES_S / 2)
        return said or DONE

    def last(self, asked: Asked) -> None:
        """See `hilbench.bench.operator.Somebody`."""
        self.asked.append(("last", asked.name))

    def close(self) -> None:
        """See `hilbench.bench.operator.Somebody`."""
        self.asked.append(("close",))


class BesideRover(Person):
    """And is the board, which may be held in reset.

    Args:
        make: makes the rover, which counts time from when it is switched on.
        cannot: see `Person`.
    """

    def __init__(self, make: Callable[[], RoverRobot], *cannot: str) -> None:
        super().__init__(*cannot)
        self.make, self.robot, self.on_ns = make, make(), 0
        self._hands, self._held = ModelHands(self.robot), False

    def put(self, bench: Bench, port: Port) -> None:
        """Put the board at the far end of its line."""
        self._actor = DeviceActor(bench, self, port, name="rover")

    # --- what is asked for

    def led(self, _bench: Bench) -> str:
        return "lit" if self.robot.lit else "dark"

    def hold_wheels(self, _bench: Bench) -> None:
        self._hands.hold_wheels(True)

    def release_wheels(self, _bench: Bench) -> None:
        self._hands.hold_wheels(False)

    def hold_reset(self, _bench: Bench) -> None:
        self._held = True

    def release_reset(self, bench: Bench) -> None:
        self.robot, self.on_ns, self._held = self.make(), bench.now_ns, False
        self._hands = ModelHands(self.robot)
        self._actor.transmit(b"")

    def face_north(self, _bench: Bench) -> None:
        self._hands.face_north()

    def turn(self, _bench: Bench, way: str) -> None:
        self._hands.turn(way)

    def put_down(self, _bench: Bench) -> None:
        self._hands.put_down()

    def position(self, _bench: Bench, latitude_deg: str, longitude_deg: str) -> str:
        shown = Position(latitude_deg=float(latitude_deg), longitude_deg=float(longitude_deg))
        return _yes(self._hands.stands_at(shown))

    def carry(self, _bench: Bench) -> None:
        self._hands.carry()

    def cover_sky(self, _bench: Bench) -> None:
        self._hands.cover_sky(True)

    def uncover_sky(self, _bench: Bench) -> None:
        self._hands.cover_sky(False)

    def air(self, _bench: Bench, low_c: str, high_c: str) -> str:
        return _yes(self._hands.air_is_between(float(low_c), float(high_c)))

    # --- a device on a line

    def receive(self, data: bytes, now_ns: int) -> bytes:
        """See `DeviceActor`."""
        return b"" if self._held else self.robot.receive(data, now_ns - self.on_ns)

    def advance(self, now_ns: int) -> bytes:
        """See `DeviceActor`."""
        return b"" if self._held else self.robot.advance(now_ns - self.on_ns)

    def next_deadline_ns(self) -> int | None:
        """See `DeviceActor`."""
        due_ns = None if self._held else self.robot.next_deadline_ns()
        return None if due_ns is None else due_ns + self.on_ns

    def line_down(self, now_ns: int) -> bytes:
        """See `DeviceActor`."""
        return self.advance(now_ns)

    def take_events(self) -> Iterable[Any]:
        """See `DeviceActor`."""
        return () if self._held else self.robot.take_events()


class BesideVehicle(Person):
    """And is the board, which may be held in reset.

    Args:
        board: what stands at the ports.
        cannot: see `Person`.
    """

    def __init__(self, board: VehicleInterface, *cannot: str) -> None:
        super().__init__(*cannot)
        self.board, self._held = board, False

    def put(self, bench: Bench, ports: Mapping[str, Port]) -> None:
        """Put the board at the far ends of its lines."""
        self._actor = LinesActor(bench, self, ports, name="board")

    # --- what is asked for

    def press(self, bench: Bench) -> None:
        self._actor.transmit(self.board.press(bench.now_ns))

    def hold_joystick(self, bench: Bench, place: str) -> None:
        """A hand does not get quite to the end, and not straight."""
        x = {"right": 64_000, "left": 2000}.get(place.partition("to the ")[2].partition(" ")[0], X_AXIS.zero + 700)
        y = 1900 if "back" in place else 64_000 if "forward" in place else Y_AXIS.zero
        self._actor.transmit(self.board.set_joystick(x, y, bench.now_ns))

    def release_joystick(self, bench: Bench) -> None:
        self._actor.transmit(self.board.set_joystick(X_AXIS.zero + 200, Y_AXIS.zero - 200, bench.now_ns))

    def light(self, _bench: Bench) -> str:
        return self.board.light or "none"

    def indicators(self, bench: Bench) -> str:
        seen = []
        for _ in range(150):
            bench.run_for(0.02)
            seen.append(self.board.lit_lamps(bench.now_ns))
        left, right = (sum(now > before for before, now in pairwise(side)) for side in zip(*seen, strict=True))
        if not {left, right} <= {0, *range(3, 7)}:
            return "otherwise"
        return {(True, False): "left", (False, True): "right", (True, True): "both"}.get((left > 0, right > 0), "none")

    def hold_reset(self, _bench: Bench) -> None:
        self._held = True

    def release_reset(self, bench: Bench) -> None:
        self._held = False
        self._actor.transmit(self.board.reset(bench.now_ns))

    # --- a device at two lines

    def receive(self, line: str, data: bytes, now_ns: int) -> Any:
        """See `LinesActor`."""
        return [] if self._held else self.board.receive(line, data, now_ns)

    def advance(self, now_ns: int) -> Any:
        """See `LinesActor`."""
        return [] if self._held else self.board.advance(now_ns)

    def next_deadline_ns(self) -> int | None:
        """See `LinesActor`."""
        return None if self._held else self.board.next_deadline_ns()

    def line_down(self, line: str, now_ns: int) -> Any:
        """See `LinesActor`."""
        return [] if self._held else self.board.line_down(line, now_ns)

    def take_events(self) -> Iterable[Any]:
        """See `LinesActor`."""
        return () if self._held else self.board.take_events()


def _yes(true: bool) -> str:
    return "yes" if true else "no"
