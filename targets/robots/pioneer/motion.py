"""The drive: what each motion command does to the two loops or the two wheels.

Theory of operation. The robot is in one of three modes. In TRANSLATE_ROTATE two independent loops run, translation
and rotation; a command for one leaves the other alone. In DIRECT_WHEELS (VEL2) each wheel has a loop of its own.
EMERGENCY is TRANSLATE_ROTATE on its way to zero with the hardest deceleration, deaf to position commands. `MODES`
below is the whole story of who goes where; an order that is not listed for a mode is refused and changes nothing.
(Pioneer 2 / PeopleBot Operations Manual, client motion commands.)

The watchdog is not a mode: it holds whatever loops run at zero and lets them go on later. Motors off is not a mode
either: no order is obeyed and every goal is forgotten. Nor is braking, by which a session ends: the motors count as off
and obey no order, but the loops still run, until the robot stands.

A loop that is given the wheels, or loses its goal, brakes within the session's limits of that moment; what it was last
told to do, perhaps in another session, does not matter any more.
"""

from __future__ import annotations

import enum
import math

from targets.robots.pioneer.axis import HALT, REST, Axis, Goal, PositionGoal, Servo, SpeedGoal
from targets.robots.pioneer.odometry import Travel
from targets.robots.pioneer.profile import Limits
from targets.robots.pioneer.settings import RobotSettings
from targets.robots.pioneer.speed_limits import SessionLimits


class Mode(enum.Enum):
    """Which loops drive the wheels."""

    TRANSLATE_ROTATE = "translate-rotate"
    DIRECT_WHEELS = "direct wheels"
    EMERGENCY = "emergency stop"


class Order(enum.Enum):
    """Kinds of motion commands."""

    VELOCITY = "VEL, RVEL, ROTATE"
    POSITION = "MOVE, HEAD, DHEAD, DCHEAD"
    WHEELS = "VEL2"
    STOP = "STOP"
    E_STOP = "E_STOP"


MODES: dict[tuple[Mode, Order], Mode] = {
    (Mode.TRANSLATE_ROTATE, Order.VELOCITY): Mode.TRANSLATE_ROTATE,
    (Mode.TRANSLATE_ROTATE, Order.POSITION): Mode.TRANSLATE_ROTATE,
    (Mode.TRANSLATE_ROTATE, Order.WHEELS): Mode.DIRECT_WHEELS,
    (Mode.TRANSLATE_ROTATE, Order.STOP): Mode.TRANSLATE_ROTATE,
    (Mode.TRANSLATE_ROTATE, Order.E_STOP): Mode.EMERGENCY,
    (Mode.DIRECT_WHEELS, Order.VELOCITY): Mode.TRANSLATE_ROTATE,
    (Mode.DIRECT_WHEELS, Order.POSITION): Mode.TRANSLATE_ROTATE,
    (Mode.DIRECT_WHEELS, Order.WHEELS): Mode.DIRECT_WHEELS,
    (Mode.DIRECT_WHEELS, Order.STOP): Mode.DIRECT_WHEELS,
    (Mode.DIRECT_WHEELS, Order.E_STOP): Mode.EMERGENCY,
    (Mode.EMERGENCY, Order.VELOCITY): Mode.TRANSLATE_ROTATE,
    (Mode.EMERGENCY, Order.WHEELS): Mode.DIRECT_WHEELS,
    (Mode.EMERGENCY, Order.STOP): Mode.EMERGENCY,
    (Mode.EMERGENCY, Order.E_STOP): Mode.EMERGENCY,
}
"""E_STOP keeps zero until the next velocity command, hence no (EMERGENCY, POSITION)."""


class Motion:
    """Modes, loops and motor power. Starts with motors off; `observe` must be called before each use in a step."""

    def __init__(self, settings: RobotSettings, limits: SessionLimits) -> None:
        self._settings = settings
        self._session = limits
        distance_servo = Servo(
            gain_per_s=settings.servo_gain_per_s,
            window=settings.servo_window_mm,
            correction=settings.servo_correction_mm_s,
        )
        heading_servo = Servo(
            gain_per_s=settings.servo_gain_per_s,
            window=settings.servo_window_deg,
            correction=settings.servo_correction_deg_s,
        )
        self._translation = Axis(distance_servo, limits.translation)
        self._rotation = Axis(heading_servo, limits.rotation)
        self._left = Axis(distance_servo, limits.translation)
        self._right = Axis(distance_servo, limits.translation)
        self._travel = Travel(left_mm=0.0, right_mm=0.0, translation_mm=0.0, rotation_deg=0.0)
        self.mode = Mode.TRANSLATE_ROTATE
        self.motors_on = False
        self.braking = False

    # --- state -----------------------------------------------------------------------------------------------------

    def observe(self, travel: Travel) -> None:
        """Take what the encoders say now."""
        self._travel = travel

    @property
    def heading_setpoint_deg(self) -> float:
        """Where the rotation loop is going, unwrapped degrees on the scale of `Travel.rotation_deg`."""
        if not self.motors_on or self.mode is Mode.DIRECT_WHEELS:
            return self._travel.rotation_deg
        return self._rotation.setpoint

    @property
    def direction(self) -> float:
        """+ while the loops drive the robot's middle forward or are about to, - backward, 0 at rest or on the spot."""
        if self.mode is Mode.DIRECT_WHEELS:
            return self._left.direction + self._right.direction
        return self._translation.direction

    def enable(self, on: bool) -> bool:
        """Switch the motors; True when that changed anything. Both ways every goal is forgotten."""
        if on == self.motors_on:
            return False
        self.motors_on = on
        self.forget()
        return True

    def forget(self) -> None:
        """Stop asking for motion at once: no goals, references at rest where the robot is (bump stop, new session)."""
        self.mode = Mode.TRANSLATE_ROTATE
        self.braking = False
        self._translation.drop((self._travel.translation_mm, 0.0), self._session.translation, HALT)
        self._rotation.drop((self._travel.rotation_deg, 0.0), self._session.rotation, HALT)

    def brake(self) -> None:
        """Motors off as seen from outside, at once; meanwhile to zero with the hardest deceleration, until `forget`."""
        if self.mode is Mode.DIRECT_WHEELS:
            self._hand_to_loops()
        self.mode = Mode.TRANSLATE_ROTATE
        self.motors_on, self.braking = False, True
        self._translation.drop(self._translation.reference, self._session.emergency_translation, HALT)
        self._rotation.drop(self._rotation.reference, self._session.emergency_rotation, HALT)

    @property
    def at_rest(self) -> bool:
        """Whether both loops have come to rest; not in `Mode.DIRECT_WHEELS`, where neither runs."""
        return not (self._translation.direction or self._rotation.direction)

    def restart(self) -> None:
        """Go on from a standstill where the robot is, goals unchanged (power returns after a stall)."""
        travel = self._travel
        if self.mode is Mode.DIRECT_WHEELS:
            self._left.rebase(travel.left_mm, 0.0)
            self._right.rebase(travel.right_mm, 0.0)
            return
        self._translation.rebase(travel.translation_mm, 0.0)
        self._rotation.rebase(travel.rotation_deg, 0.0)

    def hold(self) -> None:
        """Watchdog: come to rest with normal deceleration, setpoints kept."""
        self._translation.hold(self._session.translation)
        self._rotation.hold(self._session.rotation)
        self._left.hold(self._session.translation)
        self._right.hold(self._session.translation)

    def release(self) -> None:
        """The client is back: resume the setpoints."""
        for axis in (self._translation, self._rotation, self._left, self._right):
            axis.release()

    # --- orders; each returns whether it was obeyed ----------------------------------------------------------------

    def velocity(self, mm_s: float) -> bool:
        """VEL: translate at `mm_s`."""
        return self._translate(Order.VELOCITY, SpeedGoal(speed=mm_s))

    def move(self, mm: float) -> bool:
        """MOVE: travel `mm` from here."""
        return self._translate(Order.POSITION, PositionGoal(position=self._travel.translation_mm + mm))

    def rotate(self, deg_s: float) -> bool:
        """RVEL, ROTATE: turn at `deg_s`, + counter-clockwise."""
        return self._turn(Order.VELOCITY, SpeedGoal(speed=deg_s))

    def head(self, deg: float, zero_deg: float) -> bool:
        """HEAD: turn the short way to the absolute heading `deg`; `zero_deg` is the rotation reported as heading 0."""
        here_deg = self._travel.rotation_deg
        turn_deg = math.remainder(deg - (here_deg - zero_deg), 360.0)
        return self._turn(Order.POSITION, PositionGoal(position=here_deg + turn_deg))

    def turn_by(self, deg: float) -> bool:
        """DHEAD: turn `deg` from the present heading."""
        return self._turn(Order.POSITION, PositionGoal(position=self._travel.rotation_deg + deg))

    def turn_setpoint_by(self, deg: float) -> bool:
        """DCHEAD: turn to `deg` from the last heading setpoint."""
        return self._turn(Order.POSITION, PositionGoal(position=self.heading_setpoint_deg + deg))

    def wheels(self, left_mm_s: float, right_mm_s: float) -> bool:
        """VEL2: drive each wheel; the common and the differential part are clipped to the session's speed limits."""
        if not self._enter(Order.WHEELS):
            return False
        common = _clip((left_mm_s + right_mm_s) / 2, self._session.translation.speed)
        rim = _clip((right_mm_s - left_mm_s) / 2, self._rim_mm(self._session.rotation.speed))
        wheel_limits = Limits(
            speed=self._settings.translation_top_mm_s,
            acceleration=self._session.translation.acceleration,
            deceleration=self._session.translation.deceleration,
        )
        self._left.pursue(SpeedGoal(speed=common - rim), wheel_limits)
        self._right.pursue(SpeedGoal(speed=common + rim), wheel_limits)
        return True

    def stop(self) -> bool:
        """STOP: both speeds to zero with normal deceleration; the motors stay on."""
        if not self._enter(Order.STOP):
            return False
        if self.mode is Mode.EMERGENCY:
            return True
        for axis in (self._translation, self._left, self._right):
            axis.pursue(REST, self._session.translation)
        self._rotation.pursue(REST, self._session.rotation)
        return True

    def emergency_stop(self) -> bool:
        """E_STOP: to zero with the hardest deceleration, and stay there until the next velocity command."""
        if not self._enter(Order.E_STOP):
            return False
        self._translation.pursue(HALT, self._session.emergency_translation)
        self._rotation.pursue(HALT, self._session.emergency_rotation)
        return True

    # --- stepping --------------------------------------------------------------------------------------------------

    def step(self, dt_s: float) -> tuple[float, float]:
        """Advance the loops by `dt_s` seconds; return the wheel speeds (left, right) to drive with meanwhile, mm/s."""
        travel = self._travel
        if self.mode is Mode.DIRECT_WHEELS:
            left, right = self._left.step(dt_s, travel.left_mm), self._right.step(dt_s, travel.right_mm)
        else:
            forward = self._translation.step(dt_s, travel.translation_mm)
            rim = self._rim_mm(self._rotation.step(dt_s, travel.rotation_deg))
            left, right = forward - rim, forward + rim
        top = self._settings.translation_top_mm_s
        return _clip(left, top), _clip(right, top)

    def _rim_mm(self, deg: float) -> float:
        """Way (or speed) of a wheel for a turn of the robot by `deg` (or at deg/s)."""
        return math.radians(deg) * self._settings.believed_half_track_mm

    def _turn_deg(self, left: float, right: float) -> float:
        """Turn of the robot (or its speed) for two wheel ways in mm (or speeds in mm/s); the inverse of `_rim_mm`."""
        return math.degrees((right - left) / 2 / self._settings.believed_half_track_mm)

    def _translate(self, order: Order, goal: Goal) -> bool:
        if not self._enter(order):
            return False
        self._translation.pursue(goal, self._session.translation)
        return True

    def _turn(self, order: Order, goal: Goal) -> bool:
        if not self._enter(order):
            return False
        self._rotation.pursue(goal, self._session.rotation)
        return True

    def _enter(self, order: Order) -> bool:
        """Change to the mode the order asks for, without a jump in speed; False when it is refused."""
        mode = MODES.get((self.mode, order)) if self.motors_on else None
        if mode is None:
            return False
        if mode is Mode.DIRECT_WHEELS and self.mode is not Mode.DIRECT_WHEELS:
            self._hand_to_wheels()
        if mode is not Mode.DIRECT_WHEELS and self.mode is Mode.DIRECT_WHEELS:
            self._hand_to_loops()
        self.mode = mode
        if mode is Mode.TRANSLATE_ROTATE:
            self._translation.keep_place()
            self._rotation.keep_place()
        return True

    def _hand_to_wheels(self) -> None:
        (way, speed), (heading, turn) = self._translation.reference, self._rotation.reference
        limits = self._session.translation
        self._left.drop((way - self._rim_mm(heading), speed - self._rim_mm(turn)), limits)
        self._right.drop((way + self._rim_mm(heading), speed + self._rim_mm(turn)), limits)

    def _hand_to_loops(self) -> None:
        (left, left_speed), (right, right_speed) = self._left.reference, self._right.reference
        way, speed = (left + right) / 2, (left_speed + right_speed) / 2
        turn_deg, turn_deg_s = self._turn_deg(left, right), self._turn_deg(left_speed, right_speed)
        self._translation.drop((way, speed), self._session.translation)
        self._rotation.drop((turn_deg, turn_deg_s), self._session.rotation)


def _clip(value: float, limit: float) -> float:
    return max(-limit, min(limit, value))
