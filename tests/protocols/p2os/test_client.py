"""The client role against a scripted server; and every edge of its table."""

from __future__ import annotations

from collections import Counter

import pytest

from protocols.p2os import (
    CLIENT_TABLE,
    ROBOTS,
    BaudWanted,
    ClientOptions,
    Command,
    ConfigPacket,
    Connected,
    ConnectFailed,
    Connection,
    ConnectionLost,
    ControllerReset,
    Disconnected,
    DropReason,
    EncoderPacket,
    FailReason,
    FrameDropped,
    FrameReader,
    Identification,
    LocalProtocolError,
    LossReason,
    PacketReceived,
    Role,
    ServerOptions,
    Sip,
    SonarReading,
    SyncEcho,
    SyncError,
    Transmit,
    UnknownPacket,
    UnknownRobot,
    UnknownSubclass,
    client_table,
    decode_command,
    encode_frame,
    encode_packet,
)
from protocols.p2os import (
    ClientState as C,
)
from protocols.p2os import (
    ClientTrigger as T,
)
from protocols.p2os import (
    CommandNumber as N,
)
from protocols.p2os.states import IN_SESSION
from tests.each import each

SECOND = 1_000_000_000
ECHO0, ECHO1 = SyncEcho(number=0), SyncEcho(number=1)
P2DX = Identification(name="bench", subclass="p2dx")
STRANGER = Identification(name="x", subclass="p9zz")
CONFIG = ConfigPacket(robot_type="Pioneer", subtype="p2dx", watchdog_ms=2000)
SYNC0, SYNC1, SYNC2 = (Command(number) for number in (N.PULSE, N.OPEN, N.CLOSE))
OPEN_1, CLOSE_1, CONFIG_1 = Command(N.OPEN, 1), Command(N.CLOSE, 1), Command(N.CONFIG, 1)
BROKEN = encode_frame(b"\x02bench")


class Computer:
    """A client, what it sent and what it reported."""

    def __init__(self, table=None, **options):
        self.connection = Connection(Role.CLIENT, ClientOptions(**options), table=table)
        self.now_ns = 0
        self.sent = []
        self.events = []

    def connect(self):
        return self._take(self.connection.connect(self.now_ns))

    def disconnect(self):
        return self._take(self.connection.disconnect(self.now_ns))

    def line_down(self):
        return self._take(self.connection.line_down(self.now_ns))

    def feed(self, *packets):
        """What the client sends on receiving these packets (or bytes)."""
        data = b"".join(packet if isinstance(packet, bytes) else encode_packet(packet) for packet in packets)
        return self._take(self.connection.receive(data, self.now_ns))

    def wait(self, seconds, every_s=0.05):
        """What it sends while time passes."""
        end, sent = self.now_ns + round(seconds * SECOND), []
        while self.now_ns < end:
            self.now_ns = min(end, self.now_ns + round(every_s * SECOND))
            sent += self._take(self.connection.advance(self.now_ns))
        return sent

    def listen(self, seconds, *packets):
        """What it sends while these packets come ten times a second."""
        sent = []
        for _ in range(round(seconds * 10)):
            sent += self.wait(0.1) + self.feed(*packets)
        return sent

    def _take(self, events):
        self.events += events
        data = b"".join(event.data for event in events if isinstance(event, Transmit))
        sent = [decode_command(frame.body) for frame in FrameReader().receive(data, 0)]
        self.sent += sent
        return sent

    def report(self, kind):
        """The only event of this kind."""
        (event,) = [event for event in self.events if isinstance(event, kind)]
        return event

    @property
    def state(self):
        return self.connection.state


STEPS = {
    C.IDLE: [],
    C.SYNC0_SENT: ["connect"],
    C.SYNC1_SENT: ["connect", ECHO0],
    C.SYNC2_SENT: ["connect", ECHO0, ECHO1],
    C.OPENING: ["connect", ECHO0, ECHO1, P2DX],
    C.CONFIGURING: ["connect", ECHO0, ECHO1, P2DX, 0.1],
    C.OPEN: ["connect", ECHO0, ECHO1, P2DX, 0.1, CONFIG],
    C.CLOSING: ["connect", ECHO0, ECHO1, P2DX, 0.1, CONFIG, "disconnect"],
    C.CLOSED: ["connect", "disconnect"],
    C.RESTARTING: ["connect", SyncError()],
    C.CLOSING_OLD: ["connect", Sip()],
    C.FAILED: ["connect", "line_down"],
    C.LOST: ["connect", ECHO0, ECHO1, P2DX, 0.1, CONFIG, "line_down"],
}


def computer_in(state, **options):
    computer = Computer(**options)
    for step in STEPS[state]:
        if isinstance(step, str):
            getattr(computer, step)()
        elif isinstance(step, float):
            computer.wait(step)
        else:
            computer.feed(step)
    assert computer.state is state
    return computer


def finish(computer):
    """Answers as a good server from SYNC0 on, and checks that the session comes about."""
    computer.feed(ECHO0)
    computer.feed(ECHO1)
    computer.feed(P2DX)
    computer.wait(0.2)
    computer.feed(CONFIG)
    assert computer.state is C.OPEN


def test_connects_step_by_step():
    computer = Computer()
    assert computer.connect() == [SYNC0]
    assert computer.feed(ECHO0) == [SYNC1]
    assert computer.feed(ECHO1) == [SYNC2]
    assert computer.feed(P2DX) == []
    assert computer.wait(0.1) == [OPEN_1, CONFIG_1]
    assert computer.feed(CONFIG) == []
    assert computer.report(Connected) == Connected(identification=P2DX, parameters=ROBOTS["p2dx"], config=CONFIG)


def test_open_and_close_without_an_argument():
    computer = computer_in(C.OPENING, session_argument=None)
    assert computer.wait(0.1)[0] == Command(N.OPEN)


def test_gives_up_on_silence_in_the_time_aria_takes():
    computer = Computer()
    computer.connect()
    computer.wait(7)
    assert computer.sent == [SYNC0] * 6
    assert computer.report(ConnectFailed).reason is FailReason.NO_ANSWER
    assert computer.connection.next_deadline_ns() is None


def test_echo_800_ms_late():
    computer = Computer()
    computer.connect()
    for echo in (ECHO0, ECHO1, P2DX):
        computer.wait(0.8)
        computer.feed(echo)
    assert computer.sent == [SYNC0, SYNC1, SYNC2]
    computer.wait(0.1)
    assert computer.state is C.CONFIGURING


def test_echo_in_two_pieces():
    computer = computer_in(C.SYNC0_SENT)
    raw = encode_packet(ECHO0)
    assert computer.feed(raw[:3]) == []
    assert computer.wait(0.05) == []
    assert computer.feed(raw[3:]) == [SYNC1]


@each("answer", [ECHO0, SyncError(), P2DX, BROKEN])
def test_wrong_answer_to_sync1_restarts(answer):
    computer = computer_in(C.SYNC1_SENT)
    assert computer.feed(answer) == []
    assert computer.state is C.RESTARTING
    assert computer.feed(ECHO1, ECHO0, P2DX) == []
    assert computer.wait(0.25) == [SYNC0]
    finish(computer)


@each("moving", [False, True])
@each("state", [C.SYNC0_SENT, C.SYNC1_SENT, C.SYNC2_SENT, C.RESTARTING])
def test_takes_over_an_old_session(moving, state):
    computer = computer_in(state)
    assert computer.feed(Sip(moving=moving)) == [CLOSE_1]
    assert computer.wait(0.1) + computer.feed(Sip(moving=moving)) == [CLOSE_1]
    assert computer.wait(0.2) == []
    assert computer.wait(0.1) == [SYNC0]
    finish(computer)


def test_old_session_that_never_closes():
    computer = Computer(max_closes=5)
    computer.connect()
    computer.listen(3, Sip(moving=True))
    assert computer.sent == [SYNC0, *[CLOSE_1] * 5]
    assert computer.report(ConnectFailed).reason is FailReason.OLD_SESSION


def test_damaged_identification_is_not_accepted():
    computer = computer_in(C.SYNC2_SENT)
    raw = encode_packet(P2DX)
    computer.feed(raw[:-1] + bytes((raw[-1] ^ 1,)))
    assert computer.state is C.SYNC2_SENT
    assert computer.wait(1) == [SYNC2]
    computer.feed(P2DX)
    assert computer.state is C.OPENING


def test_identification_that_can_never_be_read():
    computer = Computer(max_restarts=3)
    computer.connect()
    for _ in range(3):
        computer.feed(ECHO0)
        computer.feed(ECHO1)
        computer.feed(BROKEN)
        computer.wait(0.25)
    assert computer.report(ConnectFailed).reason is FailReason.BROKEN_IDENTIFICATION
    drops = [event for event in computer.events if isinstance(event, FrameDropped)]
    assert drops == [FrameDropped(reason=DropReason.BAD_BODY, data=BROKEN)] * 3
    assert computer.connection.counters.restarts == 3


def test_server_that_always_answers_wrongly():
    computer = Computer(max_restarts=4)
    computer.connect()
    computer.listen(3, SyncError())
    assert computer.report(ConnectFailed).reason is FailReason.WRONG_ANSWERS


def test_unknown_robot_is_refused():
    computer = computer_in(C.SYNC2_SENT)
    assert computer.feed(STRANGER) == [CLOSE_1]
    assert computer.report(UnknownRobot) == UnknownRobot(identification=STRANGER, fallback=None)
    assert computer.report(ConnectFailed).reason is FailReason.UNKNOWN_ROBOT


def test_unknown_robot_with_a_fallback():
    options = {"unknown_subclass": UnknownSubclass.FALL_BACK, "fallback_subclass": "amigo"}
    computer = computer_in(C.SYNC2_SENT, **options)
    computer.feed(STRANGER)
    assert computer.report(UnknownRobot).fallback is ROBOTS["amigo"]
    computer.wait(0.1)
    computer.feed(CONFIG)
    assert computer.report(Connected).parameters is ROBOTS["amigo"]


def test_subclass_in_any_case():
    computer = computer_in(C.SYNC2_SENT)
    computer.feed(Identification(name="", subclass="P2DX"))
    assert computer.state is C.OPENING


def test_step_without_an_answer_goes_back_to_sync0():
    computer = computer_in(C.SYNC1_SENT)
    assert computer.wait(3) == [SYNC1, SYNC1, SYNC0]
    finish(computer)


def test_gives_up_after_misses_in_all():
    computer = computer_in(C.SYNC1_SENT)
    computer.wait(11)
    assert computer.report(ConnectFailed).reason is FailReason.NO_ANSWER


def test_goes_on_without_config():
    computer = computer_in(C.CONFIGURING)
    computer.feed(Sip())
    assert computer.wait(1) == [CONFIG_1] * 3
    assert computer.report(Connected).config is None


def test_opens_again_while_no_sip_comes():
    computer = computer_in(C.CONFIGURING)
    assert computer.wait(0.3) == [OPEN_1, CONFIG_1]
    computer.feed(Sip())
    assert computer.wait(0.3) == [CONFIG_1]


def test_does_not_ask_for_config_if_told_not_to():
    computer = computer_in(C.OPENING, request_config=False)
    assert computer.wait(0.1) == [OPEN_1]
    assert computer.feed(Sip()) == []
    assert computer.report(Connected).config is None
    assert computer.report(PacketReceived).packet == Sip()


@each("request_config", [False, True])
def test_a_lost_open_is_sent_again_and_no_pulse_before(request_config):
    """To a server that still waits for OPEN a PULSE is a SYNC0."""
    computer = computer_in(C.OPENING, request_config=request_config)
    sent = computer.wait(5)
    assert sent.count(OPEN_1) == 17
    assert set(sent) <= {OPEN_1, CONFIG_1}
    assert not [event for event in computer.events if isinstance(event, Connected)]
    computer.listen(1.1, Sip())
    assert computer.report(Connected)


def test_config_is_waited_for_from_the_open_that_got_through():
    computer = computer_in(C.OPENING)
    computer.wait(2.1)
    assert computer.listen(0.9, Sip()).count(CONFIG_1) >= 2
    assert computer.state is C.CONFIGURING


@each("options", [{}, {"keepalive_s": 0.1}, {"keepalive_s": None}])
@each("request_config", [False, True])
def test_a_robot_without_sips_could_not_be_connected_to(request_config, options):
    computer = computer_in(C.OPENING, request_config=request_config, **options)
    computer.wait(8.2)
    assert computer.report(ConnectFailed).reason is FailReason.NO_SIP
    assert SYNC0 not in computer.sent[1:]
    assert computer.connection.next_deadline_ns() is None


@each("echo", [ECHO0, ECHO1])
def test_an_echo_in_session_tells_that_there_is_none(echo):
    computer = computer_in(C.OPEN)
    computer.feed(echo)
    assert computer.report(ConnectionLost).reason is LossReason.NOT_OPEN


@each("echo", [ECHO0, ECHO1])
def test_an_echo_behind_open_begins_the_handshake_again(echo):
    computer = computer_in(C.CONFIGURING)
    assert computer.feed(echo) == []
    assert computer.wait(0.25) == [SYNC0]
    finish(computer)


def test_sips_do_not_put_off_the_end_of_the_wait_for_config():
    computer = computer_in(C.CONFIGURING)
    computer.listen(1.1, Sip())
    assert computer.state is C.OPEN


def test_keepalive_after_silence_of_the_user():
    computer = computer_in(C.OPEN)
    start = computer.connection.counters.keepalives
    assert computer.listen(1.05, Sip()) == [SYNC0, SYNC0]
    computer.connection.send(Command(N.VEL, 100), computer.now_ns)
    assert computer.listen(0.4, Sip()) == []
    assert computer.listen(0.1, Sip()) == [SYNC0]
    assert computer.connection.counters.keepalives == start + 3


def test_keepalive_can_be_left_to_the_user():
    computer = computer_in(C.OPEN, keepalive_s=None)
    assert computer.listen(5, Sip()) == []


def test_loses_a_robot_that_falls_silent():
    computer = computer_in(C.OPEN)
    computer.feed(Sip())
    computer.wait(7.9)
    assert computer.state is C.OPEN
    computer.feed(EncoderPacket(left_ticks=0, right_ticks=0))
    computer.wait(0.2)
    assert computer.report(ConnectionLost).reason is LossReason.NO_SIP
    assert computer.connection.next_deadline_ns() is None


@each("code", [0xFF, 0xFE])
def test_controller_reset_ends_the_session(code):
    computer = computer_in(C.OPEN)
    computer.feed(ControllerReset(code=code))
    assert computer.report(ConnectionLost).reason is LossReason.CONTROLLER_RESET
    assert computer.connect() == [SYNC0]


def test_takes_leave():
    computer = computer_in(C.OPEN)
    assert computer.disconnect() == [Command(N.ENABLE, 0)]
    assert computer.feed(Sip()) == []
    assert computer.wait(0.1) == [CLOSE_1]
    assert computer.report(Disconnected)
    assert computer.state is C.CLOSED


def test_packets_of_the_session_are_reported():
    computer = computer_in(C.OPEN)
    computer.events.clear()
    good = Sip(sonars=(SonarReading(number=3, range_raw=9),), tail=b"abc")
    strange = [UnknownPacket(packet_type=kind, payload=b"12") for kind in (0x61, 0x7E)]
    damaged = encode_packet(Sip(x_raw=1))[:-1] + b"\x99"
    short = encode_frame(Sip(sonars=good.sonars).encode()[:-8])
    computer.feed(good, damaged, strange[0], b"\xfa", Sip(), b"\xfa\xfb\x01\xfa", strange[1], short, Sip(x_raw=2))
    received = [event.packet for event in computer.events if isinstance(event, PacketReceived)]
    assert received == [good, strange[0], Sip(), strange[1], Sip(x_raw=2)]
    assert computer.connection.counters.bad_checksums == 1
    assert computer.connection.counters.bad_bodies == 1


def test_scans_the_rates():
    computer = Computer(bauds=(9600, 38400, 19200))
    computer.connect()
    computer.wait(3.1)
    assert computer.report(BaudWanted).baud == 38400
    assert computer.sent == [SYNC0] * 4
    finish(computer)


def test_scan_that_finds_nothing_and_the_next_one():
    computer = Computer(bauds=(9600, 38400), scan_attempts=2)
    computer.connect()
    computer.wait(5)
    assert computer.report(ConnectFailed).reason is FailReason.NO_ANSWER
    computer.connect()
    computer.wait(5)
    assert [event.baud for event in computer.events if isinstance(event, BaudWanted)] == [38400, 9600]


def test_reconnects_with_nothing_left_of_before():
    computer = computer_in(C.OPEN)
    computer.feed(encode_packet(ECHO0)[:4])
    computer.line_down()
    assert computer.report(ConnectionLost).reason is LossReason.LINE_DOWN
    assert computer.connect() == [SYNC0]
    finish(computer)


@each("state", [state for state in C if state is not C.OPEN])
def test_nothing_can_be_sent_outside_the_session(state):
    computer = computer_in(state)
    deadline, sent = computer.connection.next_deadline_ns(), computer.connection.counters.frames_out
    with pytest.raises(LocalProtocolError, match=state.name):
        computer.connection.send(Command(N.VEL, 1), computer.now_ns)
    assert computer.state is state
    assert computer.connection.next_deadline_ns() == deadline
    assert computer.connection.counters.frames_out == sent


@each("message", [Sip(), OPEN_1, SYNC2, Command(N.VEL, 99_999), Command(300), Command(N.SAY, bytes(196))])
def test_wrong_messages_of_a_client_change_nothing(message):
    computer = computer_in(C.OPEN)
    deadline = computer.connection.next_deadline_ns()
    with pytest.raises(LocalProtocolError):
        computer.connection.send(message, computer.now_ns + SECOND // 4)
    assert computer.state is C.OPEN
    assert computer.connection.next_deadline_ns() == deadline


@each("state", C)
@each(("call", "trigger"), [("connect", T.CONNECT), ("disconnect", T.DISCONNECT)])
def test_connecting_twice_and_leaving_nothing_change_nothing(state, call, trigger):
    computer = computer_in(state)
    if (state, trigger) in CLIENT_TABLE:
        getattr(computer, call)()
        assert computer.state is CLIENT_TABLE[state, trigger].next_state
        return
    deadline = computer.connection.next_deadline_ns()
    with pytest.raises(LocalProtocolError, match=call):
        getattr(computer, call)()
    assert computer.state is state
    assert computer.connection.next_deadline_ns() == deadline


@each("options", [{"fallback_subclass": "p9"}, {"sync_timeout_s": 0}, {"max_misses": 0}])
def test_options_that_make_no_sense(options):
    with pytest.raises(LocalProtocolError):
        ClientOptions(**options)


def test_options_of_the_other_role():
    with pytest.raises(LocalProtocolError, match="ServerOptions"):
        Connection(Role.CLIENT, ServerOptions())
    with pytest.raises(LocalProtocolError, match="ClientOptions"):
        Connection(Role.SERVER, ClientOptions())


PACKETS = {
    T.ECHO0: ECHO0,
    T.ECHO1: ECHO1,
    T.IDENTIFIED: P2DX,
    T.UNKNOWN_ROBOT: STRANGER,
    T.BROKEN_IDENTIFICATION: BROKEN,
    T.SYNC_ERROR: SyncError(),
    T.SIP: Sip(),
    T.CONFIG: CONFIG,
    T.PACKET: EncoderPacket(left_ticks=1, right_ticks=2),
    T.RESET: ControllerReset(),
}
# What makes a trigger happen that depends on a counter or on time, per state: options, and what is done.
WAYS = {
    (C.SYNC0_SENT, T.TIMEOUT): ({}, lambda c: c.wait(1)),
    (C.SYNC1_SENT, T.TIMEOUT): ({}, lambda c: c.wait(1)),
    (C.SYNC2_SENT, T.TIMEOUT): ({}, lambda c: c.wait(1)),
    (C.RESTARTING, T.TIMEOUT): ({}, lambda c: c.wait(0.2)),
    (C.CLOSING_OLD, T.TIMEOUT): ({}, lambda c: c.wait(0.25)),
    (C.OPENING, T.TIMEOUT): ({}, lambda c: c.wait(0.1)),
    (C.CONFIGURING, T.TIMEOUT): ({}, lambda c: c.feed(Sip()) + c.wait(0.3)),
    (C.CONFIGURING, T.UNOPENED): ({}, lambda c: c.wait(0.3)),
    (C.CLOSING, T.TIMEOUT): ({}, lambda c: c.wait(0.1)),
    (C.SYNC1_SENT, T.STEP_BACK): ({"step_attempts": 1}, lambda c: c.wait(1)),
    (C.SYNC2_SENT, T.STEP_BACK): ({"step_attempts": 1}, lambda c: c.wait(1)),
    (C.SYNC0_SENT, T.NEXT_BAUD): ({"bauds": (9600, 19200), "scan_attempts": 1}, lambda c: c.wait(1)),
    (C.SYNC0_SENT, T.GAVE_UP): ({"silent_attempts": 1}, lambda c: c.wait(1)),
    (C.SYNC1_SENT, T.GAVE_UP): ({"max_misses": 1}, lambda c: c.wait(1)),
    (C.SYNC2_SENT, T.GAVE_UP): ({"max_misses": 1}, lambda c: c.wait(1)),
    (C.RESTARTING, T.GAVE_UP): ({"max_restarts": 1}, lambda c: c.wait(0.2)),
    (C.CLOSING_OLD, T.GAVE_UP): ({"max_closes": 1}, lambda c: c.feed(Sip())),
    (C.CONFIGURING, T.GAVE_UP): ({}, lambda c: c.feed(Sip()) + c.wait(1)),
    (C.CONFIGURING, T.SIP_LOST): ({"sip_timeout_s": 0.2}, lambda c: c.wait(0.2)),
    (C.OPEN, T.SIP_LOST): ({}, lambda c: c.wait(8)),
    (C.CONFIGURING, T.KEEPALIVE): ({"config_retry_s": 1.0}, lambda c: c.feed(Sip()) + c.wait(0.5)),
    (C.OPEN, T.KEEPALIVE): ({}, lambda c: c.wait(0.5)),
}


def provoke(state, trigger):
    """A client in this state to which the trigger has happened, by what really causes it."""
    options, act = WAYS.get((state, trigger), ({}, None))
    computer = computer_in(state, **options)
    if act is not None:
        act(computer)
    elif trigger in PACKETS:
        computer.feed(PACKETS[trigger])
    elif trigger in (T.CONNECT, T.DISCONNECT, T.LINE_DOWN):
        getattr(computer, trigger.name.lower())()
    else:
        pytest.fail(f"no way to make {trigger} happen in {state}")
    return computer


def test_every_edge_is_taken_by_what_causes_it():
    visits = Counter()
    for (state, trigger), edge in CLIENT_TABLE.items():
        computer = provoke(state, trigger)
        assert computer.connection.visits[state, trigger] >= 1, (state, trigger)
        assert computer.state is edge.next_state, (state, trigger)
        visits += computer.connection.visits
    assert set(visits) == set(CLIENT_TABLE)


def without_an_edge():
    """States and packets that the table has nothing for; in a session the packets of the handshake mean nothing."""
    for state in C:
        meant = (
            (T.SIP, T.CONFIG, T.PACKET, T.RESET, T.ECHO0, T.ECHO1)
            if state in IN_SESSION
            else [t for t in PACKETS if t is not T.RESET]
        )
        yield from ((state, trigger) for trigger in meant if (state, trigger) not in CLIENT_TABLE)


def test_packets_without_an_edge_change_nothing():
    for state, trigger in without_an_edge():
        computer = computer_in(state)
        deadline, ignored = computer.connection.next_deadline_ns(), computer.connection.counters.ignored
        assert computer.feed(PACKETS[trigger]) == [], (state, trigger)
        assert computer.connection.next_deadline_ns() == deadline, (state, trigger)
        assert computer.state is state, (state, trigger)
        assert computer.connection.counters.ignored == ignored + 1, (state, trigger)


@each("packet", [encode_frame(b"\0x"), encode_frame(b"\1x"), P2DX, BROKEN])
def test_packets_of_the_handshake_in_a_session_are_unknown_ones(packet):
    computer = computer_in(C.OPEN)
    computer.events.clear()
    assert computer.feed(packet) == []
    assert isinstance(computer.report(PacketReceived).packet, UnknownPacket)


def test_default_table_is_the_one_documented():
    assert client_table() == CLIENT_TABLE
    without = client_table(request_config=False)
    assert set(without) < set(CLIENT_TABLE)
    different = {key for key in CLIENT_TABLE if without.get(key) != CLIENT_TABLE[key]}
    waiting = (T.TIMEOUT, T.UNOPENED, T.SIP, T.GAVE_UP, T.KEEPALIVE)
    assert different == {(C.OPENING, T.TIMEOUT), *((C.CONFIGURING, trigger) for trigger in waiting)}
