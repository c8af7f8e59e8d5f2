"""What a CI system shows of a run beside its log: annotations and a summary on GitHub, two reports on GitLab.

GitHub Actions reads commands from the log ("Workflow commands for GitHub Actions") and shows ten errors and ten
warnings of a step; lines of the run itself are kept from being commands. The summary is Markdown, appended to the file
``GITHUB_STEP_SUMMARY``, at most 1 MiB of it. GitLab takes JUnit XML and Code Quality (a list of objects with
description, check_name, fingerprint, severity and location; "Code Quality report format") from files that the job
names.
"""

from __future__ import annotations

import enum
import hashlib
import json
import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from hilbench.benchfile.suites import suite_name
from hilbench.check.report import junit
from hilbench.check.report.matrix import counted, word_for
from hilbench.check.results import ClauseResult, Report
from hilbench.errors import UnavailableError
from hilbench.files import write_atomically
from hilbench.files.names import printable
from hilbench.judging.verdicts import Verdict
from hilbench.terminal.console import Console
from hilbench.terminal.options import CheckOptions

__all__ = ["CODE_QUALITY", "JUNIT", "Ci", "code_quality", "commands", "detected", "guarded", "markdown", "tell"]

CODE_QUALITY, JUNIT = "gl-code-quality-report.json", "gl-junit-report.xml"
"""What is written on GitLab where the command line names no files."""

_MOST_ANNOTATIONS = 10
_MOST_ROWS = 100
_MOST_BYTES = 900_000
_BAD = (Verdict.FAIL, Verdict.ERROR, Verdict.INCONCLUSIVE)
_SEVERITIES = {"fail": "critical", "error": "major", "inconclusive": "minor", "warn": "info"}
_NO_FILE = ".gitlab-ci.yml"  # a location must be a file of the repository; a built-in bench is none


class Ci(enum.StrEnum):
    """A CI system: ``--ci``."""

    GITHUB = "github"
    GITLAB = "gitlab"
    NONE = "none"


def detected(asked: str) -> Ci:
    """Return the system that the command line names, or for ``auto`` the one that says it runs this."""
    if asked != "auto":
        return Ci(asked)
    if os.environ.get("GITHUB_ACTIONS") == "true":
        return Ci.GITHUB
    return Ci.GITLAB if os.environ.get("GITLAB_CI") == "true" else Ci.NONE


@contextmanager
def guarded(ci: Ci, console: Console) -> Iterator[None]:
    """On GitHub have no line that is printed meanwhile be a command: a target may say anything."""
    if ci is not Ci.GITHUB:
        yield
        return
    token = secrets.token_hex(16)
    console.narrate(f"::stop-commands::{token}")
    try:
        yield
    finally:
        console.narrate(f"::{token}::")


def tell(ci: Ci, report: Report, options: CheckOptions, console: Console) -> None:
    """Tell GitHub of a run, or write what GitLab reads; what cannot be written, unasked for, costs a line."""
    if ci is Ci.GITLAB:
        _write_for_gitlab(report, options, console)
    if ci is not Ci.GITHUB:
        return
    for line in commands(report, options):
        console.narrate(line)
    file = os.environ.get("GITHUB_STEP_SUMMARY")
    if file:
        try:
            with Path(file).open("a", encoding="utf-8") as summary:
                summary.write(markdown(report))
        except OSError as error:
            console.narrate(f"hilbench: the summary of the step cannot be written: {error.strerror}")


# --- GitHub


def commands(report: Report, options: CheckOptions) -> list[str]:
    """Return a command for each clause that is not shown: errors first, ten of each kind."""
    kinds: dict[str, list[str]] = {"error": [], "warning": []}
    for clause in report.clauses:
        if clause.verdict not in _BAD:
            continue
        kind = "warning" if word_for(clause) in {"warn", "inconclusive"} else "error"
        title = f"{clause.id} ({clause.level}) {clause.title}: {word_for(clause)}"
        place = _place(clause, options)
        properties = [f"file={_property(place)}"] if place else []
        words = ",".join([*properties, f"title={_property(title)}"])
        kinds[kind].append(f"::{kind} {words}::{_message(clause)}")
    return [line for lines in kinds.values() for line in lines[:_MOST_ANNOTATIONS]]


def _message(clause: ClauseResult) -> str:
    return _escaped("\n".join(map(printable, [clause.mark + clause.cause, clause.source, clause.reproduce])))


def _escaped(text: str) -> str:
    return text.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")


def _property(text: str) -> str:
    return _escaped(printable(text)).replace(":", "%3A").replace(",", "%2C")


def markdown(report: Report) -> str:
    """Return the run as Markdown: what was checked, what is not shown and why, how to run it again."""
    bench = ", ".join(f"{key} {value}" for key, value in report.bench.items() if value)
    lines = [
        f"## hilbench check: {_cell(report.exit_meaning)}",
        "",
        f"{_cell(bench)}, seed {report.seed}, exit {report.exit_code}.",
        f"{_cell(counted(report.counts))}.",
        *([f"\nStopped: {_cell(report.stopped)}."] if report.stopped else []),
        "",
    ]
    bad = [clause for verdict in _BAD for clause in report.clauses if clause.verdict is verdict]
    if bad:
        lines += ["| clause | verdict | what | cause |", "|---|---|---|---|"]
        lines += [_row(clause) for clause in bad[:_MOST_ROWS]]
        lines += [f"\n{len(bad) - _MOST_ROWS} more stand in the log."] if len(bad) > _MOST_ROWS else []
        lines += ["", "Again:", "", "```", *(printable(clause.reproduce) for clause in bad[:_MOST_ANNOTATIONS]), "```"]
    lines += ["", f"Run hash `{report.run_hash}`" if report.run_hash else f"No run hash: {report.no_run_hash}", ""]
    return "".join(f"{line}\n" for line in lines).encode(errors="replace")[:_MOST_BYTES].decode("utf-8", "ignore")


def _row(clause: ClauseResult) -> str:
    cells = (f"{clause.id} ({clause.level})", word_for(clause), clause.title, clause.mark + clause.cause)
    return f"| {' | '.join(map(_cell, cells))} |"


def _cell(text: str) -> str:
    """Return text that is nothing but text in a cell of a table."""
    text = printable(" ".join(text.split()))
    for character, instead in (
        ("&", "&amp;"),
        ("<", "&lt;"),
        ("\\", "\\\\"),
        ("|", "\\|"),
        ("`", "\\`"),
        ("*", "\\*"),
        ("[", "\\["),
        ("_", "\\_"),
    ):
        text = text.replace(character, instead)
    return text


# --- GitLab


def _write_for_gitlab(report: Report, options: CheckOptions, console: Console) -> None:
    """Write the reports that the command line does not name."""
    for asked, name, content in (
        (options.junit, JUNIT, junit.junit_xml(report)),
        (options.code_quality, CODE_QUALITY, code_quality(report, options)),
    ):
        if asked is not None:
            continue
        try:
            write_atomically(Path(name), content)
            console.narrate(f"for GitLab: {name}")
        except UnavailableError as error:
            console.narrate(f"for GitLab: {error}")


def code_quality(report: Report, options: CheckOptions) -> str:
    """Return a Code Quality report: an entry for each clause that is not shown."""
    entries = [_entry(clause, report, options) for clause in report.clauses if clause.verdict in _BAD]
    return json.dumps(entries, indent=1, ensure_ascii=True) + "\n"


def _entry(clause: ClauseResult, report: Report, options: CheckOptions) -> dict[str, object]:
    # the same clause on the same bench is the same finding, whatever has gone wrong this time
    about = json.dumps([clause.id, clause.suite, report.bench.get("bench", ""), report.bench.get("target", "")])
    return {
        "description": f"{clause.id} {clause.title}: {clause.mark}{clause.cause}",
        "check_name": clause.id,
        "fingerprint": hashlib.sha256(about.encode()).hexdigest(),
        "severity": _SEVERITIES[word_for(clause)],
        "location": {"path": _place(clause, options) or _bench_file(options) or _NO_FILE, "lines": {"begin": 1}},
    }


# --- files of the repository


def _place(clause: ClauseResult, options: CheckOptions) -> str:
    """Return the file of a suite of the user's own that checks a clause, as the repository knows it; empty if none."""
    files = (Path(suite) for suite in options.suites if suite.endswith(".py"))
    return next((_relative(file) for file in files if suite_name(file) == clause.suite), "")


def _bench_file(options: CheckOptions) -> str:
    file = Path(options.bench or "hilbench.toml")
    return _relative(file) if file.is_file() else ""


def _relative(file: Path) -> str:
    path = file.resolve()
    root = os.environ.get("GITHUB_WORKSPACE") or os.environ.get("CI_PROJECT_DIR") or str(Path.cwd())
    whole = Path(root).resolve()
    return path.relative_to(whole).as_posix() if path.is_relative_to(whole) else file.as_posix()
