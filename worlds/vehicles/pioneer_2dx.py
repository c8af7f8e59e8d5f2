"""The Pioneer 2-DX: its figures, its body for the physics, and what its controller needs of that body.

Two driven wheels, a caster behind, a ring of bumpers in front and behind with five segments each, and discs of a sonar
array. The reference point is the middle between the wheels, on the floor.

Two figures deserve a word. The effective track is not a tape measure's: it is what makes the turn rate come out as the
robot's own firmware and clients reckon it. And the torque limit is chosen so that a wall stops the wheels: with 1.5 N·m
they would spin on the floor instead, and a stall detector that waits for still wheels would never fire.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from worlds.errors import UnknownNameError
from worlds.geometry import add, rotation, turn
from worlds.vehicles.model import (
    ASSUMED,
    Axle,
    BoxShape,
    DifferentialDrive,
    Part,
    SphereShape,
    Vehicle,
    WheelShape,
    box_inertia,
    parameter,
    parameter_table,
    sphere_inertia,
    wheel_inertia,
)
from worlds.vehicles.sonar_cone import Disc, disc_at
from worlds.world import CONTACTS, RAYS, World

LEFT = "wheel_left"
RIGHT = "wheel_right"
BODY = "body"
CASTER = "caster"
FRONT_BUMPER = "bumper_front"
REAR_BUMPER = "bumper_rear"

BUMPER_SEGMENTS = 5
_SEGMENT_ANGLE_RAD = math.radians(30)

_QUOTED = f"{ASSUMED}: commonly quoted for the type, not checked against a data sheet"
_ARIA = "reedhedges/AriaCoda params/p2dx.p"


@dataclass(frozen=True, slots=True, kw_only=True)
class Pioneer2dxParameters:
    """The figures of a Pioneer 2-DX; `worlds.vehicles.model.parameter_table` lists them with unit and source."""

    wheel_radius_m: float = parameter(0.0825, "m", _QUOTED)
    track_m: float = parameter(
        2 / 0.0056 / 1000, "m", f"{_ARIA}: DiffConvFactor 0.0056 rad/s per mm/s of half the wheels' difference"
    )
    tread_m: float = parameter(
        0.002,
        "m",
        f"{ASSUMED}: width that touches the floor; a crowned tyre stands on its middle, and a wide flat one "
        "would turn about either edge and move the turning point by centimetres",
    )
    mass_kg: float = parameter(9.0, "kg", _QUOTED)
    wheel_mass_kg: float = parameter(0.5, "kg", f"{ASSUMED}: of the 9 kg, each")
    length_front_m: float = parameter(0.210, "m", f"{_ARIA}: RobotLengthFront, taken as the face of the front bumpers")
    length_rear_m: float = parameter(0.301, "m", f"{_ARIA}: RobotLengthRear, taken as the face of the rear bumpers")
    width_m: float = parameter(0.425, "m", f"{_ARIA}: RobotWidth, taken as the width over the bumpers")
    body_height_m: float = parameter(0.22, "m", _QUOTED)
    ground_clearance_m: float = parameter(0.051, "m", _QUOTED)
    bumper_protrusion_m: float = parameter(0.015, "m", f"{ASSUMED}: how far bumpers stand out from the hull")
    bumper_bottom_m: float = parameter(0.06, "m", ASSUMED)
    bumper_top_m: float = parameter(0.16, "m", ASSUMED)
    center_of_mass_x_m: float = parameter(-0.03, "m", f"{ASSUMED}: between axle and caster, so that the caster bears")
    center_of_mass_z_m: float = parameter(0.10, "m", f"{ASSUMED}: the batteries lie low")
    caster_x_m: float = parameter(-0.19, "m", ASSUMED)
    caster_radius_m: float = parameter(0.0375, "m", ASSUMED)
    caster_friction: float = parameter(0.0, "1", f"{ASSUMED}: a swivelling caster drags little; any drag bends turns")
    wheel_friction: float = parameter(0.8, "1", f"{ASSUMED}: rubber on a hard floor")
    hull_friction: float = parameter(0.3, "1", ASSUMED)
    torque_limit_nm: float = parameter(
        1.0, "N·m", f"{ASSUMED}: each wheel; below what slips on the floor, so that a blocked robot stalls"
    )
    released_friction_nm: float = parameter(0.2, "N·m", f"{ASSUMED}: drag of gearbox and motor with the power off")
    sonar_height_m: float = parameter(0.19, "m", f"{ASSUMED}: the ring is near the top of the body")
    sonar_half_angle_rad: float = parameter(math.radians(15), "rad", f"{ASSUMED}: common figure for the 50 kHz disc")
    sonar_range_m: float = parameter(5.0, "m", f"{ASSUMED}: range at the usual firing rate")
    sonar_blind_m: float = parameter(0.1, "m", f"{ASSUMED}: nearer echoes drown in the disc's ringing")


DEFAULTS = Pioneer2dxParameters()


def vehicle(parameters: Pioneer2dxParameters = DEFAULTS) -> Vehicle:
    """Return the robot as parts for the physics."""
    return Vehicle(
        name="pioneer-2dx",
        parts=(
            _body(parameters),
            _wheel(parameters, LEFT, parameters.track_m / 2),
            _wheel(parameters, RIGHT, -parameters.track_m / 2),
            _caster(parameters),
            _bumper(parameters, FRONT_BUMPER, _front_center_m(parameters), 0.0),
            _bumper(parameters, REAR_BUMPER, _rear_center_m(parameters), math.pi),
        ),
        drive=DifferentialDrive(
            left=LEFT, right=RIGHT, wheel_radius_m=parameters.wheel_radius_m, track_m=parameters.track_m
        ),
        parameters=parameter_table(parameters),
    )


_CASTER_MASS_KG = 0.2
_BUMPER_MASS_KG = 0.2


def _body(p: Pioneer2dxParameters) -> Part:
    mass = p.mass_kg - 2 * p.wheel_mass_kg - _CASTER_MASS_KG - 2 * _BUMPER_MASS_KG
    length = p.length_front_m + p.length_rear_m - 2 * p.bumper_protrusion_m
    return Part(
        name=BODY,
        mass_kg=mass,
        center_of_mass_m=(p.center_of_mass_x_m, 0.0, p.center_of_mass_z_m),
        inertia_kg_m2=box_inertia(mass, (length, p.width_m - 2 * p.bumper_protrusion_m, p.body_height_m)),
        shapes=tuple(_hull(p)),
        friction=p.hull_friction,
    )


def _hull(p: Pioneer2dxParameters) -> list[BoxShape]:
    """Three crossed boxes inside the bumpers' polygons, as an eight-cornered hull would be."""
    middle_x = (p.length_front_m - p.length_rear_m) / 2
    straight = (p.length_front_m + p.length_rear_m - p.width_m) / 2  # half the distance between the rings' middles
    radius = p.width_m / 2 - p.bumper_protrusion_m
    height = p.body_height_m - p.ground_clearance_m
    boxes = []
    for angle in (math.radians(25), math.radians(45), math.radians(70)):
        half_length, half_width = straight + radius * math.cos(angle), radius * math.sin(angle)
        boxes.append(
            BoxShape(
                size_m=(2 * half_length, 2 * half_width, height),
                center_m=(middle_x, 0.0, p.ground_clearance_m + height / 2),
            )
        )
    return boxes


def _wheel(p: Pioneer2dxParameters, name: str, y_m: float) -> Part:
    center = (0.0, y_m, p.wheel_radius_m)
    return Part(
        name=name,
        mass_kg=p.wheel_mass_kg,
        center_of_mass_m=center,
        inertia_kg_m2=wheel_inertia(p.wheel_mass_kg, p.wheel_radius_m, p.tread_m),
        shapes=(WheelShape(radius_m=p.wheel_radius_m, width_m=p.tread_m, center_m=center),),
        friction=p.wheel_friction,
        axle=Axle(origin_m=center, friction_nm=p.released_friction_nm),
    )


def _caster(p: Pioneer2dxParameters) -> Part:
    """A fixed sphere that slides without friction: a swivel that is always where it should be."""
    center = (p.caster_x_m, 0.0, p.caster_radius_m)
    return Part(
        name=CASTER,
        mass_kg=_CASTER_MASS_KG,
        center_of_mass_m=center,
        inertia_kg_m2=sphere_inertia(_CASTER_MASS_KG, p.caster_radius_m),
        shapes=(SphereShape(radius_m=p.caster_radius_m, center_m=center),),
        friction=p.caster_friction,
    )


def _bumper(p: Pioneer2dxParameters, name: str, center_x_m: float, heading_rad: float) -> Part:
    """Five flat segments of 30 degrees each, round a middle on the robot's long axis."""
    depth, radius = 0.01, p.width_m / 2
    size = (depth, 2 * (radius - depth) * math.tan(_SEGMENT_ANGLE_RAD / 2), p.bumper_top_m - p.bumper_bottom_m)
    height = (p.bumper_top_m + p.bumper_bottom_m) / 2
    shapes = []
    for segment in range(BUMPER_SEGMENTS):
        bearing = heading_rad + (segment - BUMPER_SEGMENTS // 2) * _SEGMENT_ANGLE_RAD
        reach = radius - depth / 2
        center = (center_x_m + reach * math.cos(bearing), reach * math.sin(bearing), height)
        shapes.append(BoxShape(size_m=size, center_m=center, yaw_rad=bearing))
    middle = (center_x_m + radius * math.cos(heading_rad) / 2, 0.0, height)
    return Part(
        name=name,
        mass_kg=_BUMPER_MASS_KG,
        center_of_mass_m=middle,
        inertia_kg_m2=box_inertia(_BUMPER_MASS_KG, (radius, p.width_m, size[2])),
        shapes=tuple(shapes),
        friction=p.hull_friction,
    )


def _front_center_m(p: Pioneer2dxParameters) -> float:
    return p.length_front_m - p.width_m / 2


def _rear_center_m(p: Pioneer2dxParameters) -> float:
    return p.width_m / 2 - p.length_rear_m


class Pioneer2dxBody:
    """What a Pioneer's controller commands and senses, on any world that holds the vehicle.

    Args:
        world: where the robot stands.
        sonar_poses: one per disc, in the order of their numbers: x and y in metres from the reference point, direction
            in radians. A 2-DX normally carries the eight front discs.
        parameters: the same that the world's vehicle was made from.

    In a world without contacts no bumper is ever pressed, without rays no echo ever returns.
    """

    def __init__(
        self,
        world: World,
        *,
        sonar_poses: Sequence[tuple[float, float, float]],
        parameters: Pioneer2dxParameters = DEFAULTS,
    ) -> None:
        self.world = world
        self.parameters = parameters
        self._rings = (FRONT_BUMPER, _front_center_m(parameters), 1.0), (REAR_BUMPER, _rear_center_m(parameters), -1.0)
        self._discs = tuple(_disc(parameters, pose) for pose in sonar_poses)

    def command_wheels(self, left_rad_s: float, right_rad_s: float) -> None:
        """Drive both wheels towards these speeds, rad/s, forward positive, each within the torque limit."""
        self.world.command(LEFT, left_rad_s, self.parameters.torque_limit_nm)
        self.world.command(RIGHT, right_rad_s, self.parameters.torque_limit_nm)

    def release_wheels(self) -> None:
        """Switch the motors off; the wheels turn against the gearboxes' friction."""
        self.world.release(LEFT)
        self.world.release(RIGHT)

    def wheel_angles_rad(self) -> tuple[float, float]:
        """Return how far the left and the right wheel have turned, forward positive, never wrapped."""
        return self.world.joint(LEFT).angle_rad, self.world.joint(RIGHT).angle_rad

    def motor_loads(self) -> tuple[float, float]:
        """Return each motor's torque in the last step as a share of its limit, 0 to 1."""
        limit = self.parameters.torque_limit_nm
        left, right = abs(self.world.joint(LEFT).torque_nm), abs(self.world.joint(RIGHT).torque_nm)
        return min(left / limit, 1.0), min(right / limit, 1.0)

    def bumpers(self) -> tuple[int, int]:
        """Return which segments of the front and of the rear ring touch something.

        Bit 0 is segment 1. Both rings count from the robot's left to its right (our choice: the public manuals name
        the bits but not the side they start from).
        """
        if CONTACTS not in self.world.capabilities:
            return 0, 0
        front, rear = self._rings
        return self._mask(*front), self._mask(*rear)

    def sonar_range_m(self, number: int) -> float | None:
        """Fire one disc and return the distance from its face to the nearest echo in its cone, metres.

        The cone is sampled by thirteen rays: its axis, four to the left and four to the right a quarter of its
        half-angle of 15 degrees apart, and two upwards and two downwards at half and at the whole of it. Against the
        exact cone the result is never short, but a box whose edge is within two millimetres of the cone may be heard.
        For an upright wall wider than the cone it is at most 0.054 % long, as a wall's nearest point lies within 1.875
        degrees of a ray. What is narrower than 0.066 of its distance can stand unseen between two rays, and so can what
        lies wholly below or above the discs. The floor gives no echo, as a real one does not at such a flat angle.

        Args:
            number: the disc, from 0.

        Returns:
            The range, at least the blind zone of 0.1 m; None without an echo within 5 m.

        Raises:
            UnknownNameError: no such disc.
        """
        disc = self._disc(number)
        if RAYS not in self.world.capabilities:
            return None
        pose = self.world.pose()
        frame = rotation(pose.yaw_rad, pose.pitch_rad, pose.roll_rad)
        start = add(pose.position_m, turn(frame, disc.face_m))
        ends = [add(pose.position_m, turn(frame, end)) for end in disc.ends_m]
        nearest = min(self.world.cast([start] * len(ends), ends))
        return max(nearest * self.parameters.sonar_range_m, self.parameters.sonar_blind_m) if nearest < 1.0 else None

    def ray_ranges_m(self, numbers: Sequence[int]) -> list[float]:
        """Cast one ray from the face of each of these discs, along its axis.

        Args:
            numbers: of discs, from 0.

        Returns:
            The distance of each from the disc's face to what it hits, metres; infinite where that is farther than the
            range of 5 m, or in a world without rays.

        Raises:
            UnknownNameError: no such disc.
        """
        discs = [self._disc(number) for number in numbers]
        if RAYS not in self.world.capabilities:
            return [math.inf] * len(discs)
        pose = self.world.pose()
        frame = rotation(pose.yaw_rad, pose.pitch_rad, pose.roll_rad)
        starts = [add(pose.position_m, turn(frame, disc.face_m)) for disc in discs]
        ends = [add(pose.position_m, turn(frame, disc.ends_m[0])) for disc in discs]
        shares = self.world.cast(starts, ends)
        return [share * self.parameters.sonar_range_m if share < 1.0 else math.inf for share in shares]

    def _disc(self, number: int) -> Disc:
        if not 0 <= number < len(self._discs):
            raise UnknownNameError("sonar disc", str(number), map(str, range(len(self._discs))))
        return self._discs[number]

    def _mask(self, ring: str, center_x_m: float, ahead: float) -> int:
        mask = 0
        for contact in self.world.contacts(ring):
            x, y, _ = contact.position_m
            from_left_rad = BUMPER_SEGMENTS / 2 * _SEGMENT_ANGLE_RAD - math.atan2(y, ahead * (x - center_x_m))
            segment = math.floor(from_left_rad / _SEGMENT_ANGLE_RAD)
            mask |= 1 << max(0, min(BUMPER_SEGMENTS - 1, segment))
        return mask


def _disc(p: Pioneer2dxParameters, pose: tuple[float, float, float]) -> Disc:
    x, y, heading = pose
    return disc_at((x, y, p.sonar_height_m), heading, p.sonar_half_angle_rad, p.sonar_range_m)
