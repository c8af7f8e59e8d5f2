"""What is wrong with a system of somebody's own is a line that names it; nothing is sent to a port that is not its."""

from __future__ import annotations

from textwrap import dedent

import pytest

from hilbench.clock import Scheduler
from tests.hilbench.test_target import board_at_a_port

HEAD = """
from hilbench.plugins.system import API, ModelKind, System
from protocols.common.decoding import NoOptions

KIND = ModelKind(settings=NoOptions, protocol="Tiny", suites=())

class Turn(System):
    api = API
    name = "turn"
    title = "Turn"
"""


@pytest.fixture
def refused(hilbench, tmp_path):
    """Return what checks a bench with a system: its last line on standard error, without the path."""

    def check(body, bench='[targets.a]\nmodel = "turn"\n', after="TURN = Turn()\n"):
        body = dedent(body).replace("\n", "\n    ")
        tmp_path.joinpath("turn.py").write_text(f"{HEAD}    {body}\n\n{after}")
        file = tmp_path / "bench.toml"
        file.write_text(f'version = 1\nplugins = ["turn.py"]\n{bench}')
        code, _, err = hilbench("check", file)
        assert (code, err.count("\n")) == (2, 1), err
        return err.replace(f"{tmp_path}/", "")

    return check


@pytest.mark.parametrize(
    ("body", "said"),
    [
        ("models = None", "turn.py: models cannot be called"),
        ("def models(self): return 3", "turn.py: models() is no mapping of names"),
        ("def models(self): return {1: KIND}", "turn.py: models() is no mapping of names"),
        ("def models(self): return {}['size']", "KeyError: 'size'"),
        ("vehicles = ['turn']", "turn.py: vehicles is no mapping of names"),
        ("def models(self): return {'pioneer-2dx': KIND}", "brings 'pioneer-2dx', which is there already"),
        ("def models(self): return {'other': KIND}", "call it 'turn' or 'turn-...'"),
        ("api = 7", "was written for api 7, and this hilbench has 1"),
    ],
)
def test_a_record_that_is_wrong_is_named(refused, body, said):
    assert said in refused(body)


def test_two_of_one_name_are_refused(refused):
    assert "brings two systems called 'turn'" in refused("pass", after="ONE, TWO = Turn(), Turn()\n")


def test_benches_are_called_like_their_system(refused, tmp_path):
    tmp_path.joinpath("benches").mkdir()
    tmp_path.joinpath("benches", "other.toml").touch()
    body = "from pathlib import Path\nbenches = Path(__file__).with_name('benches')"
    assert "brings 'other', which is not called like it" in refused(body)


@pytest.mark.parametrize(
    ("maker", "said"),
    [
        ("lambda: {}['size']", "turn.py:11: KeyError: 'size'"),
        ("lambda: 3", "vehicle 'turn': its maker returns 3, and no"),
    ],
)
def test_a_vehicle_that_cannot_be_made_is_the_plug_in_s(refused, maker, said):
    body = f"vehicles = {{'turn': {maker}}}\ndef models(self): return {{'turn': KIND}}"
    assert said in refused(body, '[targets.a]\nmodel = "turn"\n[world]\nvehicle = "turn"\n')


def test_a_model_stands_in_no_other_body(refused):
    body = "vehicles = {'turn': None and 0 or (lambda: 0)}\ndef models(self): return {'turn': ModelKind(**ABOUT)}"
    after = 'ABOUT = {"settings": NoOptions, "protocol": "Tiny", "suites": (), "has_body": True}\nTURN = Turn()\n'
    said = refused(body, after=after)
    wrong = "bench.toml:3: 'a' does not stand in the body of a pioneer-2dx"
    assert said == f'hilbench: {wrong}; write vehicle = "turn" under [world]\n'


def test_settings_that_a_model_does_not_have_are_refused(refused):
    body = "def models(self): return {'turn': KIND}"
    assert "unknown key 'fast'" in refused(body, '[targets.a]\nmodel = "turn"\nsettings = { fast = 1 }\n')


@pytest.mark.parametrize("suite", ["pkt-board", "p2os-server", "rover-motion", "bluepill-pins"])
@pytest.mark.parametrize("bench", ["bluepill-robot", "pioneer"])
def test_a_foreign_suite_sends_nothing_to_a_port(hilbench, bench, suite):
    if (bench, suite) == ("pioneer", "p2os-server"):
        return  # its own
    with board_at_a_port() as (board, spec):
        code, out, err = hilbench("check", bench, "--suite", suite, "--target", spec)
        board.live(Scheduler())
        assert (code, out, err.count("\n"), board.heard) == (2, "", 1, b""), err
