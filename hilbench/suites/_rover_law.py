"""What a rover's wheels should do by the figures of its parts: one wheel, its motor, its half of a driver, its battery.

Reckoned beside the bench, in its own way: the circuit is solved at each moment and the wheel's speed is summed in
steps that are short against a pulse of the motors' voltage, where the bench takes means over steps of its physics. The
figures are those that the parts and the vehicle have unless somebody sets others (docs/parts.md, docs/vehicles.md);
what a rover with other figures does is then not what it should.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from targets.parts.battery import BatterySettings, cell_volts
from targets.parts.dc_motor import DcMotorSettings
from targets.parts.l298n import L298nSettings
from worlds.vehicles.rover_4wd import DEFAULTS

__all__ = ["CARRIED_KG_M2", "FULL_V", "LIFTED_KG_M2", "Driven", "settled_rpm", "volts_at", "wheel_course"]

STEP_S = 2e-4
"""Of the sums; a hundredth of a pulse's period."""

PERIOD_S = 0.020
"""Of the pulses: 50 Hz, what Mbed OS takes unless it is told otherwise; the published firmware never tells it."""

SETTLED_S = 2.5
"""Seven times the time a wheel in the air takes to its speed."""

_MOTOR, _DRIVER, _CELLS = DcMotorSettings(), L298nSettings(), BatterySettings()
_MOTORS_A_CHANNEL = 2

LIFTED_KG_M2 = DEFAULTS.wheel_mass_kg * DEFAULTS.wheel_radius_m**2 / 2 + DEFAULTS.reflected_inertia_kg_m2
"""What a wheel in the air has to turn: itself, and its motor's rotor behind the gear."""

CARRIED_KG_M2 = LIFTED_KG_M2 + DEFAULTS.mass_kg * DEFAULTS.wheel_radius_m**2 / 4
"""What it has to turn on the floor, where it moves a quarter of the rover as well."""


def volts_at(charge: float) -> float:
    """Return the voltage of the battery without a load, at a charge of 0 to 1."""
    return _CELLS.cells * cell_volts(charge)


FULL_V = volts_at(1.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Driven:
    """What drives a wheel; all four wheels are driven alike.

    Attributes:
        throttle: share of full voltage, 0 to 1.
        emf_v: of the battery without a load.
        inertia_kg_m2: what the wheel has to turn.
        start_rpm: its speed at the beginning.
    """

    throttle: float
    emf_v: float = FULL_V
    inertia_kg_m2: float = LIFTED_KG_M2
    start_rpm: float = 0.0


def wheel_course(driven: Driven, duration_s: float) -> Iterator[float]:
    """Yield the wheel's speed in rad/s after each `STEP_S`; pulses begin at 0 and then every `PERIOD_S`."""
    speed = driven.start_rpm * math.tau / 60
    steps_a_period = round(PERIOD_S / STEP_S)
    high = round(driven.throttle * steps_a_period)
    for step in range(round(duration_s / STEP_S)):
        torque_nm = _torque_nm(speed, driven.emf_v) if step % steps_a_period < high else 0.0
        speed = _turned(speed, torque_nm, driven.inertia_kg_m2)
        yield speed


def settled_rpm(driven: Driven) -> float:
    """Return the mean speed over the last ten periods of a course that is long enough for it to settle."""
    course = list(wheel_course(driven, SETTLED_S))
    last = course[-round(10 * PERIOD_S / STEP_S) :]
    return sum(last) / len(last) * 60 / math.tau


def _torque_nm(speed: float, emf_v: float) -> float:
    """The motor's torque while its channel conducts, + forward: where its line meets that of the circuit.

    Volts at the motor: ``emf - resistance * (all channels + own current) - drop``, the last along the line through the
    driver's two points.
    """
    slope_v_a = _DRIVER.drop_2a_v - _DRIVER.drop_1a_v
    base_v = emf_v - _CELLS.resistance_ohm * _DRIVER.own_current_a - (_DRIVER.drop_1a_v - slope_v_a)
    # Of one motor's current: its channel carries two of them, the battery four.
    per_motor_ohm = _MOTORS_A_CHANNEL * slope_v_a + 2 * _MOTORS_A_CHANNEL * _CELLS.resistance_ohm
    winding_ohm = _MOTOR.nominal_v / _MOTOR.stall_current_a
    induced_v = speed / _MOTOR.idle_speed_rad_s * _MOTOR.nominal_v
    current_a = max(0.0, base_v - induced_v) / (winding_ohm + per_motor_ohm)
    return current_a / _MOTOR.stall_current_a * _MOTOR.stall_torque_nm


def _turned(speed: float, torque_nm: float, inertia_kg_m2: float) -> float:
    """The speed a step later; dry friction holds a wheel that stands, and never turns one round."""
    extra_nm = _MOTOR.breakaway_torque_nm - _MOTOR.running_torque_nm
    friction_nm = _MOTOR.running_torque_nm + extra_nm * math.exp(-abs(speed) / _MOTOR.friction_speed_rad_s)
    pushed = speed + torque_nm / inertia_kg_m2 * STEP_S
    return max(0.0, pushed - friction_nm / inertia_kg_m2 * STEP_S)
