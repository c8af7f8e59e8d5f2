"""Both ends against each other, over a line that loses, damages, repeats and delays."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from protocols.autoware import (
    AckermannControlCommand,
    AgentFound,
    AgentState,
    BoardFound,
    BoardLost,
    BoardState,
    Connection,
    ControlModeReport,
    ControlModeRequest,
    ControlModeResponse,
    MessageReceived,
    Role,
    Sender,
    Transmit,
)
from protocols.testing import LATENCY_NS, Pair, lossy, unchanged
from tests.share import examples, seeds

MS = 1_000_000
SECOND = 1000 * MS
PERIOD_NS = 50 * MS


class Vehicle(Pair):
    """A driving stack (the client) that commands 20 times a second, and a board that reports as often."""

    def __init__(self, damage=unchanged):
        super().__init__(Connection(Role.AGENT), Connection(Role.BOARD), transmit=Transmit, damage=damage)
        self.talking = {"client": True, "server": True}
        self.sent = {"client": [], "server": []}
        self._next_ns_of_talk = 0

    def answer(self, end, event):
        if isinstance(event, MessageReceived) and isinstance(event.message, ControlModeRequest):
            self.send(end, ControlModeResponse(sequence=event.message.sequence, success=True))

    def moment(self):
        if self.now_ns < self._next_ns_of_talk:
            return
        self._next_ns_of_talk = self.now_ns + PERIOD_NS
        step = self.now_ns // PERIOD_NS
        messages = {"client": AckermannControlCommand(speed=float(step)), "server": ControlModeReport(mode=step % 5)}
        for end, message in messages.items():
            if self.talking[end]:
                self.sent[end].append(message)
                self.send(end, message)

    def next_moment_ns(self):
        return self._next_ns_of_talk

    def heard(self, end):
        other = {"client": "server", "server": "client"}[end]
        kind = type(self.sent[other][0])
        messages = [event.message for _, at, event in self.seen if at == end and isinstance(event, MessageReceived)]
        return [message for message in messages if isinstance(message, kind)]


def test_everything_arrives_in_order_on_a_sound_line():
    pair = Vehicle()
    pair.connect()
    pair.run(3 * SECOND - LATENCY_NS)
    for end, other in (("client", "server"), ("server", "client")):
        assert pair.heard(end) == pair.sent[other]
    assert len(pair.of(AgentFound)) == len(pair.of(BoardFound)) == 1
    assert pair.server.state is BoardState.ONLINE


def test_a_request_has_its_response():
    pair = Vehicle()
    pair.connect()
    pair.send("client", ControlModeRequest(sequence=200, mode=1))
    pair.run(2 * LATENCY_NS)
    assert MessageReceived(message=ControlModeResponse(sequence=200, success=True)) in pair.of(MessageReceived)


def test_a_board_that_falls_silent_is_lost_and_found_again():
    pair = Vehicle()
    pair.connect()
    pair.run(SECOND)
    pair.talking["server"] = False
    pair.run(2 * SECOND)
    assert pair.client.state is AgentState.ALONE
    pair.talking["server"] = True
    pair.run(SECOND)
    assert pair.client.state is AgentState.HEARD
    assert (len(pair.of(BoardLost)), len(pair.of(BoardFound))) == (1, 2)


@pytest.mark.parametrize("seed", seeds(6, 2))
def test_on_a_faulty_line_what_arrives_was_sent(seed):
    pair = Vehicle(lossy(seed, drop=0.2, flip=0.2, repeat=0.1, noise=0.3))
    pair.connect()
    pair.run(30 * SECOND)
    for end, other in (("client", "server"), ("server", "client")):
        heard = pair.heard(end)
        assert all(message in pair.sent[other] for message in heard)
        assert len(heard) > len(pair.sent[other]) // 2
    assert pair.server.state is BoardState.ONLINE
    assert pair.client.counters.bad_crcs + pair.client.counters.cut_short > 0


@settings(max_examples=examples(60))
@given(st.lists(st.tuples(st.sampled_from(["client", "server"]), st.integers(0, 2 * SECOND)), max_size=12))
def test_a_line_that_goes_down_at_any_time_comes_back(pauses):
    pair = Vehicle()
    pair.connect()
    for end, pause_ns in pauses:
        pair.talking[end] = not pair.talking[end]
        pair.run(pause_ns)
        pair.line_down()
        pair.connect()
    pair.talking = {"client": True, "server": True}
    pair.run(SECOND)
    assert pair.client.state is AgentState.HEARD
    assert pair.server.state is BoardState.ONLINE


def test_each_message_survives_both_directions(messages, alike):
    @given(st.lists(messages(Sender.AGENT)), st.lists(messages(Sender.BOARD)))
    def check(commands, reports):
        for role, other, sent in ((Role.AGENT, Role.BOARD, commands), (Role.BOARD, Role.AGENT, reports)):
            sender, receiver = Connection(role), Connection(other)
            data = b"".join(sender.send(message, 0) for message in sent)
            events = receiver.receive(data, 0)
            got = [event.message for event in events if isinstance(event, MessageReceived)]
            handled = ("AgentOnline", "AgentPing")  # the machine's own
            expected = [message for message in sent if type(message).__name__ not in handled]
            assert len(got) == len(expected)
            assert all(alike(one, two) for one, two in zip(got, expected, strict=True))
            assert receiver.counters.frames_in == len(sent)

    check()
