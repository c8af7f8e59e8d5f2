"""What stands on a live bench: a target, and who speaks to it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from hilbench.bench.state_reporter import Observed, Sense, Senses
from hilbench.driving.driver import Drives
from hilbench.driving.operators import Operator
from hilbench.driving.tap import Tap

__all__ = ["CLIENT_SENSES", "Rig"]

CLIENT_SENSES = {"KEEPALIVE": Sense.REST}
"""Our clients speak when this one runs out, which is what it is for."""


@dataclass(slots=True, kw_only=True)
class Rig:
    """A target and who speaks to it.

    Attributes:
        operator: one of our clients; None if no line of the bench leads to one, or several are driven together.
        taps: our ends of the lines, by their names.
        machines: the state machines that can be looked at, by their source in the journal.
        senses: what the ends of their timers mean.
        views: what else can be looked at, see `hilbench.bench.state_reporter.StateReporter`.
        about: what the header of the journal says for those who show it.
        drive: begins to drive, the demo driver first or not; None where a `Driver` with the operator does, or nobody.
        demo: whether the demo driver may drive it.
        reset: presses the reset button; None where there is none.
        stimulate: does a stimulus that is written as docs/stimuli.md says; None where no emulated board is.
        ended: says why the target will never go on; empty while it does.
        close: gives everything back.
    """

    operator: Operator | None = None
    taps: Mapping[str, Tap] = field(default_factory=dict)
    machines: Mapping[str, Observed] = field(default_factory=dict)
    senses: Senses = field(default_factory=dict)
    views: Mapping[str, Callable[[], Mapping[str, object]]] = field(default_factory=dict)
    about: Mapping[str, Any] = field(default_factory=dict)
    demo: bool = True
    drive: Callable[[bool], Drives] | None = None
    reset: Callable[[], None] | None = None
    stimulate: Callable[[str], None] | None = None
    ended: Callable[[], str] = lambda: ""
    close: Callable[[], None] = lambda: None
