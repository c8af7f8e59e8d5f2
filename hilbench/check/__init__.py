"""Checks: how suites are written, run and reported.

For suites: `case`, `CaseSetup`, `Violation`, `Inconclusive`, `NotApplicable`, `record_measure` and the judge. For
programs: `run_suites`. For those who bring a bench: `BenchProvider`, `CaseBench` and `CaseInfo`.
"""

from __future__ import annotations

from hilbench.check.cases import case
from hilbench.check.judge import at_least, at_most, near, within
from hilbench.check.provider import BenchProvider, CaseBench, CaseInfo, CaseSetup
from hilbench.check.recorder import record_measure
from hilbench.check.results import CaseResult, ClauseResult, Report
from hilbench.check.runner import list_cases, run_check, run_suites
from hilbench.check.verdicts import Inconclusive, Measure, NotApplicable, Verdict, Violation
from hilbench.options import CheckOptions

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
    "within",
]
