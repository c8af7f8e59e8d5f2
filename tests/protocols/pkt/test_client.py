"""The host: asking, noticing silence, totals; and the client that splits the stream on newlines, with its losses."""

from __future__ import annotations

import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from protocols.pkt import (
    LINE_LIMIT,
    PROFILES,
    ClientOptions,
    ClientState,
    Connection,
    Dropped,
    DropReason,
    FrameDropped,
    Framing,
    FramingOptions,
    GeneralReport,
    ImuReport,
    LedOn,
    LineReader,
    LocalProtocolError,
    LossReason,
    MotionReport,
    MotorSpeeds,
    MotorThrottles,
    PacketTotals,
    ReportReceived,
    RequestTelemetry,
    Role,
    RoverFound,
    RoverLost,
    Schema,
    ServerOptions,
    StateChanged,
    Transmit,
    UnknownCommand,
    UnknownReport,
    encode_command,
    encode_frame,
    encode_report,
    hides_newline,
)
from tests.each import each

SECOND = 1_000_000_000
REQUEST = encode_frame(b"\x00")
GENERAL = encode_frame(encode_report(GeneralReport(accepted=3)))


def client(**options):
    return Connection(Role.CLIENT, ClientOptions(**options))


def sent_in(events):
    return [event.data for event in events if isinstance(event, Transmit)]


def test_it_asks_at_once_and_whenever_it_was_quiet():
    host = client(request_s=0.4, silence_s=None)
    assert host.advance(SECOND) == []
    assert sent_in(host.connect(SECOND)) == [REQUEST]
    assert host.next_deadline_ns() == SECOND * 14 // 10
    host.send(LedOn(), SECOND * 13 // 10)
    assert host.next_deadline_ns() == SECOND * 17 // 10
    assert sent_in(host.advance(SECOND * 25 // 10)) == [REQUEST] * 3
    assert host.counters.requests == 4
    assert host.counters.frames_out == 5


def test_without_keepalive_it_asks_once():
    host = client(request_s=None, silence_s=None)
    assert sent_in(host.connect(0)) == [REQUEST]
    assert host.next_deadline_ns() is None


def test_found_lost_and_found_again():
    host = client()
    host.connect(0)
    found = host.receive(GENERAL, SECOND)
    assert RoverFound() in found
    assert found[-1] == ReportReceived(report=GeneralReport(accepted=3))
    assert host.state is ClientState.LINKED
    assert RoverFound() not in host.receive(GENERAL, SECOND * 2)
    assert RoverLost(reason=LossReason.SILENCE) not in host.advance(SECOND * 4 - 1)
    assert RoverLost(reason=LossReason.SILENCE) in host.advance(SECOND * 4)
    assert host.state is ClientState.LOST
    assert host.counters.silences == 1
    assert REQUEST in sent_in(host.advance(SECOND * 5))
    assert RoverFound() in host.receive(GENERAL, SECOND * 6)


def test_a_rover_that_never_answers():
    host = client()
    host.connect(0)
    assert RoverLost(reason=LossReason.SILENCE) in host.advance(SECOND * 2)


def test_the_line_goes_down():
    host = client()
    assert host.line_down(0) == []
    host.connect(0)
    host.receive(GENERAL[:6], 0)
    dropped, *_, lost = host.line_down(1)
    assert dropped == FrameDropped(reason=DropReason.TIMED_OUT, data=GENERAL[:6])
    assert lost == RoverLost(reason=LossReason.LINE_DOWN)
    assert (host.held, host.counters.silences) == (0, 0)
    assert host.line_down(2) == []


@each(
    ("options", "last"),
    [
        ({}, [encode_frame(encode_command(MotorThrottles(a=0.0, b=0.0)))]),
        ({"schema": Schema.V1}, [encode_frame(encode_command(MotorSpeeds(a=0, b=0), Schema.V1))]),
        ({"stop_at_the_end": False}, []),
    ],
)
def test_it_stops_the_motors_when_it_leaves(options, last):
    host = client(**options)
    host.connect(0)
    assert sent_in(host.disconnect(1)) == last
    assert host.state is ClientState.IDLE
    assert host.next_deadline_ns() is None


def test_who_only_listens_gets_reports_too():
    host = client()
    assert host.receive(GENERAL, 0) == [ReportReceived(report=GeneralReport(accepted=3))]
    assert host.state is ClientState.IDLE
    assert host.next_deadline_ns() is None


def test_connecting_twice_and_leaving_twice():
    host = client()
    with pytest.raises(LocalProtocolError, match="IDLE cannot disconnect"):
        host.disconnect(0)
    host.connect(0)
    deadline_ns = host.next_deadline_ns()
    with pytest.raises(LocalProtocolError, match="WAITING cannot connect"):
        host.connect(SECOND // 10)
    assert host.next_deadline_ns() == deadline_ns


def test_totals_follow_the_counters_through_their_wrapping():
    host = client()
    assert host.totals is None
    for accepted in (250, 255, 4, 4, 3):
        host.receive(encode_frame(encode_report(GeneralReport(accepted=accepted, rejected=1))), 0)
    assert host.totals == PacketTotals(accepted=256 + 256 + 3, rejected=1)
    host.connect(0)
    assert host.totals is None
    assert Connection(Role.SERVER).totals is None


def test_a_report_of_the_wrong_size_is_counted_and_an_unknown_one_handed_on():
    host = client()
    assert host.receive(encode_frame(b"\x82\x01"), 0) == [
        FrameDropped(reason=DropReason.BAD_BODY, data=encode_frame(b"\x82\x01"))
    ]
    assert host.counters.bad_bodies == 1
    assert host.receive(encode_frame(b"\x99ab"), 0) == [
        ReportReceived(report=UnknownReport(report_id=0x99, data=b"ab"))
    ]


@each(
    ("message", "text"),
    [
        (GeneralReport(), "GeneralReport is not for a client"),
        (MotorSpeeds(a=1, b=1), "no command of schema V2"),
        (UnknownCommand(opcode=9, parameters=bytes(96)), "97 bytes"),
    ],
)
def test_what_a_host_cannot_send(message, text):
    host = client()
    host.connect(0)
    before = (host.next_deadline_ns(), host.counters.bytes_out)
    with pytest.raises(LocalProtocolError, match=text):
        host.send(message, SECOND // 10)
    assert (host.next_deadline_ns(), host.counters.bytes_out) == before


def test_it_may_send_what_no_rover_knows():
    assert client().send(UnknownCommand(opcode=0x7F), 0) == bytes.fromhex("50 4B 54 21 01 7F 6E 88 0A")
    assert client().send(RequestTelemetry(report_type=0), 0) == bytes.fromhex("50 4B 54 21 02 00 00 1D 0F 0A")


@each("call", ["telemetry", "set_status"])
def test_a_host_has_no_telemetry(call):
    host = client()
    with pytest.raises(LocalProtocolError, match="client has no telemetry"):
        host.set_status(0) if call == "set_status" else host.telemetry


def test_the_options_belong_to_a_role():
    with pytest.raises(LocalProtocolError, match="ServerOptions are not the options of a client"):
        Connection(Role.CLIENT, ServerOptions())
    for wrong in ({"request_s": 0.0}, {"silence_s": -1.0}):
        with pytest.raises(LocalProtocolError, match=next(iter(wrong))):
            ClientOptions(**wrong)


def test_it_finds_the_report_behind_a_damaged_one():
    host = client()
    damaged = bytearray(GENERAL)
    damaged[4] ^= 0x20  # a length that swallows what follows
    events = host.receive(bytes(damaged) + GENERAL * 3, 0)
    events += host.advance(SECOND)
    assert sum(isinstance(event, ReportReceived) for event in events) == 3


# ---- the client that splits lines


def imu_frames(n, seed):
    chance = random.Random(seed)
    for _ in range(n):
        yield encode_frame(b"\x82\x03\0\0" + chance.randbytes(56))


def test_p36_what_a_line_splitting_client_loses_of_random_reports():
    """Payload and CRC must be free of newlines; what stands fixed in this report is: (255/256)^58 of them come."""
    splitting = Connection(Role.CLIENT, PROFILES["g2"].client)
    driven = client()
    n = 4000
    seen = {splitting: 0, driven: 0}
    for frame in imu_frames(n, seed=1):
        for connection in seen:
            seen[connection] += sum(isinstance(event, ReportReceived) for event in connection.receive(frame, 0))
    expected = 1 - (255 / 256) ** 58
    error = (expected * (1 - expected) / n) ** 0.5
    assert 1 - seen[splitting] / n == pytest.approx(expected, abs=4 * error)
    assert seen[driven] == n


def test_p37_a_counter_of_ten_is_never_shown():
    host = Connection(Role.CLIENT, PROFILES["g2"].client)
    shown = []
    for accepted in range(20):
        report = GeneralReport(accepted=accepted, last_opcode=1)
        shown += [
            event.report.accepted
            for event in host.receive(encode_frame(encode_report(report)), 0)
            if isinstance(event, ReportReceived)
        ]
    assert shown == [n for n in range(20) if n != 10]


def test_with_opcode_three_two_more_counts_go_dark():
    """0x80 with LAST_OPCODE 3 and nothing rejected: 10 by itself, 4 and 195 through the CRC."""
    dark = [n for n in range(256) if hides_newline(encode_report(GeneralReport(accepted=n, last_opcode=3)))]
    assert dark == [4, 10, 195]


def test_it_never_looks_at_the_crc():
    wrong = GENERAL[:-3] + b"\0\0\n"
    assert len(LineReader().receive(wrong, 0)[0].payload) == 6
    assert client(split_lines=True).receive(wrong, 0) == [ReportReceived(report=GeneralReport(accepted=3))]


@each(
    ("line", "reason"),
    [
        (b"x" + GENERAL, DropReason.BAD_SYNC),
        (b"\n", DropReason.BAD_SYNC),
        (b"PKT!\n", DropReason.BAD_LENGTH),
        (encode_frame(b"\x80"), DropReason.BAD_LENGTH),
        (b"PKT!\x06\x80\n", DropReason.BAD_LENGTH),
    ],
)
def test_lines_that_are_no_frames(line, reason):
    assert LineReader().receive(line, 0)[0] == Dropped(reason=reason, data=line)


def test_a_line_is_cut_by_time_and_by_length():
    reader = LineReader()
    assert reader.receive(b"ab", 5) == []
    assert reader.next_deadline_ns() == 5 + SECOND
    assert reader.expire(4 + SECOND) == []
    assert reader.receive(b"cd\n", 5 + SECOND) == [
        Dropped(reason=DropReason.BAD_SYNC, data=b"ab"),
        Dropped(reason=DropReason.BAD_SYNC, data=b"cd\n"),
    ]
    assert [len(item.data) for item in reader.receive(b"x" * 2500, 0)] == [LINE_LIMIT] * 2
    assert reader.held == 2500 - 2 * LINE_LIMIT
    assert len(reader.reset()) == 1
    assert reader.reset() == []
    with pytest.raises(LocalProtocolError, match="timeout_ns"):
        LineReader(timeout_ns=0)


@given(st.lists(st.one_of(st.just(GENERAL), st.binary(max_size=9), st.just(b"\n")), max_size=9), st.integers(1, 20))
def test_lines_do_not_depend_on_how_they_are_cut(parts, size):
    stream = b"".join(parts)
    whole, pieces = LineReader(), LineReader()
    found = [item for at in range(0, len(stream), size) for item in pieces.receive(stream[at : at + size], 0)]
    assert found == whole.receive(stream, 0)
    assert pieces.held == whole.held


def test_a_host_of_each_profile_understands_its_rover():
    for profile in PROFILES.values():
        rover = Connection(Role.SERVER, profile.server)
        host = Connection(Role.CLIENT, profile.client)
        host.connect(0)
        answers = rover.receive(host.send(RequestTelemetry(), 0), 0) + rover.advance(SECOND)
        data = b"".join(sent_in(answers))
        events = host.receive(data, SECOND)
        expected = GeneralReport(status=0 if profile.server.general_status else None)
        assert ReportReceived(report=expected) in events, profile.name


def test_frames_without_a_length_byte_reach_a_host_too():
    options = FramingOptions(framing=Framing.TERM)
    host = client(frames=options, schema=Schema.V1B)
    assert host.receive(encode_frame(encode_report(ImuReport(), Schema.V1B), options), 0) == [
        ReportReceived(report=ImuReport())
    ]
    with pytest.raises(LocalProtocolError, match="no report of schema V1B"):
        encode_report(MotionReport(), Schema.V1B)


def test_changes_of_state_are_events():
    host = client()
    changes = [event for event in host.connect(0) if isinstance(event, StateChanged)]
    assert [(change.old, change.new) for change in changes] == [(ClientState.IDLE, ClientState.WAITING)]
    assert str(LossReason.SILENCE) == "no report for too long"
