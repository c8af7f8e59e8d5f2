"""What a check does to a vehicle-interface board, and sees of it, beside its lines: the same words whatever it is."""

from __future__ import annotations

from typing import Protocol

from hilbench.bench import Bench
from hilbench.bench.devices import LinesActor
from hilbench.bench.operator import Beside
from hilbench.errors import InternalError
from hilbench.judging.verdicts import Violation
from hilbench.systems.vehicle.simulator_peer import SimulatorPeer
from hilbench.systems.vehicle.stack_peer import StackPeer
from protocols.carla import X_AXIS, Y_AXIS, Axis
from targets.robots.vehicle_interface import VehicleInterface

__all__ = ["HANDS", "ModelHands", "OperatorHands", "VehicleBench", "VehicleHands", "stick_code"]

HANDS = frozenset({"joystick", "lamps", "indicators", "boot", "line errors", "hang"})
"""The capabilities of a bench that has all of them, as the clauses name them."""

BY_HAND_SHARE = 0.05
"""How far off the joystick may be that a person holds, as a share of its way. A choice."""


class VehicleHands(Protocol):
    """Somebody who stands beside the board.

    Attributes:
        off_share: how far off the joystick may be, as a share of its way; 0 where it is as it was set.
    """

    off_share: float

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

    def blinking(self) -> tuple[bool, bool] | None:
        """Return which lamps blink, 60 to 120 times a minute; None if it takes several looks at `lamps` to say that.

        Raises:
            Violation: one blinks otherwise.
        """

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

    off_share = 0.0

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

    def blinking(self) -> None:
        """See `VehicleHands`."""

    def reset(self) -> None:
        """See `VehicleHands`."""
        self._bench.record("reset", "hands")
        self._actor.transmit(self._board.reset(self._bench.now_ns))

    def hang(self) -> None:
        """See `VehicleHands`."""
        self._bench.record("hang", "hands")
        self._actor.transmit(self._board.hang(self._bench.now_ns))


class OperatorHands:
    """At a board at ports, as far as somebody is asked there.

    Args:
        beside: who is asked.
    """

    off_share = BY_HAND_SHARE

    def __init__(self, beside: Beside) -> None:
        self._beside = beside

    def set_joystick(self, x_count: int, y_count: int) -> None:
        """See `VehicleHands`; a hand finds no other places than rest and the ends."""
        sides = {X_AXIS.greatest: "to the right", X_AXIS.least: "to the left", X_AXIS.zero: ""}
        ways = {Y_AXIS.greatest: "forward", Y_AXIS.least: "back", Y_AXIS.zero: ""}
        place = " and ".join(filter(None, (sides[x_count], ways[y_count])))
        if place:
            self._beside.ask("hold-joystick", place)
        else:
            self._beside.ask("release-joystick")

    def press(self) -> None:
        """See `VehicleHands`."""
        self._beside.ask("press")

    def boot(self, simulator: SimulatorPeer, stack: StackPeer) -> None:
        """Have the board begin anew, with no agent there; what it said before is discarded while it is held in reset.

        When it begins is not known: the case finds out by its first ping.
        """
        self._beside.ask("hold-reset")
        stack.online = False
        simulator.forget()
        stack.forget()
        self._beside.ask("release-reset")

    def boot_again(self, stack: StackPeer) -> None:
        """Have it begin anew, with the agent there: one that was shipped does not find an agent that comes late."""
        stack.online = True
        self._beside.ask("hold-reset")
        self._beside.ask("release-reset")

    def lights(self) -> frozenset[str]:
        """See `VehicleHands`."""
        answer = self._beside.ask("light")
        return {"none": frozenset[str](), "several": frozenset({"several lights"})}.get(answer, frozenset({answer}))

    def blinking(self) -> tuple[bool, bool]:
        """See `VehicleHands`."""
        answer = self._beside.ask("indicators")
        if answer == "otherwise":
            raise Violation("a turn indicator blinks neither once nor twice a second")
        return answer in ("left", "both"), answer in ("right", "both")

    def hold(self) -> None:
        """See `VehicleHands`; no finger closes a switch without bouncing."""
        raise InternalError("a clause that needs a switch which does not bounce is not by hand")

    def let_go(self) -> None:
        """See `VehicleHands`."""
        raise InternalError("a clause that needs a switch which does not bounce is not by hand")

    def lamps(self) -> tuple[bool, bool]:
        """See `VehicleHands`; `blinking` is asked instead."""
        raise InternalError("no operator can watch a lamp fifty times a second")

    def reset(self) -> None:
        """See `VehicleHands`."""
        raise InternalError("a clause that begins with power just on is not by hand")

    def hang(self) -> None:
        """See `VehicleHands`."""
        raise InternalError("a clause about a program that hangs is not by hand")


def stick_code(axis: Axis, share: float) -> int:
    """Return the code of the converter for a share of the way beyond the dead band of an axis, -1 to 1."""
    if not share:
        return axis.zero
    end = axis.greatest if share > 0 else axis.least
    sign = 1 if share > 0 else -1
    return round(axis.zero + sign * axis.dead_band + abs(share) * (end - axis.zero - sign * axis.dead_band))
