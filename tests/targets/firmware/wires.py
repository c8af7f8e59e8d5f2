"""What images need around them besides their board: wires between its pins, with pull-ups, and parts at its buses."""

from __future__ import annotations

from collections.abc import Callable

from targets.mcu.machine import Machine
from targets.mcu.nets import Nets
from targets.parts.at24c02 import At24c02, At24c02Settings
from targets.parts.part import Ports
from targets.parts.ssd1306 import Ssd1306, Ssd1306Settings
from targets.parts.testing import Wire
from targets.parts.w25q.w25q import W25q, W25qSettings

__all__ = ["PARTS", "put_wires"]

_WIRES = {"selftest-i2c-slave": (("PB6", "PB10"), ("PB7", "PB11"))}


def _eeprom(machine: Machine) -> None:
    machine.chip.i2cs["I2C1"].bus.attach(At24c02(At24c02Settings(), Ports(), seed=1).slave("i2c"))


def _display(machine: Machine) -> None:
    machine.chip.i2cs["I2C1"].bus.attach(Ssd1306(Ssd1306Settings(), Ports(), seed=1).slave("i2c"))


def _flash(machine: Machine) -> None:
    select = Wire()
    machine.chip.pins["PA4"].on_edge(lambda _cycle, ns, level: select.set(level, ns))
    machine.chip.spis["SPI1"].bus.attach(W25q(W25qSettings(), Ports(inputs={"cs": select}), seed=1).spi_slave("spi"))


PARTS: dict[str, tuple[Callable[[Machine], None], ...]] = {
    "style-arduino": (_eeprom, _flash),
    "style-drivers": (_eeprom, _display, _flash),
    "style-hal-buses": (_eeprom, _flash),
    "style-ll-buses": (_eeprom, _flash),
    "style-opencm3": (_eeprom, _flash),
}


def put_wires(machine: Machine, image: str) -> None:
    """Solder the wires and parts of an image to the chip that is to run it."""
    nets = Nets()
    for pins in _WIRES.get(image, ()):
        nets.wire("-".join(pins), *(machine.chip.pins[pin] for pin in pins), pull=True)
    for solder in PARTS.get(image, ()):
        solder(machine)
