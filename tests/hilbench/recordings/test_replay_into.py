"""`hilbench replay --into`: a fresh robot answers what it is told once more as before, to the byte and nanosecond."""

from __future__ import annotations

import json
import re

import pytest

from hilbench.check import CheckOptions, list_cases
from hilbench.check.bench_provider import make_provider
from hilbench.cli import main
from hilbench.journal import Journal
from hilbench.links.memory import MemoryPort
from protocols import autoware
from protocols.p2os import Command, encode_command
from protocols.pkt import GeneralReport, Schema, encode_frame, encode_report

MS = 1_000_000
SYNC0 = encode_command(Command(number=0))
SELECT = "S01 or S21 or S36"
AUTOWARE = autoware.encode_frame(autoware.encode_message(autoware.ControlModeResponse(sequence=7, success=True)))


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    path = tmp_path_factory.mktemp("replay") / "run.jsonl"
    assert main(["check", "pioneer-plane", "--suite", "p2os-server", "-k", SELECT, "--journal", str(path)]) == 0
    return path


@pytest.fixture
def replay(capfd):
    def run(*words):
        code = main(["replay", *map(str, words)])
        return code, *capfd.readouterr()

    return run


def test_a_fresh_robot_answers_the_same_at_the_same_times(recorded, replay, tmp_path):
    code, out, _ = replay(recorded, "--into", "pioneer-plane", "--journal", tmp_path / "again.jsonl", "--json")
    assert code == 0
    cases = json.loads(out)["cases"]
    assert [case["number"] for case in cases] == [0, 0, 0]
    assert sum(case["recorded"] for case in cases) > 30
    again = str(tmp_path / "again.jsonl")
    ends = {event["case"]: event["ns"] for event in Journal.read(recorded).events if event["kind"] == "case-end"}
    # What comes behind the end of the recording is the rest of an answer that was on its way.
    said = {path: _until(Journal.read(path).events, ends) for path in (str(recorded), again)}
    assert said[str(recorded)] == said[again]


def _until(events, ends):
    case, kept = "", []
    for event in events:
        case = event["case"] if event["kind"] == "case" else case
        if event["kind"] in {"tx", "rx"} and event["source"] == "checker" and event["ns"] <= ends[case]:
            kept.append((case, event["ns"], event["kind"], event["data"]))
    return kept


def test_what_comes_behind_the_end_of_a_recording_is_no_difference(recorded, replay, tmp_path):
    """A recording that was stopped a while before the robot's last SIPs."""
    lines = recorded.read_text().splitlines()
    answers = [number for number, line in enumerate(lines) if '"rx","source":"checker"' in line]
    case = next(number for number, line in enumerate(lines) if number > answers[12] and '"kind":"case-end"' in line)
    path = tmp_path / "short.jsonl"
    gone = {number for number in answers if answers[12] < number < case}
    path.write_text("\n".join(line for number, line in enumerate(lines) if number not in gone) + "\n")
    code, out, _ = replay(path, "--into", "pioneer-plane", "--json")
    assert (code, json.loads(out)["equal"]) == (0, True)
    assert any(case["answered"] > case["recorded"] for case in json.loads(out)["cases"])


def test_another_answer_is_named_with_its_frame(recorded, replay, tmp_path):
    lines = recorded.read_text().splitlines()
    at = [number for number, line in enumerate(lines) if '"rx","source":"checker"' in line][1]
    event = json.loads(lines[at])
    lines[at] = json.dumps({**event, "data": "fafb03020002"})
    path = tmp_path / "other.jsonl"
    path.write_text("\n".join(['{"kind":"journal"' + lines[0][17:], *lines[1:]]) + "\n")
    code, out, err = replay(path, "--into", "pioneer-plane")
    assert code == 1
    assert "first different: frame 1" in out
    assert "answered differently" in err


@pytest.mark.parametrize(
    ("bench", "profiles"),
    [
        ("rover-model", 4),
        pytest.param("rover", 1, marks=pytest.mark.exhaustive("the gate has the model; here firmware is emulated")),
    ],
)
def test_a_rover_answers_the_same_emulated_or_not(replay, tmp_path, capfd, bench, profiles):
    """Each case by the program that it is named for; the GPS receiver's line beside it is not the host's."""
    path = tmp_path / "rover.jsonl"
    select = "P01" if profiles > 1 else "P01 and documented"
    assert main(["check", bench, "--suite", "pkt-board", "-k", select, "--journal", str(path)]) == 0
    capfd.readouterr()
    code, out, _ = replay(path, "--into", bench, "--json")
    cases = json.loads(out)["cases"]
    assert (code, [case["number"] for case in cases]) == (0, [0] * profiles)
    assert all(case["recorded"] > 5 for case in cases)


@pytest.fixture
def foreign(tmp_path):
    """Write a recording without cases, of events (kind, source, ms, data, ms of its first byte); return its path."""

    def written(*said):
        journal = Journal(tmp_path / "foreign.jsonl", {"proxy": ["pty:a", "pioneer"]})
        for kind, source, at_ms, data, from_ms in said:
            journal.record(kind, source, at_ms * MS, data=data, from_ns=from_ms * MS)
        journal.close()
        return journal.path

    return written


@pytest.mark.parametrize("begin_ms", [0, 10_291])
def test_a_recording_that_begins_with_bytes_that_were_collected(foreign, replay, begin_ms):
    """As a proxy's does, and a part of a journal behind another: the first of them came before its first event."""
    path = foreign(
        ("tx", "client", begin_ms + 10, SYNC0, begin_ms), ("tx", "server", begin_ms + 30, SYNC0, begin_ms + 20)
    )
    code, out, _ = replay(path, "--into", "pioneer-plane", "--json")
    assert (code, json.loads(out)["cases"][0]["answered"]) == (0, 1)


def test_bytes_that_lie_in_the_past_are_said_at_once(foreign, replay):
    """Two chunks of one host whose times overlap."""
    path = foreign(
        ("tx", "client", 50, SYNC0, 40), ("tx", "client", 60, SYNC0, 20), ("tx", "server", 70, SYNC0 * 2, 70)
    )
    code, out, _ = replay(path, "--into", "pioneer-plane", "--json")
    assert (code, json.loads(out)["cases"][0]["answered"]) == (0, 2)


def test_a_line_that_is_slower_than_the_recorded_one_is_waited_for(foreign, replay):
    """A second and a quarter at 9600 bit/s, on a line that took a hundredth of one."""
    path = foreign(("tx", "client", 10, SYNC0 * 200, 0), ("tx", "server", 20, SYNC0 * 200, 10))
    code, out, _ = replay(path, "--into", "pioneer-plane", "--json")
    assert (code, json.loads(out)["cases"][0]["answered"]) == (0, 200)


def test_answers_that_take_longer_than_in_the_recording_are_waited_for(foreign, replay, monkeypatch):
    """More comes back than was said, so that the last answer comes long after the last word."""
    monkeypatch.setattr("hilbench.recordings.replaying.SETTLE_S", 0.01)
    request, general = encode_frame(b"\x00"), encode_frame(encode_report(GeneralReport(), Schema.V2))
    path = foreign(("tx", "client", 10, request * 300, 0), ("tx", "server", 20, general * 300, 10))
    _, out, _ = replay(path, "--into", "rover-model", "--json")
    assert json.loads(out)["cases"][0]["answered"] >= 300


def test_a_line_that_takes_nothing_more_is_named(foreign, replay, monkeypatch):
    monkeypatch.setattr(MemoryPort, "pending", 7)
    path = foreign(("tx", "client", 10, SYNC0, 10), ("tx", "server", 20, SYNC0, 20))
    code, out, err = replay(path, "--into", "pioneer-plane")
    assert (code, out) == (3, "")
    assert "takes nothing more: 7 bytes that the host said are not out" in err


@pytest.mark.parametrize("command", ["replay", "export"])
def test_the_case_of_an_example_exists(command, capfd):
    assert main([command, "--help"]) == 0
    named = set(re.findall(r"--case (\w\S+/\S+)", capfd.readouterr().out))
    options = CheckOptions(bench="pioneer-plane", suites=("p2os-server",))
    assert named
    assert named <= {plan.id for plan in list_cases(options, make_provider(options))}


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        (("{run}", "--case", "x"), 2, "--case: is for playing to a target"),
        (("{run}", "--journal", "{folder}/j"), 2, "--journal: is for playing to a target"),
        (("{run}", "--into", "pioneer", "--case", "x"), 2, "has no case 'x'"),
        (("{run}", "--into", "pioner"), 2, "no such bench; did you mean 'pioneer'?"),
        (("{run}", "--into", "pioneer", "--journal", "{run}"), 2, "would overwrite the recording"),
        (("{folder}/no", "--into", "pioneer"), 3, "No such file"),
        (("{run}", "--into", "serial:{folder}/no"), 3, "{folder}/no"),
        (("{folder}/noise", "--into", "pioneer"), 2, "no protocol is known"),
        (("{folder}/car", "--into", "vehicle-model"), 2, "has no line, or several, where one host could be"),
        (("{run}", "--into", "vehicle"), 2, "has no line, or several, where one host could be"),
    ],
)
def test_wrong_usage(recorded, replay, tmp_path, words, code, said):
    for name, data in (("noise", b"hello, world"), ("car", AUTOWARE)):
        journal = Journal(tmp_path / name)
        journal.record("tx", "checker", 0, data=data)
        journal.close()
    found, out, err = replay(*[word.format(run=recorded, folder=tmp_path) for word in words])
    assert (found, out) == (code, "")
    assert said.format(folder=tmp_path) in err
    assert len(err.splitlines()) == 1
