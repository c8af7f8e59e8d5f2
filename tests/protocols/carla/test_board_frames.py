"""What the board makes of its bytes: the original's blocks of 22, and the reader that finds its way back."""

from __future__ import annotations

import math
import struct

import pytest

from protocols.carla import (
    COMMAND_LAYOUT,
    NOISE_RUN,
    PARSER_TABLE,
    PROFILES,
    STATUS_LAYOUT,
    VECTORS,
    BlockReader,
    DeadlineMissed,
    Dropped,
    DropReason,
    FrameDropped,
    LineDead,
    LiveParser,
    Mode,
    StatusFrame,
    StatusReceived,
    StreamReader,
    encode_status,
)
from tests.each import each

MS = 1_000_000
F4, F5, F6, F7 = (VECTORS[name].data for name in ("F4", "F5", "F6", "F7"))
ALL = pytest.mark.parametrize("profile", PROFILES)
SHIPPED = pytest.mark.parametrize("profile", ["v0", "v1"])


def with_float(tag, bits, base=F5):
    at = base.index(tag)
    return base[: at + 1] + bits + base[at + 5 :]


NAN, INFINITY, HUGE = (struct.pack("<f", value) for value in (math.nan, math.inf, 1e30))


@pytest.fixture
def hearing(make_board):
    """Makes a board that stands in MANUAL and has heard one status, F5."""

    def make(profile="hardened", quirks=()):
        board = make_board(profile, quirks)
        board.agent()
        board.hear(F5)
        return board

    return make


def accepted(board):
    return [event.status for event in board.since(0, StatusReceived)]


def reasons(board):
    return [event.reason for event in board.since(0, FrameDropped)]


@ALL
@pytest.mark.parametrize(("data", "speed"), [(F6, 0.641665), (F7, 0.550980)])
def test_delimiters_within_a_float_are_data(hearing, profile, data, speed):
    board = hearing(profile)
    board.hear(data)
    assert accepted(board)[-1].lon_speed_m_s == pytest.approx(speed, abs=1e-6)
    assert len(accepted(board)) == 2


@ALL
def test_a_frame_may_come_in_pieces(hearing, profile):
    board = hearing(profile)
    board.hear(F6[:10])
    board.run(0.05)
    board.hear(F6[10:])
    assert len(accepted(board)) == 2


@ALL
def test_22_times_hash_is_no_status(hearing, profile):
    board = hearing(profile)
    board.hear(b"#" * 22)
    assert len(accepted(board)) == 1


@SHIPPED
def test_missing_fields_keep_their_old_values(hearing, profile):
    board = hearing(profile)
    old = accepted(board)[0]
    board.hear((b"#A" + struct.pack("<f", 3.0) + b"$").ljust(22, b"\0"))
    new = accepted(board)[1]
    assert (new.lon_speed_m_s, new.lat_speed_m_s) == (3.0, old.lat_speed_m_s)


@SHIPPED
def test_a_frame_that_dies_leaves_its_first_fields(hearing, profile):
    board = hearing(profile)
    board.hear(with_float(b"A", struct.pack("<f", 7.0))[:11] + b"?" * 11)
    board.hear((b"#D" + bytes(4) + b"$").ljust(22, b"\0"))
    assert accepted(board)[1].lon_speed_m_s == 7.0


@each(
    ("data", "reason"),
    [
        (b"#A" + bytes(4) + b"$" + bytes(15), DropReason.MISSING_FIELD),
        (b"#B" + bytes(4) + F5[6:], DropReason.MISSING_FIELD),
        (F5[:6] + b"A" + F5[7:], DropReason.DUPLICATE_FIELD),
        (F5[:6] + b"?" + F5[7:], DropReason.BAD_LETTER),
        (F5[:21] + b"\0", DropReason.BAD_LETTER),
        (F5[:21] + b"D", DropReason.DUPLICATE_FIELD),
        (with_float(b"C", NAN), DropReason.NOT_FINITE),
        (with_float(b"D", INFINITY), DropReason.NOT_FINITE),
        (with_float(b"A", HUGE), DropReason.IMPLAUSIBLE),
        (with_float(b"B", struct.pack("<f", -150.5)), DropReason.IMPLAUSIBLE),
        (with_float(b"C", struct.pack("<f", 20.5)), DropReason.IMPLAUSIBLE),
        (with_float(b"D", struct.pack("<f", -2.5)), DropReason.IMPLAUSIBLE),
    ],
)
def test_what_the_hardened_board_drops_and_why(hearing, data, reason):
    board = hearing()
    board.hear(data)
    assert reasons(board)[0] is reason
    assert len(accepted(board)) == 1
    board.hear(F5)
    assert len(accepted(board)) == 2
    assert sum(getattr(board.counters, name) for name in ("bad_letters", "missing_fields", "duplicate_fields")) == (
        reason in (DropReason.BAD_LETTER, DropReason.MISSING_FIELD, DropReason.DUPLICATE_FIELD)
    )


@SHIPPED
@pytest.mark.parametrize("bits", [NAN, INFINITY, HUGE])
def test_the_originals_believe_any_figure(driving, profile, bits):
    board = driving(profile)
    board.hear(with_float(b"A", bits))
    board.run(0.1)
    told = [struct.pack("<f", report.status.lon_speed_m_s) for report in board.statuses()]
    assert bits in told


@SHIPPED
def test_one_stray_byte_is_for_ever(driving, profile):
    board = driving(profile)
    start = board.now_ns
    board.hear(b"\0")
    board.run(60.0)
    assert board.since(start, StatusReceived) == []
    assert board.mode is Mode.EMERGENCY
    assert board.counters.empty_blocks == pytest.approx(1200, abs=2)
    first = next(at for at, mode in board.frames(start) if mode == 0)
    assert first == pytest.approx(1000, abs=101)


def test_the_hardened_board_misses_none(driving):
    board = driving()
    start = board.now_ns
    board.hear(b"\0")
    board.run(1.0)
    assert len(board.since(start, StatusReceived)) == 20
    assert reasons(board) == [DropReason.NOISE]


def test_21_lost_bytes_are_as_bad_as_one(driving):
    board = driving("v0")
    board.hear(F5[:21])
    board.run(3.0)
    assert board.mode is Mode.EMERGENCY


def test_the_shift_heals_by_chance(driving):
    board = driving("v0")
    board.hear(b"\0")
    board.run(2.0)
    board.hear(F5[:21])
    board.run(0.2)
    assert board.mode is Mode.MANUAL


# --- line errors


@SHIPPED
def test_a_line_error_ends_reception(driving, profile):
    board = driving(profile)
    board.line_error()
    board.line_error()
    start = board.now_ns
    board.run(3.0)
    assert board.since(0, LineDead) == [LineDead()]
    assert board.since(start, StatusReceived) == []
    assert board.counters.line_errors == 2
    assert board.counters.lost_bytes == 22 * 60
    assert board.mode is Mode.EMERGENCY


def test_a_line_error_is_counted_by_the_hardened_board(driving):
    board = driving()
    board.line_error()
    start = board.now_ns
    board.run(1.0)
    assert len(board.since(start, StatusReceived)) == 20
    assert board.counters.line_errors == 1


# --- stale


@each(("profile", "first_miss_ms", "dropped"), [("hardened", 20_100, 1), ("v0", 20_160, 0)])
def test_an_old_status_is_no_answer(make_board, profile, first_miss_ms, dropped):
    """A status of the twenty seconds before the first frame does not count as one that followed it."""
    board = make_board(profile)
    board.run(5.0)
    board.status()
    board.run(16.0)
    assert board.times(DeadlineMissed)[0] == first_miss_ms
    assert board.counters.stale_dropped == dropped


@each(("profile", "stale"), [("hardened", 0), ("v0", 9), ("v1", 9)])
def test_old_statuses_are_reported_again_or_not(driving, profile, stale):
    board = driving(profile)
    board.every("status", None)
    board.run(0.06)
    start = board.now_ns
    board.run(2.0)
    reports = board.statuses(start)
    assert len(reports) == pytest.approx(stale, abs=1 if stale else 0)
    assert not any(report.fresh for report in reports)


# --- the readers alone


def test_the_original_parser_walks_its_whole_table():
    parser = LiveParser(STATUS_LAYOUT)
    data = F5 + b"?A$" + b"##" + b"#?" + b"#$" + F6
    assert len(list(parser.parse(data))) == 3
    assert parser.visits.keys() == PARSER_TABLE.keys()


def test_fields_may_come_in_any_order_to_the_original():
    parser = LiveParser(STATUS_LAYOUT)
    (status,) = parser.parse(b"#" + F5[16:21] + F5[11:16] + F5[1:11] + b"$")
    assert encode_status(status) == F5


def test_a_block_may_hold_several_ends():
    (first, second) = BlockReader().receive(b"#$" * 2 + bytes(18), 0)
    assert first == second == StatusFrame()


def anything(frame):
    del frame


def test_an_unfinished_frame_is_given_up_after_its_time():
    reader = StreamReader(STATUS_LAYOUT, anything, timeout_ns=100 * MS)
    assert reader.receive(F5[:10], 0) == []
    assert reader.next_deadline_ns() == 100 * MS
    assert reader.expire(100 * MS - 1) == []
    assert reader.expire(100 * MS) == [Dropped(reason=DropReason.TIMED_OUT, data=F5[:10])]
    assert reader.receive(F5[10:], 101 * MS) == []
    (noise, frame) = reader.receive(F5, 102 * MS)
    assert noise == Dropped(reason=DropReason.NOISE, data=F5[10:])
    assert isinstance(frame, StatusFrame)


def test_what_hides_in_an_unfinished_frame_has_its_own_time():
    reader = StreamReader(STATUS_LAYOUT, anything, timeout_ns=100 * MS)
    reader.receive(b"#A", 0)
    reader.receive(F5[:3], 60 * MS)
    assert reader.expire(100 * MS) == [Dropped(reason=DropReason.TIMED_OUT, data=b"#A")]
    assert reader.next_deadline_ns() == 160 * MS
    assert [type(item) for item in reader.receive(F5[3:], 110 * MS)] == [StatusFrame]


def test_noise_is_bounded_and_reported_in_runs():
    reader = StreamReader(STATUS_LAYOUT, anything)
    found = reader.receive(b"x" * (2 * NOISE_RUN + 5), 0)
    assert [len(item.data) for item in found] == [NOISE_RUN, NOISE_RUN]
    assert reader.held == 5
    assert reader.reset() == [Dropped(reason=DropReason.NOISE, data=b"xxxxx")]


def test_the_nul_behind_a_command_is_no_noise():
    reader = StreamReader(COMMAND_LAYOUT, anything)
    data = VECTORS["F1"].data
    assert len(reader.receive(data + data[:29] + data + b"\0", 0)) == 3
    assert reader.reset() == [Dropped(reason=DropReason.NOISE, data=b"\0")]
    assert StreamReader(STATUS_LAYOUT, anything).receive(F5 + b"\0" + F5, 0)[1].reason is DropReason.NOISE
