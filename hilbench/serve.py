"""`hilbench serve`: a virtual target behind real doors, in real time, until it is told to stop."""

from __future__ import annotations

import contextlib
import itertools
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

from hilbench.bench import Bench
from hilbench.clock import Scheduler
from hilbench.config import BenchFile
from hilbench.devices import DeviceActor, LinesActor
from hilbench.doors import SharedDoor
from hilbench.errors import UnavailableError, UsageError
from hilbench.exit_codes import ExitCode
from hilbench.journal import Journal
from hilbench.line_faults import LineFaults, describe_faults
from hilbench.links import Line, MemoryLink, Port, PtyDoor, TcpDoor
from hilbench.nearest import did_you_mean
from hilbench.options import PtyDoor as PtyWish
from hilbench.options import ServeOptions
from hilbench.options import TcpDoor as TcpWish
from hilbench.pioneer import PioneerPlan, VirtualPioneer, plan_of
from hilbench.rover_cases import rover_baud
from hilbench.serving import AnyDoor, Say, place, run_until_stopped, signals_held, traffic
from hilbench.vehicle_cases import line_baud
from targets.robots.rover import RoverRobot
from targets.robots.vehicle_interface import SIMULATOR_LINE, STACK_LINE, VehicleInterface
from worlds.errors import WorldError

_HOST = "host"
"""The line of a robot that has one alone."""


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
    if not options.ptys and not options.tcps:
        raise UsageError("no door", where="hilbench serve", hint="add --pty PATH or --tcp PORT")
    target = _target(options, bench_file)
    wishes = _assigned(options, bench_file, tuple(target.lines))
    # What is half built or half gone cannot be cleaned up: a signal waits until the robot runs, or until all is gone.
    with signals_held(), contextlib.ExitStack() as stack:
        scheduler = Scheduler()
        doors = {
            line: stack.enter_context(_doors(options, wishes.get(line, ()), scheduler, baud))
            for line, baud in target.lines.items()
        }
        journal = Journal(options.journal, bench_file.header(options.seed))
        bench = Bench(scheduler, journal)
        stack.callback(lambda: journal.close(bench.now_ns))
        ports = {line: _port(bench, line, there, target.lines[line]) for line, there in doors.items()}
        stack.callback(
            target.make(bench, {line: _faulty(bench, port, options, bench_file) for line, port in ports.items()})
        )
        for line, there in doors.items():
            _announce(bench, there, ports[line], say, line if len(doors) > 1 else "")
        if bench_file.faults:
            say(f"faults on the line: {describe_faults(bench_file.faults)}")
        run_until_stopped(scheduler, say)
        for door in itertools.chain.from_iterable(doors.values()):
            say(traffic(door))
    return ExitCode.OK


def _assigned(
    options: ServeOptions, bench_file: BenchFile, lines: Sequence[str]
) -> Mapping[str, Sequence[PtyWish | TcpWish]]:
    """Return the doors of each line; where there is one alone, all doors are its."""
    if len(lines) > 1:
        from hilbench.mcu.doors import assign

        return assign(options, lines)
    _check_links(options, bench_file)
    return {lines[0]: [*options.ptys, *options.tcps]}


def _check_links(options: ServeOptions, bench_file: BenchFile) -> None:
    """Make sure that a door which says where it leads means the robot's line, which is the only one."""
    known = [end for name in bench_file.targets for end in (name, f"{name}.host")]
    asked = [("--pty", pty.link) for pty in options.ptys] + [("--tcp", tcp.link) for tcp in options.tcps]
    for option, link in asked:
        if link and link not in known:
            raise UsageError(f"no line '{link}'", where=f"{option} {link}=", hint=did_you_mean(link, known, "lines"))


@dataclass(frozen=True, slots=True)
class _Target:
    """What is served: the rates of its lines, and what brings it to life at their ends and returns how to end it."""

    lines: Mapping[str, int]
    make: Callable[[Bench, Mapping[str, Port]], Callable[[], None]]


def _target(options: ServeOptions, bench_file: BenchFile) -> _Target:
    if bench_file.vehicle is not None:
        return _vehicle(options, bench_file)
    return _rover(options, bench_file) if bench_file.rover is not None else _pioneer(options, bench_file)


def _pioneer(options: ServeOptions, bench_file: BenchFile) -> _Target:
    plan = _plan(options, bench_file)

    def make(bench: Bench, ports: Mapping[str, Port]) -> Callable[[], None]:
        try:
            return VirtualPioneer(bench, ports[_HOST], plan, seed=options.seed).close
        except WorldError as error:
            raise UnavailableError(str(error), where=f"scene {plan.scene}") from error

    return _Target({_HOST: plan.settings.host_baud}, make)


def _vehicle(options: ServeOptions, bench_file: BenchFile) -> _Target:
    _refuse_scene(options)
    settings = bench_file.vehicle
    assert settings is not None
    name = next(name for name, target in bench_file.targets.items() if target.settings is settings)

    def make(bench: Bench, ports: Mapping[str, Port]) -> Callable[[], None]:
        ends = {end.rpartition(".")[2]: port for end, port in ports.items()}
        LinesActor(bench, VehicleInterface(settings, power_on_ns=bench.now_ns), ends, name="board")
        return lambda: None

    lines = (SIMULATOR_LINE, STACK_LINE)
    return _Target({f"{name}.{line}": options.baud or line_baud(bench_file, line) for line in lines}, make)


def _rover(options: ServeOptions, bench_file: BenchFile) -> _Target:
    _refuse_scene(options)
    settings = bench_file.rover
    assert settings is not None

    def make(bench: Bench, ports: Mapping[str, Port]) -> Callable[[], None]:
        DeviceActor(bench, RoverRobot(settings), ports[_HOST], name="rover")
        return lambda: None

    return _Target({_HOST: options.baud or rover_baud(bench_file)}, make)


def _refuse_scene(options: ServeOptions) -> None:
    if options.scene is not None:
        raise UsageError("nothing stands in a world here", where=f"--scene {options.scene}")


def _plan(options: ServeOptions, bench_file: BenchFile) -> PioneerPlan:
    plan = plan_of(bench_file)
    if options.scene is not None:
        plan = replace(plan, scene=options.scene)
    if options.baud is not None:
        try:
            plan = replace(plan, settings=replace(plan.settings, host_baud=options.baud))
        except ValueError as error:
            raise UsageError(str(error), where=f"--baud {options.baud}") from None
    return plan


@contextlib.contextmanager
def _doors(
    options: ServeOptions, wishes: Sequence[PtyWish | TcpWish], scheduler: Scheduler, baud: int
) -> Iterator[Sequence[AnyDoor]]:
    line = Line(baud=baud)
    doors: list[AnyDoor] = []
    with contextlib.ExitStack() as stack:
        for wish in wishes:
            if isinstance(wish, PtyWish):
                door: AnyDoor = PtyDoor(scheduler, wish.path, line, any_baud=options.any_baud, name=f"pty:{wish.path}")
            else:
                host = f"[{wish.host}]" if ":" in wish.host else wish.host
                door = TcpDoor(scheduler, f"{host}:{wish.port}", line, name=f"tcp:{wish.port}")
            doors.append(stack.enter_context(contextlib.closing(door)))
        yield doors


def _port(bench: Bench, line: str, doors: Sequence[AnyDoor], baud: int) -> Port:
    """Return the robot's end of a line, with these doors at the far end; without one it leads nowhere."""
    if not doors:
        return MemoryLink(bench.scheduler, Line(baud=baud), name=line).b
    return doors[0] if len(doors) == 1 else SharedDoor(doors)


def _faulty(bench: Bench, port: Port, options: ServeOptions, bench_file: BenchFile) -> Port:
    """Return the robot's end of the line, with the faults of the bench file on it."""
    if not bench_file.faults:
        return port
    return LineFaults(bench, bench_file.faults, seed=options.seed, near_is_client=False).on(port)


def _announce(bench: Bench, doors: Sequence[AnyDoor], port: Port, say: Say, line: str) -> None:
    """Tell where the doors are and who comes and goes; `line` is its name where there are several."""
    to_robot = port.on_line
    at, serving = (f"{line}: ", f"serving {line} at") if line else ("", "serving at")

    def line_changed(up: bool, at_ns: int) -> None:
        say(f"{bench.now_s:10.3f} s  {at}a client {'came' if up else 'left'}")
        to_robot(up, at_ns)

    def garbled(door: PtyDoor, client_baud: int) -> None:
        say(
            f"{bench.now_s:10.3f} s  the client set {client_baud} baud, the robot listens at {door.baud}; "
            f"bytes are garbled as on a real line; --any-baud or --baud {client_baud}"
        )

    port.on_line = line_changed
    for door in doors:
        if isinstance(door, PtyDoor):
            door.on_garbled = partial(garbled, door)
            say(f"{serving} {place(door)} ({door.slave_name}), {door.baud} baud")
        else:
            say(f"{serving} {place(door)}, paced as {door.baud} baud")
