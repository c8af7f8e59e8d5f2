"""A rover on four driven wheels: its figures, its body for the physics, and what drives and senses on it.

The common kit: a plate with four gear motors, wheels of 65 mm straight on their shafts, two of them on each side. It
has no steering: to turn, one side's wheels turn faster and all four are dragged sideways over the floor. What that
takes is friction times weight times half the wheelbase, so whether a rover turns at all depends on the floor, and it
turns about half as fast as two wheels on one axle would.

The reference point is the middle between the four wheels, on the floor. Nobody has published the size or the weight of
this kit; the figures are what such kits measure, and say so.

A gear motor's rotor turns 48 times as fast as its wheel, which makes its small inertia the largest by far about the
axle. The physics gives it to the wheel (`worlds.vehicles.model.Axle`); it therefore also resists pitching, as a part of
a real rotor's does.
"""

from __future__ import annotations

from dataclasses import dataclass
from types import MappingProxyType

from worlds.inertial import Felt, InertialPoint
from worlds.vehicles.model import (
    ASSUMED,
    Axle,
    BoxShape,
    Part,
    Vehicle,
    WheelShape,
    box_inertia,
    parameter,
    parameter_table,
    wheel_inertia,
)
from worlds.world import CONTACTS, JointState, World

__all__ = ["BODY", "DEFAULTS", "IMU", "WHEELS", "Rover4wdBody", "Rover4wdParameters", "vehicle"]

BODY = "body"
WHEELS = ("wheel_lf", "wheel_rf", "wheel_lb", "wheel_rb")
"""Left front, right front, left back, right back; each is a part and a joint."""

IMU = "imu"
"""Name of the place of the inertial sensor."""

_KIT = f"{ASSUMED}: common in kits of four TT motors and a plate"


@dataclass(frozen=True, slots=True, kw_only=True)
class Rover4wdParameters:
    """The figures of the rover; `worlds.vehicles.model.parameter_table` lists them with unit and source."""

    wheel_radius_m: float = parameter(0.0325, "m", f"{_KIT}: wheels of 65 mm")
    wheelbase_m: float = parameter(0.115, "m", f"{_KIT}: from front axle to back axle")
    track_m: float = parameter(0.140, "m", f"{_KIT}: between the middles of the treads")
    tread_m: float = parameter(
        0.002,
        "m",
        f"{ASSUMED}: width that touches the floor; the tyre is 26 mm wide, but a flat one would stand now on this edge "
        "and now on that, and let the middle of a turn wander",
    )
    mass_kg: float = parameter(1.0, "kg", f"{ASSUMED}: four motors of 30 g, two cells of 46 g, boards, plates, wheels")
    wheel_mass_kg: float = parameter(0.034, "kg", f"{ASSUMED}: of the whole, each")
    rotor_inertia_kg_m2: float = parameter(1.4e-7, "kg·m²", f"{ASSUMED}: 8 g of iron and copper, 12 mm across")
    gear_ratio: float = parameter(48.0, "1", "TT motor, as sold: 1:48")
    body_length_m: float = parameter(0.250, "m", _KIT)
    body_width_m: float = parameter(0.105, "m", f"{_KIT}: what fits between the wheels")
    body_bottom_m: float = parameter(0.022, "m", f"{_KIT}: under the motors")
    body_top_m: float = parameter(0.080, "m", f"{ASSUMED}: with the boards on the upper plate")
    center_of_mass_x_m: float = parameter(0.0, "m", f"{ASSUMED}: of the body; both axles bear the same")
    center_of_mass_z_m: float = parameter(0.045, "m", f"{ASSUMED}: of the body")
    wheel_friction: float = parameter(
        0.8, "1", f"{ASSUMED}: rubber on carpet; a floor that is slipperier says so itself"
    )
    body_friction: float = parameter(0.5, "1", ASSUMED)
    released_friction_nm: float = parameter(
        0.012, "N·m", f"{ASSUMED}: a gearbox of plastic, until a motor says otherwise"
    )
    imu_x_m: float = parameter(0.03, "m", f"{ASSUMED}: where the inertial sensor sits, ahead of the middle")
    imu_y_m: float = parameter(0.0, "m", f"{ASSUMED}: as above, to the left of it")
    imu_z_m: float = parameter(0.07, "m", f"{ASSUMED}: as above, above the floor")

    @property
    def reflected_inertia_kg_m2(self) -> float:
        """A rotor's inertia as the wheel feels it."""
        return self.rotor_inertia_kg_m2 * self.gear_ratio**2


DEFAULTS = Rover4wdParameters()


def vehicle(parameters: Rover4wdParameters = DEFAULTS) -> Vehicle:
    """Return the rover as parts for the physics."""
    half_base, half_track = parameters.wheelbase_m / 2, parameters.track_m / 2
    places = ((half_base, half_track), (half_base, -half_track), (-half_base, half_track), (-half_base, -half_track))
    wheels = (_wheel(parameters, name, x, y) for name, (x, y) in zip(WHEELS, places, strict=True))
    imu = (parameters.imu_x_m, parameters.imu_y_m, parameters.imu_z_m)
    return Vehicle(
        name="rover-4wd",
        parts=(_body(parameters), *wheels),
        mounts=MappingProxyType({IMU: imu}),
        parameters=parameter_table(parameters),
    )


def _body(p: Rover4wdParameters) -> Part:
    mass = p.mass_kg - len(WHEELS) * p.wheel_mass_kg
    size = (p.body_length_m, p.body_width_m, p.body_top_m - p.body_bottom_m)
    return Part(
        name=BODY,
        mass_kg=mass,
        center_of_mass_m=(p.center_of_mass_x_m, 0.0, p.center_of_mass_z_m),
        inertia_kg_m2=box_inertia(mass, size),
        shapes=(BoxShape(size_m=size, center_m=(0.0, 0.0, (p.body_bottom_m + p.body_top_m) / 2)),),
        friction=p.body_friction,
    )


def _wheel(p: Rover4wdParameters, name: str, x_m: float, y_m: float) -> Part:
    center = (x_m, y_m, p.wheel_radius_m)
    return Part(
        name=name,
        mass_kg=p.wheel_mass_kg,
        center_of_mass_m=center,
        inertia_kg_m2=wheel_inertia(p.wheel_mass_kg, p.wheel_radius_m, p.tread_m),
        shapes=(WheelShape(radius_m=p.wheel_radius_m, width_m=p.tread_m, center_m=center),),
        friction=p.wheel_friction,
        axle=Axle(
            origin_m=center, friction_nm=p.released_friction_nm, reflected_inertia_kg_m2=p.reflected_inertia_kg_m2
        ),
    )


class Rover4wdBody:
    """What motors and sensors have to do with the rover, on any world that holds it.

    Args:
        world: where the rover stands.
        parameters: the same that the world's vehicle was made from.
    """

    def __init__(self, world: World, *, parameters: Rover4wdParameters = DEFAULTS) -> None:
        self.world = world
        self.parameters = parameters
        self._imu = InertialPoint(world, world.vehicle.mounts[IMU])

    def drive(self, wheel: str, torque_nm: float, friction_nm: float | None = None) -> None:
        """Turn a wheel by a torque, forward positive, against dry friction; see `worlds.world.World.drive`."""
        self.world.drive(wheel, torque_nm, friction_nm)

    def wheel(self, wheel: str) -> JointState:
        """Return a wheel's angle, never wrapped, its speed and the torque on it, forward positive."""
        return self.world.joint(wheel)

    def felt(self) -> Felt:
        """Return what the inertial sensor's place felt in the last step; to be asked after every step."""
        return self._imu.felt()

    def touches(self, part: str) -> bool:
        """Whether the body, or a wheel, touches anything; a wheel touches the floor as a rule."""
        return CONTACTS in self.world.capabilities and bool(self.world.contacts(part))
