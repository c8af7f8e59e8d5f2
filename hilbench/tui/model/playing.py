"""The place in a demo: which scene plays, and when the next one begins. It knows of no screen and no process."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from hilbench.plugins.demo import Demo, Scene
from hilbench.tui.model.bench import BenchModel

__all__ = ["Playing", "Seen", "figures"]

_NS_PER_S = 1_000_000_000


@dataclass(frozen=True, slots=True, kw_only=True)
class Seen:
    """What is known of bench and check.

    Attributes:
        ns: the bench time.
        live: whether the bench that the scene has opened, or one before, is live.
        checked: whether no check runs.
        figures: the latest values of each signal, by its name.
        verdicts: the verdict of each clause that was checked last, by its id.
    """

    ns: int = 0
    live: bool = True
    checked: bool = True
    figures: Mapping[str, tuple[float, ...]]
    verdicts: Mapping[str, str]


class Playing:
    """See the module.

    Args:
        demo: the script.

    Attributes:
        number: of the scene, from 0.
        paused: whether time stands still for the demo.
        skipped: the scene ends as soon as what it waits for is there.
        broken: what scenes claimed and what was not so, one line each.
    """

    def __init__(self, demo: Demo) -> None:
        self.demo = demo
        self.number = 0
        self.paused = False
        self.broken: list[str] = []
        self._played_s = 0.0
        self.skipped = False
        self._began_ns = 0
        self._asked_ns = 0

    @property
    def scene(self) -> Scene:
        """The scene that plays."""
        return self.demo.scenes[self.number]

    @property
    def left_s(self) -> float:
        """How long the demo takes from here at least, in seconds."""
        later = sum(scene.lasts_s for scene in self.demo.scenes[self.number + 1 :])
        return max(0.0, self.scene.lasts_s - self._played_s) + later

    def since_s(self, ns: int) -> float:
        """Return the bench time since something was last requested, in seconds."""
        return max(0, ns - self._asked_ns) / _NS_PER_S

    def skip(self) -> None:
        """End the scene as soon as what it waits for is there."""
        self.skipped = True
        self.paused = False

    def play(self, by_s: float, seen: Seen) -> bool:
        """Let time pass; say whether the scene is over.

        Args:
            by_s: seconds on the wall clock since the last time.
            seen: what is known now.
        """
        if self.paused:
            return False
        self._played_s += by_s
        waits = (self.scene.bench is not None and not seen.live) or (self.scene.check is not None and not seen.checked)
        bench_s = (seen.ns - self._began_ns) / _NS_PER_S
        played = self._played_s >= self.scene.lasts_s and bench_s >= self.scene.bench_s
        return not waits and (played or self.skipped)

    def go_on(self, seen: Seen) -> bool:
        """End the scene: see whether what it claims is so, and begin the next one; False if there is none."""
        self.broken += [f"scene '{self.scene.title}': {what}" for what in self._wrong(seen)]
        if self.number + 1 == len(self.demo.scenes):
            return False
        self.number += 1
        self._played_s = 0.0
        self.skipped = False
        self._began_ns = 0 if self.scene.bench is not None else seen.ns
        if self.scene.asks or self.scene.bench is not None:
            self._asked_ns = self._began_ns
        return True

    def _wrong(self, seen: Seen) -> list[str]:
        wrong = []
        if self.scene.check is not None:
            for clause, verdict in self.scene.check.verdicts.items():
                found = seen.verdicts.get(clause, "not run")
                if found != verdict:
                    wrong.append(f"the verdict of {clause} is '{found}', expected '{verdict}'")
        for name, (low, high) in () if self.skipped else self.scene.claims.items():
            values = seen.figures.get(name, ())
            if not values or not all(low <= abs(value) <= high for value in values):
                shown = ", ".join(f"{value:.3g}" for value in values) or "not known"
                wrong.append(f"{name} is {shown}, expected {low:g} to {high:g} either way")
        return wrong


def figures(model: BenchModel | None) -> dict[str, tuple[tuple[float, ...], str]]:
    """Return the latest values and the unit of each signal of a bench; the duty of a pin at rest is 0 or 100 %."""
    if model is None:
        return {}
    signals = model.signals.signals
    found = {name: (tuple(points[-1][1] for points in one.parts if points), one.unit) for name, one in signals.items()}
    for pin in model.pins.pins.values():
        if f"{pin.pin} duty" in found:
            wave = pin.wave(model.ns)
            found[f"{pin.pin} duty"] = ((100 * wave[1] / wave[0] if wave else 100.0 * bool(pin.level),), "%")
    return found
