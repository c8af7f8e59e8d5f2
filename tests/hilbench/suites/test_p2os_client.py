"""The suite p2os-client: our client passes it, and for every clause there is a client that does not.

The wrong clients are of two kinds: a state table with an edge taken away or led elsewhere, and a client that is made
wrong by hand, mostly by what stands between it and its line.
"""

from __future__ import annotations

import dataclasses

import pytest

from hilbench.bench import to_ns
from hilbench.bench.shared import Shared
from hilbench.benchfile.reader import open_bench
from hilbench.check import CheckOptions, Verdict, list_cases, run_suites
from hilbench.journal import Journal
from hilbench.systems.pioneer.client import P2osClient
from hilbench.systems.pioneer.provider import P2OS_SERVER, VirtualProvider
from measure.mutants.each_its_own import Fault, judge
from measure.mutants.in_bench_time import ForeignClientInBenchTime
from protocols.p2os import (
    CLIENT_TABLE,
    Action,
    ClientState,
    ClientTrigger,
    Command,
    CommandNumber,
    Frame,
    FrameReader,
    PacketReceived,
    Pose,
    Sip,
    Transition,
    Transmit,
    checksum,
    encode_command,
    encode_frame,
    pack_bytes,
)
from protocols.p2os.clauses import CLAUSES
from tests.each import each

MUST_FAIL = {clause.id for clause in CLAUSES if clause.suite == "p2os-client"}


def provider(make_client=None):
    shared = Shared(bench_file=open_bench("pioneer"), timeout_scale=1.0, journal=Journal())
    return VirtualProvider(shared, make_client=make_client) if make_client else VirtualProvider(shared)


def options(select=""):
    return CheckOptions(bench="pioneer", suites=("p2os-client",), select=select)


# --- the right client


@pytest.fixture(scope="module")
def report():
    return run_suites(options(), provider())


def test_our_client_passes(report):
    assert {case.id: case.cause for case in report.cases if case.verdict is not Verdict.PASS} == {}
    assert report.exit_code == 0


def test_every_clause_is_cited(report):
    assert {clause for case in report.cases for clause in case.clause_ids} == MUST_FAIL


def test_the_declared_times_are_the_true_ones(report):
    declared = {case.id: case.bench_time_s for case in list_cases(options(), provider())}
    off = {case.id: case.bench_time_s for case in report.cases if abs(case.bench_time_s - declared[case.id]) > 0.2}
    assert off == {}
    assert sum(declared.values()) < 170


def test_it_is_repeatable(report):
    again = run_suites(options("C07 or C12"), provider())
    hashes = {case.id: case.case_hash for case in report.cases}
    assert {case.id: case.case_hash for case in again.cases} == {case.id: hashes[case.id] for case in again.cases}


# --- wrong clients


_S, _T, _A = ClientState, ClientTrigger, Action


def without(*edges):
    """A client whose table lacks edges."""
    return with_table({key: edge for key, edge in CLIENT_TABLE.items() if key not in edges})


def instead(key, next_state, *actions):
    """A client whose table has another edge."""
    return with_table({**CLIENT_TABLE, key: Transition(next_state, actions)})


def with_table(table):
    return lambda bench, port, chosen: P2osClient(bench, port, chosen, table=table)


def with_options(**changes):
    return lambda bench, port, chosen: P2osClient(bench, port, dataclasses.replace(chosen, **changes))


def hearing(alter):
    """A client that gets of each frame what ``alter(frame, client)`` makes of its bytes."""

    def make(bench, port, chosen):
        client = P2osClient(bench, port, chosen)
        reader, receive = _AnyFrameReader(), client.connection.receive

        def hear(data, now_ns):
            return receive(b"".join(alter(frame, client) for frame in reader.receive(data)), now_ns)

        client.connection.receive = hear
        return client

    return make


class _AnyFrameReader:
    """Cuts a stream at its headers, whatever the checksums are."""

    def __init__(self):
        self._held = b""

    def receive(self, data):
        self._held += data
        while len(self._held) >= 3 and len(self._held) >= 3 + self._held[2]:
            size = 3 + self._held[2]
            yield self._held[:size]
            self._held = self._held[size:]


def saying(alter):
    """A client whose frames are altered on their way out."""

    def make(bench, port, chosen):
        client = P2osClient(bench, port, chosen)
        send = client.connection.send
        client.connection.send = lambda message, now_ns: alter(send(message, now_ns))
        return client

    return make


def repaired(frame, _client):
    body = frame[3:-2]
    return frame[:-2] + checksum(body).to_bytes(2, "big")


def without_motion(frame, client):
    """ARIA does nothing about a robot that moves when it should answer."""
    return b"" if frame[3] == Sip.MOVING and client.state is ClientState.SYNC0_SENT else frame


def without_tail(frame, _client):
    """A SIP whose length is not that of its readings is none."""
    is_sip = frame[3] in (Sip.STOPPED, Sip.MOVING)
    return b"" if is_sip and frame[2] != 27 + 3 * frame[22] else frame


def read_past_its_end(frame, _client):
    """What is missing of a SIP is taken from whatever stands behind it in memory."""
    if frame[3] not in (Sip.STOPPED, Sip.MOVING):
        return frame
    missing = 27 + 3 * frame[22] - frame[2]
    return encode_frame(frame[3:-2] + b"\xee" * missing, max_count=255) if 0 < missing < 60 else frame


def without_short_config(frame, _client):
    return b"" if frame[3] == 0x20 and frame[2] < 80 else frame


def name_completed(frame, _client):
    """A missing string is taken to be empty, and an empty subclass to be the usual one."""
    if frame[3] != 0x02 or frame[4:-2].count(0) >= 3:
        return frame
    return encode_frame(b"\x02bench\0Pioneer\0p2dx\0")


def two_complement(frame):
    if len(frame) != 9 or frame[4] != 0x1B:
        return frame
    value = 0x10000 - int.from_bytes(frame[5:7], "little")
    return encode_frame(bytes((frame[3], 0x3B)) + value.to_bytes(2, "little"))


def without_length(frame):
    return encode_frame(frame[3:5] + frame[6:-2]) if frame[4] == 0x2B and len(frame) > 8 else frame


class _CrashesOnShortSip(P2osClient):
    """It dies of a SIP that is shorter than it says, and its line with it."""

    def __init__(self, bench, port, chosen):
        super().__init__(bench, port, chosen)
        reader, receive = FrameReader(), self.connection.receive

        def hear(data, now_ns):
            events = receive(data, now_ns)
            for item in reader.receive(data, now_ns):
                is_sip = isinstance(item, Frame) and item.body[0] in (Sip.STOPPED, Sip.MOVING)
                if is_sip and len(item.body) < 25 + 3 * item.body[19]:
                    events += self.connection.line_down(now_ns)
            return events

        self.connection.receive = hear


class _ForgetsWhatIsNotWhole(P2osClient):
    """It takes what each read brings for a packet, as if a line kept their boundaries."""

    def __init__(self, bench, port, chosen):
        super().__init__(bench, port, dataclasses.replace(chosen, frame_timeout_s=0.03))


class _LosesThePacketBehind(P2osClient):
    """Its reader does not look again into a packet that was bad; here, it loses the SIP behind any noise."""

    def __init__(self, bench, port, chosen):
        super().__init__(bench, port, chosen)
        receive, reader = self.connection.receive, FrameReader()
        noisy = False

        def hear(data, now_ns):
            nonlocal noisy
            events = receive(data, now_ns)
            for item in reader.receive(data, now_ns):
                if not isinstance(item, Frame):
                    noisy = True
                elif noisy:
                    noisy = False
                    events = [event for event in events if not isinstance(event, PacketReceived)]
            return events

        self.connection.receive = hear


class _WrapsBadly(P2osClient):
    """It takes the counters for positions."""

    def _keep(self, packet):
        super()._keep(packet)
        if isinstance(packet, Sip) and self.pose is not None:
            pose = Pose(x_mm=packet.x_raw * 0.84, y_mm=packet.y_raw * 0.84, heading_rad=packet.th_raw * 0.001534)
            self.pose = _FixedPose(pose)


class _FixedPose:
    def __init__(self, pose):
        self.pose = pose

    def update(self, _sip):
        return self.pose


class _SwapsWheels(P2osClient):
    def drive_wheels(self, left_mm_s, right_mm_s):
        left, right = (max(-127, min(127, int(speed / 20))) for speed in (left_mm_s, right_mm_s))
        self.send(CommandNumber.VEL2, pack_bytes(right, left))


class _DoesNotClamp(P2osClient):
    def drive_wheels(self, left_mm_s, right_mm_s):
        left, right = (int(speed / 20) & 0xFF for speed in (left_mm_s, right_mm_s))
        self.send(CommandNumber.VEL2, left << 8 | right)


class _SendsWhateverLength(P2osClient):
    def send(self, number, argument=None):
        if not isinstance(argument, bytes) or len(argument) > 250:
            super().send(number, argument)
            return
        body = bytes((number, 0x2B, len(argument))) + argument
        self._actor.transmit(encode_frame(body, max_count=255))


class _StaysAtItsRate(P2osClient):
    def __init__(self, bench, port, chosen):
        super().__init__(bench, port, dataclasses.replace(chosen, bauds=()))


class _ReadsBumpersItHasNot(P2osClient):
    @property
    def reading(self):
        reading, sip = super().reading, self.sips[-1]
        return reading and dataclasses.replace(reading, front_bumpers=sip.front_bumpers, rear_bumpers=sip.rear_bumpers)


class _SwapsStalls(P2osClient):
    @property
    def reading(self):
        reading = super().reading
        return reading and dataclasses.replace(reading, left_stall=reading.right_stall, right_stall=reading.left_stall)


class _OpensWithoutWaiting(P2osClient):
    """It sends all three SYNCs at once."""

    def connect(self):
        super().connect()
        for number in (1, 2):
            self._actor.transmit(encode_frame(bytes((number,))))


class _HangsUpWithoutClose(P2osClient):
    def disconnect(self):
        self.connection.disconnect(self._bench.now_ns)
        self._actor.transmit(b"".join(e.data for e in self.connection.line_down(0) if isinstance(e, Transmit)))


WRONG = {
    "never gives up": (with_options(silent_attempts=10**6), {"C01"}),
    "does not try again": (with_options(silent_attempts=1), {"C01"}),
    "gives up in silence": (instead((_S.SYNC0_SENT, _T.GAVE_UP), _S.FAILED), {"C01"}),
    "does not wait for answers": (_OpensWithoutWaiting, {"C02"}),
    "no SYNC1": (without((_S.SYNC0_SENT, _T.ECHO0)), {"C02", "C03", "C04"}),
    "impatient": (with_options(sync_timeout_s=0.1), {"C03"}),
    "reads are packets": (_ForgetsWhatIsNotWhole, {"C04"}),
    "any echo will do": (instead((_S.SYNC1_SENT, _T.ECHO0), _S.SYNC2_SENT, _A.SEND_SYNC2), {"C05"}),
    "a SYNC error is nothing": (without((_S.SYNC1_SENT, _T.SYNC_ERROR)), {"C06"}),
    "a SYNC error is the end": (instead((_S.SYNC1_SENT, _T.SYNC_ERROR), _S.FAILED, _A.REPORT_FAILED), {"C06"}),
    "an old session is nothing": (without((_S.SYNC0_SENT, _T.SIP)), {"C07", "C08"}),
    "does not wait after CLOSE": (with_options(close_silence_s=0.01), {"C07", "C08"}),
    "a moving robot is out of reach": (hearing(without_motion), {"C08"}),
    "checksums do not matter": (hearing(repaired), {"C09", "C12"}),
    "an unknown robot is no answer": (without((_S.SYNC2_SENT, _T.UNKNOWN_ROBOT)), {"C10"}),
    "an unknown robot is not reported": (instead((_S.SYNC2_SENT, _T.UNKNOWN_ROBOT), _S.FAILED), {"C10"}),
    "guesses who is there": (hearing(name_completed), {"C11"}),
    "a damaged packet ends it all": (_LosesThePacketBehind, {"C13"}),
    "unknown packets are the end": (instead((_S.OPEN, _T.PACKET), _S.LOST, _A.REPORT_LOST), {"C14"}),
    "a SIP has no tail": (hearing(without_tail), {"C15"}),
    "dies of a short SIP": (_CrashesOnShortSip, {"C16"}),
    "reads past the end": (hearing(read_past_its_end), {"C16"}),
    "waits for CONFIG for ever": (without((_S.CONFIGURING, _T.GAVE_UP)), {"C17"}),
    "asks for CONFIG for ever": (with_options(config_wait_s=60.0), {"C17"}),
    "a short CONFIG is none": (hearing(without_short_config), {"C18"}),
    "a dead robot is not noticed": (without((_S.OPEN, _T.SIP_LOST)), {"C19"}),
    "a dead robot is noticed late": (with_options(sip_timeout_s=10.5), {"C19"}),
    "a reset is nothing": (without((_S.OPEN, _T.RESET), (_S.OPEN, _T.ECHO0)), {"C20"}),
    "the pose jumps": (_WrapsBadly, {"C21"}),
    "no keep-alive": (with_options(keepalive_s=None), {"C22"}),
    "a slow keep-alive": (with_options(keepalive_s=1.1), {"C22"}),
    "two's complement": (saying(two_complement), {"C23"}),
    "VEL2 swapped": (_SwapsWheels, {"C24"}),
    "VEL2 runs over": (_DoesNotClamp, {"C24"}),
    "strings of any length": (_SendsWhateverLength, {"C25"}),
    "no length byte": (saying(without_length), {"C25"}),
    "leaves a driving robot": (
        instead((_S.OPEN, _T.DISCONNECT), _S.CLOSED, _A.SEND_CLOSE, _A.REPORT_DISCONNECTED),
        {"C26"},
    ),
    "leaves without CLOSE": (_HangsUpWithoutClose, {"C26"}),
    "knows one rate": (_StaysAtItsRate, {"C27"}),
    "bumpers it has not": (_ReadsBumpersItHasNot, {"C28"}),
    "stalls swapped": (_SwapsStalls, {"C29", "C30"}),
}


def judged(names):
    """What comes of wrong clients, each before its clauses."""
    faults = [
        Fault(name=name, clause_id=clause, open_case=provider(make_client).open_case)
        for name, (make_client, clauses) in WRONG.items()
        if name in names
        for clause in sorted(clauses)
    ]
    return judge(options(), provider(), faults)


def test_clauses_catch_clients_that_are_wrong_for_them():
    verdicts = judged({"two's complement", "VEL2 runs over", "leaves without CLOSE"})
    assert verdicts.not_found == {}
    assert verdicts.found_by == {"C23", "C24", "C26"}


@pytest.mark.exhaustive("forty clients; the gate has three of them, and in test_mutants a wrong client of each clause")
def test_each_clause_catches_each_client_that_is_wrong_for_it():
    verdicts = judged(WRONG)
    assert verdicts.not_found == {}
    assert verdicts.found_by == MUST_FAIL


def slow_to_open(opens_after_s):
    """A client of somebody else that thinks for so long about who the robot is before it opens its session."""

    def begin(bench, port):
        reader, answered = FrameReader(), []

        def say(number):
            port.write(encode_command(Command(number)))

        def keep_alive():
            say(CommandNumber.PULSE)
            bench.scheduler.after(to_ns(0.5), keep_alive)

        def open_session():
            say(CommandNumber.OPEN)
            keep_alive()

        def hear(data, at_ns):
            for item in reader.receive(data, at_ns):
                if len(answered) < 3 and item.body[0] == len(answered):
                    answered.append(item)
                    if len(answered) < 3:
                        say(len(answered))
                    else:
                        bench.scheduler.after(to_ns(opens_after_s), open_session)

        port.on_receive = hear
        bench.scheduler.after(to_ns(0.1), lambda: say(0))

    return begin


@each("opens_after_s", [0.1, 4.0])
def test_who_takes_an_unknown_robot_may_take_time_for_it(opens_after_s):
    shared = Shared(bench_file=open_bench("pioneer"), timeout_scale=1.0, journal=Journal())
    foreign = ForeignClientInBenchTime(shared, P2OS_SERVER, slow_to_open(opens_after_s))
    cases = run_suites(options("C10"), foreign).cases
    assert {case.id: case.cause for case in cases if case.verdict not in (Verdict.PASS, Verdict.NOT_APPLICABLE)} == {}
    assert sum(case.verdict is Verdict.PASS for case in cases) == 1


class SaysAgain(P2osClient):
    """Says what it was told last of some commands again in each cycle, as ARIA does."""

    def __init__(self, bench, port, client_options):
        super().__init__(bench, port, client_options)
        self._bench = bench
        self._told = {}

    def send(self, number, argument=None):
        first = not self._told
        if number in (CommandNumber.VEL, CommandNumber.RVEL, CommandNumber.HEAD):
            self._told[number] = argument
            if first:
                self._bench.scheduler.after(to_ns(0.1), self._again, source="~again")
        super().send(number, argument)

    def _again(self):
        for number, argument in self._told.items():
            super().send(number, argument)
        self._bench.scheduler.after(to_ns(0.1), self._again, source="~again")


def test_who_says_a_command_again_is_right():
    again = run_suites(options("C33"), provider(SaysAgain))
    assert [(clause.verdict, clause.cause) for clause in again.clauses] == [(Verdict.PASS, "")]
