"""What a dashboard remembers, in a file that may be damaged, not be there, or not be writable."""

from __future__ import annotations

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hilbench.systems.rover.dashboard import DASHBOARD as ROVER
from hilbench.tui.memory import Memory, state_file
from hilbench.tui.model.arrangement import arrangement_of
from hilbench.tui.model.dashboards import ROBOT as DASHBOARD

ROBOT = arrangement_of(DASHBOARD, wide=True)


def test_what_was_arranged_is_found_again(tmp_path):
    path = tmp_path / "deep" / "dashboard.json"
    first = Memory(path)
    mine = ROBOT.moved("log", columns=-2).toggled("states").resized({"link", "world"}, 200, 60, "link", dx=9, dy=0)
    first.arrange("robot", mine, wide=True)
    first.plot("rover", ["rpm"], 60)
    first.theme = "textual-light"
    again = Memory(path)
    assert again.arrangement(DASHBOARD, wide=True) == mine
    assert again.arrangement(DASHBOARD, wide=False) == arrangement_of(DASHBOARD, wide=False)
    assert again.arrangement(ROVER, wide=True) == arrangement_of(ROVER, wide=True)
    assert (again.signals("rover"), again.signals("board")) == ((["rpm"], 60), (None, 20))
    assert again.theme == "textual-light"
    assert again.problems == []
    again.arrange("robot", None, wide=True)
    assert Memory(path).arrangement(DASHBOARD, wide=True) == ROBOT


DAMAGED = {
    "nothing": "",
    "half": '{"theme": "textual-li',
    "other": '{"kinds": {"robot": {"wide": 7}}}',
    "newer": '{"version": 9}',
    "shares": json.dumps({"kinds": {"robot": {"wide": {"columns": [{"share": -1.0, "panes": []}]}}}}),
    "columns": json.dumps({"kinds": {"robot": {"wide": {"columns": []}}}}),
}


@pytest.mark.parametrize("damage", DAMAGED)
def test_a_damaged_file_costs_what_it_held_and_a_line(tmp_path, damage):
    path = tmp_path / "dashboard.json"
    path.write_text(DAMAGED[damage])
    memory = Memory(path)
    assert memory.arrangement(DASHBOARD, wide=True) == ROBOT
    assert memory.problems == [f"{path}: is damaged; the panes are as they are at first"]
    memory.theme = "textual-light"
    assert Memory(path).problems == []


@given(st.binary(max_size=60))
def test_no_bytes_in_the_file_break_it(tmp_path_factory, data):
    path = tmp_path_factory.getbasetemp() / "any.json"
    path.write_bytes(data)
    assert Memory(path).arrangement(DASHBOARD, wide=True) == ROBOT


def test_an_arrangement_of_other_panes_is_not_taken(tmp_path):
    path = tmp_path / "dashboard.json"
    pane = {"columns": [{"share": 1, "panes": [["link", 1]]}]}
    path.write_text(json.dumps({"kinds": {"robot": {"wide": pane}}}))
    assert Memory(path).arrangement(DASHBOARD, wide=True) == ROBOT


def test_a_file_that_cannot_be_written_is_said_once(tmp_path):
    (tmp_path / "file").write_text("")
    memory = Memory(tmp_path / "file" / "dashboard.json")
    memory.problems.clear()
    memory.theme = "textual-light"
    memory.theme = "textual-dark"
    (said,) = memory.problems
    assert said.startswith(f"{tmp_path / 'file' / 'dashboard.json'}: ")
    assert said.endswith("what you arrange is forgotten when you leave")
    assert memory.theme == "textual-dark"


def test_the_file_is_where_state_belongs(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    assert state_file() == tmp_path / "hilbench" / "dashboard.json"
    monkeypatch.setenv("XDG_STATE_HOME", "relative")
    monkeypatch.setenv("HOME", "/home/me")
    assert str(state_file()) == "/home/me/.local/state/hilbench/dashboard.json"
