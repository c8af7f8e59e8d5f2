"""A gear motor with brushes behind a driver: the law of a permanent-magnet motor, at the shaft of the wheel.

The torque falls on a straight line with the speed, from that at standstill to none at the idle speed, and the line
moves with the voltage; the current does the same. While the circuit is open no current flows, so there is no torque
either, and nothing brakes but friction; while it is closed without voltage (shorted) the motor brakes by the current
that it drives itself. All of this is linear, so the means over a physics step are exact at constant speed; the speed is
that at the beginning of the step.

Friction is dry, and less while the shaft turns than at standstill: it falls from the breakaway torque to the running
one by exp(-speed / friction speed), after Tustin. That is why a motor needs more to start than to go on. The physics
opposes the motion with it; it is what stops a motor whose circuit is open. With the default figures a wheel in the air
behind an L298N on two full cells, pulsed at 50 Hz, does what was measured on the original (docs/rover-vehicle.md).

The figures are those at the wheel, behind a gear of 1:48. The rotor's inertia, times 48 squared, is a figure of the
vehicle (`worlds.vehicles.rover_4wd`), because the physics has to turn it. What is not modelled: `DcMotor.ABSENT`.

The published lines make a gear that loses four fifths of the power. A motor that is turned faster than its voltage
would turn it keeps to the same lines (choice); they then take less torque than such a gear would.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from targets.parts.part import Control, Direction, Part, Ports, Quantity, check_controls
from targets.parts.settings import check_settings, setting

__all__ = ["DcMotor", "DcMotorSettings", "MotorHeld"]

_AS_SOLD = "TT motor 1:48, as sold"


@dataclass(frozen=True, slots=True, kw_only=True)
class DcMotorSettings:
    """The two straight lines and the friction.

    Raises:
        ValueError: a value makes no motor.
    """

    nominal_v: float = setting(6.0, "V", f"{_AS_SOLD}: at which the next three are", least=0.1)
    stall_torque_nm: float = setting(0.08, "N·m", f"{_AS_SOLD}: 0.8 kg·cm at 6 V", least=0.0)
    idle_speed_rad_s: float = setting(
        20.9, "rad/s", f"{_AS_SOLD}: 200 rpm at 6 V, taken as without friction", least=0.1
    )
    stall_current_a: float = setting(1.5, "A", "assumed: sellers say 0.6 to 1.5 at 6 V", least=0.0)
    breakaway_torque_nm: float = setting(
        0.0128, "N·m", "assumed: starts at a throttle of 0.23, see docs/rover-vehicle.md", least=0.0
    )
    running_torque_nm: float = setting(0.0082, "N·m", "assumed: makes 154 mA when idling; sellers say 150", least=0.0)
    friction_speed_rad_s: float = setting(
        2.85, "rad/s", "assumed: stops at a throttle of 0.19, see docs/rover-vehicle.md", least=0.01
    )
    reversed: bool = setting(False, "", "choice: True for wires that are swapped, + then turns the wheel backward")
    hold_torque_nm: float = setting(5.0, "N·m", "choice: what a hand holds the wheel with", least=0.0)

    def __post_init__(self) -> None:
        check_settings(self)
        if self.running_torque_nm > self.breakaway_torque_nm:
            raise ValueError(f"running_torque_nm must be at most that of breakaway, {self.breakaway_torque_nm}")


@dataclass(frozen=True, slots=True, kw_only=True)
class MotorHeld:
    """A hand blocks the wheel, or lets it go."""

    held: bool


class DcMotor(Part):
    """See the head of this file."""

    QUANTITIES = (
        Quantity(name="volts", direction=Direction.IN, unit="V", text="mean across the motor, 0 while it is open"),
        Quantity(
            name="closed", direction=Direction.IN, unit="1", text="part of the time in which its circuit is closed"
        ),
        Quantity(name="speed", direction=Direction.IN, unit="rad/s", text="of the wheel, + forward"),
        Quantity(name="torque", direction=Direction.OUT, unit="N·m", text="on the wheel, + forward"),
        Quantity(name="friction", direction=Direction.OUT, unit="N·m", text="of gear and brushes, against the motion"),
        Quantity(name="current", direction=Direction.OUT, unit="A", needed=False, text="mean; + flows in at +"),
    )
    CONTROLS = (Control(name="hold", least=0, greatest=1, text="1: a hand blocks the wheel"),)
    ABSENT = (
        "inductance (0.5 ms against pulses of milliseconds)",
        "ripple of the commutator",
        "backlash and teeth of the gear",
        "heat",
    )
    Settings = DcMotorSettings

    def __init__(self, settings: DcMotorSettings, ports: Ports, *, seed: int) -> None:  # noqa: ARG002
        self._settings = settings
        self._tell = ports.tell
        self._values: Mapping[str, float] = {}
        self._held = False

    def power_on(self, now_ns: int) -> None:  # noqa: ARG002
        """Begin without current."""
        self._values = {}

    def set(self, values: Mapping[str, float], now_ns: int) -> None:  # noqa: ARG002
        """Hold the wheel, or let it go: from the next physics step on."""
        check_controls(self.CONTROLS, values)
        held = values.get("hold", float(self._held)) > 0
        if held is not self._held:
            self._held = held
            self._tell(MotorHeld(held=held))

    def feed(self, values: Mapping[str, float]) -> None:
        """Take the voltage for the step, and the speed at its beginning."""
        self._values = values

    def before_step(self, from_ns: int, to_ns: int) -> Mapping[str, float]:  # noqa: ARG002
        """Return torque, friction and current for the step."""
        settings = self._settings
        volts, closed, speed = (self._values.get(name, 0.0) for name in ("volts", "closed", "speed"))
        sign = -1.0 if settings.reversed else 1.0
        share = volts / settings.nominal_v - closed * sign * speed / settings.idle_speed_rad_s
        return {
            "torque": sign * share * settings.stall_torque_nm,
            "friction": self._friction_nm(speed),
            "current": share * settings.stall_current_a,
        }

    def _friction_nm(self, speed_rad_s: float) -> float:
        settings = self._settings
        if self._held:
            return settings.hold_torque_nm
        extra_nm = settings.breakaway_torque_nm - settings.running_torque_nm
        return settings.running_torque_nm + extra_nm * math.exp(-abs(speed_rad_s) / settings.friction_speed_rad_s)
