"""Finds out which I2C or SPI bus of which board each part is soldered to."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from hilbench.benchfile.bench_file import BusEnd, BusPins, EmulatedBoard, PinEnd
from hilbench.benchfile.bench_model import BusPinsEntry, PartEntry
from hilbench.nearest import did_you_mean
from hilbench.strict import Path, Strict
from targets.parts import Part

__all__ = ["BusReader"]


class BusReader:
    """Reads what stands under ``buses`` of the parts of one file.

    Args:
        boards: its boards.
        kinds: the class of each part.
        strict: says where in the file something stands.
        pin: finds a pin of a board.
    """

    def __init__(
        self,
        boards: Mapping[str, EmulatedBoard],
        kinds: Mapping[str, type[Part]],
        strict: Strict,
        pin: Callable[[Path, str], PinEnd],
    ) -> None:
        self._boards = boards
        self._kinds = kinds
        self._strict = strict
        self._pin = pin

    def read(self, name: str, entry: PartEntry) -> dict[str, BusEnd | BusPins]:
        """Return the buses of a part, by its own names for them.

        Raises:
            UsageError: a bus does not exist on either side, or an end leads nowhere.
        """
        kind = self._kinds[name]
        known = {**dict.fromkeys(kind.BUSES, "I2C"), **dict.fromkeys(kind.SPI_BUSES, "SPI")}
        for key in entry.buses:
            if key not in known:
                hint = did_you_mean(key, known, "its buses") if known else "it has none"
                path: Path = ("parts", name, "buses", key)
                raise self._strict.error(f"a {entry.kind} has no bus '{key}'", path, hint)
        for key, which in known.items():
            if key not in entry.buses:
                example = next(iter(self._interfaces(which)), f"BOARD.{which}1")
                hint = f'add buses = {{ {key} = "{example}" }}'
                raise self._strict.error(f"'{name}': its bus '{key}' leads nowhere", ("parts", name), hint)
        return {key: self._bus(("parts", name, "buses", key), bus, known[key]) for key, bus in entry.buses.items()}

    def _bus(self, path: Path, bus: str | BusPinsEntry, which: str) -> BusEnd | BusPins:
        if isinstance(bus, str):
            return self._end(path, bus, which)
        if which != "I2C":
            hint = f"name an interface, such as {next(iter(self._interfaces(which)), f'BOARD.{which}1')}"
            raise self._strict.error("only an I2C bus can be at pins that the program moves", path, hint)
        scl, sda = self._pin((*path, "scl"), bus.scl), self._pin((*path, "sda"), bus.sda)
        if scl.board != sda.board or scl == sda:
            message = f"{scl} and {sda} are not two pins of one board"
            raise self._strict.error(message, path, "a bus has both wires at one board")
        return BusPins(board=scl.board, scl=scl.pin, sda=sda.pin)

    def _of(self, board: str, which: str) -> tuple[str, ...]:
        variant = self._boards[board].board.variant
        return variant.i2cs if which == "I2C" else variant.spis

    def _interfaces(self, which: str) -> list[str]:
        return [f"{board}.{interface}" for board in self._boards for interface in self._of(board, which)]

    def _end(self, path: Path, text: str, which: str) -> BusEnd:
        board, _, interface = text.partition(".")
        if board not in self._boards:
            hint = did_you_mean(text, self._interfaces(which), "they are")
            raise self._strict.error(f"'{text}' is no {which} interface of a board", path, hint)
        known = self._of(board, which)
        if interface.upper() not in known:
            hint = did_you_mean(interface.upper(), known, "they are") if known else "those of its chip are not modelled"
            raise self._strict.error(f"'{board}' has no {which} interface '{interface}'", path, hint)
        return BusEnd(board=board, interface=interface.upper())
