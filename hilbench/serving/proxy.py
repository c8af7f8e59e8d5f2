"""`hilbench proxy A B`: between a client and a board, in real time, until it is told to stop.

An end is a door that somebody comes in by (``pty:PATH``, ``tcp:PORT``, ``rfc2217:PORT``), a port that is opened
(``serial:/dev/ttyUSB0@115200``, a pyserial URL), or a virtual target (a model, ``BOARD:IMAGE``).
"""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import msgspec
from msgspec import UNSET

from hilbench.bench import Bench
from hilbench.bench.about import about_reading
from hilbench.bench.lateness_log import LatenessLog
from hilbench.bench.line_faults import describe_faults
from hilbench.benchfile.fault_entries import FaultEntry
from hilbench.clock import NS_PER_MS, EventClass, Scheduler
from hilbench.errors import UsageError
from hilbench.exit_codes import ExitCode
from hilbench.journal import Journal
from hilbench.links import Line, Port, ReconnectingPort, SerialPort, is_serial_target, parse_serial_target
from hilbench.pace.far_pace import FarPace, place_of
from hilbench.plugins.protocol import ProtocolPlugin
from hilbench.serving import Notice, Say, open_door, place, run_until_stopped, signals_held
from hilbench.serving.near_ends import open_near_end
from hilbench.serving.relay import CLIENT, SERVER, A, B, Heard, Relay
from hilbench.strict import Strict
from hilbench.strict.toml_file import TomlFile
from hilbench.terminal import arguments
from hilbench.terminal.options import Clients, DoorWish

__all__ = ["USUAL_BAUD", "ProxyOptions", "look_on", "proxy", "read_faults"]

USUAL_BAUD = 115_200
"""Of a serial port for which none is named (choice)."""
_WRITE_EVERY_NS = 100 * NS_PER_MS
"""How often the journal is written, and losses are looked for (choice)."""
_DOORS: Mapping[str, Callable[[str], DoorWish]] = {
    "pty": arguments.pty_door,
    "tcp": arguments.tcp_door,
    "rfc2217": arguments.rfc2217_door,
}


@dataclass(frozen=True, slots=True, kw_only=True)
class ProxyOptions:
    """What ``hilbench proxy`` was asked to do.

    Attributes:
        a: where the client is.
        b: where the board is.
        clients: who is served where several come to a socket.
        faults: file with what goes wrong on the way.
        seed: of everything random.
        journal: where the journal is written.
        journal_max: how large it and the part before it may get together, in bytes; None for no limit.
        protocol: what is spoken, as far as that is known; who shows the journal reads it so.
        reading: how its frames are read, the protocol's own record of options.
    """

    a: str
    b: str
    clients: Clients = Clients.ALL
    faults: Path | None = None
    seed: int = 0
    journal: Path | None = None
    journal_max: int | None = None
    protocol: ProtocolPlugin | None = None
    reading: object = None


_WATCHED = partial(SerialPort, watch_lines=True)
"""Opens a port; that the bench waits for a USB adapter's answer now and then costs a proxy nothing but time."""


class _FaultsFile(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    faults: tuple[FaultEntry, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class _End:
    """One end: our port, where it is in words, what is reported of it, how it is closed, why it will never go on."""

    port: Port
    where: str
    notice: Notice
    close: Callable[[], None]
    ended: Callable[[], str] = lambda: ""


def proxy(options: ProxyOptions, say: Say, heard: Heard | None = None) -> ExitCode:
    """Hand on what passes until interrupted, or until a virtual target has come to its end.

    Args:
        options: the ends, faults, journal.
        say: takes lines meant for a person; it must never wait for that person.
        heard: receives what each end says; it must not wait either.

    Returns:
        OK: being interrupted is how it ends.

    Raises:
        UsageError: an end is none, or the file of faults is wrong.
        UnavailableError: an end cannot be opened, or the journal can no longer be written.
    """
    faults = () if options.faults is None else read_faults(options.faults)
    with signals_held(), contextlib.ExitStack() as stack:
        bench = Bench(Scheduler(), Journal())
        ends = {}
        for name, what in ((A, options.a), (B, options.b)):
            end = _open(bench, what, options, say)
            stack.callback(end.close)
            ends[name] = end
        header = {"proxy": [options.a, options.b], "seed": options.seed, "faults": [one.describe() for one in faults]}
        header |= _live(options)
        bench.journal = Journal(options.journal, header, max_bytes=options.journal_max, after=bench.journal)
        stack.callback(lambda: bench.journal.close(bench.now_ns))
        record = options.journal is not None
        more = {} if heard is None else {"heard": heard}
        relay = Relay(bench, ends[A].port, ends[B].port, faults=faults, seed=options.seed, record=record, **more)
        relay.on_refused = lambda text: say(f"{bench.now_s:10.3f} s  {text}")
        stack.callback(relay.finish)
        look_on(bench, relay, LatenessLog(bench, "proxy"))
        for name, who in ((A, CLIENT), (B, SERVER)):
            say(f"{name} ({who}): {ends[name].where}")
            _announce(bench, ends[name].port, who, say)
        if faults:
            say(f"faults on the way: {describe_faults(faults)}")
        notice = ends[A].notice + ends[B].notice
        run_until_stopped(bench.scheduler, say, lambda: any(end.ended() for end in ends.values()), notice=notice)
        for name, who in ((A, CLIENT), (B, SERVER)):
            say(_traffic(ends[name].port, who) + (f"; {ended}" if (ended := ends[name].ended()) else ""))
        for line in relay.faults.evidence() if relay.faults is not None else ():
            say(line)
    return ExitCode.OK


def _live(options: ProxyOptions) -> dict[str, object]:
    """Return what the header of the journal says for those who show it: who speaks what.

    With faults an end gets something else than the other has said, so the client's end alone is shown.
    """
    if options.protocol is None:
        return {}
    speaks = {"protocol": options.protocol.name}
    speakers = {CLIENT: speaks} if options.faults is not None else {CLIENT: speaks, SERVER: {**speaks, "far": True}}
    return {"live": {"operator": CLIENT, **speaks, "speakers": speakers, **about_reading(options.reading)}}


def read_faults(path: Path) -> tuple[FaultEntry, ...]:
    """Read a file of ``[[faults]]``, which are towards end ``a``, the client, or ``b``, the board (by default).

    Raises:
        UsageError: it cannot be read, or is wrong; the line is named.
    """
    file = TomlFile(path, "file of faults")
    strict = Strict(file.place)
    entries = strict.convert(file.data, _FaultsFile).faults
    return tuple(_directed(entry, number, strict) for number, entry in enumerate(entries))


def _directed(entry: FaultEntry, number: int, strict: Strict) -> FaultEntry:
    if entry.link:
        raise strict.error("there is no link but 0 between the two ends", ("faults", number, "link"))
    if entry.kind == "disconnect":
        return entry
    for name, end in (("towards", entry.towards), ("from", entry.from_)):
        if end is not UNSET and end not in (A, B):
            raise strict.error(
                f"'{end}' is no end", ("faults", number, name), "the ends are a, the client, and b, the board"
            )
    towards = entry.towards
    if towards is UNSET:
        towards = A if entry.from_ == B else B
    return msgspec.structs.replace(entry, towards=towards, from_=UNSET)


def _open(bench: Bench, what: str, options: ProxyOptions, say: Say) -> _End:
    kind, _, rest = what.partition(":")
    if kind in _DOORS and not rest.startswith("//"):
        return _door(bench, kind, rest, what, options.clients, say)
    if is_serial_target(what):
        target = parse_serial_target(what, USUAL_BAUD)
        port = ReconnectingPort(bench.scheduler, target, record=bench.record, open_port=_WATCHED)
        if place_of(port.device) is not None:
            bench.far.append(FarPace(port.device, but_of=os.getpid()))
        notice = Notice(behind=(port.device if "://" in port.device else str(Path(port.device).absolute()),))
        return _End(port=port, where=f"{port.device}, {port.baud} baud", notice=notice, close=port.close)
    from hilbench.mcu.command_line import open_target

    near = open_near_end(bench, open_target(what), seed=options.seed, real_time=True)
    where, notice = f"{what}, line {near.name}", Notice(step_ns=near.step_ns)
    return _End(port=near.port, where=where, notice=notice, close=near.close, ended=near.ended)


def _door(bench: Bench, kind: str, rest: str, what: str, clients: Clients, say: Say) -> _End:
    try:
        wish = _DOORS[kind](rest)
    except ValueError as error:
        raise UsageError(str(error), where=what) from None
    if wish.link:
        raise UsageError(
            "an endpoint of a proxy is connected to its other side", where=what, hint=f"leave out {wish.link}="
        )
    door = open_door(wish, bench.scheduler, Line(baud=0), any_baud=True, clients=clients)
    door.on_visit = lambda text: say(f"{bench.now_s:10.3f} s  {place(door)}: {text}")
    return _End(port=door, where=place(door), notice=Notice(doors=(door,)), close=door.close)


def look_on(bench: Bench, relay: Relay, lateness: LatenessLog) -> None:
    """Record losses and lateness, and write the journal, again and again: what is killed loses little of it."""
    relay.tell_losses()
    lateness.look()
    bench.journal.flush_step()
    again = partial(look_on, bench, relay, lateness)
    bench.scheduler.after(_WRITE_EVERY_NS, again, order=EventClass.CHECK, source="journal")


def _announce(bench: Bench, port: Port, who: str, say: Say) -> None:
    notify = port.on_line

    def line_changed(up: bool, at_ns: int) -> None:
        say(f"{bench.now_s:10.3f} s  {who}: the line is {'up' if up else 'down'}")
        notify(up, at_ns)

    port.on_line = line_changed


def _traffic(port: Port, who: str) -> str:
    counted = port.counters
    lost = f", {counted.lost + counted.overruns} of them lost" if counted.lost + counted.overruns else ""
    return f"{who}: {counted.received} bytes from it, {counted.sent} to it{lost}"
