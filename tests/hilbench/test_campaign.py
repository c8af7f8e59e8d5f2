"""The campaign of the dodger: what it keeps of a drive, and the pages and pictures made of that."""

from __future__ import annotations

import json
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

from measure.campaign.__main__ import DOCS, main
from measure.campaign.drives import Figures
from measure.campaign.pages import page


def figures(way, seed, **others):
    plain = {
        "bench_s": 180.0, "way_m": 30.04, "contacts": 0, "touched": "", "least_clearance_m": 0.2345, "changes": 12,
        "turns": 6, "backs": 0, "longest_turn_s": 3.0, "blind_s": 0.008, "end": "",
    }  # fmt: skip
    return Figures(way=way, seed=seed, **plain | others)


def test_a_page_has_a_line_for_each_room_and_a_summary_for_each_way():
    record = [figures("a", 0), figures("a", 1, way_m=20.0, contacts=3, touched="box_1 after 2.0 s"), figures("c", 1)]
    lines = page([one.data() for one in record]).splitlines()
    assert "| a | pins straight to the wheels (`bluepill`) | 2 | 1 | 20.0 to 30.0 | 0.23 | 3.0 | 0 |" in lines
    assert "| 0 | 30.0 | 0 | 12 | 0.23 | - | - | - | - | - | - | - | - |" in lines
    assert not any(line.startswith("| b |") for line in lines)
    assert sum(line.startswith("| 1 |") for line in lines) == 1
    assert [one.good for one in record] == [True, False, True]


@pytest.mark.needs_physics
def test_a_short_campaign_keeps_what_it_found(tmp_path, capfd):
    (tmp_path / "images").mkdir()
    assert main(["--seeds", "1", "--way", "a", "--seconds", "1", "--docs", str(tmp_path)]) == 0
    assert capfd.readouterr().err == "1/1 way a, seed 0: 0.2 m, no contact\n"
    (row,) = json.loads((tmp_path / "campaign.json").read_text())
    assert (row["way"], row["seed"], row["contacts"], row["end"]) == ("a", 0, 0, "")
    assert main(["--seeds", "1", "--way", "a", "--missing", "--docs", str(tmp_path)]) == 0
    assert main(["--picture", "0", "--seconds", "0.5", "--docs", str(tmp_path)]) == 0
    ET.parse(tmp_path / "images" / "dodge.svg")


def test_the_page_in_the_docs_is_made_from_its_record():
    record = json.loads((DOCS / "campaign.json").read_text(encoding="utf-8"))
    assert (DOCS / "campaign.md").read_text(encoding="utf-8") == page(record)
    assert {(row["way"], row["seed"]) for row in record} >= {(way, seed) for way in "abc" for seed in range(20)}
    assert Path(DOCS / "images" / "dodge.svg").is_file()
