"""The I2C and SPI buses of the chips, with the parts that are soldered to them.

A chip runs ahead of bench time, and so do the calls that its I2C or SPI makes of a part. What the part tells meanwhile
goes into the journal at the time of the call; a transaction of an I2C bus does so at its end, as one event of the bus.
After each call the part is asked anew when it is due next, and no chip runs beyond that.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator, Mapping
from functools import partial

from hilbench.bench import Bench
from hilbench.benchfile.bench_file import BusEnd, BusPins, PartPlan
from hilbench.errors import UsageError
from hilbench.mcu.group import MachineGroup
from hilbench.mcu.parts import Parts
from hilbench.mcu.seams import Machine
from targets.mcu.i2c_bus import RELEASED, I2cBus, I2cSlave, I2cTransaction
from targets.mcu.i2c_pins import I2cPins
from targets.mcu.pins import Pins
from targets.mcu.spi_bus import PromisingSlave, SpiBus, SpiSlave, check_slave, promises
from targets.parts import Part

__all__ = ["Buses"]


class _Calls:
    """Calls of a part, made while its chip is ahead of the bench."""

    def __init__(self, parts: Parts, group: MachineGroup, name: str) -> None:
        self.name = name
        self._parts = parts
        self._group = group

    @contextlib.contextmanager
    def at(self, now_ns: int) -> Iterator[None]:
        """Call it at a time."""
        with self._parts.ahead(self.name, now_ns):
            yield
        due_ns = self._parts.settle(self.name)
        if due_ns is not None:
            self._group.limit(due_ns)


class _I2cAhead:
    """What a part has at an I2C bus."""

    def __init__(self, calls: _Calls, slave: I2cSlave) -> None:
        self._at = calls.at
        self._slave = slave

    def address(self, address: int, read: bool, now_ns: int) -> bool:
        with self._at(now_ns):
            return self._slave.address(address, read, now_ns)

    def write(self, byte: int, now_ns: int) -> bool:
        with self._at(now_ns):
            return self._slave.write(byte, now_ns)

    def read(self, now_ns: int) -> int:
        with self._at(now_ns):
            return self._slave.read(now_ns)

    def end(self, now_ns: int) -> None:
        with self._at(now_ns):
            self._slave.end(now_ns)


class _AtPins:
    """A slave of an I2C interface, for as long as that one's signals are at the pins that the slave is soldered to."""

    def __init__(self, slave: I2cSlave, here: Callable[[], bool]) -> None:
        self._slave = slave
        self._here = here
        self.end = slave.end

    def address(self, address: int, read: bool, now_ns: int) -> bool:
        return self._here() and self._slave.address(address, read, now_ns)

    def write(self, byte: int, now_ns: int) -> bool:
        return self._here() and self._slave.write(byte, now_ns)

    def read(self, now_ns: int) -> int:
        return self._slave.read(now_ns) if self._here() else RELEASED


class _SpiAhead:
    """What a part has at an SPI bus."""

    def __init__(self, calls: _Calls, slave: SpiSlave) -> None:
        try:
            check_slave(slave)
        except TypeError as error:
            raise UsageError(str(error), where=f"part '{calls.name}'") from None
        self._at = calls.at
        self._slave = slave
        self.modes, self.answer = slave.modes, slave.answer

    @property
    def releases(self) -> int:
        return self._slave.releases

    def selected(self, now_ns: int) -> bool:
        with self._at(now_ns):
            return self._slave.selected(now_ns)

    def exchange(self, byte: int, now_ns: int) -> int:
        with self._at(now_ns):
            return self._slave.exchange(byte, now_ns)


class _PromisingAhead(_SpiAhead):
    """One that may promise what it answers."""

    def __init__(self, calls: _Calls, slave: PromisingSlave) -> None:
        super().__init__(calls, slave)
        self._promising = slave
        self.promise = slave.promise

    @property
    def broken(self) -> Callable[[], None]:
        return self._promising.broken

    @broken.setter
    def broken(self, settle: Callable[[], None]) -> None:
        self._promising.broken = settle

    def take(self, data: bytes, now_ns: int) -> None:
        with self._at(now_ns):
            self._promising.take(data, now_ns)


class Buses:
    """See the module.

    Args:
        bench: whose journal it is.
        group: who lets the chips run.
        machines: the chips, by board.
        parts: the parts, not switched on yet.
        plans: what they are soldered to.
    """

    def __init__(
        self,
        bench: Bench,
        group: MachineGroup,
        machines: Mapping[str, Machine],
        parts: Parts,
        plans: Mapping[str, PartPlan],
    ) -> None:
        self._bench = bench
        self._group = group
        self._machines = machines
        self._followed: dict[BusEnd | BusPins, I2cPins] = {}
        for board, machine in machines.items():
            for interface, i2c in machine.chip.i2cs.items():
                i2c.bus.taps.append(partial(self._ended, str(BusEnd(board=board, interface=interface)).lower()))
        for name, plan in plans.items():
            for key, end in plan.buses.items():
                self._solder(parts.by_name[name], key, end, _Calls(parts, group, name))

    def _solder(self, part: Part, key: str, end: BusEnd | BusPins, calls: _Calls) -> None:
        chip = self._machines[end.board].chip
        if isinstance(end, BusPins):
            self._solder_to_pins(end, _I2cAhead(calls, part.slave(key)))
        elif key in part.SPI_BUSES:
            self._solder_to_spi(chip.spis[end.interface].bus, part.spi_slave(key), calls)
        else:
            bus = chip.i2cs[end.interface].bus
            bus.attach(_I2cAhead(calls, part.slave(key)))
            if end not in self._followed:
                self._followed[end] = I2cPins(bus)
                self._followed[end].follow(*(chip.signals.input(f"{end.interface}_{wire}") for wire in ("SCL", "SDA")))

    def _solder_to_spi(self, bus: SpiBus, slave: SpiSlave, calls: _Calls) -> None:
        bus.attach(_PromisingAhead(calls, slave) if promises(slave) else _SpiAhead(calls, slave))
        self._group.after_round.append(lambda _reached_ns: bus.settle())

    def _solder_to_pins(self, end: BusPins, slave: I2cSlave) -> None:
        chip = self._machines[end.board].chip
        if end not in self._followed:
            bus = I2cBus()
            bus.taps.append(partial(self._ended, str(end).lower()))
            self._followed[end] = I2cPins(bus)
            self._followed[end].put_at(chip.pins[end.scl], chip.pins[end.sda])
        self._followed[end].bus.attach(slave)
        for interface, i2c in chip.i2cs.items():
            i2c.bus.attach(_AtPins(slave, partial(_carry, chip.pins, interface, end)))

    def _ended(self, source: str, transaction: I2cTransaction) -> None:
        self._group.output(
            transaction.end_ns, partial(self._bench.record_event, source, transaction), source=source, reacts=False
        )


def _carry(pins: Pins, interface: str, at: BusPins) -> bool:
    """Say whether both pins carry the signals of an interface: routed there, and not moved by the program itself."""
    wires = ((pins[at.scl], f"{interface}_SCL"), (pins[at.sda], f"{interface}_SDA"))
    return all(pin.alternate and any(output.name == name for output in pin.outputs) for pin, name in wires)
