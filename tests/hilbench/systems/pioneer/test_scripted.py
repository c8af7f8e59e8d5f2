"""The scripted server: a plain P2OS server if left alone, and whatever a case wants it to be."""

from __future__ import annotations

import dataclasses
from itertools import pairwise

import pytest

from hilbench.bench import Bench
from hilbench.clock import NS_PER_MS, NS_PER_S, Scheduler
from hilbench.journal import Journal
from hilbench.judging.verdicts import Violation
from hilbench.links import Line, MemoryLink
from hilbench.systems.pioneer.client import P2osClient
from hilbench.systems.pioneer.scripted import Pause, ScriptedServer
from hilbench.systems.pioneer.scripted_packets import CONFIG, IDENTIFICATION, MOVING, STANDING
from protocols.p2os import (
    ClientState,
    Command,
    Frame,
    FrameReader,
    Sip,
    SyncEcho,
    checksum,
    encode_command,
    encode_packet,
)

SYNC0, SYNC1, SYNC2, CLOSE_1 = (encode_command(Command(*words)) for words in ((0,), (1,), (2,), (2, 1)))
OPEN = SYNC1


@pytest.fixture
def bench():
    return Bench(Scheduler(), Journal())


@pytest.fixture
def link(bench):
    return MemoryLink(bench.scheduler, Line(baud=9600))


@pytest.fixture
def server(bench, link):
    return ScriptedServer(bench, link.a)


class _Wire:
    """A bare end of the line: what came, as frames with the time of their end."""

    def __init__(self, bench, port):
        self.bench, self.port, self.frames, self.data = bench, port, [], b""
        self._reader = FrameReader()
        port.on_receive = self._take

    def _take(self, data, at_ns):
        self.data += data
        self.frames += [(at_ns, item.raw) for item in self._reader.receive(data, at_ns) if isinstance(item, Frame)]

    def say(self, *frames, then_s=0.1):
        """Say frames, one after the other, and return what was answered."""
        before = len(self.frames)
        for frame in frames:
            self.port.write(frame)
            self.bench.run_for(then_s)
        return [raw for _, raw in self.frames[before:]]


@pytest.fixture
def wire(bench, link, server):
    return _Wire(bench, link.b)


@pytest.fixture
def client(bench, link, server):
    return P2osClient(bench, link.b)


ECHO0, ECHO1 = (encode_packet(SyncEcho(number=number)) for number in (0, 1))
WHO = encode_packet(IDENTIFICATION)


# --- left alone


def test_it_answers_the_handshake_and_streams_sips_from_open_to_close(wire, server):
    assert wire.say(SYNC0, SYNC1, SYNC2) == [ECHO0, ECHO1, WHO]
    assert not server.in_session
    wire.say(OPEN, then_s=1.05)
    times_ns = [at_ns for at_ns, raw in wire.frames if raw == encode_packet(STANDING)]
    assert len(times_ns) == 10
    assert {after - before for before, after in pairwise(times_ns)} == {100 * NS_PER_MS}
    assert wire.say(CLOSE_1, then_s=1.0) == []
    assert wire.say(SYNC0) == [ECHO0]
    assert server.sessions_opened == 1


@pytest.mark.parametrize(
    ("said", "answered"),
    [
        ((SYNC1,), []),
        ((SYNC2,), []),
        ((SYNC0, SYNC2), [ECHO0]),
        ((SYNC0, SYNC0, SYNC1, SYNC1), [ECHO0, ECHO0, ECHO1, ECHO1]),
        ((SYNC0, SYNC1, SYNC0, SYNC2), [ECHO0, ECHO1, ECHO0]),
        ((CLOSE_1, SYNC0), [ECHO0]),
        ((b"WMS2\r", SYNC0), [ECHO0]),
    ],
)
def test_it_answers_in_order_only(wire, said, answered):
    assert wire.say(*said) == answered


def test_the_same_bytes_have_other_names_in_a_session(wire, server):
    wire.say(SYNC0, SYNC1, SYNC2, OPEN, SYNC0, SYNC1, SYNC2, SYNC0)
    names = ["SYNC0", "SYNC1", "SYNC2", "OPEN", "PULSE", "OPEN", "CLOSE", "SYNC0"]
    assert [heard.name for heard in server.received] == names
    assert [heard.raw for heard in server.heard("SYNC0")] == [SYNC0, SYNC0]


def test_a_frame_knows_when_its_first_byte_came(wire, server):
    wire.port.write(SYNC0[:2])
    wire.bench.run_for(0.05)
    wire.say(SYNC0[2:])
    (heard,) = server.received
    assert heard.start_ns == Line(baud=9600).bytes_ns(1)
    assert heard.at_ns == 50 * NS_PER_MS + Line(baud=9600).bytes_ns(4)


def test_what_is_no_frame_is_kept_and_shown(wire, server):
    wire.say(b"garbage", SYNC0[:-1] + b"\x01", SYNC0)
    assert b"".join(drop.data for drop in server.dropped) == b"garbage" + SYNC0[:-1] + b"\x01"
    assert server.bytes_received == 7 + 6 + 6
    assert any("SYNC0" in line for line in server.evidence())
    assert any("BAD_CHECKSUM" in line for line in server.evidence())


def test_a_count_beyond_the_limit_is_seen(wire, server):
    body = bytes((15, 0x2B, 250)) + bytes(250)
    frame = b"\xfa\xfb" + bytes((len(body) + 2,)) + body
    wire.say(SYNC0, SYNC1, SYNC2, OPEN)
    wire.say(frame + checksum(body).to_bytes(2, "big"), then_s=0.5)
    assert server.received[-1].raw[2] == 255


# --- the script


def test_an_answer_is_replaced_for_good_or_for_some_times(wire, server):
    server.answer("SYNC0", ECHO1, times=2)
    server.answer("SYNC1")
    assert wire.say(SYNC0, SYNC0, SYNC0, SYNC1, SYNC1) == [ECHO1, ECHO1, ECHO0]


def test_an_answer_comes_in_pieces_after_its_pauses(wire, server):
    server.answer("SYNC0", Pause(0.8), ECHO0[:2], Pause(0.05), ECHO0[2:])
    wire.say(SYNC0, then_s=0.8)
    assert wire.data == b""
    wire.bench.run_for(0.05)
    assert wire.data == ECHO0[:2]
    wire.bench.run_for(0.05)
    assert wire.data == ECHO0


def test_an_answer_to_nothing_that_exists_is_a_mistake(server):
    with pytest.raises(ValueError, match="SYNC3"):
        server.answer("SYNC3")


def test_silence_is_silence(wire, server):
    server.silence()
    assert wire.say(SYNC0, SYNC1, SYNC2) == []


def test_an_old_session_streams_until_close_and_one_cycle_more(wire, server):
    old = encode_packet(MOVING)
    server.stream = lambda _tick: old
    server.begin_session(sips_after_close=1)
    assert wire.say(SYNC0, then_s=0.55) == [old] * 5
    assert wire.say(CLOSE_1, then_s=1.0) == [old]
    assert [heard.name for heard in server.received] == ["PULSE", "CLOSE"]


def test_the_stream_is_what_the_case_says(wire, server):
    server.stream = lambda tick: b"" if tick == 1 else encode_packet(dataclasses.replace(STANDING, x_raw=tick))
    wire.say(SYNC0, SYNC1, SYNC2)
    wire.say(OPEN, then_s=0.5)
    xs = [Sip.decode(raw[3:-2]).x_raw for _, raw in wire.frames[3:]]
    assert xs == [0, 2, 3]


def test_a_server_that_was_closed_neither_speaks_nor_hears(wire, server, link, bench):
    server.answer("SYNC0", Pause(0.2), ECHO0)
    wire.say(SYNC0)
    server.close()
    assert wire.say(SYNC0, then_s=1.0) == []
    assert len(server.received) == 1
    ScriptedServer(bench, link.a)
    assert wire.say(SYNC0) == [ECHO0]


# --- waiting


def test_expecting_a_command(wire, server, bench):
    bench.scheduler.after(300 * NS_PER_MS, lambda: wire.port.write(SYNC0))
    heard = server.expect_command("SYNC0", 0.5)
    assert heard.at_ns == 300 * NS_PER_MS + Line(baud=9600).bytes_ns(6)
    with pytest.raises(Violation, match=r"no SYNC1 within 0.5 s"):
        server.expect_command("SYNC1", 0.5)
    bench.scheduler.after(510 * NS_PER_MS, lambda: wire.port.write(SYNC0))
    with pytest.raises(Violation, match=r"SYNC0 came after: 0\.51"):
        server.expect_command("SYNC0", 0.5)
    assert server.expect_command("SYNC0", 0.1, mark=0) is server.received[0]


def test_expecting_silence(wire, server, bench):
    server.expect_silence(0.5)
    bench.scheduler.after(NS_PER_MS, lambda: wire.port.write(SYNC0))
    with pytest.raises(Violation, match="SYNC0 came where silence is required: it sleeps"):
        server.expect_silence(0.5, why="it sleeps")


def test_waiting_for_quiet(wire, server, bench):
    for tick in range(5):
        bench.scheduler.after(tick * 500 * NS_PER_MS, lambda: wire.port.write(SYNC0))
    assert not server.wait_quiet(1.0, 1.5)
    assert server.wait_quiet(1.0, 5.0)
    assert bench.now_ns < 6 * NS_PER_S


# --- with the client of this package


def test_our_client_opens_a_session_and_learns_who_is_there(client, server, bench):
    client.connect()
    server.expect_session(2.0)
    bench.run_for(0.5)
    assert client.state is ClientState.OPEN
    assert client.identification == IDENTIFICATION
    assert client.config == CONFIG
    assert client.sips[-1] == STANDING
    assert client.reading.battery_v == 12.8
    assert client.robot.subclass == "p2dx"


def test_our_client_drives(client, server, bench):
    client.connect()
    server.expect_session(2.0)
    bench.run_for(0.5)
    mark = server.mark()
    client.enable()
    client.drive(200, -10)
    client.drive_wheels(300, -100)
    client.stop()
    client.enable(motors=False)
    bench.run_for(0.2)
    assert [(heard.name, heard.command.argument) for heard in server.heard(mark=mark)] == [
        ("ENABLE", 1),
        ("VEL", 200),
        ("RVEL", -10),
        ("VEL2", 0x0FFB),
        ("STOP", None),
        ("ENABLE", 0),
    ]


def test_the_pose_of_our_client_counts_from_its_first_sip(client, server, bench):
    server.answer("CONFIG")
    server.stream = lambda tick: encode_packet(dataclasses.replace(STANDING, x_raw=(32760 + 10 * tick) % 32768))
    client.connect()
    server.expect_session(2.0)
    bench.run_for(2.05)
    ticks = len(client.sips) - 1
    assert ticks > 15
    assert client.pose.pose.x_mm == pytest.approx((-8 + 10 * ticks) * 0.84)


def test_our_client_says_why_it_failed_and_may_try_again(client, server, bench):
    server.silence()
    client.connect()
    bench.run_for(10)
    assert (client.state, client.failure) == (ClientState.FAILED, "no answer")
    for name, answer in (("SYNC0", ECHO0), ("SYNC1", ECHO1), ("SYNC2", WHO)):
        server.answer(name, answer)
    client.connect()
    server.expect_session(2.0)
    bench.run_for(2)
    assert (client.state, client.failure) == (ClientState.OPEN, "")
