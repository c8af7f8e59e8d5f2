"""What serving has in common, whatever is served: signals, the run until somebody stops it, words about doors."""

from __future__ import annotations

import contextlib
import signal
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from hilbench.clock import MonotonicHostClock, Scheduler, deferred_interrupts
from hilbench.clock.precedence import OF_A_BENCH, freeze_memory, take_precedence
from hilbench.clock.text import seconds_text
from hilbench.errors import UnavailableError, UsageError
from hilbench.links import Line, PtyDoor, Rfc2217Door, TcpDoor
from hilbench.links.uart import Timeline
from hilbench.pace.far_pace import place_of, tcp_place
from hilbench.pace.notice import PaceNotice
from hilbench.pace.slips import SlipsSaid
from hilbench.terminal import own_process
from hilbench.terminal.options import Clients, DoorWish
from hilbench.terminal.options import PtyDoor as PtyWish
from hilbench.terminal.options import Rfc2217Door as Rfc2217Wish

__all__ = [
    "STOP_SIGNALS",
    "AnyDoor",
    "Notice",
    "Say",
    "door_option",
    "no_topics",
    "open_door",
    "place",
    "run_until_stopped",
    "signals_held",
    "traffic",
]

Say = Callable[[str], None]
AnyDoor = PtyDoor | TcpDoor

STOP_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


@contextlib.contextmanager
def signals_held() -> Iterator[None]:
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


@dataclass(frozen=True, slots=True, kw_only=True)
class Notice:
    """What whoever checks at a door of ours has to know of the bench behind it; see `hilbench.pace.notice`.

    Attributes:
        doors: the doors that lead to it.
        behind: paths and URLs of the ports that it has opened itself, to hand on what passes.
        step_ns: how far it runs ahead of the host's clock.
    """

    doors: Sequence[AnyDoor] = ()
    behind: Sequence[str] = ()
    step_ns: int = 0

    def __add__(self, other: Notice) -> Notice:
        """Return that of a bench that has the doors and ports of both."""
        doors, behind = (*self.doors, *other.doors), (*self.behind, *other.behind)
        return Notice(doors=doors, behind=behind, step_ns=max(self.step_ns, other.step_ns))


def run_until_stopped(
    scheduler: Scheduler,
    say: Say,
    condition: Callable[[], bool] | None = None,
    *,
    notice: Notice = Notice(),
    computes: bool = False,
) -> None:
    """Run in real time until a signal comes, or `condition` holds; then say how well the host kept up.

    Args:
        scheduler: what runs.
        say: takes lines meant for a person.
        condition: ends the run when it holds; None for never.
        notice: where others find, meanwhile, how well the host keeps up.
        computes: it may need a processor all the time. Then it is not run before other programs of this host, which it
            would keep from running, and would be late all the same.
    """
    with contextlib.ExitStack() as stack:
        if own_process.is_ours():
            freeze_memory()
            if not computes:
                take_precedence(OF_A_BENCH)
        host = MonotonicHostClock()
        stack.callback(host.close)
        now_ns = host.monotonic_ns()
        notifying = _notifying(notice, now_ns, say, stack)
        slips = SlipsSaid(lambda text: say(f"{scheduler.now_ns / 1e9:10.3f} s  {text}"), now_ns, notifying)
        scheduler.lock(host, listener=slips)
        stack.callback(scheduler.unlock)
        _run_until_stopped(scheduler, say, condition)


def _notifying(notice: Notice, now_ns: int, say: Say, stack: contextlib.ExitStack) -> PaceNotice | None:
    """Return the file that tells others; None if there is no place for it."""
    for number, door in enumerate(notice.doors):
        door.number = number
    places = [_place_of(door) for door in notice.doors]
    try:
        return stack.enter_context(PaceNotice(now_ns, places, behind=notice.behind, step_ns=notice.step_ns))
    except (OSError, UnavailableError) as error:
        say(f"a check at these endpoints is not notified how late this bench is: {error}")
        return None


def _place_of(door: AnyDoor) -> str:
    """Return the place of a door, as whoever opens it finds it."""
    place = place_of(door.slave_name) if isinstance(door, PtyDoor) else tcp_place(door.port)
    assert place is not None
    return place


def _run_until_stopped(scheduler: Scheduler, say: Say, condition: Callable[[], bool] | None) -> None:
    say("stop with Ctrl-C")
    with deferred_interrupts(scheduler, STOP_SIGNALS), contextlib.suppress(KeyboardInterrupt):
        before = signal.pthread_sigmask(signal.SIG_BLOCK, ())
        try:
            signal.pthread_sigmask(signal.SIG_UNBLOCK, STOP_SIGNALS)  # one that waits comes here
            scheduler.run_until(condition, None)
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)
    late = scheduler.lateness
    say(
        f"stopped after {seconds_text(scheduler.now_ns / 1e9)} at {scheduler.real_time_factor or 0:.3f} x real time; "
        f"lateness p50 {late.quantile_ns(0.5) / 1e6:.2f} ms, p99 {late.quantile_ns(0.99) / 1e6:.2f} ms, "
        f"max {late.max_ns / 1e6:.2f} ms, {scheduler.slips} slips"
    )


def door_option(wish: DoorWish) -> str:
    """Return the option by which a door was wished for."""
    if isinstance(wish, PtyWish):
        return "--pty"
    return "--rfc2217" if isinstance(wish, Rfc2217Wish) else "--tcp"


def open_door(
    wish: DoorWish,
    scheduler: Scheduler,
    line: Line,
    *,
    any_baud: bool,
    clients: Clients = Clients.FIRST,
    hangs_up: bool = True,
    chip_time: Timeline | None = None,
) -> AnyDoor:
    """Open a door; the caller closes it.

    Args:
        wish: which.
        scheduler: owner of bench time.
        line: the wire behind it.
        any_baud: understand a client whatever rate it has set.
        clients: who is served at a socket.
        hangs_up: see `hilbench.links.door.Door`.
        chip_time: time of the chip whose USART the door leads to.

    Raises:
        UsageError: something else is at the path of a pty.
        UnavailableError: it cannot be opened.
    """
    door: AnyDoor
    if isinstance(wish, PtyWish):
        name = f"pty:{wish.path}"
        door = PtyDoor(scheduler, wish.path, line, any_baud=any_baud, name=name, chip_time=chip_time)
    else:
        address = f"[{wish.host}]:{wish.port}" if ":" in wish.host else f"{wish.host}:{wish.port}"
        if isinstance(wish, Rfc2217Wish):
            name = f"rfc2217:{wish.port}"
            door = Rfc2217Door(
                scheduler, address, line, any_baud=any_baud, clients=clients, name=name, chip_time=chip_time
            )
        else:
            door = TcpDoor(scheduler, address, line, clients=clients, name=f"tcp:{wish.port}", chip_time=chip_time)
    door.hangs_up = hangs_up
    return door


def no_topics() -> UsageError:
    """Return what is wrong with ``--dds`` where a target has no topics."""
    return UsageError("the target has no topics", where="--dds")


def place(door: AnyDoor) -> str:
    """Return where a door is, for people."""
    if isinstance(door, PtyDoor):
        return str(door.path)
    return f"{'rfc2217' if isinstance(door, Rfc2217Door) else 'tcp'} {door.host}:{door.port}"


def traffic(door: AnyDoor) -> str:
    """Return what has passed a door, for people."""
    counted = door.counters
    text = f"{place(door)}: {counted.received} bytes in, {counted.sent} out"
    if dropped := counted.lost + counted.overruns:
        text += f", {dropped} of them dropped, as no client read them"
    if counted.refused:
        text += f"; {counted.refused} clients refused"
    if counted.framing_errors:
        text += f"; {counted.framing_errors} framing errors"
    return text
