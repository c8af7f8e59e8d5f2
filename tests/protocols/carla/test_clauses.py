"""The catalogue of clauses, the profiles they belong to, and the package around them."""

from __future__ import annotations

import pytest

import protocols.carla
from protocols.carla import PROFILES, QUIRKS, LocalProtocolError, with_quirks
from protocols.carla.clauses import CLAUSES
from protocols.p2os.clauses import CLAUSES as P2OS_CLAUSES
from protocols.pkt.clauses import CLAUSES as PKT_CLAUSES
from tests.each import each
from tests.protocols.clauses import check_clauses, check_package

NEEDS = {
    "board",
    "simulator",
    "stack",
    "joystick",
    "lamps",
    "indicators",
    "boot",
    "line errors",
    "hang",
    "car",
    "read errors",
}
BY_ID = {clause.id: clause for clause in CLAUSES}


def test_catalogue_is_complete():
    numbered = {clause.id for clause in CLAUSES if not clause.id.endswith("H")}
    assert numbered == {f"VB{n:02}" for n in range(1, 65)} | {f"VS{n:02}" for n in range(1, 30)}
    assert len(BY_ID) == len(CLAUSES) >= 100
    assert not BY_ID.keys() & {clause.id for clause in (*P2OS_CLAUSES, *PKT_CLAUSES)}
    assert {clause.id[:2] for clause in CLAUSES if clause.suite == "vehicle-board"} == {"VB"}
    assert {clause.id[:2] for clause in CLAUSES if clause.suite == "vehicle-host"} == {"VS"}
    assert {clause.suite for clause in CLAUSES} == {"vehicle-board", "vehicle-host"}


def test_every_clause_is_whole():
    check_clauses(CLAUSES, NEEDS)
    for clause in CLAUSES:
        assert {"VB": "board", "VS": "simulator"}[clause.id[:2]] in clause.needs, clause.id
        assert clause.profiles, clause.id
        assert list(clause.profiles) == [name for name in PROFILES if name in clause.profiles], clause.id


def test_beside_each_hazard_stands_what_is_asked_instead():
    for clause in [clause for clause in CLAUSES if clause.twin]:
        twin = BY_ID[clause.twin]
        assert "hardened" in twin.profiles, clause.id
        assert "hardened" not in clause.profiles, clause.id
        assert not set(twin.profiles) & set(clause.profiles), clause.id
        assert twin.suite == clause.suite, clause.id


def test_every_clause_of_the_hardened_alone_is_somebodys_twin():
    twins = {clause.twin for clause in CLAUSES if clause.twin}
    assert {clause.id for clause in CLAUSES if clause.id.endswith("H")} == twins - {"VB19"}
    assert {clause.id for clause in CLAUSES if clause.profiles == ("hardened",)} - twins == {
        *("VB43", "VB47", "VB60", "VB62", "VB63")
    }


@each("name", ["hardened", "v0", "v1"])
def test_a_profile_is_whole(name):
    profile = PROFILES[name]
    assert profile.name == name
    assert profile.text.endswith(".")
    assert any(name in clause.profiles for clause in CLAUSES)


def test_what_is_between_the_profiles():
    v0, v1 = PROFILES["v0"], PROFILES["v1"]
    assert v0.simulator == v1.simulator
    changed = {name for name in v0.board.__dataclass_fields__ if getattr(v0.board, name) != getattr(v1.board, name)}
    assert changed == {"flag_clash", "emergency_report"}


@each("quirk", QUIRKS.values())
def test_a_quirk_is_what_the_hardened_profile_does_not(quirk):
    made = with_quirks(PROFILES["hardened"], [quirk.name])
    assert made != PROFILES["hardened"]
    for options, values in ((made.board, quirk.board), (made.simulator, quirk.simulator)):
        assert {name: getattr(options, name) for name in values} == dict(values)


def test_all_hazards_have_a_quirk():
    assert {f"H{n}" for n in range(1, 10)} | {"V1"} <= QUIRKS.keys()
    with pytest.raises(LocalProtocolError, match="no quirk 'H10'; there are H1, H2"):
        with_quirks(PROFILES["v0"], ["H10"])


def test_the_package_exports_what_it_says_and_brings_nothing_heavy():
    check_package(protocols.carla)
