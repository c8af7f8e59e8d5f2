"""The catalogue of the messages: who sends each, its topic and type in the original, its fields, its rate."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from types import MappingProxyType

from protocols.autoware.messages import (
    AckermannControlCommand,
    AgentOnline,
    AgentPing,
    Clock,
    ControlMode,
    ControlModeReport,
    ControlModeRequest,
    ControlModeResponse,
    HazardLights,
    HazardLightsCommand,
    HazardLightsReport,
    Message,
    SteeringReport,
    TurnIndicators,
    TurnIndicatorsCommand,
    TurnIndicatorsReport,
    VelocityReport,
)

__all__ = ["MESSAGES", "FieldSpec", "MessageSpec", "Sender", "WireType"]


class Sender(enum.Enum):
    """Who sends a message."""

    AGENT = "driving stack to board"
    BOARD = "board to driving stack"


class WireType(enum.Enum):
    """What a field is."""

    TIME = "int32 s, uint32 ns"
    FLOAT32 = "float32"
    UINT8 = "uint8"
    BOOL = "bool"


@dataclass(frozen=True, slots=True, kw_only=True)
class FieldSpec:
    """One field of a message.

    Attributes:
        name: in the class here.
        original: its path in the original's type; empty where the field is ours.
        type: what it is.
        unit: its unit, or what its numbers mean.
    """

    name: str
    original: str
    type: WireType
    unit: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class MessageSpec:
    """One message.

    Attributes:
        kind: the class that holds it.
        sender: who sends it.
        topic: the topic or service of the original; empty where it has none.
        original: its type in the original; empty where the message is ours.
        fields: its fields, in order.
        rate: how often it comes.
        choice: why it is here though the original's code does not have it; empty where it does.
    """

    kind: type[Message]
    sender: Sender
    topic: str
    original: str
    fields: tuple[FieldSpec, ...]
    rate: str
    choice: str = ""


def _stamp(original: str = "stamp") -> FieldSpec:
    return FieldSpec(name="stamp", original=original, type=WireType.TIME, unit="time")


def _real(name: str, unit: str, original: str = "") -> FieldSpec:
    return FieldSpec(name=name, original=original or name, type=WireType.FLOAT32, unit=unit)


def _choose(name: str, unit: str) -> FieldSpec:
    return FieldSpec(name=name, original=name, type=WireType.UINT8, unit=unit)


_MODES = ", ".join(f"{mode.value} {mode.name}" for mode in ControlMode)
_INDICATORS = ", ".join(f"{value.value} {value.name}" for value in TurnIndicators)
_HAZARDS = ", ".join(f"{value.value} {value.name}" for value in HazardLights)
_SEQUENCE = FieldSpec(name="sequence", original="", type=WireType.UINT8, unit="number of the request")
_LIGHTS = "required by the original's document, a comment in its code"
_AT_EACH_STATUS = "with each status that the control task takes: 20 Hz in AUTOWARE, each 60 ms in MANUAL"
_MODE_RATE = "each 100 ms (choice; in the original at each loop of its task), and at each change of the mode"

_SPECS = (
    MessageSpec(
        kind=AgentOnline,
        sender=Sender.AGENT,
        topic="",
        original="",
        fields=(),
        rate="when the line is opened, and after each AgentPing",
        choice="stands for the agent's answer to a ping of Micro XRCE-DDS",
    ),
    MessageSpec(
        kind=Clock,
        sender=Sender.AGENT,
        topic="/clock",
        original="rosgraph_msgs/msg/Clock",
        fields=(FieldSpec(name="clock", original="clock", type=WireType.TIME, unit="time"),),
        rate="at each step of the simulator, 20 Hz",
    ),
    MessageSpec(
        kind=AckermannControlCommand,
        sender=Sender.AGENT,
        topic="/control/command/control_cmd",
        original="autoware_auto_control_msgs/msg/AckermannControlCommand",
        fields=(
            _stamp(),
            _real("steering_tire_angle", "rad, + left", "lateral.steering_tire_angle"),
            _real("steering_tire_rotation_rate", "rad/s", "lateral.steering_tire_rotation_rate"),
            _real("speed", "m/s", "longitudinal.speed"),
            _real("acceleration", "m/s^2", "longitudinal.acceleration"),
            _real("jerk", "m/s^3", "longitudinal.jerk"),
        ),
        rate="30 Hz (Autoware's trajectory follower: ctrl_period 0.03 s)",
    ),
    MessageSpec(
        kind=ControlModeRequest,
        sender=Sender.AGENT,
        topic="/control/control_mode_request",
        original="autoware_auto_vehicle_msgs/srv/ControlModeCommand, request",
        fields=(_SEQUENCE, _stamp(), _choose("mode", _MODES)),
        rate="on demand",
    ),
    MessageSpec(
        kind=TurnIndicatorsCommand,
        sender=Sender.AGENT,
        topic="/control/command/turn_indicators_cmd",
        original="autoware_auto_vehicle_msgs/msg/TurnIndicatorsCommand",
        fields=(_stamp(), _choose("command", _INDICATORS)),
        rate="on change",
        choice=_LIGHTS,
    ),
    MessageSpec(
        kind=HazardLightsCommand,
        sender=Sender.AGENT,
        topic="/control/command/hazard_lights_cmd",
        original="autoware_auto_vehicle_msgs/msg/HazardLightsCommand",
        fields=(_stamp(), _choose("command", _HAZARDS)),
        rate="on change",
        choice=_LIGHTS,
    ),
    MessageSpec(
        kind=AgentPing,
        sender=Sender.BOARD,
        topic="",
        original="",
        fields=(),
        rate="after a reset once a second, at most 20 times, until the agent answers",
        choice="stands for rmw_uros_ping_agent(1000, 20)",
    ),
    MessageSpec(
        kind=ControlModeReport,
        sender=Sender.BOARD,
        topic="/vehicle/status/control_mode",
        original="autoware_auto_vehicle_msgs/msg/ControlModeReport",
        fields=(_stamp(), _choose("mode", _MODES)),
        rate=_MODE_RATE,
    ),
    MessageSpec(
        kind=ControlModeResponse,
        sender=Sender.BOARD,
        topic="/control/control_mode_request",
        original="autoware_auto_vehicle_msgs/srv/ControlModeCommand, response",
        fields=(_SEQUENCE, FieldSpec(name="success", original="success", type=WireType.BOOL, unit="0 or 1")),
        rate="one for each request",
    ),
    MessageSpec(
        kind=TurnIndicatorsReport,
        sender=Sender.BOARD,
        topic="/vehicle/status/turn_indicators_status",
        original="autoware_auto_vehicle_msgs/msg/TurnIndicatorsReport",
        fields=(_stamp(), _choose("report", _INDICATORS)),
        rate=_AT_EACH_STATUS,
        choice=_LIGHTS,
    ),
    MessageSpec(
        kind=HazardLightsReport,
        sender=Sender.BOARD,
        topic="/vehicle/status/hazard_lights_status",
        original="autoware_auto_vehicle_msgs/msg/HazardLightsReport",
        fields=(_stamp(), _choose("report", _HAZARDS)),
        rate=_AT_EACH_STATUS,
        choice=_LIGHTS,
    ),
    MessageSpec(
        kind=VelocityReport,
        sender=Sender.BOARD,
        topic="/vehicle/status/velocity_status",
        original="autoware_auto_vehicle_msgs/msg/VelocityReport",
        fields=(
            _stamp("header.stamp"),
            _real("longitudinal_velocity", "m/s"),
            _real("lateral_velocity", "m/s, + left; + right from the original's simulator"),
            _real("heading_rate", "rad/s, + left; + right from the original's simulator"),
        ),
        rate=_AT_EACH_STATUS,
    ),
    MessageSpec(
        kind=SteeringReport,
        sender=Sender.BOARD,
        topic="/vehicle/status/steering_status",
        original="autoware_auto_vehicle_msgs/msg/SteeringReport",
        fields=(_stamp(), _real("steering_tire_angle", "rad, + left")),
        rate=_AT_EACH_STATUS,
    ),
)

MESSAGES = MappingProxyType({spec.kind: spec for spec in _SPECS})
"""Every message, by its class."""
