"""The rover: the cases of the catalogue that a protocol alone can decide, in their profiles; every quirk on and off.

State after a stimulus is written ACC/REJ/OP/ERR as in the general report, from a fresh rover.
"""

from __future__ import annotations

import dataclasses
import itertools

import pytest

from protocols.pkt import (
    PROFILES,
    CommandReceived,
    CommandRefused,
    Connection,
    ErrorCode,
    ExecutionReport,
    ExecutionReports,
    FrameDropped,
    FrameTimer,
    Framing,
    FramingOptions,
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
    PidGains,
    PidReport,
    PollOptions,
    RangeRule,
    ReportDue,
    ReportId,
    ReportRate,
    Role,
    Schema,
    ServerOptions,
    ServerState,
    SpeedSetpoints,
    Transmit,
    UnknownReport,
    encode_command,
    encode_frame,
)
from tests.each import each

SECOND = 1_000_000_000
W1 = bytes.fromhex("50 4B 54 21 01 00 E1 F0 0A")
W2 = bytes.fromhex("50 4B 54 21 02 00 00 1D 0F 0A")
W3 = bytes.fromhex("50 4B 54 21 01 01 F1 D1 0A")
W3_TERM = bytes.fromhex("50 4B 54 21 01 F1 D1 0A")
W4 = bytes.fromhex("50 4B 54 21 01 02 C1 B2 0A")
W7 = bytes.fromhex("50 4B 54 21 03 00 0A 00 0A 03 77 F3 0A")
W8 = bytes.fromhex("50 4B 54 21 03 00 3B 00 3B 03 1B 0A 0A")
W10 = bytes.fromhex("50 4B 54 21 0A 03 00 00 00 3F 00 00 80 BE 03 8C 42 0A")
W12 = bytes.fromhex("50 4B 54 21 0A 04 00 00 F0 41 00 00 F0 41 03 A1 E8 0A")
W14 = bytes.fromhex("50 4B 54 21 06 80 00 00 00 00 00 DA 30 0A")
W16 = bytes.fromhex("50 4B 54 21 03 81 01 00 F3 C7 0A")
W17 = bytes.fromhex("50 4B 54 21 03 81 7F 05 88 34 0A")
W18 = bytes.fromhex("50 4B 54 21 01 7F 6E 88 0A")
CUT = bytes.fromhex("50 4B 54 21 0A 03 00 00")
HALF = W3[:6]

ALL_LEN = ("documented", "g0", "g2")
SHIPPED = ("g0", "g2")


def quiet(options):
    """Without periodic reports, which only stand in the way here."""
    return dataclasses.replace(options, rates=())


def rover_of(make_rover, profile):
    return make_rover(quiet(PROFILES[profile].server))


CASES = [
    ("P01", ALL_LEN, W1, (0, 0, 0, 0)),
    ("P03", ALL_LEN, W4 + W4, (2, 0, 2, 0)),
    ("P04", ALL_LEN, W18, (1, 0, 0x7F, 5)),
    ("P05", ALL_LEN, bytes.fromhex("50 4B 54 21 01 01 00 00 0A"), (0, 1, 0, 3)),
    ("P06", ALL_LEN, W3[:-1] + b"\x58", (0, 1, 0, 4)),
    ("P07", ALL_LEN, bytes.fromhex("50 4B 54 21 00"), (0, 1, 0, 2)),
    ("P08", ALL_LEN, bytes.fromhex("50 4B 54 21 61"), (0, 1, 0, 2)),
    ("P08 FF", ALL_LEN, bytes.fromhex("50 4B 54 21 FF"), (0, 1, 0, 2)),
    ("P10", ALL_LEN, bytes.fromhex("50 4B 58 21"), (0, 1, 0, 1)),
    ("P11", SHIPPED, b"\x50" + W3, (0, 1, 0, 1)),
    ("P11D", ("documented",), b"\x50" + W3, (1, 1, 1, 0)),
    ("P12", SHIPPED, b"\x50\x4b" + W2, (0, 1, 0, 1)),
    ("P12D", ("documented",), b"\x50\x4b" + W2, (0, 1, 0, 1)),
    ("P13", ALL_LEN, b"abcdefg\n" + W3, (1, 0, 1, 0)),
    ("P14", ALL_LEN, b"PING" + W3, (1, 1, 1, 0)),
    ("P15", ALL_LEN, CUT + W3, (0, 1, 0, 3)),
    ("P16", ALL_LEN, CUT + W3 * 3, (2, 1, 1, 0)),
    ("P17", ALL_LEN, W3_TERM, (0, 1, 0, 3)),
    ("P18", ALL_LEN, W3_TERM + W3, (1, 1, 1, 0)),
    ("P20", ALL_LEN, W3 + W4, (2, 0, 2, 0)),
    ("P31", ("term-doc",), W7, (0, 1, 0, 3)),
    ("P32", ("term-doc",), W8, (0, 1, 0, 3)),
    ("P34", ("term-doc",), b"PKT!" + b"x" * 70, (0, 1, 0, 2)),
    ("P35", ("term-doc",), b"PKT!\n", (0, 1, 0, 3)),
]


@each("size", [1000, 1])
def test_the_counters_after_a_stimulus(make_rover, size):
    for name, profiles, stimulus, expected in CASES:
        for profile in profiles:
            rover = rover_of(make_rover, profile)
            for at in range(0, len(stimulus), size):
                rover.hear(stimulus[at : at + size])
            rover.wait(0.1)
            assert rover.counts == expected, (name, profile)


@each("profile", ALL_LEN)
def test_p01_a_request_is_answered_and_counts_for_nothing(make_rover, profile):
    rover = rover_of(make_rover, profile)
    assert rover.hear(W1) == [W14]
    assert rover.hear(W2) == [W14]
    assert rover.counts == (0, 0, 0, 0)


def test_p01_without_a_length_byte_the_answer_has_five_bytes(make_rover):
    rover = rover_of(make_rover, "term-doc")
    assert rover.hear(bytes.fromhex("50 4B 54 21 00 E1 F0 0A")) == [
        bytes.fromhex("50 4B 54 21 80 00 00 00 00 33 DC 0A")
    ]


@each(("profile", "answers"), [("g0", []), ("g2", []), ("documented", [W16])])
def test_p02_whether_the_execution_is_reported(make_rover, profile, answers):
    rover = rover_of(make_rover, profile)
    assert rover.hear(W3) == answers
    assert rover.counts == (1, 0, 1, 0)
    assert rover.of(CommandReceived) == [CommandReceived(command=LedOn())]


@each(
    ("rule", "expected"),
    [(ExecutionReports.NEVER, []), (ExecutionReports.LEDS, [W16]), (ExecutionReports.EVERY, [W16, W17])],
)
def test_p04_who_gets_an_execution_report(make_rover, rule, expected):
    rover = make_rover(ServerOptions(execution_reports=rule, rates=()))
    assert rover.hear(W3) + rover.hear(W18) + [frame for frame in rover.hear(W1) if frame[5] == 0x81] == expected
    assert rover.of(CommandRefused) == [CommandRefused(payload=b"\x7f", error=ErrorCode.UNKNOWN_OPCODE)]


@each("profile", ALL_LEN)
def test_p06_a_packet_without_its_newline_is_not_carried_out(make_rover, profile):
    rover = rover_of(make_rover, profile)
    rover.hear(W3[:-1] + b"\x58")
    assert rover.of(CommandReceived) == []


@each("profile", ALL_LEN)
def test_p09_the_longest_payload(make_rover, profile):
    rover = rover_of(make_rover, profile)
    for at in range(0, 104, 32):
        rover.hear(rover.frame(b"\x01" + bytes(95))[at : at + 32])
    assert rover.counts == (1, 0, 1, 0)


@each(("profile", "answers"), [("g0", 0), ("g2", 0), ("documented", 1)])
def test_p12_a_request_in_a_broken_sync_word(make_rover, profile, answers):
    rover = rover_of(make_rover, profile)
    assert len(rover.hear(b"\x50\x4b" + W2)) == answers


def test_p19_newlines_in_a_throttle(make_rover):
    rover = rover_of(make_rover, "g2")
    rover.hear(rover.frame(b"\x03\x0a\x0a\x0a\x3e" + bytes(4) + b"\x03"))
    (received,) = rover.of(CommandReceived)
    assert received.command.a == pytest.approx(0.1348, abs=1e-4)
    assert rover.counts == (1, 0, 3, 0)


@each("profile", ALL_LEN)
def test_p21_the_counters_wrap(make_rover, profile):
    rover = rover_of(make_rover, profile)
    for _ in range(255):
        rover.hear(W3)
    assert rover.counts == (255, 0, 1, 0)
    rover.hear(W3)
    assert rover.counts == (0, 0, 1, 0)
    for _ in range(256):
        rover.hear(b"PX")
    assert rover.counts == (0, 0, 1, 1)
    assert rover.connection.counters.bad_syncs == 256


def test_a_later_success_clears_the_error_of_the_decoder(make_rover):
    rover = rover_of(make_rover, "g2")
    rover.hear(b"PX")
    assert rover.counts == (0, 1, 0, 1)
    rover.hear(W4)
    assert rover.counts == (1, 1, 2, 0)


# ---- parameters


def test_p22_stale_bytes_are_taken_for_parameters(make_rover):
    rover = rover_of(make_rover, "g2")
    rover.hear(W10)
    rover.hear(rover.frame(b"\x03"))
    assert rover.counts == (2, 0, 3, 0)
    first, second = rover.of(CommandReceived)
    assert first.command == MotorThrottles(a=0.5, b=-0.25)
    assert second.command == first.command  # one zero is written behind the opcode, where a zero stood already
    rover.hear(rover.frame(b"\x03\x01"))
    assert rover.of(CommandReceived)[-1].command.b == -0.25


def test_p22d_too_few_parameters_are_an_error(make_rover):
    rover = rover_of(make_rover, "documented")
    (report,) = rover.hear(rover.frame(b"\x03"))
    assert rover.report_in(report) == ExecutionReport(opcode=3, error=2)
    assert rover.counts == (1, 0, 3, 2)
    assert rover.of(CommandReceived) == []
    assert rover.of(CommandRefused) == [CommandRefused(payload=b"\x03", error=ErrorCode.INVALID_LENGTH)]


@each(
    ("rule", "throttle", "expected"),
    [(RangeRule.ANY, 1.5, 1.5), (RangeRule.CLAMP, 1.5, 1.0), (RangeRule.CLAMP, -2, -1)],
)
def test_p28_a_throttle_out_of_range(make_rover, rule, throttle, expected):
    rover = make_rover(ServerOptions(range_rule=rule, rates=()))
    rover.hear(rover.frame(encode_command(MotorThrottles(a=throttle, b=0.0))))
    assert rover.of(CommandReceived)[0].command.a == expected


def test_gains_that_are_read_too_late(make_rover):
    """G2: kp is the sent kd, kd the sent ki, ki is the zero behind the payload and three stale bytes."""
    gains = encode_command(PidGains(kp=1.0, kd=2.0, ki=3.0))
    rover = rover_of(make_rover, "g2")
    rover.hear(rover.frame(bytes(range(16)) + b"\x3f"))
    rover.hear(rover.frame(gains))
    command = rover.of(CommandReceived)[-1].command
    assert (command.kp, command.kd) == (2.0, 3.0)
    stale = PidGains(kp=2.0, kd=3.0, ki=command.ki)
    assert encode_command(stale)[9:] == b"\0" + bytes((14, 15, 0x3F))
    sound = rover_of(make_rover, "documented")
    sound.hear(sound.frame(gains))
    assert sound.of(CommandReceived)[-1].command == PidGains(kp=1.0, kd=2.0, ki=3.0)


def test_gains_read_late_and_strictly_are_refused_only_when_short(make_rover):
    rover = make_rover(ServerOptions(pid_reads_late=True, rates=()))
    rover.hear(rover.frame(encode_command(PidGains(kp=1.0, kd=2.0, ki=3.0))))
    assert rover.of(CommandReceived)[-1].command.kp == 2.0
    rover.hear(rover.frame(b"\x05" + bytes(11)))
    assert rover.counts == (2, 0, 5, 2)


@each(
    ("schema", "opcode", "known"),
    [(s, o, o <= {Schema.V1: 3, Schema.V1B: 4, Schema.V2: 5}[s]) for s in Schema for o in range(8)],
)
def test_which_opcodes_a_schema_knows(make_rover, schema, opcode, known):
    rover = make_rover(ServerOptions(schema=schema, rates=()))
    rover.hear(rover.frame(bytes((opcode,)) + bytes(12)))
    assert rover.counts[3] == (0 if known else 5)


# ---- time


def test_p23_half_a_frame_and_the_rest_thirty_seconds_later(make_rover):
    expected = {"g2": (1, 0, 1, 0), "g0": (0, 0, 0, 0), "documented": (0, 0, 0, 0)}
    for profile, counts in expected.items():
        rover = rover_of(make_rover, profile)
        rover.hear(HALF)
        rover.wait(30)
        rover.hear(W3[6:])
        assert rover.counts == counts, profile
        rover.hear(W3)
        assert rover.counts[0] == counts[0] + 1


@each(("profile", "stops_s"), [("g2", None), ("term-doc", None), ("g0", 1.0), ("documented", 1.0)])
def test_p24_a_silent_host(make_rover, profile, stops_s):
    rover = rover_of(make_rover, profile)
    rover.wait(0.5)
    command = MotorThrottles(a=0.5, b=-0.25) if profile in ("g2", "documented") else MotorSpeeds(a=50, b=-25)
    began_ns = rover.now_ns
    rover.hear(rover.frame(encode_command(command, rover.options.schema)))
    assert rover.connection.state is ServerState.LINKED
    if stops_s is None:
        assert MotorsMustStop() not in rover.wait(10)
        assert rover.connection.next_deadline_ns() is None
        return
    assert rover.connection.next_deadline_ns() <= began_ns + round((stops_s + 0.01) * SECOND)
    assert rover.wait(10).count(MotorsMustStop()) == 1
    assert rover.connection.state is ServerState.LOST
    assert rover.connection.counters.silences == 1
    rover.hear(rover.frame(b"\x00"))
    assert rover.connection.state is ServerState.LINKED


def test_any_sound_frame_feeds_the_watchdog_and_no_other(make_rover):
    rover = rover_of(make_rover, "documented")
    for stimulus in (W1, W3, W18, rover.frame(b"\x03")):
        rover.hear(stimulus)
        assert MotorsMustStop() not in rover.wait(0.9)
    rover.hear(b"PX" + W3[:-1] + b"x")
    assert MotorsMustStop() in rover.wait(0.9)


def test_before_the_first_frame_the_watchdog_runs_too(make_rover):
    rover = rover_of(make_rover, "g0")
    assert MotorsMustStop() in rover.wait(1)


# ---- the polled receiver

ELEVEN = encode_frame(b"\x01\0\0")


@each(("profile", "counts"), [("g2", (0, 0, 0, 0)), ("documented", (1, 0, 1, 0)), ("g0", (1, 0, 1, 0))])
def test_p25_eleven_bytes_in_one_look(make_rover, profile, counts):
    rover = rover_of(make_rover, profile)
    rover.hear(ELEVEN)
    assert rover.counts == counts
    assert rover.connection.counters.polls_of_eleven == (profile == "g2")


def test_p25_is_a_matter_of_the_look_alone(make_rover):
    rover = rover_of(make_rover, "g2")
    rover.hear(ELEVEN[:5])
    rover.hear(ELEVEN[5:])
    assert rover.counts == (1, 0, 1, 0)
    rover.connection.receive(ELEVEN[:5], rover.now_ns + 1)
    rover.connection.receive(ELEVEN[5:], rover.now_ns + 2)
    rover.wait(0.01)
    assert rover.counts == (1, 0, 1, 0)
    other = make_rover(ServerOptions(poll=PollOptions(lose_eleven=False), rates=()))
    other.hear(ELEVEN)
    assert other.counts == (1, 0, 1, 0)


def test_a_polled_receiver_takes_3200_bytes_a_second(make_rover):
    rover = make_rover(ServerOptions(poll=PollOptions(buffer_bytes=100_000), rates=()))
    rover.connection.receive(W4 * 1000, 0)
    rover.wait(1.0)
    assert rover.connection.counters.frames_in == 3200 // 9
    assert rover.connection.held == 9000 - 3200 + 3200 % 9


def test_a_full_receive_buffer_loses_what_comes_last(make_rover):
    rover = make_rover(ServerOptions(poll=PollOptions(), rates=()))
    rover.hear(W4 * 40)
    (lost,) = rover.of(FrameDropped)
    assert lost.data == (W4 * 40)[256:]
    assert rover.connection.counters.overruns == 1


def test_a_look_takes_what_came_before_it(make_rover):
    connection = Connection(Role.SERVER, ServerOptions(poll=PollOptions(), rates=(), silence_s=None))
    assert connection.receive(W4, 10_000_000) == []
    assert connection.next_deadline_ns() == 20_000_000
    assert connection.receive(b"", 19_999_999) == []
    assert CommandReceived(command=LedOff()) in connection.receive(W4, 20_000_000)
    assert connection.held == 9


def test_looks_at_a_rate_that_does_not_divide_a_second():
    connection = Connection(Role.SERVER, ServerOptions(poll=PollOptions(hz=3), rates=(), silence_s=None), epoch_ns=7)
    seen = []
    for _ in range(4):
        connection.receive(b"x", (seen or [7])[-1])
        seen.append(connection.next_deadline_ns())
        connection.advance(seen[-1])
    assert seen == [7 + n * SECOND // 3 for n in range(1, 5)]
    early = Connection(Role.SERVER, ServerOptions(poll=PollOptions(), rates=(), silence_s=None), epoch_ns=SECOND)
    early.receive(b"x", 5)
    assert early.next_deadline_ns() == SECOND


# ---- reports


def test_p30_the_periodic_reports_of_ten_seconds(make_rover):
    rover = make_rover(PROFILES["g2"].server)
    events = rover.connection.advance(0)
    assert [event.report for event in events if isinstance(event, ReportDue)] == [
        ReportId.MOTION,
        ReportId.IMU,
        ReportId.GPS,
    ]
    assert events[0] == Transmit(data=W14)
    events += rover.wait(9.999)
    count = {report: sum(event == ReportDue(report=report) for event in events) for report in ReportId}
    assert count[ReportId.MOTION] == 40
    assert count[ReportId.IMU] == count[ReportId.GPS] == 10
    assert sum(isinstance(event, Transmit) for event in events) == 31


def test_periodic_reports_are_the_same_however_time_is_cut(make_rover):
    def events(steps):
        connection = Connection(Role.SERVER, PROFILES["documented"].server)
        return [event for now_ns in steps for event in connection.advance(now_ns)]

    whole = events([5 * SECOND])
    assert events(range(0, 5 * SECOND + 1, SECOND // 64)) == whole
    assert len(whole) == 16 + 21 + 6 + 6 + 2  # and the watchdog: a stop and the change of state


def test_the_arduino_reports_after_its_first_period(make_rover):
    rover = make_rover(PROFILES["g0"].server)
    assert rover.connection.advance(0) == []
    events = rover.wait(1.0)
    assert events.count(ReportDue(report=ReportId.IMU)) == 5
    assert sum(isinstance(event, Transmit) for event in events) == 1


def test_a_rover_without_rates_answers_only(make_rover):
    rover = make_rover(PROFILES["term-doc"].server)
    assert rover.connection.next_deadline_ns() is None
    assert rover.wait(100) == []


def test_the_epoch_is_tick_zero():
    connection = Connection(Role.SERVER, ServerOptions(silence_s=None), epoch_ns=3 * SECOND)
    assert connection.next_deadline_ns() == 3 * SECOND
    assert connection.advance(3 * SECOND - 1) == []
    assert len(connection.advance(3 * SECOND)) == 4


def test_the_stale_byte_of_the_position(make_rover):
    """G2 never writes byte 1 of 0x84: it is that of the report before."""
    for profile, expected in (("g2", 3), ("documented", 0)):
        connection = Connection(Role.SERVER, quiet(PROFILES[profile].server))
        connection.send(ImuReport(validity=3), 0)
        assert connection.send(GpsReport(), 0)[6] == expected
        connection.send(MotionReport(), 0)
        assert connection.send(GpsReport(), 0)[6] == 0


def test_the_gains_that_g2_would_report():
    report = PidReport(kp=1.0, kd=2.0, ki=3.0)
    g2 = Connection(Role.SERVER, PROFILES["g2"].server)
    other = Connection(Role.SERVER, PROFILES["documented"].server)
    assert g2.send(report, 0) == other.send(PidReport(kp=1.0, kd=1.0, ki=1.0), 0)
    assert other.send(report, 0) == encode_frame(
        b"\x85\0\0\0" + bytes.fromhex("0000803f 000080bf 0000803f 00000040 00004040")
    )


def test_status_of_the_general_report(make_rover):
    rover = rover_of(make_rover, "g0")
    rover.connection.set_status(2)
    (answer,) = rover.hear(W1)
    assert rover.report_in(answer) == GeneralReport(status=2)
    assert rover.connection.telemetry == GeneralReport(status=2)
    with pytest.raises(LocalProtocolError, match="status 256"):
        rover.connection.set_status(256)


@each("message", [GeneralReport(), ExecutionReport(opcode=1), LedOn(), SpeedSetpoints(a_rpm=0, b_rpm=0)])
def test_what_is_not_for_a_rover_to_send(message):
    connection = Connection(Role.SERVER)
    with pytest.raises(LocalProtocolError, match=f"{type(message).__name__} is not for the program on a server"):
        connection.send(message, 0)
    assert connection.counters.frames_out == 0


def test_a_report_that_does_not_fit_changes_nothing():
    connection = Connection(Role.SERVER)
    with pytest.raises(LocalProtocolError, match="does not fit"):
        connection.send(GpsReport(validity=300), 0)
    with pytest.raises(LocalProtocolError, match="97 bytes"):
        connection.send(UnknownReport(report_id=0x90, data=bytes(96)), 0)
    assert connection.counters.frames_out == 0


def test_a_rovers_uart_does_not_notice_that_the_line_is_gone(make_rover):
    rover = rover_of(make_rover, "documented")
    rover.hear(HALF)
    assert rover.connection.line_down(rover.now_ns) == []
    rover.hear(W3[6:])
    assert rover.counts == (1, 0, 1, 0)


# ---- frames without a length byte


def test_p32_a_tolerant_receiver_reads_on(make_rover):
    options = ServerOptions(
        frames=FramingOptions(framing=Framing.TERM, tolerant_newline=True), schema=Schema.V1, rates=()
    )
    rover = make_rover(options)
    rover.hear(W8)
    rover.hear(W7)
    assert [event.command for event in rover.of(CommandReceived)] == [MotorSpeeds(a=59, b=59), MotorSpeeds(a=10, b=10)]


@each(("strict", "counts"), [(False, (1, 0, 1, 0)), (True, (0, 1, 0, 2))])
def test_p33_what_the_limit_counts(make_rover, strict, counts):
    options = ServerOptions(
        frames=FramingOptions(framing=Framing.TERM, strict_diagram=strict, timer=FrameTimer.OFF),
        schema=Schema.V1,
        rates=(),
    )
    rover = make_rover(options)
    rover.hear(rover.frame(b"\x01" + bytes(63)))
    assert rover.counts == counts


def test_p34_the_limit_ends_a_frame_once(make_rover):
    rover = rover_of(make_rover, "term-doc")
    rover.hear(b"PKT!" + b"x" * 70 + W3_TERM)
    assert rover.counts == (1, 1, 1, 0)


# ---- misuse


@each(
    ("wrong", "text"),
    [
        ({"silence_s": 0.0}, "silence_s is 0.0"),
        ({"tick_hz": 0}, "tick_hz is 0"),
        ({"schema": Schema.V1}, "first schema has no reports"),
    ],
)
def test_senseless_options(wrong, text):
    with pytest.raises(LocalProtocolError, match=text):
        ServerOptions(**wrong)


def test_senseless_rates_and_looks():
    with pytest.raises(LocalProtocolError, match="ticks is 0"):
        ReportRate(report=ReportId.IMU, ticks=0)
    for name in ("hz", "bytes_each", "buffer_bytes"):
        with pytest.raises(LocalProtocolError, match=name):
            PollOptions(**{name: 0})


@each("call", ["connect", "disconnect"])
def test_a_rover_has_nobody_to_connect_to(call):
    with pytest.raises(LocalProtocolError, match=call):
        getattr(Connection(Role.SERVER), call)(0)


@each("profile", PROFILES)
def test_every_edge_of_the_rover_is_taken_in_some_case(make_rover, profile):
    """All pairs of state and stimulus; what the options leave out aside."""
    visited = set()
    stimuli = [b"\x00", b"\x01", b"\x7f", b"\x03"]
    for lost, stimulus in itertools.product((False, True, None), [*stimuli, None]):
        rover = make_rover(PROFILES[profile].server)
        if lost:
            rover.wait(1.5)
        elif lost is None:
            rover.hear(rover.frame(b"\x00"))
        rover.hear(b"PX" if stimulus is None else rover.frame(stimulus))
        rover.wait(2.5)
        visited |= {(state.name, trigger.name) for state, trigger in rover.connection.visits}
    states = {"WAITING", "LINKED"} | ({"LOST"} if rover.options.silence_s else set())
    triggers = {"REQUEST", "COMMAND", "UNKNOWN", "BAD_FRAME"} | ({"SHORT"} if rover.options.strict_length else set())
    assert visited >= set(itertools.product(states, triggers))
    assert ("LINKED", "GENERAL_DUE") in visited or not rover.options.rates
