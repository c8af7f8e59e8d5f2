"""Which USART of which board gets which door, and how a door and a USART are put together."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from hilbench.errors import UnavailableError, UsageError
from hilbench.links import Line, Port
from hilbench.links.port import USUAL_BREAK_NS
from hilbench.mcu.emulated import EmulatedBench
from hilbench.mcu.usart_port import UNSET_BAUD, UsartPort
from hilbench.nearest import did_you_mean
from hilbench.serving import AnyDoor, Say, door_option, open_door, place
from hilbench.serving.doors import SharedDoor
from hilbench.terminal.options import Clients, DoorWish, ServeOptions
from hilbench.terminal.options import PtyDoor as PtyWish

__all__ = ["ServedUsart", "assign", "connect_model", "open_doors"]


@dataclass(frozen=True, slots=True, kw_only=True)
class ServedUsart:
    """A USART and the doors that lead to it.

    Attributes:
        name: as ``brain.usart1``.
        doors: one or more.
    """

    name: str
    doors: tuple[AnyDoor, ...]


def assign(
    options: ServeOptions, free: Sequence[str], unasked: Sequence[str] | None = None, *, apart: bool = False
) -> Mapping[str, list[DoorWish]]:
    """Return the doors that each USART gets.

    A door that names none gets the next USART, in the order of `free`, that no door of its kind has. Where no doors are
    wished for, each USART of `unasked` gets a pty in the working folder, called after it.

    Args:
        options: the doors that were wished for.
        free: the USARTs that can have doors, as ``brain.usart1``.
        unasked: those of them that have one without anybody asking; all if left out.
        apart: a door that names none gets one that has no door at all.

    Raises:
        UsageError: no such USART, two doors of a kind for one, or more doors than USARTs.
    """
    wishes = options.doors
    if not wishes:
        return {name: [PtyWish(path=Path(f"./{name.replace('.', '-')}"))] for name in unasked or free}
    found: dict[str, list[DoorWish]] = {}
    for wish in sorted(wishes, key=lambda wish: not wish.link):
        name = _named(wish, free, found) if wish.link else _next(wish, free, found, apart=apart)
        found.setdefault(name, []).append(wish)
    return {name: found[name] for name in free if name in found}


def _named(wish: DoorWish, free: Sequence[str], found: Mapping[str, Sequence[DoorWish]]) -> str:
    link = wish.link.lower()
    fitting = [name for name in free if name == link or name.partition(".")[2] == link]
    where = f"{door_option(wish)} {wish.link}="
    if len(fitting) == 1:
        if _has_such(wish, found.get(fitting[0], ())):
            raise UsageError(f"{fitting[0]} has an endpoint of this kind already", where=where, hint="one of each kind")
        return fitting[0]
    if fitting:
        raise UsageError("several boards have it", where=where, hint=f"write one of {', '.join(fitting)}")
    raise UsageError("no such line, or it is linked already", where=where, hint=did_you_mean(link, free, "lines"))


def _next(wish: DoorWish, free: Sequence[str], found: Mapping[str, Sequence[DoorWish]], *, apart: bool) -> str:
    for name in free:
        there = found.get(name, ())
        if not (there if apart else _has_such(wish, there)):
            return name
    raise UsageError(f"more of them than lines ({', '.join(free) or 'none is free'})", where=door_option(wish))


def _has_such(wish: DoorWish, others: Sequence[DoorWish]) -> bool:
    return any(type(other) is type(wish) for other in others)


def open_doors(
    emulated: EmulatedBench, name: str, wishes: Sequence[DoorWish], options: ServeOptions
) -> Iterator[AnyDoor]:
    """Open the doors of one USART, or of the line of a model; the caller closes them.

    Raises:
        UsageError: something else is at the path of a pty.
        UnavailableError: a door cannot be opened.
    """
    port = emulated.ports.get(name)
    baud = options.baud or emulated.bench_file.served_lines[name] if port is None else port.baud
    scheduler, line = emulated.bench.scheduler, Line(baud=baud)
    for wish in wishes:
        yield open_door(
            wish,
            scheduler,
            line,
            any_baud=options.any_baud,
            clients=options.clients,
            hangs_up=not options.ignore_hangup,
            chip_time=None if port is None else port.chip_time,
        )


def connect(
    emulated: EmulatedBench, name: str, doors: Sequence[AnyDoor], say: Say, clients: Clients = Clients.FIRST
) -> None:
    """Put the doors of one USART at the far end of its line, and tell who comes and goes."""
    port, far_end = emulated.ports[name], emulated.far_ends[name]
    outside = _outside(doors, clients)
    port.on_follow = partial(_follow, port, doors)
    if far_end is port:
        outside.on_receive = port.begin
    else:  # each byte has to be judged
        outside.on_receive = lambda data, _at_ns: far_end.write(data)
    outside.on_break = lambda _at_ns: far_end.send_break(outside.break_ns or USUAL_BREAK_NS)
    far_end.on_receive = lambda data, _at_ns: outside.write(data)
    far_end.on_break = _BreakOut(emulated, name, outside, say)
    outside.on_line = lambda up, _at_ns: say(_now(emulated, name, f"a client {'came' if up else 'left'}"))
    for door in doors:
        if far_end is port:
            port.add_sender(door.incoming)
    _tell_of(emulated, name, doors, say)


def connect_model(
    emulated: EmulatedBench, name: str, doors: Sequence[AnyDoor], say: Say, options: ServeOptions
) -> None:
    """Put the doors of the line of a model at its far end; a client that leaves hangs up, unless nobody is told."""
    link, bench = emulated.surroundings.open_lines[name], emulated.bench
    outside = _outside(doors, options.clients)
    source, _, line = name.rpartition(".")

    def received(data: bytes, _at_ns: int) -> None:
        bench.record("rx", source, line=line, data=data)
        link.a.write(data)

    def line_changed(up: bool, _at_ns: int) -> None:
        if up:
            link.restore()
        elif not options.ignore_hangup:
            link.hang_up()
        say(_now(emulated, name, f"a client {'came' if up else 'left'}"))

    link.a.on_receive = lambda data, _at_ns: outside.write(data)
    outside.on_receive = received
    outside.on_line = line_changed
    _tell_of(emulated, name, doors, say)


def _outside(doors: Sequence[AnyDoor], clients: Clients) -> Port:
    return doors[0] if len(doors) == 1 else SharedDoor(doors, clients)


def _tell_of(emulated: EmulatedBench, name: str, doors: Sequence[AnyDoor], say: Say) -> None:
    for door in doors:
        door.on_garbled = partial(_garbled, emulated, name, door, say)
        door.on_visit = partial(_visited, emulated, name, door, say)


class _BreakOut:
    """Hands a break of the firmware to the client; that its door knows none is said once."""

    def __init__(self, emulated: EmulatedBench, name: str, outside: Port, say: Say) -> None:
        self._emulated, self._name, self._outside, self._say = emulated, name, outside, say
        self._said = False

    def __call__(self, _at_ns: int) -> None:
        """Take a break that has ended."""
        try:
            self._outside.send_break(0)  # it is over
        except UnavailableError as error:
            if not self._said:
                self._said = True
                self._emulated.bench.record("break-refused", self._name, text=str(error))
                self._say(_now(self._emulated, self._name, str(error)))


def _follow(port: UsartPort, doors: Sequence[AnyDoor]) -> None:
    for door in doors:
        was_baud = door.baud
        door.set_frame(port.baud, port.bits_per_byte)
        if was_baud != port.baud:
            door.follow(was_baud, unasked=was_baud == UNSET_BAUD)


def _garbled(emulated: EmulatedBench, name: str, door: AnyDoor, say: Say, client_baud: int) -> None:
    say(
        _now(
            emulated,
            name,
            f"the client at {place(door)} set {client_baud} baud, the line runs at {door.baud}; bytes are garbled as "
            "on a real line; --any-baud",
        )
    )


def _visited(emulated: EmulatedBench, name: str, door: AnyDoor, say: Say, text: str) -> None:
    say(_now(emulated, name, f"{place(door)}: {text}"))


def _now(emulated: EmulatedBench, name: str, text: str) -> str:
    return f"{emulated.bench.now_s:10.3f} s  {name}: {text}"
