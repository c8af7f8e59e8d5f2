"""The messages between the driving stack and the vehicle-interface board, whatever carries them.

Names, fields and enumerations are those of the original's types: autoware_auto_control_msgs,
autoware_auto_vehicle_msgs, builtin_interfaces and rosgraph_msgs, as LMA-FEM-UNICAMP/microAutoware uses them
(src/microAutoware/microAutoware.c). Left out, as nothing there reads or varies them: the stamps inside `lateral` and
`longitudinal`, which repeat the command's, and the frame id of the velocity report, always ``base_link``. The two
halves of the control command, `lateral` and `longitudinal`, are one flat message here.

Angles and rates are positive to the left, speeds positive forwards, as in ROS (REP 103). The turn indicators and hazard
lights are required by the original's document and stand in its code as comments only: that they are here is our choice.
"""

from __future__ import annotations

import enum
from dataclasses import dataclass

from protocols.autoware.errors import LocalProtocolError

__all__ = [
    "AckermannControlCommand",
    "AgentOnline",
    "AgentPing",
    "Clock",
    "ControlMode",
    "ControlModeReport",
    "ControlModeRequest",
    "ControlModeResponse",
    "HazardLights",
    "HazardLightsCommand",
    "HazardLightsReport",
    "Message",
    "SteeringReport",
    "Time",
    "TurnIndicators",
    "TurnIndicatorsCommand",
    "TurnIndicatorsReport",
    "VelocityReport",
]

_NS_PER_S = 1_000_000_000
_LATEST_S = (1 << 31) - 1


class ControlMode(enum.IntEnum):
    """Modes of ControlModeReport and of the request; the original's board knows 1 and 4 alone."""

    NO_COMMAND = 0
    AUTONOMOUS = 1
    AUTONOMOUS_STEER_ONLY = 2
    AUTONOMOUS_VELOCITY_ONLY = 3
    MANUAL = 4
    DISENGAGED = 5
    NOT_READY = 6


class TurnIndicators(enum.IntEnum):
    """Values of command and report; a report never says NO_COMMAND."""

    NO_COMMAND = 0
    DISABLE = 1
    ENABLE_LEFT = 2
    ENABLE_RIGHT = 3


class HazardLights(enum.IntEnum):
    """Values of command and report; a report never says NO_COMMAND."""

    NO_COMMAND = 0
    DISABLE = 1
    ENABLE = 2


@dataclass(frozen=True, slots=True)
class Time:
    """A time of builtin_interfaces.

    Attributes:
        sec: s, 32 bits with a sign.
        nanosec: ns, 32 bits; below 1e9 where the sender is sound, which nobody checks.
    """

    sec: int = 0
    nanosec: int = 0

    @classmethod
    def from_ns(cls, time_ns: int) -> Time:
        """The time so many ns after zero.

        Raises:
            LocalProtocolError: it is negative or beyond 2^31 s.
        """
        sec, nanosec = divmod(time_ns, _NS_PER_S)
        if not 0 <= sec <= _LATEST_S:
            raise LocalProtocolError(f"{time_ns} ns do not fit a stamp")
        return cls(sec, nanosec)

    @property
    def ns(self) -> int:
        """The time in ns."""
        return self.sec * _NS_PER_S + self.nanosec


@dataclass(frozen=True, slots=True, kw_only=True)
class AgentOnline:
    """The agent is there: sent when it opens the line, and as the answer to each `AgentPing`."""


@dataclass(frozen=True, slots=True, kw_only=True)
class AgentPing:
    """The board asks whether an agent is there."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Clock:
    """The simulation's time, which the board uses for its stamps.

    Attributes:
        clock: the time.
    """

    clock: Time = Time()


@dataclass(frozen=True, slots=True, kw_only=True)
class AckermannControlCommand:
    """How the vehicle is to move.

    Attributes:
        stamp: when the command was made.
        steering_tire_angle: rad, positive left.
        steering_tire_rotation_rate: rad/s, magnitude of the turn towards it; 0: as fast as possible.
        speed: m/s, positive forwards.
        acceleration: m/s^2, the acceleration wanted.
        jerk: m/s^3, as above.
    """

    stamp: Time = Time()
    steering_tire_angle: float = 0.0
    steering_tire_rotation_rate: float = 0.0
    speed: float = 0.0
    acceleration: float = 0.0
    jerk: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class ControlModeRequest:
    """Asks for a mode; the board answers each with a `ControlModeResponse`.

    Attributes:
        sequence: 0..255, comes back in the response (choice: ROS services number their requests below the message).
        stamp: when it was asked.
        mode: see `ControlMode`; another number than these is carried, too.
    """

    sequence: int = 0
    stamp: Time = Time()
    mode: int = ControlMode.NO_COMMAND


@dataclass(frozen=True, slots=True, kw_only=True)
class ControlModeResponse:
    """The answer to a `ControlModeRequest`.

    Attributes:
        sequence: that of the request.
        success: the mode is one that can be asked for.
    """

    sequence: int = 0
    success: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class TurnIndicatorsCommand:
    """Sets the turn indicators.

    Attributes:
        stamp: when the command was made.
        command: see `TurnIndicators`.
    """

    stamp: Time = Time()
    command: int = TurnIndicators.NO_COMMAND


@dataclass(frozen=True, slots=True, kw_only=True)
class HazardLightsCommand:
    """Sets the hazard lights.

    Attributes:
        stamp: when the command was made.
        command: see `HazardLights`.
    """

    stamp: Time = Time()
    command: int = HazardLights.NO_COMMAND


@dataclass(frozen=True, slots=True, kw_only=True)
class ControlModeReport:
    """The mode that the board is in.

    Attributes:
        stamp: the latest `Clock`.
        mode: see `ControlMode`.
    """

    stamp: Time = Time()
    mode: int = ControlMode.NO_COMMAND


@dataclass(frozen=True, slots=True, kw_only=True)
class VelocityReport:
    """How the vehicle moves, in its own axes.

    The board reports what its simulator says; the original's (LMA-FEM-UNICAMP/Carla-Autoware-Bridge) turns the signs of
    lateral speed and heading rate round.

    Attributes:
        stamp: `header.stamp`, the latest `Clock`.
        longitudinal_velocity: m/s, positive forwards.
        lateral_velocity: m/s, positive left.
        heading_rate: rad/s, positive to the left.
    """

    stamp: Time = Time()
    longitudinal_velocity: float = 0.0
    lateral_velocity: float = 0.0
    heading_rate: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class SteeringReport:
    """How the wheels stand.

    Attributes:
        stamp: the latest `Clock`.
        steering_tire_angle: rad, positive left.
    """

    stamp: Time = Time()
    steering_tire_angle: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class TurnIndicatorsReport:
    """What the turn indicators do.

    Attributes:
        stamp: the latest `Clock`.
        report: see `TurnIndicators`.
    """

    stamp: Time = Time()
    report: int = TurnIndicators.DISABLE


@dataclass(frozen=True, slots=True, kw_only=True)
class HazardLightsReport:
    """What the hazard lights do.

    Attributes:
        stamp: the latest `Clock`.
        report: see `HazardLights`.
    """

    stamp: Time = Time()
    report: int = HazardLights.DISABLE


Message = (
    AgentOnline
    | Clock
    | AckermannControlCommand
    | ControlModeRequest
    | TurnIndicatorsCommand
    | HazardLightsCommand
    | AgentPing
    | ControlModeReport
    | ControlModeResponse
    | TurnIndicatorsReport
    | HazardLightsReport
    | VelocityReport
    | SteeringReport
)
