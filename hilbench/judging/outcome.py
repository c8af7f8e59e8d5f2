"""Turns the exception that ended a case into a verdict."""

from __future__ import annotations

import re
import traceback
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import TracebackType

from hilbench.errors import AwayError, HilbenchError, PluginError, UnavailableError
from hilbench.judging.verdicts import CaseOutcome, Inconclusive, Measure, NotApplicable, Untimely, Verdict, Violation
from hilbench.plugins.blame import place_of
from hilbench.plugins.discovery import PLUGINS

_TRACEBACK_LINES = 12
_MOST_POINTS = 2
_SAYS_NOTHING = re.compile(
    r"\bat 0x[0-9a-f]+>|^assert (not )?(False|None|True|\d+|\[\]|\(\)|\{\}|''|\(\d+ & \d+\))$|^ *\+ .*\w\(\w+="
)
"""Lines of pytest about an assertion with words of its own: an address, a bare value or an object's insides show nobody
anything."""
_PYTEST_PACKAGES = frozenset({"_pytest", "pluggy"})

_VERDICTS: dict[type[CaseOutcome], Verdict] = {
    Violation: Verdict.FAIL,
    Inconclusive: Verdict.INCONCLUSIVE,
    NotApplicable: Verdict.NOT_APPLICABLE,
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """How a case, or a phase of it, ended.

    Attributes:
        verdict: what it says.
        cause: why, in one line; empty for a pass.
        evidence: lines that show it.
        clause: the one clause it is about, if the case named it.
        defect: whether an error is ours.
        suite_error: whether an error is that of a suite or a plug-in of the user's own.
        lost: whether the bench or the target is gone, so that nothing further can run.
        measure: the figure that it is about, if it is about one.
        spare_s: of a fail for something that was not done in its time, how late the benches may have been without being
            to blame, in seconds; None of any other, for which no lateness is.
    """

    verdict: Verdict
    cause: str = ""
    evidence: tuple[str, ...] = ()
    clause: str = ""
    defect: bool = False
    suite_error: bool = False
    lost: bool = False
    measure: Measure | None = None
    spare_s: float | None = None


PASSED = Outcome(verdict=Verdict.PASS)


def outcome_of(error: BaseException | None, own_suite: Path | None = None) -> Outcome:
    """Return the outcome of a case that ended with this exception, or with none.

    Args:
        error: the exception.
        own_suite: the file of the case if it is the user's.
    """
    if error is None:
        return PASSED
    if isinstance(error, CaseOutcome):
        verdict = next(_VERDICTS[kind] for kind in type(error).__mro__ if kind in _VERDICTS)
        return Outcome(
            verdict=verdict,
            cause=_one_line(str(error)),
            evidence=error.evidence,
            clause=error.clause,
            measure=error.measure,
            spare_s=error.spare_s if isinstance(error, Untimely) else None,
        )
    if isinstance(error, AssertionError):
        return _of_assertion(error)
    if isinstance(error, UnavailableError):
        return Outcome(verdict=Verdict.ERROR, cause=_one_line(str(error)), lost=not isinstance(error, AwayError))
    if isinstance(error, PluginError):
        return Outcome(verdict=Verdict.ERROR, cause=_one_line(str(error)), suite_error=True)
    place = place_of(
        error, lambda file: PLUGINS.brought(file) or (own_suite is not None and file.parent == own_suite.parent)
    )
    said = str(error) if isinstance(error, HilbenchError) else f"{type(error).__name__}: {error}"
    return Outcome(
        verdict=Verdict.ERROR,
        cause=_one_line(f"{place or 'defect'}: {said}"),
        evidence=_traceback(error),
        defect=not place,
        suite_error=bool(place),
    )


def with_open_points(outcome: Outcome, unclear: Sequence[Inconclusive]) -> Outcome:
    """Return the outcome of a case with the points that its bench could not tell.

    They make a pass inconclusive; another outcome has them in its evidence.
    """
    if not unclear:
        return outcome
    if outcome.verdict is Verdict.PASS:
        outcome, unclear = outcome_of(unclear[0]), unclear[1:]
    left = [f"cannot be judged either: {_one_line(str(point))}" for point in unclear[:_MOST_POINTS]]
    if len(unclear) > _MOST_POINTS:
        left.append(f"and {len(unclear) - _MOST_POINTS} more figures cannot be judged")
    return replace(outcome, evidence=(*outcome.evidence, *left))


def _of_assertion(error: AssertionError) -> Outcome:
    lines = str(error).strip().splitlines() or ["an assertion without text failed"]
    evidence = [line for line in lines[1:] if line.strip() and not _SAYS_NOTHING.search(line)]
    where = traceback.extract_tb(error.__traceback__)
    if where:
        evidence.append(f"{Path(where[-1].filename).name}:{where[-1].lineno}: {where[-1].line}")
    return Outcome(verdict=Verdict.FAIL, cause=_one_line(lines[0]), evidence=tuple(evidence))


def printable(line: str) -> str:
    """Return a line with control characters spelled out: what a target sent must not steer the reader's terminal."""
    return "".join(letter if letter.isprintable() else f"\\x{ord(letter):02x}" for letter in line.expandtabs())


def _traceback(error: BaseException) -> tuple[str, ...]:
    """Return the last lines of the traceback, from the suite on: how pytest got there says nothing."""
    frames = error.__traceback__
    while frames is not None and frames.tb_next is not None and _in_pytest(frames):
        frames = frames.tb_next
    text = "".join(traceback.format_exception(type(error), error, frames))
    return tuple(line for line in text.splitlines() if line.strip())[-_TRACEBACK_LINES:]


def _in_pytest(frame: TracebackType) -> bool:
    return not _PYTEST_PACKAGES.isdisjoint(Path(frame.tb_frame.f_code.co_filename).parts)


def _one_line(text: str) -> str:
    return " ".join(text.split())
