"""The server role: handshake, session, watchdog; and every edge of each of its tables."""

from __future__ import annotations

from collections import Counter

import pytest

from protocols.p2os import (
    SERVER_TABLE,
    Command,
    CommandReceived,
    Connection,
    ControllerReset,
    DropReason,
    FrameDropped,
    Identification,
    LocalProtocolError,
    RemoteProtocolError,
    Role,
    ServerOptions,
    ServerTrigger,
    SessionClosed,
    SessionOpened,
    Sip,
    StateChanged,
    SyncError,
    Transmit,
    WatchdogExpired,
    WatchdogRevived,
    WrongOrder,
    encode_command,
    encode_frame,
    encode_packet,
    server_table,
)
from protocols.p2os import (
    CommandNumber as N,
)
from protocols.p2os import (
    ServerState as S,
)
from protocols.p2os.events import CloseReason
from tests.each import each

SECOND = 1_000_000_000
SYNC = [encode_frame(bytes((number,))) for number in range(3)]
BENCH = Identification(name="bench", subclass="p2dx")
IDENTITY = encode_packet(BENCH)
ERROR = encode_packet(SyncError())
OPEN_1, CLOSE_1 = encode_command(Command(N.OPEN, 1)), encode_command(Command(N.CLOSE, 1))
VEL = encode_command(Command(N.VEL, 200))
UNREADABLE = encode_frame(bytes.fromhex("0B 3C 01 00"))


class Robot:
    """A server and what came of it."""

    def __init__(self, **options):
        self.connection = Connection(Role.SERVER, ServerOptions(identification=BENCH, **options))
        self.now_ns = 0
        self.events = []

    def receive(self, data):
        """What is answered to the data."""
        self.events = self.connection.receive(data, self.now_ns)
        return self.replies()

    def wait(self, seconds):
        self.now_ns += round(seconds * SECOND)
        self.events = self.connection.advance(self.now_ns)
        return [type(event) for event in self.events]

    def line_down(self):
        self.events = self.connection.line_down(self.now_ns)

    def replies(self):
        return b"".join(event.data for event in self.events if isinstance(event, Transmit))

    def commands(self):
        return [event.command for event in self.events if isinstance(event, CommandReceived)]

    def has(self, kind):
        return any(isinstance(event, kind) for event in self.events)

    @property
    def state(self):
        return self.connection.state


STEPS = {S.WAIT: [], S.WAIT1: SYNC[:1], S.WAIT2: SYNC[:2], S.READY: SYNC, S.OPEN: [*SYNC, OPEN_1]}


def robot_in(state, **options):
    robot = Robot(**options)
    for data in STEPS[state]:
        robot.receive(data)
    assert robot.state is state
    return robot


def test_handshake_step_by_step():
    robot = Robot()
    assert robot.receive(SYNC[0]) == SYNC[0]
    assert robot.receive(SYNC[1]) == SYNC[1]
    assert robot.receive(SYNC[2]) == IDENTITY
    assert robot.receive(OPEN_1) == b""
    assert robot.has(SessionOpened)


@each("opening", [SYNC[1], OPEN_1])
def test_open_with_and_without_an_argument(opening):
    robot = robot_in(S.READY)
    assert robot.receive(opening) == b""
    assert robot.state is S.OPEN


@each("closing", [SYNC[2], CLOSE_1])
def test_close_with_and_without_an_argument(closing):
    robot = robot_in(S.OPEN)
    assert robot.receive(closing) == b""
    assert SessionClosed(reason=CloseReason.CLOSED) in robot.events
    assert robot.state is S.WAIT
    assert robot.receive(SYNC[0]) == SYNC[0]


def test_radio_modem_preamble_does_no_harm():
    assert Robot().receive(b"WMS2\r" + SYNC[0]) == SYNC[0]


def test_three_syncs_in_a_live_session_end_it_without_an_echo():
    robot = robot_in(S.OPEN)
    assert robot.receive(b"".join(SYNC)) == b""
    assert robot.state is S.WAIT


@each("state", [S.WAIT, S.WAIT1, S.WAIT2, S.READY])
@each("data", [VEL, CLOSE_1, UNREADABLE, SYNC[0][:-1] + b"\x01"])
def test_nothing_else_before_the_session(state, data):
    robot = robot_in(state)
    assert robot.receive(data) == b""
    assert robot.state is state
    assert not robot.has(CommandReceived)


@each("state", [S.WAIT, S.WAIT1, S.WAIT2])
@each("policy", WrongOrder)
def test_an_early_open_with_an_argument_is_no_sync(state, policy):
    robot = robot_in(state, wrong_order=policy)
    assert robot.receive(OPEN_1) == b""
    assert robot.state is state


@each("state", [S.WAIT, S.WAIT1, S.WAIT2, S.READY])
def test_sync0_restarts_from_anywhere(state):
    robot = robot_in(state)
    assert robot.receive(SYNC[0]) == SYNC[0]
    assert robot.state is S.WAIT1


@each(("state", "last"), [(S.WAIT1, 0), (S.WAIT2, 1), (S.READY, 2)])
@each("policy", WrongOrder)
def test_a_repeat_is_answered_again(state, last, policy):
    robot = robot_in(state, wrong_order=policy)
    assert robot.receive(SYNC[last]) == (IDENTITY if last == 2 else SYNC[last])
    assert robot.state is state


@each(
    ("policy", "state", "number", "reply", "after"),
    [
        (WrongOrder.REFUSE, S.WAIT, 1, b"", S.WAIT),
        (WrongOrder.REFUSE, S.WAIT, 2, b"", S.WAIT),
        (WrongOrder.REFUSE, S.WAIT1, 2, ERROR, S.WAIT1),
        (WrongOrder.ADOPT, S.WAIT, 1, SYNC[1], S.WAIT2),
        (WrongOrder.ADOPT, S.WAIT, 2, IDENTITY, S.READY),
        (WrongOrder.ADOPT, S.WAIT1, 2, IDENTITY, S.READY),
        (WrongOrder.REECHO, S.WAIT, 1, SYNC[0], S.WAIT),
        (WrongOrder.REECHO, S.WAIT, 2, SYNC[0], S.WAIT),
        (WrongOrder.REECHO, S.WAIT1, 2, SYNC[1], S.WAIT1),
        (WrongOrder.RESTART, S.WAIT1, 2, b"", S.WAIT),
        (WrongOrder.IGNORE, S.WAIT1, 2, b"", S.WAIT1),
    ],
)
def test_syncs_out_of_order(policy, state, number, reply, after):
    robot = robot_in(state, wrong_order=policy)
    assert robot.receive(SYNC[number]) == reply
    assert robot.state is after
    for data in (*SYNC, OPEN_1):
        robot.receive(data)
    assert robot.state is S.OPEN


def test_commands_in_one_write_come_in_order():
    robot = robot_in(S.OPEN)
    sent = [Command(N.ENABLE, 1), Command(N.PULSE), Command(N.VEL, -5), Command(200, b"?"), Command(N.SAY, b"\1\2")]
    robot.receive(b"".join(map(encode_command, sent)))
    assert robot.commands() == sent


def test_open_in_a_session_is_a_command_like_any_other():
    robot = robot_in(S.OPEN)
    robot.receive(OPEN_1 + SYNC[1])
    assert robot.commands() == [Command(N.OPEN, 1), Command(N.OPEN)]
    assert not robot.has(SessionOpened)


def test_watchdog_expires_once_and_the_next_packet_revives():
    robot = robot_in(S.OPEN)
    assert robot.connection.next_deadline_ns() == 2 * SECOND
    assert robot.wait(1.999) == []
    assert robot.wait(0.001) == [WatchdogExpired]
    assert robot.wait(100) == []
    assert robot.state is S.OPEN
    robot.receive(SYNC[0])
    assert [type(event) for event in robot.events] == [WatchdogRevived, CommandReceived]
    assert robot.wait(2) == [WatchdogExpired]
    assert robot.connection.counters.watchdog_expiries == 2


@each("feed", [SYNC[0], VEL, encode_command(Command(200)), UNREADABLE])
def test_any_sound_frame_feeds_the_watchdog(feed):
    robot = robot_in(S.OPEN)
    for _ in range(5):
        assert robot.wait(1.9) == []
        robot.receive(feed)


def test_damaged_frames_do_not_feed_the_watchdog():
    robot = robot_in(S.OPEN)
    robot.wait(1.9)
    robot.receive(VEL[:-1] + b"\x00")
    assert robot.wait(0.1) == [WatchdogExpired]


def test_watchdog_that_only_warns_nobody():
    robot = robot_in(S.OPEN, watchdog_s=None)
    assert robot.connection.next_deadline_ns() is None
    assert robot.wait(3600) == []


@each("silence_s", [0, -1.0, float("nan")])
def test_a_watchdog_needs_a_time_above_0(silence_s):
    with pytest.raises(LocalProtocolError, match="watchdog_s is"):
        ServerOptions(watchdog_s=silence_s)


def test_watchdog_ends_with_the_session():
    robot = robot_in(S.OPEN)
    robot.receive(CLOSE_1)
    assert robot.connection.next_deadline_ns() is None
    for data in STEPS[S.OPEN]:
        robot.receive(data)
    assert not robot.has(WatchdogRevived)


def test_a_packet_at_the_very_end_comes_after_the_watchdog():
    robot = robot_in(S.OPEN)
    robot.now_ns = 2 * SECOND
    robot.receive(VEL)
    assert [type(event) for event in robot.events] == [WatchdogExpired, WatchdogRevived, CommandReceived]


def test_handshake_limit():
    robot = robot_in(S.READY, handshake_limit_s=10)
    robot.wait(10)
    assert robot.events == [StateChanged(old=S.READY, new=S.WAIT, trigger=ServerTrigger.HANDSHAKE_LIMIT)]
    opened = robot_in(S.OPEN, handshake_limit_s=10, watchdog_s=None)
    assert opened.wait(20) == []


@each("state", [S.WAIT1, S.WAIT2, S.READY, S.OPEN])
def test_line_down_forgets_the_client(state):
    robot = robot_in(state)
    robot.receive(SYNC[0][:3])
    robot.line_down()
    assert robot.state is S.WAIT
    assert robot.has(SessionClosed) is (state is S.OPEN)
    assert robot.connection.held == 0
    assert robot.receive(SYNC[0]) == SYNC[0]


def test_string_for_an_integer_command_is_dropped():
    robot = robot_in(S.OPEN)
    raw = encode_command(Command(N.VEL, b"200"))
    robot.receive(raw)
    assert robot.events == [FrameDropped(reason=DropReason.BAD_BODY, data=raw)]
    assert robot.connection.counters.bad_bodies == 1


def test_counters():
    robot = robot_in(S.OPEN)
    robot.receive(b"junk" + VEL + b"\xfa\xfb\x01" + VEL[:-1] + b"\x00" + b"\xfa\xfb\x09")
    robot.wait(1)
    counters = robot.connection.counters
    assert (counters.noise, counters.bad_counts, counters.bad_checksums, counters.timed_out) == (1, 1, 1, 1)
    assert (counters.frames_in, counters.frames_out) == (5, 3)
    assert counters.bytes_in == sum(map(len, STEPS[S.OPEN])) + 4 + 9 + 3 + 9 + 3
    assert counters.bytes_out == 12 + len(IDENTITY)


def test_time_does_not_run_backwards():
    robot = robot_in(S.OPEN)
    robot.wait(1)
    robot.now_ns = 0
    robot.receive(VEL)
    assert robot.connection.next_deadline_ns() == 3 * SECOND


@each("state", [S.WAIT, S.WAIT1, S.WAIT2, S.READY])
def test_nothing_can_be_sent_before_the_session(state):
    robot = robot_in(state)
    before = (robot.connection.counters, robot.connection.next_deadline_ns())
    with pytest.raises(LocalProtocolError, match=state.name):
        robot.connection.send(Sip(), robot.now_ns)
    assert robot.state is state
    assert (robot.connection.counters, robot.connection.next_deadline_ns()) == before


@each("message", [Command(N.VEL, 1), BENCH, SyncError(), Sip(x_raw=-1)])
def test_wrong_messages_of_a_server_change_nothing(message):
    robot = robot_in(S.OPEN)
    sent = robot.connection.counters.frames_out
    with pytest.raises(LocalProtocolError):
        robot.connection.send(message, robot.now_ns + SECOND)
    assert robot.state is S.OPEN
    assert robot.connection.counters.frames_out == sent
    assert robot.connection.next_deadline_ns() == 2 * SECOND


def test_sending_packets():
    robot = robot_in(S.OPEN)
    assert robot.connection.send(Sip(), 0) == encode_packet(Sip())
    assert robot.connection.send(ControllerReset(), 0) == ERROR


@each("call", ["connect", "disconnect"])
def test_a_server_neither_connects_nor_leaves(call):
    with pytest.raises(LocalProtocolError, match="server"):
        getattr(Robot().connection, call)(0)


@each(
    "options",
    [
        {"watchdog_s": 0},
        {"frame_timeout_s": -1},
        {"identification": Identification(name="x" * 20, subclass="p2dx")},
        {"identification": Identification(name="a\0", subclass="p2dx")},
    ],
)
def test_options_that_make_no_sense(options):
    with pytest.raises(LocalProtocolError):
        ServerOptions(**options)


def test_maximum_count_is_an_option():
    long = encode_frame(bytes((N.SAY, 0x2B, 200)) + b"\x01" * 200, max_count=207)
    for limit, received in ((200, []), (207, [Command(N.SAY, b"\x01" * 200)])):
        robot = robot_in(S.OPEN, max_count=limit)
        robot.receive(long)
        assert robot.commands() == received


TRIGGERS = {
    ServerTrigger.SYNC0_PULSE: SYNC[0],
    ServerTrigger.SYNC1_OPEN: SYNC[1],
    ServerTrigger.SYNC2_CLOSE: SYNC[2],
    ServerTrigger.OPEN_1: OPEN_1,
    ServerTrigger.CLOSE_1: CLOSE_1,
    ServerTrigger.COMMAND: VEL,
    ServerTrigger.UNREADABLE: UNREADABLE,
}


def provoke(robot, trigger):
    """Makes the trigger happen by what really causes it."""
    if trigger in TRIGGERS:
        robot.receive(TRIGGERS[trigger])
    elif trigger is ServerTrigger.LINE_DOWN:
        robot.line_down()
    else:
        robot.wait(10)


@each("policy", WrongOrder)
def test_every_pair_of_state_and_trigger(policy):
    table = server_table(policy)
    visits = Counter()
    for state in S:
        for trigger in ServerTrigger:
            edge = table.get((state, trigger))
            if edge is None and trigger in (ServerTrigger.WATCHDOG, ServerTrigger.HANDSHAKE_LIMIT):
                continue  # its timer does not run there, so nothing can make it happen
            robot = robot_in(state, wrong_order=policy, handshake_limit_s=10, watchdog_s=10)
            ignored = robot.connection.counters.ignored
            provoke(robot, trigger)
            assert robot.state is (edge.next_state if edge else state)
            assert (robot.connection.visits[state, trigger] == 1) is (edge is not None)
            if edge is None:
                assert robot.connection.counters.ignored == ignored + 1
                assert not any(isinstance(event, Transmit | CommandReceived) for event in robot.events)
            visits += robot.connection.visits
    assert set(visits) == set(table)


def test_default_table_is_the_one_documented():
    assert server_table() == SERVER_TABLE
    assert ServerOptions().wrong_order is WrongOrder.REFUSE


def test_another_table_can_be_run():
    without_watchdog = {key: edge for key, edge in SERVER_TABLE.items() if key != (S.OPEN, ServerTrigger.WATCHDOG)}
    connection = Connection(Role.SERVER, table=without_watchdog)
    for data in STEPS[S.OPEN]:
        connection.receive(data, 0)
    assert connection.advance(5 * SECOND) == []
    assert connection.next_deadline_ns() is None


def test_errors_are_of_two_families():
    assert not issubclass(LocalProtocolError, RemoteProtocolError)
    assert not issubclass(RemoteProtocolError, LocalProtocolError)
