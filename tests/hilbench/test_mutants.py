"""The mutants: their data, their faults on vectors, and that a few of them are found out where they should be."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterable
from pathlib import Path

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hilbench.check import CheckOptions, run_suites
from hilbench.check.bench_provider import make_provider
from hilbench.clock import NS_PER_S, Scheduler
from hilbench.judging.verdicts import Verdict
from hilbench.links import Line, MemoryLink
from measure.mutants import farm
from measure.mutants.bench import FaultyBody, fault, run_mutant
from measure.mutants.catalogue import all_mutants, mutants_of
from measure.mutants.each_its_own import Verdicts, judge, one_for_each
from measure.mutants.late import BLAMED, AtPort, late_benches
from measure.mutants.mutant import BodyFault, Family, Mutant
from measure.mutants.pages import _ranges, killing_nothing, page, unexplained
from measure.mutants.record import Entry, Record, merged, save
from measure.mutants.wire import (
    Become,
    Before,
    Bits,
    Checksum,
    Count,
    Cut,
    Drop,
    FillSip,
    Late,
    Leave,
    Lose,
    Match,
    Mend,
    MendIn,
    Noise,
    OnceMoreEachSession,
    Pad,
    Put,
    Rule,
    Sonars,
    Stick,
    Swallow,
    Swap,
    Tap,
    Then,
    Twice,
    Way,
    Word,
)
from protocols.p2os import CLIENT_TABLE, SERVER_TABLE, DropReason, Sip, SonarReading, checksum, encode_frame
from protocols.p2os.clauses import CLAUSES
from tests.each import each

SYNC0, SYNC1 = bytes.fromhex("FAFB03000000"), bytes.fromhex("FAFB03010001")
VEL_200, VEL_MINUS_200 = bytes.fromhex("FAFB060B3BC800D33B"), bytes.fromhex("FAFB060B1BC800D31B")
SIP = encode_frame(
    Sip(
        x_raw=1190,
        th_raw=-512,
        left_raw=200,
        right_raw=-50,
        stall_rear=1,
        flags=3,
        sonars=(SonarReading(number=0, range_raw=1000), SonarReading(number=5, range_raw=3731)),
    ).encode()
)
MUTANTS = all_mutants()


def after(operation, raw: bytes, memory=None) -> bytes:
    return operation.apply(raw, {} if memory is None else memory).data


def sip_after(operation) -> Sip:
    raw = after(operation, SIP)
    assert int.from_bytes(raw[-2:], "big") == checksum(raw[3:-2])
    return Sip.decode(raw[3:-2])


# --- the data


def test_each_mutant_has_its_own_name_and_fault() -> None:
    assert len({mutant.id for mutant in MUTANTS}) == len(MUTANTS)
    assert all(
        mutant.settings
        or mutant.server_options
        or mutant.client_options
        or mutant.edges
        or mutant.mute
        or mutant.wire
        or mutant.body
        for mutant in MUTANTS
    )


@each(("family", "least"), [(Family.SERVER_HAND, 25), (Family.CLIENT_HAND, 12), (Family.MOTION_HAND, 10)])
def test_enough_are_made_by_hand(family: Family, least: int) -> None:
    assert len(mutants_of((family,))) >= least


@each(("family", "table"), [(Family.SERVER_TABLE, SERVER_TABLE), (Family.CLIENT_TABLE, CLIENT_TABLE)])
def test_each_table_is_wrong_in_one_cell_and_made_once(family: Family, table) -> None:
    tables = [dict(mutant.mutate(table)) for mutant in mutants_of((family,))]
    for mutated in tables:
        assert sum(mutated.get(cell) != edge for cell, edge in table.items()) == 1
    assert len({frozenset(mutated.items()) for mutated in tables}) == len(tables)


@each(("family", "table"), [(Family.SERVER_TABLE, SERVER_TABLE), (Family.CLIENT_TABLE, CLIENT_TABLE)])
def test_each_edge_is_removed_once(family: Family, table) -> None:
    removed = {mutant.edges[0] for mutant in mutants_of((family,)) if mutant.edges[0].becomes is None}
    assert {(edge.state, edge.trigger) for edge in removed} == set(table)


def test_an_unknown_name_is_refused() -> None:
    with pytest.raises(KeyError):
        mutants_of(ids=("no-such-mutant",))


# --- faults on vectors


@each(
    ("operation", "raw", "expected"),
    [
        (Drop(), SYNC0, b""),
        (Become(b"\1"), SYNC0, SYNC1),
        (Then(b"\1"), SYNC0, SYNC0 + SYNC1),
        (Before(b"\1"), SYNC0, SYNC1 + SYNC0),
        (Twice(), SYNC0, SYNC0 + SYNC0),
        (Put(4, b"\x3b"), VEL_MINUS_200, VEL_200),
        (Bits(offset=4, turn=0x20), VEL_200, VEL_MINUS_200),
        (Word(offset=5, times=0.5), VEL_200, encode_frame(bytes.fromhex("0B3B6400"))),
        (Word(offset=5, plus=2), VEL_200, encode_frame(bytes.fromhex("0B3BCA00"))),
        (Swap(5, 6), VEL_200, encode_frame(bytes.fromhex("0B3B00C8"))),
        (Cut(1), VEL_200, encode_frame(b"\x0b")),
        (Cut(-1), VEL_200, encode_frame(bytes.fromhex("0B3BC8"))),
        (Pad(b"\0"), SYNC0, bytes.fromhex("FAFB0400000000")),
        (Leave(5), VEL_200, encode_frame(bytes.fromhex("0B3B00"))),
        (Count(1), SYNC0, bytes.fromhex("FAFB04000000")),
        (Checksum(1), SYNC0, bytes.fromhex("FAFB03000001")),
        (Noise(b"\xfa"), SYNC0, b"\xfa" + SYNC0),
        (Mend(), bytes.fromhex("FAFB03010000"), SYNC1),
        (Mend(swapped=True), bytes.fromhex("FAFB03010100"), SYNC1),
        (Mend(swapped=True), bytes.fromhex("FAFB03010000"), bytes.fromhex("FAFB03010000")),
        (Mend(), b"\x13\x37", b"\x13\x37"),
        (MendIn(0xFFFE), bytes.fromhex("FAFB03010000"), SYNC1),
        (MendIn(0x0001), bytes.fromhex("FAFB03010000"), bytes.fromhex("FAFB03010000")),
        (Lose(b"\x01"), SYNC1, bytes.fromhex("FAFB0300")),
    ],
)
def test_what_an_operation_makes_of_a_frame(operation, raw: bytes, expected: bytes) -> None:
    assert after(operation, raw) == expected


def test_late_and_swallow_change_no_byte() -> None:
    assert Late(0.3).apply(SYNC0, {}).data == SYNC0
    assert Late(0.3).apply(SYNC0, {}).late_s == 0.3
    assert Swallow(2).apply(SYNC0, {}).data == SYNC0
    assert Swallow(2).apply(SYNC0, {}).swallow == 2


def test_a_sip_is_said_once_more_in_each_session() -> None:
    memory: dict = {}
    identification = encode_frame(b"\2\0\0\0")
    for session in (1, 2, 3):
        assert after(OnceMoreEachSession(), identification, memory) == identification
        assert after(OnceMoreEachSession(), SIP, memory) == SIP * session


def test_faults_in_a_sip() -> None:
    assert sip_after(Word(offset=8, signed=True, times=-1)).th_raw == 512
    assert sip_after(Word(offset=8, signed=True, modulo=4096)).th_raw == 4096 - 512
    assert sip_after(Word(offset=4, times=-1, modulo=0x8000)).x_raw == 0x8000 - 1190
    assert sip_after(Word(offset=4, plus=7, least=2000)).x_raw == 1190
    assert sip_after(Bits(offset=15, clear=1)).stall_rear == 0
    assert sip_after(Bits(offset=16, set=1)).stall_front == 1
    assert sip_after(Swap(10, 12, 2)).left_raw == -50
    assert sip_after(Put(-3, b"\xff")).digout == 0xFF
    assert [reading.number for reading in sip_after(Sonars(plus=1)).sonars] == [1, 6]
    assert [reading.range_raw for reading in sip_after(Sonars(times=2)).sonars] == [2000, 7462]
    assert len(sip_after(Sonars(copies=10)).sonars) == 20
    assert not sip_after(Sonars(keep=0)).sonars


def test_a_sip_too_short_is_filled() -> None:
    body = bytearray(SIP[3:-2])
    body[19] = 4
    filled = Sip.decode(after(FillSip(), encode_frame(bytes(body)))[3:-2])
    assert len(filled.sonars) == 4


def test_a_stuck_field_repeats_its_first_value() -> None:
    memory: dict = {}
    after(Stick(5, 2), VEL_200, memory)
    assert after(Stick(5, 2), encode_frame(bytes.fromhex("0B3B6400")), memory) == VEL_200


@each(
    ("match", "raw", "fits"),
    [
        (Match(), SYNC0, True),
        (Match(numbers=frozenset({11})), VEL_200, True),
        (Match(numbers=frozenset({11})), SYNC0, False),
        (Match(at={4: 0x1B}), VEL_MINUS_200, True),
        (Match(at={4: 0x1B}), VEL_200, False),
        (Match(at={4: 0x00}), SYNC0, False),
        (Match(body=1), SYNC0, True),
        (Match(body=1), VEL_200, False),
        (Match(longer=1), VEL_200, True),
        (Match(longer=1), SYNC0, False),
        (Match(shorter=4), VEL_200, False),
        (Match(ends=b"\xfa"), b"\x00\xfa", True),
        (Match(), b"\xfa", True),
        (Match(within_s=0.05), SYNC0, False),
        (Match(more_than_sip=True), SIP, False),
        (Match(more_than_sip=True), encode_frame(SIP[3:-2] + b"\0"), True),
        (Match(less_than_sip=True), encode_frame(SIP[3:-4]), True),
        (Match(whole_sip=True), encode_frame(SIP[3:-4]), False),
        (Match(whole_sip=True), encode_frame(SIP[3:-2] + b"\0"), True),
    ],
)
def test_which_frames_match(match: Match, raw: bytes, fits: bool) -> None:
    assert match.fits(raw, since_s=1.0) is fits


# --- the tap


def through(rules: tuple[Rule, ...], *pieces: bytes) -> bytes:
    """Return what a device behind the tap is told when these pieces come, each after the one before."""
    scheduler = Scheduler()
    link = MemoryLink(scheduler, Line(baud=0), name="line")
    heard = bytearray()
    tap = Tap(scheduler, link.b, rules, 200)
    tap.on_receive = lambda data, _at_ns: heard.extend(data)
    for piece in pieces:
        link.a.write(piece)
        scheduler.run_until(None, scheduler.now_ns + NS_PER_S)
    return bytes(heard)


def test_a_rule_counts_its_turns() -> None:
    every_second = Rule(Way.IN, Match(numbers=frozenset({1}), every=2), Drop())
    assert through((every_second,), SYNC1, SYNC0, SYNC1, SYNC1) == SYNC1 + SYNC0 + SYNC1


def test_the_other_direction_is_left_alone() -> None:
    assert through((Rule(Way.OUT, Match(), Drop()),), SYNC0, b"\x13") == SYNC0 + b"\x13"


def test_swallow_loses_the_next_frame_only() -> None:
    rule = Rule(Way.IN, Match(numbers=frozenset({1})), Swallow())
    assert through((rule,), SYNC1, SYNC0, SYNC0) == SYNC1 + SYNC0


def test_rules_for_dropped_bytes_see_those_only() -> None:
    rule = Rule(Way.IN, Match(dropped=DropReason.BAD_CHECKSUM), Mend())
    assert through((rule,), bytes.fromhex("FAFB03010000"), SYNC0) == SYNC1 + SYNC0


@given(
    st.lists(st.sampled_from([SYNC0, VEL_200, SIP, b"\x13\x37", b"\xfa", bytes.fromhex("FAFB03000001")]), max_size=8)
)
def test_a_tap_that_does_nothing_loses_nothing(parts: list[bytes]) -> None:
    stream = b"".join(parts) + SYNC0
    assert through((Rule(Way.IN, Match(), Late(0.0)),), stream) == stream


# --- the body


class Still:
    """A body that stands and hears disc 2 at 1 m."""

    def __init__(self) -> None:
        self.speeds = (0.0, 0.0)
        self.released = False

    def command_wheels(self, left_rad_s: float, right_rad_s: float) -> None:
        self.speeds = left_rad_s, right_rad_s

    def release_wheels(self) -> None:
        self.released = True

    def wheel_angles_rad(self) -> tuple[float, float]:
        return 2.0, 2.0

    def motor_loads(self) -> tuple[float, float]:
        return 0.5, 0.5

    def bumpers(self) -> tuple[int, int]:
        return 0b00001, 0b00110

    def sonar_range_m(self, number: int) -> float | None:
        return 1.0 if number == 2 else None


def test_faults_of_the_body() -> None:
    body = Still()
    FaultyBody(body, BodyFault(wheel_scale=(1.0, 0.5))).command_wheels(4.0, 4.0)
    assert body.speeds == (4.0, 2.0)
    assert FaultyBody(body, BodyFault(wheel_scale=(1.0, 0.5))).wheel_angles_rad() == (2.0, 4.0)
    FaultyBody(body, BodyFault(top_rad_s=3.0)).command_wheels(4.0, -4.0)
    assert body.speeds == (3.0, -3.0)
    FaultyBody(body, BodyFault(never_released=True)).release_wheels()
    assert not body.released
    assert FaultyBody(body, BodyFault(motor_load=0.0)).motor_loads() == (0.0, 0.0)
    assert FaultyBody(body, BodyFault(bumpers_mirrored=True)).bumpers() == (0b10000, 0b01100)
    assert FaultyBody(body, BodyFault(bumpers_swapped=True)).bumpers() == (0b00110, 0b00001)
    assert FaultyBody(body, BodyFault(sonar_scale=2.0)).sonar_range_m(2) == 2.0
    assert FaultyBody(body, BodyFault(sonar_shift_m=0.25)).sonar_range_m(2) == 1.25
    assert FaultyBody(body, BodyFault(sonar_mirrored=True)).sonar_range_m(5) == 1.0
    assert FaultyBody(body, BodyFault(sonar_deaf=frozenset({2}))).sonar_range_m(2) is None


def test_a_body_without_a_fault_is_itself() -> None:
    body, faultless = Still(), FaultyBody(Still(), BodyFault())
    assert faultless.wheel_angles_rad() == body.wheel_angles_rad()
    assert faultless.motor_loads() == body.motor_loads()
    assert faultless.bumpers() == body.bumpers()
    assert [faultless.sonar_range_m(number) for number in range(8)] == [
        body.sonar_range_m(number) for number in range(8)
    ]


# --- found out, or not


RECORDED = msgspec.json.decode((Path(__file__).parents[2] / "docs" / "mutants.json").read_bytes(), type=Record)
SUITES = ("p2os-server", "p2os-client", "pioneer-motion")


def found_in(suite: str) -> dict[str, list[str]]:
    """By mutant, the clauses of a suite that find it, as the page says."""
    by_id = {mutant.id: mutant for mutant in MUTANTS if suite in mutant.family.suites}
    entries = {id_: entry.verdicts for id_, entry in RECORDED.mutants.items() if id_ in by_id}
    return {id_: [one for one, said in verdicts.items() if said is Verdict.FAIL] for id_, verdicts in entries.items()}


def looked_for(
    suite: str, pairs: Iterable[tuple[str, str]], *, motion: bool = False, until_found: bool = False
) -> Verdicts:
    """What comes of mutants, each before a clause."""
    by_id = {mutant.id: mutant for mutant in MUTANTS}
    faults = [fault(by_id[id_], clause_id, motion=motion) for clause_id, id_ in pairs]
    options = CheckOptions(bench="pioneer", suites=(suite,))
    return judge(options, make_provider(options), faults, until_found=until_found)


@pytest.mark.slow("each clause of P2OS and of motion and a mutant that it has to find")
@pytest.mark.needs_physics
@pytest.mark.parametrize("suite", SUITES)
def test_each_clause_finds_a_mutant(suite: str) -> None:
    clause_ids = [clause.id for clause in CLAUSES if clause.suite == suite]
    # Of a robot a case that finds nothing takes longer than the others that find it at once.
    one_by_one = suite != "p2os-server"
    verdicts = looked_for(suite, one_for_each(clause_ids, found_in(suite)), until_found=one_by_one)
    assert verdicts.not_found == {}
    assert verdicts.found_by == {*clause_ids}


ON_LATE_BENCHES = pytest.mark.exhaustive("each clause and a mutant once more; the gate has those of a client")
OF_TIME = {"p2os-server": {"S05", "S22", "S38", "S57"}, "p2os-client": {"C18"}, "pioneer-motion": {"M04"}}
"""By suite what is about times, or ramps in time, that 100 ms blur, or looks for a client that waits too long."""


@pytest.mark.slow("each clause of a client and a mutant that it has to find, on a bench that is late")
@pytest.mark.needs_physics
@pytest.mark.parametrize(
    "suite", [pytest.param(one, marks=ON_LATE_BENCHES) for one in SUITES if one != "p2os-client"] + ["p2os-client"]
)
def test_on_a_late_bench_the_other_clauses_find_it_too(suite: str) -> None:
    clause_ids = [clause.id for clause in CLAUSES if clause.suite == suite]
    with late_benches(0.1):
        verdicts = looked_for(suite, one_for_each(clause_ids, found_in(suite)))
    assert verdicts.open_clauses == OF_TIME[suite]


@pytest.mark.slow("what a port shows of a right client, on a bench that is late")
@pytest.mark.needs_physics
@pytest.mark.parametrize(
    ("suite", "select"),
    [
        pytest.param(
            *("p2os-server", "not (S18 or S31 or S52 or S53)"),
            marks=pytest.mark.exhaustive("a robot, which takes five times as long; the gate has a client"),
        ),
        ("p2os-client", ""),
    ],
    ids=["p2os-server", "p2os-client"],
)
def test_on_a_late_bench_nobody_right_is_accused(suite: str, select: str) -> None:
    """But for what takes ten seconds and more."""
    options = CheckOptions(bench="pioneer", suites=(suite,), select=select)
    with late_benches(0.1):
        cases = run_suites(options, AtPort(make_provider(options))).cases
    assert {case.id: case.cause for case in cases if case.verdict in BLAMED} == {}


@pytest.mark.exhaustive("each mutant that is found, by a clause that few find it by; the gate has one for each clause")
@pytest.mark.needs_physics
@pytest.mark.parametrize("suite", SUITES)
def test_each_mutant_is_found(suite: str) -> None:
    found = found_in(suite)
    finds = Counter(clause for clauses in found.values() for clause in clauses)
    pairs = [(min(clauses, key=finds.__getitem__), id_) for id_, clauses in found.items() if clauses]
    assert looked_for(suite, pairs, motion=suite == "pioneer-motion").not_found == {}


@each(("family", "select"), [(Family.SERVER_HAND, "S01 or S09"), (Family.CLIENT_HAND, "C02 or C24")])
@each("wire", [(), (Rule(Way.IN, Match(), Late(0.0)), Rule(Way.OUT, Match(), Late(0.0)))])
def test_the_right_device_passes_through_the_same_harness(family: Family, select: str, wire: tuple[Rule, ...]) -> None:
    right = Mutant(id="right", family=family, what="nothing", wire=wire)
    report = run_mutant(right, family, select=select)
    assert {clause.verdict for clause in report.clauses} == {Verdict.PASS}


def test_a_mutant_that_dies_does_not_take_the_others_with_it(monkeypatch) -> None:
    first, second = mutants_of(ids=("echo0-wrong", "echo-twice"))

    def examine(mutant: Mutant) -> farm.Found:
        if mutant is first:
            os._exit(3)
        return farm.Found(mutant=mutant, verdicts={"S12": Verdict.FAIL}, cause="twice")

    monkeypatch.setattr(farm, "examine", examine)
    died, found = farm.examine_all([first, second], 2, lambda *_: None)
    assert died.hung
    assert died.killed
    assert found.killers == ["S12"]


# --- the page


def entry(**values) -> Entry:
    return Entry(family="server-hand", what="something", **{"verdicts": {}} | values)


RECORD = Record(
    format="hilbench-mutants/1",
    clauses={"S01": "must", "S02": "must", "S10": "should"},
    mutants={
        "found": entry(verdicts={"S01": Verdict.FAIL}),
        "doubtful": entry(verdicts={"S02": Verdict.INCONCLUSIVE}),
        "same": entry(survives="equivalent: so it is"),
    },
)


def test_the_page_tells_who_survives_and_which_clause_finds_nothing() -> None:
    assert unexplained(RECORD) == ["doubtful"]
    assert killing_nothing(RECORD, "must") == ["S02"]
    assert killing_nothing(RECORD, "should") == ["S10"]
    text = page(RECORD)
    assert "level *must* that find no mutant: S02." in text
    assert "| **All** | 3 | 1 | 1 | 1 | 1 | 0 | 50.0% | 50.0% |" in text


def test_clauses_in_a_row_are_written_short() -> None:
    assert _ranges(["S01", "S03", "S04", "S05", "S08", "S09"]) == "S01, S03-S05, S08, S09"


def test_a_run_of_a_part_keeps_the_rest(tmp_path) -> None:
    first, second = mutants_of(ids=("echo0-wrong", "echo-twice"))
    path = tmp_path / "mutants.json"
    save(merged(path, [farm.Found(mutant=first, verdicts={"S01": Verdict.FAIL})]), path)
    both = merged(path, [farm.Found(mutant=second, verdicts={"S12": Verdict.ERROR})])
    killers = {id_: kept.killers for id_, kept in both.mutants.items()}
    assert killers == {"echo0-wrong": ["S01"], "echo-twice": ["S12"]}
