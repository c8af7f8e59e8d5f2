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
from hilbench.benchfile.reader import DEFAULT_FILE, open_bench
from hilbench.benchfile.target_grammar import Target, TargetKind, target_of
from hilbench.errors import UsageError
from hilbench.files import refuse_overwriting, refuse_writing_into
from hilbench.journal import Journal
from hilbench.judging.provider import BenchProvider
from hilbench.plugins.blame import checked
from hilbench.plugins.discovery import PLUGINS
from hilbench.protocol_bench.system import system_of
from hilbench.terminal.options import CheckOptions, TargetChoice

if TYPE_CHECKING:
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
    journal = Journal(options.journal, bench_file.header(options.seed), max_bytes=options.journal_max)
    route = _routes(options.through) if options.through else None
    shared = Shared(bench_file=bench_file, timeout_scale=options.timeout_scale, journal=journal, route=route)
    if bench_file.boards:
        return _boards(shared, options)
    assert bench_file.model is not None
    return checked(system_of(bench_file.model).provider, BenchProvider)(shared, options.targets)


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
        raise UsageError("a recording needs no bench", where=options.bench, hint="leave it away")
    if options.changes:
        raise UsageError("a recording has no bench file", where=options.changes[0].where, hint="leave it away")
    if options.through:
        raise UsageError("a recording has no lines", where=f"--through {options.through}", hint="leave it away")
    return CaptureProvider(options, Path(target.rest))


def _bench_of(options: CheckOptions) -> str | None:
    """Return the bench that is meant; where none is named, and suites of a model are, it is that model's."""
    if options.bench is not None or DEFAULT_FILE.is_file() or not options.suites:
        return options.bench
    kinds = (kind for _, kind in PLUGINS.systems.models().values())
    meant = [kind.bench for kind in kinds if {*options.suites} <= {*kind.suites}]
    return (meant[0] if meant else "") or None


def _boards(shared: Shared, options: CheckOptions) -> BenchProvider:
    """Return the provider of a bench with emulated boards, or of a board at ports in the place of them."""
    system = PLUGINS.systems.of_suites(_speaking(shared, options))
    if system is not None:
        made = checked(system.board_provider, BenchProvider, or_none=True)(shared, options.targets)
        if made is not None:
            return made
    if any(target_of(choice).kind is TargetKind.SERIAL for choice in options.targets):
        return _stranger(shared, options.targets)
    from hilbench.mcu.board_provider import BoardProvider

    return BoardProvider(shared, options.targets)


def _speaking(shared: Shared, options: CheckOptions) -> Sequence[str]:
    """Return the suites that say what a bench of boards speaks: those of its file.

    Where it has none, it is those that are asked for; not so if it names a protocol, or no line leads to the checker.
    """
    bench_file = shared.bench_file
    lines = [end for end in bench_file.checker_lines.values() if end.partition(".")[0] in bench_file.boards]
    return shared.suites or (options.suites if lines and not bench_file.protocols else ())


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
