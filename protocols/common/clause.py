"""A clause: one rule that a peer follows or violates, and where it is written."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

__all__ = ["Clause"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Clause:
    """One rule.

    Attributes:
        id: short name, unique over all catalogues.
        suite: the suite whose cases cite it.
        level: how binding it is.
        title: a few words.
        text: the rule.
        sources: where it is written.
        needs: names of what a bench must be able to do for it to be checked, beside speaking the protocol.
        stand_ins: names of what it must be able to do instead where it lacks some of `needs`: its case then judges by
            the peer's own reports, which is weaker evidence, and its verdict says so. Empty if nothing stands in.
        by_hand: whether a person beside the peer can do and see what it needs, on request: nothing of it has to be
            at an exact time or place.
    """

    id: str
    suite: str
    level: Literal["must", "should"]
    title: str
    text: str
    sources: tuple[str, ...]
    needs: tuple[str, ...] = ()
    stand_ins: tuple[str, ...] = ()
    by_hand: bool = False

    @property
    def source(self) -> str:
        """The sources in one line."""
        return "; ".join(self.sources)
