"""Both roles against each other, over a line that loses, damages and delays, with time as a rule."""

from __future__ import annotations

import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule

from protocols.p2os import (
    ClientOptions,
    Command,
    CommandReceived,
    ConfigPacket,
    Connected,
    Connection,
    LocalProtocolError,
    PacketReceived,
    Role,
    ServerOptions,
    SessionClosed,
    SessionOpened,
    Sip,
    Transmit,
    WatchdogExpired,
    WatchdogRevived,
)
from protocols.p2os import (
    ClientState as C,
)
from protocols.p2os import (
    CommandNumber as N,
)
from protocols.p2os import (
    ServerState as S,
)
from protocols.testing import Pair, lossy, unchanged
from tests.share import examples, seeds

SECOND = 1_000_000_000
CYCLE_NS = SECOND // 10
WATCHDOG_NS = 2 * SECOND


class RobotPair(Pair):
    """A client and a server, a line with faults between them, and a server that streams SIPs while it is open."""

    def __init__(self, *, damage=unchanged, client=None, server=None):
        ends = (
            Connection(Role.CLIENT, client or ClientOptions()),
            Connection(Role.SERVER, server or ServerOptions()),
        )
        super().__init__(*ends, transmit=Transmit, damage=damage)

    def next_moment_ns(self):
        return (self.now_ns // CYCLE_NS + 1) * CYCLE_NS

    def moment(self):
        if self.now_ns % CYCLE_NS == 0 and self.server.state is S.OPEN:
            self.send("server", Sip(x_raw=self.now_ns // CYCLE_NS & 0x7FFF))

    def answer(self, end, event):
        if isinstance(event, CommandReceived) and event.command.number == N.CONFIG:
            self.send("server", ConfigPacket(name="pair"))


def test_clean_line():
    pair = RobotPair()
    pair.connect()
    pair.run(SECOND)
    assert (pair.client.state, pair.server.state) == (C.OPEN, S.OPEN)
    (connected,) = pair.of(Connected)
    assert connected.config == ConfigPacket(name="pair")
    pair.run(60 * SECOND)
    assert len(pair.of(PacketReceived)) > 590
    assert pair.of(WatchdogExpired) == []
    pair.disconnect()
    pair.run(SECOND)
    assert (pair.client.state, pair.server.state) == (C.CLOSED, S.WAIT)
    assert [command.number for command in (event.command for event in pair.of(CommandReceived))][-1] == N.ENABLE


@pytest.mark.parametrize("seed", seeds(20, 5))
def test_bad_line(seed):
    pair = RobotPair(
        damage=lossy(seed, drop=0.05, flip=0.05, repeat=0.05, noise=0.1),
        client=ClientOptions(max_restarts=100, max_misses=100),
    )
    pair.connect()
    pair.run(60 * SECOND)
    assert pair.client.state is C.OPEN
    assert pair.server.state is S.OPEN
    counters = pair.client.counters
    assert counters.noise + counters.bad_checksums + counters.bad_counts + counters.timed_out > 0
    received = [event.packet for event in pair.of(PacketReceived) if isinstance(event.packet, Sip)]
    assert len(received) > 400
    assert len({sip.x_raw for sip in received}) <= len(received)
    pair.damage = lambda data: data
    pair.disconnect()
    pair.run(SECOND)
    assert (pair.client.state, pair.server.state) == (C.CLOSED, S.WAIT)


def test_client_that_died_is_replaced_by_one_that_takes_over():
    pair = RobotPair()
    pair.connect()
    pair.run(SECOND)
    pair.client = Connection(Role.CLIENT)
    pair.run(SECOND // 2)
    pair.connect()
    pair.run(2 * SECOND)
    assert (pair.client.state, pair.server.state) == (C.OPEN, S.OPEN)
    assert len(pair.of(SessionClosed)) == 1
    assert len(pair.of(SessionOpened)) == 2


def test_same_seed_same_story():
    stories = []
    for _ in range(2):
        pair = RobotPair(damage=lossy(7, drop=0.1, flip=0.1, noise=0.2))
        pair.connect()
        pair.run(20 * SECOND)
        stories.append(pair.seen)
    assert stories[0] == stories[1]


class AnyUse(RuleBasedStateMachine):
    """Users, faults and time in any order; the model knows what the line carried, not what the machines hold."""

    def __init__(self):
        super().__init__()
        self.mute = False
        self.sound = True
        self.pair = RobotPair(damage=self._damage)
        self.last_to_server_ns = None

    def _damage(self, data):
        return b"" if self.mute else data

    @rule(tenths=st.integers(1, 30))
    def time_passes(self, tenths):
        self.pair.run(tenths * SECOND // 10)

    @rule()
    def line_is_cut(self):
        self.mute = True

    @rule()
    def line_is_mended(self):
        self.mute = False

    @rule()
    def line_goes_down(self):
        self.pair.line_down()
        assert self.pair.server.state is S.WAIT
        assert self.pair.client.state in (C.IDLE, C.FAILED, C.LOST, C.CLOSED)

    @precondition(lambda self: self.pair.client.state in (C.IDLE, C.FAILED, C.LOST, C.CLOSED))
    @rule()
    def user_connects(self):
        self.pair.connect()
        assert self.pair.client.state is C.SYNC0_SENT

    @precondition(lambda self: self.pair.client.state not in (C.IDLE, C.FAILED, C.LOST, C.CLOSED, C.CLOSING))
    @rule()
    def user_disconnects(self):
        self.pair.disconnect()
        assert self.pair.client.state in (C.CLOSING, C.CLOSED)

    @rule(speed=st.integers(-500, 500))
    def user_drives(self, speed):
        state, deadline = self.pair.client.state, self.pair.client.next_deadline_ns()
        try:
            self.pair.send("client", Command(N.VEL, speed))
        except LocalProtocolError:
            assert state is not C.OPEN
            assert self.pair.client.next_deadline_ns() == deadline
        else:
            assert state is C.OPEN
        assert self.pair.client.state is state

    @rule(noise=st.binary(min_size=1, max_size=10))
    def noise_on_the_line(self, noise):
        self.pair.write("client", noise)
        self.pair.write("server", noise)

    @invariant()
    def watchdog_and_its_revival_take_turns(self):
        story = [event for _, end, event in self.pair.seen if end == "server"]
        expired = opened = False
        for event in story:
            if isinstance(event, SessionOpened):
                assert not opened
                opened, expired = True, False
            elif isinstance(event, SessionClosed):
                assert opened
                opened = False
            elif isinstance(event, WatchdogExpired):
                assert opened
                assert not expired
                expired = True
            elif isinstance(event, WatchdogRevived):
                assert expired
                expired = False
            elif isinstance(event, CommandReceived):
                assert opened
                assert not expired
        assert opened is (self.pair.server.state is S.OPEN)

    @invariant()
    def watchdog_expires_only_after_its_time(self):
        last_ns = 0
        for now_ns, end, event in self.pair.seen:
            if end == "server" and isinstance(event, SessionOpened | CommandReceived):
                last_ns = now_ns
            if isinstance(event, WatchdogExpired):
                assert now_ns - last_ns == WATCHDOG_NS

    @invariant()
    def nothing_is_overdue_and_little_is_held(self):
        for connection in (self.pair.client, self.pair.server):
            deadline_ns = connection.next_deadline_ns()
            assert deadline_ns is None or deadline_ns >= self.pair.now_ns
            assert connection.held <= 256

    def teardown(self):
        """However it went, on a good line a patient user gets a session."""
        self.mute = False
        self.pair.run(12 * SECOND)
        if self.pair.client.state in (C.IDLE, C.FAILED, C.LOST, C.CLOSED):
            self.pair.connect()
        self.pair.run(20 * SECOND)
        assert self.pair.client.state is C.OPEN
        assert self.pair.server.state is S.OPEN


TestAnyUse = AnyUse.TestCase
TestAnyUse.settings = settings(max_examples=examples(60), stateful_step_count=25)
