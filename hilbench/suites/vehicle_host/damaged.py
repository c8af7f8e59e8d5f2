"""Frames in pieces, behind something else, without a field, or with a carriage return in them."""

from __future__ import annotations

from dataclasses import replace

from hilbench.check import at_least, at_most, near
from hilbench.suites.vehicle_host._host import ACKERMANN, COMMAND, F1, F2, POLL_S, Host, alike, host, on_host
from protocols.carla import AckermannCommand, ManualCommand, Mode, encode_command

__all__ = ["host"]


def _torn(host: Host) -> None:
    """Say a frame, the beginning of another, and 20 ms later its rest."""
    second = encode_command(replace(COMMAND, steering=-0.3, speed=9.0, mode=Mode.EMERGENCY))
    host.say(F1, 0.030)
    host.say(second[:10], POLL_S)
    host.say(second[10:])


@on_host("VS06", lasts_s=0.3)
def test_torn_frames(host: Host) -> None:
    _torn(host)
    host.require(ACKERMANN, replace(ACKERMANN, steering_rad=-0.3))


@on_host("VS06H", lasts_s=0.6)
def test_a_frame_in_pieces_is_one_frame(host: Host) -> None:
    _torn(host)
    host.say(F1[:10], 0.15)
    host.say(F1[10:])
    host.require_no_more(ACKERMANN, replace(ACKERMANN, steering_rad=-0.3, speed_m_s=9.0))


@on_host("VS07", lasts_s=0.3)
def test_a_hash_too_many_costs_a_frame(host: Host) -> None:
    host.say(b"#" + F1[:-1])
    host.require_nothing()


@on_host("VS07H", lasts_s=6.0)
def test_a_hash_too_many_costs_nothing(host: Host) -> None:
    whole = F1[:-1]
    stray = [part for at in range(1, len(whole)) for part in (whole[:at], whole[at:])]
    for part in stray:
        host.say(part + whole)
    host.require(*[ACKERMANN] * len(stray))


def _shifted(host: Host) -> int:
    """Say 40 frames behind 7 stray bytes, without a gap; return how many are handed on."""
    host.say(b"\x01" * 7 + F1 * 40, 1.5)
    return sum(alike(one, ACKERMANN) for one in host.commands)


@on_host("VS08", lasts_s=1.7)
def test_a_shifted_stream_is_never_read(host: Host) -> None:
    at_most(_shifted(host), 0, unit="frames", what="of 40 handed on")
    host.require_heard()


@on_host("VS08H", lasts_s=1.6)
def test_a_shifted_stream_is_read(host: Host) -> None:
    at_least(_shifted(host), 39, unit="frames", what="of 40 handed on")


_MODE_ALONE = bytes.fromhex("234D0424")


@on_host("VS09", lasts_s=0.3)
def test_missing_fields_keep_their_old_values(host: Host) -> None:
    host.say(F1)
    host.say(_MODE_ALONE)
    host.require(ACKERMANN, ManualCommand(steer=0.6, throttle=5.0, brake=1.0))


@on_host("VS09H", lasts_s=0.4)
def test_a_frame_that_lacks_a_field_is_none(host: Host) -> None:
    host.say(F1)
    host.say(_MODE_ALONE)
    host.say(F2.replace(b"W", b"S", 1))
    host.require_no_more(ACKERMANN)


@on_host("VS10", lasts_s=0.2)
def test_an_empty_frame_commands(host: Host) -> None:
    host.say(b"#$")
    at_least(len(host.commands), 1, unit="commands", what="handed on")


@on_host("VS10H", lasts_s=0.3)
def test_an_empty_frame_says_nothing(host: Host) -> None:
    host.say(b"#$")
    host.require_nothing()


@on_host("VS12", lasts_s=0.2)
def test_a_carriage_return_becomes_a_newline(host: Host) -> None:
    _require_speed(host, "0D0D0D3F", 0.539216)


@on_host("VS12H", lasts_s=0.2)
def test_a_carriage_return_is_a_byte(host: Host) -> None:
    _require_speed(host, "0D0D0D3F", 0.550980)


def _require_speed(host: Host, value: str, speed_m_s: float) -> None:
    """Require the speed that is handed on for the bytes of one."""
    host.say(F1.replace(bytes.fromhex("0000A040"), bytes.fromhex(value)))
    host.wait_told(lambda: bool(host.commands))
    (command,) = host.commands or (None,)
    assert isinstance(command, AckermannCommand), "no command of mode 1 is forwarded"
    near(command.speed_m_s, speed_m_s, 1e-6, unit="m/s", what="the speed that is handed on")
