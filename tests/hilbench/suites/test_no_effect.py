"""Suites on targets on which nothing that is sent, or done by hand, has an effect: what judges an effect never passes.

A case may say that the target violates its clause, or that what it needs was not reached; that all is well it may say
only if it judges something else. Which do is listed here, with what it is that they judge.
"""

from __future__ import annotations

import contextlib
import math
from dataclasses import replace
from types import SimpleNamespace
from unittest.mock import patch

import pytest

from hilbench.bench.feed import Feed
from hilbench.bench.shared import Shared
from hilbench.benchfile.reader import open_bench
from hilbench.check import CheckOptions, Inconclusive, Verdict, run_suites
from hilbench.check.bench_provider import make_provider
from hilbench.journal import Journal
from hilbench.mcu.parts import Parts
from hilbench.mcu.under_test import BoardUnderTest
from hilbench.suites._dodge import AHEAD, Drive
from hilbench.suites._rover_motion import Ride
from hilbench.systems.rover.hands import ModelHands
from hilbench.systems.rover.motion_clauses import CLAUSES as RIDE_CLAUSES
from hilbench.systems.rover.provider import RoverProvider
from hilbench.systems.vehicle.car_simulator import CarSimulator
from hilbench.systems.vehicle.driven_car import DrivenCar
from hilbench.systems.vehicle.driving_stack import DrivingStack
from hilbench.systems.vehicle.on_board import BoardHands
from measure.mutants.altered_bench import AlteredBench
from measure.mutants.bench import run_mutant
from measure.mutants.mutant import Family, Mutant
from measure.mutants.rover import RoverMutant
from protocols import carla, p2os, pkt
from protocols.carla.clauses import HOST_CLAUSES
from protocols.pkt import ServerState, ServerTrigger, Transition
from protocols.pkt.clauses import BOARD_CLAUSES
from protocols.pkt.server import ServerMachine
from targets.robots.rover import RoverRobot
from targets.robots.rover.control import Tachometers
from targets.robots.vehicle_interface import VehicleInterface
from tests.each import each
from worlds import default_physics
from worlds.bullet import BulletWorld
from worlds.mujoco import MujocoWorld
from worlds.rigid import RigidWorld
from worlds.vehicles.pioneer_2dx import Pioneer2dxBody
from worlds.vehicles.rover_4wd import Rover4wdBody


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
            stack.enter_context(patch("hilbench.systems.rover.provider.rover_baud", return_value=baud))
        provider = RoverProvider(shared) if mutant is None else RoverProvider(shared, make_rover=mutant.make)
        return run_suites(CheckOptions(bench="rover-model", suites=("pkt-board",), select=select), provider)


SAYS_BY_ITSELF = {
    *("P30", "P39", "P39D", "P40", "P40D", "P41", "P41D", "P42", "P42D", "P43", "P43D", "P49", "P49D"),
    *("P72", "P75", "P78", "P84", "P85", "P86", "P87", "P89", "P90", "P91", "P92", "P93"),
}
"""Nothing is commanded."""
COUNTS_AND_ANSWERS = {
    *("P01", "P03", "P04", "P04D", "P64"),
    *("P05", "P06", "P07", "P08", "P09", "P10", "P11", "P12", "P12D", "P13", "P14", "P15", "P16", "P16D", "P17", "P18"),
    *("P20", "P21", "P22", "P23", "P23D", "P25", "P25D", "P31", "P32", "P33", "P34", "P35", "P48", "P48D"),
    *("P60", "P61", "P65", "P67", "P68", "P70", "P74", "P77"),
}
"""What is judged is whether a frame is taken for one, by the counters and by what is answered."""

ANSWERS_A_REQUEST = {"P01", "P77"}

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
    assert found[Verdict.PASS] & COUNTS_AND_ANSWERS == ANSWERS_A_REQUEST
    assert found[Verdict.PASS] <= ANSWERS_A_REQUEST | SAYS_BY_ITSELF
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


def test_a_report_with_an_acceleration_and_no_quaternion_is_no_wrong_order():
    imu = RoverRobot._imu

    def without(robot):
        return replace(imu(robot), quaternion=(0.0, 0.0, 0.0, 0.0))

    found = clauses_by_verdict(rover_model("P41 or P41D or P42 or P42D", patch.object(RoverRobot, "_imu", without)))
    assert found[Verdict.INCONCLUSIVE] == {"P42", "P42D"}


def test_wheels_that_never_turn_in_a_report_do_not_stop_in_it():
    still = patch.object(Tachometers, "read", lambda *_: None)
    found = clauses_by_verdict(rover_model("P47D", still))
    assert found[Verdict.INCONCLUSIVE] == {"P47D"}


def test_a_line_that_is_too_slow_for_what_is_judged_shows_nothing():
    found = clauses_by_verdict(rover_model("P25 or P25D or P48 or P48D", baud=9600))
    assert found[Verdict.INCONCLUSIVE] == {"P25", "P25D", "P48", "P48D"}


# --- the other suites

NOTHING_MAY_COME_OF_IT = {"S07", "S20", "S66"}
"""What is required is that a stimulus has no effect; so it is in M24 and VB42."""
HANDSHAKE = {
    *("S01", "S02", "S03", "S04", "S05", "S06", "S08", "S09", "S10", "S11", "S12", "S13", "S14", "S15", "S16"),
    *("S18", "S19", "S39", "S40", "S61", "S62"),
}
"""How a session begins, goes on by itself and ends; a robot that obeys nothing answers all the same."""
SEES_BY_ITSELF = {"S54", "S80"}
"""A robot that stands at a wall hears it, and each knows its battery."""


def passed(report):
    return clauses_by_verdict(report)[Verdict.PASS]


def disobedient(family):
    """A Pioneer that is in session and obeys no command."""
    return Mutant(id="idle", family=family, what="obeys no command", mute=frozenset({"CommandReceived"}))


@pytest.mark.exhaustive("a whole suite, most of whose cases wait for what does not come")
@pytest.mark.needs_physics
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


# --- the simulator's side of a vehicle-interface board

STATUSES = {"VS13", "VS14", "VS15", "VS16", "VS17H", "VS20", "VS21", "VS21H"}
"""What is said of the car, whatever the board says; VS21 and VS21H are about a board that says nothing."""
BY_HAND = {"VS11", "VS11H", "VS14", "VS15", "VS16", "VS17", "VS17H", "VS18", "VS19", "VS25", "VS28", "VS28H"}
"""What is told by hand, beside the line: how the car moves, when to say it, noise, reads that fail."""


def nothing(*_args, **_options):
    """What has no effect."""


def car_host(select, *patches):
    options = CheckOptions(bench="vehicle-model", suites=("vehicle-host",), select=select)
    with contextlib.ExitStack() as stack:
        for one in patches:
            stack.enter_context(one)
        return clauses_by_verdict(run_suites(options, make_provider(options)))


def deaf_car_host():
    receive = carla.Connection.receive
    return patch.object(carla.Connection, "receive", lambda self, _data, now_ns: receive(self, b"", now_ns))


def idle_hands():
    return patch.multiple(
        CarSimulator, sense=nothing, report=nothing, report_by_hand=nothing, read_error=nothing, hear=nothing
    )


def test_a_simulator_s_side_that_hears_nothing_has_not_refused_it():
    found = car_host("VS04 or VS07 or VS08 or VS10H or VS23H", deaf_car_host())
    assert found[Verdict.INCONCLUSIVE] == {"VS04", "VS07", "VS08", "VS10H"}
    assert found[Verdict.FAIL] == {"VS23H"}


def test_a_simulator_s_side_that_nobody_does_anything_to():
    found = car_host("VS11H or VS16 or VS17H or VS28 or VS28H or (VS25 and [hardened])", idle_hands())
    assert found[Verdict.INCONCLUSIVE] == {"VS11H", "VS25", "VS28", "VS28H"}
    assert found[Verdict.FAIL] == {"VS16", "VS17H"}


@pytest.mark.exhaustive("a whole suite; the gate has what was not reached in it")
def test_a_simulator_s_side_without_effect():
    found = car_host("", deaf_car_host())
    assert found[Verdict.PASS] == STATUSES
    assert found[Verdict.ERROR] == set()
    found = car_host("", idle_hands())
    assert found[Verdict.PASS] == {clause.id for clause in HOST_CLAUSES} - BY_HAND
    assert found[Verdict.ERROR] == set()


# --- a car that is driven through its board


def driven(select, *patches):
    options = CheckOptions(bench="vehicle", suites=("vehicle-drive",), select=select)
    with contextlib.ExitStack() as stack:
        for one in patches:
            stack.enter_context(one)
        return clauses_by_verdict(run_suites(options, make_provider(options)))


@pytest.mark.exhaustive("a whole suite in the emulator")
@pytest.mark.needs_physics
def test_a_car_that_obeys_nothing():
    found = driven("", patch.object(DrivenCar, "_obey", nothing))
    assert found[Verdict.PASS] == set()
    assert found[Verdict.ERROR] == set()


@pytest.mark.exhaustive("three quarters of a minute of bench time in the emulator")
@pytest.mark.needs_physics
def test_a_car_whose_driver_touches_nothing_and_whose_partners_are_never_lost():
    stop = Feed.stop
    found = driven(
        "not a_lap",  # which does not need any of it
        patch.multiple(BoardHands, set_joystick=nothing, press=nothing),
        patch.object(DrivingStack, "stop_driving", nothing),
        patch.object(Feed, "stop", lambda feed: None if feed._name == "car" else stop(feed)),
    )
    # By request of the driving stack, the stick at rest by itself.
    assert found[Verdict.PASS] == {"VD04", "VD05"}
    assert found[Verdict.ERROR] == set()


@pytest.mark.exhaustive("three quarters of a minute of bench time in the emulator")
@pytest.mark.needs_physics
def test_a_board_that_is_asked_for_no_mode():
    found = driven("not a_lap", patch.object(DrivingStack, "request_mode", nothing))
    # By a press; and an emergency, for which nobody asks.
    assert found[Verdict.PASS] == {"VD04", "VD05", "VD10"}
    assert found[Verdict.ERROR] == set()


# --- the pins of a Blue Pill

PINS = AlteredBench(bench="bluepill", board="bluepill", suite="bluepill-pins", clause_ids=())
WIRES = {"G01", "G03", "G04", "G05", "G06", "G07", "G11", "G12", "G14", "G15", "G16", "G18", "G23", "G24", "G25"}
"""What stands on wires, and what an adapter reads there and tells its robot: no wheel has to turn for it. G18: the
robot is sent the same as always, and has to stand."""
BY_ITSELF = {"G01", "G02", "G03", "G04", "G09", "G10", "G14", "G17", "G23", "G24", "G25"}
"""What a program does that nobody touches, on a flat floor with nothing near."""
WITHOUT_PROGRAM = {"G06", "G07", "G10", "G12", "G15", "G16", "G18", "G19", "G20", "G21", "G22", "G24"}
"""What needs a program that keeps out of the way, or none; G24: words are published, whatever they are."""


class OutOfReach:
    """A pin that somebody sees and cannot drive."""

    def __init__(self, pin):
        self._pin = pin

    def __getattr__(self, name):
        return getattr(self._pin, name)

    def drive(self, level):
        """Do nothing."""


@contextlib.contextmanager
def untouched():
    """A bench on which the checker drives no pin, moves no control, shows no part anything and moves no robot."""
    pin, place = BoardUnderTest.pin, RigidWorld.place

    def at_the_start(world, *_where):
        start = world.scene.start
        place(world, start.x_m, start.y_m, start.yaw_rad, start.z_m)

    with (
        patch.object(BoardUnderTest, "pin", lambda board, name: OutOfReach(pin(board, name))),
        patch.object(RigidWorld, "place", at_the_start),
        patch.multiple(Parts, set=nothing, show=nothing),
    ):
        yield


def without_motors():
    return patch.object(RigidWorld, "command", nothing)


@pytest.mark.needs_physics
def test_wires_that_nobody_drives_and_a_robot_that_never_drove():
    with untouched():
        found = clauses_by_verdict(PINS.check("majority and [2-False-PA1]"))
    assert found[Verdict.INCONCLUSIVE] == {"G16"}
    with without_motors():
        found = clauses_by_verdict(PINS.check("robot_is_let_go"))
    assert found[Verdict.INCONCLUSIVE] == {"G15"}


@pytest.mark.exhaustive("a whole suite in the emulator; the gate has what was not reached in it")
@pytest.mark.needs_physics
def test_pins_without_effect():
    with without_motors():
        found = clauses_by_verdict(PINS.check())
    assert found[Verdict.PASS] == WIRES
    assert found[Verdict.INCONCLUSIVE] == {"G15"}
    assert found[Verdict.ERROR] == set()
    with untouched():
        found = clauses_by_verdict(PINS.check())
    assert found[Verdict.PASS] == BY_ITSELF
    assert found[Verdict.INCONCLUSIVE] == {"G16"}
    assert found[Verdict.ERROR] == set()


@pytest.mark.exhaustive("a whole suite in the emulator")
@pytest.mark.needs_physics
def test_pins_of_a_program_that_does_nothing():
    names = ("words", "sweep", "halt", "encoders", "sensors", "reactive", "inputs")
    found = clauses_by_verdict(PINS.check(images=dict.fromkeys(names, "robot-quiet")))
    assert found[Verdict.PASS] == WITHOUT_PROGRAM
    assert found[Verdict.ERROR] == set()


# --- a program that finds its way

DODGE = AlteredBench(bench="bluepill", board="bluepill", suite="bluepill-dodge", clause_ids=())


def empty_scenes():
    kind = BulletWorld if default_physics() == "bullet" else MujocoWorld
    init = kind.__init__
    return patch.object(
        kind,
        "__init__",
        lambda world, scene, *others, **options: init(world, replace(scene, boxes=()), *others, **options),
    )


@pytest.mark.needs_physics
@pytest.mark.parametrize(
    "select",
    [
        "wall",
        *(
            pytest.param(select, marks=pytest.mark.exhaustive("other drives past nothing; the gate has one"))
            for select in ("D05", "each_disc and [4]", "D07")
        ),
    ],
)
def test_where_nothing_stands_nothing_was_dodged(select):
    shorter = patch.multiple("hilbench.suites.bluepill_dodge", REPLAY_S=3.0, AFTER_RESET_S=4.0)
    with empty_scenes(), shorter:
        report = DODGE.check(select)
    assert {case.verdict for case in report.cases} == {Verdict.INCONCLUSIVE}


@pytest.mark.needs_physics
@pytest.mark.exhaustive("a robot drives for seven seconds of bench time; the gate has other effects that do not come")
def test_a_board_that_nobody_reset():
    with patch.object(BoardUnderTest, "reset", nothing):
        assert clauses_by_verdict(DODGE.check("D07"))[Verdict.INCONCLUSIVE] == {"D07"}


@pytest.mark.needs_physics
def test_a_program_that_hears_of_no_obstacle_drives_at_it():
    """What D06 judges does come to pass, before a disc whose readings are withheld."""
    with patch.object(Pioneer2dxBody, "sonar_range_m", nothing):
        assert clauses_by_verdict(DODGE.check("each_disc and [4]"))[Verdict.FAIL] == {"D06"}


@each("required", [Drive.require_sight, Drive.require_sight_over_p2os])
def test_a_drive_past_nothing_has_not_dodged_it(required):
    drive = object.__new__(Drive)
    drive._bench = SimpleNamespace(bench=SimpleNamespace(now_ns=0))
    drive._high = {sensor: SimpleNamespace(edges=[(0, False)]) for sensor in AHEAD}
    drive.least_ahead_m = math.inf
    with pytest.raises(Inconclusive, match="in all this time"):
        required(drive)


@pytest.mark.exhaustive("a whole suite of long drives in the emulator")
@pytest.mark.needs_physics
@pytest.mark.parametrize(
    ("wrong", "select", "allowed"),
    [
        (empty_scenes, "", set()),
        (without_motors, "not G13", {"D03", "D06"}),  # by the wires, and by what the robot is told
    ],
)
def test_a_dodger_without_effect(wrong, select, allowed):
    with wrong():
        found = clauses_by_verdict(DODGE.check(select))
    assert found[Verdict.PASS] == allowed
    assert found[Verdict.ERROR] == set()


# --- a rover that drives

RIDE = AlteredBench(bench="rover", board="nucleo-f767zi", suite="rover-motion", clause_ids=())
AT_REST = {"R14", "R16", "R18", "R20", "R21"}
"""What a rover says that was not told to drive: of its attitude, and of where it is."""
NEEDS_HANDS = {"R09", "R16", "R20", "R22", "R24", "R25"}
"""A wheel that is held, a ramp or a wall before it, the sky, the sensor's bus."""


@pytest.mark.needs_physics
@pytest.mark.exhaustive("a rover's firmware runs for three seconds; the gate has a report of such wheels")
def test_counts_of_wheels_that_never_turn_are_not_told_apart():
    with patch.object(Rover4wdBody, "drive", nothing):
        assert clauses_by_verdict(RIDE.check("R09"))[Verdict.INCONCLUSIVE] == {"R09"}


@pytest.mark.exhaustive("a whole suite in the emulator; the gate has what was not reached in it")
@pytest.mark.needs_physics
def test_a_ride_without_effect():
    with patch.object(Rover4wdBody, "drive", nothing):
        found = clauses_by_verdict(RIDE.check())
    assert found[Verdict.PASS] == AT_REST
    assert found[Verdict.INCONCLUSIVE] == {"R09"}
    assert found[Verdict.ERROR] == set()
    no_bus = SimpleNamespace(stick=nothing, unstick=nothing, deaf=set())
    with patch.multiple(Ride, hold=nothing, open_sky=nothing, place=nothing, bus=no_bus):
        found = clauses_by_verdict(RIDE.check())
    assert found[Verdict.PASS] == {clause.id for clause in RIDE_CLAUSES} - NEEDS_HANDS
    assert found[Verdict.INCONCLUSIVE] == {"R09"}
    assert found[Verdict.ERROR] == set()
