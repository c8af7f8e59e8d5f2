"""What a line-splitting client loses: a small run of the experiment of `measure.loss`, against its formula."""

from __future__ import annotations

import random
from itertools import islice
from pathlib import Path

import pytest

from measure.loss.measure import Loss, by_formula, lost_by_lines, lost_by_newline
from measure.loss.payloads import STRUCTURED, random_payloads
from protocols.pkt import hides_newline
from tests.each import each

DOCS = Path(__file__).parents[3] / "docs"


@each("size", [3, 12, 60, 96])
def test_random_payloads_follow_the_formula(size):
    loss = lost_by_newline(random_payloads(size, random.Random(size)), 20_000)
    assert loss.share == pytest.approx(by_formula(size), abs=2 * loss.uncertainty)


def test_one_byte_is_no_random_payload():
    assert sum(hides_newline(bytes((byte,))) for byte in range(256)) == 4


def test_lines_lose_one_imu_report_in_five_and_lengths_none():
    payloads = STRUCTURED["0x82, random floats"][1](random.Random(1))
    by_line, by_length = lost_by_lines(payloads, 5000)
    assert by_line.share == pytest.approx(by_formula(56), abs=2 * by_line.uncertainty)
    assert by_length == Loss(0, 5000)


def test_a_line_is_lost_exactly_if_it_hides_a_newline():
    for name, (_, make) in STRUCTURED.items():
        payloads = list(islice(make(random.Random(2)), 600))
        if len(payloads[0]) != 10:  # the length is a newline then
            by_line, _ = lost_by_lines(iter(payloads), len(payloads))
            assert by_line == lost_by_newline(iter(payloads), len(payloads)), name


def test_the_page_has_the_figures_of_the_formula():
    page = (DOCS / "pkt" / "loss.md").read_text(encoding="utf-8")
    for size in (1, 12, 60):
        assert f"| {size} | {by_formula(size):.2%} |" in page
