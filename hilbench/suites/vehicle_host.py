"""What the simulator's side must do, faced with a board of a script: what it commands the car, what it says of it.

Our own is told what its car does, and tells what the car was commanded. Of a foreign one only its statuses are seen.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import TypeVar

import pytest

from hilbench.car_simulator import CarSimulator, Published
from hilbench.check import CaseSetup, Violation, at_least, at_most, case, near
from hilbench.check.recorder import record_measure
from hilbench.clock import NS_PER_S
from hilbench.errors import InternalError, UnavailableError
from hilbench.vehicle_cases import CarHostCase, PairCase
from protocols.autoware import AckermannControlCommand
from protocols.carla import (
    BAUD,
    STATUS_BYTES,
    VECTORS,
    AckermannCommand,
    CommandFrame,
    ManualCommand,
    Mode,
    decode_command,
    encode_command,
)
from protocols.carla.clauses import HOST_CLAUSES
from targets.robots.car_host import CarState

FunctionT = TypeVar("FunctionT", bound=Callable[..., object])

_PROFILES = {clause.id: clause.profiles for clause in HOST_CLAUSES}

F1, F2, F3 = (VECTORS[name].data for name in ("F1", "F2", "F3"))
COMMAND = decode_command(F1)
POLL_S = 0.020
START_WITHIN_S = 10.0
"""How long a program may take to its first byte. A choice: a busy machine starts an interpreter in two."""

UNDERSTAND_S = 0.1
"""Until a frame that is complete is understood: five polls. A choice."""

MANUAL_WITHIN_S = 0.045
"""Until the frame of mode 4 is handed on; with 50 ms since an F3 less than its rhythm. A choice."""

HELD_S = 0.100
"""So much later where a quiet line holds the status up until the next F3 (VS21), and a read comes each 20 ms."""

STOP_WITHIN_S = 0.5
RANDOM_BYTES = 1_000_000
CHUNK_BYTES = 2000
"""So many at once find room in the buffer of a terminal, 4096."""


def on_host(clause_id: str, *, lasts_s: float) -> Callable[[FunctionT], FunctionT]:
    """Declare the case of a clause, in each of its profiles."""
    setups = {profile: CaseSetup(program=profile) for profile in _PROFILES[clause_id]}
    return case(clause_id, bench_time_s=lasts_s, setups=setups)


class Host:
    """A simulator's side under test.

    Args:
        there: the bench, with it started.
    """

    def __init__(self, there: CarHostCase) -> None:
        self.there = there
        self.board = there.board
        self.bench = there.bench

    @property
    def own(self) -> CarSimulator:
        """Ours, which tells what its car is commanded.

        Raises:
            InternalError: it is a foreign one, and the case has not said that it needs ours.
        """
        if self.there.client.own is None:
            raise InternalError("the case needs to see the car and has not said so")
        return self.there.client.own

    @property
    def told(self) -> list[Published]:
        """What the car was commanded, by frames or by CARLA's ackermann node."""
        return self.own.published

    @property
    def published(self) -> list[Published]:
        """The same without the node."""
        return [one for one in self.told if not one.by_node]

    @property
    def commands(self) -> list[AckermannCommand | ManualCommand]:
        """The same without the times."""
        return [one.command for one in self.published]

    def say(self, data: bytes, wait_s: float = UNDERSTAND_S) -> None:
        """Put bytes on the line at the time of a poll, and let time pass."""
        self.board.write(data)
        self.board.run(10 * len(data) / BAUD + wait_s)

    def require(self, *wanted: AckermannCommand | ManualCommand) -> None:
        """Require what the car was commanded since the start, and nothing else."""
        if not _same(self.commands, wanted):
            shown = [f"{one.ns / NS_PER_S:10.4f} s  {one.command}" for one in self.published[:8]] or ["nothing"]
            raise Violation(f"handed on: {len(self.commands)} commands, required {len(wanted)}", shown)

    def move(self, state: CarState) -> None:
        """Say statuses by hand from now on, of a car that moves so."""
        self.own.report_by_hand()
        self.own.sense(state)

    def statuses_from_now(self) -> int:
        """Return a mark in the statuses."""
        return self.board.mark()


def _same(
    found: Sequence[AckermannCommand | ManualCommand], wanted: Sequence[AckermannCommand | ManualCommand]
) -> bool:
    return len(found) == len(wanted) and all(map(_alike, found, wanted))


def _alike(one: AckermannCommand | ManualCommand, other: AckermannCommand | ManualCommand) -> bool:
    """Both say the same, as far as floats of 32 bits tell."""
    if type(one) is not type(other):
        return False
    names = one.__dataclass_fields__
    pairs = ((getattr(one, name), getattr(other, name)) for name in names)
    return all(abs(left - right) <= 1e-6 * max(1.0, abs(right)) for left, right in pairs)


@pytest.fixture
def host(bench: CarHostCase) -> Host:
    """The simulator's side, begun."""
    bench.client.start()
    board = bench.board
    if bench.client.own is None:
        heard = board.bench.run_until(lambda: board.bytes_received > 0 or bool(bench.client.ended()), START_WITHIN_S)
        if not heard:
            raise Violation(f"nothing came within {START_WITHIN_S:g} s of its start")
        if board.bytes_received == 0:
            raise UnavailableError(f"the simulator's side {bench.client.ended()} before it sent anything")
    return Host(bench)


ACKERMANN = AckermannCommand(
    steering_rad=0.6, steering_rate_rad_s=0.12, speed_m_s=5.0, acceleration_m_s2=1.0, jerk_m_s3=0.2
)
MANUAL = ManualCommand(steer=-0.5, throttle=0.75, brake=0.0)

OTHER_WAY = CommandFrame(
    steering=-0.48, steering_rate=-0.3, speed=-2.0, acceleration=-3.0, jerk=-0.5, mode=Mode.AUTOWARE
)
"""To the right, in reverse and braking: each sign that F1 does not have."""


# --- commands


@on_host("VS01", lasts_s=0.3)
def test_a_command_of_mode_1(host: Host) -> None:
    host.say(F1)
    host.say(encode_command(OTHER_WAY))
    other = AckermannCommand(
        steering_rad=-0.48, steering_rate_rad_s=-0.3, speed_m_s=-2.0, acceleration_m_s2=-3.0, jerk_m_s3=-0.5
    )
    host.require(ACKERMANN, other)


@on_host("VS02", lasts_s=0.3)
def test_a_command_of_mode_4(host: Host) -> None:
    host.say(F2)
    host.say(encode_command(CommandFrame(steering=0.25, acceleration=0.5, mode=Mode.MANUAL)))
    host.require(MANUAL, ManualCommand(steer=0.25, brake=0.5))


@on_host("VS03", lasts_s=0.2)
def test_an_emergency_stops_the_car(host: Host) -> None:
    host.say(F3)
    host.require(AckermannCommand())


@on_host("VS04", lasts_s=0.7)
def test_unknown_modes_are_not_handed_on(host: Host) -> None:
    for mode in (2, 3, 5, 6, 7, 255):
        host.say(encode_command(replace(COMMAND, mode=mode)))
    host.require()


@on_host("VS05", lasts_s=0.2)
def test_the_nul_is_not_needed(host: Host) -> None:
    host.say(F1[:-1])
    host.require(ACKERMANN)


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
    host.require(ACKERMANN, replace(ACKERMANN, steering_rad=-0.3, speed_m_s=9.0))


@on_host("VS07", lasts_s=0.2)
def test_a_hash_too_many_costs_a_frame(host: Host) -> None:
    host.say(b"#" + F1[:-1])
    host.require()


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
    return sum(_alike(one, ACKERMANN) for one in host.commands)


@on_host("VS08", lasts_s=1.6)
def test_a_shifted_stream_is_never_read(host: Host) -> None:
    at_most(_shifted(host), 0, unit="frames", what="of 40 handed on")


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
    host.require(ACKERMANN)


@on_host("VS10", lasts_s=0.2)
def test_an_empty_frame_commands(host: Host) -> None:
    host.say(b"#$")
    at_least(len(host.commands), 1, unit="commands", what="handed on")


@on_host("VS10H", lasts_s=0.2)
def test_an_empty_frame_says_nothing(host: Host) -> None:
    host.say(b"#$")
    host.require()


@on_host("VS12", lasts_s=0.2)
def test_a_carriage_return_becomes_a_newline(host: Host) -> None:
    _require_speed(host, "0D0D0D3F", 0.539216)


@on_host("VS12H", lasts_s=0.2)
def test_a_carriage_return_is_a_byte(host: Host) -> None:
    _require_speed(host, "0D0D0D3F", 0.550980)


def _require_speed(host: Host, value: str, speed_m_s: float) -> None:
    """Require the speed that is handed on for the bytes of one."""
    host.say(F1.replace(bytes.fromhex("0000A040"), bytes.fromhex(value)))
    (command,) = host.commands or (None,)
    assert isinstance(command, AckermannCommand), "no command of mode 1 is handed on"
    near(command.speed_m_s, speed_m_s, 1e-6, unit="m/s", what="the speed that is handed on")


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


def _status_between(host: Host) -> None:
    """Say F2, have a status sent, and say an empty frame."""
    host.move(CarState())
    host.say(F2, 0.003)  # the next read of one that polls, which may wait, is yet to come
    host.own.report("velocity", "steering")
    host.board.run(0.003)
    host.say(b"#$")


@on_host("VS28", lasts_s=0.3)
def test_sending_forgets_the_mode(host: Host) -> None:
    _status_between(host)
    host.require(MANUAL, AckermannCommand(steering_rad=-0.5, speed_m_s=0.75))


@on_host("VS28H", lasts_s=0.3)
def test_values_keep_their_mode(host: Host) -> None:
    _status_between(host)
    host.require(MANUAL)


NODE_S = 1.0
"""So long CARLA's node goes on behind its last command."""


def _from_autoware_to_joystick(host: Host) -> int:
    """Say commands of mode 1, and then the joystick's; return how many the car was told until the first of these."""
    host.board.command = COMMAND
    host.board.commands.start(20.0)
    host.board.run(0.3)
    host.board.commands.stop()
    host.board.command = decode_command(F2)
    host.board.commands.start(1 / 0.06)
    host.board.run(UNDERSTAND_S)
    return len(host.told)


def _others(told: Sequence[Published]) -> list[Published]:
    """What is not the joystick's."""
    return [one for one in told if not _alike(one.command, MANUAL)]


@on_host("VS22", lasts_s=2.2)
def test_the_joystick_is_contradicted(host: Host) -> None:
    start = _from_autoware_to_joystick(host)
    host.board.run(0.8 - UNDERSTAND_S)
    at_least(len(_others(host.told[start:])), 8, unit="commands", what="that are not the joystick's")
    host.board.run(NODE_S - 0.8 + UNDERSTAND_S)
    start = len(host.told)
    host.board.run(0.5)
    at_most(len(_others(host.told[start:])), 0, unit="commands", what="that are not the joystick's a second later")
    at_least(len(host.told) - start, 1, unit="commands", what="of the joystick")


@on_host("VS22H", lasts_s=1.7)
def test_the_joystick_wins(host: Host) -> None:
    start = _from_autoware_to_joystick(host)
    host.board.run(0.8)
    others = _others(host.told[start:])
    if others:
        times = ", ".join(f"{one.ns / NS_PER_S:.3f}" for one in others[:4])
        raise Violation(f"{len(others)} times the car is commanded otherwise than by the joystick, at {times} s")
    at_least(len(host.told) - start, 1, unit="commands", what="of the joystick")


# --- silence and noise


@on_host("VS11", lasts_s=0.6)
def test_a_port_that_is_gone_goes_on_commanding(host: Host) -> None:
    host.say(F1)
    start = len(host.published)
    host.own.read_error(failing=True)
    host.board.run(0.41)
    again = host.published[start:]
    near(len(again), 21, 2, unit="commands", what="handed on again in 0.41 s")
    assert all(_alike(one.command, ACKERMANN) for one in again), "something else than F1 is handed on"


@on_host("VS11H", lasts_s=1.2)
def test_a_port_that_is_gone_stops_the_car(host: Host) -> None:
    host.say(F1)
    host.own.read_error(failing=True)
    host.board.run(1.0)
    host.require(ACKERMANN, AckermannCommand())
    stopped_s = (host.published[1].ns - host.published[0].ns) / NS_PER_S
    at_most(stopped_s, STOP_WITHIN_S, unit="s", what="the car was commanded to stop after")


@on_host("VS26", lasts_s=2.2)
def test_a_silent_board_drives_on(host: Host) -> None:
    host.say(F1, 2.0)
    host.require(ACKERMANN)


@on_host("VS26H", lasts_s=3.4)
def test_a_silent_board_stops_the_car(host: Host) -> None:
    host.say(F1, 2.0)
    host.require(ACKERMANN, AckermannCommand())
    stopped_s = (host.published[1].ns - host.published[0].ns) / NS_PER_S
    near(stopped_s, STOP_WITHIN_S, 0.01, unit="s", what="the car was commanded to stop after")
    host.say(F2)
    host.require(ACKERMANN, AckermannCommand(), MANUAL)
    host.board.run(1.0)
    host.require(ACKERMANN, AckermannCommand(), MANUAL, AckermannCommand())


@on_host("VS23", lasts_s=4.5)
def test_more_than_50_frames_a_second_pile_up(host: Host) -> None:
    handed_on = _many_frames(host)
    near(len(handed_on), 100, 4, unit="frames", what="of 200 handed on when the last has come")
    host.board.run(2.1)
    late_s = (host.published[-1].ns - host.bench.now_ns) / NS_PER_S + 2.1
    near(late_s, 2.0, 0.1, unit="s", what="the last was handed on after")


@on_host("VS23H", lasts_s=2.2)
def test_the_newest_frame_counts(host: Host) -> None:
    handed_on = _many_frames(host)
    last = handed_on[-1].command
    assert isinstance(last, AckermannCommand)
    near(last.speed_m_s, 19.9, 1e-5, unit="m/s", what="the speed handed on last")


def _many_frames(host: Host) -> list[Published]:
    """Say frames at 100 Hz for 2 s, each with its own speed; return what is handed on until 50 ms behind them."""
    begun_ns = host.bench.now_ns
    for number in range(200):
        host.board.write(encode_command(replace(COMMAND, speed=number / 10)))
        host.board.run((begun_ns + (number + 1) * 10_000_000 - host.bench.now_ns) / NS_PER_S)
    host.board.run(0.045)
    return [*host.published]


@on_host("VS25", lasts_s=700.0)
def test_whatever_comes(host: Host) -> None:
    chance = random.Random(host.there.case.seed)
    host.own.report_by_hand()
    for _ in range(RANDOM_BYTES // CHUNK_BYTES):
        host.own.hear(chance.randbytes(CHUNK_BYTES))
        host.board.run(host.own.backlog_s + POLL_S)
    believed = host.own.host.connection.counters.frames_in
    record_measure("frames believed in a million random bytes", float(believed), "frames")
    before = len(host.commands)
    for _ in range(3):  # the first may end what was begun
        host.say(F1)
    assert any(_alike(one, ACKERMANN) for one in host.commands[before:]), "F1 is not handed on behind the noise"


# --- statuses


@on_host("VS13", lasts_s=2.2)
def test_a_status_has_22_bytes(host: Host) -> None:
    board = host.board
    mark, dropped = board.mark(), len(board.dropped)
    board.run(2.0)
    if board.dropped[dropped:]:
        between = board.dropped[dropped].data.hex(" ").upper()
        raise Violation(f"{between} stands between the frames of {STATUS_BYTES} bytes", board.evidence())
    at_least(len(board.frames(mark)), 1, unit="statuses", what="in 2 s")


@on_host("VS14", lasts_s=1.0)
def test_a_status_waits_for_both_reports(host: Host) -> None:
    host.board.commands.start(20.0)  # a quiet board may hold statuses up, see VS21
    _require_one_status(host, CarState(lon_speed_m_s=3.0, steering_rad=0.25), "velocity", "steering")
    _require_one_status(host, CarState(lon_speed_m_s=-4.0, steering_rad=-0.1), "velocity", "steering")
    _require_one_status(host, CarState(lon_speed_m_s=5.0, steering_rad=0.3), "steering", "velocity")


def _require_one_status(host: Host, state: CarState, first: str, second: str) -> None:
    """Say one report and 0.15 s later the other; require no status behind the first, and one behind both."""
    host.move(state)
    host.board.run(0.1)
    mark = host.statuses_from_now()
    host.own.report(first)
    host.board.run(0.15)
    at_most(len(host.board.frames(mark)), 0, unit="statuses", what=f"of a {first} report alone")
    host.own.report(second)
    host.board.run(0.15)
    (status,) = [got.packet for got in host.board.frames(mark)] or [None]
    assert status is not None, "no status comes behind both reports"
    near(status.lon_speed_m_s, state.lon_speed_m_s, 1e-6, unit="m/s", what="its speed")
    near(status.steering_rad, state.steering_rad, 1e-6, unit="rad", what="its steering")


@on_host("VS15", lasts_s=0.3)
def test_the_newest_report_counts(host: Host) -> None:
    host.move(CarState(lon_speed_m_s=3.0, lat_speed_m_s=0.1, yaw_rate_rad_s=0.2))
    host.say(F1, 0.0)
    mark = host.statuses_from_now()
    host.own.report("velocity")
    lateral_m_s, rate_rad_s = 0.3, 0.4
    host.own.sense(CarState(lon_speed_m_s=4.0, lat_speed_m_s=lateral_m_s, yaw_rate_rad_s=rate_rad_s))
    host.own.report("velocity", "steering")
    host.board.run(0.1)
    said = [got.packet for got in host.board.frames(mark) if got.packet is not None]
    speeds = [one.lon_speed_m_s for one in said]
    assert speeds == [4.0], f"the speeds said are {speeds}, required one, the newer"
    near(abs(said[0].lat_speed_m_s), lateral_m_s, 1e-6, unit="m/s", what="B, its sign aside")
    near(abs(said[0].heading_rate_rad_s), rate_rad_s, 1e-6, unit="rad/s", what="C, its sign aside")


def _said(host: Host, state: CarState) -> tuple[float, float, float, float]:
    """The status of a car that moves so."""
    host.move(state)
    host.say(F1, 0.0)
    mark = host.statuses_from_now()
    host.own.report("velocity", "steering")
    host.board.run(0.1)
    (status,) = [got.packet for got in host.board.frames(mark)] or [None]
    assert status is not None, "no status comes behind both reports"
    return status.lon_speed_m_s, status.lat_speed_m_s, status.heading_rate_rad_s, status.steering_rad


@on_host("VS16", lasts_s=0.4)
def test_the_sign_of_steering(host: Host) -> None:
    for steer, wanted_rad in ((0.5, -0.5146), (-0.25, 0.2573)):
        *_, steering_rad = _said(host, CarState(steer=steer))
        near(steering_rad, wanted_rad, 1e-4, unit="rad", what="D")


@on_host("VS17", lasts_s=0.2)
def test_the_signs_of_motion_are_turned_round(host: Host) -> None:
    _require_motion(host, -1.0)


@on_host("VS17H", lasts_s=0.2)
def test_the_signs_of_motion_are_those_of_ros(host: Host) -> None:
    _require_motion(host, 1.0)


def _require_motion(host: Host, sign: float) -> None:
    """Require what is said of a car that turns and slides to the left."""
    _, lateral_m_s, rate_rad_s, _ = _said(host, CarState(lat_speed_m_s=0.05, yaw_rate_rad_s=0.1))
    near(rate_rad_s, sign * 0.1, 1e-6, unit="rad/s", what="C")
    near(lateral_m_s, sign * 0.05, 1e-6, unit="m/s", what="B")


@on_host("VS20", lasts_s=61.0)
def test_statuses_come_in_time(host: Host) -> None:
    host.board.command = COMMAND
    host.board.commands.start(20.0)
    host.board.run(1.0)
    mark = host.statuses_from_now()
    host.board.run(60.0)
    near(len(host.board.frames(mark)), 1200, 2, unit="statuses", what="in 60 s")
    assert not host.board.dropped, "a status is split by something else"


def _statuses_while_silent(host: Host) -> list[float]:
    """Let the board be silent for 2 s; return how far apart statuses come, in seconds."""
    host.say(F1, 0.2)
    mark = host.statuses_from_now()
    host.board.run(2.0)
    frames = host.board.frames(mark)
    return [(later.start_ns - earlier.start_ns) / NS_PER_S for earlier, later in pairwise(frames)]


@on_host("VS21", lasts_s=2.3)
def test_a_quiet_board_holds_the_statuses_up(host: Host) -> None:
    gaps_s = _statuses_while_silent(host)
    near(max(gaps_s), STOP_WITHIN_S, 0.03, unit="s", what="the longest time between two statuses")


@on_host("VS21H", lasts_s=2.3)
def test_a_quiet_board_holds_nothing_up(host: Host) -> None:
    gaps_s = _statuses_while_silent(host)
    near(max(gaps_s), 0.05, 0.002, unit="s", what="the longest time between two statuses")
    near(min(gaps_s), 0.05, 0.002, unit="s", what="the shortest time between two statuses")


# --- with a board at the far end


class Pair:
    """A simulator's side and a board, with a driving stack that commands at 30 Hz.

    Args:
        there: the bench.

    Attributes:
        blocks: its reads wait for something to come, and what is to be sent waits for them (VS21).
    """

    def __init__(self, there: PairCase) -> None:
        self.bench = there.bench
        self.simulator = there.simulator
        self.blocks = there.case.setup.program != "hardened"
        there.stack.command = AckermannControlCommand(speed=5.0)
        there.stack.commands.start(30.0)
        self.simulator.sense(CarState(lon_speed_m_s=5.0))

    def modes(self, start: int = 0) -> list[int | None]:
        """The modes of the frames since a mark."""
        return [one.mode for one in self.simulator.published[start:] if one.mode is not None]

    def require_mode(self, mode: Mode, when: str) -> None:
        """Require the mode of the newest frame."""
        newest = self.modes()[-1:]
        if newest != [mode]:
            text = f"of mode {newest[0]}" if newest else "none at all"
            raise Violation(f"{when} the board's newest frame is {text}, required mode {mode}")

    def report_at_20_hz(self, steps: int) -> None:
        """Let a simulator that pauses between its steps make some of them; the last is made now."""
        for step in range(steps):
            if step:
                self.bench.run_for(0.05)
            self.simulator.report("velocity", "steering")


@pytest.fixture
def pair(bench: PairCase) -> Pair:
    """A simulator's side and a board, begun."""
    return Pair(bench)


@on_host("VS18", lasts_s=6.0)
def test_how_long_a_pause_may_be(pair: Pair) -> None:
    for pause_s, mode in ((0.9, Mode.AUTOWARE), (1.1, Mode.EMERGENCY)):
        pair.report_at_20_hz(20)
        pair.bench.run_for(0.045)
        pair.require_mode(Mode.AUTOWARE, "while statuses come")
        pair.bench.run_for(pause_s - 0.045)
        pair.require_mode(mode, f"{pause_s} s after the last status")
        pair.report_at_20_hz(1)
        pair.bench.run_for(0.05)


@on_host("VS19", lasts_s=3.5)
def test_the_first_status_ends_the_emergency(pair: Pair) -> None:
    pair.report_at_20_hz(20)
    pair.bench.run_for(2.0)
    pair.require_mode(Mode.EMERGENCY, "after a pause of 2 s")
    before = len(pair.simulator.published)
    pair.bench.run_until(lambda: bool(pair.modes(before)), 0.2)
    pair.bench.run_for(0.05)
    before = len(pair.simulator.published)
    pair.report_at_20_hz(1)
    pair.bench.run_for(MANUAL_WITHIN_S + (HELD_S if pair.blocks else 0.0))
    modes = pair.modes(before)
    if pair.blocks and modes[:1] == [Mode.EMERGENCY]:
        del modes[0]  # the one that ends the read
    assert modes[:1] == [Mode.MANUAL], f"behind the first status come frames of the modes {modes}"
