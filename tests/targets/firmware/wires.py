"""What images need around them besides their board: wires between its pins, with pull-ups."""

from __future__ import annotations

from targets.mcu.machine import Machine
from targets.mcu.nets import Nets

__all__ = ["put_wires"]

_WIRES = {"selftest-i2c-slave": (("PB6", "PB10"), ("PB7", "PB11"))}


def put_wires(machine: Machine, image: str) -> None:
    """Solder the wires of an image to the chip that is to run it."""
    nets = Nets()
    for pins in _WIRES.get(image, ()):
        nets.wire("-".join(pins), *(machine.chip.pins[pin] for pin in pins), pull=True)
