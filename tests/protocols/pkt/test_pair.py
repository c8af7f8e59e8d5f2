"""Both roles against each other, over a line that loses, damages and delays, with time as a rule."""

from __future__ import annotations

import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule

from protocols.pkt import (
    PROFILES,
    ClientOptions,
    ClientState,
    CommandReceived,
    Connection,
    EulerImuReport,
    GeneralReport,
    GpsReport,
    ImuReport,
    LedOff,
    LedOn,
    LocalProtocolError,
    MotionReport,
    MotorsMustStop,
    MotorSpeeds,
    MotorThrottles,
    ReportDue,
    ReportId,
    ReportReceived,
    Role,
    RoverFound,
    RoverLost,
    Schema,
    ServerOptions,
    ServerState,
    SpeedSetpoints,
    StateChanged,
    Transmit,
    encode_report,
    hides_newline,
)
from protocols.testing import Pair, lossy, unchanged
from tests.each import each
from tests.share import examples, seeds

SECOND = 1_000_000_000
SILENCE_NS = SECOND


class RoverPair(Pair):
    """A host and a rover, a line with faults between them, and a program on the rover that sends what is due."""

    def __init__(self, *, damage=unchanged, profile="documented", client=None):
        ends = (
            Connection(Role.CLIENT, client or PROFILES[profile].client),
            Connection(Role.SERVER, PROFILES[profile].server),
        )
        super().__init__(*ends, transmit=Transmit, damage=damage)
        self.schema = PROFILES[profile].server.schema

    def answer(self, end, event):
        if isinstance(event, ReportDue):
            self.send("server", self._report(event.report))

    def _report(self, report):
        ticks = self.now_ns // 10_000_000
        return {
            ReportId.IMU: EulerImuReport() if self.schema is Schema.V1 else ImuReport(validity=3),
            ReportId.MOTION: MotionReport(ticks=(ticks, 0, 0, 0)),
            ReportId.GPS: GpsReport(first_deg=-58.3683, second_deg=-34.6175),
        }[report]


def test_clean_line():
    pair = RoverPair()
    pair.connect()
    for n in range(60):
        pair.send("client", MotorThrottles(a=n / 64, b=-n / 64))
        pair.run(SECOND)
    assert pair.of(MotorsMustStop) == pair.of(RoverLost) == []
    assert [event.command.a for event in pair.of(CommandReceived)] == [n / 64 for n in range(60)]
    reports = [event.report for event in pair.of(ReportReceived)]
    # Each second: 3.03 of 0x80, more on request, one 0x81 for the command, 4 of 0x83, 1 of 0x82 and of 0x84.
    assert sum(isinstance(report, MotionReport) for report in reports) == 240
    assert sum(isinstance(report, ImuReport) for report in reports) == 60
    assert pair.client.totals.accepted == 60
    assert pair.client.totals.rejected == 0
    pair.disconnect()
    pair.run(SECOND)
    assert pair.of(CommandReceived)[-1].command == MotorThrottles(a=0.0, b=0.0)


@each(
    ("profile", "command"),
    [
        ("documented", SpeedSetpoints(a_rpm=30.0, b_rpm=30.0)),
        ("g2", SpeedSetpoints(a_rpm=30.0, b_rpm=30.0)),
        ("g0", MotorSpeeds(a=255, b=-255)),
        ("term-doc", MotorSpeeds(a=100, b=-100)),
    ],
)
def test_each_profile_with_itself(profile, command):
    pair = RoverPair(profile=profile, client=ClientOptions(**options_of(profile)))
    pair.connect()
    for _ in range(10):
        pair.send("client", command)
        pair.send("client", LedOff())
        pair.run(SECOND // 2)
    assert [event.command for event in pair.of(CommandReceived)] == [command, LedOff()] * 10
    assert pair.server.telemetry.rejected == 0
    assert pair.of(RoverFound)
    assert pair.of(RoverLost) == []
    assert pair.client.totals.accepted == 20


def options_of(profile):
    """Our host with the frames and the schema of this profile's rover."""
    server = PROFILES[profile].server
    return {"frames": server.frames, "schema": server.schema}


@pytest.mark.parametrize("seed", seeds(10, 3))
def test_bad_line(seed):
    pair = RoverPair(damage=lossy(seed, drop=0.05, flip=0.05, repeat=0.05, noise=0.1))
    pair.connect()
    for n in range(120):
        pair.send("client", MotorThrottles(a=n / 128, b=0.0))
        pair.run(SECOND // 2)
    assert pair.client.state is ClientState.LINKED
    counters = pair.client.counters
    assert counters.noise + counters.bad_crcs + counters.bad_syncs + counters.timed_out > 0
    executed = [event.command.a for event in pair.of(CommandReceived)]
    assert len(set(executed)) > 80
    # A CRC lets nothing through but what was sent: bits that are turned never become another throttle.
    assert set(executed) <= {n / 128 for n in range(120)}
    assert executed == sorted(executed)
    assert pair.server.telemetry.rejected > 0
    pair.damage = lambda data: data
    pair.run(SECOND)
    assert pair.client.totals.rejected % 256 == pair.server.telemetry.rejected


def test_the_author_s_client_on_g2():
    """All commands arrive; of the reports it shows those without newlines."""
    pair = RoverPair(profile="g2")
    for n in range(100):
        pair.send("client", LedOn() if n % 2 else LedOff())
        pair.run(SECOND * 4 // 10)
    assert len(pair.of(CommandReceived)) == 100
    reports = [event.report for event in pair.of(ReportReceived)]
    assert not [report for report in reports if isinstance(report, GpsReport)]  # -34.6175 holds a newline
    shown = {report.accepted for report in reports if isinstance(report, GeneralReport)}
    assert 9 in shown
    assert 10 not in shown
    assert all(
        hides_newline(encode_report(GeneralReport(accepted=n, last_opcode=1 + n % 2)))
        for n in set(range(1, 100)) - shown
    )


def test_same_seed_same_story():
    stories = []
    for _ in range(2):
        pair = RoverPair(damage=lossy(7, drop=0.1, flip=0.1, noise=0.2))
        pair.connect()
        pair.run(20 * SECOND)
        stories.append(pair.seen)
    assert stories[0] == stories[1]


class AnyUse(RuleBasedStateMachine):
    """Users, faults and time in any order; the model knows what the line carried, not what the machines hold."""

    def __init__(self):
        super().__init__()
        self.mute = False
        self.pair = RoverPair(damage=lambda data: b"" if self.mute else data)

    @rule(tenths=st.integers(1, 30))
    def time_passes(self, tenths):
        self.pair.run(tenths * SECOND // 10)

    @rule()
    def line_is_cut(self):
        self.mute = True

    @rule()
    def line_is_mended(self):
        self.mute = False

    @precondition(lambda self: self.pair.client.state is ClientState.IDLE)
    @rule()
    def user_connects(self):
        self.pair.connect()
        assert self.pair.client.state is ClientState.WAITING

    @precondition(lambda self: self.pair.client.state is not ClientState.IDLE)
    @rule()
    def user_disconnects(self):
        self.pair.disconnect()
        assert self.pair.client.state is ClientState.IDLE

    @rule(throttle=st.floats(-2, 2, width=32))
    def user_drives(self, throttle):
        self.pair.send("client", MotorThrottles(a=throttle, b=0.0))

    @rule(speed=st.integers(-9, 9))
    def user_errs(self, speed):
        state, deadline_ns = self.pair.client.state, self.pair.client.next_deadline_ns()
        with pytest.raises(LocalProtocolError):
            self.pair.send("client", MotorSpeeds(a=speed, b=speed))
        assert (self.pair.client.state, self.pair.client.next_deadline_ns()) == (state, deadline_ns)

    @rule(noise=st.binary(min_size=1, max_size=10))
    def noise_on_the_line(self, noise):
        self.pair.write("client", noise)
        self.pair.write("server", noise)

    @invariant()
    def commands_stay_in_range(self):
        assert all(abs(event.command.a) <= 1 for event in self.pair.of(CommandReceived))

    @invariant()
    def motors_stop_after_silence_and_only_then(self):
        last_ns = 0
        stopped = False
        for now_ns, end, event in self.pair.seen:
            if end == "server" and isinstance(event, CommandReceived):
                last_ns, stopped = now_ns, False
            if isinstance(event, MotorsMustStop):
                assert now_ns - last_ns >= SILENCE_NS
                stopped = True
        if not stopped and self.pair.server.state is not ServerState.LOST:
            assert self.pair.server.next_deadline_ns() <= self.pair.now_ns + SILENCE_NS

    @invariant()
    def found_and_lost_take_turns_until_the_user_leaves(self):
        there = False
        for event in self.pair.of(RoverFound | RoverLost | StateChanged):
            if isinstance(event, StateChanged):
                there = there and event.new is not ClientState.IDLE
            else:
                assert not (there and isinstance(event, RoverFound))
                there = isinstance(event, RoverFound)

    @invariant()
    def nothing_is_overdue_and_little_is_held(self):
        for connection in (self.pair.client, self.pair.server):
            deadline_ns = connection.next_deadline_ns()
            assert deadline_ns is None or deadline_ns >= self.pair.now_ns
            assert connection.held <= 256

    def teardown(self):
        """However it went, on a good line both ends hear each other, and commands arrive."""
        self.mute = False
        if self.pair.client.state is ClientState.IDLE:
            self.pair.connect()
        self.pair.run(4 * SECOND)
        self.pair.send("client", LedOn())
        self.pair.run(SECOND)
        assert self.pair.client.state is ClientState.LINKED
        assert self.pair.server.state is ServerState.LINKED


TestAnyUse = AnyUse.TestCase
TestAnyUse.settings = settings(max_examples=examples(50), stateful_step_count=20)


def test_options_can_be_mixed():
    """A rover of the second schema behind frames without a length byte, and its host."""
    frames = PROFILES["term-doc"].server.frames
    rover = Connection(Role.SERVER, ServerOptions(frames=frames, schema=Schema.V1B, rates=()))
    host = Connection(Role.CLIENT, ClientOptions(frames=frames, schema=Schema.V1B))
    command = MotorSpeeds(a=100, b=-100)
    assert CommandReceived(command=command) in rover.receive(host.send(command, 0), 0)
