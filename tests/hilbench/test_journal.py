from __future__ import annotations

import enum
import gc
import math
import os
import signal
import subprocess
import sys
from dataclasses import dataclass

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hilbench.errors import InternalError, UnavailableError, UsageError
from hilbench.journal import Journal, metres, radians
from hilbench.journal.run_hash import run_hash
from tests.each import each


class Colour(enum.Enum):
    RED = 1


@dataclass(frozen=True, slots=True, kw_only=True)
class Happened:
    kind: str
    colour: Colour
    data: bytes


def hash_of(*events, start_ns=0):
    journal = Journal()
    journal.begin_case("c", at_ns=start_ns)
    for kind, source, at_ns, fields in events:
        journal.record(kind, source, at_ns, **fields)
    return journal.end_case()


def write_journal(path, count=20):
    journal = Journal(path, {"seed": 7})
    for index in range(count):
        journal.record("tx", "robot", index * 10, data=bytes([index]), text="é" * index)
        journal.flush_step()
    journal.close()


def test_round_trip(tmp_path):
    path = tmp_path / "j.jsonl"
    journal = Journal(path, {"seed": 7, "digest": b"\x01\xff"})
    journal.record("rx", "robot.host", 5, data=b"\xfa\xfb", ok=True, where=(1, 2.5), colours={Colour.RED})
    journal.record_value("event", "robot", 6, Happened(kind="k", colour=Colour.RED, data=b"\x10"))
    journal.close(at_ns=9)
    journal.close()
    recording = Journal.read(path)
    assert recording.problem is None
    assert recording.ended
    assert recording.header["seed"] == 7
    assert recording.header["digest"] == "01ff"
    assert recording.header["format"] == 1
    assert recording.events[0] == {
        "ns": 5, "kind": "rx", "source": "robot.host", "data": "fafb", "ok": True, "where": [1, 2.5], "colours": ["RED"]
    }  # fmt: skip
    assert recording.events[1]["name"] == "Happened"
    assert recording.events[1]["value"] == {"kind": "k", "colour": "RED", "data": "10"}
    assert list(journal.recent) == list(recording.events[:2])


def test_cut_at_any_byte_is_readable_up_to_the_cut(tmp_path):
    path = tmp_path / "j.jsonl"
    write_journal(path, 8)
    whole = path.read_bytes()
    events = Journal.read(path).events
    header_bytes = whole.index(b"\n") + 1
    for size in range(len(whole)):
        path.write_bytes(whole[:size])
        recording = Journal.read(path)
        complete = whole[header_bytes:size].count(b"\n")
        assert recording.events == events[:complete]
        assert bool(recording.header) == (size >= header_bytes)
        at_line_end = size > 0 and whole[size - 1 : size] == b"\n"
        assert (recording.problem is None) == at_line_end
        assert not recording.ended


def test_a_damaged_line_ends_the_reading_and_is_named(tmp_path):
    path = tmp_path / "j.jsonl"
    write_journal(path, 3)
    lines = path.read_bytes().split(b"\n")
    lines[2] = b"\xff\x00"
    path.write_bytes(b"\n".join(lines))
    recording = Journal.read(path)
    assert len(recording.events) == 1
    assert recording.problem == "line 3 cannot be read"


def test_readable_after_sigkill(tmp_path):
    path = tmp_path / "j.jsonl"
    program = (
        "import sys; from hilbench.journal import Journal\n"
        "j = Journal(sys.argv[1]); j.record('tx', 'a', 1, n=1); j.flush_step(); j.record('tx', 'a', 2, n=2)\n"
        "print('ready', flush=True); sys.stdin.read()\n"
    )
    with subprocess.Popen(
        [sys.executable, "-c", program, str(path)], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    ) as process:
        assert process.stdout.readline() == b"ready\n"
        process.send_signal(signal.SIGKILL)
    recording = Journal.read(path)
    assert [event["n"] for event in recording.events] == [1]
    assert recording.problem is None
    assert not recording.ended


def test_one_write_per_step(tmp_path, monkeypatch):
    journal = Journal(tmp_path / "j.jsonl")
    writes = []
    real = os.write
    monkeypatch.setattr(os, "write", lambda fd, data: writes.append(len(data)) or real(fd, data))
    for index in range(50):
        journal.record("tx", "a", index)
    assert writes == []
    journal.flush_step()
    assert len(writes) == 1
    journal.flush_step()
    assert len(writes) == 1
    journal.close()


def test_a_step_of_any_size_does_not_pile_up(tmp_path):
    path = tmp_path / "j.jsonl"
    journal = Journal(path)
    for index in range(40):
        journal.record("tx", "a", index, data=bytes(10_000))
    assert path.stat().st_size > 300_000
    journal.close()
    assert len(Journal.read(path).events) == 41


def test_rotation_bounds_the_size(tmp_path):
    path = tmp_path / "j.jsonl"
    journal = Journal(path, max_bytes=20_000)
    for index in range(1000):
        journal.record("tx", "a", index, n=index)
        journal.flush_step()
    journal.close()
    assert sum(file.stat().st_size for file in tmp_path.iterdir()) < 20_500
    older, newer = Journal.read(tmp_path / "j.jsonl.1"), Journal.read(path)
    numbers = [event["n"] for event in (*older.events, *newer.events) if "n" in event]
    assert numbers == list(range(numbers[0], 1000))
    assert newer.header["part"] == older.header["part"] + 1


def test_memory_only_keeps_the_latest():
    journal = Journal(keep=3)
    for index in range(10):
        journal.record("tx", "a", index)
    journal.flush_step()
    journal.close()
    assert [event["ns"] for event in journal.recent] == [7, 8, 9]


def test_an_older_journal_is_overwritten_and_anything_else_refused(tmp_path):
    path = tmp_path / "j.jsonl"
    write_journal(path, 50)
    write_journal(path, 2)
    assert len(Journal.read(path).events) == 3
    path.write_text("precious")
    with pytest.raises(UsageError, match="will not be overwritten"):
        Journal(path)
    assert path.read_text() == "precious"
    with pytest.raises(UsageError, match="not a hilbench journal"):
        path.write_text("precious\n")
        Journal.read(path)
    with pytest.raises(UnavailableError, match="cannot be written"):
        Journal(tmp_path / "missing" / "j")
    with pytest.raises(UnavailableError, match="cannot be read"):
        Journal.read(tmp_path / "missing")


def test_one_program_writes_it_at_a_time(tmp_path):
    path = tmp_path / "j.jsonl"
    first = Journal(path)
    first.record("tx", "a", 1)
    first.flush_step()
    with pytest.raises(UnavailableError, match=r"j\.jsonl: is being written by another program"):
        Journal(path)
    first.close()
    assert len(Journal.read(path).events) == 2
    Journal(path).close()


def test_a_part_before_that_somebody_writes_is_left_alone(tmp_path):
    theirs = Journal(tmp_path / "j.jsonl.1")
    with pytest.raises(UnavailableError, match=r"j\.jsonl\.1: is being written by another program"):
        Journal(tmp_path / "j.jsonl", max_bytes=1000)
    theirs.close()
    Journal(tmp_path / "j.jsonl", max_bytes=1000).close()


def test_a_journal_that_is_forgotten_is_free_again(tmp_path):
    Journal(tmp_path / "j.jsonl")
    gc.collect()
    Journal(tmp_path / "j.jsonl").close()


def test_where_files_have_no_locks_it_is_written_without(tmp_path, monkeypatch):
    def no_locks(*_words):
        raise OSError(37, "No locks available")

    monkeypatch.setattr("fcntl.flock", no_locks)
    Journal(tmp_path / "j.jsonl").close()
    assert Journal.read(tmp_path / "j.jsonl").ended


def test_full_disk_is_one_line():
    with pytest.raises(UnavailableError, match="No space left") as caught:
        Journal("/dev/full")
    assert "\n" not in str(caught.value)


BASE = ("tx", "robot", 100, {"data": b"\x01", "x": 1.5})


@given(
    path=st.text(),
    pid=st.integers(0, 2**31),
    text=st.text(max_size=20),
    lateness=st.floats(),
    kind=st.just("host-load"),
)
@settings(deadline=None)
def test_hash_is_unaffected_by_what_belongs_to_the_host(path, pid, text, lateness, kind):
    other = ("tx", "robot", 100, {**BASE[3], "host_path": path, "host_pid": pid, "text": text, "cause": text})
    noise = (kind, "host", 7, {"lateness": lateness})
    assert hash_of(BASE) == hash_of(noise, other, noise)


@each(
    "other",
    [
        ("rx", "robot", 100, {"data": b"\x01", "x": 1.5}),
        ("tx", "other", 100, {"data": b"\x01", "x": 1.5}),
        ("tx", "robot", 101, {"data": b"\x01", "x": 1.5}),
        ("tx", "robot", 100, {"data": b"\x02", "x": 1.5}),
        ("tx", "robot", 100, {"data": b"\x01", "x": 1.500001}),
        ("tx", "robot", 100, {"data": b"\x01", "x": 1.5, "more": 1}),
    ],
)
def test_hash_depends_on_everything_else(other):
    assert hash_of(BASE) != hash_of(other)
    assert hash_of(BASE, other) != hash_of(other, BASE)


def test_hash_quantises_floats_and_ignores_field_order_and_start():
    assert hash_of(BASE) == hash_of(("tx", "robot", 100, {"x": 1.5000001, "data": b"\x01"}))
    assert hash_of(BASE) == hash_of(("tx", "robot", 1100, BASE[3]), start_ns=1000)
    assert hash_of(("w", "a", 0, {"x": -0.0, "y": [math.nan]})) == hash_of(("w", "a", 0, {"x": 0.0, "y": [math.nan]}))


def test_cases_do_not_depend_on_their_order():
    journal = Journal()
    hashes = {}
    for case_id, value in (("b", 2), ("a", 1)):
        journal.record("tx", "between", 0)
        journal.begin_case(case_id)
        journal.record("tx", "x", value)
        hashes[case_id] = journal.end_case()
    assert hashes["a"] == hash_of(("tx", "x", 1, {}))
    assert run_hash(hashes) == run_hash(dict(sorted(hashes.items())))
    assert run_hash(hashes) != run_hash({"a": hashes["b"], "b": hashes["a"]})


def test_cases_do_not_nest():
    journal = Journal()
    with pytest.raises(InternalError):
        journal.end_case()
    journal.begin_case("a")
    with pytest.raises(InternalError, match="inside"):
        journal.begin_case("b")


def test_quantisers():
    assert metres(1.2345678) == 1_234_568
    assert radians(-math.pi) == -3_141_593
    assert metres(-0.0) == 0
    for bad in (math.nan, math.inf):
        with pytest.raises(ValueError):
            metres(bad)
