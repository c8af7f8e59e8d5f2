"""Commands of each mode, as they are handed on."""

from __future__ import annotations

from dataclasses import replace

from hilbench.suites.vehicle_host._host import ACKERMANN, COMMAND, F1, F2, F3, MANUAL, Host, host, on_host
from protocols.carla import AckermannCommand, CommandFrame, ManualCommand, Mode, encode_command

__all__ = ["host"]

OTHER_WAY = CommandFrame(
    steering=-0.48, steering_rate=-0.3, speed=-2.0, acceleration=-3.0, jerk=-0.5, mode=Mode.AUTOWARE
)
"""To the right, in reverse and braking: each sign that F1 does not have."""

OTHER_ACKERMANN = AckermannCommand(
    steering_rad=-0.48, steering_rate_rad_s=-0.3, speed_m_s=-2.0, acceleration_m_s2=-3.0, jerk_m_s3=-0.5
)


@on_host("VS01", lasts_s=0.3)
def test_a_command_of_mode_1(host: Host) -> None:
    host.say(F1)
    host.say(encode_command(OTHER_WAY))
    host.require(ACKERMANN, OTHER_ACKERMANN)


@on_host("VS02", lasts_s=0.3)
def test_a_command_of_mode_4(host: Host) -> None:
    host.say(F2)
    host.say(encode_command(CommandFrame(steering=0.25, acceleration=0.5, mode=Mode.MANUAL)))
    host.require(MANUAL, ManualCommand(steer=0.25, brake=0.5))


@on_host("VS03", lasts_s=0.2)
def test_an_emergency_stops_the_car(host: Host) -> None:
    host.say(F3)
    host.require(AckermannCommand())


@on_host("VS29", lasts_s=0.3)
def test_a_frame_of_mode_0_is_handed_on_as_it_is(host: Host) -> None:
    for command in (COMMAND, OTHER_WAY):
        host.say(encode_command(replace(command, mode=Mode.EMERGENCY)))
    host.require(ACKERMANN, OTHER_ACKERMANN)


@on_host("VS04", lasts_s=0.8)
def test_unknown_modes_are_not_handed_on(host: Host) -> None:
    for mode in (2, 3, 5, 6, 7, 255):
        host.say(encode_command(replace(COMMAND, mode=mode)))
    host.require_nothing()


@on_host("VS05", lasts_s=0.2)
def test_the_nul_is_not_needed(host: Host) -> None:
    host.say(F1[:-1])
    host.require(ACKERMANN)
