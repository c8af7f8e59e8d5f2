"""What lateness makes of a verdict on something that was not done in its time, and what an emulation lacks of any.

A figure that has lateness in its uncertainty is judged with it (`hilbench.judging.judge`). What a target said is wrong
however late it was read. Only that something did not come while a case waited for it, or came while it must not, may be
the doing of a bench that was late (`Untimely`): such a fail stands where the benches were no later than cases have to
bear anyway, or than the case waited longer.

A target that waits on something that its emulation lacks would have gone on where it is at home: nothing that it fails
to do meanwhile is held against it. Having touched something of the kind excuses nothing.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from hilbench.judging.outcome import Outcome
from hilbench.judging.verdicts import Verdict

__all__ = ["BORNE_S", "Doubt", "doubted", "excused"]

BORNE_S = 0.016
"""How late what comes from a board may be taken by any case, in seconds: so long an FT232R keeps bytes in its first
state (FTDI AN232B-04)."""

_WORTH_SAYING_S = 0.001


@dataclass(frozen=True, slots=True, kw_only=True)
class Doubt:
    """How late things were in a case.

    Attributes:
        lateness_s: how late the checker's bench and the target's were together, in seconds, with what they stood still.
        cause: which of them was, and how late, for people.
        lived: whether as much time passed for the target in each wait as the case had waited.
    """

    lateness_s: float
    cause: str
    lived: bool = True


def doubted(outcome: Outcome, doubt: Doubt) -> Outcome:
    """Return an outcome as far as it can be held for true."""
    figure = outcome.measure
    if outcome.verdict is Verdict.INCONCLUSIVE and figure is not None and doubt.lateness_s >= _WORTH_SAYING_S:
        return replace(outcome, cause=f"{outcome.cause}; {doubt.cause}")
    if outcome.spare_s is not None and doubt.lateness_s > max(BORNE_S, outcome.spare_s):
        cause = f"{outcome.cause}: not counted against the target, because {doubt.cause}"
        return replace(outcome, verdict=Verdict.INCONCLUSIVE, cause=cause)
    if outcome.verdict is Verdict.PASS and not doubt.lived:
        cause = f"less time passed for the target than the case waited: {doubt.cause}"
        return replace(outcome, verdict=Verdict.INCONCLUSIVE, cause=cause)
    return outcome


def excused(outcome: Outcome, lacks: str) -> Outcome:
    """Return an outcome as far as it can be held for true of a target that waits on what is not modelled, if it does.

    Args:
        outcome: other than a pass.
        lacks: on what it waits, for people; empty if on nothing of the kind.
    """
    if lacks and outcome.verdict is Verdict.INCONCLUSIVE:
        return replace(outcome, cause=f"{outcome.cause}; {lacks}")
    if lacks and outcome.verdict is Verdict.FAIL:
        cause = f"{outcome.cause}: not counted against the target, because {lacks}"
        return replace(outcome, verdict=Verdict.INCONCLUSIVE, cause=cause)
    return outcome
