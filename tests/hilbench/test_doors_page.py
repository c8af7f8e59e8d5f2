"""The same suite through each door: how verdicts are compared, and the page made of them."""

from __future__ import annotations

import itertools
import json

import pytest

from measure.doors.__main__ import DOCS, main
from measure.doors.benches import DOORS
from measure.doors.pages import compared, page
from measure.doors.whole import WHOLE, whole_page

PACE = {"lateness_p50_s": 0.0001, "lateness_p99_s": 0.002, "lateness_max_s": 0.05, "slips": 2, "slipped_s": 0.3}

SERVED = {"factor": 0.98, "p50": 0.1, "p99": 2.0, "max": 300.0, "slips": 4.0}


def row(door, **verdicts):
    return {
        "bench": "rover", "suite": "pkt-board", "door": door, "select": "P01", "bench_time_s": 1.0, "host_time_s": 2.0,
        "pace": None if door == "memory" else PACE, "served": None if door == "memory" else SERVED,
        "verdicts": verdicts, "causes": {"b": "the board was late", "c": "too\nlate"},
    }  # fmt: skip


MEMORY = row("memory", a="pass", b="pass", c="pass", d="fail")
PTY = row("pty", a="pass", b="inconclusive", c="fail", d="fail", e="pass", f="n/a")


def test_verdicts_are_compared_case_by_case():
    assert compared(PTY, MEMORY) == {"same": 2, "inconclusive": 1, "other": 1, "n/a": 2}


def test_a_page_has_a_line_for_each_door_and_says_what_differs():
    lines = page([MEMORY, PTY]).splitlines()
    assert '| rover | pkt-board | `-k "P01"` | memory | 4 | 0 | 0 | virtual time | - |' in lines
    assert (
        '| rover | pkt-board | `-k "P01"` | pty | 2 | 1 | 1 | 0.10, 2.00, 50.00; 2 | 0.980; 0.10, 2.00, 300.00; 4 |'
        in lines
    )
    wrong, unclear = lines.index("### Other verdicts than in memory"), lines.index("### Inconclusive")
    assert lines[wrong + 2] == "- rover, pty: `c` fail, in memory pass: too late"
    assert lines[unclear + 2] == "- rover, pty: `b` inconclusive, in memory pass: the board was late"
    assert "###" not in page([MEMORY])
    assert "| pty |" not in page([PTY])


def whole(door, run_hash="aaaaaaaaaaaaaaaa", **not_passed):
    passed = 3 - len(not_passed)
    return {
        "bench": "rover", "door": door, "exit": 0, "run_hash": run_hash, "bench_time_s": 60.0, "host_time_s": 7.0,
        "counts": {"pkt-board": {"pass": passed, **dict.fromkeys(not_passed.values(), 1)}},
        "not_passed": {f"pkt-board/{case}": verdict for case, verdict in not_passed.items()},
    }  # fmt: skip


def test_whole_suites_have_a_cell_for_each_door():
    text = whole_page([whole("memory", a="fail"), whole("pty", a="fail"), whole("tcp", "bbbbbbbbbbbbbbbb")])
    assert "| rover | pkt-board | 3 | 1 fail, 2 pass | 3 | 2, other: pkt-board/a | - | - |" in text
    assert "| rover | aaaaaaaaaaaa | 60 s | 7 s | same, 7 s | **bbbbbbbbbbbb**, 7 s | - | - |" in text
    assert whole_page([whole("pty")]) == ""


def test_each_bench_has_been_checked_whole_through_each_door():
    rows = json.loads((DOCS / "doors-whole.json").read_text())
    assert {(row["bench"], row["door"]) for row in rows} == set(itertools.product(WHOLE, DOORS))


@pytest.mark.exhaustive("whole suites through a door; the gate has one case through each (through/test_through.py)")
def test_a_whole_check_through_a_door_is_that_in_memory(tmp_path, capfd):
    words = ["--whole", "--bench", "rover-model", "--door", "memory", "--door", "tcp", "--docs", str(tmp_path)]
    assert main(words) == 0
    assert "| rover-model | pkt-host | 22 | 22 pass | - | 22 | - | - |" in (tmp_path / "doors-verdicts.md").read_text()
    capfd.readouterr()


def test_the_page_is_made_of_its_record():
    record = json.loads((DOCS / "doors-verdicts.json").read_text())
    whole = json.loads((DOCS / "doors-whole.json").read_text())
    assert page(record, whole_page(whole)) == (DOCS / "doors-verdicts.md").read_text()


@pytest.mark.exhaustive("a case in real time through a door; the gate has such cases in virtual time (through/)")
def test_a_case_through_a_door_says_what_it_says_in_memory(tmp_path, capfd):
    words = ["--bench", "rover-model", "-k", "P01", "--door", "memory", "--door", "rfc2217", "--docs", str(tmp_path)]
    assert main(words) == 0
    rows = json.loads((tmp_path / "doors-verdicts.json").read_text())
    assert [one["door"] for one in rows] == ["memory", "rfc2217"]
    assert compared(rows[1], rows[0])["other"] == 0
    assert set(compared(rows[1], rows[0])) & {"same", "inconclusive"}
    before = (tmp_path / "doors-verdicts.md").read_text()
    assert main(["--pages", "--docs", str(tmp_path)]) == 0
    assert (tmp_path / "doors-verdicts.md").read_text() == before
    capfd.readouterr()
