"""One thing that was looked at: how it stands, and what to do if it is not right."""

from __future__ import annotations

import enum
from dataclasses import dataclass

__all__ = ["Finding", "State", "cross", "fine", "warning"]


class State(enum.Enum):
    """How a thing stands."""

    FINE = "fine"
    """Nothing to do."""
    WARNING = "warning"
    """Something would work better, or something that is not used now would not work."""
    CROSS = "cross"
    """Something does not work."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Finding:
    """What was found.

    Attributes:
        subject: what was looked at, such as ``wheels``.
        state: how it stands.
        what: what was seen, without a full stop.
        fix: what to do, a command where there is one; empty if all is fine.
    """

    subject: str
    state: State
    what: str
    fix: str = ""

    def __post_init__(self) -> None:
        if (self.state is State.FINE) != (not self.fix):
            raise ValueError(f"{self.subject}: whatever is not fine has a fix, and nothing else")

    def as_data(self) -> dict[str, object]:
        """Return it as plain data."""
        return {"subject": self.subject, "state": self.state.value, "what": self.what, "fix": self.fix or None}


def fine(subject: str, what: str) -> Finding:
    """Return that something is all right."""
    return Finding(subject=subject, state=State.FINE, what=what)


def warning(subject: str, what: str, fix: str) -> Finding:
    """Return that something could be better."""
    return Finding(subject=subject, state=State.WARNING, what=what, fix=fix)


def cross(subject: str, what: str, fix: str) -> Finding:
    """Return that something does not work."""
    return Finding(subject=subject, state=State.CROSS, what=what, fix=fix)
