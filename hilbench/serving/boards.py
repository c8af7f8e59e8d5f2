"""`hilbench serve BOARD:IMAGE`: each USART of an emulated board behind a door of its own, in real time.

So are the lines of models beside boards that lead to ``peer`` or ``peer.LINE``.
"""

from __future__ import annotations

import contextlib
import dataclasses
from collections.abc import Iterator, Mapping, Sequence

import msgspec

from hilbench.benchfile.bench_file import BenchFile, is_checker_end
from hilbench.errors import UsageError
from hilbench.exit_codes import ExitCode
from hilbench.files import Named, refuse_writing_into
from hilbench.links import PtyDoor
from hilbench.mcu.emulated import EmulatedBench, MachineFactory, make_machine
from hilbench.mcu.group import LOCKED_STEP_NS
from hilbench.serving import AnyDoor, Notice, Say, no_topics, place, run_until_stopped, signals_held, traffic
from hilbench.serving.usart_doors import assign, connect, connect_model, open_doors
from hilbench.terminal.options import Clients, DoorWish, ServeOptions
from hilbench.terminal.options import PtyDoor as PtyWish

__all__ = ["free_usarts", "serve_boards", "usual_usarts"]


def serve_boards(
    options: ServeOptions, bench_file: BenchFile, say: Say, *, make_machine: MachineFactory = make_machine
) -> ExitCode:
    """Serve until interrupted, or until the firmware has come to its end.

    Args:
        options: doors, seed, speed of the lines.
        bench_file: what to serve.
        say: takes lines meant for a person; it must never wait for that person, the boards would stand still.
        make_machine: makes the chips.

    Returns:
        OK: being interrupted is how serving ends. VIOLATION if the firmware cannot run on.

    Raises:
        UsageError: a door for a USART that is not there; an image that cannot run on its board.
        UnavailableError: an image, the engine or the physics is missing; a door cannot be opened.
    """
    if options.dds is not None:
        raise no_topics()
    if options.scene is not None and not bench_file.has_world:
        raise UsageError("no target of this bench has a world", where=f"--scene {options.scene}")
    models = bench_file.served_lines
    one_each = Clients.FIRST if options.clients is Clients.ALL else options.clients
    of_models = dataclasses.replace(options, clients=one_each)
    assigned = assign(options, [*free_usarts(bench_file), *models], [*usual_usarts(bench_file), *models])
    refuse_writing_into([("--journal", options.journal)], _unasked_doors(options, assigned))
    with signals_held(), contextlib.ExitStack() as stack:
        emulated = EmulatedBench(
            _with_scene(bench_file, options.scene), seed=options.seed, step_ns=LOCKED_STEP_NS, make_machine=make_machine
        )
        stack.callback(emulated.close)
        emulated.far_ends.tell_of_refusals(say)
        served: list[AnyDoor] = []
        for name, wishes in assigned.items():
            if options.baud is not None and name not in models:
                emulated.ports[name].baud = options.baud
            opened = open_doors(emulated, name, wishes, of_models if name in models else options)
            doors = [stack.enter_context(contextlib.closing(door)) for door in opened]
            if name in models:
                connect_model(emulated, name, doors, say, of_models)
            else:
                connect(emulated, name, doors, say, options.clients)
            for door in doors:
                say(_announcement(name, door, follows=options.baud is None and name not in models))
            served += doors
        if options.journal is not None:
            emulated.write_journal(options.journal, options.journal_max)
        notice = Notice(doors=served, step_ns=LOCKED_STEP_NS)
        run_until_stopped(emulated.bench.scheduler, say, lambda: emulated.end is not None, notice=notice, computes=True)
        for door in served:
            say(traffic(door))
        if emulated.end is not None:
            say(f"hilbench: {emulated.end}")
    return ExitCode.OK if emulated.end is None or emulated.end.good else ExitCode.VIOLATION


def _with_scene(bench_file: BenchFile, scene: str | None) -> BenchFile:
    if scene is None:
        return bench_file
    return dataclasses.replace(bench_file, world=msgspec.structs.replace(bench_file.world, scene=scene))


def _unasked_doors(options: ServeOptions, assigned: Mapping[str, Sequence[DoorWish]]) -> Iterator[Named]:
    """Yield the doors that nobody has named, by whose they are."""
    if not options.doors:
        for name, wishes in assigned.items():
            yield from ((f"the line of {name}", wish.path) for wish in wishes if isinstance(wish, PtyWish))


def free_usarts(bench_file: BenchFile) -> list[str]:
    """Return the USARTs that are not linked to anything on the bench."""
    linked = {end for link in bench_file.links if not any(map(is_checker_end, link.ends)) for end in link.ends}
    names = [f"{name}.{usart.lower()}" for name, board in bench_file.boards.items() for usart in board.board.usarts]
    return [name for name in names if name not in linked]


def usual_usarts(bench_file: BenchFile) -> list[str]:
    """Return those that are served without being named: of a board with a console the console, else each."""
    consoles = {name: board.board.console.lower() for name, board in bench_file.boards.items() if board.board.console}
    return [
        full
        for full in free_usarts(bench_file)
        if (board := full.partition(".")[0]) not in consoles or full == f"{board}.{consoles[board]}"
    ]


def _announcement(name: str, door: AnyDoor, *, follows: bool) -> str:
    rate = "at the rate the firmware sets" if follows else f"{door.baud} baud"
    at = f"{place(door)} ({door.slave_name})" if isinstance(door, PtyDoor) else place(door)
    return f"serving {name} at {at}, {rate}"
