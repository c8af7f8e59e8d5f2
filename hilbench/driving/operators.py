"""Who speaks to the target of a live bench: one of our own clients, commanded in shares of what is usual.

Each client has a module of its own, so that a bench loads but the protocol that is spoken on it.
"""

from __future__ import annotations

from typing import Protocol

from hilbench.bench.state_reporter import Observed

__all__ = ["Operator"]


class Operator(Protocol):
    """One of our clients."""

    @property
    def name(self) -> str:
        """Its source in the journal."""

    @property
    def observed(self) -> Observed:
        """Its end of the protocol."""

    @property
    def in_session(self) -> bool:
        """Whether the target is there and can be commanded to drive."""

    @property
    def idle(self) -> bool:
        """Whether it is neither connected nor trying to be."""

    @property
    def room_ahead_m(self) -> float | None:
        """How far it sees nothing ahead, in metres; None if it does not see."""

    @property
    def pad_turn(self) -> float:
        """What a game pad's full stick is, as a multiple of the usual full turn."""

    @property
    def circle(self) -> tuple[float, float]:
        """The shares, forward and counter-clockwise, by which the demo driver has it go round."""

    def connect(self) -> None:
        """Begin to connect; nothing if it does so already."""

    def disconnect(self) -> None:
        """Take leave; nothing if it is not connected."""

    def drive(self, forward: float, turn: float) -> None:
        """Drive by shares of -1 to 1, forward and counter-clockwise; nothing without a session."""

    def tidy(self) -> None:
        """Forget what is old; called now and then."""
