"""Which of several targets is meant, and what is refused before anything is opened: the words that systems share."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from hilbench.bench.locked_providers import ExecProvider, FarEnd, ListenProvider
from hilbench.bench.shared import Shared
from hilbench.benchfile.target_grammar import TargetKind, target_of
from hilbench.errors import UsageError
from hilbench.judging.provider import BenchProvider
from hilbench.nearest import did_you_mean
from hilbench.terminal.options import TargetChoice

__all__ = ["CLIENTS", "cannot_be", "client_provider", "first_of", "only_choice", "only_port", "port_of_boards"]

CLIENTS = frozenset({TargetKind.LISTEN, TargetKind.EXEC})
"""A client under test."""


def first_of(choices: Sequence[TargetChoice], kinds: Collection[TargetKind]) -> TargetChoice:
    """Return the first choice of one of these kinds, which there has to be."""
    return next(choice for choice in choices if target_of(choice).kind in kinds)


def only_choice(shared: Shared, choices: Sequence[TargetChoice]) -> TargetChoice:
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


def only_port(shared: Shared, choices: Sequence[TargetChoice]) -> TargetChoice:
    """Return the port that is chosen for a bench with one line.

    Raises:
        UsageError: there are several, or something else is chosen.
    """
    choice = only_choice(shared, choices)
    if target_of(choice).kind is not TargetKind.SERIAL:
        raise cannot_be(shared, choice, "write serial:PORT@BAUD or a pyserial URL")
    return choice


def port_of_boards(shared: Shared, choices: Sequence[TargetChoice]) -> TargetChoice | None:
    """Return the port that is chosen in the place of a bench of boards with one line; None if no port is.

    Raises:
        UsageError: something else is chosen beside it, or it is for a board that is not there.
    """
    kinds = {target_of(choice).kind for choice in choices}
    if TargetKind.SERIAL not in kinds:
        return None
    if len(choices) > 1:
        where = first_of(choices, {TargetKind.SERIAL}).where
        raise UsageError("a board at a port stands for the whole bench", where=where, hint="name only that")
    board, boards = choices[0].name.partition(".")[0], shared.bench_file.boards
    if board and board not in boards:
        hint = did_you_mean(board, boards, "boards")
        raise UsageError(f"no board '{board}' on this bench", where=choices[0].where, hint=hint)
    return choices[0]


def client_provider(shared: Shared, choice: TargetChoice, far_end: FarEnd, own: str) -> BenchProvider:
    """Return the provider for a client that somebody else wrote.

    Args:
        shared: bench file, journal, waiting.
        choice: the client.
        far_end: what it finds at the far end of its line.
        own: the target that is the bench's own, for the message.

    Raises:
        UsageError: no client is chosen.
    """
    target = target_of(choice)
    if target.kind is TargetKind.LISTEN:
        return ListenProvider(shared, target.rest, far_end)
    if target.kind is TargetKind.EXEC:
        return ExecProvider(shared, target.rest, far_end)
    hint = f"write {own}, serial:PORT@BAUD, a pyserial URL, listen:pty:PATH, listen:tcp:PORT or exec:COMMAND"
    raise cannot_be(shared, choice, hint)


def cannot_be(shared: Shared, choice: TargetChoice, hint: str) -> UsageError:
    """Return the error for a target of a kind that a bench cannot have."""
    kind = target_of(choice).kind.value
    return UsageError(f"{kind} cannot be the target of bench '{shared.bench_file.name}'", where=choice.where, hint=hint)
