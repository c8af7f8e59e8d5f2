"""A real target is left as a person would want to find it."""

from __future__ import annotations

import os
import termios
import tty
from collections.abc import Iterator
from contextlib import contextmanager, suppress

import pytest

from hilbench.check.bench_provider import make_provider
from hilbench.clock import NS_PER_MS, Scheduler
from hilbench.judging.provider import CaseInfo
from hilbench.terminal.options import CheckOptions, TargetChoice

STOPPED_SIP = bytes.fromhex("FA FB 1B 32 00 00 00 00 00 00 00 00 00 00 80 00 00 00 00 00 00 00 00 05 00 00 FF 00 38 7F")
STOP = bytes.fromhex("FA FB 03 1D 00 1D")
ENABLE_0 = bytes.fromhex("FA FB 06 04 3B 00 00 04 3B")
CLOSE_1 = bytes.fromhex("FA FB 06 02 3B 01 00 03 3B")


@contextmanager
def robot_in_session() -> Iterator[tuple[RobotInSession, str]]:
    """The far end of a pty, and its name: SIPs come from it until CLOSE, and what was written to it is kept."""
    master, slave = os.openpty()
    tty.setraw(slave)
    os.set_blocking(master, False)
    try:
        yield RobotInSession(master), os.ttyname(slave)
    finally:
        os.close(master)
        os.close(slave)


class RobotInSession:
    """It lives in bench time: a host that is busy makes it no slower than those who wait for it."""

    def __init__(self, descriptor: int) -> None:
        self.written = bytearray()
        self._descriptor = descriptor

    def live(self, scheduler: Scheduler) -> None:
        with suppress(BlockingIOError):
            self.written.extend(os.read(self._descriptor, 4096))
        if CLOSE_1 not in self.written:
            os.write(self._descriptor, STOPPED_SIP)
        scheduler.after(20 * NS_PER_MS, lambda: self.live(scheduler))


@pytest.mark.real_time("a robot at a pseudo-terminal is closed; how long that takes is not judged")
@pytest.mark.slow("the line is to be silent for a while before it is left")
def test_the_session_is_closed_before_the_first_case_and_after_the_last() -> None:
    with robot_in_session() as (robot, name):
        provider = make_provider(CheckOptions(targets=(TargetChoice(spec=f"serial:{name}"),)))
        robot.live(provider._scheduler)
        try:
            with provider.open_case(CaseInfo(id="x", clause_ids=("S01",), seed=0)) as bench:
                assert bytes(robot.written) == STOP + ENABLE_0 + CLOSE_1
                robot.written.clear()  # the robot talks again, as after a case that failed in the middle of a session
                bench.finish("fail", "")
        finally:
            provider.close()
        assert bytes(robot.written) == STOP + ENABLE_0 + CLOSE_1


@pytest.mark.usefixtures("skips")
@pytest.mark.parametrize(
    ("suite", "rate", "speed"),
    [
        ("p2os-server", "", termios.B9600),
        ("pkt-board", "", termios.B115200),
        ("pkt-board", "@57600", termios.B57600),
    ],
)
def test_a_port_without_a_rate_is_opened_at_the_usual_one_of_its_protocol(suite: str, rate: str, speed: int) -> None:
    master, slave = os.openpty()
    try:
        target = TargetChoice(spec=f"serial:{os.ttyname(slave)}{rate}")
        provider = make_provider(CheckOptions(targets=(target,), suites=(suite,)))
        try:
            with provider.open_case(CaseInfo(id="x", clause_ids=(), seed=0)) as bench:
                assert termios.tcgetattr(slave)[4] == speed
                bench.finish("fail", "")
        finally:
            provider.close()
    finally:
        os.close(master)
        os.close(slave)
