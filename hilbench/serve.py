"""`hilbench serve`: a virtual target behind real doors, in real time, until it is told to stop."""

from __future__ import annotations

import contextlib
import signal
from collections.abc import Callable, Iterator
from dataclasses import replace

from hilbench.bench import Bench
from hilbench.clock import MonotonicHostClock, Scheduler, deferred_interrupts
from hilbench.config import BenchFile
from hilbench.doors import SharedDoor
from hilbench.errors import UnavailableError, UsageError
from hilbench.exit_codes import ExitCode
from hilbench.journal import Journal
from hilbench.links import Line, Port, PtyDoor, TcpDoor
from hilbench.options import ServeOptions
from hilbench.pioneer import PioneerPlan, VirtualPioneer, plan_of
from worlds.errors import WorldError

Say = Callable[[str], None]


def serve(options: ServeOptions, bench_file: BenchFile, say: Say) -> ExitCode:
    """Serve until interrupted.

    Args:
        options: doors, scene, seed, speed of the line.
        bench_file: what to serve.
        say: takes lines meant for a person.

    Returns:
        OK: being interrupted is how serving ends.

    Raises:
        UsageError: no door, or a scene that does not exist.
        UnavailableError: a door cannot be opened, or the physics is missing.
    """
    if not options.ptys and not options.tcps:
        raise UsageError("no door", where="hilbench serve", hint="add --pty PATH or --tcp PORT")
    plan = _plan(options, bench_file)
    with contextlib.ExitStack() as stack:
        journal = Journal(options.journal, {"seed": options.seed, "bench": bench_file.name})
        scheduler = Scheduler()
        bench = Bench(scheduler, journal)
        stack.callback(lambda: journal.close(bench.now_ns))
        port = stack.enter_context(_doors(options, scheduler, plan, say))
        try:
            pioneer = VirtualPioneer(bench, port, plan, seed=options.seed)
        except WorldError as error:
            raise UnavailableError(str(error), where=f"scene {plan.scene}") from error
        stack.callback(pioneer.close)
        _announce_clients(bench, port, say)
        _run(scheduler, say)
    return ExitCode.OK


def _plan(options: ServeOptions, bench_file: BenchFile) -> PioneerPlan:
    plan = plan_of(bench_file)
    if options.scene is not None:
        plan = replace(plan, scene=options.scene)
    if options.baud is not None:
        plan = replace(plan, settings=replace(plan.settings, host_baud=options.baud))
    return plan


@contextlib.contextmanager
def _doors(options: ServeOptions, scheduler: Scheduler, plan: PioneerPlan, say: Say) -> Iterator[Port]:
    line = Line(baud=plan.settings.host_baud)
    doors: list[Port] = []
    try:
        for pty in options.ptys:
            pty_door = PtyDoor(scheduler, pty.path, line, any_baud=options.any_baud, name=f"pty:{pty.path}")
            doors.append(pty_door)
            say(f"serving at {pty.path} ({pty_door.slave_name}), {line.baud} baud")
        for tcp in options.tcps:
            host = f"[{tcp.host}]" if ":" in tcp.host else tcp.host
            tcp_door = TcpDoor(scheduler, f"{host}:{tcp.port}", line)
            doors.append(tcp_door)
            say(f"serving at tcp {tcp_door.host}:{tcp_door.port}, paced as {line.baud} baud")
        yield doors[0] if len(doors) == 1 else SharedDoor(doors)
    finally:
        for door in doors:
            door.close()


def _announce_clients(bench: Bench, port: Port, say: Say) -> None:
    to_robot = port.on_line

    def line_changed(up: bool, at_ns: int) -> None:
        say(f"{bench.now_s:10.3f} s  a client {'came' if up else 'left'}")
        to_robot(up, at_ns)

    port.on_line = line_changed


def _run(scheduler: Scheduler, say: Say) -> None:
    host = MonotonicHostClock()
    scheduler.lock(host)
    say("stop with Ctrl-C")
    try:
        with deferred_interrupts(scheduler, (signal.SIGINT, signal.SIGTERM)):
            scheduler.run_until(None, None)
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
