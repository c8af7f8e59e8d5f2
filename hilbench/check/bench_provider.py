"""Which benches there are, and which one a command line means.

A provider opens the bench of each case: a fresh virtual one, or what is at the other end of a real port, or a client
that connects to us. What it can do decides which cases apply; the names of the capabilities are those the clauses use.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from hilbench.bench.shared import Shared
from hilbench.bench.target_choice import first_of
from hilbench.benchfile.inputs import inputs_of, inputs_of_targets, lines_of
from hilbench.benchfile.reader import DEFAULT_FILE, BenchFile, open_bench
from hilbench.benchfile.target_grammar import Target, TargetKind, target_of
from hilbench.errors import UsageError
from hilbench.files import refuse_overwriting, refuse_writing_into
from hilbench.journal import Journal
from hilbench.judging.provider import Attended, BenchProvider
from hilbench.plugins.blame import checked
from hilbench.plugins.discovery import PLUGINS
from hilbench.protocol_bench.system import system_of
from hilbench.terminal.options import CheckOptions, TargetChoice

if TYPE_CHECKING:
    from hilbench.bench.operator import Operator, Somebody
    from hilbench.plugins.system import System
    from hilbench.through import Routes

__all__ = ["make_provider"]


def make_provider(options: CheckOptions) -> BenchProvider:
    """Return the provider that the options mean; nothing is opened yet.

    Raises:
        UsageError: the bench file or the target is wrong, or would be overwritten.
    """
    targets = [target_of(choice) for choice in options.targets]
    if any(target.kind is TargetKind.CAPTURE for target in targets):
        return _capture(options, targets)
    bench_file = open_bench(_bench_of(options), changes=options.changes)
    refuse_overwriting(options.outputs(), [*inputs_of(bench_file), *inputs_of_targets(options.targets)])
    refuse_writing_into(options.outputs(), lines_of(choice.spec for choice in options.targets))
    if bench_file.boards and not (options.suites or bench_file.suites):
        hint = 'write suites = ["my_suite.py"] into it, or --suite; without clauses: pytest (hilbench init begins one)'
        raise UsageError("names no suite for its boards", where=str(bench_file.path), hint=hint)
    system = _system(bench_file, options)
    operator = _operator(system, options)
    journal = Journal(options.journal, bench_file.header(options.seed), max_bytes=options.journal_max)
    route = _routes(options.through) if options.through else None
    shared = Shared(
        bench_file=bench_file, timeout_scale=options.timeout_scale, journal=journal, route=route, operator=operator
    )
    provider = _boards(shared, system, options) if bench_file.boards else _of_model(shared, system, options)
    if operator is not None and not isinstance(provider, Attended):
        hint = "name the port of a target that a person can touch"
        raise UsageError("this bench never asks an operator", where=_asking(options), hint=hint)
    return provider


def _system(bench_file: BenchFile, options: CheckOptions) -> System | None:
    """Return the system that the bench belongs to; None for boards that are nobody's."""
    if bench_file.boards:
        return PLUGINS.systems.of_suites(_speaking(bench_file, options))
    assert bench_file.model is not None
    return system_of(bench_file.model)


def _of_model(shared: Shared, system: System | None, options: CheckOptions) -> BenchProvider:
    assert system is not None
    return checked(system.provider, BenchProvider)(shared, options.targets)


def _operator(system: System | None, options: CheckOptions) -> Operator | None:
    """Return who is asked for what needs a hand on the target; None if nobody is to be.

    Raises:
        UsageError: nothing can be asked for, or nobody is there.
    """
    if not options.operator and not options.operator_hook:
        return None
    if system is None or not system.hand_requests:
        hint = "a system says what may be asked in its hand_requests"
        raise UsageError("this target never needs an operator", where=_asking(options), hint=hint)
    from hilbench.bench.operator import Operator
    from hilbench.bench.operator_hook import CommandAsOperator
    from hilbench.bench.operator_terminal import PersonAtTerminal

    somebodies: list[Somebody] = []
    if not options.list_only:
        somebodies += [CommandAsOperator(options.operator_hook)] if options.operator_hook else []
        somebodies += [PersonAtTerminal()] if options.operator else []
    return Operator(system.hand_requests, somebodies)


def _asking(options: CheckOptions) -> str:
    return "--operator-hook" if options.operator_hook else "--operator"


def _routes(kind: str) -> Routes:
    from hilbench.through import Routes

    return Routes(kind)


def _capture(options: CheckOptions, targets: Sequence[Target]) -> BenchProvider:
    from hilbench.check.capture_provider import CaptureProvider

    choice, target = next(
        (choice, target)
        for choice, target in zip(options.targets, targets, strict=True)
        if target.kind is TargetKind.CAPTURE
    )
    if len(options.targets) > 1 or choice.name:
        hint = "give no other target, and no NAME="
        raise UsageError("a recording stands for the whole bench", where=choice.where, hint=hint)
    if options.bench is not None:
        raise UsageError("a recording needs no bench", where=options.bench, hint="leave it out")
    if options.changes:
        raise UsageError("a recording has no bench file", where=options.changes[0].where, hint="leave it out")
    if options.through:
        raise UsageError("a recording has no lines", where=f"--through {options.through}", hint="leave it out")
    return CaptureProvider(options, Path(target.rest))


def _bench_of(options: CheckOptions) -> str | None:
    """Return the bench that is meant; where none is named, and suites of a model are, it is that model's."""
    if options.bench is not None or DEFAULT_FILE.is_file() or not options.suites:
        return options.bench
    kinds = (kind for _, kind in PLUGINS.systems.models().values())
    meant = [kind.bench for kind in kinds if {*options.suites} <= {*kind.suites}]
    return (meant[0] if meant else "") or None


def _boards(shared: Shared, system: System | None, options: CheckOptions) -> BenchProvider:
    """Return the provider of a bench with emulated boards, or of a board at ports in the place of them."""
    if system is not None:
        made = checked(system.board_provider, BenchProvider, or_none=True)(shared, options.targets)
        if made is not None:
            return made
    if any(target_of(choice).kind is TargetKind.SERIAL for choice in options.targets):
        return _stranger(shared, options.targets)
    from hilbench.mcu.board_provider import BoardProvider

    return BoardProvider(shared, options.targets)


def _speaking(bench_file: BenchFile, options: CheckOptions) -> Sequence[str]:
    """Return the suites that say what a bench of boards speaks: those of its file.

    Where it has none, it is those that are asked for; not so if it names a protocol, or no line leads to the checker.
    """
    lines = [end for end in bench_file.checker_lines.values() if end.partition(".")[0] in bench_file.boards]
    return bench_file.suites or (options.suites if lines and not bench_file.protocols else ())


def _stranger(shared: Shared, choices: Sequence[TargetChoice]) -> BenchProvider:
    """Return the provider of a real board that no system has one for: its suite speaks by the protocol of its file."""
    from hilbench.bench.protocol_providers import AttachedPeerProvider
    from hilbench.mcu.attached_board import AttachedBoardProvider, protocol_at

    if len(choices) > 1:
        where = first_of(choices, {TargetKind.SERIAL}).where
        raise UsageError("a board at a port stands for the whole bench", where=where, hint="name only that")
    spoken = protocol_at(shared.bench_file, choices[0])
    if spoken.peer is not None:
        return AttachedPeerProvider(shared, choices[0].spec, spoken)
    return AttachedBoardProvider(shared, choices[0])
