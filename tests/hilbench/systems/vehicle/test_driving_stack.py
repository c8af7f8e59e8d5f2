"""The driving stack against a board's end of the stand-in link, over a line in the bench."""

from __future__ import annotations

import runpy
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

from hilbench.bench import Bench
from hilbench.bench.devices import ClientDevice, DeviceActor
from hilbench.clock import Scheduler
from hilbench.journal import Journal
from hilbench.links import Line, MemoryLink
from hilbench.systems.vehicle.driving_stack import DrivingStack
from protocols.autoware import (
    AckermannControlCommand,
    AgentFound,
    AgentState,
    Clock,
    Connection,
    ControlMode,
    ControlModeReport,
    ControlModeRequest,
    ControlModeResponse,
    LocalProtocolError,
    MessageReceived,
    Role,
    SteeringReport,
    Time,
    Transmit,
    TurnIndicatorsCommand,
    VelocityReport,
)


class Board:
    """The board's end: keeps what it hears, answers requests when told to."""

    def __init__(self, bench, port):
        self.bench = bench
        self.connection = Connection(Role.BOARD)
        self.heard = []
        self.found = 0
        self.answers = True
        self.actor = DeviceActor(bench, ClientDevice(self.connection, Transmit), port, name="board", on_event=self.take)

    def say(self, message):
        self.actor.transmit(self.connection.send(message, self.bench.now_ns))

    def of(self, kind):
        return [(ns, message) for ns, message in self.heard if isinstance(message, kind)]

    def take(self, event):
        if isinstance(event, MessageReceived):
            self.heard.append((self.bench.now_ns, event.message))
            if self.answers and isinstance(event.message, ControlModeRequest):
                self.say(ControlModeResponse(sequence=event.message.sequence, success=event.message.mode in (1, 4)))
        self.found += isinstance(event, AgentFound)


@pytest.fixture
def make():
    def make(**options):
        bench = Bench(Scheduler(), Journal())
        link = MemoryLink(bench.scheduler, Line(baud=921600), name="stack")
        board = Board(bench, link.b)
        return SimpleNamespace(bench=bench, link=link, board=board, stack=DrivingStack(bench, link.a, **options))

    return make


def test_a_stack_that_opens_is_found_and_tells_the_time(make):
    there = make()
    there.bench.run_for(1.5)
    assert there.board.found == 0
    there.stack.open()
    there.bench.run_for(1.01)
    assert there.board.found == 1
    clocks = there.board.of(Clock)
    assert len(clocks) == 21
    assert [message.clock.ns for _, message in clocks[:2]] == [1_500_000_000, 1_550_000_000]


def test_a_ping_is_answered_while_it_is_open_alone(make):
    there = make()
    there.bench.run_for(0.5)
    there.stack.open()
    there.stack.close()
    there.bench.run_for(5.0)
    assert there.board.found == 1  # by the greeting
    again = make()
    again.stack.open()
    again.bench.run_for(0.1)
    assert again.stack.connection.counters.pings == 1


def test_without_a_clock_nothing_is_said_after_the_greeting(make):
    there = make(clock_hz=None)
    there.stack.open()
    there.bench.run_for(3.0)
    assert there.board.heard == []


def test_subscribers_get_what_they_asked_for_and_the_newest_is_kept(make):
    there = make()
    seen = []
    unsubscribe = there.stack.subscribe(VelocityReport, seen.append)
    there.stack.open()
    first, second = (VelocityReport(stamp=Time(1, 2), longitudinal_velocity=speed) for speed in (1.0, 2.0))
    there.board.say(first)
    there.board.say(SteeringReport(steering_tire_angle=0.25))
    there.board.say(ControlModeReport(mode=ControlMode.MANUAL))
    there.bench.run_for(0.01)
    unsubscribe()
    unsubscribe()
    there.board.say(second)
    there.bench.run_for(0.01)
    assert seen == [first]
    assert there.stack.velocity == second
    assert there.stack.steering == SteeringReport(steering_tire_angle=0.25)
    assert there.stack.mode == ControlMode.MANUAL
    assert there.stack.counts[VelocityReport] == 2
    assert make().stack.mode is None


def test_commands_go_out_at_their_rate_and_can_be_left_out(make):
    there = make(clock_hz=None)
    there.stack.open()
    speeds = iter([1.0, None, 3.0, 4.0])

    def source():
        speed = next(speeds, None)
        return None if speed is None else there.stack.command(speed=speed, steering_tire_angle=-0.5)

    there.stack.drive_with(source, rate_hz=10.0)
    there.bench.run_for(2.0)
    commands = there.board.of(AckermannControlCommand)
    assert [message.speed for _, message in commands] == [1.0, 3.0, 4.0]
    assert [message.stamp.ns for _, message in commands] == [0, 200_000_000, 300_000_000]
    assert commands[0][1].steering_tire_angle == -0.5


def test_thirty_commands_a_second_until_it_stops(make):
    there = make(clock_hz=None)
    there.stack.open()
    there.stack.drive_with(lambda: there.stack.command(speed=5.0))
    there.bench.run_for(0.99)
    assert len(there.board.of(AckermannControlCommand)) == 30
    there.stack.stop_driving()
    there.bench.run_for(1.0)
    assert len(there.board.of(AckermannControlCommand)) == 30


def test_a_request_is_answered(make):
    there = make()
    there.stack.open()
    answers = []
    there.stack.request_mode(ControlMode.AUTONOMOUS, answers.append)
    there.stack.request_mode(ControlMode.AUTONOMOUS_STEER_ONLY, answers.append)
    there.bench.run_for(0.1)
    assert answers == [True, False]
    assert [message.mode for _, message in there.board.of(ControlModeRequest)] == [1, 2]


def test_a_request_without_an_answer_is_given_up_once(make):
    there = make()
    there.board.answers = False
    there.stack.open()
    answers = []
    there.stack.request_mode(1, answers.append)
    there.bench.run_for(0.9)
    assert answers == []
    there.bench.run_for(0.2)
    assert answers == [None]
    there.board.say(ControlModeResponse(sequence=1, success=True))
    there.bench.run_for(0.1)
    assert answers == [None]


def test_a_board_that_falls_silent_is_lost_and_found_again(make):
    there = make()
    there.board.answers = False
    states, answers = [], []
    there.stack.on_board = states.append
    there.stack.open()
    there.board.say(ControlModeReport())
    there.stack.drive_with(lambda: there.stack.command(speed=5.0))
    there.bench.run_for(0.7)
    there.stack.request_mode(4, answers.append)
    there.bench.run_for(0.5)
    assert there.stack.state is AgentState.ALONE
    assert there.stack.failure == "no frame for too long"
    assert (states, answers) == ([True, False], [None])
    sent = len(there.board.of(AckermannControlCommand))
    there.board.say(ControlModeReport())
    there.bench.run_for(0.5)
    assert (there.stack.failure, states) == ("", [True, False, True])
    assert len(there.board.of(AckermannControlCommand)) == sent + 15


def test_a_line_that_goes_down_closes_it_and_it_can_be_opened_again(make):
    there = make()
    there.stack.open()
    there.stack.drive_with(lambda: there.stack.command(speed=5.0))
    there.board.say(ControlModeReport())
    there.bench.run_for(0.1)
    there.link.hang_up()
    there.bench.run_for(0.5)
    assert there.stack.state is AgentState.CLOSED
    assert there.stack.failure == "the line went down"
    there.link.restore()
    heard = len(there.board.heard)
    there.bench.run_for(0.5)
    assert len(there.board.heard) == heard
    there.stack.open()
    there.bench.run_for(0.5)
    assert len(there.board.of(Clock)) > heard - 10


def test_misuse_is_refused(make):
    there = make()
    with pytest.raises(LocalProtocolError, match="cannot disconnect"):
        there.stack.close()
    with pytest.raises(LocalProtocolError, match="not for the agent"):
        there.stack.publish(ControlModeReport())
    there.stack.open()
    with pytest.raises(LocalProtocolError, match="cannot connect"):
        there.stack.open()
    there.stack.publish(TurnIndicatorsCommand(command=2))
    there.bench.run_for(0.01)
    assert there.board.of(TurnIndicatorsCommand)


def test_the_same_run_twice_gives_the_same_journal(make):
    def run():
        there = make()
        there.bench.journal.begin_case("one")
        there.stack.open()
        there.stack.drive_with(lambda: there.stack.command(speed=5.0))
        there.stack.request_mode(1)
        there.board.say(ControlModeReport())
        there.bench.run_for(2.0)
        return there.bench.journal.end_case(there.bench.now_ns)

    assert run() == run()


def test_the_example_drives(monkeypatch, capfd):
    monkeypatch.setattr(sys, "argv", ["driving_stack.py"])
    runpy.run_path(str(Path(__file__).parents[4] / "examples" / "clients" / "driving_stack.py"), run_name="__main__")
    out, err = capfd.readouterr()
    assert err == ""
    lines = out.splitlines()
    assert "mode AUTONOMOUS" in lines[0]
    assert any("3.00 m/s" in line for line in lines)
    assert "0.00 m/s" in lines[-1]
