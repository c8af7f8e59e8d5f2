"""The same suite through each door: how verdicts are compared, and the page made of them."""

from __future__ import annotations

import json

import pytest

from tests.doors.__main__ import DOCS, main
from tests.doors.pages import compared, page

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
    wrong, unclear = lines.index("## Other verdicts than in memory"), lines.index("## Inconclusive")
    assert lines[wrong + 2] == "- rover, pty: `c` fail, in memory pass: too late"
    assert lines[unclear + 2] == "- rover, pty: `b` inconclusive, in memory pass: the board was late"
    assert "##" not in page([MEMORY])
    assert "| pty |" not in page([PTY])


def test_the_page_is_made_of_its_record():
    record = json.loads((DOCS / "doors-verdicts.json").read_text())
    assert page(record) == (DOCS / "doors-verdicts.md").read_text()


@pytest.mark.thorough
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
