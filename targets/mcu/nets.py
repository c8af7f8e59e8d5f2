"""Wires between pins, of one chip or of several.

Each end of a wire sees the others as sources of its own. Within a chip that happens at once; between chips at the bench
time of the change, through `targets.mcu.pins.Pins.deliver`: chips do not run in step, so no level of a wire as a whole
exists until all have reached it.
"""

from __future__ import annotations

from collections.abc import Hashable

from targets.mcu.errors import BoardError
from targets.mcu.pins import AnySource, Pin, Source

__all__ = ["Net", "Nets"]

PULL_OHMS = 10_000.0
"""An ordinary pull resistor on a board (choice)."""


class Net:
    """A wire; it comes from `Nets.wire`.

    Attributes:
        name: what it is called on the bench.
        pins: its ends.
    """

    def __init__(self, name: str, pins: tuple[Pin, ...], pull: Source | None) -> None:
        self.name = name
        self.pins = pins
        for pin in pins:
            if pull is not None:
                pin.set_source((name, "pull"), pull)
            pin.join(self)
        for pin in pins:
            chip, outside = pin.contributions()
            self.spread(pin, "chip", chip)
            self.spread(pin, "outside", outside)

    def spread(self, origin: Pin, kind: Hashable, source: AnySource | None) -> None:
        """Let the other ends see what `origin` contributes from the present cycle of its chip on."""
        key = (self.name, origin.chip, origin.name, kind)
        ns = origin.now_ns()
        for pin in self.pins:
            if pin is origin:
                continue
            if pin.chip is origin.chip:
                pin.set_source(key, source)
            else:
                pin.deliver(ns, _Change(pin, key, source))


class _Change:
    """A change that waits for its chip to reach the time of it."""

    __slots__ = ("_key", "_pin", "_source")

    def __init__(self, pin: Pin, key: tuple[object, ...], source: AnySource | None) -> None:
        self._pin, self._key, self._source = pin, key, source

    def __call__(self) -> None:
        self._pin.set_source(self._key, self._source)


class Nets:
    """The wires of a bench, by name."""

    def __init__(self) -> None:
        self._nets: dict[str, Net] = {}

    def wire(
        self,
        name: str,
        *pins: Pin,
        pull: bool | None = None,
        pull_ohms: float = PULL_OHMS,
        pull_volts: float = 3.3,
    ) -> Net:
        """Join pins.

        Args:
            name: what the wire is called.
            pins: its ends, two or more, of any chips.
            pull: whether a resistor pulls it up (True) or down; None for no resistor.
            pull_ohms: of the resistor.
            pull_volts: what a pull-up leads to.

        Raises:
            BoardError: the name is taken, there are fewer than two ends, or an end is not bonded.
        """
        if name in self._nets:
            raise BoardError(f"there are two wires called {name}", hint="give each wire a name of its own")
        if len(set(pins)) < 2:
            raise BoardError(f"the wire {name} has fewer than two ends", hint="name the pins that it joins")
        for pin in pins:
            if not pin.bonded:
                raise BoardError(f"{pin.name} is not bonded in this package", where=f"wire {name}")
        resistor = None if pull is None else Source(pull_volts if pull else 0.0, pull_ohms)
        net = self._nets[name] = Net(name, pins, resistor)
        return net

    def __getitem__(self, name: str) -> Net:
        """Return the wire of that name. Raises KeyError."""
        return self._nets[name]
