"""Values that cannot be meant."""

from __future__ import annotations

import math
from dataclasses import replace

from hilbench.suites.vehicle_host._host import COMMAND, F2, Host, host, on_host
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
    assert any(map(math.isnan, speeds)), "the NaN is not forwarded"


_MOST = {"steering": 2.5, "steering_rate": 50.0, "speed": 150.0, "acceleration": 100.0, "jerk": 1000.0}
_MOST_MANUAL = dict.fromkeys(("steering", "speed", "acceleration"), 10.0)
"""What a frame can be meant with, in mode 1: rad, rad/s, m/s, m/s^2, m/s^3; in mode 4."""
_UNUSED = ("steering_rate", "jerk")
"""What mode 4 has no use for."""

INSIDE, OUTSIDE = 0.99, 1.01
"""Shares of a limit that are just within it and just beyond."""


@on_host("VS27H", lasts_s=5.2)
def test_what_cannot_be_meant_is_dropped(host: Host) -> None:
    for sound, limits in ((COMMAND, _MOST), (decode_command(F2), _MOST_MANUAL)):
        for name, most in limits.items():
            for value in (math.nan, math.inf, -math.inf, OUTSIDE * most, -OUTSIDE * most):
                host.say(encode_command(replace(sound, **{name: value})))  # type: ignore[arg-type]
    for name in _UNUSED:
        for value in (math.nan, math.inf, -math.inf):
            host.say(encode_command(replace(decode_command(F2), **{name: value})))  # type: ignore[arg-type]
    host.require()
    for sign in (1, -1):
        for mode, limits in ((Mode.AUTOWARE, _MOST), (Mode.MANUAL, _MOST_MANUAL)):
            figures = {name: sign * INSIDE * most for name, most in limits.items()}
            host.say(encode_command(CommandFrame(mode=mode, **figures)))
    host.require(
        _the_most(1),
        ManualCommand(steer=1.0, throttle=1.0, brake=1.0),
        _the_most(-1),
        ManualCommand(steer=-1.0),
    )


def _the_most(sign: int) -> AckermannCommand:
    angle, rate, speed, acceleration, jerk = (sign * INSIDE * most for most in _MOST.values())
    return AckermannCommand(
        steering_rad=angle,
        steering_rate_rad_s=rate,
        speed_m_s=speed,
        acceleration_m_s2=acceleration,
        jerk_m_s3=jerk,
    )
