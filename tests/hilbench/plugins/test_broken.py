"""What plug-ins get wrong is theirs: a line that names it, and nothing of others in its way."""

from __future__ import annotations

import json

import pytest

from hilbench.tui.model.frames import FramesModel
from tests.hilbench.plugins.conftest import TINY
from tests.share import few

RECORD = "api=1,"
DEVICE = """
from hilbench.plugins.protocol import Device


class Node:
    def __init__(self, settings):
        pass

    def receive(self, data, now_ns):
        return data

    def advance(self, now_ns):
        return b""

    def next_deadline_ns(self):
        return None

    def line_down(self, now_ns):
        return b""

    def take_events(self):
        return []
"""
SUITE = """
from hilbench.check import case


@case("TINY1")
def test_ends(peer):
    peer.write(b"x\\n")
    peer.run(0.1)
    assert peer.received
"""


def with_device(source=DEVICE, record="device=Device(make=Node), suites=()"):
    return TINY.replace("\n\n\nTINY = Proto", f"\n\n{source}\n\nTINY = Proto").replace(RECORD, f"{RECORD} {record},")


@pytest.fixture
def bench(tiny, tmp_path):
    """Return a bench with the device of the file, and a suite."""
    tmp_path.joinpath("suite.py").write_text(SUITE)
    path = tmp_path / "bench.toml"
    path.write_text('version = 1\nplugins = ["tiny.py"]\nsuites = ["suite.py"]\n[targets.one]\nmodel = "tiny"\n')
    return path


def test_the_device_of_these_tests_passes(hilbench, tiny, bench):
    tiny.write_text(with_device())
    code, out, err = hilbench("check", bench)
    assert code == 0, out + err


# --- records


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("decoder=Lines", "decoder=None", "decoder cannot be called"),
        ("decoder=Lines", "decoder=Lines, device=Lines", "device is no Device"),
        ("decoder=Lines", "decoder=Lines, baud='fast'", "baud is no whole number from 300 on"),
        ("decoder=Lines", "decoder=Lines, suites='suite.py'", "suites is no tuple of paths"),
        ("decoder=Lines", "decoder=Lines, regions=3", "regions cannot be called"),
        ("decoder=Lines", "decoder=Lines, encode=3", "encode cannot be called"),
        ('name="tiny"', 'name="Tiny one"', "name 'Tiny one' is no name"),
        ('name="tiny"', "name=5", "name 5 is no name"),
        ('title="Tiny"', 'title=""', "title is empty"),
        ('title="Tiny"', 'title="PKT!"', "has the title 'PKT!', and so has 'pkt'; give it one of its own"),
        ("most: int", "most: tuple", "options: 'most' can be no flag: it is none of bool, int, float, str, Path"),
        ("most: int", "most: 'Nosuch'", "options: cannot be made without values: NameError"),
        ("default=80, ", "kw_only=True, ", "options: cannot be made without values: TypeError"),
        ("options=Options", "options=5", "options: no dataclass"),
    ],
)
def test_a_record_is_looked_at_when_it_is_taken(hilbench, tiny, old, new, said):
    assert old in TINY
    tiny.write_text(TINY.replace(old, new))
    code, out, err = hilbench("protocols", "--plugin", tiny)
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert err.startswith(f"hilbench: {tiny}: {said}"), err


def test_a_suite_that_is_not_there_is_named_with_its_plug_in(hilbench, tiny):
    tiny.write_text(TINY.replace(RECORD, f"{RECORD} suites=(__import__('pathlib').Path('/nowhere/suite.py'),),"))
    code, _, err = hilbench("protocols", "--plugin", tiny)
    assert code == 2
    assert err == f"hilbench: {tiny}: its suite '/nowhere/suite.py' is not there\n"


@pytest.mark.parametrize(
    "junk", few(["[SimpleNamespace(id=5)]", "[1]", "None", "3"], 2, "the gate has two kinds of junk")
)
def test_clauses_that_are_none_leave_out_the_plug_in_and_nothing_else(hilbench, package, junk):
    source = TINY.replace("def clauses():", f"def clauses():\n    return {junk}\n\n\ndef other():")
    package("stranger", source, {"tiny": "stranger:TINY"})
    code, out, err = hilbench("check", "rover-model", "-k", "P01")
    assert code == 0, out + err
    assert "protocol 'tiny' of the package stranger: " in err
    assert "it is left out" in err
    code, out, err = hilbench("protocols", "tiny")
    assert (code, out) == (2, "")


def test_a_clause_id_that_is_taken_refuses_a_bench_of_that_protocol(hilbench, tiny, bench):
    tiny.write_text(with_device().replace('"TINY1"', '"P01"'))
    code, _, err = hilbench("check", bench)
    assert code == 2
    assert f"protocol 'tiny' of {tiny}: has a clause 'P01', and so has another catalogue" in err


# --- flags


@pytest.mark.parametrize("field", ["json", "input", "stream", "plugin", "help"])
def test_a_flag_that_the_command_has_is_refused(hilbench, tiny, tmp_path, field):
    tiny.write_text(TINY.replace("most: int", f"{field}: int").replace("self.options.most", "80"))
    code, out, err = hilbench("decode", "tiny", tmp_path / "x", "--plugin", tiny)
    assert (code, out) == (2, "")
    assert err == f"hilbench: protocol 'tiny': has the flag --{field}, and so has hilbench decode\n"


def test_options_are_no_arguments_of_the_command(hilbench, tiny, tmp_path):
    tiny.write_text(TINY.replace("most: int", "file: int").replace("self.options.most", "self.options.file"))
    line = tmp_path / "line.bin"
    line.write_bytes(b"first\n")
    assert hilbench("decode", "tiny", line, "--file", "2", "--plugin", tiny)[1].split()[-1] == "fi"
    assert hilbench("decode", "tiny", line, "--plugin", tiny)[1].split()[-1] == "first"


def test_what_is_on_is_switched_off(hilbench, tiny, tmp_path):
    tiny.write_text(TINY.replace("default=False", "default=True"))
    line = tmp_path / "line.bin"
    line.write_bytes(b"first\n")
    assert hilbench("decode", "tiny", line, "--plugin", tiny)[1].split()[-1] == "FIRST"
    assert hilbench("decode", "tiny", line, "--no-loud", "--plugin", tiny)[1].split()[-1] == "first"


@pytest.mark.parametrize("command", ["decode", "export", "proxy"])
def test_a_command_without_words_says_what_is_missing(hilbench, command):
    code, out, err = hilbench(command)
    assert (code, out) == (2, "")
    assert err.count("\n") == 1


# --- files


def test_a_plug_in_is_not_overwritten(hilbench, tiny, bench, tmp_path):
    tiny.write_text(with_device())
    before = tiny.read_text()
    code, _, err = hilbench("check", bench, "--json", tiny)
    assert code == 2
    assert "would overwrite the plug-in" in err
    journal = tmp_path / "run.jsonl"
    assert hilbench("check", bench, "--journal", journal)[0] == 0
    for words in (("export", journal, "--mcap", tiny), ("check", "--target", f"capture:{journal}", "--json", tiny)):
        assert hilbench(*words, "--plugin", tiny)[0] == 2
    assert tiny.read_text() == before


def test_a_record_that_another_file_imports_is_brought_once(plugins, tiny, tmp_path):
    other = tmp_path / "other.py"
    other.write_text("from tiny import TINY\n\n" + TINY.replace("TINY = ", "OTHER = ").replace('"tiny"', '"other"')
                     .replace('"Tiny"', '"Other"'))  # fmt: skip
    plugins.add_file(tiny, "--plugin")
    plugins.add_file(other, "--plugin")
    assert plugins.names()[-2:] == ["other", "tiny"]


# --- code that runs


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("        return data\n", "        return 'text'\n", "device 'device': returned str, not bytes"),
        ("        return data\n", "        return 1 / 0\n", "tiny.py:{line}: ZeroDivisionError: division by zero"),
        (
            "        return None\n",
            "        return 0\n",
            "device 'device': is due at 0 ns for ever: advance() does not move next_deadline_ns()",
        ),
    ],
)
def test_a_device_that_fails_is_an_error_of_its_own(hilbench, tiny, bench, tmp_path, old, new, said):
    tiny.write_text(with_device(DEVICE.replace(old, new)))
    lines = tiny.read_text().splitlines()
    number = 1 + lines.index(new.rstrip("\n")) if new.rstrip("\n") in lines else 0
    report = tmp_path / "report.json"
    code, out, err = hilbench("check", bench, "--json", report)
    assert code == 2, out + err
    (case,) = json.loads(report.read_text())["cases"]
    assert case["cause"] == said.format(line=number)
    assert (case["suite_error"], case["defect"]) == (True, False)


def test_frames_that_cannot_be_read_are_shown_with_the_reason(plugins, tiny):
    tiny.write_text(TINY.replace('text = found[:-1].decode("ascii", "replace")', "text = (1 / 0)"))
    plugins.add_file(tiny, "--plugin")
    model = FramesModel({"operator": "client", "protocol": "tiny"})
    model.take({"kind": "tx", "source": "client", "ns": 5, "data": b"one\n".hex()})
    assert "its decoder fails: tiny.py:" in model.frames[0].text
    assert "ZeroDivisionError" in model.frames[0].text


@pytest.mark.parametrize("broken", ["def find(self, data):", "def __init__(self, options, speaker):"])
def test_bytes_that_a_decoder_fails_on_are_shown(plugins, tiny, broken):
    tiny.write_text(TINY.replace(broken, f"{broken}\n        raise OSError('gone')"))
    plugins.add_file(tiny, "--plugin")
    model = FramesModel({"operator": "client", "protocol": "tiny"})
    model.take({"kind": "rx", "source": "client", "ns": 5, "data": b"one\n".hex()})
    assert model.frames[0].item.raw == b"one\n"
    assert "its decoder fails: tiny.py:" in model.frames[0].text


def test_regions_that_fail_are_the_whole_frame(plugins, tiny):
    tiny.write_text(TINY.replace(RECORD, f"{RECORD} regions=lambda raw, options, sent: 1 / 0,"))
    plugins.add_file(tiny, "--plugin")
    model = FramesModel({"operator": "client", "protocol": "tiny"})
    model.take({"kind": "rx", "source": "client", "ns": 5, "data": b"one\n".hex()})
    (region,) = model.frames[0].regions
    assert region.data == b"one\n"
    assert "its regions fails" in region.name


def test_a_recording_of_a_protocol_that_is_not_there_says_so(plugins):
    model = FramesModel({"operator": "client", "protocol": "nosuch"})
    model.take({"kind": "rx", "source": "client", "ns": 5, "data": b"one".hex()})
    assert "no protocol 'nosuch' is known here; --plugin FILE brings one of a file" in model.frames[0].text
    assert [region.data for region in model.frames[0].regions] == [b"one"]
    assert FramesModel({}).take({"kind": "rx", "source": "client", "ns": 5, "data": "00"}) == []


def test_a_decoder_that_loses_bytes_is_told_of(hilbench, tiny, tmp_path):
    tiny.write_text(TINY.replace("raw=found)\n\n    def feed", "raw=found[:1])\n\n    def feed"))
    line = tmp_path / "line.bin"
    line.write_bytes(b"one\ntwo\n")
    code, _, err = hilbench("decode", "tiny", line, "--plugin", tiny)
    assert code == 2
    assert "protocol 'tiny': its decoder makes 2 bytes of 8: each byte belongs into one item" in err


def test_a_suite_that_waits_for_no_class_has_an_error_of_its_own(hilbench, tiny, bench, tmp_path):
    tiny.write_text(with_device())
    tmp_path.joinpath("suite.py").write_text(SUITE.replace("peer.run(0.1)", 'peer.expect("Answer", 0.1)'))
    code, out, _ = hilbench("check", bench)
    assert code == 2
    assert "suite.py:8: TypeError: 'Answer' is no class of messages" in out


def test_an_export_whose_frames_cannot_be_read_leaves_no_file(hilbench, tiny, bench, tmp_path):
    tiny.write_text(with_device())
    journal, capture = tmp_path / "run.jsonl", tmp_path / "run.mcap"
    assert hilbench("check", bench, "--journal", journal)[0] == 0
    other = tmp_path / "other.py"
    source = TINY.replace('"tiny"', '"other"').replace('"Tiny"', '"Other"').replace("TINY1", "OTHER1")
    other.write_text(source.replace('text = found[:-1].decode("ascii", "replace")', "text = (1 / 0)"))
    code, _, err = hilbench("export", journal, "--mcap", capture, "--protocol", "other", "--plugin", other)
    assert code == 2
    assert "other.py:" in err
    assert not capture.exists()
