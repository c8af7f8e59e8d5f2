"""What waits to be sent on a real line: bytes, and between them what has to wait until those before it are out.

A break or another rate at once would corrupt the bytes that the system still has: they are taken when it is their turn.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

from hilbench.links.port import Refused

__all__ = ["Outgoing", "Turn"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Turn:
    """What is done between bytes.

    Attributes:
        act: does it, or raises UnavailableError.
        refused: takes that.
    """

    act: Callable[[], None]
    refused: Refused


class Outgoing:
    """See the module; its length is that of all bytes.

    Attributes:
        first: the bytes before the next turn; whoever sends some removes them.
    """

    def __init__(self) -> None:
        self.first = bytearray()
        self._turns: deque[tuple[Turn, bytearray]] = deque()

    def __len__(self) -> int:
        return len(self.first) + sum(len(behind) for _, behind in self._turns)

    @property
    def idle(self) -> bool:
        """Whether nothing waits at all."""
        return not self.first and not self._turns

    def add(self, data: bytes) -> None:
        """Put bytes behind everything else."""
        last = self._turns[-1][1] if self._turns else self.first
        last += data

    def add_turn(self, turn: Turn) -> None:
        """Put something to be done behind everything else."""
        self._turns.append((turn, bytearray()))

    def next_turn(self) -> Turn | None:
        """Return what is to be done now that the first bytes are out, and go on to those behind it; None if nothing."""
        if self.first or not self._turns:
            return None
        turn, self.first = self._turns.popleft()
        return turn

    def clear_bytes(self) -> int:
        """Forget all bytes, and nothing that is between them; return how many those were."""
        lost = len(self)
        self.first.clear()
        for _, behind in self._turns:
            behind.clear()
        return lost

    def clear(self) -> int:
        """Forget everything; return how many bytes those were."""
        lost = self.clear_bytes()
        self._turns.clear()
        return lost
