"""A dual full-bridge driver L298N (ST, data sheet L298): two motor channels with three inputs each.

============  ==========  ==========  =================================================================
enable        first       second      the channel (data sheet, figure 6, bidirectional DC motor control)
============  ==========  ==========  =================================================================
low           any         any         open: all four transistors off, the motor runs free
high          high        low         the supply less the drop across two transistors, forward
high          low         high        the same, backward
high          both the same           the motor is shorted: fast stop
============  ==========  ==========  =================================================================

The states of a slice are added up exactly, however short or long the pulses are against it: what goes out is the mean
of the voltage over the time in which the channel drives (0 in the rest), and the part of the time in which its circuit
is closed at all. Both together give the exact mean of a motor's current at constant speed. What counts for a physics
step is the slice since the step before, as the levels of the coming one are not known yet: one step late.

The drop grows with the current of the channel, along the straight line through the data sheet's two points, and the
supply sags behind its resistance by the current of both. These are the currents while a channel is closed, one step
late, and half of each change is taken at a time (choice: driver, battery and motors are a loop, whose gain is 0.7 with
two TT motors a channel). What is drawn from the supply is told one step late as well.

A jumper of the module at an enable input is a wire to 3v3. What is not modelled: `L298n.ABSENT`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from targets.parts.part import DigitalInput, Direction, Part, Ports, Quantity, Terminal
from targets.parts.settings import check_settings, setting

__all__ = ["L298n", "L298nOverload", "L298nSettings", "Shares", "bridge_shares"]

_DATA_SHEET = "ST data sheet L298"


@dataclass(frozen=True, slots=True, kw_only=True)
class L298nSettings:
    """The voltages across its transistors, and its own current.

    Raises:
        ValueError: a value makes no driver.
    """

    drop_1a_v: float = setting(
        2.55,
        "V at 1 A",
        f"{_DATA_SHEET}: VCEsat(H) 1.35 + VCEsat(L) 1.2 typical; total at least 1.80, at most 3.2",
        least=0,
    )
    drop_2a_v: float = setting(
        3.70, "V at 2 A", f"{_DATA_SHEET}: VCEsat(H) 2.0 + VCEsat(L) 1.7 typical; total at most 4.9", least=0.0
    )
    own_current_a: float = setting(
        0.05,
        "A",
        f"{_DATA_SHEET}: quiescent supply current 13 mA typical with low inputs, 50 mA with high ones",
        least=0.0,
    )
    limit_a: float = setting(2.0, "A a channel", f"{_DATA_SHEET}: DC operation; more is only reported", least=0.0)

    def __post_init__(self) -> None:
        check_settings(self)


@dataclass(frozen=True, slots=True, kw_only=True)
class L298nOverload:
    """A channel carries more than it may for long. It is told again after it has carried less."""

    channel: str
    current_a: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Shares:
    """The parts of a slice, 0..1, in which a channel drives forward, backward, and shorts the motor."""

    forward: float
    backward: float
    brake: float

    @property
    def driven(self) -> float:
        """The part in which the motor has voltage."""
        return self.forward + self.backward

    @property
    def closed(self) -> float:
        """The part in which current can flow."""
        return self.driven + self.brake


def bridge_shares(enable: DigitalInput, first: DigitalInput, second: DigitalInput, from_ns: int, to_ns: int) -> Shares:
    """Add up what a channel does between two times; between the same two, what it does then."""
    forward = backward = brake = 0
    for span_ns, (on, one, two) in _spans((enable, first, second), from_ns, to_ns):
        if on and one is two:
            brake += span_ns
        elif on and one:
            forward += span_ns
        elif on:
            backward += span_ns
    whole = max(1, to_ns - from_ns)
    return Shares(forward=forward / whole, backward=backward / whole, brake=brake / whole)


def _spans(wires: tuple[DigitalInput, ...], from_ns: int, to_ns: int) -> Iterator[tuple[int, list[bool]]]:
    """The spans in which no wire changes, with their levels; an empty slice is one span of 1 ns."""
    levels = [wire.level_at(from_ns) for wire in wires]
    changes = sorted(
        (ns, index, level) for index, wire in enumerate(wires) for ns, level in wire.changes(from_ns, to_ns - 1)
    )
    since_ns = from_ns
    for ns, index, level in changes:
        yield ns - since_ns, levels
        since_ns, levels[index] = ns, level
    yield max(to_ns, from_ns + 1) - since_ns, levels


class _Channel:
    """One of the two bridges."""

    def __init__(self, name: str, inputs: tuple[DigitalInput, DigitalInput, DigitalInput]) -> None:
        self.name = name
        self._inputs = inputs
        self.reset()

    def reset(self) -> None:
        """Begin open."""
        self.shares = Shares(forward=0.0, backward=0.0, brake=0.0)
        self.current_a = 0.0
        self.overloaded = False

    def load(self, mean_a: float) -> float:
        """Take the motors' mean current in the last step; return what of it came from the supply.

        A motor that is turned faster than the voltage would turn it drives current against the bridge, which the
        transistors do not let back into the supply.
        """
        closed = self.shares.closed
        if not closed:
            return 0.0
        self.current_a += (abs(mean_a) / closed - self.current_a) / 2
        along_a = mean_a if self.shares.forward >= self.shares.backward else -mean_a
        return max(0.0, along_a) * self.shares.driven / closed

    def advance(self, from_ns: int, to_ns: int) -> None:
        """Take the slice that counts for the next step."""
        self.shares = bridge_shares(*self._inputs, from_ns, to_ns)


class L298n(Part):
    """See the head of this file."""

    TERMINALS = (
        Terminal(name="ena", direction=Direction.IN, needed=True, text="enables channel A"),
        Terminal(name="in1", direction=Direction.IN, needed=True, text="high: OUT1 to the supply, low: to ground"),
        Terminal(name="in2", direction=Direction.IN, needed=True, text="the same for OUT2"),
        Terminal(name="in3", direction=Direction.IN, needed=True, text="the same for OUT3"),
        Terminal(name="in4", direction=Direction.IN, needed=True, text="the same for OUT4"),
        Terminal(name="enb", direction=Direction.IN, needed=True, text="enables channel B"),
    )
    QUANTITIES = (
        Quantity(name="supply", direction=Direction.IN, unit="V", text="of the motors, without a load"),
        Quantity(name="source", direction=Direction.IN, unit="ohm", needed=False, text="resistance of the supply"),
        *(
            Quantity(
                name=f"load_{channel}{number}",
                direction=Direction.IN,
                unit="A",
                needed=False,
                late=True,
                text=f"of a motor on channel {channel.upper()}, + from its first output to its second",
            )
            for channel in "ab"
            for number in (1, 2)
        ),
        Quantity(
            name="out_a", direction=Direction.OUT, unit="V", needed=False, text="mean of OUT1 less OUT2 as it drives"
        ),
        Quantity(name="closed_a", direction=Direction.OUT, unit="1", needed=False, text="part of the time A conducts"),
        Quantity(
            name="out_b", direction=Direction.OUT, unit="V", needed=False, text="mean of OUT3 less OUT4 as it drives"
        ),
        Quantity(name="closed_b", direction=Direction.OUT, unit="1", needed=False, text="part of the time B conducts"),
        Quantity(name="current", direction=Direction.OUT, unit="A", needed=False, text="from the supply, mean"),
    )
    ABSENT = (
        "temperature and what it shuts off",
        "dead times of a few microseconds",
        "freewheeling diodes, and the current that an inductance drives through them after a pulse",
        "the drop while a motor is shorted (0 here)",
        "inputs that are neither high nor low",
        "the module's regulator",
    )
    Settings = L298nSettings

    def __init__(self, settings: L298nSettings, ports: Ports, *, seed: int) -> None:  # noqa: ARG002
        self._settings = settings
        self._tell = ports.tell
        self._channels = tuple(
            _Channel(name, (ports.input(enable), ports.input(first), ports.input(second)))
            for name, enable, first, second in (("a", "ena", "in1", "in2"), ("b", "enb", "in3", "in4"))
        )
        self._values: Mapping[str, float] = {}
        self._since_ns = 0

    def power_on(self, now_ns: int) -> None:
        """Begin open."""
        self._since_ns = now_ns
        self._values = {}
        for channel in self._channels:
            channel.reset()

    def feed(self, values: Mapping[str, float]) -> None:
        """Take the supply's voltage, and the currents of the last step."""
        self._values = values

    def before_step(self, from_ns: int, to_ns: int) -> Mapping[str, float]:  # noqa: ARG002
        """Return what the slice since the last step puts on the motors."""
        given = {"current": self._settings.own_current_a}
        for channel in self._channels:
            given["current"] += channel.load(self._load(channel.name))
            self._watch(channel)
            channel.advance(self._since_ns, from_ns)
        self._since_ns = from_ns
        for channel in self._channels:
            given[f"out_{channel.name}"] = self._volts(channel) * (channel.shares.forward - channel.shares.backward)
            given[f"closed_{channel.name}"] = channel.shares.closed
        return given

    def _volts(self, channel: _Channel) -> float:
        """What a channel puts on its motors while it drives them."""
        others_a = sum(one.current_a * one.shares.driven for one in self._channels if one is not channel)
        drawn_a = channel.current_a + others_a + self._settings.own_current_a
        sag_v = drawn_a * self._values.get("source", 0.0)
        return max(0.0, self._values.get("supply", 0.0) - sag_v - self._drop(channel.current_a))

    def _load(self, channel: str) -> float:
        return sum(self._values.get(f"load_{channel}{number}", 0.0) for number in (1, 2))

    def _drop(self, current_a: float) -> float:
        one, two = self._settings.drop_1a_v, self._settings.drop_2a_v
        return max(0.0, one + (two - one) * (current_a - 1.0))

    def _watch(self, channel: _Channel) -> None:
        over = channel.current_a > self._settings.limit_a
        if over and not channel.overloaded:
            self._tell(L298nOverload(channel=channel.name, current_a=channel.current_a))
        channel.overloaded = over
