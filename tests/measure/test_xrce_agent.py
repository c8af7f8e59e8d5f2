"""The measurements of the agent: that each does what it says it measures; the figures are the page's."""

from __future__ import annotations

import pytest

from measure.xrce_agent import BAUD, WAYS, deaf, frame_bytes, page, parts, reconnects, serial_rate
from protocols import xrce
from tests.share import few


@pytest.mark.parametrize("way", few([*WAYS], 2, "seconds of bench time in each of six ways; the gate has two"))
def test_a_board_is_back_and_nothing_of_before_is_left(way):
    found = reconnects(way, 2)
    assert found["count"] == 2
    assert 10 < found["median_ms"] <= found["most_ms"] < 2000


def test_a_client_that_never_reads_costs_no_more_than_a_queue_and_a_history():
    options = xrce.AgentOptions()
    assert 0 < deaf(50)["held"] < options.streams.max_queued + options.max_history_bytes


def test_a_line_passes_no_more_than_it_can():
    found = serial_rate(BAUD, 20, reliable=True, seconds=0.1)
    assert found["frame"] == frame_bytes(20, xrce.Framing.SERIAL)
    assert 0.8 < found["share"] <= 1.05  # of a tenth of a second one sample more or less


def test_the_page_has_a_row_for_each_part():
    figures = dict.fromkeys(("median_ms", "most_ms", "memory_early", "memory_late", "held", "count"), 1)
    rates = dict.fromkeys(("rate", "limit", "share", "frame", "cpu_us"), 2)
    names = [*parts(1, 1, 1.0)]
    text = page({name: rates if name.startswith("rate ") else figures for name in names})
    rows = [line for line in text.splitlines() if line.startswith("| ")]
    assert len(rows) == len(names) - 1 + 2  # a client that never reads has a paragraph, and tables have heads
