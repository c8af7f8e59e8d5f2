"""The sonar arrays: who fires when, and which readings are new.

Each array of eight discs fires one disc per 40 ms, in its polling sequence; a SIP lists only readings that are new
since the last one (Pioneer 2 Operations Manual, sonar). POLLING names discs from 1; the SIP numbers them from 0.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from targets.robots.pioneer.settings import RobotSettings

ARRAY = 8
"""Discs per array: 1 to 8 belong to array 1, 9 to 16 to array 2 and so on."""
MOST_PER_ARRAY = 16
"""Longest polling sequence of one array (Pioneer 2/3 H8 Operations Manual, POLLING)."""
MOST_PER_SIP = 16
"""Readings a SIP carries at most; older clients reserve no more."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Echo:
    """One firing: 0-based disc number and distance in mm."""

    disc: int
    range_mm: float


class SonarArrays:
    """Sequencer of all fitted discs.

    Args:
        settings: Which discs are fitted, the cycle time and the no-echo distance.
        fire: Fires one 0-based disc and returns its range in metres, None without echo.
    """

    def __init__(self, settings: RobotSettings, fire: Callable[[int], float | None]) -> None:
        self._settings = settings
        self._fire = fire
        self._cycle_ns = settings.sonar_cycle_ms * 1_000_000
        self._sequences = _default_sequences(settings.sonar_discs)
        self._silenced = False
        self._epoch_ns: int | None = None
        self._firings = 0
        self._fresh: dict[int, Echo] = {}

    @property
    def on(self) -> bool:
        """Whether sonar are switched on: the flag bit of the SIP."""
        return self._epoch_ns is not None

    def switch(self, on: bool, now_ns: int) -> None:
        """SONAR 1 or 0. The first disc fires one cycle after switching on; switching off discards unsent readings."""
        if on:
            self._silenced = False
            if self._epoch_ns is None:
                self._epoch_ns, self._firings = now_ns, 0
            return
        self._epoch_ns = None
        self._fresh.clear()

    def reset(self) -> None:
        """All fitted discs in their factory order again (a session begins)."""
        self._sequences = _default_sequences(self._settings.sonar_discs)
        self._silenced = False

    def poll(self, numbers: bytes) -> None:
        """POLLING: 1-based disc numbers in firing order.

        Only the arrays that are named get a new sequence; an empty string silences all discs and leaves the sequences
        as they are (Pioneer 2/3 H8 Operations Manual, POLLING).
        """
        self._silenced = not numbers
        self._fresh.clear()
        for array in {(number - 1) // ARRAY for number in numbers if number}:
            members = [number - 1 for number in numbers if number and (number - 1) // ARRAY == array]
            self._sequences[array] = tuple(members[:MOST_PER_ARRAY])

    def next_deadline_ns(self) -> int | None:
        """When the next discs fire, None when switched off."""
        if self._epoch_ns is None:
            return None
        return self._epoch_ns + (self._firings + 1) * self._cycle_ns

    def advance(self) -> None:
        """Fire the disc of each array whose turn it is."""
        turn = self._firings
        self._firings += 1
        if self._silenced:
            return
        for _, sequence in sorted(self._sequences.items()):
            disc = sequence[turn % len(sequence)]
            if disc in self._settings.sonar_discs:
                self._take(disc)

    def take_fresh(self) -> tuple[Echo, ...]:
        """Take the readings that are new, oldest first, at most 16; the rest stay for the next SIP."""
        taken = tuple(self._fresh.values())[:MOST_PER_SIP]
        for echo in taken:
            del self._fresh[echo.disc]
        return taken

    def _take(self, disc: int) -> None:
        range_m = self._fire(disc)
        range_mm = self._settings.sonar_no_echo_mm if range_m is None else range_m * 1000
        self._fresh.pop(disc, None)
        self._fresh[disc] = Echo(disc=disc, range_mm=range_mm)


def _default_sequences(discs: tuple[int, ...]) -> dict[int, tuple[int, ...]]:
    """Ascending order in each array (choice; the factory order is not published)."""
    arrays = sorted({disc // ARRAY for disc in discs})
    return {array: tuple(disc for disc in sorted(discs) if disc // ARRAY == array) for array in arrays}
