"""What a check does to a vehicle-interface board, and sees of it, beside its lines: the same words whatever it is."""

from __future__ import annotations

from typing import Protocol

from hilbench.bench import Bench
from hilbench.bench.devices import LinesActor
from hilbench.systems.vehicle.simulator_peer import SimulatorPeer
from hilbench.systems.vehicle.stack_peer import StackPeer
from protocols.carla import Axis
from targets.robots.vehicle_interface import VehicleInterface

__all__ = ["HANDS", "ModelHands", "VehicleBench", "VehicleHands", "stick_code"]

HANDS = frozenset({"joystick", "lamps", "indicators", "boot", "line errors", "hang"})
"""The capabilities of a bench that has all of them, as the clauses name them."""


class VehicleHands(Protocol):
    """Somebody who stands beside the board."""

    def set_joystick(self, x_count: int, y_count: int) -> None:
        """Move the joystick to where the converter reads these counts, 0..65535."""

    def press(self) -> None:
        """Press the joystick's switch and let go of it, as somebody does: the contact may bounce."""

    def hold(self) -> None:
        """Hold the joystick's switch closed, with a wire: it does not bounce."""

    def let_go(self) -> None:
        """Take the wire away."""

    def lights(self) -> frozenset[str]:
        """Return which of the lights ``green``, ``amber`` and ``red`` are on."""

    def lamps(self) -> tuple[bool, bool]:
        """Return whether the left and the right lamp are lit."""

    def reset(self) -> None:
        """Press the reset button."""

    def hang(self) -> None:
        """Have the board's program do nothing more until a reset, as in an endless loop with interrupts off."""


class VehicleBench(Protocol):
    """A bench with a vehicle-interface board, as the cases of its suites see it."""

    @property
    def simulator(self) -> SimulatorPeer:
        """The checker's end of the simulator's line."""

    @property
    def stack(self) -> StackPeer:
        """The checker's end of the driving stack's line."""

    @property
    def hands(self) -> VehicleHands | None:
        """Who stands beside the board; None if nobody does."""


class ModelHands:
    """At a behavioural board.

    Args:
        bench: whose time it lives in.
        board: the board.
        actor: who calls it.
    """

    def __init__(self, bench: Bench, board: VehicleInterface, actor: LinesActor) -> None:
        self._bench = bench
        self._board = board
        self._actor = actor

    def set_joystick(self, x_count: int, y_count: int) -> None:
        """See `VehicleHands`."""
        self._bench.record("joystick", "hands", x=x_count, y=y_count)
        self._actor.transmit(self._board.set_joystick(x_count, y_count, self._bench.now_ns))

    def press(self) -> None:
        """See `VehicleHands`."""
        self._bench.record("press", "hands")
        self._actor.transmit(self._board.press(self._bench.now_ns))

    def hold(self) -> None:
        """See `VehicleHands`."""
        self._bench.record("hold", "hands")
        self._actor.transmit(self._board.hold(self._bench.now_ns))

    def let_go(self) -> None:
        """See `VehicleHands`."""
        self._bench.record("let go", "hands")
        self._actor.transmit(self._board.press(self._bench.now_ns))

    def lights(self) -> frozenset[str]:
        """See `VehicleHands`."""
        return frozenset({self._board.light} - {""})

    def lamps(self) -> tuple[bool, bool]:
        """See `VehicleHands`."""
        return self._board.lit_lamps(self._bench.now_ns)

    def reset(self) -> None:
        """See `VehicleHands`."""
        self._bench.record("reset", "hands")
        self._actor.transmit(self._board.reset(self._bench.now_ns))

    def hang(self) -> None:
        """See `VehicleHands`."""
        self._bench.record("hang", "hands")
        self._actor.transmit(self._board.hang(self._bench.now_ns))


def stick_code(axis: Axis, share: float) -> int:
    """Return the code of the converter for a share of the way beyond the dead band of an axis, -1 to 1."""
    if not share:
        return axis.zero
    end = axis.greatest if share > 0 else axis.least
    sign = 1 if share > 0 else -1
    return round(axis.zero + sign * axis.dead_band + abs(share) * (end - axis.zero - sign * axis.dead_band))
