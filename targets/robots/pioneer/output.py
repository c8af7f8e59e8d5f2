"""What the robot has given to its UART and may still take back.

Frames are never cut: one whose first byte has left goes out whole, those behind it can be withdrawn.
"""

from __future__ import annotations

from collections import deque
from typing import Protocol


class HostLine(Protocol):
    """What the robot sees of the line it sends on."""

    @property
    def baud(self) -> int:
        """Bits per second, 0 for no pace."""

    @property
    def pending(self) -> int:
        """Bytes handed over that are not out yet."""

    def withdraw(self, keep: int) -> None:
        """Take back what is not out yet, but for the next `keep` bytes and what is being sent."""


class UnpacedLine:
    """A line on which nothing ever waits."""

    baud = 0
    pending = 0

    def withdraw(self, keep: int) -> None:
        """Do nothing: there is nothing to take back."""


class Output:
    """Collects the frames of a call, and knows which of all that were sent have not begun to leave.

    Attributes:
        line: where the collected bytes are going to be written.
    """

    def __init__(self) -> None:
        self.line: HostLine = UnpacedLine()
        self._collected = bytearray()
        self._total = 0  # bytes ever collected; the ends below count from the same start
        self._ends: deque[int] = deque()
        self._session_start = 0

    def put(self, frame: bytes) -> None:
        """Send a frame behind the others."""
        self._collected += frame
        self._total += len(frame)
        self._ends.append(self._total)

    def take(self) -> bytes:
        """Take what was collected, to be written to the line at once."""
        taken = bytes(self._collected)
        self._collected.clear()
        while self._ends and self._ends[0] <= self._total - len(taken) - self.line.pending:
            self._ends.popleft()
        return taken

    def start_session(self) -> None:
        """Let what was sent so far, the answers to the SYNCs, go out whatever happens."""
        self._session_start = self._total

    def withdraw(self) -> int:
        """Take back the frames of the session that have not begun to leave the line; return how many bytes they have.

        What was collected in the present call was due before the session ended, and stays.
        """
        written = self._total - len(self._collected)
        out = written - self.line.pending
        begun = next((end for end in self._ends if end > out), out)
        keep = max(begun, self._session_start)
        if keep >= written:
            return 0
        self.line.withdraw(keep - out)
        self._total -= written - keep
        self._ends = deque(end for end in self._ends if end <= keep)
        return written - keep
