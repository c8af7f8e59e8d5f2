"""The body: a foot that stands still, a fork that pans on it, a camera that tilts in the fork. Figures are a choice."""

from hilbench.benchfile.joint_signals import joint_signals
from hilbench.plugins.system import VehicleKind
from pantilt.frames import IDS
from worlds.vehicles.model import Axle, BoxShape, Part, Vehicle, box_inertia

ROTOR_KG_M2 = 2e-4  # of a servo's motor, seen through its gears
FRICTION_NM = 0.15  # of its gears without torque: enough to hold the camera
TORQUE_NM = 0.6  # of a motor on a bench with boards


def part(name, mass_kg, size_m, center_m, axis=None, height_m=0.0, on=""):
    """Return a box that stands still, or turns about an axis at a height over the middle of the foot."""
    turns = dict(friction_nm=FRICTION_NM, reflected_inertia_kg_m2=ROTOR_KG_M2)
    axle = axis and Axle(origin_m=(0, 0, height_m), axis=axis, **turns)
    shapes, inertia = (BoxShape(size_m=size_m, center_m=center_m),), box_inertia(mass_kg or 1, size_m)
    about = dict(mass_kg=mass_kg, center_of_mass_m=center_m, inertia_kg_m2=inertia)
    return Part(name=name, shapes=shapes, axle=axle, on=on, **about)


def vehicle():
    foot = part("foot", 0.0, (0.08, 0.08, 0.06), (0, 0, 0.03))  # without a mass: it stays where it is
    fork = part("pan", 0.15, (0.04, 0.07, 0.1), (0, 0, 0.11), (0, 0, 1), 0.06)
    camera = part("tilt", 0.2, (0.16, 0.04, 0.04), (0.06, 0, 0.15), (0, -1, 0), 0.15, on="pan")
    return Vehicle(name="pantilt", parts=(foot, fork, camera))


def kind():
    signals, wire = joint_signals(IDS, TORQUE_NM)
    return VehicleKind(vehicle=vehicle, body=lambda world: world, signals=signals, wire=wire, size_m=(0.2, 0.08))
