"""A screen without a terminal."""

from __future__ import annotations

import re
from xml.etree import ElementTree

import pytest

from tests.each import each

pytestmark = pytest.mark.usefixtures("all_done")


def drawn(*told):
    """Return the words in the picture of what was told."""
    from hilbench.tui.picture import draw

    return words(draw(*told))


def words(svg):
    root = ElementTree.fromstring(svg)
    return re.sub(r"\s", " ", " ".join(text for text in root.itertext() if text))


@each(("bench", "seen"), [("pioneer", "pioneer-2dx"), ("rover", "LINKED")])
def test_a_picture_has_the_panes_and_what_is_said(recordings, bench, seen):
    header, events = recordings[bench]
    found = drawn(header, events, "FAIL suite/it: [bold]it did not")
    for word in (seen, "FAIL suite/it: [bold]it did not", "Watchdogs", "Counters", "Frames", "States", "Log"):
        assert word in found


def test_of_a_case_without_anything_there_is_a_picture_too():
    assert "ERROR nothing was opened" in drawn({"kind": "journal", "bench": "x"}, [], "ERROR nothing was opened")


def test_events_that_are_not_understood_spoil_no_picture(recordings):
    header, events = recordings["pioneer"]
    broken = [{**event, "data": "no hex"} if event["kind"] == "tx" else event for event in events]
    assert "FAIL" in drawn(header, [{"ns": 0, "kind": "machine", "source": "x", "timers": 3}, *broken], "FAIL")
