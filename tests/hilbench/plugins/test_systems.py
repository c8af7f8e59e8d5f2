"""What is wrong with a system of somebody's own is a line that names it; nothing is sent to a port that is not its."""

from __future__ import annotations

from textwrap import dedent

import pytest

from hilbench.clock import Scheduler
from tests.hilbench.test_target import board_at_a_port
from tests.share import matrix

HEAD = """
from hilbench.plugins.system import API, ModelKind, System
from functools import partial
from hilbench.plugins.system import VehicleKind
from protocols.common.decoding import NoOptions

Body = partial(VehicleKind, vehicle=dict, body=dict, signals={}, wire=dict, size_m=(1, 1))
KIND = ModelKind(settings=NoOptions, protocol="Tiny", suites=())

class Turn(System):
    api = API
    name = "turn"
    title = "Turn"
"""


@pytest.fixture
def refused(hilbench, tmp_path):
    """Return what checks a bench with a system: its last line on standard error, without the path."""

    def check(body, bench='[targets.a]\nmodel = "turn"\n', after="TURN = Turn()\n", words=("check",)):
        body = dedent(body).replace("\n", "\n    ")
        tmp_path.joinpath("turn.py").write_text(f"{HEAD}    {body}\n\n{after}")
        file = tmp_path / "bench.toml"
        file.write_text(f'version = 1\nplugins = ["turn.py"]\n{bench}')
        code, _, err = hilbench(words[0], file, *words[1:])
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
        ("speakers = ['turn']", "turn.py: speakers is no mapping of names"),
        ("hand_requests = {'press': 'press it'}", "hand_requests is no mapping of names to HandRequests"),
        (
            """
            from hilbench.plugins.system import HandRequest
            hand_requests = {'hold': HandRequest(text='hold it', capability='x', undo='let go')}
            """,
            "its request 'hold' is undone by 'let go', which is none",
        ),
    ],
)
def test_a_record_that_is_wrong_is_named(refused, body, said):
    assert said in refused(body)


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ("settings=3", "settings: no dataclass"),
        ("protocol=None", "protocol is no text"),
        ("suites='suite.py'", "suites is no tuple of str"),
        ("suites=(3,)", "suites is no tuple of str"),
        ("baud='fast'", "baud is no whole number from 300 on"),
        ("rates=9600", "rates is no tuple of int"),
        ("lines=['host']", "lines is no tuple of str"),
        ("lines=()", "lines is empty"),
        ("target=None", "target is no text"),
        ("beside=3", "beside is no bool"),
    ],
)
def test_a_model_kind_that_is_wrong_is_named(refused, wrong, said):
    body = f"def models(self): return {{'turn': replace(KIND, {wrong})}}"
    after = "from dataclasses import replace\nTURN = Turn()\n"
    assert refused(body, after=after) == f"hilbench: turn.py: its model 'turn': {said}\n"


def test_a_model_kind_s_suite_that_is_not_there_is_its_plug_in_s(refused):
    said = refused("def models(self): return {'turn': replace(KIND, suites=('nosuch.py',))}",
                   after="from dataclasses import replace\nTURN = Turn()\n")  # fmt: skip
    hint = "its ModelKind names shipped suites and paths: str(Path(__file__).with_name('nosuch.py'))"
    assert said == f"hilbench: bench.toml:4: the model 'turn' has the suite 'nosuch.py', which is not there; {hint}\n"


@pytest.mark.parametrize(
    ("method", "words", "kind"),
    [
        ("provider", ("check",), "BenchProvider"),
        ("served", ("serve", "--pty", "./never"), "ServedTarget"),
        ("rig", ("live", "--folder", "."), "Rig"),
        ("lines_asked", ("live", "--folder", ".", "--target", "serial:/dev/nothing"), "Mapping"),
    ],
)
@pytest.mark.parametrize("junk", ["None", "3"])
def test_a_method_that_returns_something_else_is_the_plug_in_s(
    refused, tmp_path, monkeypatch, method, words, kind, junk
):
    monkeypatch.chdir(tmp_path)
    said = refused(
        f"def models(self): return {{'turn': KIND}}\ndef {method}(self, *a, **k): return {junk}", words=words
    )
    assert said == f"hilbench: turn.py:15: Turn.{method}() returns {junk}, and no {kind}\n"


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
        ("lambda: {}['size']", "turn.py:14: KeyError: 'size'"),
        ("lambda: 3", "vehicle 'turn': its maker returns 3, and no"),
        ("lambda: Body(size_m=3)", "vehicle 'turn': size_m is no length and breadth in m"),
        ("lambda: Body(size_m=(1, 'wide'))", "vehicle 'turn': size_m is no length and breadth in m"),
        ("lambda: Body(signals={'speed': 3})", "vehicle 'turn': signals is no mapping of names to WorldSignals"),
        ("lambda: Body(vehicle=None)", "vehicle 'turn': vehicle cannot be called"),
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


@pytest.mark.parametrize(
    ("suite", "bench"),
    matrix(["pkt-board", "p2os-server", "rover-motion", "bluepill-pins"], ["bluepill-robot", "pioneer"]),
)
def test_a_foreign_suite_sends_nothing_to_a_port(hilbench, bench, suite):
    if (bench, suite) == ("pioneer", "p2os-server"):
        return  # its own
    with board_at_a_port() as (board, spec):
        code, out, err = hilbench("check", bench, "--suite", suite, "--target", spec)
        board.live(Scheduler())
        assert (code, out, err.count("\n"), board.heard) == (2, "", 1, b""), err
