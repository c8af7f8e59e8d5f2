"""Recordings by hand: what they say is plain to see in the test."""

from __future__ import annotations

import json

import pytest

from hilbench.cli import main
from hilbench.journal import Journal

MS = 1_000_000


@pytest.fixture
def write(tmp_path):
    """Write a file; return its path as text."""

    def written(name, text):
        (tmp_path / name).write_text(text)
        return str(tmp_path / name)

    return written


@pytest.fixture
def journal(tmp_path):
    """Write a journal of one board from (ms, kind, source, fields); return its path as text."""

    def written(name, events, *, end_ms=100, board="brain"):
        path = tmp_path / name
        log = Journal(path, {"bench": "test", "images": {board: {}}})
        for at_ms, kind, source, fields in events:
            log.record(kind, source, round(at_ms * MS), **fields)
        log.close(end_ms * MS)
        return str(path)

    return written


@pytest.fixture
def pins(journal):
    """Write a journal of pins from (ms, pin, level)."""

    def written(name, edges, **options):
        events = [(at_ms, "pin", f"brain.{pin}", {"level": level}) for at_ms, pin, level in edges]
        return journal(name, events, **options)

    return written


@pytest.fixture
def diff(capfd):
    """Run `hilbench diff`; return exit code, standard output, standard error."""

    def run(*words):
        code = main(["diff", *words])
        out, err = capfd.readouterr()
        return code, out, err

    return run


@pytest.fixture
def data(diff):
    """Run `hilbench diff --json`; return what it says."""

    def run(*words):
        code, out, err = diff(*words, "--json")
        assert err == ""
        found = json.loads(out)
        assert code == (0 if found["equal"] else 1)
        return found

    return run
