"""The suite xrce-client: our clients pass, also at a port, and each clause finds a client that is wrong about it."""

from __future__ import annotations

import contextlib
import dataclasses
import re
import signal
from pathlib import Path

import pytest

from hilbench.bench import Bench
from hilbench.check import CheckOptions, Verdict, list_cases, run_suites
from hilbench.check.bench_provider import make_provider
from hilbench.judging.uncertainty import OfTimes
from hilbench.pace.lateness import IN_TIME, Lateness
from hilbench.suites._xrce_client import Agent
from hilbench.systems.xrce_agent import client as model
from hilbench.terminal.options import TargetChoice
from measure.mutants.each_its_own import Fault, judge
from protocols import xrce
from protocols.common import flagged
from protocols.xrce import client, machine, session, streams
from protocols.xrce import submessages as said
from protocols.xrce.clauses import CLIENT_CLAUSES
from targets.firmware import image_path
from tests.protocols.clauses import check_clauses

OPTIONS = CheckOptions(bench="xrce-client", suites=("xrce-client",))
ON_BOARD = CheckOptions(bench=str(Path(__file__).parent / "xrce_client_board.toml"))
SLOW = CheckOptions(bench=str(Path(__file__).parent / "xrce_client_slow.toml"))
OF_OUTPUT = " or ".join(f"XC{number:02}" for number in (5, 6, 7, 8, 9, 10, 11, 18, 19, 21))
OF_INPUT = " or ".join(f"XC{number:02}" for number in (12, 13, 14, 15, 17, 22))
MS = 1_000_000
S = 1000 * MS


def test_the_clauses_are_whole_and_each_is_cited():
    check_clauses(CLIENT_CLAUSES, set())
    planned = list_cases(OPTIONS, make_provider(OPTIONS))
    assert [case.clauses[0].id for case in planned] == [clause.id for clause in CLIENT_CLAUSES]


def not_passed(options):
    report = run_suites(options, make_provider(options))
    return {case.clause_ids[0]: case.cause for case in report.cases if case.verdict is not Verdict.PASS}


@pytest.mark.slow("the whole suite, 22 cases")
def test_our_model_passes():
    assert not_passed(OPTIONS) == {}


@pytest.mark.exhaustive("half a minute: 22 cases on the emulated board; the gate has the client in C against our agent")
def test_our_firmware_passes():
    assert not_passed(ON_BOARD) == {}


@pytest.mark.exhaustive("the emulated board; the gate has a mutant for each of these clauses")
def test_a_firmware_that_never_looks_again_is_found():
    choice = TargetChoice(name="brain", spec=f"nucleo-h753zi:{image_path('vehicle-micro-ros-v0')}")
    options = dataclasses.replace(ON_BOARD, targets=(choice,), select="XC07 or XC19")
    assert {*not_passed(options)} == {"XC19"}


@pytest.mark.real_time(
    "a process that serves a client; a check of it at its socket, whose verdicts may be inconclusive"
)
def test_our_model_violates_nothing_at_a_port(forkable):
    with forkable.start("serve", "xrce-client", "--tcp", "0") as process:
        port = re.search(r"tcp .*:(\d+),", process.hear("stop with"))[1]
        choice = TargetChoice(spec=f"socket://127.0.0.1:{port}")
        options = dataclasses.replace(OPTIONS, targets=(choice,), select="XC01 or XC12")
        report = run_suites(options, make_provider(options))
        process.send_signal(signal.SIGINT)
        process.communicate()
    assert len(report.cases) == 2
    verdicts = {case.verdict for case in report.cases}
    assert Verdict.PASS in verdicts
    assert verdicts <= {Verdict.PASS, Verdict.INCONCLUSIVE}


# --- clients that are right, and other than our model


def altered(owner, name, make):
    """What replaces an attribute, made of what was there."""
    return owner, name, make


def always(value):
    return lambda _was: lambda *_args, **_more: value


@contextlib.contextmanager
def patched(alterations):
    with pytest.MonkeyPatch.context() as patch:
        for owner, name, make in alterations:
            patch.setattr(owner, name, make(getattr(owner, name, None)), raising=False)
        yield


def judged(alterations, select, options=OPTIONS):
    """What does not pass of the cases that are selected, with its cause."""
    options = dataclasses.replace(options, select=select)
    with patched(alterations):
        report = run_suites(options, make_provider(options))
    return {case.clause_ids[0]: (case.verdict, case.cause) for case in report.cases if case.verdict is not Verdict.PASS}


def verdicts_of(seen):
    return {clause_id: verdict for clause_id, (verdict, _) in seen.items()}


def says_heartbeat_beside(call):
    """Say HEARTBEAT in each message of a reliable stream, of which it is the last."""

    def other(self, *args):
        sent = b""
        for frame in xrce.FrameReader().receive(call(self, *args)):
            header, body = xrce.decode_header(frame.payload)
            if xrce.is_reliable(header.stream_id):
                beat = said.Heartbeat(first_unacked=0, last_unacked=header.sequence, stream_id=header.stream_id)
                body = bytes(body) + bytes(-len(body) % 4) + xrce.encode_submessage(beat)
            sent += xrce.encode_frame(xrce.encode_message(header, body))
        return sent

    return other


def test_a_heartbeat_in_the_message_that_it_names():
    beside = [altered(model.ModelClient, name, says_heartbeat_beside) for name in ("receive", "advance")]
    assert judged(beside, "XC09") == {}


def hurries(init):
    def other(self, *args):
        init(self, *args)
        self._pause_ns = self._shortest_ns = 20 * MS

    return other


def test_a_heartbeat_that_crosses_the_acknack_on_a_slow_line():
    assert judged([altered(streams.ReliableOutput, "__init__", hurries)], "XC11", SLOW) == {}


def on_best_effort(send):
    return lambda self, one, now_ns, **_stream: send(self, one, now_ns, stream_id=0x01)


@pytest.mark.slow("ten cases, two of which wait for a session to be lost")
def test_a_client_without_a_reliable_output_stream():
    seen = judged([altered(session.Session, "send", on_best_effort)], OF_OUTPUT)
    assert verdicts_of(seen) == dict.fromkeys(("XC07", "XC08", "XC09", "XC10", "XC11"), Verdict.NOT_APPLICABLE)


def has_room_for_one(init):
    def other(self, *args):
        init(self, *args)
        self._window = 1

    return other


ROOM_FOR_ONE = [
    altered(streams.ReliableInput, "__init__", has_room_for_one),
    altered(streams, "_BITMAP_BITS", lambda _was: 1),
]


def test_a_client_with_room_for_one_message_that_comes():
    assert judged(ROOM_FOR_ONE, OF_INPUT) == {}


def several_in_one_message(begin):
    """Create all in one message."""

    def other(self, now_ns):
        made = []
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(session.Session, "send", lambda _self, one, _now_ns: made.append(one) or b"")
            begin(self, now_ns)
        return self._session.send(made, now_ns)

    return other


def test_a_client_that_creates_all_in_one_message():
    assert judged([altered(model.ModelClient, "_begin", several_in_one_message)], "XC05 or XC06 or XC07 or XC11") == {}


def begins_in_a_session(init):
    """Have the session of a case before."""

    def other(self, *args):
        init(self, *args)
        self._session.connect(0)
        opened = xrce.encode_submessage(xrce.StatusAgent(status=xrce.Status.OK, agent=xrce.Agent()))
        header = self._session._machine.header()
        self.receive(xrce.encode_frame(xrce.encode_message(header, opened)), 0)

    return other


LEFT_OVER = [
    altered(model.ModelClient, "__init__", begins_in_a_session),
    altered(model.ModelClient, "_watch", always(b"")),
]


def test_a_client_that_stays_in_the_session_of_the_case_before():
    at_a_port = altered(Agent, "_at_a_port", lambda _was: property(lambda _self: True))
    seen = judged([*LEFT_OVER, at_a_port], "XC01 or XC09 or XC12")
    assert verdicts_of(seen) == dict.fromkeys(("XC01", "XC09", "XC12"), Verdict.INCONCLUSIVE)
    assert all("[port] reset" in cause for _, cause in seen.values())


def test_a_fresh_client_that_speaks_in_a_session_unasked():
    assert verdicts_of(judged(LEFT_OVER, "XC01")) == {"XC01": Verdict.FAIL}


# --- clients that are wrong


def of_another_version(client_of):
    return lambda self: dataclasses.replace(client_of(self), version=b"\x02\x00")


def asks_once(ask):
    def other(self, *args):
        if not getattr(self, "has_asked", False):
            self.has_asked = True
            ask(self, *args)

    return other


def hears_no_late_agent(take):
    def other(self, one, stream_id):
        if not (isinstance(one, said.StatusAgent) and self.now_ns > 1.2 * S):
            take(self, one, stream_id)

    return other


def twice(begin):
    return lambda self, now_ns: begin(self, now_ns) + begin(self, now_ns)


def once(begin):
    def other(self, now_ns):
        if getattr(self, "has_begun", False):
            return b""
        self.has_begun = True
        return begin(self, now_ns)

    return other


def begins_at_one(init):
    def other(self, *args):
        init(self, *args)
        self._first = 1

    return other


def without_window(_sendable):
    def other(self, now_ns):
        while self._waiting:
            body = self._waiting.popleft()
            self._waiting_bytes -= len(body)
            self._sent.append(streams._Sent(body, now_ns))
            yield xrce.after(self._first, len(self._sent) - 1), body

    return other


def never_done(restart):
    def other(self, now_ns):
        restart(self, now_ns)
        self.due_ns = now_ns + self._pause_ns

    return other


def names_all(heartbeat):
    def other(self, now_ns):
        beat = heartbeat(self, now_ns)
        return beat and dataclasses.replace(beat, first_unacked=0)

    return other


def never_asks(_heartbeat):
    def other(self, _now_ns):
        self.due_ns = None

    return other


def deaf_to(kind):
    def make(take):
        def other(self, one, stream_id):
            if not isinstance(one, kind):
                take(self, one, stream_id)

        return other

    return make


def hands_on_at_once(take):
    def other(self, number, body):
        self._expected = number
        return take(self, number, body)

    return other


def names_nothing(acknack):
    return lambda self: dataclasses.replace(acknack(self), nack_bitmap=0)


def keeps_nothing_early(take):
    """Drop what comes too early, and name it as received."""

    def other(self, number, body):
        if number == self._expected:
            return take(self, number, body)
        self._announce(number - 1)
        return False

    return other


def throws_away(hand_on):
    return lambda self: None if hand_on(self) is None else b""


def obeys_early(take):
    def other(self, number, body):
        if number != self._expected:
            self._announce(xrce.decode_submessage(next(xrce.split_submessages(body))).last_unacked)
        return take(self, number, body)

    return other


def acknowledges_once(take):
    def other(self, header, body):
        one = self.streams.reliable_input(header.stream_id)
        if xrce.ahead(header.sequence, one._expected) < 0x8000:
            take(self, header, body)

    return other


def reads_little_endian_alone(reader):
    return lambda data, *, little_endian: reader(data, little_endian=True)


def believes_any_crc(finish):
    def other(self, payload):
        self._body[-2:] = flagged.crc16(payload).to_bytes(2, "little")
        finish(self, payload)

    return other


def takes_any_session(_belongs):
    return lambda self, header: self.state is self.OPEN and header.session_id != xrce.NO_SESSION


def of_another_key(client_of):
    def other(self):
        self.keys = getattr(self, "keys", 0) + 1
        return dataclasses.replace(client_of(self), client_key=self.keys.to_bytes(4, "big"))

    return other


def opens_again(take):
    def other(self, one, stream_id):
        if isinstance(one, said.StatusAgent) and self.state is self.OPEN:
            self.events.append(xrce.SessionOpened(peer=one.agent))
        take(self, one, stream_id)

    return other


BACKWARDS = [altered(model, "OBJECTS", lambda was: dict(reversed(was.items())))]
WRONG = [
    ("XC01", "says another version", [altered(client.ClientMachine, "_client", of_another_version)]),
    ("XC02", "asks once", [altered(client.ClientMachine, "_ask", asks_once)]),
    ("XC03", "takes a refusal for a session", [altered(client, "_ERRORS_FROM", lambda _was: 0x100)]),
    ("XC04", "does not wait", [altered(client.ClientMachine, "take_said", hears_no_late_agent)]),
    ("XC05", "creates children first", BACKWARDS),
    ("XC06", "creates all twice", [altered(model.ModelClient, "_begin", twice)]),
    (
        "XC06",
        "creates all twice on a best-effort stream",
        [altered(session.Session, "send", on_best_effort), altered(model.ModelClient, "_begin", twice)],
    ),
    ("XC07", "begins at 1", [altered(streams.ReliableOutput, "__init__", begins_at_one)]),
    (
        "XC08",
        "has no window",
        [
            altered(streams.ReliableOutput, "sendable", without_window),
            altered(model, "_MOST_WAITING", lambda _was: 100),
        ],
    ),
    ("XC09", "says no HEARTBEAT", [altered(streams.ReliableOutput, "heartbeat", never_asks)]),
    ("XC10", "hears no ACKNACK", [altered(machine.Machine, "_take_submessage", deaf_to(said.AckNack))]),
    (
        "XC11",
        "says all twice",
        [altered(session.Session, "send", lambda send: lambda *args, **more: 2 * send(*args, **more))],
    ),
    (
        "XC11",
        "says HEARTBEAT of what was acknowledged",
        [
            altered(streams.ReliableOutput, "_restart", never_done),
            altered(streams.ReliableOutput, "heartbeat", names_all),
        ],
    ),
    ("XC12", "hears no HEARTBEAT", [altered(machine.Machine, "_take_submessage", deaf_to(said.Heartbeat))]),
    ("XC12", "names nothing as missing", [altered(streams.ReliableInput, "acknack", names_nothing)]),
    ("XC13", "keeps nothing that comes too early", [altered(streams.ReliableInput, "take", keeps_nothing_early)]),
    ("XC13", "does not wait for what is missing", [altered(streams.ReliableInput, "take", hands_on_at_once)]),
    ("XC14", "acknowledges once", [altered(machine.Machine, "_take_reliable", acknowledges_once)]),
    ("XC15", "reads little-endian alone", [altered(said.wire, "payload_reader", reads_little_endian_alone)]),
    ("XC16", "believes any CRC", [altered(flagged.FrameReader, "_finish", believes_any_crc)]),
    ("XC17", "takes any session for its own", [altered(machine.Machine, "belongs", takes_any_session)]),
    ("XC18", "asks no silent agent", [altered(model.ModelClient, "_watch", always(b""))]),
    ("XC18", "creates nothing anew", [altered(model.ModelClient, "_begin", once)]),
    ("XC19", "gives no agent up", [altered(model.ModelClient, "_watch", always(b""))]),
    ("XC20", "has another key each time", [altered(client.ClientMachine, "_client", of_another_key)]),
    ("XC21", "begins at each STATUS_AGENT", [altered(client.ClientMachine, "take_said", opens_again)]),
    ("XC22", "throws away what it acknowledges", [altered(streams.ReliableInput, "next", throws_away)]),
    ("XC22", "obeys what comes too early", [altered(streams.ReliableInput, "take", obeys_early)]),
]


def opening(right, alterations):
    @contextlib.contextmanager
    def open_case(case):
        with patched(alterations), right.open_case(case) as bench:
            yield bench

    return open_case


@pytest.mark.slow("a run of a case for each of 28 wrong clients: each clause finds one")
def test_each_clause_finds_a_client_that_is_wrong_about_it():
    right = make_provider(OPTIONS)
    faults = [
        Fault(name=what, clause_id=clause_id, open_case=opening(right, alterations))
        for clause_id, what, alterations in WRONG
    ]
    verdicts = judge(OPTIONS, right, faults)
    assert verdicts.not_found == {}
    assert verdicts.found_by == {clause.id for clause in CLIENT_CLAUSES}


# --- a host that was late


def begins_later(init):
    """Stand at a port where another case was before."""

    def other(self, peer):
        peer.run(1.0)
        init(self, peer)

    return other


def late_in_the_first_second(_was):
    return lambda _self, since_ns: Lateness(late_ns=200 * MS) if since_ns < S else IN_TIME


def unsure_of_the_first_second(_was):
    return lambda _self, since_ns: OfTimes(5.0 if since_ns < S else 0.0)


LATE_BEFORE = [
    altered(Agent, "__init__", begins_later),
    altered(Bench, "lateness", late_in_the_first_second),
    altered(Bench, "uncertainty_s", unsure_of_the_first_second),
]


def test_a_host_that_was_late_before_the_case_leaves_its_verdict_alone():
    assert judged(LATE_BEFORE, "XC11") == {}
    wrong = [
        altered(streams.ReliableOutput, "_restart", never_done),
        altered(streams.ReliableOutput, "heartbeat", names_all),
    ]
    assert verdicts_of(judged([*LATE_BEFORE, *wrong], "XC11")) == {"XC11": Verdict.FAIL}
