"""`--journal-max`: a journal that gets no larger, and of which each part can be read."""

from __future__ import annotations

import os

import pytest

from hilbench.cli import main
from hilbench.errors import UnavailableError, UsageError
from hilbench.journal import Journal
from hilbench.terminal import arguments
from targets.firmware import image_path
from tests.each import each

LIMIT = 4000


def fill(journal, count=100):
    for index in range(count):
        journal.record("tx", "a", index, n=index)
        journal.flush_step()


def numbers(*paths):
    return [event["n"] for path in paths for event in Journal.read(path).events if "n" in event]


@each(("text", "size"), [("100kB", 100_000), ("50MB", 50_000_000), ("1.5GB", 1_500_000_000), ("0.1MB", 100_000)])
def test_sizes(text, size):
    assert arguments.journal_bytes(text) == size


@each("text", ["", "50", "50M", "99kB", "-5MB", "0MB", "50 MB", "five MB"])
def test_what_is_no_size_says_so(text):
    with pytest.raises(ValueError, match=r"is not a size|is less than"):
        arguments.journal_bytes(text)


def case_lines(journal, name, scene=True):
    journal.begin_case(name)
    if scene:
        journal.record("scene", "world", 0, walls=[1, 2, 3])
    for index in range(60):
        journal.record("tx", "a", index, n=index)
    journal.end_case(60)


def test_cases_of_another_journal_are_added_as_they_are(tmp_path):
    one, other, both = (Journal(tmp_path / f"{name}.jsonl") for name in ("one", "other", "both"))
    for journal in (one, both):
        case_lines(journal, "a")
    begin = (tmp_path / "other.jsonl").stat().st_size
    for journal in (other, both):
        case_lines(journal, "b")
    one.append((tmp_path / "other.jsonl").read_bytes()[begin:])
    for journal in (one, other, both):
        journal.close()
    assert (tmp_path / "one.jsonl").read_bytes() == (tmp_path / "both.jsonl").read_bytes()


def test_cases_that_are_added_stay_within_it_and_each_part_says_what_stands_there(tmp_path):
    source, limited = Journal(tmp_path / "source.jsonl"), Journal(tmp_path / "x.jsonl", max_bytes=LIMIT)
    begin = (tmp_path / "source.jsonl").stat().st_size
    case_lines(source, "a")
    source.close()
    limited.append((tmp_path / "source.jsonl").read_bytes()[begin:].rsplit(b"{", 1)[0])
    limited.append(b'{"ns":0,"kind":"tx","source":"a","n":99}\n')
    limited.close()
    last = Journal.read(tmp_path / "x.jsonl")
    assert [event["kind"] for event in last.events] == ["scene", "tx", "host-end"]
    limited_without = Journal(tmp_path / "y.jsonl", max_bytes=LIMIT)
    limited_without.append(b'{"ns":0,"kind":"case","source":"journal","case":"scene"}\n' * 80)
    limited_without.close()
    assert [event["kind"] for event in Journal.read(tmp_path / "y.jsonl").events] == ["host-end"]


def test_a_run_stays_within_it_and_its_parts_follow_each_other(tmp_path, capfd):
    path = tmp_path / "run.jsonl"
    assert (
        main(
            [
                "run",
                f"bluepill:{image_path('style-hal')}",
                "--for",
                "6s",
                "--journal",
                str(path),
                "--journal-max",
                "100kB",
            ]
        )
        == 0
    )
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


@pytest.mark.parametrize("text", ["precious\n", "p"])
def test_the_part_before_is_replaced_if_it_is_a_journal_alone(tmp_path, text):
    path, before = tmp_path / "k.jsonl", tmp_path / "k.jsonl.1"
    Journal(path, {"seed": 7}).close()
    before.write_text(text)
    with pytest.raises(UsageError, match=r"k\.jsonl\.1: is not a journal and will not be overwritten"):
        Journal(path, max_bytes=LIMIT)
    assert before.read_text() == text
    assert Journal.read(path).header["seed"] == 7, "nothing is lost of the older journal either"
    Journal(path).close()


@pytest.mark.parametrize("make", [os.mkdir, os.mkfifo, lambda path: os.symlink("nowhere", path)])
def test_what_stands_where_the_part_before_belongs_is_said_at_once(tmp_path, make):
    make(tmp_path / "j.jsonl.1")
    with pytest.raises(UsageError, match="will not be overwritten"):
        Journal(tmp_path / "j.jsonl", max_bytes=LIMIT)
    assert not (tmp_path / "j.jsonl").exists()


@pytest.mark.parametrize("make", [os.mkdir, lambda path: path.write_text("precious")])
def test_what_comes_there_meanwhile_ends_the_run_and_costs_nothing(tmp_path, make):
    path = tmp_path / "j.jsonl"
    journal = Journal(path, max_bytes=LIMIT)
    fill(journal, 5)
    make(tmp_path / "j.jsonl.1")
    with pytest.raises(UsageError, match="will not be overwritten"):
        fill(journal)
    journal.close()
    recording = Journal.read(path)
    assert recording.ended
    assert recording.problem is None
    assert path.stat().st_size < LIMIT


@pytest.mark.parametrize("call", ["replace", "open"])
def test_a_part_that_cannot_be_begun_is_one_line_and_costs_nothing(tmp_path, monkeypatch, call):
    path = tmp_path / "j.jsonl"
    journal = Journal(path, max_bytes=LIMIT)

    def refuse(*_words):
        raise OSError(30, "Read-only file system")

    fill(journal, 5)
    with monkeypatch.context() as patched:
        patched.setattr(os, "rename" if call == "replace" else "open", refuse)
        patched.setattr(os, "replace" if call == "replace" else "open", refuse)
        with pytest.raises(UnavailableError, match="the journal cannot be written: Read-only file system"):
            fill(journal)
    journal.close()
    (left,) = tmp_path.iterdir()
    assert Journal.read(left).ended


def test_a_journal_that_was_moved_away_is_written_on_and_nothing_else_is_renamed(tmp_path):
    path = tmp_path / "j.jsonl"
    journal = Journal(path, max_bytes=LIMIT)
    path.rename(tmp_path / "mine.jsonl")
    path.write_text("precious")
    fill(journal)
    journal.close()
    assert path.read_text() == "precious"
    assert numbers(tmp_path / "mine.jsonl") == list(range(100))


def test_through_a_link_the_file_is_renamed_and_not_the_link(tmp_path):
    disk = tmp_path / "disk"
    disk.mkdir()
    link, file = tmp_path / "j.jsonl", disk / "j.jsonl"
    link.symlink_to("disk/j.jsonl")
    journal = Journal(link, max_bytes=LIMIT)
    fill(journal)
    journal.close()
    assert link.is_symlink()
    assert {one.name for one in disk.iterdir()} == {"j.jsonl", "j.jsonl.1"}
    assert numbers(file)[-1] == 99


def test_what_a_link_of_the_system_leads_to_is_never_renamed(tmp_path):
    redirected = tmp_path / "out.jsonl"
    with redirected.open("wb") as file:
        link = tmp_path / "mine"
        link.symlink_to(f"/dev/fd/{file.fileno()}")
        journal = Journal(link, max_bytes=LIMIT)
        fill(journal)
        journal.close()
    assert numbers(redirected) == list(range(100))
    assert link.is_symlink()


@pytest.mark.parametrize("path", ["/dev/stdout", "/dev/null", "link", "pipe", "folder"])
def test_what_cannot_be_begun_anew_has_no_limit(tmp_path, monkeypatch, capfd, path):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "link").symlink_to("/dev/stdout")
    os.mkfifo("pipe")
    (tmp_path / "folder").mkdir()
    assert main(["run", "bluepill", "--for", "1s", "--journal", path, "--journal-max", "100kB"]) == 2
    assert capfd.readouterr().err == (
        f"hilbench: --journal {path}: is no file on a disk that can become FILE.1; "
        "name a file, or leave out --journal-max\n"
    )


def test_a_link_that_leads_to_itself_is_one_line(tmp_path, capfd):
    (tmp_path / "a").symlink_to("b")
    (tmp_path / "b").symlink_to("a")
    for path in (tmp_path / "a", tmp_path / "a" / "j.jsonl"):
        assert main(["run", "bluepill", "--for", "1s", "--journal", str(path), "--journal-max", "100kB"]) == 3
        assert "the journal cannot be written: Too many levels" in capfd.readouterr().err
