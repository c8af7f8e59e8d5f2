"""What every dashboard does, whatever it looks like: it follows a bench, or a place in a recording."""

from __future__ import annotations

from typing import Literal

from textual.app import App

from hilbench.clock import Stopwatch
from hilbench.tui.bench_process import BenchProcess, Phase
from hilbench.tui.model.bench import BenchModel
from hilbench.tui.model.follower import Follower
from hilbench.tui.model.replay import NS_PER_S, Replay
from hilbench.tui.recorded import RecordedBench
from hilbench.tui.views.status import clock_words
from hilbench.tui.views.words import seconds

__all__ = ["Watching"]

_MOST_S = 0.06
"""How long a look reads a journal or a recording at most, in seconds of host time: keys are to be heard (choice)."""
_MUCH_BYTES = 2_000_000
_LOSING_LOOKS = 20
"""Whoever has more than so much to read, and more each time for so many looks, will not catch up (choices)."""
_KEPT_BYTES = 500_000


class Watching(App[None]):
    """See the module.

    Args:
        process: the bench, or a recording.
        replay: the recording's events and the place in it; None of a bench that runs.

    Attributes:
        model: what is known of the bench; None before anything is.
        passed_over: bytes of the journal that were not read, because they came faster than they can be shown.
    """

    def __init__(self, process: BenchProcess | RecordedBench, replay: Replay | None) -> None:
        super().__init__()
        self.process = process
        self.replay = replay
        self.model: BenchModel | None = None
        self.stopwatch = Stopwatch()
        self._follower: Follower | None = None
        self._looked_s = 0.0
        self._waiting = 0
        self._losing = 0
        self._most_s = _MOST_S
        self.passed_over = 0

    def on_unmount(self) -> None:
        """Let go of the journal."""
        self.forget()

    def open(self, process: BenchProcess | RecordedBench, replay: Replay | None = None) -> None:
        """Watch another bench, or a recording."""
        self.forget()
        self.process, self.replay = process, replay
        self.passed_over = self._waiting = self._losing = 0

    def forget(self) -> None:
        """Know nothing of the bench any more."""
        self.model = None
        if self._follower is not None:
            self._follower.close()
        self._follower = None

    def look(self) -> None:
        """Take what the bench has reported since the last time, and show it."""
        for refused in self.process.poll():
            self.say(refused, severity="warning")
        if self.replay is not None:
            self._play(self.replay)
        elif self._follower is None and self.process.phase is not Phase.STARTING:
            self._follower = Follower(self.process.journal)
        if self._follower is not None:
            self._take(self._follower)
        self.show()

    def say(self, text: str, *, severity: Literal["information", "warning", "error"] = "information") -> None:
        """Say something for some seconds; brackets in it are brackets, and no markup."""
        self.notify(text, severity=severity, markup=False)

    def show(self) -> None:
        """Show what is known."""
        raise AssertionError("each kind of watcher shows it in its own way")

    def _play(self, replay: Replay) -> None:
        now_s = self.stopwatch.elapsed_s()
        replay.play(now_s - self._looked_s)
        self._looked_s = now_s
        self.work(replay)
        if replay.problem and isinstance(self.process, RecordedBench):
            self.process.break_off(replay.problem)
        self.model = replay.model

    def work(self, replay: Replay) -> None:
        """Let a recording read, or go to its place, for as long as nobody minds."""
        watch = Stopwatch()
        replay.work(lambda: watch.elapsed_s() >= self._most_s)

    def _take(self, follower: Follower) -> None:
        watch = Stopwatch()
        while watch.elapsed_s() < self._most_s:
            events = follower.news()
            if self.model is None and follower.header:
                self.model = BenchModel(follower.header)
                self.refresh_bindings()
            if not events or self.model is None:
                break
            self.model.take(events)
        self._keep_up(follower)

    def _keep_up(self, follower: Follower) -> None:
        """Pass over what is old rather than show an ever older bench; the bench itself is never slowed."""
        waiting = follower.waiting
        self._losing = self._losing + 1 if waiting > max(self._waiting, _MUCH_BYTES) else 0
        if self._losing >= _LOSING_LOOKS:
            self.passed_over += follower.pass_over(_KEPT_BYTES)
            self._losing = 0
        self._waiting = waiting

    # --- in words

    def _headline(self) -> str:
        """Return bench time, how it passes, and how the bench and its journal are."""
        model = self.model
        if model is None:
            return f"{self.process.phase.value} ..."
        if self.replay is not None:
            how = "plays" if self.replay.playing else "recorded"
            reads = f"[{self.replay.progress}]  " if self.replay.progress else ""
            return f"{reads}{seconds(model.ns)} of {seconds(self.replay.length_ns)}  {how}"
        state = "" if self.process.phase is Phase.LIVE else f"[{self.process.phase.value}]"
        passed = f"{self.passed_over / 1e6:.1f} MB passed over" if self.passed_over else ""
        return "  ".join(filter(None, (passed, state, clock_words(model), seconds(model.ns))))

    def _epitaph(self) -> str:
        """Return why the bench has ended and where its journal is; of one that ended well it goes with its folder."""
        process = self.process
        where = "" if process.ended_well or not process.journal.exists() else f" Journal: {process.journal}."
        ways = "q leaves" if self.replay is not None else "b opens a bench, q leaves"
        return f"{process.cause}.{where} What was recorded stays here; {ways}."

    # --- recordings

    def action_play(self) -> None:
        """Let the recording go on, or stand still."""
        if self.replay is not None:
            self.replay.playing = not self.replay.playing
            self.look()

    def action_go(self, by_s: int) -> None:
        """Go on in a recording by seconds, or back."""
        if self.replay is not None:
            self.replay.go_by(by_s * NS_PER_S)
            self.look()

    def action_event(self, by: int) -> None:
        """Go on in a recording by events, or back."""
        if self.replay is not None:
            self.replay.step(by)
            self.look()

    def action_error(self, way: int) -> None:
        """Go to the next error of a recording, or the one before."""
        if self.replay is not None:
            if not self.replay.to_error(way):
                more = "no more errors so far: it is still read" if self.replay.reading else "no more errors"
                self.say(more if way > 0 else "no error before this")
            self.look()
