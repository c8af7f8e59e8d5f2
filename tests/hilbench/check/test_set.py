"""``check --set KEY=VALUE``: a bench with something else in it than its file says."""

from __future__ import annotations

import json

import pytest

from hilbench.cli import main


def checked(tmp_path, capsys, *words):
    """Run a check; return its code, its report, the first line of its journal, and what it said."""
    report, journal = tmp_path / "report.json", tmp_path / "run.jsonl"
    code = main(["check", "pioneer-plane", "-k", "S01", "-q", "--json", str(report), "--journal", str(journal), *words])
    said = capsys.readouterr()
    return code, json.loads(report.read_bytes()), json.loads(journal.read_text().splitlines()[0]), said.out


def test_the_report_and_the_journal_say_what_was_set(tmp_path, capsys):
    fault = ("--set", "faults.0.kind=drop", "--set", "faults.0.probability=1")
    code, report, header, said = checked(tmp_path, capsys, *fault)
    assert code == 1
    assert header["set"] == ["faults.0.kind=drop", "faults.0.probability=1"]
    assert "--set faults.0.kind=drop --set faults.0.probability=1 --suite" in said
    assert report["clauses"][0]["reproduce"].startswith("hilbench check pioneer-plane --set faults.0.kind=drop")


def test_without_it_nothing_is_said_of_it(tmp_path, capsys):
    code, _, header, _ = checked(tmp_path, capsys)
    assert code == 0
    assert "set" not in header


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("world.scene=nowhere", "--set world.scene=nowhere: no scene 'nowhere'"),
        ("wrold.scene=wall", "--set wrold.scene=wall: unknown key 'wrold'"),
        ("faults.0.kind=drip", "--set faults.0.kind=drip: "),
        ("world", "--set: 'world' is not KEY=VALUE"),
    ],
)
def test_what_is_wrong_is_one_line_with_the_option(text, said, capsys):
    assert main(["check", "pioneer-plane", "--set", text]) == 2
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 1
    assert said in lines[0]


def test_a_recording_has_no_bench_file(capsys):
    assert main(["check", "--target", "capture:run.jsonl", "--set", "seed=1"]) == 2
    assert "--set seed=1: a recording has no bench file" in capsys.readouterr().err
