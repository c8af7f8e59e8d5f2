"""Clients that tell on a line of their own what they understood: they are judged as ours are, and nonsense is found."""

from __future__ import annotations

import json
from dataclasses import asdict, replace

import pytest

from hilbench.bench import Bench
from hilbench.bench.client_under_test import EXEC_CAPABILITIES
from hilbench.bench.locked_providers import ExecProvider, FarEnd
from hilbench.bench.report_line import ReportLine
from hilbench.bench.shared import Shared
from hilbench.benchfile.reader import open_bench
from hilbench.check import CheckOptions, Verdict, Violation, run_suites
from hilbench.check.bench_provider import make_provider
from hilbench.clock import NS_PER_MS, Scheduler
from hilbench.errors import UsageError
from hilbench.journal import Journal
from hilbench.links import Line, MemoryLink
from hilbench.systems.pioneer.cases import ForeignClientCase
from hilbench.systems.pioneer.reporting_client import ClientReporter, ReportingClient
from hilbench.systems.pioneer.scripted import ScriptedServer
from hilbench.systems.rover.reporting_station import ReportingStation
from hilbench.systems.vehicle.car_simulator import CarSimulator, make_host
from hilbench.systems.vehicle.reporting_car import ReportingCar
from hilbench.terminal.options import TargetChoice
from measure.mutants.car_host import FAULTY_HOSTS
from measure.mutants.derived.subjects import SUBJECTS, opened
from protocols.carla import AckermannCommand
from protocols.pkt import PROFILES, ClientState, GeneralReport, PacketTotals
from targets.robots.car_host import CarHostSettings

OF_OURS_ALONE = {
    "pkt-host": {"P36", "P37", "P54", "P55"},
    "p2os-client": {"C27"},
    "carla-host": {"VS11H", "VS18", "VS19", "VS25"},
}
"""By subject the clauses that ask for more: a client of another profile, its rates, its own end of the port."""


BY_OWN_REPORT = {"carla-host": {"car"}}
"""By subject what only the client's own word says, where ours is seen to do it."""


CAR = pytest.mark.exhaustive("the suite takes seconds; the gate has a car that tells late, and each wrong one")
"""Of the three clients the one whose cases take longest."""


@pytest.mark.slow("two suites of a client, in bench time")
@pytest.mark.parametrize("name", ["pkt-host", "p2os-client", pytest.param("carla-host", marks=CAR)])
def test_a_client_that_tells_is_judged_as_ours_is(name):
    subject = SUBJECTS[name]
    options = CheckOptions(bench=subject.bench, suites=subject.suites, select=subject.select)
    with opened(subject, lambda _scheduler, port: port, at_port=True) as provider:
        report = run_suites(options, provider)
    verdicts = {clause.id: clause.verdict for clause in report.clauses}
    assert {clause for clause, verdict in verdicts.items() if verdict is Verdict.NOT_APPLICABLE} == OF_OURS_ALONE[name]
    assert set(verdicts.values()) == {Verdict.PASS, Verdict.NOT_APPLICABLE}
    assert {need for clause in report.clauses for need in clause.by_own_report} == BY_OWN_REPORT.get(name, set())


def test_a_client_may_say_that_it_lost_the_robot_and_not_why(monkeypatch):
    told = ClientReporter._report_new
    monkeypatch.setattr(
        ClientReporter,
        "_report_new",
        lambda reporter, what, value: told(reporter, what, value | {"failure": ""} if what == "state" else value),
    )
    subject = SUBJECTS["p2os-client"]
    options = CheckOptions(bench=subject.bench, suites=subject.suites, select="C20")
    with opened(subject, lambda _scheduler, port: port, at_port=True) as provider:
        report = run_suites(options, provider)
    assert [(case.verdict, case.cause) for case in report.cases] == [(Verdict.PASS, "")] * 2


class TellsLate:
    """A line of a client that hears and tells some time later."""

    def __init__(self, bench, port):
        self._after = lambda do: bench.scheduler.after(150 * NS_PER_MS, do, source="~late")
        self._port = port
        port.on_receive = lambda data, at_ns: self._after(lambda: self.on_receive(data, at_ns))

    def write(self, data):
        self._after(lambda: self._port.write(data))


def test_who_tells_its_configuration_late_has_read_it():
    right = SUBJECTS["p2os-client"]
    subject = replace(right, tell=lambda bench, client, port: right.tell(bench, client, TellsLate(bench, port)))
    options = CheckOptions(bench=subject.bench, suites=subject.suites, select="C31")
    with opened(subject, lambda _scheduler, port: port, at_port=True) as provider:
        report = run_suites(options, provider)
    assert [(clause.verdict, clause.cause) for clause in report.clauses] == [(Verdict.PASS, "")]


def late_car(make_host=make_host, select="[hardened]"):
    """What is judged of a simulator's side that hears and tells late; not applicable is left out."""

    def program(bench, port):
        return CarSimulator(bench, port, CarHostSettings(), make_host=make_host)

    right = SUBJECTS["carla-host"]
    subject = replace(
        right, program=program, tell=lambda bench, car, port: right.tell(bench, car, TellsLate(bench, port))
    )
    options = CheckOptions(bench=subject.bench, suites=subject.suites, select=select)
    with opened(subject, lambda _scheduler, port: port, at_port=True) as provider:
        report = run_suites(options, provider)
    return {clause.id: clause.verdict for clause in report.clauses if clause.verdict is not Verdict.NOT_APPLICABLE}


@pytest.mark.slow("the suite of a simulator's side, which has to wait in each case")
def test_a_car_that_tells_late_is_right():
    verdicts = late_car(select="[hardened] and not VS20")
    of_time = {clause for clause, verdict in verdicts.items() if verdict is Verdict.INCONCLUSIVE}
    assert of_time == {"VS26H", "VS28H"}
    assert {verdict for clause, verdict in verdicts.items() if clause not in of_time} == {Verdict.PASS}


def test_to_tell_late_excuses_nothing_that_is_told():
    for clause, kind in {clause: kind for kind, clauses in FAULTY_HOSTS for clause in clauses}.items():

        def wrong(settings, power_on_ns, kind=kind):
            return kind(settings, power_on_ns=power_on_ns)

        assert late_car(wrong, f"[hardened] and {clause}") == {clause: Verdict.FAIL}, kind.__name__


def line():
    scheduler = Scheduler()
    link = MemoryLink(scheduler, Line(baud=0), name="report")
    bench = Bench(scheduler, Journal())

    def say(*lines):
        link.b.write(b"".join(line if isinstance(line, bytes) else json.dumps(line).encode() + b"\n" for line in lines))
        bench.run_for(0.01)

    return bench, link.a, say


def test_lines_in_pieces_are_put_together():
    _bench, port, say = line()
    came = []
    end = ReportLine(port, came.append)
    say(b'{"a": ', b"1}\n\n", {"b": [2]}, b'{"c"')
    assert came == [{"a": 1}, {"b": [2]}]
    assert not end.senseless
    say(b"}\n", b"[1]\n")
    assert end.senseless == '{"c"}'


@pytest.mark.parametrize(
    "nonsense",
    [
        b"[" * 100_000 + b"\n",
        b'{"a":' * 100_000 + b"\n",
        b'{"config": {"\\ud800": 1}}\n',
        b"9" * 5000 + b"\n",
        b"x" * 1_000_001,
    ],
    ids=["arrays in arrays", "objects in objects", "half a character", "a number of 5000 digits", "a line without end"],
)
def test_lines_that_are_hostile_are_refused(nonsense):
    _bench, port, say = line()
    came = []
    end = ReportLine(port, came.append)
    say(nonsense)
    assert end.senseless == nonsense[:80].decode().rstrip("\n")
    assert came == []
    say(b"\n", {"a": 1})
    assert came == [{"a": 1}]


def test_a_station_is_known_by_what_it_tells():
    bench, port, say = line()
    station = ReportingStation(bench, port, PROFILES["documented"])
    say({"report": "GeneralReport", "accepted": 7, "rejected": 1}, {"state": "LINKED"})
    say({"totals": {"accepted": 300, "rejected": 2}})
    assert station.counts[GeneralReport] == 1
    assert station.latest[GeneralReport].report == GeneralReport(accepted=7, rejected=1)
    assert station.state is ClientState.LINKED
    assert station.totals == PacketTotals(accepted=300, rejected=2)


@pytest.mark.parametrize(
    "nonsense",
    [b"hello\n", {"report": "Nothing"}, {"report": "GeneralReport", "accepted": "many"}, {"state": "LOUD"}],
)
def test_nonsense_of_a_station_is_its_own_fault(nonsense):
    bench, port, say = line()
    station = ReportingStation(bench, port, PROFILES["documented"])
    say(nonsense)
    with pytest.raises(Violation, match="makes no sense"):
        _ = station.counts


@pytest.mark.parametrize("nonsense", [{"state": "ASLEEP"}, {"state": ["OPEN"]}])
def test_what_is_nonsense_is_shown_as_it_came(nonsense):
    bench, port, say = line()
    told = ReportingClient(bench, port)
    say(nonsense)
    with pytest.raises(Violation) as wrong:
        _ = told.sips
    assert str(wrong.value).splitlines()[0] == f"the client reports what makes no sense: {nonsense}"


COMMANDED = {"commanded": "AckermannCommand", **asdict(AckermannCommand())}


@pytest.mark.parametrize(
    ("make", "look", "nonsense"),
    [
        (ReportingClient, "sips", {"sip": {}}),
        (ReportingClient, "sips", {"state": "OPEN", "failure": [1]}),
        (ReportingCar, "published", {"commanded": "Nothing"}),
        (ReportingCar, "published", {**COMMANDED, "mode": "one", "by_node": False}),
        (ReportingCar, "published", {**COMMANDED, "mode": 1, "by_node": [2]}),
    ],
)
def test_nonsense_of_others_too(make, look, nonsense):
    bench, port, say = line()
    told = make(bench, port)
    say(nonsense)
    with pytest.raises(Violation, match="makes no sense"):
        getattr(told, look)


def test_who_has_a_line_for_it_can_be_asked_and_told():
    target = TargetChoice(spec="exec:station {pty} {report}")
    provider = make_provider(CheckOptions(bench="rover-model", targets=(target,)))
    told = {"client.report", "client.commands"}
    assert provider.capabilities == {"PKT!", "program 'documented'", *EXEC_CAPABILITIES, *told}


def test_a_line_that_nobody_understands_is_refused():
    shared = Shared(bench_file=open_bench("pioneer"), timeout_scale=1.0, journal=Journal())
    with pytest.raises(UsageError, match="nobody here would understand"):
        ExecProvider(shared, "client {pty} {report}", FarEnd(serve=ScriptedServer, case=ForeignClientCase))
