"""A demo in the dashboard: a script drives the bench and runs checks, a caption says what happens."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Mapping, Sequence

from rich.text import Text
from textual.app import ComposeResult
from textual.binding import Binding

from hilbench.exit_codes import ExitCode
from hilbench.plugins.demo import Check, Demo, LiveBench, Scene
from hilbench.tui.app import Dashboard
from hilbench.tui.bench_process import BenchProcess, Phase
from hilbench.tui.check_run import CheckRun
from hilbench.tui.checks_pane import ChecksPane
from hilbench.tui.lines import Lines
from hilbench.tui.model.playing import Playing, Seen, figures
from hilbench.tui.views.caption import caption_keys, caption_of, caption_view, words_of

__all__ = ["DemoDashboard"]

_COMMAND_COLUMNS = 76
"""Of the command of a check, so that it fits into a pane of 80 columns."""
OpenBench = Callable[[LiveBench], BenchProcess]


class Caption(Lines):
    """What happens, below the panes.

    Attributes:
        text: what it says.
    """

    def __init__(self) -> None:
        super().__init__("caption")
        self.text = ""

    def lines_for(self, width: int, height: int) -> Sequence[Text]:
        """Return the lines."""
        return caption_view(self.text, width, height)


class DemoDashboard(Dashboard, inherit_bindings=False):
    """See the module.

    Args:
        demo: the script.
        process: the bench of its first scene.
        start: starts the bench of a later one.
        theme: the theme; empty for the default one.
        ticking: whether it looks at the bench by itself; a test does it by hand.

    Attributes:
        playing: the place in the script.
        problem: why the demo cannot go on; empty while it can.
    """

    CSS = """
    Caption { height: 5; border: heavy $accent; border-title-color: $accent; border-title-style: bold; padding: 0 1; }
    KeyLine { display: none; }
    """
    ENABLE_COMMAND_PALETTE = False
    BINDINGS = [
        Binding("space", "hold", "Pause"),
        Binding("n,right", "skip", "Next"),
        Binding("q,ctrl+q", "end", "Quit"),
        Binding("ctrl+c", "interrupt", show=False, priority=True),
    ]

    def __init__(
        self, demo: Demo, process: BenchProcess, start: OpenBench, *, theme: str = "", ticking: bool = True
    ) -> None:
        super().__init__(process, theme=theme, ticking=ticking)
        self.playing = Playing(demo)
        self.problem = ""
        self._start = start
        self._shown: tuple[str, ...] = ()
        self._asks: list[Mapping[str, object]] = []
        self._played_s: float | None = None
        self._resumes = False

    def compose(self) -> ComposeResult:
        """Put the caption below the panes; it has the keys, too."""
        yield from super().compose()
        yield Caption()

    def look(self) -> None:
        """See `Watching`; then let the script go on."""
        super().look()
        now_s = self.stopwatch.elapsed_s()
        if self._played_s is None:
            self.begin(self.playing.scene)
            self._played_s = now_s
        by_s, self._played_s = now_s - self._played_s, now_s
        self._ask()
        if self.process.phase is Phase.ENDED:
            self.problem = self.process.cause
            self.leave(ExitCode.UNAVAILABLE)
        elif self.playing.play(by_s, self._seen()):
            if self.playing.go_on(self._seen()):
                self.begin(self.playing.scene)
            else:
                self.action_end()
        self._caption()

    def show(self) -> None:
        """See `Watching`; what says elsewhere which keys to press is hidden, for here they do nothing."""
        super().show()
        for guide in self.query("#guide"):
            guide.display = False

    def available(self) -> list[str]:
        """Return the panes of the scene that have something to show."""
        there = super().available()
        return [name for name in self._shown if name in there] or there

    # --- scenes

    def begin(self, scene: Scene) -> None:
        """Begin a scene; the bench of the first one has been started already."""
        if scene.bench is not None and self.playing.number:
            before = self.process
            self.open(self._start(scene.bench))
            before.stop()
        self._asks = list(scene.asks)
        self._shown = scene.panes or self._shown
        if scene.check is not None:
            self._check(scene.check)
        self.zoomed = scene.panes[0] if len(scene.panes) == 1 else "" if scene.panes else self.zoomed

    def _check(self, check: Check) -> None:
        """Run a check, and show its first clause whole."""
        self.run_of_suite = run = CheckRun(check.bench, check.suite, check.select, check.more)
        run.text = "\n".join(textwrap.wrap(check.command, _COMMAND_COLUMNS)) + "\n"
        pane = self.query_one(ChecksPane)
        pane.take(run.checks, run.title, "", ended=False)
        pane.chosen, pane.opened = next(iter(check.verdicts)), True

    def _ask(self) -> None:
        """Request what the scene asks for, as soon as its bench is live."""
        if self.process.phase is Phase.LIVE:
            for asked in self._asks:
                self.process.send(str(asked["do"]), **{name: of for name, of in asked.items() if name != "do"})
            self._asks.clear()

    def _seen(self) -> Seen:
        model, run = self.model, self.run_of_suite
        return Seen(
            ns=0 if model is None else model.ns,
            live=self.process.phase is Phase.LIVE and model is not None,
            checked=run is None or run.code is not None,
            figures={name: values for name, (values, _) in figures(model).items()},
            verdicts={} if run is None else {row.id: row.state for row in run.checks.rows.values()},
        )

    def _caption(self) -> None:
        caption, playing = self.query_one(Caption), self.playing
        run = self.run_of_suite
        caption.text = caption_of(
            playing.scene.text, words_of(playing, self.model, None if run is None else run.checks)
        )
        caption.border_title = playing.scene.title
        caption.border_subtitle = caption_keys(playing)
        caption.look()

    def leave(self, code: ExitCode) -> None:
        """End the bench and the demo."""
        self.process.stop()
        self.exit(return_code=code)

    # --- keys

    def action_hold(self) -> None:
        """Let demo and bench stand still, or go on."""
        playing, model = self.playing, self.model
        if not playing.paused:
            self._resumes = model is not None and not model.paused
        if self._resumes:
            self.process.send("resume" if playing.paused else "pause")
        playing.paused = not playing.paused
        self._caption()

    def action_skip(self) -> None:
        """Go to the next scene, once what this one waits for is there."""
        if self.playing.paused:
            self.action_hold()
        self.playing.skip()
        self.look()

    def action_end(self) -> None:
        """End the demo."""
        self.leave(ExitCode.INCONCLUSIVE if self.playing.broken else ExitCode.OK)

    def action_interrupt(self) -> None:
        """End the demo, as Ctrl-C ends every command."""
        self.leave(ExitCode.INTERRUPTED)
