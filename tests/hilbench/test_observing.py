"""What a report says beside verdicts: coverage, tight margins, fidelity, pace; and that it is all in the JSON."""

from __future__ import annotations

import json
from collections import Counter
from xml.etree import ElementTree

import msgspec
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hilbench.bench.observing import coverage_of
from hilbench.check import CheckOptions, Report, Verdict, run_suites
from hilbench.check.bench_provider import make_provider
from hilbench.check.report import junit, matrix
from hilbench.check.report.schema import report_json
from hilbench.check.results import CaseResult, tightest_margins
from hilbench.judging.observations import Observations, PortCounters
from hilbench.judging.provider import case_seed
from hilbench.judging.verdicts import Measure
from hilbench.terminal.options import TargetChoice
from protocols.p2os import CLIENT_TABLE, SERVER_TABLE
from protocols.p2os.states import ServerState, ServerTrigger
from targets.robots.pioneer.ledger import LEDGER, Fidelity

SUITE = """
from __future__ import annotations
from hilbench.check import Violation, at_most, case
from hilbench.judging.verdicts import Inconclusive

def my(clause): return case(clause, text=f"The robot does {clause}.", source="ours")

@my("X1")
def test_session(peer):
    peer.start()
    at_most(0.5, 2.0, unit="s", what="made up")
    peer.send(11, 200)             # VEL without motors: no effect
    peer.send(15, b"hello")        # SAY: partly
    peer.send(72, 100)             # ARM: absent
    peer.send(99)                  # nobody's
    peer.run(0.2)

@my("X2")
def test_again(peer):
    peer.start()
    peer.send(15, b"again")
    peer.run(0.2)

@my("X3")
def test_wrong(peer):
    peer.handshake()
    raise Violation("not as it should be", ["seen"])

@my("X4")
def test_unclear(bench):
    raise Inconclusive("cannot tell")
"""


@pytest.fixture(scope="module")
def run_one(tmp_path_factory):
    """Run the suite above on a bench; return the report."""
    folder = tmp_path_factory.mktemp("suite")
    suite = folder / "test_mine.py"
    suite.write_text(SUITE)

    def run(*targets, bench="pioneer-plane", select=""):
        chosen = tuple(TargetChoice(spec=spec) for spec in targets)
        options = CheckOptions(bench=bench, suites=(str(suite),), targets=chosen, select=select, seed=7)
        provider = make_provider(options)
        try:
            return run_suites(options, provider)
        finally:
            provider.close()

    return run


@pytest.fixture(scope="module")
def virtual(run_one):
    return run_one()


@pytest.fixture(scope="module")
def in_real_time(run_one):
    return run_one("serial:loop://", select="X2")


# --- virtual targets


def test_coverage_is_the_union_of_all_cases(virtual):
    (server,) = virtual.observed.coverage
    assert (server.peer, server.states, server.edges) == ("server", 5, len(SERVER_TABLE))
    assert server.states_missed == ()
    assert "READY SYNC1_OPEN" not in server.edges_missed
    assert {"OPEN LINE_DOWN", "WAIT1 SYNC0_PULSE"} <= set(server.edges_missed)


def test_a_client_is_covered_as_well(run_one):
    options = CheckOptions(bench="pioneer-plane", suites=("p2os-client",), select="C04")
    report = run_suites(options, make_provider(options))
    (client,) = report.observed.coverage
    assert (client.peer, client.states, client.edges) == ("client", 13, len(CLIENT_TABLE))
    assert "IDLE CONNECT" not in client.edges_missed
    assert report.observed.ledger is None


def test_the_ledger_names_what_the_run_touched_and_where(virtual):
    ledger = virtual.observed.ledger
    fidelities = Counter(entry.fidelity for entry in LEDGER)
    assert (ledger.modelled, ledger.partly, ledger.absent) == tuple(fidelities[fidelity] for fidelity in Fidelity)
    touched = {feature.feature: feature for feature in ledger.touched}
    assert set(touched) == {"sound", "arm", "unknown commands"}
    assert touched["sound"].fidelity == "partly"
    assert touched["sound"].case_ids == ("mine/session", "mine/again")
    assert touched["arm"].fidelity == touched["unknown commands"].fidelity == "absent"
    assert touched["arm"].case_ids == ("mine/session",)
    (ignored,) = ledger.ignored
    assert (ignored.command, ignored.reason, ignored.case_ids) == ("VEL", "motors are off", ("mine/session",))


def test_the_terminal_has_a_line_for_each(virtual):
    lines = matrix.render(virtual, colours=False, width=None).splitlines()
    (coverage,) = (line for line in lines if line.startswith("server: "))
    assert coverage.startswith(
        f"server: 5 of 5 states, {26 - len(virtual.observed.coverage[0].edges_missed)} of 26 edges"
    )
    assert "; not taken: " in coverage
    assert "tightest margins: X1 0.5 s (75.0%)" in lines
    (model,) = (line for line in lines if line.startswith("model: "))
    assert model.endswith("; touched, partly: 'sound'; touched, absent: 'arm', 'unknown commands'; without effect: VEL")
    assert not [line for line in lines if line.startswith(("host: ", "port: "))]
    assert f"run hash {virtual.run_hash}" in lines


def test_looking_leaves_nothing_in_the_hash(virtual, run_one):
    alone = run_one(select="X2")
    assert alone.cases[0].case_hash == virtual.cases[1].case_hash


def test_everything_about_a_case_is_in_the_json(virtual):
    read = msgspec.json.decode(report_json(virtual), type=Report, strict=True)
    assert read == virtual
    raw = {case["id"]: case for case in json.loads(report_json(virtual))["cases"]}
    assert list(raw) == ["mine/session", "mine/again", "mine/wrong", "mine/unclear"]
    for case_id, case in raw.items():
        assert case["seed"] == case_seed(7, case_id)
        assert len(bytes.fromhex(case["case_hash"])) == 32
        assert isinstance(case["bench_time_s"], float)
    assert raw["mine/session"]["bench_time_s"] > 0.2
    assert [case["verdict"] for case in raw.values()] == ["pass", "pass", "fail", "inconclusive"]
    assert raw["mine/session"]["measures"] == [
        {"name": "made up", "value": 0.5, "unit": "s", "high": 2.0, "uncertainty": 0.0, "margin": 1.5}
    ]
    assert raw["mine/session"]["cause"] == ""
    assert raw["mine/wrong"]["cause"] == "not as it should be"
    assert raw["mine/wrong"]["evidence"][0] == "seen"
    assert len(raw["mine/wrong"]["evidence"]) > 1, "the latest packets"
    assert raw["mine/unclear"]["cause"] == "cannot tell"


# --- a port in real time


@pytest.mark.real_time("a run in real time says how exact it was; it may have been late")
def test_a_run_in_real_time_has_no_hash_and_says_why(in_real_time):
    assert in_real_time.run_hash is None
    assert in_real_time.cases[0].case_hash == ""
    raw = json.loads(report_json(in_real_time))
    assert raw["run_hash"] is None
    assert "real time" in raw["no_run_hash"]
    lines = matrix.render(in_real_time, colours=False, width=None).splitlines()
    assert f"no run hash: {raw['no_run_hash']}" in lines
    assert not [line for line in lines if line.startswith("run hash")]
    suite = ElementTree.fromstring(junit.junit_xml(in_real_time).encode()).find("testsuite")
    facts = {entry.get("name"): entry.get("value") for entry in suite.find("properties")}
    assert facts["run_hash"] == ""


@pytest.mark.real_time("a run in real time says how exact it was; it may have been late")
def test_a_run_in_real_time_tells_how_exact_it_was(in_real_time):
    observed = in_real_time.observed
    assert (observed.coverage, observed.ledger) == ((), None)
    assert 0 <= observed.pace.lateness_p50_s <= observed.pace.lateness_p99_s <= observed.pace.lateness_max_s
    assert observed.pace.real_time_factor > 0
    assert observed.port.sent == observed.port.received > 0, "Tx and Rx are joined"
    lines = matrix.render(in_real_time, colours=False, width=None).splitlines()
    (host,) = (line for line in lines if line.startswith("host: lateness p50 "))
    assert " slips, " in host
    assert f"port: {observed.port.sent} bytes sent, {observed.port.received} received, none lost" in lines


@pytest.mark.real_time("a run in real time says how exact it was; it may have been late")
def test_breaks_that_a_port_cannot_send_are_not_passed_over(in_real_time):
    port = PortCounters(sent=1, breaks=2, breaks_unsent=3)
    report = msgspec.structs.replace(in_real_time, observed=Observations(port=port))
    wanted = "port: 1 bytes sent, 0 received, none lost; 2 breaks; 3 breaks asked for that it cannot send"
    assert wanted in matrix.render(report, colours=False, width=None).splitlines()


# --- the parts


edges = st.dictionaries(st.sampled_from(list(SERVER_TABLE)), st.integers(0, 3))


@settings(deadline=None)
@given(edges)
def test_coverage_counts_what_was_taken(visits):
    stranger = (ServerState.WAIT, ServerTrigger.COMMAND)
    coverage = coverage_of("server", SERVER_TABLE, {**visits, stranger: 5})
    taken = {edge for edge, times in visits.items() if times}
    missed = [f"{state.name} {trigger.name}" for state, trigger in SERVER_TABLE if (state, trigger) not in taken]
    assert list(coverage.edges_missed) == missed
    entered = {"WAIT"} | {edge[0].name for edge in taken} | {SERVER_TABLE[edge].next_state.name for edge in taken}
    assert {state.name for state in ServerState} - set(coverage.states_missed) == entered


margins = st.lists(st.tuples(st.sampled_from("ABCDEFG"), st.floats(-1, 2)), max_size=20)


@settings(deadline=None)
@given(margins)
def test_the_tightest_margins_are_the_least_of_each_clause(found):
    results = [
        CaseResult(
            id=f"s/{number}",
            suite="s",
            clause_ids=(clause,),
            verdict=Verdict.PASS,
            measures=(Measure(name="m", value=1 - share, unit="", high=1.0, margin=share),),
        )
        for number, (clause, share) in enumerate(found)
    ]
    tightest = tightest_margins(results)
    least = {clause: min(share for other, share in found if other == clause) for clause, _ in found}
    assert [margin.share for margin in tightest] == sorted(least.values())[:5]
    assert all(least[margin.clause_ids[0]] == margin.share for margin in tightest)
    assert len({margin.clause_ids for margin in tightest}) == len(tightest)
