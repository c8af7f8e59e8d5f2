"""The suite xrce-client: our clients pass, also at a port, and each clause finds a client that is wrong about it."""

from __future__ import annotations

import contextlib
import dataclasses
import re
import signal
from pathlib import Path

import pytest

from hilbench.check import CheckOptions, Verdict, list_cases, run_suites
from hilbench.check.bench_provider import make_provider
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
S = 1_000_000_000


def test_the_clauses_are_whole_and_each_is_cited():
    check_clauses(CLIENT_CLAUSES, set())
    planned = list_cases(OPTIONS, make_provider(OPTIONS))
    assert [case.clauses[0].id for case in planned] == [clause.id for clause in CLIENT_CLAUSES]


def not_passed(options):
    report = run_suites(options, make_provider(options))
    return {case.clauses[0].id: case.cause for case in report.cases if case.verdict is not Verdict.PASS}


@pytest.mark.slow("the whole suite, 21 cases")
def test_our_model_passes():
    assert not_passed(OPTIONS) == {}


@pytest.mark.exhaustive("half a minute: 21 cases on the emulated board; the gate has the client in C against our agent")
def test_our_firmware_passes():
    assert not_passed(ON_BOARD) == {}


@pytest.mark.exhaustive("the emulated board; the gate has a mutant for each of these clauses")
def test_a_firmware_that_never_looks_again_is_found():
    choice = TargetChoice(name="brain", spec=f"nucleo-h753zi:{image_path('vehicle-micro-ros-v0')}")
    options = dataclasses.replace(ON_BOARD, targets=(choice,), select="XC07 or XC18 or XC19 or XC20")
    assert {*not_passed(options)} == {"XC18", "XC19", "XC20"}


@pytest.mark.real_time(
    "a process that serves a client; a check of it at its socket, whose verdicts may be inconclusive"
)
def test_our_model_violates_nothing_at_a_port(forkable):
    with forkable.start("serve", "xrce-client", "--tcp", "0") as process:
        port = re.search(r"tcp .*:(\d+),", process.hear("stop with"))[1]
        choice = TargetChoice(spec=f"socket://127.0.0.1:{port}")
        options = dataclasses.replace(OPTIONS, targets=(choice,), select="XC01 or XC05 or XC12 or XC20")
        report = run_suites(options, make_provider(options))
        process.send_signal(signal.SIGINT)
        process.communicate()
    assert len(report.cases) == 4
    assert {case.verdict for case in report.cases} <= {Verdict.PASS, Verdict.INCONCLUSIVE}


# --- clients that are wrong


def altered(owner, name, make):
    """What replaces an attribute, made of what was there."""
    return owner, name, make


def always(value):
    return lambda _was: lambda *_args, **_more: value


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
    ("XC12", "hears no HEARTBEAT", [altered(machine.Machine, "_take_submessage", deaf_to(said.Heartbeat))]),
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
]


def opening(right, alterations):
    @contextlib.contextmanager
    def open_case(case):
        with pytest.MonkeyPatch.context() as patch:
            for owner, name, make in alterations:
                patch.setattr(owner, name, make(getattr(owner, name, None)), raising=False)
            with right.open_case(case) as bench:
                yield bench

    return open_case


@pytest.mark.slow("a run of a case for each of 22 wrong clients: each clause finds one")
def test_each_clause_finds_a_client_that_is_wrong_about_it():
    right = make_provider(OPTIONS)
    faults = [
        Fault(name=what, clause_id=clause_id, open_case=opening(right, alterations))
        for clause_id, what, alterations in WRONG
    ]
    verdicts = judge(OPTIONS, right, faults)
    assert verdicts.not_found == {}
    assert verdicts.found_by == {clause.id for clause in CLIENT_CLAUSES}
