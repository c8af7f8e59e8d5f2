"""The figures of a car: what its dynamics, its command layer and its body for the physics are made of.

A saloon of the middle class with front-wheel drive. Where the ROS bridge of CARLA assumes a figure for every car, so do
we, because commands that were tuned there then do the same here; what it does not say is assumed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from worlds.vehicles.model import ASSUMED, parameter

__all__ = ["DEFAULTS", "GRAVITY_M_S2", "CarParameters"]

GRAVITY_M_S2 = 9.81

_CARLA = "carla-simulator/ros-bridge carla_control_physics.py"
_NODE = "carla-simulator/ros-bridge carla_ackermann_control_node.py"
_BRIDGE = "LMA-FEM-UNICAMP/Carla-Autoware-Bridge steering_status.py"
_TYPICAL = f"{ASSUMED}: typical of a saloon of this size"


@dataclass(frozen=True, slots=True, kw_only=True)
class CarParameters:
    """The figures of the car; `worlds.vehicles.model.parameter_table` lists them with unit and source."""

    mass_kg: float = parameter(1500.0, "kg", f"{_CARLA}: get_vehicle_mass, default")
    yaw_inertia_kg_m2: float = parameter(2500.0, "kg·m²", _TYPICAL)
    wheelbase_m: float = parameter(2.85, "m", _TYPICAL)
    com_ahead_m: float = parameter(1.50, "m", f"{ASSUMED}: centre of mass, ahead of the rear axle; 53 % on the front")
    front_stiffness_n_rad: float = parameter(80e3, "N/rad", f"{ASSUMED}: lateral, both front tyres together")
    rear_stiffness_n_rad: float = parameter(90e3, "N/rad", f"{ASSUMED}: as above; stiffer, so that the car understeers")
    friction: float = parameter(0.9, "1", f"{ASSUMED}: tyres on dry asphalt")
    max_steering_rad: float = parameter(
        math.radians((69.99 + 47.95) / 2), "rad", f"{_BRIDGE}: mean of 69.99 and 47.95 degrees"
    )
    max_steering_rate_rad_s: float = parameter(2.0, "rad/s", f"{ASSUMED}: of the tyre angle; lock to lock in 1 s")
    max_accel_m_s2: float = parameter(3.0, "m/s²", f"{_CARLA}: get_vehicle_max_acceleration; full throttle, per mass")
    max_decel_m_s2: float = parameter(8.0, "m/s²", f"{_CARLA}: get_vehicle_max_deceleration; full brake, per mass")
    power_w: float = parameter(
        125e3, "W", f"{_CARLA}: 3.0 m/s² up to 100 km/h of 1500 kg, as its comment has it; at the wheels"
    )
    rolling_resistance: float = parameter(0.01, "1", f"{_CARLA}: get_rolling_resistance_force")
    drag_coefficient: float = parameter(0.3, "1", f"{_CARLA}: get_aerodynamic_drag_force")
    drag_area_m2: float = parameter(2.37, "m²", f"{_CARLA}: as above")
    air_density_kg_m3: float = parameter(1.184, "kg/m³", f"{_CARLA}: as above, air of 25 °C")
    standing_m_s: float = parameter(0.1, "m/s", f"{_NODE}: hand brake below this")
    kinematic_below_m_s: float = parameter(1.0, "m/s", f"{ASSUMED}: slower than this the tyres do not slip sideways")
    dynamic_above_m_s: float = parameter(2.0, "m/s", f"{ASSUMED}: faster than this only the tyres' slip counts")
    settling_s: float = parameter(0.05, "s", f"{ASSUMED}: time constant in which slow tyres stop to slip")
    length_m: float = parameter(4.90, "m", _TYPICAL)
    width_m: float = parameter(1.86, "m", f"{_TYPICAL}, without mirrors")
    height_m: float = parameter(1.50, "m", _TYPICAL)
    rear_overhang_m: float = parameter(1.10, "m", f"{_TYPICAL}: rear bumper, behind the rear axle")
    ground_clearance_m: float = parameter(0.15, "m", _TYPICAL)
    body_friction: float = parameter(0.4, "1", f"{ASSUMED}: painted sheet metal along an obstacle")
    ray_height_m: float = parameter(0.5, "m", f"{ASSUMED}: where obstacles ahead are looked for, above the floor")
    ray_range_m: float = parameter(100.0, "m", f"{ASSUMED}: and how far")

    @property
    def front_arm_m(self) -> float:
        """From the centre of mass forward to the front axle."""
        return self.wheelbase_m - self.com_ahead_m

    @property
    def front_load_n(self) -> float:
        """What the front axle bears at rest."""
        return self.mass_kg * GRAVITY_M_S2 * self.com_ahead_m / self.wheelbase_m

    @property
    def rear_load_n(self) -> float:
        """What the rear axle bears at rest."""
        return self.mass_kg * GRAVITY_M_S2 * self.front_arm_m / self.wheelbase_m

    @property
    def grip_n(self) -> float:
        """The greatest force of all four tyres along the car."""
        return self.friction * self.mass_kg * GRAVITY_M_S2

    @property
    def front_bumper_m(self) -> float:
        """From the rear axle forward to the front bumper."""
        return self.length_m - self.rear_overhang_m


DEFAULTS = CarParameters()
