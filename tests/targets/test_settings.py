"""Settings: the limits are those of the packets that carry them."""

from __future__ import annotations

import dataclasses

import pytest

from protocols.p2os import Command, CommandNumber, ConfigPacket, WrongOrder
from targets.robots.pioneer import RobotSettings, server_options
from targets.robots.pioneer.settings import RANGES
from tests.each import each

ON_THE_WIRE = {name: limits for name, limits in RANGES.items() if limits in ((0, 0xFF), (0, 0xFFFF))}
OTHERS = {"front_bumper_segments": 7, "rear_bumper_segments": 7, "analog": (1023,) * 5, "heading_units_per_turn": 65536}


def greatest(name: str) -> object:
    value = int(ON_THE_WIRE[name][1])
    return (value,) * 6 if name == "pid_gains" else value


def test_the_greatest_values_of_all_settings_fit_their_packets(make_rig) -> None:
    longest = dict.fromkeys(("name", "robot_class", "serial"), "x" * 19)
    rig = make_rig(RobotSettings(**{name: greatest(name) for name in ON_THE_WIRE}, **OTHERS, **longest))
    rig.ready()
    received = [r.packet for r in rig.say(Command(CommandNumber.CONFIG, 1), 1.0)]
    (config,) = [packet for packet in received if isinstance(packet, ConfigPacket)]
    assert (config.serial, config.watchdog_ms, config.sip_cycle_ms, config.stall_pwm) == ("x" * 19, 65535, 255, 65535)
    assert (rig.sips[-1].battery_dv, rig.sips[-1].digin, rig.sips[-1].analog) == (255, 255, 255)


@each("name", sorted(ON_THE_WIRE))
def test_one_more_than_the_greatest_is_refused_by_name(name: str) -> None:
    value = greatest(name)
    more = (*value[:-1], value[-1] + 1) if isinstance(value, tuple) else value + 1
    with pytest.raises(ValueError, match=f"^{name} must be between"):
        RobotSettings(**{name: more})


def test_every_limit_is_of_a_setting() -> None:
    assert set(RANGES) <= {item.name for item in dataclasses.fields(RobotSettings)}


@each("policy", WrongOrder)
def test_every_answer_to_a_wrong_order_can_be_set(policy: WrongOrder) -> None:
    assert server_options(RobotSettings(wrong_order=policy.name.lower())).wrong_order is policy
