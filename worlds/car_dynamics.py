"""A car as a dynamic bicycle: both wheels of an axle in one, moved in the plane by the forces of its tyres.

Seven states: position and heading of the reference point (the middle of the rear axle), forward and sideways speed and
turn rate of the centre of mass, tyre angle. A tyre's lateral force is proportional to its slip angle until friction
ends it (R. Rajamani, Vehicle Dynamics and Control, 2nd ed., 2.3). Slower than walking pace, where slip angles lose
their sense, the tyres roll without slip (the kinematic bicycle, 2.2 there) and what is left of a slip dies away;
between the two speeds of `CarParameters` the one turns smoothly into the other. Along the car act engine, brakes,
rolling resistance, drag, and what cornering takes.

Integrated by Runge-Kutta of fourth order in steps of at most 5 ms, whatever the world's own step.

Not modelled (`CarDynamics.ABSENT`): what is said there.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import ClassVar

from worlds.car_commands import CarCommand, CommandLayer, Effort
from worlds.car_parameters import DEFAULTS, GRAVITY_M_S2, CarParameters
from worlds.motion import PlanarPose, PlanarVelocity

__all__ = ["MAX_STEP_S", "CarDynamics"]

MAX_STEP_S = 0.005
"""At the lowest speed at which slip counts, tyres settle in 8 ms: steps of this length resolve that."""

_STILL_M_S = 1e-12
"""What is left by rounding where a controller stops the car."""

_State = tuple[float, float, float, float, float, float, float]


class CarDynamics:
    """See the module. A `worlds.motion.PlanarMotion`.

    Args:
        parameters: of the car.
        floor_friction: Coulomb coefficient of the floor; at 1.0 that of the parameters is the real one.

    Attributes:
        parameters: of the car on this floor.
        layer: what turns commands into what acts on the car.
    """

    ABSENT: ClassVar[tuple[str, ...]] = (
        "reverse gear: a speed below zero stops the car; only an obstacle can push it backwards",
        "gearbox, engine speed and engine braking: the throttle is a force",
        "suspension, roll and pitch, load transfer: the axles bear what they bear at rest",
        "combined slip: braking takes nothing from a tyre's lateral grip, and no wheel locks or spins",
        "relaxation length of tyres, self-aligning torque, play and lag of the steering",
        "slopes: the car drives in the plane, and a ramp is an obstacle",
    )

    _state: _State

    def __init__(self, parameters: CarParameters = DEFAULTS, floor_friction: float = 1.0) -> None:
        parameters = replace(parameters, friction=parameters.friction * floor_friction)
        self.parameters = parameters
        self.layer = CommandLayer(parameters)
        self._drag_n_s2_m2 = parameters.air_density_kg_m3 * parameters.drag_coefficient * parameters.drag_area_m2 / 2
        self._rolling_n = parameters.rolling_resistance * parameters.mass_kg * GRAVITY_M_S2
        self._state = (0.0,) * 7
        self._speed_before_m_s = 0.0
        self._step_s = 1.0

    # --- what the car does

    @property
    def pose(self) -> PlanarPose:
        """Where the reference point is."""
        x, y, yaw = self._state[:3]
        return PlanarPose(x, y, math.remainder(yaw, math.tau))

    @property
    def velocity(self) -> PlanarVelocity:
        """How the reference point moves along the scene's axes."""
        yaw, along, across = self._state[2], self.lon_speed_m_s, self.lat_speed_m_s
        cos, sin = math.cos(yaw), math.sin(yaw)
        return PlanarVelocity(cos * along - sin * across, sin * along + cos * across, self._state[5])

    @property
    def lon_speed_m_s(self) -> float:
        """Speed along the car, + forward."""
        return self._state[3]

    @property
    def lat_speed_m_s(self) -> float:
        """Speed of the reference point across the car, + left."""
        return self._state[4] - self.parameters.com_ahead_m * self._state[5]

    @property
    def yaw_rate_rad_s(self) -> float:
        """Turn rate, + left."""
        return self._state[5]

    @property
    def steering_rad(self) -> float:
        """Tyre angle, + left."""
        return self._state[6]

    @property
    def lon_accel_m_s2(self) -> float:
        """How fast the speed along the car changed in the last step."""
        return (self._state[3] - self._speed_before_m_s) / self._step_s

    # --- what moves it

    def advance(self, dt_s: float) -> None:
        """Move on by a step of this length under the command in force."""
        self._speed_before_m_s, self._step_s = self._state[3], dt_s
        steps = math.ceil(dt_s / MAX_STEP_S - 1e-9)
        for _ in range(steps):
            self._step(dt_s / steps)

    def place(self, pose: PlanarPose) -> None:
        """Stand still there with free pedals; the tyre angle stays."""
        self._state = (pose.x_m, pose.y_m, pose.yaw_rad, 0.0, 0.0, 0.0, self._state[6])
        self._speed_before_m_s = 0.0
        self.layer.command = CarCommand()
        self.layer.accel_m_s2 = 0.0

    def adopt(self, pose: PlanarPose, velocity: PlanarVelocity) -> None:
        """Go on from where an obstacle let the car go; the command stays in force."""
        cos, sin = math.cos(pose.yaw_rad), math.sin(pose.yaw_rad)
        along = cos * velocity.x_m_s + sin * velocity.y_m_s
        across = cos * velocity.y_m_s - sin * velocity.x_m_s
        turning = velocity.yaw_rad_s
        sideways = across + self.parameters.com_ahead_m * turning
        self._state = (pose.x_m, pose.y_m, pose.yaw_rad, along, sideways, turning, self._state[6])

    def _step(self, dt: float) -> None:
        before = self._state
        speed = before[3]
        effort = self.layer.effort(speed, before[6], dt)
        held = effort.accel_m_s2 is None and effort.push_n <= effort.brake_n + self._rolling_n
        if held and not speed:
            effort = Effort(effort.steering_rate_rad_s, 0.0, 0.0, 0.0)
        # Whatever opposes the motion does so in one direction for the whole step: it would not settle otherwise.
        way = -1.0 if speed < 0 else 1.0
        one = self._rates(before, effort, way)
        two = self._rates(_moved(before, one, dt / 2), effort, way)
        three = self._rates(_moved(before, two, dt / 2), effort, way)
        four = self._rates(_moved(before, three, dt), effort, way)
        mean = [(a + 2 * b + 2 * c + d) / 6 for a, b, c, d in zip(one, two, three, four, strict=True)]
        after = _moved(before, mean, dt)
        turned = after[3] * speed < 0 if held else after[3] < 0 <= speed
        if turned or abs(after[3]) < _STILL_M_S:
            after = (*after[:3], 0.0, *after[4:])  # what opposes the motion ends with it, brakes let go slowly included
        self._state = after
        self.layer.accel_m_s2 = (after[3] - speed) / dt

    # --- forces

    def _rates(self, state: _State, effort: Effort, way: float) -> _State:
        """Return how fast each state changes."""
        p = self.parameters
        yaw, vx, vy, turning, angle = state[2:]
        share = _smooth((vx - p.kinematic_below_m_s) / (p.dynamic_above_m_s - p.kinematic_below_m_s))
        front_n, rear_n = self._lateral_n(vx, vy, turning, angle) if share else (0.0, 0.0)
        cornering = share * (turning * vy - front_n * math.sin(angle) / p.mass_kg)
        vx_rate = self._along(vx, cornering, effort, way)
        vy_rate, turning_rate = 0.0, 0.0
        if share:
            steered_n = front_n * math.cos(angle)
            vy_rate += share * ((steered_n + rear_n) / p.mass_kg - turning * vx)
            turning_rate += share * (p.front_arm_m * steered_n - p.com_ahead_m * rear_n) / p.yaw_inertia_kg_m2
        if share < 1:
            slow_vy, slow_turning = self._rolling(state, vx_rate, effort.steering_rate_rad_s)
            vy_rate += (1 - share) * slow_vy
            turning_rate += (1 - share) * slow_turning
        cos, sin = math.cos(yaw), math.sin(yaw)
        across = vy - p.com_ahead_m * turning
        return (
            cos * vx - sin * across,
            sin * vx + cos * across,
            turning,
            vx_rate,
            vy_rate,
            turning_rate,
            effort.steering_rate_rad_s,
        )

    def _lateral_n(self, vx: float, vy: float, turning: float, angle: float) -> tuple[float, float]:
        """Lateral forces of the front and the rear tyres, by their slip angles."""
        p = self.parameters
        front_slip = angle - math.atan2(vy + p.front_arm_m * turning, vx)
        rear_slip = -math.atan2(vy - p.com_ahead_m * turning, vx)
        front_most, rear_most = p.friction * p.front_load_n, p.friction * p.rear_load_n
        return (
            max(-front_most, min(front_most, p.front_stiffness_n_rad * front_slip)),
            max(-rear_most, min(rear_most, p.rear_stiffness_n_rad * rear_slip)),
        )

    def _along(self, vx: float, cornering: float, effort: Effort, way: float) -> float:
        """Acceleration along the car, which rolls this way: 1 is forward, -1 back."""
        p = self.parameters
        resistance_n = way * self._rolling_n + self._drag_n_s2_m2 * vx * abs(vx)
        if effort.accel_m_s2 is None:
            force_n = effort.push_n - way * effort.brake_n
        else:
            force_n = p.mass_kg * (effort.accel_m_s2 - cornering) + resistance_n
            force_n = max(-p.grip_n, min(self.layer.push_limit_n(vx), force_n))
        return (force_n - resistance_n) / p.mass_kg + cornering

    def _rolling(self, state: _State, vx_rate: float, steering_rate: float) -> tuple[float, float]:
        """Rates of sideways speed and turn rate of tyres that roll without slip, or come to do so."""
        p = self.parameters
        _, _, _, vx, vy, turning, angle = state
        tan = math.tan(angle)
        ideal = vx * tan / p.wheelbase_m
        ideal_rate = (vx_rate * tan + vx * steering_rate * (1 + tan * tan)) / p.wheelbase_m
        grip = p.friction * GRAVITY_M_S2
        turn_grip = grip * p.mass_kg * p.wheelbase_m / 4 / p.yaw_inertia_kg_m2
        slip_rate = (p.com_ahead_m * ideal - vy) / p.settling_s
        spin_rate = (ideal - turning) / p.settling_s
        return (
            p.com_ahead_m * ideal_rate + max(-grip, min(grip, slip_rate)),
            ideal_rate + max(-turn_grip, min(turn_grip, spin_rate)),
        )


def _moved(state: _State, rates: _State | list[float], dt: float) -> _State:
    x, y, yaw, vx, vy, turning, angle = state
    a, b, c, d, e, f, g = rates
    return x + a * dt, y + b * dt, yaw + c * dt, vx + d * dt, vy + e * dt, turning + f * dt, angle + g * dt


def _smooth(place: float) -> float:
    """0 up to 0, 1 from 1 on, and without a kink between."""
    if place <= 0:
        return 0.0
    return 1.0 if place >= 1 else place * place * (3 - 2 * place)
