"""The bench of one case where emulated boards run firmware."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from typing import Any, TypeVar

from hilbench.bench import Bench
from hilbench.bench.about import about_boards, about_world
from hilbench.bench.cases import CaseBase
from hilbench.bench.line_peer import LinePeer
from hilbench.bench.protocol_peer import RAW, peer_of
from hilbench.bench.state_reporter import Observed
from hilbench.bench.world_runner import WorldRunner
from hilbench.errors import InternalError, UsageError
from hilbench.judging.provider import CaseInfo, CaseSetup
from hilbench.links import Port
from hilbench.mcu.emulated import EmulatedBench
from hilbench.mcu.under_test import BoardUnderTest, boards_under_test
from hilbench.plugins.blame import checked
from hilbench.plugins.discovery import PLUGINS
from targets.parts import Part
from worlds.world import World

__all__ = ["BoardBench", "BoardCase"]

ThingT = TypeVar("ThingT")

_LINES_OF_EVIDENCE = 20


class BoardBench:
    """A bench of emulated boards, as a case sees it.

    Args:
        emulated: the boards and what stands around them.

    Attributes:
        bench: time and journal.
        emulated: the boards and what stands around them.
        boards: the boards by name, power just on.
    """

    def __init__(self, emulated: EmulatedBench) -> None:
        self.bench: Bench = emulated.bench
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
    def body(self) -> Any:
        """The vehicle in it, of the class that its system has for it."""
        return _there(self.emulated.surroundings.body, "world")

    @property
    def runner(self) -> WorldRunner:
        """Who moves the world."""
        return _there(self.emulated.surroundings.runner, "world")


OpenOther = Callable[[CaseSetup, str], BoardBench]
"""Opens another bench of the same case, by setup and scene."""


class BoardCase(CaseBase, BoardBench):
    """A case on a bench of its own, in virtual time.

    Args:
        bench: made for this case alone.
        case: what is known of it.
        emulated: the boards and what stands around them.
        open_other: opens another bench beside it.
    """

    def __init__(self, bench: Bench, case: CaseInfo, emulated: EmulatedBench, open_other: OpenOther) -> None:
        CaseBase.__init__(self, bench, case, emulated.far_ends.faults)
        BoardBench.__init__(self, emulated)
        self._open_other = open_other

    def open_other(self, setup: CaseSetup, scene: str = "") -> BoardBench:
        """Open another bench, to hold against this one: with a time and a journal of its own, until the case ends.

        Args:
            setup: how it differs from the bench of the bench file; the case has to declare what that needs.
            scene: its scene; empty for that of the bench file.
        """
        return self._open_other(setup, scene)

    @cached_property
    def peer(self) -> LinePeer[Any]:
        """The checker's end of a board's line, with the frames of the protocol that the bench file names for it.

        Of several lines it is the first one with a protocol. Where none has one, each message is bytes as they came.

        Raises:
            UsageError: the bench file has no such line.
        """
        bench_file = self.emulated.bench_file
        lines = [end for end in bench_file.checker_lines.values() if end in self.emulated.ports]
        if not lines:
            hint = 'write [[links]] ends = ["peer", "NAME.usart1"]'
            raise UsageError("has no line between 'peer' and a board", where=bench_file.name, hint=hint)
        end = next((end for end in lines if end in bench_file.protocols), lines[0])
        return peer_of(
            self.bench, self.emulated.far_ends[end], bench_file.protocols.get(end, RAW), self.case.setup.program
        )

    def _machines_seen(self) -> Mapping[str, Observed]:
        model = self.emulated.surroundings.model
        return {} if model is None else model.machines

    def _lines_seen(self) -> Mapping[str, Port]:
        lines = self.emulated.bench_file.checker_lines
        ends = self.emulated.far_ends
        return {name or "host": ends[end] for name, end in lines.items() if end in ends}

    def _about_view(self) -> Mapping[str, Any]:
        bench_file = self.emulated.bench_file
        about = {"boards": about_boards(bench_file.boards), **about_world(self.emulated.surroundings.world)}
        system = PLUGINS.systems.speaking(self.case.needs)
        return (
            about
            if system is None
            else {**about, **checked(system.about_board, Mapping)(bench_file, self.case.setup.program)}
        )

    def _packets(self) -> Sequence[str]:
        waiting = ((name, self.emulated.waiting(name)) for name in self.boards)
        at_the_end = [f"{name} {text}, at the end" for name, text in waiting if text]
        return [*at_the_end, *self.board.transcript[-_LINES_OF_EVIDENCE:]]


def _there(thing: ThingT | None, what: str) -> ThingT:
    if thing is None:
        raise InternalError(f"the case needs a {what} and has not said so")
    return thing
