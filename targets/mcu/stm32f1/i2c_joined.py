"""Which I2C interfaces of a chip are on the same two wires: their pins are, and are set to carry the signals.

Choice: two pins are on the same wire if a net of the bench joins them directly.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable
from functools import partial

from targets.mcu.i2c_bus import I2cBus
from targets.mcu.signals import PinOutput, Signals
from targets.mcu.stm32f1.i2c import I2c

__all__ = ["join"]

_FAR = "and SDA lead to another chip, whose interfaces are not reached: only those of the same chip are"


def join(i2cs: Collection[I2c], signals: Signals) -> None:
    """Tell the bus of each interface how to find those that it is joined with, and each what stands at its pins."""
    wires = {i2c.name: tuple(signals.output(f"{i2c.name}_{wire}") for wire in ("SCL", "SDA")) for i2c in i2cs}
    buses = {i2c.name: i2c.bus for i2c in i2cs}

    def joined_with(name: str) -> tuple[I2cBus, ...]:
        scl, sda = wires[name]
        if not (_wired(scl) and _wired(sda)):
            return ()
        if _leaves_chip(scl) and _leaves_chip(sda):
            scl.pins[0].chip.notes.add("unmodelled", scl.name, _FAR)
        others = (other for other in buses if other != name)
        return tuple(buses[other] for other in others if all(map(_meet, wires[name], wires[other])))

    for i2c in i2cs:
        i2c.bus.joined = partial(joined_with, i2c.name)
        i2c.held_low = partial(_held_low, wires[i2c.name])


def _held_low(signals: Iterable[PinOutput]) -> str:
    low = (signal.name for signal in signals for pin in signal.pins if pin.alternate and pin.level is False)
    return " and ".join(low)


def _wired(signal: PinOutput) -> bool:
    return any(pin.nets and pin.alternate for pin in signal.pins)


def _leaves_chip(signal: PinOutput) -> bool:
    return any(far.chip is not pin.chip for pin in signal.pins for net in pin.nets for far in net.pins)


def _meet(one: PinOutput, other: PinOutput) -> bool:
    there = [pin for pin in other.pins if pin.alternate]
    nets = [net for pin in one.pins if pin.alternate for net in pin.nets]
    return any(pin in net.pins for net in nets for pin in there)
