"""A port that is gone, a board that is silent, or says more than can be read, and noise."""

from __future__ import annotations

import random
from dataclasses import replace

from hilbench.check import Inconclusive, at_most, near
from hilbench.clock import NS_PER_S
from hilbench.judging.recorder import record_measure
from hilbench.suites.vehicle_host._host import (
    ACKERMANN,
    COMMAND,
    F1,
    F2,
    MANUAL,
    POLL_S,
    STOP_WITHIN_S,
    Host,
    alike,
    host,
    on_host,
)
from hilbench.systems.vehicle.car_simulator import Published
from protocols.carla import AckermannCommand, encode_command

__all__ = ["host"]

RANDOM_BYTES = 1_000_000
CHUNK_BYTES = 2000
"""So many at once find room in the buffer of a terminal, 4096."""


@on_host("VS11", lasts_s=0.6)
def test_a_port_that_is_gone_goes_on_commanding(host: Host) -> None:
    host.say(F1)
    start = len(host.published)
    host.ours.read_error(failing=True)
    host.board.run(0.41)
    again = host.published[start:]
    near(len(again), 21, 2, unit="commands", what="handed on again in 0.41 s")
    assert all(alike(one.command, ACKERMANN) for one in again), "something other than F1 is forwarded"


@on_host("VS11H", lasts_s=1.2)
def test_a_port_that_is_gone_stops_the_car(host: Host) -> None:
    host.say(F1)
    host.ours.read_error(failing=True)
    if not host.ours.host.connection.counters.read_errors:
        raise Inconclusive("no read of the port fails")
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
    said_ns = host.bench.now_ns
    host.say(F1, 2.0)
    host.require(ACKERMANN, AckermannCommand())
    stopped_s = (host.published[1].ns - host.published[0].ns) / NS_PER_S
    doubt_s = host.told_late_s(said_ns)
    near(stopped_s, STOP_WITHIN_S, 0.01, unit="s", what="the car was commanded to stop after", uncertainty=doubt_s)
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
    assert handed_on, "nothing is forwarded"
    last = handed_on[-1].command
    assert isinstance(last, AckermannCommand)
    near(last.speed_m_s, 19.9, 1e-5, unit="m/s", what="the speed handed on last")


def _many_frames(host: Host) -> list[Published]:
    """Say frames at 100 Hz for 2 s, each with its own speed; return what is handed on until 50 ms behind them."""
    begun_ns = host.bench.now_ns
    for number in range(200):
        host.board.write(encode_command(replace(COMMAND, speed=number / 10)))
        host.board.run((begun_ns + (number + 1) * 10_000_000 - host.bench.now_ns) / NS_PER_S)
    host.board.run(0.045 + host.told_late_s(begun_ns))
    return [*host.published]


@on_host("VS25", lasts_s=700.0)
def test_whatever_comes(host: Host) -> None:
    chance = random.Random(host.there.case.seed)
    host.own.report_by_hand()
    for _ in range(RANDOM_BYTES // CHUNK_BYTES):
        host.ours.hear(chance.randbytes(CHUNK_BYTES))
        host.board.run(host.ours.backlog_s + POLL_S)
    counters = host.ours.host.connection.counters
    record_measure("frames believed in a million random bytes", float(counters.frames_in), "frames")
    before = len(host.commands)
    for _ in range(3):  # the first may end what was begun
        host.say(F1)
    assert any(alike(one, ACKERMANN) for one in host.commands[before:]), "F1 is not forwarded after the noise"
    if counters.bytes_in < RANDOM_BYTES:
        raise Inconclusive(f"{counters.bytes_in} bytes are heard, required {RANDOM_BYTES} of noise")
