"""A recording that is not all there: every command that reads one says so, once, and goes on with what there is."""

from __future__ import annotations

import pytest

from hilbench.cli import main
from hilbench.journal import Journal

pytestmark = pytest.mark.usefixtures("keep_signals")


@pytest.fixture(scope="module")
def session(tmp_path_factory):
    """The journal of a case, in which a host speaks to a robot."""
    path = tmp_path_factory.mktemp("session") / "session.jsonl"
    assert main(["check", "pioneer-plane", "--suite", "p2os-server", "-k", "S01", "--journal", str(path)]) == 0
    return path


def test_one_that_was_cut_is_played_up_to_there(session, tmp_path, capfd):
    path = tmp_path / "cut.jsonl"
    path.write_bytes(session.read_bytes()[:-10])
    lines = path.read_bytes().count(b"\n") + 1
    capfd.readouterr()
    assert main(["replay", str(path), "--into", "pioneer-plane"]) == 0
    said = f"{path}: cut in line {lines}: played up to there\nthe target has answered the same\n"
    assert capfd.readouterr().err == said


@pytest.mark.parametrize("words", [("--events",), ()])
def test_a_later_part_is_compared_as_one(tmp_path, capfd, words):
    path = tmp_path / "run.jsonl"
    journal = Journal(path, {"part": 3, "images": {"brain": {}}})
    for index in range(10):
        journal.record("pin", "brain.PB7", index * 1000, level=bool(index % 2))
    journal.close(10**6)
    assert main(["diff", str(path), str(path), *words]) == 0
    assert capfd.readouterr().out.count("its beginning is in an older file") == 2
