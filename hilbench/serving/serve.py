"""`hilbench serve`: a virtual target behind real doors, in real time, until it is told to stop."""

from __future__ import annotations

import contextlib
import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial

from hilbench.bench import Bench
from hilbench.bench.line_faults import describe_faults
from hilbench.bench.served_targets import ServedTarget
from hilbench.benchfile.reader import BenchFile
from hilbench.clock import Scheduler
from hilbench.errors import UsageError
from hilbench.exit_codes import ExitCode
from hilbench.journal import Journal
from hilbench.links import Line, MemoryLink, Port, PtyDoor
from hilbench.nearest import did_you_mean
from hilbench.serving import (
    AnyDoor,
    Notice,
    Say,
    door_option,
    no_topics,
    open_door,
    place,
    run_until_stopped,
    signals_held,
    traffic,
)
from hilbench.serving.bench_faults import with_faults
from hilbench.serving.doors import LastingLine, SharedDoor
from hilbench.serving.served_model import served_target
from hilbench.terminal.options import Clients, DoorWish, ServeOptions


def serve(options: ServeOptions, bench_file: BenchFile, say: Say) -> ExitCode:
    """Serve until interrupted.

    Args:
        options: doors, scene, seed, speed of the line.
        bench_file: what to serve.
        say: takes lines meant for a person; it must never wait for that person, the robot would stand still.

    Returns:
        OK: being interrupted is how serving ends, from the moment this function is entered.

    Raises:
        UsageError: no door, one that leads nowhere, or a scene that does not exist.
        UnavailableError: a door cannot be opened, the physics is missing, or the journal can no longer be written.
    """
    if not options.doors:
        raise UsageError("no endpoint", where="hilbench serve", hint="add --pty PATH, --tcp PORT or --rfc2217 PORT")
    target = _target(options, bench_file, say)
    if target.one_client and options.clients is Clients.ALL:
        options = replace(options, clients=Clients.FIRST)
    wishes = _assigned(options, bench_file, tuple(target.lines), apart=target.one_client)
    # What is half built or half gone cannot be cleaned up: a signal waits until the robot runs, or until all is gone.
    with signals_held(), contextlib.ExitStack() as stack:
        scheduler = Scheduler()
        doors = {
            line: stack.enter_context(_doors(options, wishes.get(line, ()), scheduler, baud))
            for line, baud in target.lines.items()
        }
        journal = Journal(options.journal, bench_file.header(options.seed), max_bytes=options.journal_max)
        bench = Bench(scheduler, journal)
        stack.callback(lambda: journal.close(bench.now_ns))
        outside = {line: _port(bench, line, there, target.lines[line], options) for line, there in doors.items()}
        ports = {line: LastingLine(port) for line, port in outside.items()} if options.ignore_hangup else outside
        faulty = with_faults(
            bench,
            ports,
            bench_file,
            seed=options.seed,
            on_refused=lambda text: say(f"{bench.now_s:10.3f} s  {text}"),
        )
        stack.callback(target.make(bench, faulty))
        if target.source:
            for line, port in faulty.items():
                about = {"line": line.rpartition(".")[2]} if len(faulty) > 1 else {}
                _record_received(bench, target.source, port, **about)
        for line, there in doors.items():
            _announce(bench, there, outside[line], say, line if len(doors) > 1 else "", options)
        for line in (line for line, there in doors.items() if not there and not target.may_be_open):
            end = line.rpartition(".")[2]
            say(f"{line} is connected to nothing; add --pty {end}=PATH or --tcp {end}=PORT")
        if bench_file.faults:
            lines = "lines" if len(doors) > 1 else "line"
            say(f"faults on the {lines}: {describe_faults(bench_file.faults)}")
        opened = [*itertools.chain.from_iterable(doors.values())]
        run_until_stopped(scheduler, say, notice=Notice(doors=opened))
        for door in opened:
            say(traffic(door))
    return ExitCode.OK


def _target(options: ServeOptions, bench_file: BenchFile, say: Say) -> ServedTarget:
    target = served_target(bench_file, scene=options.scene, baud=options.baud, seed=options.seed)
    if options.dds is None:
        return target
    if target.in_dds is None:
        raise no_topics()
    return target.in_dds(options.dds, say)


def _assigned(
    options: ServeOptions, bench_file: BenchFile, lines: Sequence[str], *, apart: bool
) -> Mapping[str, Sequence[DoorWish]]:
    """Return the doors of each line; where there is one alone, all doors are its."""
    if len(lines) > 1:
        from hilbench.serving.usart_doors import assign

        return assign(options, lines, apart=apart)
    _check_links(options, bench_file)
    return {lines[0]: options.doors}


def _check_links(options: ServeOptions, bench_file: BenchFile) -> None:
    """Make sure that a door which says where it leads means the robot's line, which is the only one."""
    known = [end for name in bench_file.targets for end in (name, f"{name}.host")]
    for wish in options.doors:
        if wish.link and wish.link not in known:
            where = f"{door_option(wish)} {wish.link}="
            raise UsageError(f"no line '{wish.link}'", where=where, hint=did_you_mean(wish.link, known, "lines"))


@contextlib.contextmanager
def _doors(
    options: ServeOptions, wishes: Sequence[DoorWish], scheduler: Scheduler, baud: int
) -> Iterator[Sequence[AnyDoor]]:
    with contextlib.ExitStack() as stack:
        yield [
            stack.enter_context(
                contextlib.closing(
                    open_door(
                        wish,
                        scheduler,
                        Line(baud=baud),
                        any_baud=options.any_baud,
                        clients=options.clients,
                        hangs_up=not options.ignore_hangup,
                    )
                )
            )
            for wish in wishes
        ]


def _port(bench: Bench, line: str, doors: Sequence[AnyDoor], baud: int, options: ServeOptions) -> Port:
    """Return the robot's end of a line, with these doors at the far end; without one it leads nowhere."""
    if not doors:
        return MemoryLink(bench.scheduler, Line(baud=baud), name=line).b
    return doors[0] if len(doors) == 1 else SharedDoor(doors, options.clients)


def _record_received(bench: Bench, name: str, port: Port, **about: str) -> None:
    """Have what a client sends in the journal, too, for whoever judges it or plays it again."""
    to_target = port.on_receive

    def received(data: bytes, at_ns: int) -> None:
        bench.record("rx", name, **about, data=data)
        to_target(data, at_ns)

    port.on_receive = received


def _announce(bench: Bench, doors: Sequence[AnyDoor], port: Port, say: Say, line: str, options: ServeOptions) -> None:
    """Tell where the doors are and who comes and goes; `line` is its name where there are several."""
    to_robot = port.on_line
    left = "left; the target is not notified" if options.ignore_hangup else "left"
    at, serving = (f"{line}: ", f"serving {line} at") if line else ("", "serving at")

    def line_changed(up: bool, at_ns: int) -> None:
        say(f"{bench.now_s:10.3f} s  {at}a client {'came' if up else left}")
        to_robot(up, at_ns)

    def garbled(door: AnyDoor, client_baud: int) -> None:
        say(
            f"{bench.now_s:10.3f} s  the client set {client_baud} baud, the target listens at {door.baud}; "
            f"bytes are garbled as on a real line; --any-baud or --baud {client_baud}"
        )

    def visited(door: AnyDoor, text: str) -> None:
        say(f"{bench.now_s:10.3f} s  {at}{place(door)}: {text}")

    port.on_line = line_changed
    for door in doors:
        door.on_visit = partial(visited, door)
        door.on_garbled = partial(garbled, door)
        if isinstance(door, PtyDoor):
            say(f"{serving} {place(door)} ({door.slave_name}), {door.baud} baud")
        else:
            say(f"{serving} {place(door)}, paced as {door.baud} baud")
