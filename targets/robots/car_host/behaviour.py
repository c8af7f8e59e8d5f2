"""How a car host behaves, profile by profile, and the defects of the published one, each by itself.

Sources: bridge, LMA-FEM-UNICAMP/carla_serial_bridge; CAB, LMA-FEM-UNICAMP/Carla-Autoware-Bridge; node,
carla-simulator/ros-bridge carla_ackermann_control. The quirks of the line are those of protocols/carla/profiles.py.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType

from protocols.carla import ORIGINAL_SIGNS, PROFILES, QUIRKS, ROS_SIGNS, Signs, SimulatorOptions

__all__ = ["BEHAVIOURS", "DEFECTS", "SIGNS", "Behaviour", "Defect", "HostQuirks", "behaviour_of"]


@dataclass(frozen=True, slots=True, kw_only=True)
class HostQuirks:
    """What is not of the line.

    Attributes:
        signs: what the car's figures become in a status. Ours are those of ROS, as the driving stack's messages are
            defined (choice); CAB turns lateral speed and yaw rate round.
        node_holds_s: CARLA's ackermann node goes on commanding the car for so long after the last ackermann command,
            beside what the joystick commands meanwhile (node: 1 s; from reading, not measured); 0: the newer wins.
        reports: the car's velocity and steering are reported (CAB: both, at each step of the simulator).
    """

    signs: Signs = ROS_SIGNS
    node_holds_s: float = 0.0
    reports: tuple[str, ...] = ("velocity", "steering")


@dataclass(frozen=True, slots=True, kw_only=True)
class Behaviour:
    """All that a car host promises or gets wrong.

    Attributes:
        line: its end of the board's line.
        host: the rest.
    """

    line: SimulatorOptions
    host: HostQuirks = field(default_factory=HostQuirks)


_SHIPPED = HostQuirks(signs=ORIGINAL_SIGNS, node_holds_s=1.0)

BEHAVIOURS: Mapping[str, Behaviour] = MappingProxyType(
    {
        name: Behaviour(line=profile.simulator, host=HostQuirks() if name == "hardened" else _SHIPPED)
        for name, profile in PROFILES.items()
    }
)
"""The behaviour of each profile; the bridge is the same for both firmwares."""

SIGNS: Mapping[str, Signs] = MappingProxyType({"original": ORIGINAL_SIGNS, "ros": ROS_SIGNS})
"""What ``signs`` of the settings may be."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Defect:
    """One thing that is wrong.

    Attributes:
        name: as in settings.
        text: what it does.
        source: where it is published.
        line: what changes in `SimulatorOptions`.
        host: the same in `HostQuirks`.
    """

    name: str
    text: str
    source: str
    line: Mapping[str, object] = field(default_factory=dict)
    host: Mapping[str, object] = field(default_factory=dict)

    def put_into(self, behaviour: Behaviour) -> Behaviour:
        """The behaviour with this defect."""
        return Behaviour(
            line=replace(behaviour.line, **self.line),  # type: ignore[arg-type]
            host=replace(behaviour.host, **self.host),  # type: ignore[arg-type]
        )


_OURS = (
    Defect(
        name="never-stops",
        text="a board that falls silent leaves the car with its last command",
        source="bridge carla_serial_bridge_node.cpp timer_callback: nothing watches the line",
        line={"silence_s": None},
    ),
    Defect(
        name="no-clamp",
        text="steer, throttle and brake beyond their ranges are handed on",
        source="bridge carla_serial_bridge_node.cpp publish_to_carla",
        line={"clamp_manual": False},
    ),
    Defect(
        name="node-overlap",
        text="for a second after an ackermann command CARLA's node contradicts the joystick",
        source="node carla_ackermann_control_node.py: commands until the last one is 1 s old",
        host={"node_holds_s": 1.0},
    ),
    Defect(
        name="original-signs",
        text="lateral speed and heading rate are turned round: positive to the right",
        source="CAB: heading_rate = -yaw rate, lateral = -y",
        host={"signs": ORIGINAL_SIGNS},
    ),
    Defect(
        name="no-steering",
        text="no steering report comes, so that no status is ever complete",
        source="bridge: a status needs both reports; CAB without its steering topic",
        host={"reports": ("velocity",)},
    ),
)

DEFECTS: Mapping[str, Defect] = MappingProxyType(
    {
        **{
            quirk.name: Defect(name=quirk.name, text=quirk.text, source=quirk.source, line=quirk.simulator)
            for quirk in QUIRKS.values()
            if quirk.simulator
        },
        **{defect.name: defect for defect in _OURS},
    }
)
"""All defects by name."""


def behaviour_of(profile: str, defects: Iterable[str], signs: str = "profile") -> Behaviour:
    """The behaviour of a profile with some defects in it, and other signs than its own if they are named."""
    behaviour = BEHAVIOURS[profile]
    if signs in SIGNS:
        behaviour = replace(behaviour, host=replace(behaviour.host, signs=SIGNS[signs]))
    for name in defects:
        behaviour = DEFECTS[name].put_into(behaviour)
    return behaviour
