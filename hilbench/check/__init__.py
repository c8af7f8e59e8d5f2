"""Checks: how suites are written, run and reported.

For suites: `case`, `CaseSetup`, `Violation`, `Untimely`, `Inconclusive`, `NotApplicable`, `record_measure`,
`try_members` and the judge. For programs: `run_suites`. For those who bring a bench: `BenchProvider`, `CaseBench` and
`CaseInfo`.
"""

from __future__ import annotations

from hilbench.check.cases import case
from hilbench.check.results import CaseResult, ClauseResult, Report
from hilbench.check.runner import list_cases, run_check, run_suites
from hilbench.judging.families import try_members
from hilbench.judging.judge import at_least, at_most, near, within
from hilbench.judging.provider import BenchProvider, CaseBench, CaseInfo, CaseSetup
from hilbench.judging.recorder import record_measure
from hilbench.judging.verdicts import Inconclusive, Measure, NotApplicable, Untimely, Verdict, Violation
from hilbench.terminal.options import CheckOptions

__all__ = [
    "BenchProvider",
    "CaseBench",
    "CaseInfo",
    "CaseResult",
    "CaseSetup",
    "CheckOptions",
    "ClauseResult",
    "Inconclusive",
    "Measure",
    "NotApplicable",
    "Report",
    "Untimely",
    "Verdict",
    "Violation",
    "at_least",
    "at_most",
    "case",
    "list_cases",
    "near",
    "record_measure",
    "run_check",
    "run_suites",
    "try_members",
    "within",
]
