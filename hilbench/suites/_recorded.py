"""What the cases on recordings have in common: where somebody may be judged, and the worst of what was seen.

Such a case sends nothing. It looks for what a clause is about, wherever that happened, and judges it. Where it never
happened, the clause does not concern this recording.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import TypeVar

from hilbench.check import Inconclusive, NotApplicable, Violation, at_most
from hilbench.check import case as any_case
from hilbench.check.capture_provider import CaptureCase
from hilbench.clock import NS_PER_S
from hilbench.judging.provider import RECORDING
from hilbench.recordings.listening import Heard, Stretch

FunctionT = TypeVar("FunctionT", bound=Callable[..., object])

__all__ = ["Worst", "around", "followed", "judge_answers", "on_recording", "start_ns", "stretches_of"]


def on_recording(*clause_ids: str) -> Callable[[FunctionT], FunctionT]:
    """Declare that a function judges these clauses by listening alone."""
    return any_case(*clause_ids, needs=(RECORDING,))


def stretches_of(bench: CaptureCase, end: str) -> Iterator[Stretch]:
    """Yield the stretches in which this end may be judged.

    Raises:
        Inconclusive: only one direction of the line was recorded.
    """
    if not any(stretch.under_test for stretch in bench.stretches):
        raise Inconclusive("only one direction of the line is in this recording")
    return (stretch for stretch in bench.stretches if end in stretch.under_test)


@dataclass(slots=True)
class Worst:
    """The worst of many figures, with where it was seen.

    Attributes:
        what: what the figure is, for the report.
        unit: its unit.
        value: the figure; None while there is none.
        where: in which stretch, and when.
        uncertainty: of the figure.
        count: how many there were.
    """

    what: str
    unit: str
    value: float | None = None
    where: str = ""
    uncertainty: float = 0.0
    count: int = 0

    def take(self, value: float, where: str, uncertainty: float) -> None:
        """Take a figure."""
        self.count += 1
        if self.value is None or value - uncertainty > self.value - self.uncertainty:
            self.value, self.where, self.uncertainty = value, where, uncertainty

    def judge(self, limit: float, never: str) -> None:
        """Require even the worst to be no higher than a limit.

        Raises:
            Violation: it is higher.
            Inconclusive: it may be.
            NotApplicable: there was none; `never` says of what.
        """
        if self.value is None:
            raise NotApplicable(f"{never} in this recording")
        what = f"{self.what} ({self.where}, the worst of {self.count})"
        at_most(self.value, limit, unit=self.unit, what=what, uncertainty=self.uncertainty)


BYTE_S = 10 / 9600
"""Of a byte at the usual rate, by which the first byte of a frame is reckoned from its last one."""


def start_ns(one: Heard) -> int:
    """Return when the first byte of a frame was there, at the usual rate."""
    return one.ns - round(len(one.item.raw) * BYTE_S * NS_PER_S)


def followed(
    stretch: Stretch, asked: Heard, within_s: float, answers: Callable[[Heard], bool], by: str
) -> Heard | None:
    """Return the answer to something; None if there was none.

    Raises:
        LookupError: nobody can tell: it was not listened to for long enough, or the line was disturbed.
    """
    patience_ns = round(within_s * 1.5 * NS_PER_S) + NS_PER_S // 20
    if not stretch.quiet(asked.ns, asked.ns):
        raise LookupError
    for one in stretch.between(asked.ns, asked.ns + patience_ns):
        if one.by == by and answers(one):
            return one
    if not stretch.quiet(asked.ns, asked.ns + patience_ns):
        raise LookupError
    return None


def judge_answers(
    asked: Iterable[tuple[Stretch, Heard]],
    within_s: float,
    answers: Callable[[Heard], bool],
    by: str,
    *,
    what: str,
    never: str,
    right: Callable[[Heard], bool] = lambda _: True,
    to_its_start: bool = False,
) -> None:
    """Require each of many questions to be answered in time.

    Args:
        asked: the questions.
        within_s: how soon an answer is due, in seconds.
        answers: says whether something is one.
        by: who has to answer.
        what: the answer, for the report.
        never: what is said where there was no question.
        right: says whether an answer is what it should be.
        to_its_start: whether the first byte of the answer is to be there by then, and not its last one.

    Raises:
        Violation: one was not, or wrongly, or too late.
        Inconclusive: one may have been too late.
        NotApplicable: there was no question.
    """
    worst = Worst(f"{what} came after", "s")
    for stretch, question in asked:
        with contextlib.suppress(LookupError):
            answer = followed(stretch, question, within_s, answers, by)
            if answer is None:
                raise Violation(f"no {what} ({stretch.at(question.ns)})", around(stretch, question.ns))
            if not right(answer):
                said = answer.item.raw.hex(" ").upper()
                raise Violation(f"a wrong {what}: {said} ({stretch.at(answer.ns)})", around(stretch, answer.ns))
            there_ns = start_ns(answer) if to_its_start else answer.ns
            worst.take((there_ns - question.ns) / NS_PER_S, stretch.at(question.ns), stretch.uncertainty_s)
    worst.judge(within_s, never)


_SHOWN_AROUND = 5


def around(stretch: Stretch, ns: int) -> list[str]:
    """Return what passed the line before and after, as lines of evidence."""
    shown = stretch.around(ns, _SHOWN_AROUND)
    return [f"{one.ns / NS_PER_S:10.4f} s  {one.by:<6}  {one.item.raw[:32].hex(' ').upper()}" for one in shown]
