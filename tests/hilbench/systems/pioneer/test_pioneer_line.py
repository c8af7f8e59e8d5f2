"""What the virtual robot puts on a line that cannot carry all of it, in bench time."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import pytest

from hilbench.bench import Bench
from hilbench.benchfile.reader import open_bench
from hilbench.clock import Scheduler
from hilbench.journal import Journal
from hilbench.links import Line, MemoryLink
from hilbench.systems.pioneer.robot import VirtualPioneer, plan_of
from protocols.p2os import (
    MAX_COUNT,
    Command,
    CommandNumber,
    ConfigPacket,
    EncoderPacket,
    Frame,
    FrameReader,
    IoPacket,
    SerAuxPacket,
    Sip,
    decode_packet,
    encode_command,
)
from targets.robots.pioneer import OutputWithdrawn, SipSkipped

MS = 1_000_000
SYNCS = ("FAFB03000000", "FAFB03010001", "FAFB03020002", "FAFB03010001")
CLOSE = bytes.fromhex("FAFB03020002")
BAUDS = pytest.mark.parametrize("baud", [9600, 115_200])


class Rig:
    def __init__(self, baud=9600, **settings):
        self.bench = Bench(Scheduler(), Journal(keep=5000))
        self.link = MemoryLink(self.bench.scheduler, Line(baud=baud))
        plan = plan_of(open_bench("pioneer"))
        plan = replace(plan, physics="plane", settings=replace(plan.settings, host_baud=baud, **settings))
        self.pioneer = VirtualPioneer(self.bench, self.link.a, plan, seed=1)
        self.told = []
        told = self.pioneer.actor._on_event
        self.pioneer.actor._on_event = lambda event: (self.told.append(event), told(event))
        self._reader = FrameReader(max_count=MAX_COUNT)
        self.packets = []  # (start in ns, packet)
        self.last_ns = 0
        self.most_pending = 0
        self.link.b.on_receive = self._hear

    def _hear(self, data, at_ns):
        self.last_ns = at_ns
        for item in self._reader.receive(data, at_ns):
            assert isinstance(item, Frame), item
            length_ns = len(item.raw) * 10**10 // self.link.b.baud
            self.packets.append((at_ns - length_ns, decode_packet(item.body)))

    def say(self, number, argument=None):
        self.link.b.write(encode_command(Command(number, argument)))

    def run(self, duration_s):
        for _ in range(round(duration_s * 100)):
            self.bench.run_for(0.01)
            self.most_pending = max(self.most_pending, self.link.a.pending)

    def open(self):
        for sync in SYNCS:
            self.link.b.write(bytes.fromhex(sync))
            self.run(0.06)
        self.packets.clear()

    def ask_for(self, duration_s, number, argument=None, every_s=0.1):
        for _ in range(round(duration_s / every_s)):
            self.say(number, argument)
            self.run(every_s)

    def times(self, kind):
        return [at_ns for at_ns, packet in self.packets if isinstance(packet, kind)]

    def count(self, kind):
        return len(self.times(kind))

    def close_session(self):
        self.link.b.write(CLOSE)
        self.run(0.01)
        closed_ns = self.bench.now_ns
        self.run(2.0)
        assert self._reader.held == 0, "a frame was cut"
        return (self.last_ns - closed_ns) / MS

    def told_of(self, kind):
        return [event for event in self.told if isinstance(event, kind)]


@pytest.fixture
def make_rig():
    rigs = []

    def make(*args, **settings):
        rigs.append(Rig(*args, **settings))
        rigs[-1].open()
        return rigs[-1]

    yield make
    for rig in rigs:
        rig.pioneer.close()


def test_more_than_the_line_carries_does_not_pile_up(make_rig):
    rig = make_rig()
    rig.say(CommandNumber.ENCODER, 2)
    rig.ask_for(20.0, CommandNumber.CONFIG, 1)
    assert rig.most_pending < 400
    assert rig.count(Sip) >= 195, "the SIP goes first"
    assert rig.count(ConfigPacket) > 30
    assert rig.count(EncoderPacket) > 30
    assert rig.close_session() <= 100
    assert rig.told_of(SipSkipped) == []


def test_half_a_cycle_is_too_short_for_everything(make_rig):
    rig = make_rig(sip_cycle_ms=50)
    rig.say(CommandNumber.ENCODER, 2)
    rig.say(CommandNumber.IOREQUEST, 2)
    rig.ask_for(20.0, CommandNumber.PULSE, every_s=1.0)
    assert rig.most_pending < 250
    assert rig.count(Sip) >= 360
    assert rig.count(EncoderPacket) > 15
    assert rig.count(IoPacket) > 15
    assert len(rig.told_of(SipSkipped)) <= 1
    assert rig.close_session() <= 100


@BAUDS
def test_what_fits_is_complete_and_in_time(make_rig, baud):
    rig = make_rig(baud, sonar_discs=tuple(range(16)))
    rig.say(CommandNumber.SONAR, 1)
    rig.say(CommandNumber.ENCODER, 2)
    rig.say(CommandNumber.IOREQUEST, 2)
    rig.run(0.5)
    rig.packets.clear()
    rig.ask_for(5.0, CommandNumber.PULSE, every_s=1.0)
    assert rig.count(Sip) == rig.count(EncoderPacket) == rig.count(IoPacket) == 50
    assert all(abs(second - first - 100 * MS) <= MS for first, second in pairwise(rig.times(Sip)))
    assert {reading.number for _, packet in rig.packets if isinstance(packet, Sip) for reading in packet.sonars} == set(
        range(16)
    )


def test_a_velocity_shows_at_once_whatever_else_was_asked_for(make_rig):
    rig = make_rig()
    rig.say(CommandNumber.ENABLE, 1)
    rig.say(CommandNumber.ENCODER, 2)
    rig.ask_for(10.0, CommandNumber.CONFIG, 1)
    told_ns = rig.bench.now_ns
    rig.say(CommandNumber.VEL, 200)
    rig.ask_for(1.0, CommandNumber.CONFIG, 1)
    moving_ns = next(at for at, packet in rig.packets if at > told_ns and isinstance(packet, Sip) and packet.moving)
    assert moving_ns - told_ns < 400 * MS


BETWEEN = pytest.mark.exhaustive("the gate closes at every third of these moments")


@pytest.mark.parametrize(
    "wait_ms", [pytest.param(wait_ms, marks=[BETWEEN] if wait_ms % 30 else []) for wait_ms in range(0, 300, 10)]
)
def test_close_ends_the_frame_that_is_being_sent_and_nothing_else(make_rig, wait_ms):
    rig = make_rig(aux_loop_back=True)
    rig.say(CommandNumber.TTY2, bytes(190))
    rig.say(CommandNumber.GETAUX, 190)
    rig.say(CommandNumber.CONFIG, 1)
    rig.run(0.3 + wait_ms / 1000)
    busy = rig.link.a.pending
    assert rig.close_session() <= 210
    withdrawn = sum(event.count for event in rig.told_of(OutputWithdrawn))
    assert withdrawn == rig.link.a.counters.withdrawn <= busy


@pytest.mark.parametrize("count", [1, 195, 196, 198, 199, 200])
def test_aux_packets_of_every_length(make_rig, count):
    rig = make_rig(aux_loop_back=True)
    for part in (count // 2, count - count // 2):
        if part:
            rig.say(CommandNumber.TTY2, bytes(part))
    rig.say(CommandNumber.GETAUX, count)
    rig.run(1.5)
    assert [packet.data for _, packet in rig.packets if isinstance(packet, SerAuxPacket)] == [bytes(count)]
    assert rig.most_pending < 400


def test_a_stream_that_was_stopped_sends_nothing_more(make_rig):
    rig = make_rig()
    rig.say(CommandNumber.ENCODER, 2)
    rig.ask_for(1.0, CommandNumber.CONFIG, 1)
    rig.say(CommandNumber.ENCODER, 0)
    rig.run(0.25)
    rig.packets.clear()
    rig.run(1.0)
    assert rig.count(EncoderPacket) == 0


def test_the_next_session_counts_afresh(make_rig):
    rig = make_rig(aux_loop_back=True)
    rig.ask_for(1.0, CommandNumber.CONFIG, 1)
    rig.close_session()
    rig.open()
    rig.ask_for(1.0, CommandNumber.PULSE)
    assert rig.count(Sip) == 10
