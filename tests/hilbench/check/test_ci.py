"""What GitHub and GitLab are told of a run, and that a target cannot tell them anything."""

from __future__ import annotations

import json

import pytest

from hilbench.check import CheckOptions, run_check
from hilbench.check.report import ci
from hilbench.terminal.console import Console

BODY = """
    @my("A1")
    def test_stops(): raise Violation("late, 2.3 s: 100 % | `x` <b>\\n::set-output name=a::b")

    @my("A2", level="should")
    def test_tidy(): raise Violation("untidy")

    @my("A3")
    def test_late(): raise Inconclusive("host was late")

    @my("A4")
    def test_answers(): pass

    @my("A5")
    def test_goes(): raise UnavailableError("unplugged")
    """
MANY = "".join(f'    @my("B{n}")\n    def test_{n}(): raise Violation("x")\n\n' for n in range(30))


@pytest.fixture
def on_github(monkeypatch, tmp_path):
    monkeypatch.setenv("GITHUB_ACTIONS", "true")
    monkeypatch.setenv("GITHUB_STEP_SUMMARY", str(tmp_path / "summary.md"))
    monkeypatch.setenv("GITHUB_WORKSPACE", str(tmp_path))
    return tmp_path / "summary.md"


@pytest.fixture
def checked(write_suite, provider, capsys):
    """Run a suite as the command does; return exit code, standard output and standard error."""

    def run(body=BODY, **options):
        options = {"suites": (str(write_suite(body)),), "ci": "github"} | options
        code = run_check(CheckOptions(**options), lambda _options: provider, Console())
        return code, *capsys.readouterr()

    return run


@pytest.mark.parametrize(
    ("environment", "asked", "found"),
    [
        ({}, "auto", "none"),
        ({"GITHUB_ACTIONS": "true"}, "auto", "github"),
        ({"GITLAB_CI": "true"}, "auto", "gitlab"),
        ({"GITHUB_ACTIONS": "true"}, "none", "none"),
        ({}, "gitlab", "gitlab"),
    ],
)
def test_who_runs_it(monkeypatch, environment, asked, found):
    for name in ("GITHUB_ACTIONS", "GITLAB_CI"):
        monkeypatch.delenv(name, raising=False)
    for name, value in environment.items():
        monkeypatch.setenv(name, value)
    assert ci.detected(asked) == found


def test_annotations_name_clause_verdict_cause_and_file(checked, on_github):
    code, _, said = checked()
    lines = [line for line in said.splitlines() if line.startswith(("::error ", "::warning "))]
    assert [line.partition("::")[2].partition(" ")[0] for line in lines] == ["error"] * 2 + ["warning"] * 2
    assert "file=test_panel.py,title=A1 (must) The target does A1%3A fail::late, 2.3 s: 100 %25 | `x` <b>" in lines[0]
    assert "%0Aour panel, rev. C%0Ahilbench check" in lines[0]
    assert code == 3


def test_lines_of_the_run_are_no_commands(checked, on_github):
    _, _, said = checked()
    lines = said.splitlines()
    token = lines[0].removeprefix("::stop-commands::")
    assert lines[0] != token
    assert len(token) == 32
    until = lines.index(f"::{token}::")
    commands = [number for number, line in enumerate(lines) if line.lstrip().startswith("::")]
    assert all(number in (0, until) or number > until for number in commands)
    assert "::set-output" not in "".join(
        line for line in lines[until + 1 :] if not line.startswith(("::error ", "::w"))
    )


def test_a_step_shows_ten_of_each_kind(checked, on_github):
    _, _, said = checked(MANY)
    assert sum(line.startswith("::error ") for line in said.splitlines()) == 10


def test_the_summary_is_appended_and_is_nothing_but_text(checked, on_github):
    on_github.write_text("before\n")
    checked()
    text = on_github.read_text()
    assert text.startswith("before\n## hilbench check: bench or target not available\n")
    assert (
        "| A1 (must) | fail | The target does A1 | late, 2.3 s: 100 % \\| \\`x\\` &lt;b> ::set-output name=a::b |"
        in text
    )
    assert "| A2 (should) | warn |" in text
    assert "A4" not in text
    assert "<b" not in text.replace("&lt;b", "")


def test_a_summary_that_cannot_be_written_costs_a_line(checked, on_github, monkeypatch, tmp_path):
    monkeypatch.setenv("GITHUB_STEP_SUMMARY", str(tmp_path / "none" / "summary.md"))
    code, _, said = checked()
    assert "hilbench: the summary of the step cannot be written: No such file or directory" in said
    assert code == 3


def test_nobody_is_told_anything_where_no_ci_runs_it(checked):
    assert "::" not in checked(ci="none")[2].replace("::set-output name=a::b", "")


def test_code_quality_has_an_entry_for_each_clause_that_is_not_shown(checked, monkeypatch, tmp_path):
    monkeypatch.setenv("CI_PROJECT_DIR", str(tmp_path))
    monkeypatch.chdir(tmp_path)
    _, _, said = checked(ci="gitlab")
    file = tmp_path / "gl-code-quality-report.json"
    entries = json.loads(file.read_text())
    assert [entry["check_name"] for entry in entries] == ["A1", "A2", "A3", "A5"]
    assert [entry["severity"] for entry in entries] == ["critical", "info", "minor", "major"]
    assert entries[0]["location"] == {"path": "test_panel.py", "lines": {"begin": 1}}
    assert len({entry["fingerprint"] for entry in entries}) == 4
    assert "for GitLab: gl-junit-report.xml\nfor GitLab: gl-code-quality-report.json\n" in said
    checked(ci="gitlab")
    assert json.loads(file.read_text()) == entries


def test_files_that_the_command_line_names_take_the_place_of_those_for_gitlab(checked, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    checked(ci="gitlab", junit=tmp_path / "own.xml", code_quality=tmp_path / "own.json")
    assert {file.name for file in tmp_path.glob("*.*ml")} == {"own.xml"}
    assert {file.name for file in tmp_path.glob("*.json")} == {"own.json"}


def test_what_nobody_asked_for_and_cannot_be_written_costs_a_line_each(checked, monkeypatch, tmp_path):
    (tmp_path / "gl-junit-report.xml").mkdir()
    (tmp_path / "gl-code-quality-report.json").mkdir()
    monkeypatch.chdir(tmp_path)
    code, _, said = checked('@my("A4")\ndef test_answers(): pass\n', ci="gitlab")
    assert code == 0
    assert said.count("for GitLab: ") == 2
    assert "gl-junit-report.xml" in said


def test_a_workspace_behind_a_link_is_the_same(checked, on_github, monkeypatch, tmp_path):
    (tmp_path / "there").mkdir()
    (tmp_path / "link").symlink_to(tmp_path)
    monkeypatch.setenv("GITHUB_WORKSPACE", str(tmp_path / "link"))
    monkeypatch.chdir(tmp_path / "there")
    assert "::error file=test_panel.py," in checked()[2]


def test_quiet_prints_what_is_not_shown_and_the_last_line(checked):
    _, printed, said = checked(ci="none", quiet=True)
    assert said == ""
    assert "A4" not in printed
    assert printed.startswith("FAIL A1 (must) The target does A1\n")
    assert printed.splitlines()[-1] == "exit 3: bench or target not available"


def test_quiet_says_one_line_where_all_is_shown(checked):
    assert checked('@my("A4")\ndef test_answers(): pass\n', ci="none", quiet=True)[1] == "exit 0: all checks passed\n"
