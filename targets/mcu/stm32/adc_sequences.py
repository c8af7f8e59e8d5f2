"""The two groups of channels of an ADC: where a trigger begins, what comes next, where it ends (RM0410 section 15.3).

Both walk along their sequence; in discontinuous mode a trigger takes a few steps only, and the next one goes on there.
"""

from __future__ import annotations

from collections.abc import Sequence

__all__ = ["Group"]


class Group:
    """One group.

    Attributes:
        active: conversions were asked for and are not all made.
        rank: which conversion of the sequence is next, from 0 on.
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self.active = False
        self.rank = 0
        self._sequence: Sequence[int] = (0,)
        self._until = 0

    def start(self, sequence: Sequence[int], steps: int = 0) -> None:
        """Begin.

        Args:
            sequence: channels by rank.
            steps: how many a trigger converts in discontinuous mode; 0 for all.
        """
        self._sequence = sequence
        if not steps or self.rank >= len(sequence):
            self.rank = 0
        self._until = min(self.rank + steps, len(sequence)) if steps else len(sequence)
        self.active = True

    @property
    def channel(self) -> int:
        """The channel that is converted next."""
        return self._sequence[self.rank]

    @property
    def over(self) -> bool:
        """Whether the whole sequence has been converted, after `advance` has ended the group."""
        return self.rank == 0

    def advance(self) -> None:
        """A conversion has ended; after the last one that the trigger asked for the group is not active any more."""
        self.rank += 1
        if self.rank >= self._until:
            self.active = False
            if self.rank >= len(self._sequence):
                self.rank = 0
