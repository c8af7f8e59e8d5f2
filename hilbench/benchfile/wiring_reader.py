"""Finds out what the parts and wires of a bench file mean, and refuses what cannot be built.

Every mistake is named with its line, and with the nearest name that would be right.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

from hilbench.benchfile.bench_file import EmulatedBoard, Link, Net, PartPlan, PinEnd, TerminalEnd
from hilbench.benchfile.bench_model import BenchModel, PartEntry
from hilbench.benchfile.bus_reader import BusReader
from hilbench.benchfile.quantity_reader import WORLD, QuantityReader
from hilbench.nearest import did_you_mean
from hilbench.plugins.system import VehicleKind
from hilbench.strict import Path, Strict
from targets.parts import PARTS, Direction, Part, part_class

__all__ = ["WiringReader"]

SUPPLIES = ("3v3", "gnd")
_TAKEN = {WORLD: "the world", "peer": "the checker's end of a line", **dict.fromkeys(SUPPLIES, "a supply")}

End = PinEnd | TerminalEnd | str


class WiringReader:
    """Reads the parts and the wires of one file.

    Args:
        model: the file as it is written.
        boards: its boards.
        vehicle: the vehicle in its world; None for one of which nothing is known.
        strict: says where in the file something stands.
        add_pin: says how a terminal is joined to a pin, for a hint.
    """

    def __init__(
        self,
        model: BenchModel,
        boards: Mapping[str, EmulatedBoard],
        vehicle: VehicleKind | None,
        strict: Strict,
        *,
        add_pin: Callable[[str], str] = 'add pins = {{ {} = "BOARD.PIN" }}'.format,
    ) -> None:
        self._model = model
        self._boards = boards
        self._strict = strict
        self._add_pin = add_pin
        self._kinds: dict[str, type[Part]] = {name: self._kind(name, entry) for name, entry in model.parts.items()}
        self._quantities = QuantityReader(model, self._kinds, vehicle, strict)
        self._buses = BusReader(boards, self._kinds, strict, self._board_pin)
        self._where: dict[End, Path] = {}

    # --- parts

    def parts(self) -> dict[str, PartPlan]:
        """Return the parts.

        Raises:
            UsageError: a kind, setting, quantity or signal does not exist or does not fit.
        """
        plans = {name: self._part(name, entry) for name, entry in self._model.parts.items()}
        self._quantities.check(plans, self._robot)
        self._check_addresses(plans)
        return plans

    def serial_ends(self) -> list[str]:
        """Return the serial ends of all parts, as ``PART.END``."""
        return [f"{name}.{end}" for name, kind in self._kinds.items() for end in kind.SERIAL]

    def check_lines(self, links: Iterable[Link]) -> None:
        """Require that a part with a serial end has a line to the robot, if there is a robot.

        Raises:
            UsageError: an end leads nowhere.
        """
        joined = {end for link in links for end in link.ends}
        for end in self.serial_ends():
            if self._robot and end not in joined:
                part, _, name = end.partition(".")
                hint = f'add [[links]] with ends = ["{end}", "{self._robot}.host"]'
                raise self._strict.error(f"'{part}': its serial end '{name}' leads nowhere", ("parts", part), hint)

    def _kind(self, name: str, entry: PartEntry) -> type[Part]:
        path: Path = ("parts", name, "kind")
        if name in self._model.targets or name in _TAKEN:
            taken = "a target" if name in self._model.targets else _TAKEN[name]
            message = f"'{name}' is the name of {taken} already"
            raise self._strict.error(message, ("parts", name), "give the part another name")
        if "." in name:
            hint = f"write [parts.{name.replace('.', '_')}]"
            raise self._strict.error(f"'{name}': a name of a part has no dot", ("parts", name), hint)
        if entry.kind not in PARTS:
            raise self._strict.error(f"no kind of part '{entry.kind}'", path, did_you_mean(entry.kind, PARTS, "kinds"))
        return part_class(entry.kind)

    def _part(self, name: str, entry: PartEntry) -> PartPlan:
        for quantity in self._kinds[name].QUANTITIES:
            if quantity.name in entry.pins:
                message = f"'{quantity.name}' is a quantity, not a wire"
                hint = f"put it under signals: {quantity.name} = ..."
                raise self._strict.error(message, ("parts", name, "pins", quantity.name), hint)
        settings = self._strict.convert_at(entry.settings, self._kinds[name].Settings, ("parts", name, "settings"))
        signals, sources = self._quantities.read(name, entry)
        buses = self._buses.read(name, entry)
        return PartPlan(kind=entry.kind, settings=settings, signals=signals, sources=sources, buses=buses)

    def _check_addresses(self, plans: Mapping[str, PartPlan]) -> None:
        there: dict[tuple[object, int], str] = {}
        for name, plan in plans.items():
            kind = self._kinds[name]
            address = kind.address_of(plan.settings)
            if address is None:
                continue
            for end in (plan.buses[key] for key in kind.BUSES):
                first = there.setdefault((end, address), name)
                if first != name:
                    message = f"'{name}' answers at 0x{address:02X} of the same bus as '{first}'"
                    hint = f"set {kind.ADDRESSED_BY} of one" if kind.ADDRESSED_BY else "put one on another bus"
                    raise self._strict.error(f"{message}: a real one would have both answer", ("parts", name), hint)

    @property
    def _robot(self) -> str:
        return next((name for name in self._model.targets if name not in self._boards), "")

    # --- wires

    def nets(self) -> tuple[Net, ...]:
        """Return what the wires and the pins of the parts join, each net once.

        Raises:
            UsageError: an end does not exist, two drive one net, or a terminal that is needed is open.
        """
        groups: list[list[End]] = []
        for ends in self._joined():
            joined, apart = ends, []
            for group in groups:
                if any(end in group and end not in SUPPLIES for end in joined):
                    joined = group + [end for end in joined if end not in group]
                else:
                    apart.append(group)
            groups = [*apart, joined]
        for group in groups:
            self._check_net(group)
        self._check_open({end for group in groups for end in group})
        return tuple(_net(group) for group in groups)

    def _joined(self) -> Iterable[list[End]]:
        for number, wire in enumerate(self._model.wires):
            yield [self._end(("wires", number, "ends"), end) for end in wire.ends]
        for name, entry in self._model.parts.items():
            for terminal, end in entry.pins.items():
                path: Path = ("parts", name, "pins", terminal)
                yield [self._terminal(path, name, terminal), self._end(path, end)]

    def _end(self, path: Path, end: str) -> End:
        if end.lower() in SUPPLIES:
            return self._at(path, end.lower())
        name, _, pin = end.partition(".")
        if name in self._kinds:
            return self._terminal(path, name, pin)
        if name not in self._boards:
            known = [f"{name}.PIN" for name in self._boards] + [f"{name}.TERMINAL" for name in self._kinds]
            hint = did_you_mean(end, known, "write one as")
            raise self._strict.error(f"'{end}' is not a pin of a board, a terminal of a part, 3v3 or gnd", path, hint)
        return self._at(path, self._pin(path, name, pin))

    def _board_pin(self, path: Path, text: str) -> PinEnd:
        name, _, pin = text.partition(".")
        if name not in self._boards:
            hint = did_you_mean(text, [f"{name}.PIN" for name in self._boards], "write one as")
            raise self._strict.error(f"'{text}' is not a pin of a board", path, hint)
        return self._pin(path, name, pin)

    def _pin(self, path: Path, name: str, pin: str) -> PinEnd:
        board = self._boards[name].board
        if pin.upper() in board.variant.usarts:
            message = f"'{name}.{pin}' is a serial line, not a pin"
            raise self._strict.error(message, path, "join lines under [[links]]")
        port_pin = board.port_pin(pin)
        if port_pin is None:
            hint = did_you_mean(pin.upper(), [*sorted(board.variant.pins), *board.pins], "pins")
            raise self._strict.error(f"'{name}' has no pin '{pin}'", path, hint)
        return PinEnd(board=name, pin=port_pin)

    def _terminal(self, path: Path, name: str, terminal: str) -> TerminalEnd:
        kind = self._kinds[name]
        known = [one.name for one in kind.TERMINALS]
        if terminal in known:
            end = TerminalEnd(part=name, terminal=terminal)
            self._where.setdefault(end, path)
            return end
        if terminal in {one.name for one in kind.QUANTITIES}:
            message = f"'{name}.{terminal}' is a quantity, not a wire"
            raise self._strict.error(message, path, f"put it under signals: {terminal} = ...")
        if terminal in kind.SERIAL:
            message = f"'{name}.{terminal}' is a serial line, not a wire"
            raise self._strict.error(message, path, "join lines under [[links]]")
        message, hint = f"'{name}' has no terminal '{terminal}'", did_you_mean(terminal, known, "terminals")
        raise self._strict.error(message, path, hint)

    def _at(self, path: Path, end: End) -> End:
        self._where.setdefault(end, path)
        return end

    def _drives(self, end: TerminalEnd) -> bool:
        direction = {one.name: one.direction for one in self._kinds[end.part].TERMINALS}[end.terminal]
        return direction is Direction.OUT

    def _check_net(self, group: list[End]) -> None:
        drivers = [end for end in group if isinstance(end, TerminalEnd) and self._drives(end)]
        terminals = [end for end in group if isinstance(end, TerminalEnd)]
        supplies = [end for end in group if isinstance(end, str)]
        path = self._where[terminals[-1] if terminals else group[-1]]
        if {*SUPPLIES} <= {*supplies}:
            raise self._strict.error("joins 3v3 and gnd", path)
        if len(drivers) > 1:
            message = f"{drivers[0]} and {drivers[1]} drive one wire"
            raise self._strict.error(message, self._where[drivers[1]], "give each a pin of its own")
        if drivers and supplies:
            message = f"{drivers[0]} drives a wire that {supplies[0]} holds"
            raise self._strict.error(message, self._where[drivers[0]], "join it to a pin instead")
        if not any(isinstance(end, PinEnd) for end in group) and not supplies:
            names = " and ".join(map(str, group))
            raise self._strict.error(f"{names}: no pin of a board is on this wire", path, "join one of them to a pin")

    def _check_open(self, connected: set[End]) -> None:
        for name, kind in self._kinds.items():
            for terminal in kind.TERMINALS:
                if terminal.needed and TerminalEnd(part=name, terminal=terminal.name) not in connected:
                    message = f"'{name}': its terminal '{terminal.name}' ({terminal.text}) is open"
                    raise self._strict.error(message, ("parts", name), self._add_pin(terminal.name))


def _net(group: Iterable[Any]) -> Net:
    ends = list(group)
    return Net(
        pins=tuple(end for end in ends if isinstance(end, PinEnd)),
        terminals=tuple(end for end in ends if isinstance(end, TerminalEnd)),
        supplies=frozenset(end for end in ends if isinstance(end, str)),
    )
