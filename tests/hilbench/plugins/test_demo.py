"""``hilbench demo`` of a system that a user brings, up to where it would play."""

from __future__ import annotations

import pytest

from hilbench.commands import demo as command

TURN = """
from hilbench.plugins.demo import Demo, LiveBench, Scene
from hilbench.plugins.system import API, System

class Turn(System):
    api = API
    name = title = "turn"

    def demo(self, *, physics):
        return {demo}

TURN = Turn()
"""


@pytest.fixture
def asked(hilbench, tmp_path, monkeypatch):
    """Ask for a demo; return the exit code, the line on standard error, and the script that would be played."""
    scripts = []
    monkeypatch.setattr("hilbench.commands.dashboard.require_terminal", lambda hint: None)
    monkeypatch.setattr(command, "_played", lambda demo, start, theme: scripts.append(demo) or 0)

    def ask(name, demo):
        file = tmp_path / "turn.py"
        file.write_text(TURN.replace("{demo}", demo))
        code, _, err = hilbench("demo", name, "--plugin", file)
        return code, err.replace(f"{tmp_path}/", ""), scripts

    return ask


def test_a_system_brings_its_own(asked):
    own = "Demo(title='Mine', scenes=(Scene(title='a', text='', lasts_s=1, bench=LiveBench(bench='b')),))"
    code, said, (script,) = asked("turn", own)
    assert (code, said, script.title) == (0, "", "Mine")


@pytest.mark.parametrize(
    ("name", "demo", "said"),
    [
        ("tturn", "None", "hilbench: demo: no system 'tturn'; did you mean 'turn'?\n"),
        ("turn", "None", "hilbench: the system 'turn' brings no demo; these do: rover\n"),
        ("turn", "3", "hilbench: turn.py:9: Turn.demo() returns 3, and no Demo\n"),
        (
            "turn",
            "Demo(title='', scenes=())",
            "hilbench: turn.py:10: ValueError: the first scene of a demo opens a bench",
        ),
    ],
)
def test_a_demo_that_is_not_there_is_one_line(asked, name, demo, said):
    code, line, scripts = asked(name, demo)
    assert (code, line[: len(said)], line.count("\n"), scripts) == (2, said, 1, [])
