"""The suite pkt-host: our ground station passes, the line-splitting one loses what it should, faulty ones are found."""

from __future__ import annotations

import math
import struct
from dataclasses import replace
from types import MappingProxyType

import pytest

from hilbench.bench.client_under_test import EXEC_CAPABILITIES
from hilbench.bench.locked_providers import ExecProvider
from hilbench.bench.shared import Shared
from hilbench.benchfile.reader import open_bench
from hilbench.check import CheckOptions, Verdict, list_cases, run_suites
from hilbench.check.bench_provider import make_provider
from hilbench.cli import main
from hilbench.exit_codes import ExitCode
from hilbench.journal import Journal
from hilbench.systems.rover.ground_station import GroundStation
from hilbench.systems.rover.provider import RoverProvider, foreign_host
from hilbench.terminal.options import TargetChoice
from measure.mutants.each_its_own import Fault, judge
from measure.mutants.in_bench_time import ForeignClientInBenchTime, saying
from measure.mutants.late import BLAMED, AtPort, late_benches
from protocols.pkt import (
    CLIENT_TABLE,
    PROFILES,
    ClientState,
    ClientTrigger,
    Framing,
    FramingOptions,
    GpsReport,
    MotorThrottles,
    PacketTotals,
    Resync,
    SpeedSetpoints,
    UnknownReport,
)
from protocols.pkt.clauses import HOST_CLAUSES
from protocols.pkt.framing import encode_frame as pkt_frame
from tests.each import each

OPTIONS = CheckOptions(bench="rover-model", suites=("pkt-host",))


def shared_bench():
    return Shared(bench_file=open_bench("rover-model"), timeout_scale=1.0, journal=Journal())


def test_each_clause_is_cited_by_one_function_in_each_of_its_profiles():
    planned = list_cases(OPTIONS, make_provider(OPTIONS))
    cited = [(case.clauses[0].id, case.setup.program) for case in planned]
    assert sorted(cited) == sorted((clause.id, profile) for clause in HOST_CLAUSES for profile in clause.profiles)


def test_our_hosts_pass():
    report = run_suites(OPTIONS, make_provider(OPTIONS))
    assert {case.id: case.cause for case in report.cases if case.verdict is not Verdict.PASS} == {}


# --- hosts that are wrong


def with_options(**changes):
    """A host of the case's profile, but for these options."""

    def make(bench, port, profile):
        return GroundStation(bench, port, profile, options=replace(profile.client, **changes))

    return make


def without(state, trigger):
    """A host whose table lacks an edge."""

    def make(bench, port, profile):
        table = {edge: to for edge, to in CLIENT_TABLE.items() if edge != (state, trigger)}
        return GroundStation(bench, port, profile, table=MappingProxyType(table))

    return make


class NeverUnwraps(GroundStation):
    @property
    def totals(self):
        general = self.general
        return None if general is None else PacketTotals(accepted=general.accepted, rejected=general.rejected)


class SwapsMotors(GroundStation):
    def send(self, command):
        if isinstance(command, MotorThrottles):
            command = replace(command, a=command.b, b=command.a)
        super().send(command)


class StopsAtAStranger(GroundStation):
    def _keep(self, report):
        self.deaf = getattr(self, "deaf", False) or isinstance(report, UnknownReport)
        if not self.deaf:
            super()._keep(report)


class LongitudeFirst(GroundStation):
    def _keep(self, report):
        if isinstance(report, GpsReport):
            report = replace(report, first_deg=report.second_deg, second_deg=report.first_deg)
        super()._keep(report)


class SaysAgain(GroundStation):
    """Says the motor command of last ten times a second, as a rover that watches its link wants it."""

    def __init__(self, bench, port, profile):
        super().__init__(bench, port, profile)
        self._bench = bench
        self._motors = None
        self._again()

    def send(self, command):
        self._motors = command if isinstance(command, MotorThrottles | SpeedSetpoints) else self._motors
        super().send(command)

    def _again(self):
        if self._motors is not None:
            super().send(self._motors)
        self._bench.scheduler.after(100_000_000, self._again, source="~again")


def documented():
    """The documented host in the place of one that splits lines."""

    def make(bench, port, _profile):
        return GroundStation(bench, port, PROFILES["documented"])

    return make


SCAN = PROFILES["documented"].client.frames
MUTANTS = [
    ("P36D", "P36D", with_options(split_lines=True)),
    ("P37D", "P37D", with_options(split_lines=True)),
    ("P54D", "P54D", with_options(split_lines=True)),
    ("P55D", "P55D", with_options(frames=replace(SCAN, resync=Resync.NONE))),
    ("P56", "P56", with_options(frames=replace(SCAN, timeout_s=0.01))),
    ("P50", "P50", with_options(frames=FramingOptions(framing=Framing.TERM))),
    ("P51", "P51", with_options(request_s=None)),
    ("P51", "P51", with_options(request_s=1.1)),
    ("P52", "P52", with_options(stop_at_the_end=False)),
    ("P53", "P53 and documented", SwapsMotors),
    ("P57", "P57", with_options(silence_s=None)),
    ("P57", "P57", with_options(silence_s=5.5)),
    ("P57", "P57", without(ClientState.LOST, ClientTrigger.REPORT)),
    ("P58", "P58", StopsAtAStranger),
    ("P59", "P59", NeverUnwraps),
    ("P79", "P79", LongitudeFirst),
    ("P36", "P36 and g2", documented()),
    ("P37", "P37 and g2", documented()),
    ("P54", "P54 and g2", documented()),
    ("P55", "P55 and g2", documented()),
]


def faults():
    return [
        Fault(
            name=f"{select} {number}",
            clause_id=clause,
            select=select,
            open_case=RoverProvider(shared_bench(), make_host=make).open_case,
        )
        for number, (clause, select, make) in enumerate(MUTANTS)
    ]


@pytest.mark.exhaustive("each fault once more; the gate has what P2OS's clients show on a late bench")
def test_on_a_late_bench_each_clause_finds_them_too():
    with late_benches(0.1):
        assert judge(OPTIONS, make_provider(OPTIONS), faults()).not_found == {}


def test_on_a_late_bench_no_right_host_is_accused():
    with late_benches(0.1):
        cases = run_suites(OPTIONS, AtPort(make_provider(OPTIONS))).cases
    assert {case.id: case.cause for case in cases if case.verdict in BLAMED} == {}


def test_each_clause_finds_each_host_that_is_wrong_for_it():
    verdicts = judge(OPTIONS, make_provider(OPTIONS), faults(), until_found=True)
    assert verdicts.not_found == {}
    assert verdicts.found_by == {clause.id for clause in HOST_CLAUSES}


def test_who_says_a_motor_command_again_is_right():
    provider = RoverProvider(shared_bench(), make_host=SaysAgain)
    cases = run_suites(replace(OPTIONS, select="P53"), provider).cases
    assert [(case.verdict, case.cause) for case in cases] == [(Verdict.PASS, "")] * len(cases)


REQUEST = bytes.fromhex("504B54210100E1F00A")


def test_a_foreign_host_is_judged_by_what_it_sends():
    """And by no more than that; here it requests for ever, also when it is to leave."""
    shared = shared_bench()
    options = replace(OPTIONS, select="P50 or P52 or P57")
    report = run_suites(options, ForeignClientInBenchTime(shared, foreign_host(shared), saying(REQUEST, 0.3)))
    verdicts = {case.clause_ids[0]: case.verdict for case in report.cases}
    assert verdicts == {"P50": Verdict.PASS, "P52": Verdict.FAIL, "P57": Verdict.NOT_APPLICABLE}


def of_parameters(opcode, layout, *values, rest=b""):
    return pkt_frame(bytes((opcode,)) + struct.pack(layout, *values) + rest)


@each(
    ("said", "right"),
    [
        (of_parameters(3, "<ffB", 0.5, -0.25, 3), True),
        (of_parameters(4, "<ffB", 200.0, -0.5, 3), True),
        (of_parameters(3, "<ffB", 1e-40, 0.0, 3), True),
        (of_parameters(3, "<ffB", 1.0000001, -1.0000002, 3), True),  # tenths, added in single precision
        (of_parameters(3, ">ffB", 0.5, -0.25, 3), False),
        (of_parameters(4, ">ffB", 60.0, 30.0, 3), False),
        (of_parameters(3, "<ffB", 1.5, -0.25, 3), False),
        (of_parameters(3, "<ffB", math.nan, 0.0, 3), False),
        (of_parameters(3, "<ffB", 0.5, -0.25, 3, rest=b"\0"), False),
    ],
)
def test_a_host_s_parameters_are_those_that_the_rover_has(said, right):
    shared = shared_bench()
    provider = ForeignClientInBenchTime(shared, foreign_host(shared), saying(REQUEST + said, 0.3))
    cases = run_suites(replace(OPTIONS, select="P50"), provider).cases
    assert [case.verdict for case in cases] == [Verdict.PASS if right else Verdict.FAIL], cases[0].cause


def test_a_program_is_a_foreign_host():
    provider = make_provider(replace(OPTIONS, targets=(TargetChoice(spec="exec:station {pty}"),)))
    assert isinstance(provider, ExecProvider)
    assert provider.capabilities == {"PKT!", "program 'documented'", *EXEC_CAPABILITIES}


def test_no_such_target(capsys):
    assert main(["check", "rover-model", "--target", "rovr"]) == ExitCode.USAGE
    assert capsys.readouterr().err.startswith("hilbench: --target rovr: not a target; ")
