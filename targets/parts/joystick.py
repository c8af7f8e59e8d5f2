"""A joystick: two potentiometers across the supply, and a switch to ground under the stick.

The calibration is that of the original's joystick: what a converter of 16 bits made of each axis at both ends and in
between (toffanetto/im420x, nucleo-H753ZI_TemplateAutoware_Serial Core, taksControle.c). It has a dead band of 500 of
these codes round the middle and no limit at the ends. From a deflection of -1, 0 or 1 an ideal converter makes exactly
the figures of the calibration, and what lies between is on a straight line, so that every code can be asked for
(`AxisCalibration.deflection`).

The switch is a bare contact, which bounces as it closes and as it opens; who reads it has to pull it up. The original's
board uses the pull-up of its chip, and acts on the rising edge, which is the release.
"""

from __future__ import annotations

import random
from collections.abc import Mapping
from dataclasses import dataclass

from targets.parts.part import Control, Direction, Part, Ports, Terminal, check_controls
from targets.parts.settings import check_settings, setting

__all__ = ["CODES", "AxisCalibration", "Joystick", "JoystickMoved", "JoystickSettings"]

CODES = 65536
"""Of a converter of 16 bits; the last one is 65535."""

_ORIGINAL = "toffanetto/im420x taksControle.c, 16 bits"
_BEYOND = 1.04
"""How far an axis can be told to go, so that code 0, a wire that has come off, can be asked for as well."""


@dataclass(frozen=True, slots=True)
class AxisCalibration:
    """What a converter of 16 bits makes of an axis: at -1, at rest and at 1."""

    least: int
    zero: int
    greatest: int

    def code(self, deflection: float) -> float:
        """Return what a converter without steps would read; not less than 0, nor more than 65535."""
        span = self.greatest - self.zero if deflection > 0 else self.zero - self.least
        return max(0.0, min(CODES - 1, self.zero + deflection * span))

    def deflection(self, code: int) -> float:
        """Return the deflection from which a converter makes this code."""
        span = self.greatest - self.zero if code > self.zero else self.zero - self.least
        return (code - self.zero) / span


@dataclass(frozen=True, slots=True, kw_only=True)
class JoystickSettings:
    """What the joystick is like.

    Raises:
        ValueError: a value makes no joystick.
    """

    x_min: int = setting(1057, "LSB", _ORIGINAL, least=0, greatest=CODES - 1)
    x_zero: int = setting(33970, "LSB", _ORIGINAL, least=0, greatest=CODES - 1)
    x_max: int = setting(65535, "LSB", _ORIGINAL, least=0, greatest=CODES - 1)
    y_min: int = setting(1062, "LSB", _ORIGINAL, least=0, greatest=CODES - 1)
    y_zero: int = setting(33580, "LSB", _ORIGINAL, least=0, greatest=CODES - 1)
    y_max: int = setting(65535, "LSB", _ORIGINAL, least=0, greatest=CODES - 1)
    supply_v: float = setting(
        3.3, "V", "assumed: the supply and the reference of the board it is soldered to", least=0.1
    )
    noise_v: float = setting(0.0, "V", "choice; standard deviation at each axis", least=0.0)
    noise_period_ms: float = setting(1.0, "ms", "choice; how often noise changes", least=0.01)
    bounce_ms: float = setting(2.0, "ms", "assumed: common for small switches; 0 for none", least=0.0, greatest=100.0)
    bounces: int = setting(4, "1", "assumed: times that a contact parts again, at most", least=0, greatest=100)

    def __post_init__(self) -> None:
        check_settings(self)
        for axis in "xy":
            least, zero, greatest = (getattr(self, f"{axis}_{name}") for name in ("min", "zero", "max"))
            if not least < zero < greatest:
                raise ValueError(f"{axis}_zero must lie between {axis}_min and {axis}_max")

    @property
    def axes(self) -> tuple[AxisCalibration, AxisCalibration]:
        """The calibration of X and of Y."""
        return (
            AxisCalibration(self.x_min, self.x_zero, self.x_max),
            AxisCalibration(self.y_min, self.y_zero, self.y_max),
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class JoystickMoved:
    """A person has moved the stick, or pressed or released it: -1 to 1, and whether the switch is down."""

    x: float
    y: float
    pressed: bool


class Joystick(Part):
    """See the head of this file."""

    TERMINALS = (
        Terminal(name="vrx", direction=Direction.OUT, analog=True, needed=True, text="wiper of X"),
        Terminal(name="vry", direction=Direction.OUT, analog=True, needed=True, text="wiper of Y"),
        Terminal(name="sw", direction=Direction.OUT, text="to ground while pressed, else open"),
    )
    CONTROLS = (
        Control(name="x", least=-_BEYOND, greatest=_BEYOND, text="1 is the end with the highest voltage"),
        Control(name="y", least=-_BEYOND, greatest=_BEYOND, text="as x; the original speeds up towards 1"),
        Control(name="press", least=0, greatest=1, text="1 is down"),
    )
    ABSENT = ("resistance of the potentiometers: each wiper is a stiff source", "hysteresis and wear of the springs")
    Settings = JoystickSettings

    def __init__(self, settings: JoystickSettings, ports: Ports, *, seed: int) -> None:
        self._settings = settings
        self._axes = settings.axes
        self._wipers = ports.analog("vrx"), ports.analog("vry")
        self._switch = ports.output("sw")
        self._tell = ports.tell
        self._noise = random.Random(f"noise {seed}")
        self._contact = random.Random(f"contact {seed}")
        self._place = {control.name: control.rest for control in self.CONTROLS}
        self._noise_due_ns: int | None = None
        self._edges: list[tuple[int, bool]] = []

    def power_on(self, now_ns: int) -> None:
        """Nobody touches it."""
        self._switch.set(None, now_ns)
        self._put_wipers(now_ns)

    def set(self, values: Mapping[str, float], now_ns: int) -> None:
        """Move controls; raises ValueError as `Part.set` does."""
        check_controls(self.CONTROLS, values)
        was_pressed = self._pressed
        self._place |= values
        if self._pressed is not was_pressed:
            self._edges = self._bouncing(self._pressed, now_ns)
            self._advance_switch(now_ns)
        self._put_wipers(now_ns)
        self._tell(JoystickMoved(x=self._place["x"], y=self._place["y"], pressed=self._pressed))

    def advance(self, now_ns: int) -> None:
        """Let noise change, and the contact bounce."""
        self._advance_switch(now_ns)
        if self._noise_due_ns is not None and self._noise_due_ns <= now_ns:
            self._put_wipers(now_ns)

    def next_deadline_ns(self) -> int | None:
        """When the contact moves again, or noise changes."""
        due = [self._noise_due_ns, self._edges[0][0] if self._edges else None]
        return min((ns for ns in due if ns is not None), default=None)

    @property
    def _pressed(self) -> bool:
        return self._place["press"] >= 0.5

    def _put_wipers(self, now_ns: int) -> None:
        settings = self._settings
        for wiper, axis, name in zip(self._wipers, self._axes, "xy", strict=True):
            volts = axis.code(self._place[name]) / CODES * settings.supply_v
            if settings.noise_v:
                volts += self._noise.gauss(0.0, settings.noise_v)
            wiper.put(max(0.0, min(settings.supply_v, volts)), now_ns)
        if settings.noise_v:
            self._noise_due_ns = now_ns + round(settings.noise_period_ms * 1e6)

    def _bouncing(self, closed: bool, now_ns: int) -> list[tuple[int, bool]]:
        """Return when the contact closes (True) and opens: at once, and then there and back some times."""
        length_ns = round(self._settings.bounce_ms * 1e6)
        times = self._contact.randint(0, self._settings.bounces) if length_ns else 0
        moments = sorted(now_ns + self._contact.randint(1, length_ns) for _ in range(2 * times))
        return [(now_ns, closed), *((ns, closed is bool(index % 2)) for index, ns in enumerate(moments))]

    def _advance_switch(self, now_ns: int) -> None:
        while self._edges and self._edges[0][0] <= now_ns:
            ns, closed = self._edges.pop(0)
            self._switch.set(False if closed else None, ns)
