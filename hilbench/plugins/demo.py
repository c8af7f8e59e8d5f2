"""The script of a demo, which a system may bring: scenes that play one after the other in the dashboard.

Everything in a demo happens: benches are live, checks are run. A caption fills in what was measured, and what a scene
claims is looked at when it ends.
"""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

__all__ = ["Check", "Demo", "LiveBench", "Scene"]


@dataclass(frozen=True, slots=True, kw_only=True)
class LiveBench:
    """A bench that a scene opens.

    Attributes:
        bench: the name of a bench, or the path of its file.
        changes: what is different from the file, as ``hilbench check --set`` takes it.
    """

    bench: str
    changes: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Check:
    """A check that a scene runs on a fresh bench, in virtual time.

    Attributes:
        bench: the name of a bench, or the path of its file.
        suite: the suite.
        select: which of its cases, as for ``-k``.
        more: more options of ``hilbench check``.
        verdicts: the verdict that each clause must get, by its id.
    """

    bench: str
    suite: str
    select: str
    more: tuple[str, ...] = ()
    verdicts: Mapping[str, str]

    @property
    def command(self) -> str:
        """The command line that runs it."""
        words = ["hilbench", "check", self.bench, "--suite", self.suite, "-k", self.select, *self.more]
        return f"$ {shlex.join(words)}"


@dataclass(frozen=True, slots=True, kw_only=True)
class Scene:
    """A step of a demo, with one caption.

    A scene with a bench lasts until that is live, a scene with a check until that has ended.

    Attributes:
        title: a few words.
        text: what happens and why it matters; about 220 characters, so that it fits below an 80-column dashboard.
            These are filled in: ``{speed}`` and every other plotted signal, by its name, with its unit; ``{faults}``,
            how many faults have struck; ``{since}``, the bench time since something was last requested; ``{verdict}``
            and ``{cause}`` of the check.
        lasts_s: how long it stays at least, in seconds on the wall clock, pauses not counted.
        bench_s: how much bench time it takes at least, in seconds: on a slow computer it stays longer.
        panes: the panes that are shown; those of the scene before if empty.
        bench: the bench to open in place of the one before; None to continue with that.
        check: the check to run; None for none. The bench should be paused meanwhile.
        asks: the actions that are requested of the bench when the scene begins, as the dashboard requests them.
        claims: the range of a signal's magnitude at the end of the scene, by its name: lowest and highest value.
    """

    title: str
    text: str
    lasts_s: float
    bench_s: float = 0.0
    panes: tuple[str, ...] = ()
    bench: LiveBench | None = None
    check: Check | None = None
    asks: tuple[Mapping[str, object], ...] = ()
    claims: Mapping[str, tuple[float, float]] = field(default_factory=lambda: MappingProxyType({}))


@dataclass(frozen=True, slots=True, kw_only=True)
class Demo:
    """A demo.

    Attributes:
        title: what it shows, in a few words.
        scenes: one after the other.
        after: what is printed at the end: commands to continue with, one a line.

    Raises:
        ValueError: the first scene opens no bench.
    """

    title: str
    scenes: tuple[Scene, ...]
    after: str = ""

    def __post_init__(self) -> None:
        if not self.scenes or self.scenes[0].bench is None:
            raise ValueError("the first scene of a demo opens a bench")

    @property
    def opening(self) -> LiveBench:
        """The bench of the first scene."""
        bench = self.scenes[0].bench
        assert bench is not None
        return bench
