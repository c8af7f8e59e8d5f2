"""The catalogue of clauses, and the package around it."""

from __future__ import annotations

from collections import Counter

import protocols.p2os
from protocols.p2os.clauses import CLAUSES
from tests.protocols.clauses import check_clauses, check_package

NEEDS = {
    *(
        "server",
        "hangup",
        "reopen",
        "baud",
        "uart",
        "flash",
        "user-io",
        "aux-loopback",
        "truth",
        "scene",
        "rays",
        "contacts",
        "bumpers",
        "gravity",
    ),
    *("client", "client.commands", "client.report", "client.disconnect"),
}


def test_catalogue_is_complete():
    expected = [f"{letter}{n:02}" for letter, last in (("S", 66), ("C", 33), ("M", 24)) for n in range(1, last + 1)]
    expected[66:66] = [f"S{n}" for n in range(80, 95)]
    assert [clause.id for clause in CLAUSES] == expected
    assert Counter(clause.suite for clause in CLAUSES) == {"p2os-server": 81, "p2os-client": 33, "pioneer-motion": 24}


def test_every_clause_is_whole():
    check_clauses(CLAUSES, NEEDS)
    for clause in CLAUSES:
        assert {"server", "client"} & set(clause.needs), clause.id


def test_levels_of_the_server_clauses():
    should = {clause.id for clause in CLAUSES if clause.suite == "p2os-server" and clause.level == "should"}
    assert should == {
        *("S10", "S14", "S17", "S29", "S30", "S31", "S32", "S42", "S43", "S44"),
        *("S46", "S47", "S56", "S57", "S58", "S60", "S63"),
        *("S82", "S83", "S84", "S85", "S86", "S87", "S88", "S91", "S92", "S94"),
    }


def test_the_package_exports_what_it_says_and_brings_nothing_heavy():
    check_package(protocols.p2os)
