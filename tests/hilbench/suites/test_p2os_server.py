"""The suite p2os-server: the virtual robot passes it, in the time it declares, and robots that are wrong inside do not.

Servers that are wrong on the wire, in their tables and in their FLASH are the business of the mutants; here are those
whose fault is in what they do with a command.
"""

from __future__ import annotations

import contextlib
import itertools
import random
from dataclasses import replace
from unittest.mock import patch

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hilbench.bench import Bench
from hilbench.bench.shared import Shared
from hilbench.benchfile.reader import open_bench
from hilbench.check import CheckOptions, Untimely, Verdict, Violation, list_cases, run_suites
from hilbench.clock import NS_PER_MS, NS_PER_S, Scheduler
from hilbench.journal import Journal
from hilbench.links import Line, MemoryLink
from hilbench.suites import _session
from hilbench.suites._requirements import all_caught_up
from hilbench.suites._session import Seen, Slope, find_parameters, poses, turned_deg
from hilbench.systems.pioneer.peer import Peer
from hilbench.systems.pioneer.provider import VirtualProvider
from measure.mutants.bench import MutantProvider
from measure.mutants.each_its_own import Fault, judge
from measure.mutants.late import AtPort, late_benches
from protocols.p2os import ROBOTS, CommandNumber, EncoderPacket, Identification, Sip
from protocols.p2os.clauses import CLAUSES
from targets.robots.pioneer import commands, reports, robot
from targets.robots.pioneer.auxport import AuxPort
from targets.robots.pioneer.bumpers import BumpGuard
from targets.robots.pioneer.controller import Controller
from targets.robots.pioneer.hostbaud import HostBaud
from targets.robots.pioneer.motion import Motion
from targets.robots.pioneer.requests import Extra
from targets.robots.pioneer.sonar import SonarArrays
from targets.robots.pioneer.speed_limits import SessionLimits
from tests.each import each

SETTLE_S = 0.3
BUDGET_S = 326.0


NEED_A_SCENE = {"S54", "S56"}
LONG = {"S52", "S53", "S31", "S18", "S04", "S60", "S59"}
"""What takes more than eight seconds of bench time: half of all of it."""


def shared(bench):
    return Shared(bench_file=open_bench(bench), timeout_scale=1.0, journal=Journal())


def provider(bench="pioneer"):
    return VirtualProvider(shared(bench))


def options(select=""):
    return CheckOptions(bench="pioneer", suites=("p2os-server",), select=select)


# --- the right robot


@pytest.fixture(scope="module")
def planned():
    return list_cases(options(), provider())


@pytest.fixture(scope="module")
def on_the_plane():
    return run_suites(options(f"not ({' or '.join(sorted(LONG))})"), provider("pioneer-plane"))


@pytest.fixture(scope="module")
def in_scenes():
    return run_suites(options(" or ".join(NEED_A_SCENE)), provider())


def test_each_clause_is_cited_by_exactly_one_function(planned):
    cited = {(clause.id, case.id.partition("[")[0]) for case in planned for clause in case.clauses}
    assert sorted(clause_id for clause_id, _ in cited) == [c.id for c in CLAUSES if c.suite == "p2os-server"]


@pytest.mark.slow("most of what is asked of a robot, once; two minutes of bench time")
def test_on_the_plane_it_passes_what_needs_no_scene(on_the_plane):
    left_out = {case.clause_ids[0] for case in on_the_plane.cases if case.verdict is Verdict.NOT_APPLICABLE}
    assert left_out == NEED_A_SCENE
    passed = {clause.id for clause in on_the_plane.clauses if clause.verdict is Verdict.PASS}
    assert passed == {clause.id for clause in on_the_plane.clauses} - NEED_A_SCENE


@pytest.mark.needs_physics
def test_in_scenes_it_passes_the_rest(in_scenes):
    assert {clause.id: clause.verdict for clause in in_scenes.clauses} == dict.fromkeys(NEED_A_SCENE, Verdict.PASS)


def took_otherwise(planned, cases):
    """What took another time than it declares: both times in seconds, by case."""
    declared = {case.id: case.bench_time_s for case in planned}
    took = {case.id: case.bench_time_s for case in cases if case.verdict is not Verdict.NOT_APPLICABLE}
    return {i: (s, declared[i]) for i, s in took.items() if abs(s - declared[i]) > 0.3 * declared[i] + 0.5}


@pytest.mark.needs_physics
def test_each_case_takes_the_time_it_declares(planned, on_the_plane, in_scenes):
    assert took_otherwise(planned, [*on_the_plane.cases, *in_scenes.cases]) == {}
    declared = {case.id: case.bench_time_s for case in planned}
    assert sum(declared.values()) + SETTLE_S * len(declared) <= BUDGET_S


@pytest.mark.needs_physics
@pytest.mark.exhaustive("all cases, on PyBullet; the gate has most on the plane, and in scenes what needs one")
def test_the_virtual_robot_passes_with_full_physics(planned):
    report = run_suites(options(), provider())
    assert took_otherwise(planned, report.cases) == {}
    assert {case.id: case.cause for case in report.cases if case.verdict is not Verdict.PASS} == {}
    assert report.exit_code == 0


# --- robots that are wrong inside


def instead(owner, name, make):
    """Put what ``make`` makes of the original in its place."""
    return patch.object(owner, name, make(getattr(owner, name)))


def handler(name, act):
    """Obey a command by ``act(controller, value)``."""
    number = CommandNumber[name]

    def obey(controller, command, now_ns):
        act(controller, command.value)

    return patch.dict(commands.HANDLERS, {number: obey})


def sip(change):
    """Change every SIP."""
    return instead(robot, "make_sip", lambda make: lambda *a: change(make(*a)))


def wrong_robots():
    def limits_deaf_to(sign):
        return instead(
            SessionLimits,
            "set_translation_acceleration",
            lambda do: lambda self, rate: True if rate * sign > 0 else do(self, rate),
        )

    def moves_unpowered(do):
        def enter(self, order):
            self.motors_on = True
            return do(self, order)

        return enter

    def falls_silent(do):
        def send_cycle(self, now_ns):
            if now_ns < 3.2 * NS_PER_S:
                do(self, now_ns)
            else:
                self._sips += 1

        return send_cycle

    def drive(name, make):
        return instead(Motion, name, make)

    yield "S20", "moves with motors off", drive("_enter", moves_unpowered)
    yield (
        "S19",
        "motors on at OPEN",
        instead(Controller, "start_session", lambda do: lambda self, now_ns: (do(self, now_ns), self.enable(True))),
    )
    yield "S19", "sonar off at OPEN", instead(Controller, "start_session", lambda _: lambda self, now_ns: None)
    yield "S21", "deaf to ENABLE", handler("ENABLE", lambda c, v: None)
    yield "S22", "deaf to SETA for accelerating", limits_deaf_to(1)
    yield "S34", "deaf to SETA for braking", limits_deaf_to(-1)
    yield "S32", "deaf to SETA for braking", limits_deaf_to(-1)
    yield "S22", "too fast", drive("velocity", lambda do: lambda self, v: do(self, v * 1.035))
    yield "S22", "one wheel too fast", sip(lambda s: replace(s, right_raw=s.right_raw + 7 * bool(s.right_raw)))
    yield "S22", "veers", sip(lambda s: replace(s, th_raw=s.x_raw // 10))
    yield "S24", "turns the wrong way", drive("rotate", lambda do: lambda self, v: do(self, -v))
    yield "S24", "wheels exchanged", sip(lambda s: replace(s, left_raw=s.right_raw, right_raw=s.left_raw))
    yield "S24", "angle mirrored", sip(lambda s: replace(s, th_raw=-s.th_raw))
    yield "S25", "RVEL ends VEL", drive("rotate", lambda do: lambda self, v: (self.velocity(0), do(self, v))[1])
    yield "S26", "VEL2 exchanged", drive("wheels", lambda do: lambda self, left, right: do(self, right, left))
    yield "S28", "HEAD 3 % off", drive("head", lambda do: lambda self, deg, zero: do(self, deg * 1.03, zero))
    yield "S28", "HEAD relative", drive("head", lambda _: lambda self, deg, zero: self.turn_by(deg))
    yield "S29", "DCHEAD from here", drive("turn_setpoint_by", lambda _: lambda self, deg: self.turn_by(deg))
    yield "S30", "MOVE 2 % off", drive("move", lambda do: lambda self, mm: do(self, mm * 1.02))
    yield "S31", "deaf to SETV", instead(SessionLimits, "set_translation_speed", lambda _: lambda self, v: True)
    yield "S33", "deaf to SETO", handler("SETO", lambda c, v: None)
    yield "S34", "STOP switches off", handler("STOP", lambda c, v: c.enable(False))
    yield "S34", "STOP abrupt", handler("STOP", lambda c, v: c.motion.emergency_stop())
    yield "S35", "E_STOP soft", handler("E_STOP", lambda c, v: c.motion.stop())
    yield "S18", "falls silent", instead(robot.PioneerRobot, "_send_cycle", falls_silent)
    yield "S36", "falls silent", instead(robot.PioneerRobot, "_send_cycle", falls_silent)
    yield "S37", "never revived", drive("release", lambda _: lambda self: None)
    yield "S37", "forgets its speed", drive("hold", lambda _: lambda self: self.stop())
    yield "S41", "rolls on after CLOSE", instead(Controller, "end_session", lambda _: lambda self, now_ns: None)
    yield "S55", "rolls on after a hang-up", instead(Controller, "end_session", lambda _: lambda self, now_ns: None)
    yield "S45", "deaf to SONAR", handler("SONAR", lambda c, v: None)
    yield (
        "S45",
        "SONAR 0 for ever",
        instead(
            SonarArrays,
            "switch",
            lambda do: lambda self, on, now_ns: do(self, on, now_ns) if not self._firings else None,
        ),
    )
    yield (
        "S46",
        "POLLING from 0",
        instead(SonarArrays, "poll", lambda do: lambda self, discs: do(self, bytes(disc + 1 for disc in discs))),
    )
    yield "S47", "DIGOUT exchanged", handler("DIGOUT", lambda c, v: c.io.write((v & 0xFF) << 8 | (v >> 8 & 0xFF)))
    yield "S48", "STEP does something", handler("STEP", lambda c, v: c.enable(True))
    yield "S23", "x of 16 bits", patch.object(reports, "POSITION_MASK", 0xFFFF)
    yield "S52", "x of 12 bits", patch.object(reports, "POSITION_MASK", 0x0FFF)
    yield "S52", "x of 14 bits", patch.object(reports, "POSITION_MASK", 0x3FFF)
    yield (
        "S53",
        "Th of a whole turn",
        patch.object(reports, "_heading_raw", lambda c, deg: round(deg * 4096 / 360) % 4096),
    )
    yield (
        "S53",
        "Th wraps at 4000",
        patch.object(reports, "_heading_raw", lambda c, deg: (round(deg * 4096 / 360) + 2000) % 4000 - 2000),
    )
    yield (
        "S54",
        "discs from 1",
        sip(lambda s: replace(s, sonars=tuple(replace(r, number=r.number + 1) for r in s.sonars))),
    )
    yield (
        "S54",
        "range 1 % off",
        sip(lambda s: replace(s, sonars=tuple(replace(r, range_raw=round(r.range_raw * 1.01)) for r in s.sonars))),
    )
    yield "S54", "17 readings", sip(lambda s: replace(s, sonars=(s.sonars * 17)[:17]))
    yield "S56", "bits but no stop", instead(BumpGuard, "update", lambda do: lambda *a, **k: (do(*a, **k), False)[1])
    yield "S56", "stop but no bits", sip(lambda s: replace(s, stall_rear=s.stall_rear & ~1))
    yield "S56", "stuck bit", sip(lambda s: replace(s, stall_rear=s.stall_rear | 1))
    yield "S57", "stays at the new rate", instead(HostBaud, "next_deadline_ns", lambda _: lambda self: None)
    yield (
        "S58",
        "again and again",
        instead(AuxPort, "take_due", lambda _: lambda self: b""),
    )


def judged(wrong):
    """What comes of robots that are wrong inside: rows as of `wrong_robots`."""

    def opening(faulty):
        @contextlib.contextmanager
        def open_case(case):
            with faulty, right.open_case(case) as bench:
                yield bench

        return open_case

    right = MutantProvider(shared("pioneer"), None, motion=False)
    faults = [Fault(name=what, clause_id=clause, open_case=opening(faulty)) for clause, what, faulty in wrong]
    return judge(options(), right, faults)


@pytest.mark.needs_physics
def test_robots_that_are_wrong_inside_violate_their_clauses():
    wrong = [row for row in wrong_robots() if row[1] in ("wheels exchanged", "deaf to SONAR", "STOP switches off")]
    verdicts = judged(wrong)
    assert verdicts.not_found == {}
    assert verdicts.found_by == {"S24", "S34", "S45"}


@pytest.mark.exhaustive("fifty robots; the gate has three of them, and in test_mutants a wrong robot of each clause")
@pytest.mark.needs_physics
def test_each_wrong_robot_violates_its_clause():
    verdicts = judged(wrong_robots())
    assert verdicts.not_found == {}
    assert verdicts.found_by == {clause for clause, _, _ in wrong_robots()}


# --- robots that can do less, and are right


def of_the_line(**less):
    """Take the robot for one of which the clients know less."""
    return patch.object(_session, "ROBOTS", {"p2dx": replace(ROBOTS["p2dx"], **less)})


@each("clause_id", ["S30", "S31"])
def test_a_robot_without_move_is_not_asked_for_it(clause_id):
    deaf = handler("MOVE", lambda c, v: None)
    with deaf, of_the_line(has_move=False):
        report = run_suites(options(clause_id), provider("pioneer-plane"))
    assert [clause.verdict for clause in report.clauses] == [Verdict.NOT_APPLICABLE]


@pytest.mark.exhaustive("a robot drives 50 m; the gate has what else robots are that can do less")
def test_a_slow_robot_is_given_the_time_it_needs():
    slow = instead(Motion, "velocity", lambda do: lambda self, mm_s: do(self, min(mm_s, 400)))
    with slow, of_the_line(max_speed_mm_s=400):
        report = run_suites(options("S52"), provider("pioneer-plane"))
    assert [clause.verdict for clause in report.clauses] == [Verdict.PASS], [clause.cause for clause in report.clauses]


# --- robots that are otherwise, and right; and what is not judged


@contextlib.contextmanager
def rests_off(units):
    """Shift the heading, from which DHEAD turns, against the setpoint."""
    with (
        sip(lambda s: replace(s, th_raw=s.th_raw + units)),
        instead(Motion, "turn_by", lambda do: lambda self, deg: do(self, deg + units * 360 / 4096)),
    ):
        yield


def gentle():
    """Let it speed up and slow down by 60 mm/s2 and 30 deg/s2, until it is told otherwise."""
    rates = {
        "translation_acceleration_mm_s2": 60.0,
        "translation_deceleration_mm_s2": 60.0,
        "rotation_acceleration_deg_s2": 30.0,
        "rotation_deceleration_deg_s2": 30.0,
    }
    return instead(
        robot, "Controller", lambda make: lambda settings, *a, **k: make(replace(settings, **rates), *a, **k)
    )


def other_robots():
    """Yield clause, what is otherwise about the robot, and what makes it so."""
    ticks = itertools.count()
    yield (
        "S90",
        "x flickers below 0",
        sip(lambda s: replace(s, x_raw=(s.x_raw - next(ticks) % 2) & 0x7FFF)),
    )
    yield (
        "S91",
        "rests 5 units off its goal",
        rests_off(5),
    )
    yield "S91", "setpoint of a whole turn", sip(lambda s: replace(s, control_raw=s.control_raw % 4096))
    for clause in ("S17", "S23", "S25", "S26", "S27", "S49", "S51"):
        yield clause, "gentle ramps of its own", gentle()
    yield "S88", "a noisy converter", sip(lambda s: replace(s, analog=s.analog + s.timer % 2))


def verdict_of(clause_id, robot):
    with robot:
        (clause,) = run_suites(options(clause_id), provider("pioneer-plane")).clauses
    return clause.verdict, clause.cause


@each("clause_id, what, robot", other_robots())
def test_a_robot_that_is_otherwise_is_right(clause_id, what, robot):
    assert verdict_of(clause_id, robot) == (Verdict.PASS, ""), what


def test_analog_values_that_are_always_off_are_found():
    verdict, cause = verdict_of("S88", sip(lambda s: replace(s, analog=s.analog - 1)))
    assert (verdict, "off by [1, 1, 1, 1, 1] of 256" in cause) == (Verdict.FAIL, True)


def test_encoders_that_stand_still_are_found():
    zeros = patch.dict(reports._MAKERS, {Extra.ENCODER: lambda c, now_ns: EncoderPacket(left_ticks=0, right_ticks=0)})
    assert verdict_of("S87", zeros) == (Verdict.FAIL, "the ticks go by 0 and 0 on a way ahead")


def test_encoders_of_a_robot_that_does_not_drive_are_not_judged():
    verdict, cause = verdict_of("S87", handler("VEL", lambda c, v: None))
    assert (verdict, "nothing to hold its encoders against" in cause) == (Verdict.INCONCLUSIVE, True)


def test_bytes_that_are_read_late_show_no_new_rate():
    with handler("HOSTBAUD", lambda c, v: None), late_benches(0.4, 4):
        (clause,) = run_suites(options("S57"), AtPort(provider("pioneer-plane"))).clauses
    assert clause.verdict is Verdict.INCONCLUSIVE


@pytest.mark.slow("five turns of a robot, in small steps")
def test_a_step_of_the_heading_is_as_long_as_the_time_between_two_sips():
    """A process that serves a robot may be late itself; then a step is longer, and on a late bench nobody knows."""
    jumps = itertools.cycle([60] + [0] * 39)
    jumping = sip(lambda one: replace(one, th_raw=min(2047, one.th_raw + next(jumps))))
    with jumping, late_benches(0.1, 4):
        (clause,) = run_suites(options("S53"), AtPort(provider("pioneer-plane"))).clauses
    assert clause.verdict is Verdict.INCONCLUSIVE


# --- what the cases measure with

CYCLE_NS = 100 * NS_PER_MS


def on_grid(count, late_ms=()):
    """SIPs on their grid, but for some that are late: {number: ms}."""
    return [k * CYCLE_NS + dict(late_ms).get(k, 0) * NS_PER_MS for k in range(count)]


@given(st.dictionaries(st.integers(1, 38), st.integers(0, 90), max_size=4))
def test_late_sips_that_return_to_their_grid_are_made_up_for(late_ms):
    run = max((len(run) for run in consecutive(sorted(late_ms))), default=0)
    if run <= 4:
        assert all_caught_up(on_grid(40, late_ms.items()), CYCLE_NS)


def consecutive(numbers):
    runs = []
    for number in numbers:
        if runs and runs[-1][-1] == number - 1:
            runs[-1].append(number)
        else:
            runs.append([number])
    return runs


@given(st.integers(1, 38), st.integers(11, 1000))
def test_a_sip_left_out_or_a_shift_is_never_made_up_for(at, shift_ms):
    starts = [ns + shift_ms * NS_PER_MS * (k >= at) for k, ns in enumerate(on_grid(40))]
    assert not all_caught_up(starts, CYCLE_NS)


def test_a_drifting_clock_is_never_made_up_for():
    assert not all_caught_up([k * CYCLE_NS * 112 // 100 for k in range(40)], CYCLE_NS)


def seen_at(start_ns, speed_mm_s, **fields):
    packet = Sip(left_raw=round(speed_mm_s), right_raw=round(speed_mm_s), **fields)
    return Seen(start_ns=start_ns, end_ns=start_ns, sip=packet, raw=b"", left_mm_s=speed_mm_s, right_mm_s=speed_mm_s)


def ramp(rate_mm_s2, end_mm_s, begin_s=0.23):
    times_s = [k * 0.1 for k in range(60)]
    return [seen_at(round(t * NS_PER_S), min(max(0.0, (t - begin_s) * rate_mm_s2), end_mm_s)) for t in times_s]


@given(st.floats(60, 550), st.floats(0.05, 0.35))
def test_the_slope_of_a_ramp_is_found(rate, begin_s):
    slope = Slope(ramp(rate, 200.0, begin_s), 0, 200, 0.0)
    assert slope.mm_s2 == pytest.approx(rate, rel=0.01)
    assert slope.uncertainty_mm_s2 == 0


def test_the_slope_of_a_jump_is_steep():
    assert Slope(ramp(1e6, 200.0), 0, 200, 0.0).mm_s2 == pytest.approx(2000)


def test_the_slope_carries_the_uncertainty_of_its_times():
    slope = Slope(ramp(200, 200.0), 0, 200, 0.01)
    assert slope.uncertainty_mm_s2 == pytest.approx(200 * 0.02 / 0.7)


def test_a_speed_that_is_never_reached_has_no_slope():
    with pytest.raises(Violation, match="does not go from 0 to 300"):
        Slope(ramp(200, 200.0), 0, 300, 0.0)


def test_headings_and_positions_are_followed_over_their_wraps():
    rng = random.Random(1)
    th = [k * 150 + rng.randrange(20) for k in range(60)]
    seen = [seen_at(k, 0.0, th_raw=(t + 2048) % 4096 - 2048, x_raw=-5 * k & 0x7FFF) for k, t in enumerate(th)]
    assert turned_deg(seen, ROBOTS["p2dx"]) == pytest.approx((th[-1] - th[0]) * 360 / 4096)
    assert poses(seen, ROBOTS["p2dx"])[-1].x_mm == pytest.approx(-5 * 59 * 0.84)


class Notes:
    def __init__(self):
        self.bench, self.texts = self, []

    def record(self, kind, source, *, text):
        self.texts.append(text)


def test_an_unknown_robot_is_taken_for_a_p2dx_and_the_journal_says_so():
    peer = Notes()
    assert find_parameters(peer, Identification(name="x", subclass="P3AT")).subclass == "p3at"
    assert peer.texts == []
    assert find_parameters(peer, Identification(name="x", subclass="mine")).subclass == "p2dx"
    assert peer.texts == ["subclass 'mine' unknown, taken for p2dx"]


def test_an_answer_that_is_refused_says_what_is_wrong_with_it():
    bench = Bench(Scheduler(), Journal())
    link = MemoryLink(bench.scheduler, Line(), name="line")
    answers = [bytes.fromhex("FAFB03010100")]
    link.b.on_receive = lambda _data, _at_ns: link.b.write(answers.pop() if answers else b"")
    with pytest.raises(Untimely) as raised:
        Peer(bench, link.a).sync(1)
    assert raised.value.cause == (
        "no echo of SYNC1 within 0.2 s; 1 time what came was refused, first for BAD_CHECKSUM: "
        "the bytes of its checksum are swapped"
    )
    assert raised.value.evidence[-1].endswith("FA FB 03 01 01 00: the bytes of its checksum are swapped")
