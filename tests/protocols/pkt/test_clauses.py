"""The catalogue of clauses, the profiles they belong to, and the package around them."""

from __future__ import annotations

import protocols.pkt
from protocols.p2os.clauses import CLAUSES as P2OS_CLAUSES
from protocols.pkt import PROFILES, Framing, Profile, Schema
from protocols.pkt.clauses import CLAUSES
from tests.each import each
from tests.protocols.clauses import check_clauses, check_package

NEEDS = {"server", "client", "led", "wheels", "duty", "imu", "gps", "sensed", "boot", "reopen"}
NEEDS |= {"turned", "sky", "carried", "air"}
NEEDS |= {f"client.{name}" for name in ("report", "commands", "disconnect")}
BY_ID = {clause.id: clause for clause in CLAUSES}


def test_catalogue_is_complete():
    numbered = [clause.id for clause in CLAUSES if not clause.id.endswith("D")]
    assert sorted(numbered) == [f"P{n:02}" for n in range(1, 94)]
    assert len(BY_ID) == len(CLAUSES) >= 60
    assert not BY_ID.keys() & {clause.id for clause in P2OS_CLAUSES}
    hosts = {clause.id.rstrip("D") for clause in CLAUSES if clause.suite == "pkt-host"}
    assert hosts == {"P36", "P37", *(f"P{n}" for n in range(50, 60)), "P79"}
    assert {clause.suite for clause in CLAUSES} == {"pkt-board", "pkt-host"}


def test_every_clause_is_whole():
    check_clauses(CLAUSES, NEEDS)
    for clause in CLAUSES:
        assert len({"server", "client"} & set(clause.needs)) == 1, clause.id
        assert {*clause.stand_ins} in (set(), {"server", "motion reports"}), clause.id
        assert clause.profiles, clause.id
        assert set(clause.profiles) <= PROFILES.keys(), clause.id
        assert list(clause.profiles) == [name for name in PROFILES if name in clause.profiles], clause.id


def test_what_was_shipped_broken_was_promised_otherwise():
    for clause in [clause for clause in CLAUSES if clause.twin]:
        twin = BY_ID[clause.twin]
        assert "documented" in twin.profiles, clause.id
        assert "documented" not in clause.profiles, clause.id
        assert not set(twin.profiles) & set(clause.profiles), clause.id
        assert twin.suite == clause.suite, clause.id


def test_every_promise_beside_a_defect_is_named_by_it():
    twins = {clause.twin for clause in CLAUSES if clause.twin}
    assert {clause.id for clause in CLAUSES if clause.id.endswith("D")} - twins == {
        "P04D"
    }  # P04 itself is promised too
    assert len(twins) >= 15


@each("name", ["documented", "term-doc", "g0", "g2"])
def test_a_profile_is_whole(name):
    profile = PROFILES[name]
    assert profile.name == name
    assert profile.text.endswith(".")
    assert profile.server.schema is profile.client.schema
    if not profile.client.split_lines:
        assert profile.client.frames.framing is profile.server.frames.framing
    assert any(name in clause.profiles for clause in CLAUSES)


def test_what_the_profiles_are():
    assert Profile(name="documented", text="x").server == PROFILES["documented"].server
    assert {n: (p.server.frames.framing, p.server.schema) for n, p in PROFILES.items()} == {
        "documented": (Framing.LEN, Schema.V2),
        "term-doc": (Framing.TERM, Schema.V1),
        "g0": (Framing.LEN, Schema.V1),
        "g2": (Framing.LEN, Schema.V2),
    }


def test_the_package_exports_what_it_says_and_brings_nothing_heavy():
    check_package(protocols.pkt)
