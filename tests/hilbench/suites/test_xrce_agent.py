"""The suite xrce-agent: our agent passes, also at a port, and each clause finds an agent that is wrong about it."""

from __future__ import annotations

import contextlib
import dataclasses
import re
import signal

import pytest

from hilbench.check import CheckOptions, Verdict, list_cases, run_suites
from hilbench.check.bench_provider import make_provider
from hilbench.terminal.options import TargetChoice
from measure.mutants.each_its_own import Fault, judge
from protocols import xrce
from protocols.common import flagged
from protocols.xrce import agent, descriptions, entities, machine, reading, service, streams
from protocols.xrce import submessages as said
from protocols.xrce.clauses import AGENT_CLAUSES
from tests.protocols.clauses import check_clauses

OPTIONS = CheckOptions(bench="xrce-agent", suites=("xrce-agent",))


def test_the_clauses_are_whole_and_each_is_cited():
    check_clauses(AGENT_CLAUSES, set())
    planned = list_cases(OPTIONS, make_provider(OPTIONS))
    assert [case.clauses[0].id for case in planned] == [clause.id for clause in AGENT_CLAUSES]


@pytest.mark.slow("the whole suite, 23 cases")
def test_our_agent_passes():
    report = run_suites(OPTIONS, make_provider(OPTIONS))
    assert {case.id: case.cause for case in report.cases if case.verdict is not Verdict.PASS} == {}


@pytest.mark.real_time(
    "a process that serves an agent; a check of it at its socket, whose verdicts may be inconclusive"
)
def test_our_agent_violates_nothing_at_a_port(forkable):
    with forkable.start("serve", "xrce-agent", "--tcp", "0") as process:
        port = re.search(r"tcp .*:(\d+),", process.hear("stop with"))[1]
        choice = TargetChoice(spec=f"socket://127.0.0.1:{port}")
        options = dataclasses.replace(OPTIONS, targets=(choice,), select="XA01 or XA04 or XA10 or XA20")
        report = run_suites(options, make_provider(options))
        process.send_signal(signal.SIGINT)
        process.communicate()
    assert len(report.cases) == 4
    assert {case.verdict for case in report.cases} <= {Verdict.PASS, Verdict.INCONCLUSIVE}


# --- agents that are wrong


def altered(owner, name, make):
    """What replaces an attribute, made of what was there."""
    return owner, name, make


def refuses_readers(create):
    def other(self, asked):
        wrong = isinstance(asked.object, xrce.DataReader) and not isinstance(asked.object.representation, xrce.AsXml)
        return xrce.Status.DDS_ERROR if wrong else create(self, asked)

    return other


def reads_no_xml(topic):
    def other(self, asked):
        if isinstance(asked, xrce.AsXml):
            raise xrce.RemoteProtocolError("XML")
        return topic(self, asked)

    return other


def forgets_parents(child):
    def other(self, object_id, made, *parents):
        one = child(self, object_id, made, *parents)
        one.parents = ()
        return one

    return other


def without_request_id(make):
    return lambda **fields: make(**(fields | {"request_id": 0}))


def deaf_to(kind, take):
    def other(self, one, stream_id):
        if not isinstance(one, kind):
            take(self, one, stream_id)

    return other


def hands_on_at_once(take):
    """What comes too early is handed on, and what was missing never waited for."""

    def other(self, number, body):
        self._expected = number
        return take(self, number, body)

    return other


def never_asks(_heartbeat):
    def other(self, _now_ns):
        self.due_ns = None

    return other


def believes_any_crc(finish):
    def other(self, payload):
        self._body[-2:] = flagged.crc16(payload).to_bytes(2, "little")
        finish(self, payload)

    return other


def keeps_entities(end):
    def other(self, line):
        self.kept = line.entities or getattr(self, "kept", None)

    return other


def begins_with_what_was_kept(begin):
    def other(self, line, client_key, now_ns):
        begin(self, line, client_key, now_ns)
        line.entities = getattr(self, "kept", None) or line.entities

    return other


def always(value):
    return lambda _was: lambda *_args, **_more: value


WRONG = [
    ("XA01", "answers outside of the session", [altered(agent, "_header_for", always(xrce.Header(session_id=0x80)))]),
    ("XA02", "takes anybody", [altered(agent, "_verdict", always(xrce.Status.OK))]),
    (
        "XA03",
        "says that it is not available",
        [altered(agent, "AgentActivity", lambda make: lambda **_: make(availability=0))],
    ),
    ("XA04", "creates no reader", [altered(entities.Entities, "create", refuses_readers)]),
    ("XA05", "reads no XML", [altered(descriptions.Profiles, "topic", reads_no_xml)]),
    ("XA06", "looks for no parent", [altered(entities.Entities, "_child", forgets_parents)]),
    (
        "XA07",
        "replaces what is there",
        [
            altered(
                entities.Entities,
                "create",
                lambda create: lambda self, asked: create(self, dataclasses.replace(asked, replace=True)),
            )
        ],
    ),
    (
        "XA08",
        "deletes what is not there",
        [altered(entities.Entities, "delete", lambda delete: lambda *args: delete(*args) and xrce.Status.OK)],
    ),
    ("XA09", "answers on the reliable stream", [altered(service, "is_reliable", always(True))]),
    ("XA10", "forgets the id of the request", [altered(service, "TopicData", without_request_id)]),
    ("XA11", "reads for ever", [altered(reading.Reading, "is_over", always(False))]),
    ("XA12", "says nothing of what is not there", [altered(service.AgentService, "_status", always(None))]),
    ("XA13", "does not wait for what is missing", [altered(streams.ReliableInput, "take", hands_on_at_once)]),
    ("XA14", "obeys again", [altered(streams.ReliableInput, "take", hands_on_at_once)]),
    (
        "XA15",
        "hears no HEARTBEAT",
        [altered(machine.Machine, "_take_submessage", lambda take: deaf_to(said.Heartbeat, take))],
    ),
    (
        "XA16",
        "hears no ACKNACK",
        [altered(machine.Machine, "_take_submessage", lambda take: deaf_to(said.AckNack, take))],
    ),
    ("XA16", "says no HEARTBEAT", [altered(streams.ReliableOutput, "heartbeat", never_asks)]),
    ("XA17", "drops fragments", [altered(streams.Fragments, "add", always(None))]),
    ("XA18", "takes what is older", [altered(streams.BestEffortInput, "accepts", always(True))]),
    ("XA19", "goes on with its streams", [altered(agent.AgentMachine, "streams", lambda _was: LastingStreams())]),
    (
        "XA20",
        "keeps what a client had",
        [
            altered(service.AgentService, "_end", keeps_entities),
            altered(service.AgentService, "_begin", begins_with_what_was_kept),
        ],
    ),
    (
        "XA21",
        "forgets when it was asked",
        [altered(agent, "TimestampReply", lambda make: lambda **fields: make(**(fields | {"originate": xrce.Time()})))],
    ),
    ("XA22", "believes any CRC", [altered(flagged.FrameReader, "_finish", believes_any_crc)]),
    (
        "XA23",
        "reads little-endian alone",
        [
            altered(
                said.wire,
                "payload_reader",
                lambda reader: lambda data, *, little_endian: reader(data, little_endian=True),
            )
        ],
    ),
]


class LastingStreams:
    """An attribute that keeps what it was given first."""

    def __get__(self, owner, kind=None):
        return owner.__dict__["_streams"]

    def __set__(self, owner, value):
        owner.__dict__.setdefault("_streams", value)


def opening(right, alterations):
    @contextlib.contextmanager
    def open_case(case):
        with pytest.MonkeyPatch.context() as patch:
            for owner, name, make in alterations:
                patch.setattr(owner, name, make(getattr(owner, name, None)), raising=False)
            with right.open_case(case) as bench:
                yield bench

    return open_case


@pytest.mark.slow("a run of a case for each of 24 wrong agents: each clause finds one")
def test_each_clause_finds_an_agent_that_is_wrong_about_it():
    right = make_provider(OPTIONS)
    faults = [
        Fault(name=what, clause_id=clause_id, open_case=opening(right, alterations))
        for clause_id, what, alterations in WRONG
    ]
    verdicts = judge(OPTIONS, right, faults)
    assert verdicts.not_found == {}
    assert verdicts.found_by == {clause.id for clause in AGENT_CLAUSES}
