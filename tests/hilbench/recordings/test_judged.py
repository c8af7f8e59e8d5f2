"""`check --target capture:FILE`: a recording gives the verdicts that the run gave, whatever format it is in."""

from __future__ import annotations

import io
import json

import pytest

from hilbench.bench.shared import Shared
from hilbench.benchfile.reader import open_bench
from hilbench.check import CheckOptions, Verdict, list_cases, run_suites
from hilbench.check.bench_provider import make_provider
from hilbench.cli import main
from hilbench.journal import Journal
from hilbench.recordings.csv_file import write_csv
from hilbench.recordings.mcap_file import write_mcap
from hilbench.recordings.pcapng import write_pcapng
from hilbench.terminal.options import TargetChoice
from measure.mutants.bench import MutantProvider
from measure.mutants.catalogue import mutants_of
from measure.mutants.mutant import Family
from protocols import autoware
from protocols.p2os import Command, encode_command
from protocols.pkt import (
    GeneralReport,
    GpsReport,
    ImuReport,
    MotionReport,
    MotorThrottles,
    RequestTelemetry,
    Schema,
    encode_frame,
    encode_report,
)
from protocols.pkt import encode_command as encode_command_of_rover

SUITES = {"server": "p2os-server", "client": "p2os-client"}
MS = 1_000_000


def live(path, mutant=None, *, select, suite="p2os-server"):
    """Run a suite on a bench with a mutant, or with the right device; return the verdicts by clause."""
    shared = Shared(bench_file=open_bench("pioneer"), timeout_scale=1.0, journal=Journal(path, {"bench": "pioneer"}))
    provider = MutantProvider(shared, mutant, motion=False)
    report = run_suites(CheckOptions(suites=(suite,), select=select), provider)
    provider.close()
    return {clause.id: clause.verdict for clause in report.clauses}


def judged(path, *, select=""):
    """Judge a recording; return the report."""
    options = CheckOptions(targets=(TargetChoice(spec=f"capture:{path}"),), select=select)
    provider = make_provider(options)
    try:
        return run_suites(options, provider)
    finally:
        provider.close()


def verdicts(report):
    return {clause.id: clause.verdict for clause in report.clauses}


def listening_clauses(path):
    """The clauses that some case judges by listening alone."""
    options = CheckOptions(targets=(TargetChoice(spec=f"capture:{path}"),))
    planned = list_cases(options, make_provider(options))
    return {clause for plan in planned if not plan.missing for clause in plan.clause_ids}


# --- verdicts of live runs and of their recordings


@pytest.fixture(scope="module")
def right(tmp_path_factory):
    """The recording of a run of a robot that does as it should, and what that run said."""
    path = tmp_path_factory.mktemp("right") / "run.jsonl"
    select = "S01 or S02 or S03 or S04 or S05 or S06 or S36 or S39 or S40"
    return path, live(path, select=select)


def test_a_run_that_passed_passes(right):
    path, said = right
    found = verdicts(judged(path, select=" or ".join(said)))
    assert found == said
    assert set(found.values()) == {Verdict.PASS}


OTHER_FORMATS = pytest.mark.exhaustive("the gate judges one format, and test_formats reads what each has written")


@pytest.mark.parametrize(
    "write", [write_mcap, *(pytest.param(write, marks=OTHER_FORMATS) for write in (write_pcapng, write_csv))]
)
def test_in_every_format_alike(right, tmp_path, write):
    path, said = right
    file = io.BytesIO()
    write(Journal.read(path), file)
    exported = tmp_path / "exported"
    exported.write_bytes(file.getvalue())
    assert verdicts(judged(exported, select=" or ".join(said))) == said


FAULTS = {
    "echo1-argument": "S02",
    "sip-twentieth": "S18",
    "c-opens-early": "C02",
}


MORE_FAULTS = {
    "pulse-echoed": "S39",
    "c-no-keepalive": "C22",
    "id-class": "S03",
    "id-padded": "S03",
    "session-at-once": "S04",
    "out-checksum": "S18",
    "out-noise": "S18",
    "sip-padded": "S18",
    "sip-cycle": "S18",
    "type-moving": "S18",
    "watchdog-absent": "S36",
    "watchdog-bit-late": "S36",
    "c-hasty": "C02",
    "c-slow-keepalive": "C22",
    "c-string-no-length": "C25",
    "c-count-over-200": "C25",
}
_MORE = pytest.mark.exhaustive("more faults of the kind of those in the gate: an echo, a SIP, an opening")


@pytest.mark.parametrize(
    ("fault", "clause"), [*FAULTS.items(), *(pytest.param(*pair, marks=_MORE) for pair in MORE_FAULTS.items())]
)
def test_a_run_that_failed_fails_for_the_same_clause(tmp_path, fault, clause):
    (mutant,) = mutants_of(ids=(fault,))
    path = tmp_path / "run.jsonl"
    assert live(path, mutant, select=clause, suite=mutant.family.suites[0]) == {clause: Verdict.FAIL}
    report = judged(path, select=clause)
    assert verdicts(report) == {clause: Verdict.FAIL}
    assert "p2os-" in report.cases[0].cause  # the case in which it was seen


@pytest.mark.exhaustive("every fault there is against every clause; the gate has three, each with the clause it breaks")
@pytest.mark.parametrize("mutant", mutants_of((Family.SERVER_HAND, Family.CLIENT_HAND)), ids=lambda mutant: mutant.id)
def test_no_clause_is_judged_otherwise_than_live(tmp_path, mutant):
    """Where a live case could not get to its question, a recording may say less, and never the opposite."""
    suite = mutant.family.suites[0]
    path = tmp_path / "run.jsonl"
    listening = "S01 S02 S03 S04 S05 S06 S18 S36 S39 S40" if suite == "p2os-server" else "C02 C22 C25"
    said = live(path, mutant, select=listening.replace(" ", " or "), suite=suite)
    if not any(event["kind"] == "rx" for event in Journal.read(path).events):
        pytest.skip("nothing was heard from it")
    found = verdicts(judged(path, select=listening.replace(" ", " or ")))
    for clause, verdict in found.items():
        assert verdict is not Verdict.FAIL or said[clause] is Verdict.FAIL, clause


# --- what cannot be judged by listening


def test_a_case_that_listens_does_not_apply_where_somebody_answers():
    options = CheckOptions(bench="pioneer", suites=("recorded-p2os",))
    planned = list_cases(options, make_provider(options))
    assert {plan.missing for plan in planned} == {("recording",)}


# --- lines that no case was about


@pytest.fixture
def line(tmp_path):
    """Write a journal of one end of a line from (ms, way, bytes); return its path."""

    def written(*said, source="checker", end_ms=None):
        path = tmp_path / "line.jsonl"
        journal = Journal(path, {"bench": "desk"})
        for at_ms, way, data in said:
            journal.record(way, source, round(at_ms * MS), data=data)
        journal.record("note", "desk", round((end_ms or said[-1][0]) * MS), text="the end")
        journal.close()
        return path

    return written


SYNCS = [encode_command(Command(number=number)) for number in range(3)]


def test_both_ends_of_a_foreign_line_are_judged(line):
    path = line((0, "tx", SYNCS[0]), (150, "rx", SYNCS[0]), (160, "tx", SYNCS[1]), end_ms=3000)
    found = verdicts(judged(path, select="S01 or S02 or C02"))
    assert found == {"S01": Verdict.PASS, "S02": Verdict.FAIL, "C02": Verdict.PASS}


def test_a_time_too_near_to_its_limit_is_inconclusive(line):
    path = line((0, "tx", SYNCS[0]), (201, "rx", SYNCS[0]), end_ms=3000)
    report = judged(path, select="S01")
    assert verdicts(report) == {"S01": Verdict.INCONCLUSIVE}  # assumed uncertainty of 2 ms
    assert verdicts(judged(line((0, "tx", SYNCS[0]), (203, "rx", SYNCS[0]), end_ms=3000), select="S01")) == {
        "S01": Verdict.FAIL
    }


def test_a_recording_that_ends_too_soon_says_nothing(line):
    path = line((0, "tx", SYNCS[0]), (10, "rx", SYNCS[0]), (20, "tx", SYNCS[1]), (100, "tx", b"x"))
    found = verdicts(judged(path, select="S01 or S02"))
    assert found == {"S01": Verdict.PASS, "S02": Verdict.NOT_APPLICABLE}


def test_one_direction_alone_is_not_judged(line):
    path = line((0, "tx", SYNCS[0]), (10, "tx", SYNCS[1]), end_ms=3000)
    assert verdicts(judged(path, select="S01 or C02")) == {"S01": Verdict.INCONCLUSIVE, "C02": Verdict.INCONCLUSIVE}


def test_the_two_ends_of_a_proxy_are_one_line(tmp_path):
    """Bytes are collected there for up to 10 ms, and came half of that earlier, more or less."""
    journal = Journal(tmp_path / "proxy.jsonl", {"proxy": ["pty:a", "pioneer"]})
    for number, sync in enumerate(SYNCS[:2]):
        asked_ns = number * 1000 * MS
        journal.record("tx", "client", asked_ns + 10 * MS, data=sync, from_ns=asked_ns)
        journal.record("tx", "robot", asked_ns + 190 * MS, data=sync)
        journal.record("tx", "server", asked_ns + 204 * MS, data=sync, from_ns=asked_ns + 194 * MS)
    journal.record("note", "desk", 5000 * MS, text="the end")
    journal.close()
    report = judged(tmp_path / "proxy.jsonl", select="S01 or S02 or C02")
    assert verdicts(report) == {"S01": Verdict.INCONCLUSIVE, "S02": Verdict.INCONCLUSIVE, "C02": Verdict.PASS}
    (measure,) = report.cases[1].measures
    assert (measure.value, measure.uncertainty) == pytest.approx((0.194, 0.007))


@pytest.mark.parametrize(("late_s", "verdict"), [(0.03, Verdict.INCONCLUSIVE), (0.003, Verdict.FAIL)])
def test_an_answer_to_a_proxy_that_was_late_may_have_been_in_time(tmp_path, late_s, verdict):
    journal = Journal(tmp_path / "proxy.jsonl", {"proxy": ["pty:a", "serial:b"]})
    journal.record("tx", "client", 0, data=SYNCS[0])
    journal.record("tx", "server", 220 * MS, data=SYNCS[0])
    journal.record("host-lateness", "proxy", 300 * MS, uncertainty_s=late_s)
    journal.record("host-lateness", "proxy", 400 * MS, uncertainty_s=0.0025)
    journal.record("note", "desk", 5000 * MS, text="the end")
    journal.close()
    assert verdicts(judged(tmp_path / "proxy.jsonl", select="S01")) == {"S01": verdict}


@pytest.fixture
def rover_line(line):
    request = encode_frame(b"\x00")

    def written(*reports, every_ms=500, count=8):
        asked = [(every_ms * number, "tx", request) for number in range(count)]
        told = [(every_ms * number + 5, "rx", encode_frame(encode_report(report, Schema.V2))) for number, report in
                enumerate(reports)]  # fmt: skip
        return line(*sorted([*asked, *told], key=lambda each: each[0]))

    return written


@pytest.mark.parametrize(
    ("throttle", "verdict"),
    [(0.5, Verdict.PASS), (float("nan"), Verdict.FAIL), (-1.5, Verdict.FAIL)],
)
def test_throttles_of_a_rover(rover_line, throttle, verdict):
    path = rover_line(MotionReport(throttles=(0.0, throttle)))
    assert verdicts(judged(path, select="P28D or P50 or P51")) == {
        "P28D": verdict,
        "P50": Verdict.PASS,
        "P51": Verdict.PASS,
    }


def reports_by_themselves(from_ms):
    """What a rover says in ten seconds to whom nobody speaks."""
    for report, count in ((GeneralReport(), 30), (MotionReport(), 40), (ImuReport(), 10), (GpsReport(), 10)):
        for number in range(count):
            yield from_ms + 10_000 / count * (number + 0.5), "rx", encode_frame(encode_report(report, Schema.V2))


@pytest.mark.parametrize(
    ("last_word", "verdict"),
    [(RequestTelemetry(), Verdict.PASS), (MotorThrottles(a=0.0, b=0.0, flags=3), Verdict.NOT_APPLICABLE)],
)
def test_ten_seconds_behind_the_answer_to_a_request_are_enough(line, last_word, verdict):
    """As in the live case; what another command brings may take half a second."""
    word = encode_frame(encode_command_of_rover(last_word))
    answer = encode_frame(encode_report(GeneralReport(), Schema.V2))
    path = line((0, "tx", word), (5, "rx", answer), *sorted(reports_by_themselves(5)), end_ms=10_005)
    assert verdicts(judged(path, select="P30")) == {"P30": verdict}


def test_a_part_that_starts_for_the_next_case_does_not_end_the_one_before(tmp_path):
    """A board's parts say that they start before the journal has the next case; nobody is heard at a GPS receiver."""
    journal = Journal(tmp_path / "rover.jsonl", {"bench": "rover"})
    answer = encode_frame(encode_report(GeneralReport(), Schema.V2))
    for case in ("pkt-board/one[documented]", "pkt-board/two[documented]"):
        journal.record("event", "gps", 0, name="ReceiverStarted", value={"start": "hot"})
        journal.begin_case(case)
        said = [(0, "tx", encode_frame(b"\x00")), (5, "rx", answer), *sorted(reports_by_themselves(5))]
        for at_ms, way, data in said:
            journal.record(way, "checker", round(at_ms * MS), data=data)
            journal.record("tx", "gps", round(at_ms * MS), data=b"$GPGGA,120000.00,,,,,0,00,99.9,,,,,,*67\r\n" * 4)
        journal.end_case(10_005 * MS)
    journal.close()
    assert verdicts(judged(tmp_path / "rover.jsonl", select="P30")) == {"P30": Verdict.PASS}


def test_a_host_that_is_silent_or_talks_nonsense(rover_line, line):
    slow = rover_line(MotionReport(), every_ms=1200)
    assert verdicts(judged(slow, select="P51")) == {"P51": Verdict.FAIL}
    report = encode_frame(encode_report(MotionReport(), Schema.V2))
    path = line((0, "tx", encode_frame(b"\x00")), (10, "tx", encode_frame(b"\x6f")), (20, "rx", report))
    assert verdicts(judged(path, select="P50")) == {"P50": Verdict.FAIL}


# --- as a person meets it


def test_the_report_names_the_recording_and_why_most_does_not_apply(right, capfd):
    path, _ = right
    assert main(["check", "--target", f"capture:{path}", "--json", "-"]) == 0
    report = json.loads(capfd.readouterr().out)
    assert report["bench"]["target"] == f"recording {path} (p2os)"
    assert len(report["run_hash"]) == 64
    listening = listening_clauses(path)
    others = [clause for clause in report["clauses"] if clause["id"] not in listening]
    assert {clause["verdict"] for clause in others} == {"not-applicable"}
    (cause,) = {clause["cause"] for clause in others if clause["id"] == "S10"}
    assert cause == "the bench has no far end that answers: it is a recording"


def test_a_cut_recording_is_judged_up_to_there(right, tmp_path, capfd):
    path, _ = right
    cut = tmp_path / "cut.jsonl"
    cut.write_bytes(path.read_bytes()[:-3000])
    assert main(["check", "--target", f"capture:{cut}", "-k", "S01"]) == 0
    assert "judged up to there" in capfd.readouterr().out


def test_a_protocol_that_cannot_be_judged_is_named(line, capfd):
    message = autoware.encode_message(autoware.ControlModeResponse(sequence=7, success=True))
    path = line((0, "tx", autoware.encode_frame(message)))
    assert main(["check", "--target", f"capture:{path}"]) == 2
    assert "autoware is spoken there, and cannot be judged by listening; that can be" in capfd.readouterr().err


def test_the_journal_of_a_judgement_keeps_to_its_limit(right, tmp_path, capfd):
    path, _ = right
    journal = tmp_path / "judged.jsonl"
    limit = CheckOptions(targets=(TargetChoice(spec=f"capture:{path}"),), journal=journal, journal_max=2000)
    provider = make_provider(limit)
    run_suites(limit, provider)
    provider.close()
    assert journal.with_name("judged.jsonl.1").exists()
    assert Journal.read(journal).header["part"] > 0


def test_a_later_part_of_a_journal_is_said_to_be_one(right, tmp_path, capfd):
    path, _ = right
    part = tmp_path / "part.jsonl"
    part.write_text(path.read_text().replace('"part":0', '"part":1', 1))
    assert main(["check", "--target", f"capture:{part}", "-k", "S01"]) == 0
    assert "its beginning is in an older file" in capfd.readouterr().out


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        (("--target", "capture:"), 2, "names no recording"),
        (("--target", "capture:{folder}/no"), 3, "No such file"),
        (("pioneer", "--target", "capture:{folder}/line.jsonl"), 2, "a recording needs no bench"),
        (("--target", "robot=capture:{folder}/line.jsonl"), 2, "stands for the whole bench"),
        (("--target", "capture:{folder}/line.jsonl", "--target", "pioneer"), 2, "stands for the whole bench"),
        (("--target", "capture:{folder}/line.jsonl", "--journal", "{folder}/line.jsonl"), 2, "would overwrite"),
        (("--target", "capture:{folder}/line.jsonl"), 2, "no protocol is known that makes frames"),
    ],
)
def test_wrong_usage(line, tmp_path, capfd, words, code, said):
    line((0, "tx", b"hello, world"), (1, "rx", b"hello"))
    assert main(["check", *[word.format(folder=tmp_path) for word in words]]) == code
    err = capfd.readouterr().err
    assert said in err
    assert len(err.splitlines()) == 1
