"""Which benches there are, and which one a command line means.

A provider opens the bench of each case: a fresh virtual one, or what is at the other end of a real port, or a client
that connects to us. What it can do decides which cases apply; the names of the capabilities are those the clauses use.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from hilbench.check.provider import BenchProvider
from hilbench.config import DEFAULT_FILE, open_bench
from hilbench.errors import UsageError
from hilbench.files import refuse_overwriting, refuse_writing_into
from hilbench.inputs import inputs_of, inputs_of_targets, lines_of
from hilbench.journal import Journal
from hilbench.locked_providers import ExecProvider, FarEnd, ListenProvider
from hilbench.model_kinds import MODEL_KINDS, board_protocol
from hilbench.nearest import did_you_mean
from hilbench.options import CheckOptions, TargetChoice
from hilbench.shared import Shared
from hilbench.systems.pioneer.provider import P2OS_SERVER, AttachedProvider, VirtualProvider
from hilbench.target import Target, TargetKind, target_of

if TYPE_CHECKING:
    from hilbench.through import Passages

__all__ = ["make_provider"]


def make_provider(options: CheckOptions) -> BenchProvider:
    """Return the provider that the options mean; nothing is opened yet.

    Raises:
        UsageError: the bench file or the target is wrong, or would be overwritten.
    """
    targets = [target_of(choice) for choice in options.targets]
    if any(target.kind is TargetKind.CAPTURE for target in targets):
        return _capture(options, targets)
    bench_file = open_bench(_bench_of(options))
    refuse_overwriting(options.outputs(), [*inputs_of(bench_file), *inputs_of_targets(options.targets)])
    refuse_writing_into(options.outputs(), lines_of(choice.spec for choice in options.targets))
    if bench_file.boards and not (options.suites or bench_file.suites):
        hint = 'write suites = ["my_suite.py"] into it, or --suite; without clauses: pytest (hilbench init begins one)'
        raise UsageError("names no suite for its boards", where=str(bench_file.path), hint=hint)
    journal = Journal(options.journal, bench_file.header(options.seed), max_bytes=options.journal_max)
    passage = _passages(options.through) if options.through else None
    shared = Shared(bench_file=bench_file, timeout_scale=options.timeout_scale, journal=journal, passage=passage)
    if bench_file.boards:
        return _boards(shared, options, targets)
    if bench_file.vehicle is not None:
        return _vehicle(shared, options.targets, targets)
    if bench_file.plugged_in is not None:
        return _plugged_in(shared, options.targets, targets)
    return _model(shared, options.targets, targets)


def _passages(kind: str) -> Passages:
    from hilbench.through import Passages

    return Passages(kind)


def _capture(options: CheckOptions, targets: Sequence[Target]) -> BenchProvider:
    from hilbench.capture_provider import CaptureProvider

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
    if options.through:
        raise UsageError("a recording has no lines", where=f"--through {options.through}", hint="leave it away")
    return CaptureProvider(options, Path(target.rest))


def _bench_of(options: CheckOptions) -> str | None:
    """Return the bench that is meant; where none is named, and suites of a model are, it is that model's."""
    if options.bench is not None or DEFAULT_FILE.is_file() or not options.suites:
        return options.bench
    meant = [kind.bench for kind in MODEL_KINDS.values() if {*options.suites} <= {*kind.suites}]
    return (meant[0] if meant else "") or None


def _plugged_in(shared: Shared, choices: Sequence[TargetChoice], targets: Sequence[Target]) -> BenchProvider:
    """Return the provider of a bench with the model of a plug-in, or of a real one at a port."""
    from hilbench.protocol_bench.providers import AttachedPeerProvider, DeviceProvider

    there = shared.bench_file.plugged_in
    assert there is not None
    assert there.protocol is not None
    if not targets:
        return DeviceProvider(shared, there.protocol, there.settings)
    choice = _only(shared, choices)
    if targets[0].kind is not TargetKind.SERIAL:
        message = f"{targets[0].kind.value} cannot be the target of bench '{shared.bench_file.name}'"
        raise UsageError(message, where=choice.where, hint="write serial:PORT@BAUD or a pyserial URL")
    return AttachedPeerProvider(shared, choice.spec, there.protocol)


def _only(shared: Shared, choices: Sequence[TargetChoice]) -> TargetChoice:
    """Return the one target that is chosen for a bench with one line.

    Raises:
        UsageError: there are several, or it is for something else.
    """
    if len(choices) > 1:
        raise UsageError("this bench has one target", where=choices[1].where, hint="name only one")
    choice = choices[0]
    if choice.name and choice.name not in shared.bench_file.targets:
        nearest = did_you_mean(choice.name, shared.bench_file.targets, "targets")
        raise UsageError(f"no target '{choice.name}'", where=choice.where, hint=nearest)
    return choice


def _model(shared: Shared, choices: Sequence[TargetChoice], targets: Sequence[Target]) -> BenchProvider:
    """Return the provider of a bench with a model that has one line."""
    rover = shared.bench_file.rover is not None
    if not targets:
        return _rover(shared) if rover else VirtualProvider(shared)
    choice, target = _only(shared, choices), targets[0]
    own = "rover-model" if rover else "pioneer"
    if target.kind is TargetKind.MODEL and target.text == own:
        return _rover(shared) if rover else VirtualProvider(shared)
    if not rover:
        shared.bench_file.pioneer()  # or it is no bench for this
    if target.kind is TargetKind.SERIAL:
        return _rover_at(shared, target.text) if rover else AttachedProvider(shared, target.text)
    return _client(shared, choice, target, _far_end(shared, rover=rover), own)


def _far_end(shared: Shared, *, rover: bool) -> FarEnd:
    if not rover:
        return P2OS_SERVER
    from hilbench.systems.rover.provider import foreign_host

    return foreign_host(shared)


def _client(shared: Shared, choice: TargetChoice, target: Target, far_end: FarEnd, own: str) -> BenchProvider:
    """Return the provider for a client that somebody else wrote."""
    if target.kind is TargetKind.LISTEN:
        return ListenProvider(shared, target.rest, far_end)
    if target.kind is TargetKind.EXEC:
        return ExecProvider(shared, target.rest, far_end)
    hint = f"write {own}, serial:PORT@BAUD, a pyserial URL, listen:pty:PATH, listen:tcp:PORT or exec:COMMAND"
    raise UsageError(
        f"{target.kind.value} cannot be the target of bench '{shared.bench_file.name}'", where=choice.where, hint=hint
    )


def _rover(shared: Shared) -> BenchProvider:
    from hilbench.systems.rover.provider import RoverProvider

    return RoverProvider(shared)


def _rover_at(shared: Shared, spec: str) -> BenchProvider:
    from hilbench.systems.rover.provider import AttachedRoverProvider

    return AttachedRoverProvider(shared, spec)


_CLIENTS = {TargetKind.LISTEN, TargetKind.EXEC}


def _vehicle(shared: Shared, choices: Sequence[TargetChoice], targets: Sequence[Target]) -> BenchProvider:
    """Return the provider of a bench with the model of a vehicle interface."""
    from hilbench.systems.vehicle.provider import (
        MODEL_TARGET,
        AttachedVehicleProvider,
        VehicleProvider,
        foreign_simulator,
    )

    kinds = {target.kind for target in targets}
    if all(target.name == MODEL_TARGET for target in targets):
        return VehicleProvider(shared, [choice for choice in choices if choice.spec != MODEL_TARGET])
    if kinds == {TargetKind.SERIAL}:
        return AttachedVehicleProvider(shared, choices)
    if len(targets) > 1 and kinds <= _CLIENTS:
        raise UsageError("one simulator's side at a time", where=choices[1].where, hint="name only one")
    if len(targets) > 1:
        choice = _first(choices, targets, {*TargetKind} - {TargetKind.SERIAL})
        raise UsageError("each line needs a serial port", where=choice.where, hint="write LINE=serial:PORT for each")
    own = f"interface.PROFILE={MODEL_TARGET}:PROFILE"
    return _client(shared, choices[0], targets[0], foreign_simulator(shared), own)


def _boards(shared: Shared, options: CheckOptions, targets: Sequence[Target]) -> BenchProvider:
    """Return the provider of a bench with emulated boards, or of a board at ports in the place of them."""
    choices, kinds = options.targets, {target.kind for target in targets}
    protocol = board_protocol(shared.suites or options.suites)
    if protocol == "CARLA" and kinds & _CLIENTS:
        choice = _first(choices, targets, _CLIENTS)
        raise UsageError(
            "a program in the place of the simulator's side is checked without a board, not on this bench",
            where=choice.where,
            hint=f"write hilbench check vehicle-model --suite vehicle-host --target '{choice.spec}'",
        )
    if TargetKind.SERIAL not in kinds:
        return _emulated(shared, choices)
    if len(kinds) > 1 or (len(targets) > 1 and protocol != "CARLA"):
        choice = _first(choices, targets, {TargetKind.SERIAL})
        raise UsageError("a board at a port stands for the whole bench", where=choice.where, hint="name only that")
    return _at_ports(shared, choices, protocol)


def _at_ports(shared: Shared, choices: Sequence[TargetChoice], protocol: str) -> BenchProvider:
    """Return the provider of a real board that speaks a protocol; empty: one that nothing of ours speaks to."""
    if protocol == "CARLA":
        from hilbench.systems.vehicle.provider import AttachedVehicleProvider

        return AttachedVehicleProvider(shared, choices)
    if not protocol:
        from hilbench.mcu.attached_board import AttachedBoardProvider, protocol_at

        spoken = protocol_at(shared.bench_file, choices[0])
        if spoken.peer is not None:
            from hilbench.protocol_bench.providers import AttachedPeerProvider

            return AttachedPeerProvider(shared, choices[0].spec, spoken)

        return AttachedBoardProvider(shared, choices[0])
    board = choices[0].name.partition(".")[0]
    if board and board not in shared.bench_file.boards:
        hint = did_you_mean(board, shared.bench_file.boards, "boards")
        raise UsageError(f"no board '{board}' on this bench", where=choices[0].where, hint=hint)
    return _rover_at(shared, choices[0].spec) if protocol == "PKT!" else AttachedProvider(shared, choices[0].spec)


def _first(choices: Sequence[TargetChoice], targets: Sequence[Target], kinds: Collection[TargetKind]) -> TargetChoice:
    return next(choice for choice, target in zip(choices, targets, strict=True) if target.kind in kinds)


def _emulated(shared: Shared, choices: Sequence[TargetChoice]) -> BenchProvider:
    from hilbench.mcu.board_provider import BoardProvider

    return BoardProvider(shared, choices)
