"""Gives each case a fresh bench of emulated boards, in virtual time: the bench of a file, or one of its variants.

What a case may ask for beside the bench itself: another program of the board, a variant, settings of parts, a scene.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import fields, replace
from functools import cached_property
from pathlib import Path

import msgspec

from hilbench.bench import Bench
from hilbench.bench.cases import CaseBase
from hilbench.bench.physics import describe_physics, physics_capabilities, require_physics
from hilbench.bench.shared import Shared
from hilbench.benchfile.bench_file import BenchFile, EmulatedBoard, PartPlan
from hilbench.benchfile.reader import read_bench
from hilbench.benchfile.target_grammar import TargetKind, target_of
from hilbench.clock import Scheduler
from hilbench.errors import UsageError
from hilbench.journal import Journal
from hilbench.judging.observations import Observations
from hilbench.judging.provider import CaseInfo, CaseSetup
from hilbench.mcu.board_case import BoardBench, BoardCase
from hilbench.mcu.command_line import open_target
from hilbench.mcu.emulated import EmulatedBench
from hilbench.mcu.noted import Noted, lacking
from hilbench.nearest import did_you_mean
from hilbench.plugins.blame import checked
from hilbench.plugins.discovery import PLUGINS
from hilbench.plugins.system import System
from hilbench.terminal.options import TargetChoice
from targets.boards import Board, board_names
from worlds import default_physics

__all__ = ["BoardProvider"]

Alter = Callable[[BenchFile], BenchFile]


class BoardProvider:
    """See the module.

    Args:
        shared: bench file, journal, waiting.
        choices: the images to check instead of those of the bench file.
        alter: makes of each bench what it is checked as, such as one with a mistake that has to be found.

    Raises:
        UsageError: no suite is known for this bench, or a choice fits nothing.
    """

    def __init__(
        self, shared: Shared, choices: Sequence[TargetChoice] = (), *, alter: Alter = lambda bench_file: bench_file
    ) -> None:
        self._shared = shared
        self._alter = alter
        self._images = _Images(self._variants, choices)
        self._noted = Noted()

    @property
    def suites(self) -> Sequence[str]:
        """The suites of the bench file."""
        return self._shared.suites

    @property
    def capabilities(self) -> frozenset[str]:
        """Boards, programs, variants, parts, and what the world can do."""
        bench_file = self._shared.bench_file
        found = {"boards"}
        for system in PLUGINS.systems.there():
            found |= {*checked(system.board_capabilities, Iterable)(bench_file)}
        found |= {protocol.title for protocol in bench_file.protocols.values()}
        found |= {f"variant '{name}'" for name in self._variants if name}
        for name, variant in self._variants.items():
            there = {f"part '{part}'" for part in variant.parts}
            there |= {f"program '{one}'" for emulated in variant.boards.values() for one in emulated.programs}
            found |= {f"{thing} in variant '{name}'" for thing in there} if name else there
            found |= {thing for thing in there if thing.startswith("part")}
        if bench_file.has_world:
            found |= {"world", "scene"} | physics_capabilities(bench_file.world.physics)
        return frozenset(found)

    @property
    def recorded_in(self) -> Journal:
        """Where its cases are recorded."""
        return self._shared.journal

    def describe(self) -> Mapping[str, str]:
        """Name the bench, its boards and its physics."""
        bench_file = self._shared.bench_file
        boards = ", ".join(f"{emulated.board_name} ({emulated.timing})" for emulated in bench_file.boards.values())
        named = {
            name: describe_physics(variant.world.physics, variant.world.step_hz) if variant.has_world else "none"
            for name, variant in self._variants.items()
        }
        about = self._shared.describe(f"emulated {boards}", named[""])
        others = {f"physics of {name}": text for name, text in named.items() if text not in {named[""], "none"}}
        instead = {"instead": self._images.text} if self._images.text else {}
        return {**about, **others, **instead}

    def observed(self) -> Observations:
        """Return what there is to note of the firmware, over all cases so far."""
        return Observations(notes=self._noted.notes())

    def prepare(self, cases: Sequence[CaseInfo]) -> None:
        """Make sure that what somebody wants to be checked is checked by one of these cases at least.

        Raises:
            UsageError: an image that was put in the place of another, or the firmware of a board, is run by none.
            UnavailableError: the physics is not installed.
        """
        run = {full for case in cases if _system_of(case).needs_board(case) for full in self._run_by(case.setup)}
        if run and self._shared.bench_file.has_world:
            require_physics(self._shared.bench_file.world.physics)
        hint = f"these cases run {', '.join(sorted(run))}"
        for name in self._images.names:
            if cases and name not in run:
                raise UsageError("no case that is selected runs it", where=f"--target {name}=...", hint=hint)
        for name, emulated in self._shared.bench_file.boards.items():
            known = {*emulated.programs.values()}
            if cases and name not in run and known and emulated.firmware.resolve() not in {*map(Path.resolve, known)}:
                message = f"no case that is selected runs the firmware '{emulated.firmware}': each has a program"
                raise UsageError(message, where=emulated.where, hint=f"{hint}; see [targets.{name}.programs]")

    def _run_by(self, setup: CaseSetup) -> Iterator[str]:
        """Return what runs on the boards of a case, as a choice would name it."""
        for name, emulated in self._variants[setup.variant].boards.items():
            yield f"{name}.{setup.program}" if setup.program in emulated.programs else name

    @contextlib.contextmanager
    def open_case(self, case: CaseInfo) -> Iterator[CaseBase]:
        """Open a bench for one case."""
        bench = self._shared.bench(Scheduler())
        system = _system_of(case)
        if not system.needs_board(case):
            yield checked(system.without_board, CaseBase)(self._shared, bench, case)
            return
        with contextlib.ExitStack() as opened:
            there: list[EmulatedBench] = []

            def add(bench: Bench, setup: CaseSetup, scene: str) -> EmulatedBench:
                idle = not scene and "world" not in case.needs
                bench_file = self._bench_file(setup, scene)
                bench_file = replace(bench_file, vehicle_ready=bench_file.vehicle_ready and not idle)
                emulated = EmulatedBench(bench_file, seed=case.seed, bench=bench)
                opened.enter_context(contextlib.closing(emulated))
                opened.callback(self._noted.take, case.id, emulated)
                there.append(emulated)
                return emulated

            def open_other(setup: CaseSetup, scene: str) -> BoardBench:
                beside = Bench(Scheduler(), Journal(), timeout_scale=bench.timeout_scale)
                return BoardBench(add(beside, setup, scene))

            emulated = add(bench, case.setup, case.scene)
            special = checked(system.with_board, CaseBase, or_none=True)(self._shared, case, emulated)
            made = BoardCase(bench, case, emulated, open_other) if special is None else special
            made.on_lacks = lambda: lacking(there)
            yield made

    def close(self) -> None:
        """Close what the benches of the run had in common."""
        self._shared.close()

    # --- the bench of a case

    @cached_property
    def _variants(self) -> Mapping[str, BenchFile]:
        """Every bench there is, the one that was asked for under the empty name."""
        bench_file = self._shared.bench_file
        return {"": bench_file} | {name: self._variant(path) for name, path in bench_file.variants.items()}

    def _variant(self, path: Path) -> BenchFile:
        """Read another bench of these cases; a physics that was set is that of this one, too, unless it has its own."""
        variant = read_bench(path)
        physics = [change for change in self._shared.bench_file.changes if change.path == ("world", "physics")]
        own = variant.world.physics != default_physics()
        return read_bench(path, changes=physics) if physics and not own else variant

    def _bench_file(self, setup: CaseSetup, scene: str) -> BenchFile:
        bench_file = self._variants[setup.variant]
        boards = {
            name: self._images.chosen(name, emulated, setup.program) for name, emulated in bench_file.boards.items()
        }
        parts = {name: _set(plan, name, setup) for name, plan in bench_file.parts.items()}
        world = msgspec.structs.replace(bench_file.world, scene=scene) if scene else bench_file.world
        return self._alter(replace(bench_file, boards=boards, parts=parts, world=world))


def _set(plan: PartPlan, name: str, setup: CaseSetup) -> PartPlan:
    settings = setup.settings.get(name)
    return replace(plan, settings=replace(plan.settings, **settings)) if settings else plan


def _system_of(case: CaseInfo) -> System:
    """Return whose case it is, by the protocol that it needs; one without anything of its own where there is none."""
    return PLUGINS.systems.speaking(case.needs) or System()


class _Images:
    """Which image a board runs.

    Attributes:
        names: of what was replaced: boards, or their programs as ``BOARD.PROGRAM``.
        text: what was put in the place of the bench file's, for people; empty for nothing.
    """

    def __init__(self, variants: Mapping[str, BenchFile], choices: Sequence[TargetChoice]) -> None:
        boards = {name: emulated for variant in variants.values() for name, emulated in variant.boards.items()}
        programs = {
            f"{name}.{program}": None
            for variant in variants.values()
            for name, emulated in variant.boards.items()
            for program in emulated.programs
        }
        known = [*boards, *programs]
        self._chosen: dict[str, EmulatedBoard] = {}
        for choice in choices:
            name = choice.name or next(iter(boards))
            if name not in known:
                hint = did_you_mean(name, known, "this bench has")
                raise UsageError("nothing of that name to replace", where=f"--target {name}=...", hint=hint)
            self._chosen[name] = _only_board(choice)
            board = name.partition(".")[0]
            there = [variant.boards[board] for variant in variants.values() if board in variant.boards]
            _check_board(self._chosen[name], there)
        self.names = tuple(self._chosen)
        self.text = ", ".join(f"{name}: {emulated.firmware}" for name, emulated in self._chosen.items())

    def chosen(self, name: str, emulated: EmulatedBoard, program: str) -> EmulatedBoard:
        """Return the board of a case with its image: `program` of it, or its firmware where there is none such."""
        is_program = program in emulated.programs
        instead = self._chosen.get(f"{name}.{program}" if is_program else name)
        if instead is not None:
            return replace(emulated, firmware=instead.firmware, base=instead.base, where=instead.where)
        return replace(emulated, firmware=emulated.programs[program], base=None) if is_program else emulated


def _only_board(choice: TargetChoice) -> EmulatedBoard:
    if target_of(choice).kind is not TargetKind.BOARD:
        raise UsageError("not a board with an image", where=choice.where, hint=f"write {board_names()[0]}:IMAGE")
    return next(iter(open_target(choice.spec).boards.values()))


def _check_board(chosen: EmulatedBoard, there: Sequence[EmulatedBoard]) -> None:
    """Refuse a board that is not the bench's: only the image is replaced, and it would run on another."""
    if not any(_is_same(chosen.board, emulated.board) for emulated in there):
        message = f"the board of this bench is {there[0].board_name}, not {chosen.board_name}"
        hint = f"write {there[0].board_name}:{chosen.firmware}"
        raise UsageError(message, where=f"--target {chosen.where}", hint=hint)


def _is_same(one: Board, other: Board) -> bool:
    """Say whether two boards are the same but for the chip, which the bench may have chosen, and what that reaches."""
    names = {field.name for field in fields(one)} - {"chip", "connectors"}
    return all(getattr(one, name) == getattr(other, name) for name in names)
