"""Values that cannot be meant."""

from __future__ import annotations

import math
from dataclasses import replace

from hilbench.suites.vehicle_host._host import ACKERMANN, COMMAND, F2, Host, host, on_host
from protocols.carla import AckermannCommand, CommandFrame, ManualCommand, Mode, decode_command, encode_command

__all__ = ["host"]


@on_host("VS24", lasts_s=0.2)
def test_steering_beyond_one_is_handed_on(host: Host) -> None:
    host.say(encode_command(CommandFrame(steering=2.0, mode=Mode.MANUAL)))
    host.require(ManualCommand(steer=2.0))


@on_host("VS24H", lasts_s=0.3)
def test_steering_ends_at_one(host: Host) -> None:
    host.say(encode_command(CommandFrame(steering=2.0, speed=1.5, acceleration=-1.0, mode=Mode.MANUAL)))
    host.say(encode_command(CommandFrame(steering=-2.0, speed=-1.0, acceleration=1.5, mode=Mode.MANUAL)))
    host.require(ManualCommand(steer=1.0, throttle=1.0), ManualCommand(steer=-1.0, brake=1.0))


@on_host("VS27", lasts_s=0.2)
def test_a_nan_is_handed_on(host: Host) -> None:
    host.say(encode_command(replace(COMMAND, speed=math.nan)))
    speeds = [one.speed_m_s for one in host.commands if isinstance(one, AckermannCommand)]
    assert any(map(math.isnan, speeds)), "the NaN is not handed on"


_FIELDS = ("steering", "steering_rate", "speed", "acceleration", "jerk")


@on_host("VS27H", lasts_s=3.7)
def test_what_cannot_be_meant_is_dropped(host: Host) -> None:
    for sound, names in ((COMMAND, _FIELDS), (decode_command(F2), ("steering", "speed", "acceleration"))):
        for name in names:
            for value in (math.nan, math.inf, -math.inf, 1e30):
                host.say(encode_command(replace(sound, **{name: value})))  # type: ignore[arg-type]
    host.say(encode_command(replace(COMMAND, speed=151.0)))
    host.require()
    host.say(encode_command(replace(COMMAND, speed=149.0)))
    host.require(replace(ACKERMANN, speed_m_s=149.0))
