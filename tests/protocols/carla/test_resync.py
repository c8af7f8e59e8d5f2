"""One stray byte and up to thirty: the board as shipped never recovers, the hardened one within two statuses."""

from __future__ import annotations

import random
from pathlib import Path

import pytest

from measure.resync import __main__ as resync
from measure.resync.measure import BEFORE_NS, FRAME, KINDS, STATUS_NS, drive, status, worst
from protocols.carla import Mode
from tests.each import each

PAGE = Path(__file__).parents[3] / "docs" / "carla" / "resync.md"


@each("profile", ["v0", "v1"])
@each("count", [1, 2, 11, 21, 23, 30])
def test_the_board_as_shipped_never_recovers(profile, count):
    for make in KINDS.values():
        outcome = drive(profile, make(count, random.Random(count)), 4.0)
        assert (outcome.accepted, outcome.lost, outcome.mode) == (0, None, Mode.EMERGENCY)
        assert outcome.emergency_ms == pytest.approx(1000, abs=60)


def test_a_whole_block_too_many_does_not_shift():
    assert drive("v0", b"\0" * FRAME, 2.0).accepted == 40


OTHER = pytest.mark.exhaustive("the gate has the counts about one byte, half a status and a whole one, and the most")
IN_GATE = (1, 2, 11, 21, 22, 23, 30)


@pytest.mark.parametrize(
    "count", [count if count in IN_GATE else pytest.param(count, marks=OTHER) for count in range(1, 31)]
)
def test_the_hardened_board_recovers_within_two_statuses(count):
    outcome = worst("hardened", count, seeds=3, seconds=0.5)
    assert outcome.lost <= 1
    assert (outcome.emergency_ms, outcome.mode) == (None, Mode.AUTOWARE)
    assert outcome.accepted >= outcome.sent - 1


def test_what_it_takes_to_lose_one(monkeypatch):
    """The next status has in its floats the letters that the stray beginning lacks."""
    stray, number = status(3)[:7], BEFORE_NS // STATUS_NS + 1
    crafted = bytearray(status(number))
    crafted[11 - 7], crafted[16 - 7], crafted[21 - 7] = b"CD$"
    monkeypatch.setattr(
        "measure.resync.measure.status", lambda wanted: bytes(crafted) if wanted == number else status(wanted)
    )
    outcome = drive("hardened", stray, 1.0)
    assert (outcome.lost, outcome.mode) == (1, Mode.AUTOWARE)
    assert outcome.accepted == outcome.sent - 1


def test_the_page_says_so():
    rows = [line.strip("| ").split(" | ") for line in PAGE.read_text(encoding="utf-8").splitlines() if line[:3] > "| 0"]
    rows = [row for row in rows if row[0].isdecimal()]
    assert [int(row[0]) for row in rows] == list(resync.COUNTS) == list(range(1, 31))
    assert {int(row[0]) for row in rows if row[1] != "0"} == {FRAME}
    assert {int(row[4]) for row in rows} <= {0, 1}
    assert {row[6] for row in rows} == {"AUTOWARE"}


def test_the_page_is_made_of_what_is_measured():
    text = resync.page([22, 1], seeds=1, long_s=2.0)
    assert text.endswith(
        "| 22 | 40 | none | AUTOWARE | 0 | none | AUTOWARE |\n| 1 | 0 | 990 ms | EMERGENCY | 0 | none | AUTOWARE |\n"
    )
