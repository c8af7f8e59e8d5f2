"""What a check can say, and the exceptions by which a case says it.

A case passes by returning. Otherwise it raises::

    AssertionError      the target violates the clause; the cause is the text of the assertion
    Violation           the same, with the cause and the evidence in the case's own words
    Untimely            the same, because something did not come in time: a late bench may be to blame
    Inconclusive        the bench cannot tell: it is too imprecise, or something needed is not modelled
    NotApplicable       the target turned out to lack something the case needs
    UnavailableError    the bench or the target is gone; nothing further is run (see `hilbench.errors`)

Anything else that escapes from a case is a defect in the case or in hilbench, never the target's fault.
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import Enum
from typing import Literal

import msgspec

Level = Literal["must", "should"]


class Verdict(Enum):
    """The outcome of a case, and of a clause."""

    PASS = "pass"  # noqa: S105 - a verdict, not a password
    FAIL = "fail"
    INCONCLUSIVE = "inconclusive"
    ERROR = "error"
    NOT_APPLICABLE = "not-applicable"
    NOT_RUN = "not-run"


WORST_FIRST = (
    Verdict.ERROR,
    Verdict.FAIL,
    Verdict.INCONCLUSIVE,
    Verdict.NOT_RUN,
    Verdict.PASS,
    Verdict.NOT_APPLICABLE,
)
"""The verdict of a clause is the first of these that one of its cases has."""


BY_OWN_REPORT = "by its own report: "
"""Stands before what was judged by what the target says of itself, where nobody saw whether that is so."""


def marked(cause: str, by_own_report: Sequence[str]) -> str:
    """Return the cause of a verdict, that of a pass being empty, behind what marks it as weaker if it is.

    Args:
        cause: one line.
        by_own_report: what nobody saw, so that the target's own reports stood in for it; empty if all was seen.
    """
    return f"{BY_OWN_REPORT}{cause}".removesuffix(": ") if by_own_report else cause


class CaseOutcome(Exception):  # noqa: N818 - an outcome, not an error
    """What a case raises if it does not pass. Raise one of the classes below.

    Args:
        cause: one line for people: what was seen, and what was required.
        evidence: further lines that show it: frames in hex, times, a pose.
        clause: the id of the clause, if the case cites several; the others are then inconclusive, not failed. Empty
            for all of them.
        measure: the figure that violates its limit or cannot be determined; None if there is none.
    """

    def __init__(
        self, cause: str, evidence: Sequence[str] = (), *, clause: str = "", measure: Measure | None = None
    ) -> None:
        super().__init__(cause)
        self.cause = cause
        self.evidence = tuple(evidence)
        self.clause = clause
        self.measure = measure


class Violation(CaseOutcome):
    """The target does not do what the clause says.

    Example scenarios: the wrong answer came; an answer came too late by more than the uncertainty of the bench.
    """


class Untimely(Violation):
    """The target did not do in time what the clause says, or did it at a time at which it must not.

    It is a violation only if the benches were in time themselves; otherwise the case is inconclusive
    (`hilbench.judging.doubt`). Do not use it for a measured time: the uncertainty of that contains the lateness of the
    benches.

    Example scenarios: no answer came while the case waited; a report came while the target must be silent.

    Args:
        cause: as in `CaseOutcome`.
        evidence: as in `CaseOutcome`.
        clause: as in `CaseOutcome`.
        measure: as in `CaseOutcome`.
        spare_s: how much longer the case waited than the clause allows, in seconds. Benches that were late by less are
            not to blame.
    """

    def __init__(
        self,
        cause: str,
        evidence: Sequence[str] = (),
        *,
        clause: str = "",
        measure: Measure | None = None,
        spare_s: float = 0.0,
    ) -> None:
        super().__init__(cause, evidence, clause=clause, measure=measure)
        self.spare_s = spare_s


class Inconclusive(CaseOutcome):
    """The bench cannot tell whether the target does what the clause says.

    Example scenarios: the distance of a measured time from its limit is less than its uncertainty; the host was late by
    more than the tolerance.
    """


class NotApplicable(CaseOutcome):
    """The clause does not apply to this target, which only the running case could find out.

    Example scenario: the clause is about a sensor, and the target's own configuration says that it has none. What is
    known before the case runs belongs in its ``needs``.
    """


class Sampled(msgspec.Struct, frozen=True, kw_only=True):
    """How much of a family of stimuli a case tried.

    Attributes:
        family: its name, a noun in the plural.
        tried: how many members were tried; the last of them is the one that ended the case, if one did.
        members: how many there are.
    """

    family: str
    tried: int
    members: int


class Measure(msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True):
    """A figure that a case has measured, with the limits it was compared with.

    Attributes:
        name: what was measured.
        value: the figure.
        unit: its unit, as in ``s``, ``mm/s`` or ``deg``.
        low: the lowest value allowed, if there is one.
        high: the highest value allowed, if there is one.
        uncertainty: half the width of the interval around the value that contains the true value.
        margin: distance to the nearest limit, in the same unit; negative outside of the limits. None without a limit.
        clause: the clause it belongs to, if the case cites several; empty for all of them.
        of_times: whether the lateness of the benches is part of the uncertainty.
    """

    name: str
    value: float
    unit: str
    low: float | None = None
    high: float | None = None
    uncertainty: float = 0.0
    margin: float | None = None
    clause: str = ""
    of_times: bool = False
