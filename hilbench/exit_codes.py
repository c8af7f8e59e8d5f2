"""What the process tells its caller: the exit codes and how several of them become one."""

from __future__ import annotations

import enum
from collections.abc import Iterable


class ExitCode(enum.IntEnum):
    """Exit codes of every `hilbench` command; part of the documented interface."""

    OK = 0
    """All checks passed."""
    VIOLATION = 1
    """The target violates a clause."""
    USAGE = 2
    """Wrong usage or bench file, nothing selected, or an error in a suite of the user's own."""
    UNAVAILABLE = 3
    """The bench or a target is not available: port, image, physics, shadowed package."""
    INCONCLUSIVE = 4
    """The bench was too imprecise, or a clause needs something that is not modelled."""
    DEFECT = 5
    """A defect in hilbench itself."""
    INTERRUPTED = 130
    """Interrupted; what was recorded is complete and readable."""


# A bench or a suite that broke says nothing about the target, so it outranks a violation; a violation that was seen
# stands even though something else stayed inconclusive.
_PRECEDENCE = (
    ExitCode.INTERRUPTED,
    ExitCode.DEFECT,
    ExitCode.UNAVAILABLE,
    ExitCode.USAGE,
    ExitCode.VIOLATION,
    ExitCode.INCONCLUSIVE,
    ExitCode.OK,
)


def worst(codes: Iterable[ExitCode]) -> ExitCode:
    """Return the one code that speaks for a whole run: 130, 5, 3, 2, 1, 4, 0 in that precedence; OK for no codes."""
    seen = set(codes)
    return next((code for code in _PRECEDENCE if code in seen), ExitCode.OK)
