"""Both roles against each other over a faulty line: no reliable message is lost or doubled, the order is kept."""

from __future__ import annotations

import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, rule

from protocols import xrce
from protocols.testing import lossy
from protocols.xrce import AgentState, ClientState, CloseReason
from tests.each import each
from tests.protocols.xrce.conftest import Line
from tests.share import examples, seeds

MS = 1_000_000
SECOND = 1000 * MS

ENDS = ("client", "server")
STREAMS = (0x80, 0x81, 1)
FAULTS = {
    "lost": {"drop": 0.2},
    "turned": {"flip": 0.2},
    "twice": {"repeat": 0.3},
    "noise": {"noise": 0.5},
    "all": {"drop": 0.1, "flip": 0.1, "repeat": 0.1, "noise": 0.3},
}


def numbered(count, size):
    return [number.to_bytes(4, "big") * (1 + (number * 7919) % size) for number in range(count)]


def exchange(pair, messages, *, patience_s=600):
    """Both programs say all of it as fast as there is room, until all of it is acknowledged."""
    waiting = {"client": list(messages), "server": list(messages)}
    end_ns = pair.now_ns + patience_s * SECOND
    while pair.now_ns < end_ns and (any(waiting.values()) or pair.client.unacknowledged or pair.server.unacknowledged):
        for end, left in waiting.items():
            while left:
                try:
                    pair.say(end, left[0])
                except xrce.StreamFullError:
                    break
                del left[0]
        pair.run(20 * MS)


@pytest.mark.parametrize("fault", FAULTS)
@pytest.mark.parametrize("seed", seeds(8, 1))
def test_on_a_faulty_line_everything_arrives_once_and_in_order(fault, seed):
    pair = Line(damage=lossy(seed, **FAULTS[fault]), mtu=128, max_queued=2000)
    pair.connect()
    pair.run(30 * SECOND)
    messages = numbered(40, 60)  # up to 240 bytes: one message, or three fragments
    exchange(pair, messages)
    assert pair.heard("server") == pair.heard("client") == messages
    counters = (pair.client.counters, pair.server.counters)
    assert sum(one.repeated + one.stale + one.noise for one in counters) > 0
    assert [one.lost for one in counters] == [0, 0]
    assert pair.of(xrce.Senseless) == []


@pytest.mark.exhaustive("half a minute for each: three thousand messages each way; the gate has forty")
@pytest.mark.parametrize("fault", FAULTS)
def test_three_thousand_messages(fault):
    pair = Line(damage=lossy(26, **FAULTS[fault]), mtu=128, max_queued=2000)
    pair.connect()
    pair.run(30 * SECOND)
    messages = numbered(1000, 30)
    for _ in range(3):
        exchange(pair, messages, patience_s=100_000)
        assert pair.heard("server") == pair.heard("client") == messages
        pair.seen.clear()


def test_a_client_that_never_reads_does_not_make_the_agent_grow():
    pair = Line(max_queued=5000)
    pair.connect()
    pair.run(SECOND)
    deaf = {"client": 0}
    whole = pair.client.receive

    def hears_nothing(data, now_ns):
        deaf["client"] += len(data)
        return []

    pair.client.receive = hears_nothing
    refused = 0
    for _ in range(2000):
        try:
            pair.say("server", bytes(400))
        except xrce.StreamFullError:
            refused += 1
        pair.say("server", bytes(400), stream_id=1)
        pair.run(10 * MS)
        assert pair.server.held <= 16 * 512 + 5000
    assert refused > 1900
    assert deaf["client"] > 800_000
    pair.client.receive = whole
    pair.run(10 * SECOND)
    assert pair.server.held == pair.server.unacknowledged == 0


def test_a_peer_that_sends_only_beginnings_does_not_make_the_agent_grow():
    pair = Line(max_message=3000)
    pair.connect()
    pair.run(SECOND)
    for stream_id in range(128, 256):
        for number in (0, 1, 2, 3, 5, 6, 7):
            header = xrce.Header(session_id=0x81, stream_id=stream_id, sequence=number)
            piece = xrce.encode_submessage(xrce.Fragment(data=bytes(1000)))
            pair.write("client", xrce.encode_frame(xrce.encode_message(header, piece)))
    pair.run(SECOND)
    assert pair.server.held <= 16 * (3 * 1004 + 3000)


@each("who", ["agent", "client", "both"])
def test_a_restart_of_either_end_is_got_over(who):
    pair = Line()
    pair.connect()
    pair.run(SECOND)
    for step in range(20):
        pair.say("client", bytes((step,)))
        pair.say("server", bytes((step,)))
        pair.run((step % 5) * 3 * MS)
        fresh = Line()
        if who != "client":
            pair.server = fresh.server
        if who != "agent":
            pair.client = fresh.client
        else:
            pair._take("client", pair.client.line_down(pair.now_ns))
        pair.connect()
        pair.run(SECOND)
        assert (pair.client.state, pair.server.state) == (ClientState.OPEN, AgentState.OPEN)
        assert pair.client.held == pair.server.held == 0
    pair.seen.clear()
    exchange(pair, numbered(20, 5))
    assert pair.heard("server") == pair.heard("client") == numbered(20, 5)


class AnyUse(RuleBasedStateMachine):
    """Programs at both ends do what they like, the line too; what is said in a session is heard once, in order."""

    def __init__(self):
        super().__init__()
        self.pair = Line(mtu=64, max_queued=1000)
        self.said = {"client": [], "server": []}
        self.mute = False
        self.pair.damage = lambda data: b"" if self.mute else data

    @rule(ms=st.integers(1, 1500))
    def time_passes(self, ms):
        self.pair.run(ms * MS)

    @rule(mute=st.booleans())
    def line_is_cut_or_mended(self, mute):
        self.mute = mute

    @rule(
        data=st.binary(max_size=150),
        end=st.sampled_from(["client", "server"]),
        stream_id=st.sampled_from([0x80, 0x81, 1]),
    )
    def program_says(self, data, end, stream_id):
        try:
            self.pair.say(end, data[:40] if stream_id == 1 else data, stream_id=stream_id)
        except xrce.LocalProtocolError:
            return
        self.said[end].append((stream_id, data[:40] if stream_id == 1 else data))

    @rule()
    def client_connects(self):
        if self.pair.client.state is ClientState.CLOSED:
            self.pair.connect()

    @rule()
    def client_leaves(self):
        if self.pair.client.state in (ClientState.OPEN, ClientState.CONNECTING):
            self.pair.disconnect()

    @rule()
    def line_goes_down(self):
        self.pair.line_down()

    @rule(noise=st.binary(min_size=1, max_size=10))
    def noise_on_the_line(self, noise):
        self.pair.write("client", noise)
        self.pair.write("server", noise)

    @invariant()
    def nothing_is_heard_that_was_not_said_nor_oftener_nor_in_another_order(self):
        for end, other in (("client", "server"), ("server", "client")):
            for stream_id in STREAMS:
                said = iter([data for stream, data in self.said[other] if stream == stream_id])
                assert all(data in said for data in self.pair.heard(end, stream_id=stream_id))

    @invariant()
    def nothing_is_overdue_and_little_is_held(self):
        for session in (self.pair.client, self.pair.server):
            deadline_ns = session.next_deadline_ns()
            assert deadline_ns is None or deadline_ns >= self.pair.now_ns
            assert session.held <= 2 * (16 * 64 + 1000) + 2 * (16 * 64 + 1000) + 300

    @invariant()
    def sessions_open_and_close_in_turn(self):
        for end in ("client", "server"):
            there = False
            for _, at, event in self.pair.seen:
                if at == end and isinstance(event, xrce.SessionOpened):
                    assert event.again is there
                    there = True
                elif at == end and isinstance(event, xrce.SessionClosed):
                    assert there or event.reason in (CloseReason.NO_ANSWER, CloseReason.LINE_DOWN, CloseReason.DELETED)
                    there = False

    def teardown(self):
        """However it went, on a good line both ends find together, and what is said arrives."""
        self.mute = False
        self.pair.run(30 * SECOND)
        if self.pair.client.state is ClientState.OPEN:
            self.pair._take("client", self.pair.client.line_down(self.pair.now_ns))
        self.pair.connect()
        self.pair.run(3 * SECOND)
        self.pair.seen.clear()
        self.pair.say("client", b"at last")
        self.pair.run(SECOND)
        assert self.pair.heard("server") == [b"at last"]


TestAnyUse = AnyUse.TestCase
TestAnyUse.settings = settings(max_examples=examples(60), stateful_step_count=25)
