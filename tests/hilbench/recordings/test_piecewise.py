from __future__ import annotations

import json

import pytest

from hilbench.errors import UnavailableError
from hilbench.recordings import piecewise
from hilbench.recordings.piecewise import JournalPieces, open_pieces
from hilbench.recordings.reading import read_recording

_HEADER = b'{"kind":"journal","part":0}\n'


def _event(ns, **more):
    return json.dumps({"ns": ns, "kind": "tx", "source": "checker", "data": "55", **more}).encode() + b"\n"


def _all(pieces):
    found = []
    while events := pieces.read():
        found += events
    return found


@pytest.fixture(autouse=True)
def _small_pieces(monkeypatch):
    monkeypatch.setattr(piecewise, "_READ_BYTES", 100)


_FILES = {
    "whole": _HEADER + b"".join(map(_event, range(20))),
    "a long line": _HEADER + _event(1) + _event(2, text="x" * 1000) + _event(3),
    "cut": _HEADER + b"".join(map(_event, range(9))) + b'{"ns":',
    "no event": _HEADER + _event(1) + b"[]\n" + _event(2),
    "damaged": _HEADER + _event(1) + _event(2) + _event(-3) + _event(4),
    "of nothing": _HEADER,
    "empty": b"",
    "a cut header": _HEADER[:-4],
}


@pytest.mark.parametrize("data", _FILES.values(), ids=_FILES)
def test_a_journal_is_read_as_it_is_read_at_once(tmp_path, data):
    path = tmp_path / "journal.jsonl"
    path.write_bytes(data)
    pieces, wanted = open_pieces(path), read_recording(path)
    assert (pieces.header, _all(pieces), pieces.problem) == (wanted.header, list(wanted.events), wanted.problem)
    assert pieces.share == 1 or pieces.problem or not wanted.events


@pytest.mark.parametrize("name", ["whole", "a long line", "cut", "damaged"])
def test_what_was_read_is_found_again(tmp_path, name):
    path = tmp_path / "journal.jsonl"
    path.write_bytes(_FILES[name])
    pieces = open_pieces(path)
    assert isinstance(pieces, JournalPieces)
    events = _all(pieces)
    for begin in range(len(events) + 1):
        for end in range(len(events) + 1):
            assert list(pieces.between(begin, end)) == events[begin:end]


def test_what_is_no_recording_is_said_as_ever(tmp_path):
    (tmp_path / "notes.txt").write_text("notes\n")
    (tmp_path / "header.jsonl").write_bytes(b'{"kind":"journal"\n' + _event(1))
    for path in (tmp_path / "notes.txt", tmp_path / "header.jsonl", tmp_path, tmp_path / "none.jsonl"):
        with pytest.raises(UnavailableError):
            open_pieces(path)
