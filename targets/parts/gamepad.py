"""A game pad that drives: triggers to speed, stick to rotation, as the adapter of the original maps a PS5 controller.

R2 and L2 (0..255) are scaled to 0..400 mm/s (bachelor-thesis, Fig. 23) or 0..500 mm/s (pioneer_2DX-Interface
code-esp32_d1, task_controller.cpp); the speed is their difference. The right stick (-128..128) gives -170..170
hundredths of a rad/s, turned about. Up connects, down disconnects. All of it in whole numbers, as in C.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from targets.parts.part import Control, Direction, Part, Ports, Quantity, Terminal, check_controls
from targets.parts.settings import check_settings, setting

__all__ = ["PAD_CONTROLS", "Gamepad", "GamepadSettings", "PadMapping", "PadMoved", "PadState", "c_scale"]

PAD_CONTROLS = (
    Control(name="r2", least=0, greatest=255, text="right trigger: forward"),
    Control(name="l2", least=0, greatest=255, text="left trigger: backward"),
    Control(name="rx", least=-128, greatest=127, text="right stick: to the right is positive"),
    Control(name="up", least=0, greatest=1, text="button: connect"),
    Control(name="down", least=0, greatest=1, text="button: disconnect"),
)
"""What a person moves on the pad."""

TRACK_M = 2 / 0.0056 / 1000
"""Distance between the wheels of a Pioneer 2-DX: 2 / DiffConvFactor (AriaCoda params/p2dx.p), 0.357 m."""


def c_scale(value: int, old: tuple[int, int], new: tuple[int, int]) -> int:
    """Map one range to another in whole numbers, divided as in C (pioneer_2DX-Interface utils.cpp, `scale`)."""
    product, span = (value - old[0]) * (new[1] - new[0]), old[1] - old[0]
    quotient = abs(product) // abs(span)
    return new[0] + (quotient if (product >= 0) is (span > 0) else -quotient)


@dataclass(frozen=True, slots=True, kw_only=True)
class PadMapping:
    """What the pad means: `trigger_mm_s` at a whole trigger, `stick_mrad_s` at a whole stick."""

    trigger_mm_s: int
    stick_mrad_s: int

    def speed_m_s(self, r2: int, l2: int) -> float:
        """Speed for two triggers of 0..255."""
        forward, backward = (c_scale(trigger, (0, 255), (0, self.trigger_mm_s)) for trigger in (r2, l2))
        return (forward - backward) / 1000

    def turn_rad_s(self, rx: int) -> float:
        """Rotation, + counter-clockwise, for a stick of -128..127."""
        most = self.stick_mrad_s // 10
        return -c_scale(rx, (-128, 128), (-most, most)) / 100


class PadState:
    """Where everything on the pad is, and what that means.

    Args:
        mapping: what it means.

    Attributes:
        connected: up was pressed after down. Only then does the pad drive.
    """

    def __init__(self, mapping: PadMapping) -> None:
        self._mapping = mapping
        self._values = {control.name: round(control.rest) for control in PAD_CONTROLS}
        self.connected = False

    def set(self, values: Mapping[str, float]) -> None:
        """Move controls; raises ValueError as `Part.set` does."""
        check_controls(PAD_CONTROLS, values)
        self._values |= {name: round(value) for name, value in values.items()}
        if self._values["up"]:
            self.connected = True
        if self._values["down"]:
            self.connected = False

    @property
    def velocity(self) -> tuple[float, float]:
        """Speed in m/s and rotation in rad/s, whether connected or not."""
        values = self._values
        return self._mapping.speed_m_s(values["r2"], values["l2"]), self._mapping.turn_rad_s(values["rx"])


@dataclass(frozen=True, slots=True, kw_only=True)
class GamepadSettings:
    """What the pad means, and for which robot.

    Raises:
        ValueError: a value makes no pad.
    """

    trigger_mm_s: int = setting(
        500, "mm/s", "pioneer_2DX-Interface task_controller.cpp; 400: bachelor-thesis, Fig. 23", least=0, greatest=2200
    )
    stick_mrad_s: int = setting(1700, "mrad/s", "pioneer_2DX-Interface task_controller.cpp", least=0, greatest=8700)
    track_m: float = setting(TRACK_M, "m", "AriaCoda params/p2dx.p: 2 / DiffConvFactor", least=0.01)

    def __post_init__(self) -> None:
        check_settings(self)


@dataclass(frozen=True, slots=True, kw_only=True)
class PadMoved:
    """The pad asks for another motion: speed forward, rotation counter-clockwise; zero while it is not connected."""

    connected: bool
    speed_m_s: float
    turn_rad_s: float


class Gamepad(Part):
    """A pad that drives the wheels of a world by itself; see the head of this file."""

    TERMINALS = (Terminal(name="connected", direction=Direction.OUT, text="high between up and down"),)
    QUANTITIES = (
        Quantity(name="left", direction=Direction.OUT, unit="m/s", needed=False, text="rim of the left wheel"),
        Quantity(name="right", direction=Direction.OUT, unit="m/s", needed=False, text="rim of the right wheel"),
    )
    CONTROLS = PAD_CONTROLS
    Settings = GamepadSettings

    def __init__(self, settings: GamepadSettings, ports: Ports, *, seed: int) -> None:  # noqa: ARG002
        self._half_track_m = settings.track_m / 2
        mapping = PadMapping(trigger_mm_s=settings.trigger_mm_s, stick_mrad_s=settings.stick_mrad_s)
        self._state = PadState(mapping)
        self._output = ports.output("connected")
        self._tell = ports.tell
        self._reported = PadMoved(connected=False, speed_m_s=0.0, turn_rad_s=0.0)

    def power_on(self, now_ns: int) -> None:
        """Begin disconnected."""
        self._output.set(False, now_ns)

    def set(self, values: Mapping[str, float], now_ns: int) -> None:
        """Move controls of the pad; raises ValueError as `Part.set` does."""
        self._state.set(values)
        connected = self._state.connected
        speed_m_s, turn_rad_s = self._state.velocity if connected else (0.0, 0.0)
        moved = PadMoved(connected=connected, speed_m_s=speed_m_s, turn_rad_s=turn_rad_s)
        if connected is not self._reported.connected:
            self._output.set(connected, now_ns)
        if moved != self._reported:
            self._reported = moved
            self._tell(moved)

    def before_step(self, from_ns: int, to_ns: int) -> Mapping[str, float]:  # noqa: ARG002
        """Return the wheels' speeds."""
        aside_m_s = self._reported.turn_rad_s * self._half_track_m
        return {"left": self._reported.speed_m_s - aside_m_s, "right": self._reported.speed_m_s + aside_m_s}
