"""A run of suites as far as it is known: what is planned, what a journal tells of cases, and the report at the end."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from hilbench.judging.verdicts import BY_OWN_REPORT

__all__ = ["RUNNING", "CheckedModel", "ChecksModel"]

Event = Mapping[str, Any]
RUNNING = "runs"
_WORST = ("error", "fail", "inconclusive", RUNNING, "pass", "not-applicable", "")
"""The verdicts of a clause's cases, worst first: the worst is the clause's, as of `hilbench.judging.verdicts`."""


@dataclass(slots=True)
class CheckedModel:
    """A clause; or a case, of a journal that names no clauses.

    Attributes:
        id: of the clause, or of the case.
        level: must or should; empty if it is not known.
        title: in a few words.
        cases: the verdict of each of its cases, by id; empty before it has one.
        verdict: that of the report; empty before that has come.
        about: what the report says of it.
        unseen: what it needs and nobody saw, so that the target's own reports were believed.
    """

    id: str
    suite: str = ""
    level: str = ""
    title: str = ""
    cases: dict[str, str] = field(default_factory=dict)
    verdict: str = ""
    cause: str = ""
    about: Event = field(default_factory=dict)
    unseen: tuple[str, ...] = ()

    @property
    def state(self) -> str:
        """The verdict, or what is known of it so far; empty while nothing is."""
        if self.verdict:
            return self.verdict
        known = set(self.cases.values())
        if RUNNING in known or (len(known) > 1 and "" in known and not known & {"error", "fail"}):
            return RUNNING
        return next((verdict for verdict in _WORST if verdict in known), "")

    @property
    def mark(self) -> str:
        """What stands before what was judged by less than it needs; else empty."""
        return BY_OWN_REPORT if self.unseen else ""

    @property
    def bad(self) -> bool:
        """Whether the target, or the bench, did not do what it has to."""
        return self.state in {"error", "fail"}


class ChecksModel:
    """See the module.

    Attributes:
        rows: the clauses in the order in which their cases run.
        ended: what the run came to, in words; empty while it runs.
    """

    def __init__(self) -> None:
        self.rows: dict[str, CheckedModel] = {}
        self.ended = ""
        self.report: Event = {}
        self._clauses: dict[str, Sequence[str]] = {}
        self._case = ""

    def plan(self, cases: Iterable[Event]) -> None:
        """Take the list of ``hilbench check --list --json``; may come when cases have run already."""
        before, self.rows = self.rows, {}
        for case in cases:
            self._clauses[case["id"]] = case["clause_ids"]
            for number, clause in enumerate(case["clause_ids"]):
                row = self.rows.setdefault(clause, CheckedModel(clause, str(case["suite"])))
                row.level = str(case["levels"][number])
                row.title = str(case["titles"][number])
                known = before.get(case["id"], CheckedModel(case["id"]))
                row.cases[case["id"]], row.cause = known.state, row.cause or known.cause
                row.unseen = (*dict.fromkeys((*row.unseen, *case.get("by_own_report", ()))),)
                if case["missing"]:
                    row.cases[case["id"]] = "not-applicable"
                    row.cause = f"needs {', '.join(map(str, case['missing']))}"

    def take(self, event: Event) -> None:
        """Take what the journal of a run tells."""
        match event["kind"]:
            case "case":
                self._case = str(event["case"])
                self._set(RUNNING)
            case "verdict":
                self._set(str(event["verdict"]), str(event.get("cause", "")))

    def take_report(self, report: Event) -> None:
        """Take the report of ``hilbench check --json``: it says all there is to say, also where no plan has come."""
        self.report = report
        for case in report["cases"]:
            self.rows.pop(case["id"], None)
        for clause in report["clauses"]:
            row = self.rows.setdefault(clause["id"], CheckedModel(clause["id"]))
            row.cases |= {case["id"]: case["verdict"] for case in report["cases"] if clause["id"] in case["clause_ids"]}
            row.suite, row.level, row.title = clause["suite"], clause["level"], clause["title"]
            row.verdict, row.cause, row.about = clause["verdict"], clause["cause"], clause
            row.unseen = tuple(clause.get("by_own_report", ()))
        self.ended = str(report.get("exit_meaning", "ended"))

    def counts(self) -> Counter[str]:
        """Return how many clauses have which verdict; an empty one has not been run."""
        return Counter(row.state for row in self.rows.values())

    def _set(self, verdict: str, cause: str = "") -> None:
        for clause in self._clauses.get(self._case, (self._case,)):
            row = self.rows.setdefault(clause, CheckedModel(clause, self._case.partition("/")[0]))
            row.cases[self._case] = verdict
            if cause:
                row.cause = cause
