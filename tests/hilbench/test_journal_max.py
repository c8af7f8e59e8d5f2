"""`--journal-max`: a journal that gets no larger, and of which each part can be read."""

from __future__ import annotations

import pytest

from hilbench import arguments
from hilbench.cli import main
from hilbench.journal import Journal


@pytest.mark.parametrize(
    ("text", "size"), [("100kB", 100_000), ("50MB", 50_000_000), ("1.5GB", 1_500_000_000), ("0.1MB", 100_000)]
)
def test_sizes(text, size):
    assert arguments.journal_bytes(text) == size


@pytest.mark.parametrize("text", ["", "50", "50M", "99kB", "-5MB", "0MB", "50 MB", "five MB"])
def test_what_is_no_size_says_so(text):
    with pytest.raises(ValueError, match=r"is not a size|is less than"):
        arguments.journal_bytes(text)


def test_a_run_stays_within_it_and_its_parts_follow_each_other(tmp_path, capfd):
    path = tmp_path / "run.jsonl"
    assert main(["run", "bluepill", "--for", "25s", "--journal", str(path), "--journal-max", "100kB"]) == 0
    before = path.with_name("run.jsonl.1")
    assert path.stat().st_size + before.stat().st_size < 110_000
    first, last = Journal.read(before), Journal.read(path)
    assert (first.problem, last.problem, last.ended) == (None, None, True)
    assert first.header["part"] + 1 == last.header["part"] >= 2
    assert first.events[-1]["ns"] <= last.events[0]["ns"]


@pytest.mark.parametrize("words", [("check", "pioneer"), ("run", "bluepill"), ("serve", "pioneer", "--pty", "./p")])
def test_without_a_journal_there_is_nothing_to_limit(words, capfd):
    assert main([*words, "--journal-max", "50MB"]) == 2
    assert capfd.readouterr().err == "hilbench: --journal-max: there is no journal to limit; give --journal FILE, too\n"
