"""`hilbench export`, as a person meets it."""

from __future__ import annotations

import io
import json
import os
import subprocess
import sys
import threading

import pytest

from hilbench.cli import main
from hilbench.journal import Journal
from hilbench.recordings.reading import read_recording
from hilbench.recordings.vcd_file import summarised


@pytest.fixture
def journal(tmp_path):
    path = tmp_path / "run.jsonl"
    log = Journal(path, {"bench": "test"})
    for case in ("a/one", "a/two"):
        log.begin_case(case)
        log.record("tx", "checker", 1000, data=bytes.fromhex("fafb03000000"))
        log.record("pin", "brain.PB7", 1500, level=True)
        log.end_case(2000)
    log.close()
    return path


@pytest.fixture
def export(capfd):
    def run(*words):
        code = main(["export", *map(str, words)])
        return code, *capfd.readouterr()

    return run


def test_every_format_at_once(export, journal, tmp_path):
    files = {name: tmp_path / f"it.{name}" for name in ("mcap", "pcapng", "vcd", "csv")}
    code, out, _ = export(journal, *[word for name, path in files.items() for word in (f"--{name}", path)])
    assert code == 0
    assert out.count("wrote ") == 4
    assert "without pin" in out
    assert "frames of p2os" in out
    for name in ("mcap", "csv"):
        assert read_recording(files[name]).events == Journal.read(journal).events


def test_one_case(export, journal, tmp_path):
    code, _, _ = export(journal, "--csv", tmp_path / "c.csv", "--case", "a/two")
    assert code == 0
    found = read_recording(tmp_path / "c.csv").events
    assert [event["kind"] for event in found] == ["case", "tx", "pin", "case-end"]


def test_what_was_exported_can_be_exported(export, journal, tmp_path):
    export(journal, "--mcap", tmp_path / "a.mcap")
    code, out, _ = export(tmp_path / "a.mcap", "--csv", tmp_path / "b.csv", "--json")
    assert code == 0
    assert json.loads(out)["files"][0]["events"] == len(Journal.read(journal).events)


def test_a_journal_that_was_cut_is_written_up_to_there(export, journal, tmp_path):
    journal.write_bytes(journal.read_bytes()[:-20])
    code, _, err = export(journal, "--csv", tmp_path / "b.csv")
    assert code == 0
    assert "cut in line" in err


def piped(*words):
    """Run `hilbench export`, with a pipe for its output; return what came, and what was said."""
    command = [sys.executable, "-m", "hilbench", "export", *map(str, words)]
    ran = subprocess.run(command, capture_output=True, check=True, timeout=120)
    return ran.stdout, ran.stderr.decode()


def test_a_pipe_takes_mcap_and_nothing_else(journal, tmp_path):
    from mcap.reader import make_reader

    out, said = piped(journal, "--mcap", "/dev/stdout")
    reader = make_reader(io.BytesIO(out), validate_crcs=True)
    topics = [channel.topic for _, channel, _ in reader.iter_messages()]
    assert len(topics) == reader.get_summary().statistics.message_count
    assert topics.count("/checker/tx") == topics.count("/brain/PB7/pin") == 2
    assert said.startswith("wrote /dev/stdout: ")
    (tmp_path / "it.mcap").write_bytes(out)
    assert read_recording(tmp_path / "it.mcap").events == Journal.read(journal).events


def test_a_pipe_gets_the_bytes_of_a_file(export, journal, tmp_path):
    pipe, taken = tmp_path / "pipe", []
    os.mkfifo(pipe)
    reader = threading.Thread(target=lambda: taken.append(pipe.read_bytes()))
    reader.start()
    assert export(journal, "--mcap", pipe)[0] == 0
    reader.join()
    assert export(journal, "--mcap", tmp_path / "it.mcap")[0] == 0
    assert taken == [(tmp_path / "it.mcap").read_bytes()]


def test_the_standard_output_is_no_place_for_two(journal):
    with pytest.raises(subprocess.CalledProcessError) as caught:
        piped(journal, "--csv", "/dev/stdout", "--json")
    assert caught.value.returncode == 2
    assert b"--json: --csv is written to the standard output; name a file" in caught.value.stderr
    assert caught.value.stdout == b""


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        ((), 2, "says no format"),
        (("--csv", "{folder}/run.jsonl"), 2, "would overwrite the recording"),
        (("--csv", "{folder}/no/c.csv"), 2, "there is no folder"),
        (("--csv", "{folder}/c.csv", "--case", "a/three"), 2, "has no case 'a/three'"),
        (("--csv", "{folder}/c.csv", "--mcap", "{folder}/c.csv"), 2, "would overwrite"),
        (("--csv", "/dev/full"), 3, "/dev/full: cannot be written"),
        (("--mcap", "/dev/full"), 3, "/dev/full: cannot be written"),
        (("--pcapng", "/dev/full"), 3, "/dev/full: cannot be written"),
        (("--vcd", "/dev/full"), 3, "/dev/full"),
    ],
)
def test_wrong_usage(export, journal, tmp_path, words, code, said):
    found, out, err = export(journal, *[word.format(folder=tmp_path) for word in words])
    assert (found, out) == (code, "")
    assert said in err
    assert len(err.splitlines()) == 1


def test_no_pins(export, tmp_path):
    path = tmp_path / "run.jsonl"
    Journal(path).close()
    code, _, err = export(path, "--vcd", tmp_path / "x.vcd")
    assert code == 2
    assert "has no edges of pins" in err
    assert not (tmp_path / "x.vcd").exists()


def test_no_such_file(export, tmp_path):
    code, _, err = export(tmp_path / "no.jsonl", "--csv", tmp_path / "x.csv")
    assert code == 3
    assert "No such file" in err


def test_pins_of_which_a_journal_has_no_edges_are_named(recording_of):
    events = [
        {"ns": 1, "kind": "pwm", "source": "brain.PA8", "edges": 40, "in_ns": 10**8},
        {"ns": 2, "kind": "frames", "source": "brain", "pin": "PA9"},
        {"ns": 3, "kind": "pin", "source": "brain.PB7", "level": True},
    ]
    assert summarised(recording_of(events)) == ["brain.PA8", "brain.PA9"]
