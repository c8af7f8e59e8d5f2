"""A slotted disc on a wheel's shaft and the forked light barrier with an LM393 that counts its slots.

A slot begins with a falling edge, in whichever direction the wheel turns; there is one for each slot, and no telling
forward from backward. Within a physics step the wheel is taken to turn evenly, and each edge is put on the wire at its
exact time.

What goes wrong with such barriers are settings, all off: a comparator without hysteresis that gives several pulses at
the edge of a slot, slots that are not seen, and pulses out of nothing that motors induce. What is random follows from
the seed and from how many slots and pulses there were before, so the same turns give the same edges however they are
cut. What is not modelled: `TachometerDisc.ABSENT`.
"""

from __future__ import annotations

import math
import random
from collections import deque
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from targets.parts.part import Direction, Part, Ports, Quantity, Terminal
from targets.parts.settings import check_settings, setting

__all__ = ["TachometerDisc", "TachometerSettings"]

_US = 1_000
_S = 1_000_000_000

_MOST_EDGES = 1_000
"""More than so many in one physics step is no rotation but a wheel that was put elsewhere (choice)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TachometerSettings:
    """The disc, and what is wrong with the barrier.

    Raises:
        ValueError: a value makes no tachometer.
    """

    slots: int = setting(
        20, "slots", "PKT! rover, final firmware; 32 in ceai2020 commit de8cdae of August 2021", least=1, greatest=1000
    )
    slot_width: float = setting(
        0.5, "of the pitch", "assumed: slots as wide as the teeth between them", least=0.05, greatest=0.95
    )
    phase: float = setting(
        0.75,
        "of the pitch",
        "choice: where the disc stands at angle 0, from the edge of a slot",
        least=0.0,
        greatest=1.0,
    )
    extra_pulses: int = setting(
        0, "pulses a slot", "choice; 1 counts double, 7 as the right front one of the original's notebooks", least=0
    )
    extra_spacing_us: float = setting(100.0, "us", "assumed: half a period of what the comparator does", least=1.0)
    missed: float = setting(0.0, "of 1", "choice: chance that a slot is not seen", least=0.0, greatest=1.0)
    spurious_hz: float = setting(0.0, "1/s", "choice: mean rate of pulses out of nothing", least=0.0, greatest=1e5)
    spurious_us: float = setting(20.0, "us", "assumed: length of such a pulse", least=1.0)

    def __post_init__(self) -> None:
        check_settings(self)


class TachometerDisc(Part):
    """See the head of this file.

    Attributes:
        pulses: how many falling edges it has given.
    """

    TERMINALS = (Terminal(name="out", direction=Direction.OUT, needed=True, text="low: light through a slot"),)
    QUANTITIES = (Quantity(name="angle", direction=Direction.IN, unit="rad", text="of the wheel, not wrapped"),)
    ABSENT = ("slots that are not all alike", "slow edges and the open collector of an LM393", "light from outside")
    Settings = TachometerSettings

    def __init__(self, settings: TachometerSettings, ports: Ports, *, seed: int) -> None:
        self._output = ports.output("out")
        self._comparator = _Comparator(settings, random.Random(f"{seed} slots"))
        self._noise = _Noise(settings, random.Random(f"{seed} noise"))
        self._level = True
        self.pulses = 0

    def power_on(self, now_ns: int) -> None:
        """Begin with the level of a wheel at angle 0."""
        self._comparator.begin()
        self._noise.begin(now_ns)
        self._level = self._comparator.level
        self._output.set(self._level, now_ns)

    def after_step(self, from_ns: int, to_ns: int, before: Mapping[str, float], after: Mapping[str, float]) -> None:
        """Put every edge of the step on the wire at its exact time."""
        edges = self._comparator.edges(before.get("angle", math.nan), after.get("angle", math.nan), from_ns, to_ns)
        flips: list[tuple[int, bool | None]] = [(ns, None) for ns in self._noise.flips(to_ns)]
        inverted = self._noise.inverted
        level = self._comparator.level
        for ns, changed in sorted((*edges, *flips), key=lambda event: event[0]):
            if changed is None:
                inverted = not inverted
            else:
                level = changed
            self._show(level is not inverted, max(ns, from_ns))
        self._comparator.level, self._noise.inverted = level, inverted

    def _show(self, level: bool, at_ns: int) -> None:
        if level is not self._level:
            self._level = level
            self.pulses += not level
            self._output.set(level, at_ns)


class _Comparator:
    """From angles to what the comparator says. Intervals are numbered: even ones are slots, odd ones teeth.

    Attributes:
        level: what it says now; kept by the caller.
    """

    def __init__(self, settings: TachometerSettings, chance: random.Random) -> None:
        self._settings = settings
        self._chance = chance
        self.begin()

    def begin(self) -> None:
        """Stand at angle 0."""
        self._interval = self._interval_at(0.0)
        self._hidden = False
        self._extra: deque[tuple[int, bool]] = deque()
        self.level = bool(self._interval & 1)

    def edges(self, start_rad: float, end_rad: float, from_ns: int, to_ns: int) -> list[tuple[int, bool]]:
        """Turn evenly from one angle to another; return the edges up to the end of that time, in order."""
        found: list[tuple[int, bool]] = []
        for ns, interval in self._entered(start_rad, end_rad, from_ns, to_ns):
            self._interval = interval
            is_slot = not interval & 1
            if is_slot:
                self._hidden = self._chance.random() < self._settings.missed
            if self._hidden:
                continue
            found += self._take_extra(ns - 1)
            self._extra.clear()  # what is left of the pulses at the last edge ends here
            found.append((ns, not is_slot))
            if is_slot:
                self._extra.extend(self._pulses_after(ns))
        return found + self._take_extra(to_ns)

    def _entered(self, start_rad: float, end_rad: float, from_ns: int, to_ns: int) -> Iterator[tuple[int, int]]:
        """When which interval is entered."""
        if not (math.isfinite(start_rad) and math.isfinite(end_rad)):
            return
        start, end = self._interval_at(start_rad), self._interval_at(end_rad)
        if start != self._interval:
            yield from_ns, start
        if abs(end - start) > _MOST_EDGES:
            yield to_ns, end
            return
        way = 1 if end > start else -1
        for interval in range(start + way, end + way, way) if end != start else ():
            boundary_rad = self._boundary_rad(max(interval, interval - way))
            part = min(1.0, max(0.0, (boundary_rad - start_rad) / (end_rad - start_rad)))
            yield from_ns + math.ceil((to_ns - from_ns) * part), interval

    def _interval_at(self, angle_rad: float) -> int:
        pitches = angle_rad * self._settings.slots / math.tau + self._settings.phase
        whole = math.floor(pitches)
        return 2 * whole + (pitches - whole >= self._settings.slot_width)

    def _boundary_rad(self, interval: int) -> float:
        """The angle at which an interval begins."""
        pitches = interval // 2 + (self._settings.slot_width if interval & 1 else 0.0)
        return (pitches - self._settings.phase) * math.tau / self._settings.slots

    def _take_extra(self, until_ns: int) -> list[tuple[int, bool]]:
        taken = []
        while self._extra and self._extra[0][0] <= until_ns:
            taken.append(self._extra.popleft())
        return taken

    def _pulses_after(self, ns: int) -> Iterator[tuple[int, bool]]:
        spacing_ns = round(self._settings.extra_spacing_us * _US)
        for number in range(2 * self._settings.extra_pulses):
            yield ns + spacing_ns * (number + 1), number % 2 == 0


class _Noise:
    """Pulses out of nothing: gaps of random length, pulses of a fixed one.

    Attributes:
        inverted: whether one is on; kept by the caller.
    """

    def __init__(self, settings: TachometerSettings, chance: random.Random) -> None:
        self._settings = settings
        self._chance = chance
        self._next_ns: int | None = None
        self._ends = False
        self.inverted = False

    def begin(self, now_ns: int) -> None:
        """Draw the first gap."""
        self._ends, self.inverted = False, False
        self._next_ns = now_ns + self._gap_ns() if self._settings.spurious_hz else None

    def flips(self, until_ns: int) -> Iterator[int]:
        """Yield when a pulse begins or ends, up to a time."""
        while self._next_ns is not None and self._next_ns <= until_ns:
            yield self._next_ns
            self._ends = not self._ends
            self._next_ns += round(self._settings.spurious_us * _US) if self._ends else self._gap_ns()

    def _gap_ns(self) -> int:
        return math.ceil(self._chance.expovariate(self._settings.spurious_hz) * _S)
