"""What the bench sees of a part: terminals (wires), quantities (physical values), serial ends, timers.

A part is something soldered between a board and the rest of the world: a switch, an encoder, a motor driver, another
controller. It knows no bench, no world and no clock: levels and values go in with a time, levels, values and bytes
come out. Time is bench time in integer nanoseconds and never goes back.

How the bench calls it:

1. `Part.power_on` once, before anything else. Until then its outputs drive nothing.
2. At every physics step from `from_ns` to `to_ns`: `feed` and `before_step` while all pins have been run up to
   `from_ns` and not further, of a part that gives before one that takes; then the world moves; then `after_step`, which
   may set outputs at exact times in `from_ns`..`to_ns`, because the chips that see them have not been run there yet.
3. `advance` at the time that `next_deadline_ns` has named; `receive` when bytes have come in. Pins have then been run
   up to `now_ns`. What is due at the time of a step comes before that step.

A new kind of part derives from `Part`, names its terminals and quantities, and is entered in `targets.parts.PARTS`.
"""

from __future__ import annotations

import enum
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar, Protocol

from targets.mcu.i2c_bus import I2cSlave
from targets.mcu.spi_bus import SpiSlave

__all__ = [
    "HISTORY_NS",
    "AnalogOutput",
    "Control",
    "DigitalInput",
    "DigitalOutput",
    "Direction",
    "Part",
    "Picture",
    "Ports",
    "Quantity",
    "Terminal",
    "check_controls",
]

HISTORY_NS = 200_000_000
"""How far back a `DigitalInput` remembers, at least: 0.2 s (choice). Before it began, a level counts as low."""


class Direction(enum.Enum):
    """The direction of a terminal or quantity, as the part sees it."""

    IN = "in"
    OUT = "out"


@dataclass(frozen=True, slots=True, kw_only=True)
class Terminal:
    """A wire of a part, 0 or 3.3 V. An output is push-pull, or not driven at all.

    Attributes:
        name: such as ``comm1``.
        direction: as the part sees it.
        analog: an output is a voltage, for an analog-to-digital converter.
        needed: it must be connected. Other terminals may stay open; an open input reads low.
        text: its purpose.
    """

    name: str
    direction: Direction
    analog: bool = False
    needed: bool = False
    text: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Quantity:
    """A physical value that a part takes from the world or from another part, or gives to them.

    Attributes:
        name: such as ``range``.
        direction: as the part sees it.
        unit: the unit, equal to that of the signal it is joined to: ``m``, ``m/s``, ``rad``, ...; ``1`` for none.
        needed: it must be joined.
        late: the part takes the value of the step before, 0 at first. In a loop of parts, such as a circuit, one part
            must do so: feedback is one physics step late.
        text: what it is.
    """

    name: str
    direction: Direction
    unit: str
    needed: bool = True
    late: bool = False
    text: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Control:
    """Something on a part that a person or a script moves: a stick, a button (0 or 1).

    Attributes:
        name: such as ``r2``.
        least: its lowest position.
        greatest: its highest position.
        rest: its position when nobody touches it.
        text: what it is.
    """

    name: str
    least: float
    greatest: float
    rest: float = 0.0
    text: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Picture:
    """What a part shows to people.

    Attributes:
        width: in pixels.
        height: in pixels.
        grey: a byte for each pixel, 0 dark to 255 bright, row by row from above.
    """

    width: int
    height: int
    grey: bytes


class DigitalInput(Protocol):
    """What a part can know of a wire that comes in. A wire that nobody drives reads low."""

    def level(self) -> bool:
        """The level now."""

    def level_at(self, ns: int) -> bool:
        """The level at `ns`, not later than now and not earlier than `HISTORY_NS` before; at an edge the new one."""

    def mean(self, from_ns: int, to_ns: int) -> float:
        """The part of the time from `from_ns` to `to_ns` in which the level was high, 0..1; the same bounds hold.

        An empty span has the level at that instant.
        """

    def latch(self) -> bool:
        """What a chip's output latch holds, whatever the direction of its pin; elsewhere the same as `level`."""

    def changes(self, from_ns: int, to_ns: int) -> Sequence[tuple[int, bool]]:
        """What the level became after `from_ns` and up to `to_ns`, and when, in order; the same bounds hold."""

    def before_change(self, callback: Callable[[], None]) -> None:
        """Have `callback` called before each change of the level, of which nothing is known then; for good."""


class DigitalOutput(Protocol):
    """A wire that a part can drive."""

    def set(self, level: bool | None, at_ns: int) -> None:
        """Drive the wire from `at_ns` on, or let it go (None).

        `at_ns` is not before the present and never before that of an earlier call; in `Part.after_step` it lies within
        the step.
        """


class AnalogOutput(Protocol):
    """A wire on which a part puts a voltage."""

    def put(self, volts: float, at_ns: int) -> None:
        """Put a voltage on the wire from `at_ns` on; for the time the same holds as in `DigitalOutput.set`."""


class _Low:
    """An input to which nothing is connected."""

    def level(self) -> bool:
        return False

    def level_at(self, ns: int) -> bool:  # noqa: ARG002
        return False

    def mean(self, from_ns: int, to_ns: int) -> float:  # noqa: ARG002
        return 0.0

    def latch(self) -> bool:
        return False

    def changes(self, from_ns: int, to_ns: int) -> Sequence[tuple[int, bool]]:  # noqa: ARG002
        return ()

    def before_change(self, callback: Callable[[], None]) -> None:
        pass


class _Nowhere:
    """An output to which nothing is connected."""

    def set(self, level: bool | None, at_ns: int) -> None:
        pass

    def put(self, volts: float, at_ns: int) -> None:
        pass


_LOW, _NOWHERE = _Low(), _Nowhere()


def _deaf(event: object) -> None:
    """Nobody listens."""


def _no_line(data: bytes) -> None:
    """No line is connected."""


def _no_rate(baud: int) -> None:
    """No line is connected, or one whose rate others decide."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Ports:
    """The connections of a part.

    Attributes:
        inputs: the inputs, by name of terminal; terminals without a connection may be missing.
        outputs: as above.
        analogs: as above, for analog terminals.
        serial: takes the bytes that the part sends, at the time of the present call of the part.
        rate: sets the rate of the part's serial end in bit/s, from now on, if the part chooses it itself.
        tell: takes frozen events for the journal, at the time of the present call of the part.
    """

    inputs: Mapping[str, DigitalInput] = field(default_factory=dict)
    outputs: Mapping[str, DigitalOutput] = field(default_factory=dict)
    analogs: Mapping[str, AnalogOutput] = field(default_factory=dict)
    serial: Callable[[bytes], None] = _no_line
    rate: Callable[[int], None] = _no_rate
    tell: Callable[[object], None] = _deaf

    def input(self, name: str) -> DigitalInput:
        """The input of a terminal; always low without a connection."""
        return self.inputs.get(name, _LOW)

    def output(self, name: str) -> DigitalOutput:
        """The output of a terminal; without effect if it has no connection."""
        return self.outputs.get(name, _NOWHERE)

    def analog(self, name: str) -> AnalogOutput:
        """The output of an analog terminal; without effect if it has no connection."""
        return self.analogs.get(name, _NOWHERE)


class Part:
    """A part that does nothing. A real part overrides what it needs.

    Class attributes:
        TERMINALS: wires, by unique names.
        QUANTITIES: physical values, by names that no terminal has.
        SERIAL: names of serial ends; at most one for now.
        BUSES: names of ends at an I2C bus, by names that are nothing else's.
        SPI_BUSES: the same of ends at an SPI bus.
        ADDRESSED_BY: the setting that says at which address it answers on its I2C bus, if it has one; see `address_of`.
        CONTROLS: what can be moved by hand, by names that are nothing else's.
        ABSENT: what the real part does and this model does not, in a few words each; noted when it is used.
        Settings: a frozen dataclass of keywords whose fields carry ``unit`` and ``source`` in their metadata, see
            `targets.parts.settings`; its constructor raises `ValueError` with a text that begins with a field's name.

    Args:
        settings: an instance of `Settings`.
        ports: its connections.
        seed: the seed of everything random in it.
    """

    TERMINALS: ClassVar[tuple[Terminal, ...]] = ()
    QUANTITIES: ClassVar[tuple[Quantity, ...]] = ()
    SERIAL: ClassVar[tuple[str, ...]] = ()
    BUSES: ClassVar[tuple[str, ...]] = ()
    SPI_BUSES: ClassVar[tuple[str, ...]] = ()
    ADDRESSED_BY: ClassVar[str] = ""
    CONTROLS: ClassVar[tuple[Control, ...]] = ()
    ABSENT: ClassVar[tuple[str, ...]] = ()
    Settings: ClassVar[type[Any]]

    def __init__(self, settings: Any, ports: Ports, *, seed: int) -> None:
        raise NotImplementedError

    @staticmethod
    def address_of(settings: Any) -> int | None:  # noqa: ARG004
        """Return its address on the I2C bus with these settings, 0 to 127; None for none."""
        return None

    def power_on(self, now_ns: int) -> None:
        """The supply has been switched on."""

    def feed(self, values: Mapping[str, float]) -> None:
        """Take the incoming quantities for the coming step.

        Quantities of the world have their value at the beginning of the step. Those of other parts have the value for
        this step, or for the step before (`Quantity.late`).
        """

    def before_step(self, from_ns: int, to_ns: int) -> Mapping[str, float]:  # noqa: ARG002
        """Return all outgoing quantities for the coming physics step; see the head of this file."""
        return {}

    def after_step(self, from_ns: int, to_ns: int, before: Mapping[str, float], after: Mapping[str, float]) -> None:
        """Take the incoming quantities at the beginning and at the end of the step that the world has just made.

        Those of other parts are the same at both.
        """

    def advance(self, now_ns: int) -> None:
        """Do what is due at `now_ns`."""

    def next_deadline_ns(self) -> int | None:
        """The next time at which `advance` has something to do, in ns of bench time; None for never.

        It is asked again after every call of the part.
        """
        return None

    def slave(self, name: str) -> I2cSlave:
        """Return what answers at an end of `BUSES`; asked for once, before `power_on`.

        The master may call it at times later than the last call of the part: a chip runs ahead of bench time, but never
        past the next call of the part.

        Raises:
            KeyError: the part has no such end.
        """
        raise KeyError(name)

    def spi_slave(self, name: str) -> SpiSlave:
        """Return what answers at an end of `SPI_BUSES`; see `slave`. A `PromisingSlave` is asked less often."""
        raise KeyError(name)

    def picture(self) -> Picture | None:
        """Return what its display shows at present; None if it has no display."""
        return None

    def receive(self, data: bytes, now_ns: int) -> None:
        """Take bytes that the serial end has received. It raises nothing, whatever they are."""

    def set(self, values: Mapping[str, float], now_ns: int) -> None:  # noqa: ARG002
        """Move controls; the others stay where they are.

        Raises:
            ValueError: there is no such control, or the value is out of its range. Nothing is moved then.
        """
        check_controls(self.CONTROLS, values)


def check_controls(controls: tuple[Control, ...], values: Mapping[str, float]) -> None:
    """Check what somebody wants controls to be; raises ValueError as `Part.set` does."""
    known = {control.name: control for control in controls}
    for name, value in values.items():
        control = known.get(name)
        if control is None:
            raise ValueError(f"no control '{name}'; there are: {', '.join(known) or 'none'}")
        if not control.least <= value <= control.greatest:
            raise ValueError(f"{name} goes from {control.least:g} to {control.greatest:g}, not to {value!r}")
