"""Boards with a fault that checks once passed are found, as at a port, in virtual time."""

from __future__ import annotations

import pytest

from measure.escapes import BOARDS, served
from measure.gate_proof.copies import ROOT
from measure.mends import MENDS
from measure.right_peers import at_port
from measure.right_peers.__main__ import RIGHT, checked_in_memory
from tests.each import each

FOUND_BY = {
    "rover-never-stops": ("P24D",),
    "rover-half-a-crc": ("P67", "P68"),
    "rover-answers-too-soon": ("P68",),
    "rover-swallows-xon-xoff": ("P71",),
    "rover-refuses-a-byte-too-many": ("P70",),
    "rover-reserved-byte": ("P72",),
    "rover-swapped-crc": ("P01",),
    "robot-no-battery": ("S80",),
    "vehicle-no-emergency-from-manual": ("VB21",),
    "vehicle-one-emergency": ("VB07", "VB21"),
}


def test_each_board_is_looked_for():
    assert {*FOUND_BY} == {*BOARDS}


def found(monkeypatch, name):
    protocol, _ = BOARDS[name]
    monkeypatch.setitem(at_port.PEERS, protocol, served(name))
    verdicts, accused = checked_in_memory(RIGHT[f"script-{protocol}"], seed=0, also=" or ".join(FOUND_BY[name]))
    assert verdicts == {"fail": len(FOUND_BY[name])}, accused


def test_one_emergency_is_not_enough(monkeypatch):
    found(monkeypatch, "vehicle-one-emergency")


@pytest.mark.exhaustive("each wrong board; the gate has one, and a fault of the same kind for each of these clauses")
@each("name", FOUND_BY)
def test_each_is_found_by_each_of_its_clauses(monkeypatch, name):
    found(monkeypatch, name)


@each("name", MENDS)
def test_each_mend_is_there_to_be_taken_out(name):
    for edit in MENDS[name]["edits"]:
        assert (ROOT / edit["file"]).read_text(encoding="utf-8").count(edit["has"]) == 1, edit["file"]
    for test in MENDS[name]["tests"]:
        file, _, function = test.partition("::")
        assert f"def {function.partition('[')[0]}" in (ROOT / file).read_text(encoding="utf-8")
