"""Families of stimuli: of all the ways to corrupt a frame, a case tries some, drawn by its seed, and names the culprit.

A family is a list of members, each with a few words. Where the budget has room all of them are tried; otherwise so many
as it says, none of them twice, in the order of the list. How many of how many they were stands in the report.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import TypeVar

from hilbench.judging.recorder import recorded_so_far
from hilbench.judging.verdicts import CaseOutcome, Sampled, Violation

StimulusT = TypeVar("StimulusT")


def try_members(
    family: str,
    members: Sequence[tuple[str, StimulusT]],
    judge: Callable[[StimulusT], object],
    *,
    seed: int,
    budget: int,
) -> None:
    """Try members of a family of stimuli, one after the other, until one of them ends the case.

    Args:
        family: the name of the family, a plural noun, as in ``single bits``.
        members: all members, at least one: a short description of each, and its stimulus.
        judge: applies a stimulus and judges the reaction, as a case does. It leaves the target ready for the next one.
        seed: the seed of the case; the same seed tries the same members.
        budget: how many members to try at most, at least one. The bench time of the case must allow for them.

    Raises:
        Violation: that of a member; its cause begins with the member and the seed. A failed assertion becomes one.
        Inconclusive: as above.
        ValueError: there is no member, or no budget.
    """
    if not members or budget < 1:
        raise ValueError(f"{family}: {len(members)} members and a budget of {budget} leave nothing to try")
    numbers = sorted(random.Random(seed).sample(range(len(members)), min(budget, len(members))))
    recorded, tried = recorded_so_far(), 0
    try:
        for tried, number in enumerate(numbers, start=1):  # noqa: B007 - it is recorded, whatever happens
            what, stimulus = members[number]
            open_before = len(recorded.unclear)
            with _named(f"member {number + 1} of {len(members)} {family} ({what}), case seed {seed}") as name:
                judge(stimulus)
            for point in recorded.unclear[open_before:]:
                _name(point, name)
    finally:
        recorded.families.append(Sampled(family=family, tried=tried, members=len(members)))


@contextmanager
def _named(name: str) -> Iterator[str]:
    try:
        yield name
    except CaseOutcome as outcome:
        _name(outcome, name)
        raise
    except AssertionError as error:
        said = (str(error).strip() or "an assertion without text failed").splitlines()[0]
        raise Violation(f"{name}: {said}") from error


def _name(outcome: CaseOutcome, name: str) -> None:
    outcome.cause = f"{name}: {outcome.cause}"
    outcome.args = (outcome.cause,)
