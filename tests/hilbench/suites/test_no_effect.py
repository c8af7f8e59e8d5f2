"""Suites on targets on which nothing that is sent, or done by hand, has an effect: what judges an effect never passes.

A case may say that the target violates its clause, or that what it needs was not reached; that all is well it may say
only if it judges something else. Which do is listed here, with what it is that they judge.
"""

from __future__ import annotations

import contextlib
from dataclasses import replace
from unittest.mock import patch

import pytest

from hilbench.bench_provider import make_provider
from hilbench.check import CheckOptions, Verdict, run_suites
from hilbench.config import open_bench
from hilbench.journal import Journal
from hilbench.rover.hands import ModelHands
from hilbench.rover.provider import RoverProvider
from hilbench.shared import Shared
from protocols import p2os, pkt
from protocols.pkt import ServerState, ServerTrigger, Transition
from protocols.pkt.clauses import BOARD_CLAUSES
from protocols.pkt.server import ServerMachine
from targets.robots.rover import RoverRobot
from targets.robots.rover.control import Tachometers
from targets.robots.vehicle_interface import VehicleInterface
from tests.mutants.bench import run_mutant
from tests.mutants.mutant import Family, Mutant
from tests.mutants.rover import RoverMutant


def clauses_by_verdict(report):
    """Return the clauses of the cases with each verdict, in any profile."""
    return {
        verdict: {clause for case in report.cases if case.verdict is verdict for clause in case.clause_ids}
        for verdict in Verdict
    }


def rover_model(select="", *patches, mutant=None, baud=None):
    bench_file = open_bench("rover-model")
    shared = Shared(bench_file=bench_file, timeout_scale=1.0, journal=Journal())
    with contextlib.ExitStack() as stack:
        for one in patches:
            stack.enter_context(one)
        if baud is not None:
            stack.enter_context(patch("hilbench.rover.provider.rover_baud", return_value=baud))
        provider = RoverProvider(shared) if mutant is None else RoverProvider(shared, make_rover=mutant.make)
        return run_suites(CheckOptions(bench="rover-model", suites=("pkt-board",), select=select), provider)


SAYS_BY_ITSELF = {"P30", "P39", "P39D", "P40", "P40D", "P41", "P41D", "P42", "P42D", "P43", "P43D", "P49", "P49D"}
"""Nothing is commanded."""
COUNTS_AND_ANSWERS = {
    *("P01", "P03", "P04", "P04D", "P64"),
    *("P05", "P06", "P07", "P08", "P09", "P10", "P11", "P12", "P12D", "P13", "P14", "P15", "P16", "P16D", "P17", "P18"),
    *("P20", "P21", "P22", "P23", "P23D", "P25", "P25D", "P31", "P32", "P33", "P34", "P35", "P48", "P48D"),
    *("P60", "P61", "P65"),
}
"""What is judged is whether a frame is taken for one, by the counters and by what is answered."""

DEAF = RoverMutant(
    id="deaf",
    what="nothing but REQUEST_TMY is heard",
    edges={
        (state, trigger): Transition(ServerState.LINKED, ())
        for state in ServerState
        for trigger in (ServerTrigger.COMMAND, ServerTrigger.UNKNOWN, ServerTrigger.SHORT, ServerTrigger.BAD_FRAME)
    },
)


NOT_REACHED = {"P28D", "P29", "P29D", "P45", "P45D", "P46", "P46D", "P47", "P47D"}
"""What needs a command to have been carried out before it can judge anything."""


def idle_rover(select):
    """Check a rover that counts and answers each command, and carries none out."""
    idle = patch.object(RoverRobot, "_obey", lambda _self, _command: None)
    dark = patch.object(RoverRobot, "_switch_led", lambda _self, _lit: None)
    return clauses_by_verdict(rover_model(select, idle, dark))


def test_what_was_not_reached_is_inconclusive():
    assert idle_rover("P28D or P45 or P45D or P46 or P46D or P47D")[Verdict.INCONCLUSIVE] == NOT_REACHED - {
        *("P29", "P29D", "P47")
    }


@pytest.mark.exhaustive("all clauses on a rover that carries nothing out; the gate has those that need most")
def test_no_command_has_an_effect():
    found = idle_rover("")
    assert found[Verdict.PASS] == SAYS_BY_ITSELF | COUNTS_AND_ANSWERS
    assert found[Verdict.ERROR] == set()
    assert found[Verdict.INCONCLUSIVE] >= NOT_REACHED
    assert {clause.id for clause in BOARD_CLAUSES} == set().union(*found.values())


@pytest.mark.exhaustive("all clauses on a rover that counts nothing either; the gate has one that does")
def test_nothing_but_a_request_is_heard():
    found = clauses_by_verdict(rover_model("", patch.object(ServerMachine, "drop", lambda *_: None), mutant=DEAF))
    assert found[Verdict.PASS] & COUNTS_AND_ANSWERS == {"P01"}
    assert found[Verdict.PASS] <= {"P01"} | SAYS_BY_ITSELF
    assert found[Verdict.ERROR] == set()


def test_frames_are_not_lost_by_a_look_that_takes_none():
    deaf = patch.object(ServerMachine, "drop", lambda *_: None)
    assert clauses_by_verdict(rover_model("P25 and g2", deaf, mutant=DEAF))[Verdict.PASS] == set()


def test_hands_that_hold_no_wheel():
    let_go = patch.object(ModelHands, "hold_wheels", lambda _self, _held: None)
    found = clauses_by_verdict(rover_model("P46 or P46D or P47 or P47D", let_go))
    assert found[Verdict.INCONCLUSIVE] == {"P46", "P46D", "P47", "P47D"}


def test_a_report_without_any_measurement_is_no_wrong_unit_and_no_wrong_order():
    imu = RoverRobot._imu

    def without(robot):
        return replace(imu(robot), acceleration=(0.0, 0.0, 0.0))

    found = clauses_by_verdict(rover_model("P41 or P41D or P42 or P42D", patch.object(RoverRobot, "_imu", without)))
    assert found[Verdict.INCONCLUSIVE] == {"P41", "P41D", "P42", "P42D"}


def test_wheels_that_never_turn_in_a_report_do_not_stop_in_it():
    still = patch.object(Tachometers, "read", lambda *_: None)
    found = clauses_by_verdict(rover_model("P47D", still))
    assert found[Verdict.INCONCLUSIVE] == {"P47D"}


def test_a_line_that_is_too_slow_for_what_is_judged_shows_nothing():
    found = clauses_by_verdict(rover_model("P25 or P25D or P48 or P48D", baud=9600))
    assert found[Verdict.INCONCLUSIVE] == {"P25", "P25D", "P48", "P48D"}


# --- the other suites

NOTHING_MAY_COME_OF_IT = {"S07", "S20"}
"""What is required is that a stimulus has no effect; so it is in M24 and VB42."""
HANDSHAKE = {
    *("S01", "S02", "S03", "S04", "S05", "S06", "S08", "S09", "S10", "S11", "S12", "S13", "S14", "S15", "S16"),
    *("S18", "S19", "S39", "S40"),
}
"""How a session begins, goes on by itself and ends; a robot that obeys nothing answers all the same."""
SEES_BY_ITSELF = {"S54"}
"""A robot that stands at a wall hears it."""


def passed(report):
    return clauses_by_verdict(report)[Verdict.PASS]


def disobedient(family):
    """A Pioneer that is in session and obeys no command."""
    return Mutant(id="idle", family=family, what="obeys no command", mute=frozenset({"CommandReceived"}))


@pytest.mark.exhaustive("a whole suite, most of whose cases wait for what does not come")
@pytest.mark.needs_bullet
@pytest.mark.parametrize(
    ("family", "allowed"),
    [
        (Family.SERVER_HAND, HANDSHAKE | SEES_BY_ITSELF | NOTHING_MAY_COME_OF_IT),
        (Family.MOTION_HAND, {"M24"}),
    ],
)
def test_a_pioneer_that_obeys_nothing(family, allowed):
    assert passed(run_mutant(disobedient(family), family)) == allowed


@pytest.mark.exhaustive("a whole suite, most of whose cases wait for what does not come")
def test_a_vehicle_interface_that_hears_and_feels_nothing():
    still = {
        "receive": lambda board, _line, _data, now_ns: board.advance(now_ns),
        "set_joystick": lambda board, _x, _y, now_ns: board.advance(now_ns),
        "press": lambda board, now_ns: board.advance(now_ns),
    }
    options = CheckOptions(bench="vehicle-model", suites=("vehicle-board",))
    with patch.multiple(VehicleInterface, **still):
        # VB03: without an agent the mode is MANUAL; nothing is sent.
        assert passed(run_suites(options, make_provider(options))) == {"VB03", "VB42"}


def deaf_client(bench, suite, protocol, select=""):
    """Check a client that hears nothing of what it is told."""
    receive = protocol.Connection.receive
    options = CheckOptions(bench=bench, suites=(suite,), select=select)
    with patch.object(protocol.Connection, "receive", lambda self, _data, now_ns: receive(self, b"", now_ns)):
        return passed(run_suites(options, make_provider(options)))


def test_a_client_that_hears_nothing_has_not_dealt_with_what_it_was_told():
    assert deaf_client("rover-model", "pkt-host", pkt, "P36 or P55") == set()
    assert deaf_client("pioneer-plane", "p2os-client", p2os, "C11") == set()


@pytest.mark.exhaustive("whole suites, most of whose cases wait for what does not come")
def test_a_client_that_hears_nothing():
    # C01: silence makes it give up. P50 to P53: what a ground station says by itself.
    assert deaf_client("pioneer-plane", "p2os-client", p2os) == {"C01"}
    assert deaf_client("rover-model", "pkt-host", pkt) == {"P50", "P51", "P52", "P53"}
