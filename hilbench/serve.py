"""`hilbench serve`: a virtual target behind real doors, in real time, until it is told to stop."""

from __future__ import annotations

import contextlib
import signal
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial

from hilbench.bench import Bench
from hilbench.clock import MonotonicHostClock, Scheduler, deferred_interrupts
from hilbench.config import BenchFile
from hilbench.doors import SharedDoor
from hilbench.errors import UnavailableError, UsageError
from hilbench.exit_codes import ExitCode
from hilbench.journal import Journal
from hilbench.line_faults import LineFaults, describe_faults
from hilbench.links import Line, Port, PtyDoor, TcpDoor
from hilbench.options import ServeOptions
from hilbench.pioneer import PioneerPlan, VirtualPioneer, plan_of
from worlds.errors import WorldError

Say = Callable[[str], None]

STOP_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


def serve(options: ServeOptions, bench_file: BenchFile, say: Say) -> ExitCode:
    """Serve until interrupted.

    Args:
        options: doors, scene, seed, speed of the line.
        bench_file: what to serve.
        say: takes lines meant for a person; it must never wait for that person, the robot would stand still.

    Returns:
        OK: being interrupted is how serving ends, from the moment this function is entered.

    Raises:
        UsageError: no door, or a scene that does not exist.
        UnavailableError: a door cannot be opened, the physics is missing, or the journal can no longer be written.
    """
    if not options.ptys and not options.tcps:
        raise UsageError("no door", where="hilbench serve", hint="add --pty PATH or --tcp PORT")
    plan = _plan(options, bench_file)
    # What is half built or half gone cannot be cleaned up: a signal waits until the robot runs, or until all is gone.
    with _signals_held(), contextlib.ExitStack() as stack:
        scheduler = Scheduler()
        doors = stack.enter_context(_doors(options, scheduler, plan))
        port = doors[0] if len(doors) == 1 else SharedDoor(doors)
        journal = Journal(options.journal, bench_file.header(options.seed))
        bench = Bench(scheduler, journal)
        stack.callback(lambda: journal.close(bench.now_ns))
        try:
            pioneer = VirtualPioneer(bench, _faulty(bench, port, options, bench_file), plan, seed=options.seed)
        except WorldError as error:
            raise UnavailableError(str(error), where=f"scene {plan.scene}") from error
        stack.callback(pioneer.close)
        _announce(bench, doors, port, say)
        if bench_file.faults:
            say(f"faults on the line: {describe_faults(bench_file.faults)}")
        _run(scheduler, say)
        for door in doors:
            say(_traffic(door))
    return ExitCode.OK


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
def _signals_held() -> Iterator[None]:
    """Keep the signals that end serving waiting; one that came meanwhile is taken to have been heard."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, STOP_SIGNALS)
    handlers = {number: signal.getsignal(number) for number in STOP_SIGNALS}
    try:
        yield
    finally:
        for number in STOP_SIGNALS:
            signal.signal(number, signal.SIG_IGN)  # forgets one that waits
            signal.signal(number, handlers[number])
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextlib.contextmanager
def _doors(options: ServeOptions, scheduler: Scheduler, plan: PioneerPlan) -> Iterator[Sequence[PtyDoor | TcpDoor]]:
    line = Line(baud=plan.settings.host_baud)
    doors: list[PtyDoor | TcpDoor] = []
    with contextlib.ExitStack() as stack:
        for pty in options.ptys:
            pty_door = PtyDoor(scheduler, pty.path, line, any_baud=options.any_baud, name=f"pty:{pty.path}")
            doors.append(stack.enter_context(contextlib.closing(pty_door)))
        for tcp in options.tcps:
            host = f"[{tcp.host}]" if ":" in tcp.host else tcp.host
            tcp_door = TcpDoor(scheduler, f"{host}:{tcp.port}", line, name=f"tcp:{tcp.port}")
            doors.append(stack.enter_context(contextlib.closing(tcp_door)))
        yield doors


def _faulty(bench: Bench, port: Port, options: ServeOptions, bench_file: BenchFile) -> Port:
    """Return the robot's end of the line, with the faults of the bench file on it."""
    if not bench_file.faults:
        return port
    return LineFaults(bench, bench_file.faults, seed=options.seed, near_is_client=False).on(port)


def _announce(bench: Bench, doors: Sequence[PtyDoor | TcpDoor], port: Port, say: Say) -> None:
    to_robot = port.on_line

    def line_changed(up: bool, at_ns: int) -> None:
        say(f"{bench.now_s:10.3f} s  a client {'came' if up else 'left'}")
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
            say(f"serving at {_place(door)} ({door.slave_name}), {door.baud} baud")
        else:
            say(f"serving at {_place(door)}, paced as {door.baud} baud")


def _run(scheduler: Scheduler, say: Say) -> None:
    host = MonotonicHostClock()
    scheduler.lock(host)
    say("stop with Ctrl-C")
    try:
        with deferred_interrupts(scheduler, STOP_SIGNALS):
            try:
                signal.pthread_sigmask(signal.SIG_UNBLOCK, STOP_SIGNALS)
                scheduler.run_until(None, None)
            finally:
                signal.pthread_sigmask(signal.SIG_BLOCK, STOP_SIGNALS)
    except KeyboardInterrupt:
        late = scheduler.lateness
        say(
            f"stopped after {scheduler.now_ns / 1e9:.1f} s at {scheduler.real_time_factor or 0:.3f} x real time; "
            f"lateness p50 {late.quantile_ns(0.5) / 1e6:.2f} ms, p99 {late.quantile_ns(0.99) / 1e6:.2f} ms, "
            f"max {late.max_ns / 1e6:.2f} ms, {scheduler.slips} slips"
        )
    finally:
        scheduler.unlock()
        host.close()


def _place(door: PtyDoor | TcpDoor) -> str:
    return str(door.path) if isinstance(door, PtyDoor) else f"tcp {door.host}:{door.port}"


def _traffic(door: PtyDoor | TcpDoor) -> str:
    counted = door.counters
    text = f"{_place(door)}: {counted.received} bytes in, {counted.sent} out"
    if dropped := counted.lost + counted.overruns:
        text += f", {dropped} of them dropped: nobody read"
    if counted.refused:
        text += f"; {counted.refused} clients turned away"
    if counted.framing_errors:
        text += f"; {counted.framing_errors} framing errors"
    return text
