"""The rate of the host UART and the trial after HOSTBAUD.

The change is immediate. Unless a good packet arrives at the new rate within 500 ms the old rate is back (Pioneer 2/3
H8 Operations Manual, HOSTBAUD). The end of a session restores the stored rate (choice), so that the next client finds
the robot where it expects it.
"""

from __future__ import annotations

RATES = (9600, 19200, 38400, 57600, 115200)
"""bit/s, by HOSTBAUD argument."""


class HostBaud:
    """Current rate in bit/s and the trial that may be running.

    Args:
        stored: Rate at power-on, bit/s.
        trial_ns: How long a new rate is tried.
    """

    def __init__(self, stored: int, trial_ns: int) -> None:
        self._stored = stored
        self._trial_ns = trial_ns
        self._previous = stored
        self._deadline_ns: int | None = None
        self.baud = stored

    def request(self, code: int, now_ns: int) -> bool:
        """HOSTBAUD: switch; False for a code that names no rate."""
        if not 0 <= code < len(RATES):
            return False
        self._previous, self.baud = self.baud, RATES[code]
        self._deadline_ns = now_ns + self._trial_ns
        return True

    def confirm(self) -> None:
        """A good packet arrived."""
        self._deadline_ns = None

    def next_deadline_ns(self) -> int | None:
        """When the trial ends, None when there is none."""
        return self._deadline_ns

    def revert(self) -> None:
        """The trial failed: the old rate is back."""
        self.baud = self._previous
        self._deadline_ns = None

    def reset(self) -> bool:
        """Back to the stored rate; True when that changed it."""
        changed = self.baud != self._stored
        self.baud, self._deadline_ns = self._stored, None
        return changed
