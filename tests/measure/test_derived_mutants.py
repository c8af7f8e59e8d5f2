"""Mutants derived from a protocol's own record: fields found by trying, faults on real frames, the relay, the runs."""

from __future__ import annotations

import struct
from dataclasses import fields, replace
from pathlib import Path

import pytest

from hilbench.clock import NS_PER_MS, NS_PER_S, Scheduler
from hilbench.judging.verdicts import Verdict
from hilbench.links import Line, MemoryLink
from hilbench.systems.pioneer.protocol import P2OS
from hilbench.systems.rover.protocol import PKT
from hilbench.systems.vehicle.protocol import CARLA
from measure.mutants.derived import __main__ as program
from measure.mutants.derived.book import Book, Entry, drawn
from measure.mutants.derived.fields import Number, Place, Reading
from measure.mutants.derived.mutant import EARLY, EVERY, LATE_S, Acting, Fault, Group, Mutant, bent, changed, faults_of
from measure.mutants.derived.page import page
from measure.mutants.derived.reasons import EQUIVALENT, hidden, reason
from measure.mutants.derived.relay import Relay
from measure.mutants.derived.subjects import SUBJECTS
from measure.mutants.derived.tape import CaseTape, Tape, derive, touched
from measure.mutants.derived.trial import Outcome, tried
from measure.mutants.side_by_side import Lost, side_by_side
from measure.mutants.wire import Way
from protocols import carla
from protocols.p2os import Sip, SonarReading, encode_frame
from protocols.pkt import GeneralReport, MotionReport, MotorThrottles, Schema
from protocols.pkt.commands import encode_command
from protocols.pkt.framing import encode_frame as pkt_frame
from protocols.pkt.reports import encode_report
from tests.each import each

SAID, HEARD = Reading(PKT, "target"), Reading(PKT, "host")
LITTLE = Number(order="little")


def general(accepted: int, rejected: int = 0) -> bytes:
    report = GeneralReport(accepted=accepted, rejected=rejected, last_opcode=3, last_error=0, status=1)
    return pkt_frame(encode_report(report, Schema.V2))


def throttles(a: float, b: float = -0.25) -> bytes:
    return pkt_frame(encode_command(MotorThrottles(a=a, b=b), Schema.V2))


def sip(x_raw: int) -> bytes:
    said = Sip(
        x_raw=x_raw,
        y_raw=3,
        th_raw=-512,
        left_raw=200,
        right_raw=-50,
        battery_dv=120,
        stall_rear=1,
        stall_front=2,
        control_raw=7,
        flags=259,
        compass_raw=9,
        sonars=(SonarReading(number=0, range_raw=1000),),
        analog=11,
        digin=12,
        digout=13,
    )
    return encode_frame(said.encode())


def named(places: list[Place]) -> dict[str, tuple[int, int, Number | None]]:
    return {place.name: (place.start, place.size, place.number) for place in places}


# --- fields, by trying


def test_fields_of_pkt_are_found_with_their_numbers():
    places = named(HEARD.places([throttles(0.5)]))
    assert places["sync word"] == (0, 4, None)
    assert places["a"] == (6, 4, Number(order="little", real=True))
    assert places["b"] == (10, 4, Number(order="little", real=True))
    assert places["flags"] == (14, 1, Number(order="big"))
    assert "CRC" not in places


def test_a_byte_that_one_frame_does_not_tell_the_field_of_is_called_as_in_another():
    assert named(HEARD.places([throttles(0.0), throttles(0.3)]))["a"][:2] == (6, 4)


def test_several_numbers_are_a_field_each():
    report = MotionReport(rpm=(1.0, 2.0, 3.0, 4.0), setpoints_rpm=(1.0, 2.0))
    places = named(SAID.places([pkt_frame(encode_report(report, Schema.V2))]))
    assert [places[f"rpm[{wheel}]"] for wheel in range(4)] == [
        (start, 4, Number(order="little", real=True)) for start in (9, 13, 17, 21)
    ]
    assert [places[f"ticks[{wheel}]"][1] for wheel in range(4)] == [4] * 4


def test_fields_of_p2os_are_found_with_sign_and_byte_order():
    places = named(Reading(P2OS, "target").places([sip(1190)]))
    assert places["th_raw"] == (8, 2, Number(order="little", signed=True))
    assert places["left_raw"] == (10, 2, Number(order="little", signed=True))
    assert "checksum" not in places


def test_fields_of_carla_are_found():
    places = named(Reading(CARLA, "host").places([car(1.5)]))
    real = Number(order="little", real=True)
    assert [place for place in places.values() if place[2] == real] == [
        place for place in places.values() if place[1] == 4
    ]


# --- one field


@each(
    ("fault", "data", "number", "expected"),
    [
        (Fault.PLUS, b"\xff\x00", LITTLE, b"\x00\x01"),
        (Fault.MINUS, b"\x00\x00", LITTLE, b"\xff\xff"),
        (Fault.PLUS, b"\x00\xff", Number(order="big"), b"\x01\x00"),
        (Fault.SIGN, b"\x02\x00", Number(order="little", signed=True), b"\xfe\xff"),
        (Fault.SIGN, struct.pack("<f", 1.5), Number(order="little", real=True), struct.pack("<f", -1.5)),
        (Fault.PLUS, struct.pack(">d", 1.5), Number(order="big", real=True), struct.pack(">d", 2.5)),
        (Fault.ORDER, b"\x01\x02", LITTLE, b"\x02\x01"),
        (Fault.STUCK, b"\x01\x02", LITTLE, b"\x09\x09"),
        (Fault.STALE, b"\x01\x02", LITTLE, b"\x07\x07"),
    ],
)
def test_a_field_is_changed_and_nothing_else(fault, data, number, expected):
    place = Place(name="x", start=1, size=len(data), number=number)
    raw = b"<" + data + b">"
    assert changed(fault, raw, (place,), b"\x07" * 2, b"\x09" * 2) == b"<" + expected + b">"


def test_neighbours_are_exchanged():
    one, other = Place(name="x", start=0, size=2), Place(name="y", start=2, size=2)
    assert changed(Fault.NEIGHBOUR, b"abcd", (one, other), None, b"") == b"cdab"


def test_a_number_too_large_for_its_bytes_stays():
    place = Place(name="x", start=0, size=4, number=Number(order="little", real=True))
    most = struct.pack("<f", 3.4028234663852886e38)
    assert changed(Fault.PLUS, most, (place,), None, b"") == most


# --- the checksum


@each(
    ("reading", "raw"),
    [
        (SAID, general(3)),
        (HEARD, throttles(0.5)),
        (Reading(P2OS, "target"), sip(7)),
        (Reading(P2OS, "host"), bytes.fromhex("FAFB060B3BC800D33B")),
    ],
)
def test_a_rule_mends_a_frame_and_no_bent_one_makes_the_same(reading, raw):
    rule = reading.checksum
    assert rule.mended(raw) == raw
    assert rule.mended(rule.put(raw, b"\0\0")) == raw
    for fault in faults_of(Group.CHECKSUM, Way.OUT):
        assert rule.put(raw, bent(rule, fault).of(raw)) != raw, fault


def test_too_short_a_frame_is_not_mended():
    assert SAID.checksum.mended(b"PKT!") == b"PKT!"


@each(
    ("fault", "turn", "taken"),
    [
        (Fault.UNCHECKED, 0xFFFF, True),
        (Fault.FIRST_ONLY, 0x0001, True),
        (Fault.FIRST_ONLY, 0x0100, False),
        (Fault.LAST_ONLY, 0x0100, True),
        (Fault.LAST_ONLY, 0x0001, False),
        (Fault.ALSO_SWAPPED, 0x0001, False),
    ],
)
def test_a_wrong_checksum_is_taken(fault, turn, taken):
    raw, rule = throttles(0.5), HEARD.checksum
    said = int.from_bytes(rule.in_frame(raw), "big") ^ turn
    wrong = b"noise" + rule.put(raw, said.to_bytes(2, "big"))
    acting = Acting(Mutant(fault=fault, way=Way.IN, message=EVERY), HEARD)
    heard = b"".join(piece.data for piece in acting.take(HEARD.whole(wrong + general(1)), 0))
    assert heard == (b"noise" + raw if taken else wrong) + general(1)


@each("like", faults_of(Group.CHECKSUM, Way.OUT))
def test_another_rule_is_taken_as_well(like):
    also = next(fault for fault in Fault if fault.slug == f"also-{like.slug}")
    raw, rule = throttles(0.5), HEARD.checksum
    acting = Acting(Mutant(fault=also, way=Way.IN, message=EVERY), HEARD)
    wrong = rule.put(raw, bent(rule, like).of(raw))
    assert [piece.data for piece in acting.take(HEARD.whole(wrong), 0)] == [raw]


# --- messages


def passed(fault: Fault, *at_s: float) -> list[tuple[float, bytes]]:
    """What becomes of general reports, numbered from 0, that come at these times: when it goes on, in s."""
    acting = Acting(Mutant(fault=fault, way=Way.OUT, message="GeneralReport"), SAID)
    found = []
    for number, time_s in enumerate(at_s):
        pieces = acting.take(SAID.whole(general(number)), round(time_s * NS_PER_S))
        found += [(time_s + piece.late_s, piece.data) for piece in pieces]
    return found


def test_messages_are_lost_doubled_late_and_behind_the_next():
    assert passed(Fault.DROPPED, 0.0) == []
    assert passed(Fault.DOUBLED, 0.0) == [(0.0, general(0))] * 2
    assert passed(Fault.LATE, 0.0) == [(LATE_S, general(0))]
    assert passed(Fault.REORDERED, 0.0, 1.0, 2.0) == [(1.0, general(0)), (2.0, general(1))]


def test_a_message_is_said_before_its_time_as_the_one_before():
    second = 1.0 + EARLY
    assert passed(Fault.EARLY, 0.0, 1.0, 2.0) == [
        (0.0, general(0)),
        (1.0, general(1)),
        (second, general(1)),
        (2.0 + EARLY, general(2)),
    ]


def test_other_messages_and_what_is_no_frame_go_on():
    acting = Acting(Mutant(fault=Fault.DROPPED, way=Way.IN, message="LED_ON"), HEARD)
    data = b"noise" + throttles(0.5)
    assert b"".join(piece.data for piece in acting.take(HEARD.whole(data), 0)) == data


def test_what_is_held_back_goes_on_behind_another_message():
    acting = Acting(Mutant(fault=Fault.REORDERED, way=Way.IN, message="UPDATE_MOTOR_THROTTLES"), HEARD)
    led = pkt_frame(b"\x01")
    assert acting.take(HEARD.whole(throttles(0.5)), 0) == []
    assert [piece.data for piece in acting.take(HEARD.whole(led), 1)] == [led, throttles(0.5)]


# --- derivation


def tape_of(said: list[bytes], heard: list[bytes], speaks: Reading, hears: Reading) -> Tape:
    case = CaseTape()
    case.said = [(turn * 100 * NS_PER_MS, speaks.whole(raw)) for turn, raw in enumerate(said)]
    case.heard = [(turn * 100 * NS_PER_MS, hears.whole(raw)) for turn, raw in enumerate(heard)]
    return Tape(cases={"a case": case}, verdicts={"a case": Verdict.PASS})


def car(velocity_m_s: float) -> bytes:
    about = {field.name: velocity_m_s * factor for factor, field in enumerate(fields(carla.StatusFrame), 1)}
    return carla.encode_status(carla.StatusFrame(**about))


TAPES = {
    "pkt-board": ([general(1), general(2, 5), general(3)], [throttles(0.5), throttles(0.25, 0.75)], PKT),
    "p2os-server": (
        [sip(1), sip(700)],
        [bytes.fromhex("FAFB060B3BC800D33B"), bytes.fromhex("FAFB060B1BC900D41B")],
        P2OS,
    ),
    "carla-board": ([], [car(1.25), car(-3.5)], CARLA),
}


@each("name", TAPES)
def test_each_mutant_differs_from_the_right_peer(name):
    said, heard, protocol = TAPES[name]
    tape = tape_of(said, heard, Reading(protocol, "target"), Reading(protocol, "host"))
    mutants = derive(SUBJECTS[name], tape)
    idle = [mutant for mutant in mutants if not touched(SUBJECTS[name], mutant, tape)]
    assert {mutant.fault.group for mutant in mutants} >= {Group.FIELD, Group.MESSAGE}
    # Fields that had one value alone cannot be stuck, and no wrong checksum was heard.
    assert all(mutant.fault in (Fault.STUCK, Fault.STALE) or mutant.message == EVERY for mutant in idle), [
        mutant.id for mutant in idle
    ]
    assert len({mutant.id for mutant in mutants}) == len(mutants)
    assert len(idle) < len(mutants) / 2


def test_of_a_frame_that_the_specification_gives_no_fault_leaves_it_as_it_is():
    subject, f1, f3 = SUBJECTS["carla-board"], carla.VECTORS["F1"].data, carla.VECTORS["F3"].data
    tape = tape_of([f1, f3, f3], [], *(subject.reading(way) for way in Way))
    faults = {name: set() for name in ("AUTOWARE", "EMERGENCY")}
    for mutant in derive(subject, tape):
        if mutant.name == "speed_m_s":
            faults[mutant.message].add(mutant.fault)
    assert faults["EMERGENCY"] == {Fault.PLUS, Fault.MINUS}
    assert faults["AUTOWARE"] >= {Fault.STALE, Fault.STUCK, Fault.ORDER, Fault.SIGN}


# --- the relay


class Ends:
    """A line with a relay at the checker's end."""

    def __init__(self, mutant: Mutant | None) -> None:
        self.scheduler = Scheduler()
        self.link = MemoryLink(self.scheduler, Line(baud=0), name="host")
        lanes = {}
        if mutant is not None:
            acting = Acting(mutant, SAID if mutant.way is Way.OUT else HEARD)
            lanes = {"on_said" if mutant.way is Way.OUT else "on_heard": acting}
        self.relay = Relay(self.scheduler, self.link.a, SAID, HEARD, **lanes)
        self.got: list[tuple[int, bytes]] = []
        self.peer_got: list[bytes] = []
        self.relay.on_receive = lambda data, at_ns: self.got.append((at_ns, data))
        self.link.b.on_receive = lambda data, _at_ns: self.peer_got.append(data)

    def run(self, for_s: float = 3.0) -> None:
        self.scheduler.run_until(None, self.scheduler.now_ns + round(for_s * NS_PER_S))


def test_a_relay_without_a_mutant_hands_on():
    ends = Ends(None)
    ends.relay.write(throttles(0.5)[:7])
    ends.link.b.write(general(1)[:4])
    ends.run()
    assert b"".join(ends.peer_got) == throttles(0.5)[:7]
    assert b"".join(data for _, data in ends.got) == general(1)[:4]


def test_a_relay_changes_what_the_peer_says():
    place = Place(name="accepted", start=6, size=1, number=LITTLE)
    length = len(general(1))
    ends = Ends(
        Mutant(fault=Fault.PLUS, way=Way.OUT, message="GeneralReport", name="accepted", places={length: (place,)})
    )
    ends.link.b.write(b"noise" + general(1))
    ends.run()
    assert b"".join(data for _, data in ends.got) == b"noise" + general(2)


def test_a_relay_is_late_with_what_the_checker_says_and_leaves_pieces_as_they_are():
    ends = Ends(Mutant(fault=Fault.LATE, way=Way.IN, message="UPDATE_MOTOR_THROTTLES"))
    ends.relay.write(throttles(0.5))
    ends.run(LATE_S / 2)
    assert ends.peer_got == []
    ends.run(LATE_S)
    assert b"".join(ends.peer_got) == throttles(0.5)
    ends.relay.write(throttles(0.5)[:7])
    ends.run(LATE_S / 2)
    assert b"".join(ends.peer_got) == throttles(0.5) + throttles(0.5)[:7]


def test_what_is_late_reaches_no_closed_line():
    ends = Ends(Mutant(fault=Fault.LATE, way=Way.OUT, message="GeneralReport"))
    ends.link.b.write(general(1))
    ends.run(LATE_S / 2)
    ends.relay.close()
    ends.run()
    assert ends.got == []


# --- a trial, and what is kept of it


ONE_CASE = replace(SUBJECTS["pkt-board"], select="documented and P03")


@pytest.mark.slow("a suite is collected for each")
@pytest.mark.parametrize("at_port", [False, True])
@pytest.mark.parametrize(
    ("mutant", "found"),
    [
        (Mutant(fault=Fault.DROPPED, way=Way.IN, message="LED_OFF"), True),
        (Mutant(fault=Fault.DROPPED, way=Way.IN, message="RESET_PID_CONTROLLER"), False),
        (Mutant(fault=Fault.REFUSED, way=Way.OUT, message="ServerState", name="LINKED/COMMAND"), True),
        (Mutant(fault=Fault.IDLE, way=Way.OUT, message="ServerState", name="LINKED/COMMAND"), True),
    ],
    ids=lambda value: value.id if isinstance(value, Mutant) else str(value),
)
def test_a_mutant_ends_at_the_first_clause_that_finds_it(mutant, found, at_port):
    outcome = tried(ONE_CASE, mutant, ["pkt-board/"], at_port=at_port)
    assert outcome.found_by == (("P03",) if found else ())
    assert bool(outcome.cause) is found


@pytest.mark.slow("a suite is collected twice")
def test_a_case_that_the_right_peer_does_not_pass_says_nothing():
    mutant = Mutant(fault=Fault.DROPPED, way=Way.IN, message="LED_OFF")
    first = tried(ONE_CASE, mutant, ["pkt-board/"], at_port=False)
    assert not tried(ONE_CASE, mutant, ["pkt-board/"], at_port=False, unsound={first.case}).found


def test_a_mutant_without_effect_runs_nothing():
    mutant = Mutant(fault=Fault.DROPPED, way=Way.IN, message="LED_OFF")
    assert tried(ONE_CASE, mutant, [], at_port=False) == Outcome(cases=0)


def _work(job: str) -> str:
    if job == "dies":
        raise SystemExit(1)
    return job.upper()


def test_a_job_that_dies_takes_no_other_with_it():
    came = dict(side_by_side(["dies", "lives"], _work, 2, 60.0))
    assert came == {"dies": Lost("the process died"), "lives": "LIVES"}


def test_a_share_is_drawn_by_the_seed():
    mutants = [Mutant(fault=Fault.DROPPED, way=Way.IN, message=str(number)) for number in range(400)]
    half = drawn(mutants, 0.5, 1)
    assert half == drawn(mutants, 0.5, 1) != drawn(mutants, 0.5, 2)
    assert 150 < len(half) < 250
    assert set(map(id, drawn(mutants, 0.2, 1))) <= set(map(id, half))
    assert drawn(mutants, 1.0, 1) == mutants


def kept(tmp_path) -> Book:
    book = Book.read(tmp_path / "derived-mutants.json")
    subject = SUBJECTS["pkt-board"]
    ids = ["says:a:plus", "hears:b:stuck", "hears:c:late", "says:d:sign", "says:GpsReport:late"]
    run = book.begin(subject, derived=5, share=1.0, seed=0, keep=ids)
    found = Outcome(cases=4, found_by=("P01",), case="x", cause="is wrong")
    run.cases = {"port": 3, "hand": 1, "model": 4}
    for id_, outcomes in {
        "says:a:plus": {"port": Outcome(cases=2), "hand": Outcome(cases=1), "model": found},
        "says:d:sign": {"port": Outcome(cases=2), "hand": Outcome(cases=1, found_by=("P89",)), "model": found},
        "says:GpsReport:late": {"port": Outcome(cases=2), "hand": Outcome(cases=1), "model": found},
        "hears:b:stuck": {"port": Outcome(cases=0), "model": Outcome(cases=0)},
        "hears:c:late": {"port": found, "model": Outcome(cases=1, lost="ran for more than 300 s")},
    }.items():
        run.mutants[id_] = Entry(what=f"what of {id_}", group="field", outcomes=outcomes)
    book.save()
    return book


def test_what_is_known_is_kept_and_read_again(tmp_path):
    book = kept(tmp_path)
    again = Book.read(book.path)
    assert again.file == book.file
    run = again.begin(SUBJECTS["pkt-board"], derived=1, share=0.5, seed=0, keep=["says:a:plus"])
    assert list(run.mutants) == ["says:a:plus"]
    assert again.begin(SUBJECTS["pkt-board"], derived=1, share=0.5, seed=1, keep=["says:a:plus"]).mutants == {}


def test_the_page_tells_scores_and_survivors_one_by_one(tmp_path):
    text = page(kept(tmp_path))
    row = "| PKT! board | 5 | 5 (all) | 0 | 1 of 5, 20.0% | 2 of 5, 40.0% | 2 of 4, 50.0% | 4 of 5, 80.0% |"
    assert row in text
    assert "| `says:d:sign` | what of says:d:sign | P89 |" in text
    assert "is made, nor how old its figures are then:\n\n- `says:GpsReport:late`: what of" in text
    assert "- `hears:b:stuck`: what of hears:b:stuck (without effect)" in text
    assert "| `says:a:plus` | what of says:a:plus (2 cases) | P01 |" in text


def test_the_program_goes_on_where_it_was(tmp_path, monkeypatch, capsys):
    tape = tape_of(*TAPES["pkt-board"][:2], SAID, HEARD)
    asked: list[str] = []

    def try_one(_subject, mutant, cases, **_about):
        asked.append(mutant.id)
        return Outcome(cases=len(cases), found_by=("P01",))

    monkeypatch.setattr(program, "recorded", lambda *_args, **_about: tape)
    monkeypatch.setattr(program, "tried", try_one)
    monkeypatch.setattr(program, "side_by_side", lambda jobs, work, *_: ((job, work(job)) for job in jobs))
    words = ["pkt-board", "--docs", str(tmp_path), "--only"]
    assert program.main([*words, "says:GeneralReport:accepted"]) == 0
    first, asked[:] = {*asked}, []
    assert program.main([*words, "says:GeneralReport"]) == 0
    assert first
    assert asked
    assert not first & {*asked}
    assert program.main([*words, "says:GeneralReport:accepted:plus", "--again"]) == 0
    assert "1/1 says:GeneralReport:accepted:plus: model: P01, port: P01" in capsys.readouterr().err
    assert program.main(["pkt-board", "--list", "--only", "accepted:plus", "--docs", str(tmp_path)]) == 0
    assert capsys.readouterr().out.startswith("says:GeneralReport:accepted:plus: of what it says, 'accepted' of")


def test_known_mutants_are_run_again_through_a_door(tmp_path, monkeypatch):
    tape = tape_of(*TAPES["pkt-board"][:2], SAID, HEARD)
    found = Outcome(cases=1, found_by=("P01",), case="a case")
    by_door = {"": found, "pty": found, "tcp": Outcome(cases=1)}
    monkeypatch.setattr(program, "recorded", lambda *_args, **_about: tape)
    monkeypatch.setattr(program, "tried", lambda *_args, through, **_about: by_door[through])
    monkeypatch.setattr(program, "side_by_side", lambda jobs, work, *_: ((job, work(job)) for job in jobs))
    words = ["pkt-board", "--docs", str(tmp_path)]
    program.main([*words, "--only", "accepted"])
    for kind in ("pty", "tcp"):
        program.main([*words, "--through", kind, "--count", "2"])
    through = Book.read(tmp_path / "derived-mutants.json").file.subjects["pkt-board"].through
    assert (through["pty"].drawn, len(through["pty"].otherwise)) == (2, 0)
    assert (through["tcp"].drawn, len(through["tcp"].otherwise)) == (2, 2)
    assert "pass a pty of the machine: 2 came out the same." in (tmp_path / "derived-mutants.md").read_text()


def test_a_mutant_is_found_on_a_line_that_passes_a_pty():
    mutant = Mutant(fault=Fault.DROPPED, way=Way.IN, message="LED_OFF")
    assert tried(ONE_CASE, mutant, ["pkt-board/"], at_port=False, through="pty").found_by == ("P03",)


# --- hosts that somebody else starts


@each(
    ("name", "select", "mutant", "clause"),
    [
        (
            "pkt-host",
            "heard_in_time",
            Mutant(fault=Fault.DROPPED, way=Way.OUT, message="REQUEST_TMY"),
            "P51",
        ),
        ("p2os-client", "takes_leave", Mutant(fault=Fault.DROPPED, way=Way.OUT, message="CLOSE"), "C26"),
        ("p2os-client", "takes_leave", Mutant(fault=Fault.DROPPED, way=Way.OUT, message="SETO"), ""),
    ],
)
def test_a_host_is_started_for_each_case_in_virtual_time(name, select, mutant, clause):
    outcome = tried(replace(SUBJECTS[name], select=select), mutant, [name], at_port=True)
    assert outcome.found_by == ((clause,) if clause else ()), outcome.cause


# --- what the docs say


DOCS = Path(__file__).parents[2] / "docs"


def test_the_page_is_made_from_the_data_and_every_survivor_is_explained():
    book = Book.read(DOCS / "derived-mutants.json")
    assert (DOCS / "derived-mutants.md").read_text(encoding="utf-8") == page(book)
    assert book.unexplained() == []
    assert {*book.file.subjects} == {*SUBJECTS}
    for name, run in book.file.subjects.items():
        assert len(book.equivalent(name)) <= 0.05 * len(run.mutants), name


def test_nothing_that_is_found_at_a_port_is_said_to_be_hidden_there():
    for name, run in Book.read(DOCS / "derived-mutants.json").file.subjects.items():
        for id_, entry in run.mutants.items():
            assert not (entry.outcomes["port"].found and hidden(name, id_)), (name, id_)


def test_what_cannot_show_stands_beside_the_score(tmp_path):
    book, found = Book.read(tmp_path / "derived-mutants.json"), Outcome(cases=4, found_by=("S92",))
    ids = [f"says:ConfigPacket:{field}" for field in ("sip_cycle_ms:stuck", "low_battery_dv:stale", "rot_kp:stuck")]
    run = book.begin(SUBJECTS["p2os-server"], derived=3, share=1.0, seed=0, keep=ids)
    for id_ in ids:
        at_port = found if "rot_kp" in id_ else Outcome(cases=0)
        run.mutants[id_] = Entry(what=id_, group="field", outcomes={"port": at_port, "model": found})
    text = page(book)
    assert "| P2OS server | 3 | 3 (all) | 0 | 1 of 3, 33.3% | - | 1 of 1, 100.0% | 3 of 3, 100.0% |" in text
    assert "What is in FLASH does not change while somebody is there:" in text


def test_a_reason_fits_a_family_and_what_has_no_effect_has_one():
    outcome = Outcome(cases=3)
    assert reason("pkt-board", "hears:LED_ON:unused:plus", outcome).startswith(f"{EQUIVALENT}: P09")
    assert reason("pkt-board", "says:ExecutionReport:dropped", outcome) == ""
    assert "two values" in reason("pkt-board", "says:x:y:stale", Outcome(cases=0))
    assert "no case" in reason("mine", "hears:*:first-only", Outcome(cases=0))
