"""Frames as rows: folded, joined, aligned."""

from __future__ import annotations

import pytest

from hilbench.tui.model.bench import BenchModel
from hilbench.tui.model.rows import rows_of
from hilbench.tui.views.frames import frames_view
from protocols import autoware, pkt

MS = 1_000_000
ASK = pkt.encode_frame(pkt.encode_command(pkt.RequestTelemetry()))
REPORT = pkt.encode_frame(pkt.encode_report(pkt.GeneralReport(accepted=7)))
MOTION = pkt.encode_frame(pkt.encode_report(pkt.MotionReport(rpm=(1.5, 0.0, 1.5, 0.0))))


@pytest.fixture
def frames_of():
    """Make the frames of bytes that were sent or heard at times in ms."""

    def make(*chunks, protocol="pkt"):
        model = BenchModel({"live": {"operator": "station", "protocol": protocol}})
        kinds = {">": "tx", "<": "rx"}
        model.take(
            {"ns": at_ms * MS, "kind": kinds[way], "source": "station", "data": data.hex()}
            for at_ms, way, data in chunks
        )
        return list(model.frames.frames)

    return make


def said(rows):
    return [(row.frame.item.name, row.count, row.request and row.frame.ns - row.request.ns) for row in rows]


def test_equal_frames_in_a_row_are_one_and_all_of_them_are_kept(frames_of):
    frames = frames_of(*((at, "<", MOTION) for at in range(0, 900, 100)), (900, "<", REPORT), (1000, "<", MOTION))
    rows = rows_of(frames)
    assert said(rows) == [("MotionReport", 9, None), ("GeneralReport", 1, None), ("MotionReport", 1, None)]
    assert [frame for row in rows for frame in row.frames] == frames
    assert len(rows_of(frames, fold=False)) == 11


def test_an_answer_is_joined_to_the_latest_request_and_equal_pairs_are_folded(frames_of):
    pairs = [
        (at + after, way, data) for at in (0, 500, 1000) for after, way, data in ((0, ">", ASK), (12, "<", REPORT))
    ]
    assert said(rows_of(frames_of(*pairs))) == [("GeneralReport", 3, 12 * MS)]
    lost = frames_of((0, ">", ASK), (500, ">", ASK), (510, "<", MOTION), (520, "<", REPORT), (530, "<", REPORT))
    assert said(rows_of(lost)) == [
        ("REQUEST_TMY", 1, None), ("MotionReport", 1, None), ("GeneralReport", 1, 20 * MS), ("GeneralReport", 1, None),
    ]  # fmt: skip
    assert said(rows_of(frames_of((0, ">", ASK), (2001, "<", REPORT))))[-1] == ("GeneralReport", 1, None)


def test_of_several_open_requests_that_with_the_same_number_is_answered(frames_of):
    def framed(message):
        return autoware.encode_frame(autoware.encode_message(message))

    asked = [(number, ">", framed(autoware.ControlModeRequest(sequence=number))) for number in (1, 2, 3)]
    answers = [(10 + number, "<", framed(autoware.ControlModeResponse(sequence=number))) for number in (1, 3)]
    rows = rows_of(frames_of(*asked, *answers, protocol="autoware"), fold=False)
    assert [row.frames[0].item.fields["sequence"] for row in rows] == [2, 1, 3]
    assert [row.request is not None for row in rows] == [False, True, True]


def test_a_request_that_is_too_old_stands_in_no_newer_ones_way(frames_of):
    """The old one has the number of the answer, by noise or because numbers begin anew."""

    def framed(message):
        return autoware.encode_frame(autoware.encode_message(message))

    asked = [(at, ">", framed(autoware.ControlModeRequest(sequence=number))) for at, number in ((0, 7), (2100, 8))]
    answer = (2110, "<", framed(autoware.ControlModeResponse(sequence=7)))
    *_, row = rows_of(frames_of(*asked, answer, protocol="autoware"), fold=False)
    assert row.request.ns == 2100 * MS


def test_columns_are_aligned_and_times_have_their_milliseconds_after_a_minute_too(frames_of):
    noise = (62_007, "<", b"\x00\x01\x02")
    frames = frames_of((59_900, "<", MOTION), (61_980, ">", ASK), (61_990, "<", REPORT), noise, (63_000, "<", MOTION))
    lines = [line.plain for line in frames_view(rows_of(frames), 90, 9)]
    assert [line.index(way) for line, way in zip(lines, "<⇄<<", strict=True)] == [lines[0].index("<")] * 4
    assert lines[1].split()[:3] == ["0:01:01.990", "+10.0", "ms"]
    assert "GeneralReport" in lines[1]
    assert "to REQUEST_TMY in 10.0 ms" in lines[1]
    assert "rpm 1.5 0 1.5 0 rpm" in lines[0]
    assert "!! " in lines[2]
    assert frames_view(rows_of(frames), 90, 9)[2].spans[-1].style == "bold red"


def test_the_figures_of_a_message_stand_one_below_the_other(frames_of):
    status = [pkt.encode_frame(pkt.encode_report(pkt.GeneralReport(accepted=count))) for count in (7, 250, 40)]
    frames = frames_of(*((10 * number, "<", data) for number, data in enumerate(status)))
    lines = [line.plain for line in frames_view(rows_of(frames, fold=False), 200, 9)]
    ends = {line.index("accepted ") + len("accepted ") + 3 for line in lines}
    assert len(lines) == 3
    assert len(ends) == 1
    assert [line[end - 3 : end] for line in lines for end in ends] == ["  7", "250", " 40"]
