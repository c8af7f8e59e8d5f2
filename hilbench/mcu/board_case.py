"""The bench of one case where emulated boards run firmware."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TypeVar

from hilbench.bench import Bench
from hilbench.cases import CaseBase
from hilbench.check.provider import CaseInfo
from hilbench.errors import InternalError
from hilbench.mcu.emulated import EmulatedBench
from hilbench.mcu.under_test import BoardUnderTest, boards_under_test
from hilbench.world_runner import WorldRunner
from targets.parts import Part
from worlds.vehicles.pioneer_2dx import Pioneer2dxBody
from worlds.world import World

__all__ = ["BoardCase"]

ThingT = TypeVar("ThingT")

_LINES_OF_EVIDENCE = 20


class BoardCase(CaseBase):
    """A case on a bench of its own, in virtual time.

    Args:
        bench: made for this case alone.
        case: what is known of it.
        emulated: the boards and what stands around them.

    Attributes:
        emulated: the boards and what stands around them.
        boards: the boards by name, power just on.
    """

    def __init__(self, bench: Bench, case: CaseInfo, emulated: EmulatedBench) -> None:
        super().__init__(bench, case)
        self.emulated = emulated
        self.boards: Mapping[str, BoardUnderTest] = boards_under_test(emulated)

    @property
    def board(self) -> BoardUnderTest:
        """The first board of the bench."""
        return next(iter(self.boards.values()))

    @property
    def parts(self) -> Mapping[str, Part]:
        """The parts by name."""
        return self.emulated.surroundings.parts.by_name

    @property
    def world(self) -> World:
        """The world around the board."""
        return _there(self.emulated.surroundings.world, "world")

    @property
    def body(self) -> Pioneer2dxBody:
        """The vehicle in it."""
        return _there(self.emulated.surroundings.body, "vehicle")

    @property
    def runner(self) -> WorldRunner:
        """Who moves the world."""
        return _there(self.emulated.surroundings.runner, "world")

    def _packets(self) -> Sequence[str]:
        return self.board.transcript[-_LINES_OF_EVIDENCE:]


def _there(thing: ThingT | None, what: str) -> ThingT:
    if thing is None:
        raise InternalError(f"the case needs a {what} and has not said so")
    return thing
