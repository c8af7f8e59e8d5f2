"""Pictures of failed cases: which, where, and that they change nothing."""

from __future__ import annotations

from xml.etree import ElementTree

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hilbench.check import CheckOptions, run_check
from hilbench.check.screens import Screens
from hilbench.errors import UsageError
from hilbench.judging.provider import CaseView
from hilbench.judging.verdicts import Verdict
from hilbench.terminal.console import Console

SUITE = """
    @my("A1")
    def test_passes(bench): bench.happens("a")

    @my("A2")
    def test_fails(bench):
        bench.happens("b")
        assert False, "it did not"

    @my("A3")
    def test_unclear(bench): raise Inconclusive("host was late")

    @my("A4", needs=("gravity",))
    def test_falls(bench): pass

    @my("A5", level="should")
    def test_tidy(bench): raise Violation("untidy")
    """


@pytest.fixture
def checked(watched, write_suite, tmp_path):
    """Run the suite with pictures; return what was drawn, the exit code, and the folder."""
    drawn = []

    def draw(header, events, said):
        drawn.append((header["bench"], header["live"], list(events), said))
        return f"<svg>{said}</svg>"

    def run(draw=draw, folder=tmp_path / "deep" / "shots", **options):
        asked = CheckOptions(suites=(str(write_suite(SUITE)),), screens=folder, junit=tmp_path / "r.xml", **options)
        code = run_check(asked, lambda _: watched, Console(), draw=draw)
        return drawn, code, folder

    return run


def test_what_does_not_pass_is_drawn_with_what_happened_until_then(checked):
    drawn, code, folder = checked()
    assert [(bench, about, events, said) for bench, about, events, said in drawn] == [
        ("fake", {"x": 1}, ["b"], "FAIL panel/fails: it did not"),
        ("fake", {"x": 1}, [], "INCONCLUSIVE panel/unclear: host was late"),
        ("fake", {"x": 1}, [], "FAIL panel/tidy: untidy"),
    ]
    assert code == 1
    assert sorted(file.name for file in folder.iterdir()) == ["panel_fails.svg", "panel_tidy.svg", "panel_unclear.svg"]
    assert (folder / "panel_fails.svg").read_text() == "<svg>FAIL panel/fails: it did not</svg>"


def test_reports_name_the_pictures(checked, tmp_path, capsys):
    _, _, folder = checked()
    said = {
        case.get("name")[:2]: (case.findtext("system-out"), [one.get("value") for one in case.iter("property")][-1])
        for case in ElementTree.parse(tmp_path / "r.xml").iter("testcase")
    }
    picture = str(folder / "panel_fails.svg")
    assert said["A2"] == (f"[[ATTACHMENT|{picture}]]", picture)
    assert said["A1"][0] is None
    assert f"  screen     {picture}\n" in capsys.readouterr().out


def test_a_picture_that_cannot_be_drawn_changes_no_verdict_and_is_said(checked, capsys):
    def broken(header, events, said):
        raise RuntimeError("no paper")

    _, code, folder = checked(broken)
    out, err = capsys.readouterr()
    assert code == 3
    assert not list(folder.iterdir())
    assert "4 clauses" not in out
    assert "1 pass, 1 fail, 1 warn, 1 inconclusive, 1 not applicable" in out
    assert "the screen could not be drawn: RuntimeError: no paper" in err


def test_a_folder_that_is_none_is_refused_before_anything_runs(checked, watched, tmp_path):
    (tmp_path / "file").write_text("mine")
    for folder in (tmp_path / "file", tmp_path / "file" / "below"):
        with pytest.raises(UsageError, match="--screens"):
            checked(folder=folder)
    assert not watched.opened
    assert (tmp_path / "file").read_text() == "mine"


def test_without_a_folder_nothing_is_kept_of_a_case(watched, write_suite):
    asked = CheckOptions(suites=(str(write_suite(SUITE)),))
    assert run_check(asked, lambda _: watched, Console(), draw=None) == 1
    assert [bench.seen for bench in watched.opened] == [None] * 4


@given(st.lists(st.text(st.characters(codec="utf-8"), max_size=200), max_size=6))
def test_each_case_has_a_file_of_its_own_in_the_folder(tmp_path_factory, ids):
    folder = tmp_path_factory.mktemp("shots")
    screens = Screens(folder, lambda _header, _events, said: said, "bench")
    view = CaseView(about={}, events=())
    files = [screens.save(case_id, view, Verdict.FAIL, str(number)) for number, case_id in enumerate(ids)]
    assert screens.problem is None
    assert len(set(files)) == len(ids)
    assert sorted(files) == sorted(map(str, folder.iterdir()))
