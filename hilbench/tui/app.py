"""The dashboard on a terminal: panes around one model, keys that ask the bench for something."""

from __future__ import annotations

import asyncio
import signal
from collections.abc import Callable, Iterable
from pathlib import Path

from textual.app import App, ComposeResult, SystemCommand
from textual.containers import Horizontal, Vertical
from textual.screen import Screen
from textual.widgets import Footer, Static

from hilbench.clock import Stopwatch
from hilbench.tui.bench_process import BenchProcess, Phase
from hilbench.tui.check_run import CheckRun
from hilbench.tui.dialogs import CheckScreen, HelpScreen, InjectScreen, LeaveScreen, PickScreen, WordScreen
from hilbench.tui.keys import BY_NAME, KEYS, NEEDS, OF_RECORDINGS
from hilbench.tui.model.bench import BenchModel
from hilbench.tui.model.follower import Follower
from hilbench.tui.model.replay import NS_PER_S, Replay
from hilbench.tui.model.stick import Stick
from hilbench.tui.panes import FramesPane, Pane, Strip, pane_names
from hilbench.tui.recorded import RecordedBench
from hilbench.tui.views.words import seconds

__all__ = ["FRAMES_PER_S", "Dashboard"]

FRAMES_PER_S = 10
_WIDE = 132
_MOST_BATCHES = 8
OpenBench = Callable[[str], BenchProcess]


class Dashboard(App[None]):
    """See the module.

    Args:
        process: the bench, or a recording.
        replay: the recording's events and the place in it; None of a bench that runs.
        benches: the benches that can be opened instead, by name and what they are.
        open_bench: opens one of them.
        ticking: whether it looks at the bench by itself; a test does it by hand.
    """

    CSS_PATH = "dashboard.tcss"
    TITLE = "hilbench"
    BINDINGS = KEYS

    def __init__(
        self,
        process: BenchProcess | RecordedBench,
        replay: Replay | None = None,
        *,
        benches: Iterable[tuple[str, str]] = (),
        open_bench: OpenBench | None = None,
        ticking: bool = True,
    ) -> None:
        super().__init__()
        self.process = process
        self.replay = replay
        self.model: BenchModel | None = None
        self.zoomed = ""
        self._benches = list(benches)
        self._open_bench = open_bench
        self._ticking = ticking
        self._follower: Follower | None = None
        self._stick = Stick()
        self._watch = Stopwatch()
        self._looked_s = 0.0
        self._arranged = ""

    def compose(self) -> ComposeResult:
        """Put the panes into three columns; how they are shared out is `_arrange`'s business."""
        yield Static(id="head")
        yield Static(id="ended")
        with Horizontal(id="body"):
            with Vertical(id="left"):
                yield Pane("link")
                yield Pane("timers")
                yield Pane("counters")
            with Vertical(id="middle"):
                yield Pane("world")
                yield FramesPane()
            with Vertical(id="right"):
                yield Pane("states")
                yield Pane("pins")
                yield Pane("log")
        yield Strip()
        yield Footer(compact=True, show_command_palette=False)

    def on_mount(self) -> None:
        """Begin to look. A signal that ends the process gives the terminal back first."""
        self._arrange()
        if self._ticking:
            self.set_interval(1 / FRAMES_PER_S, self.look)
            for number in (signal.SIGTERM, signal.SIGHUP):
                asyncio.get_running_loop().add_signal_handler(number, self.exit)
        self.look()

    def on_unmount(self) -> None:
        """Let go of the journal."""
        if self._follower is not None:
            self._follower.close()

    # --- what is seen

    def look(self) -> None:
        """Take what the bench has told since the last time, and show it."""
        for refused in self.process.poll():
            self.notify(refused, severity="warning")
        if self.replay is not None:
            self._play(self.replay)
        elif self._follower is None and self.process.phase is not Phase.STARTING:
            self._follower = Follower(self.process.journal)
        if self._follower is not None:
            self._take(self._follower)
        if isinstance(self.screen, CheckScreen):
            self.screen.look()
        self._show()

    def _play(self, replay: Replay) -> None:
        now_s = self._watch.elapsed_s()
        replay.play(now_s - self._looked_s)
        self._looked_s = now_s
        self.model = replay.model

    def _take(self, follower: Follower) -> None:
        for _ in range(_MOST_BATCHES):
            events = follower.news()
            if self.model is None and follower.header:
                self.model = BenchModel(follower.header)
                self._arranged = ""
                self.refresh_bindings()
            if not events or self.model is None:
                return
            self.model.take(events)

    def _show(self) -> None:
        self._arrange()
        for pane in self.query(Pane):
            pane.model = self.model
            if pane.display:
                pane.refresh()
        strip = self.query_one(Strip)
        strip.model = self.model
        strip.refresh()
        self.query_one("#head", Static).update(self._headline())
        ended = self.query_one("#ended", Static)
        ended.display = self.process.phase is Phase.ENDED
        if ended.display:
            ended.update(self._epitaph().replace("[", "\\["))

    def _epitaph(self) -> str:
        """Return why the bench has ended and where its journal is; of one that ended well it goes with its folder."""
        process = self.process
        where = "" if process.ended_well else f" Journal: {process.journal}."
        return f"{process.cause}.{where} What was told stays here; b opens a bench, q leaves."

    def _headline(self) -> str:
        model = self.model
        if model is None:
            return f" hilbench  {self.process.phase.value} ..."
        if self.replay is not None:
            how = "plays" if self.replay.playing else "recorded"
            return f" hilbench  {model.name}  {seconds(model.ns)} of {seconds(self.replay.length_ns)}  {how}"
        clock = "PAUSED" if model.paused else "" if model.speed == 1 else f"{model.speed:g} x"
        state = "" if self.process.phase is Phase.LIVE else f"  [{self.process.phase.value}]"
        return f" hilbench  {model.name}  {seconds(model.ns)}  {clock}{state}".replace("[", "\\[")

    # --- arrangement

    def on_resize(self) -> None:
        """Share the room out anew."""
        self._arrange()

    def _arrange(self) -> None:
        """Show what there is room for: three columns, or the middle one alone, or one pane."""
        wide = self.size.width >= _WIDE
        has_world = self.model is None or bool(self.model.world.vehicle)
        has_pins = self.model is None or bool(self.model.pins.pins)
        arranged = f"{wide} {has_world} {has_pins} {self.zoomed}"
        if arranged == self._arranged:
            return
        self._arranged = arranged
        first = "world" if has_world else "link"
        shown = set(pane_names()) if wide else {first, "frames"}
        shown -= {"world"} if not has_world else set()
        shown -= {"pins"} if not has_pins else set()
        shown = {self.zoomed} if self.zoomed else shown
        for column in ("left", "middle", "right"):
            box = self.query_one(f"#{column}")
            box.display = any(pane.id in shown for pane in box.query(Pane))
        for pane in self.query(Pane):
            pane.display = pane.id in shown
        self.query_one(Strip).display = not wide or bool(self.zoomed)
        self.query_one("#body").set_class(not wide and not has_world and not self.zoomed, "stacked")

    def action_zoom(self, name: str) -> None:
        """Give a pane the whole screen, or take it back."""
        self.zoomed = "" if self.zoomed == name else name
        self._arrange()
        if self.zoomed:
            self.query_one(f"#{name}").focus()

    def action_unzoom(self) -> None:
        """Show all panes again."""
        self.zoomed = ""
        self._arrange()

    def on_pane_chosen(self, message: Pane.Chosen) -> None:
        """Give the pane that was clicked on the whole screen."""
        self.action_zoom(message.name)

    # --- what is asked of the bench

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        """Offer only what the bench can do."""
        del parameters
        needed = NEEDS.get(action)
        if needed is None:
            return self.replay is not None if action in OF_RECORDINGS else True
        return self.process.phase is Phase.LIVE and needed in self.process.actions

    def action_drive(self, axis: int, share: float) -> None:
        """Move the stick."""
        forward, turn = self._stick.press(int(axis), float(share), self._watch.elapsed_s())
        self.process.send("drive", forward=forward, turn=turn)

    def action_stop(self) -> None:
        """Stop the vehicle."""
        self._stick.release()
        self.process.send("stop")

    def action_demo(self) -> None:
        """Let the demo driver go on."""
        self.process.send("demo")

    def action_connect(self) -> None:
        """Connect."""
        self.process.send("connect")

    def action_disconnect(self) -> None:
        """Disconnect."""
        self.process.send("disconnect")

    def action_reset(self) -> None:
        """Press the reset button."""
        self.process.send("reset")

    def action_pause(self) -> None:
        """Let bench time stand still, or go on."""
        self.process.send("resume" if self.model is not None and self.model.paused else "pause")

    def action_step(self) -> None:
        """Go a tenth of a second further."""
        self.process.send("step", seconds=0.1)

    def action_faster(self) -> None:
        """Let bench time pass twice as fast."""
        self.process.send("speed", factor=min(16.0, 2 * (self.model.speed if self.model else 1.0)))

    def action_slower(self) -> None:
        """Let bench time pass half as fast."""
        self.process.send("speed", factor=max(1 / 16, 0.5 * (self.model.speed if self.model else 1.0)))

    def action_clear_faults(self) -> None:
        """Take all faults back."""
        self.process.send("clear-faults")

    def action_inject(self) -> None:
        """Ask for a fault and put it on the line."""

        def put(asked: dict[str, object] | None) -> None:
            if asked:
                self.process.send("inject", **asked)

        self.push_screen(InjectScreen(), put)

    def action_mark(self) -> None:
        """Ask for a word and put it into the journal."""

        def mark(word: str | None) -> None:
            if word is not None:
                self.process.send("mark", text=word)

        self.push_screen(WordScreen("Mark this moment as"), mark)

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

    def action_next_error(self) -> None:
        """Go to the next error of a recording."""
        if self.replay is not None:
            if not self.replay.next_error():
                self.notify("no more errors")
            self.look()

    # --- the rest

    def action_filter(self) -> None:
        """Ask for a filter of the frames."""
        frames = self.query_one(FramesPane)

        def filter_by(pattern: str | None) -> None:
            if pattern is not None:
                frames.filter(pattern)

        self.push_screen(WordScreen("Frames with (words, -word, > < !):", frames.pattern), filter_by)

    def action_picture(self) -> None:
        """Save the screen."""
        name = self.model.name.replace("/", "-") if self.model else "bench"
        at_ms = (self.model.ns if self.model else 0) // 1_000_000
        path = Path.cwd() / f"hilbench-{name}-{at_ms}ms.svg"
        try:
            path.write_text(self.export_screenshot(title=f"hilbench {name}"))
        except OSError as error:
            self.notify(f"{path}: {error.strerror}", severity="error")
        else:
            self.notify(f"saved {path}")

    def action_help(self) -> None:
        """Explain everything."""
        self.push_screen(HelpScreen())

    def action_pick(self) -> None:
        """Ask for another bench and open it."""

        def open_it(name: str | None) -> None:
            if name and self._open_bench is not None:
                self.process.stop()
                self.process = self._open_bench(name)
                self.model, self._arranged, self.zoomed = None, "", ""
                if self._follower is not None:
                    self._follower.close()
                self._follower = None
                self.look()

        self.push_screen(PickScreen("Open which bench? The present one is stopped.", self._benches), open_it)

    def action_check(self) -> None:
        """Ask for a suite and run it on a fresh bench of the same kind."""
        about = self.process.about
        suites = [(str(suite), "") for suite in about.get("suites", ())]
        if not suites:
            self.notify("this bench has no suite")
            return

        def run_it(suite: str | None) -> None:
            if suite:
                self.process.send("mark", text=f"suite {suite}")
                self.push_screen(CheckScreen(CheckRun(str(about["file"]), suite)))

        self.push_screen(PickScreen("Run which suite? The live bench goes on meanwhile.", suites), run_it)

    def action_leave(self) -> None:
        """Leave; a bench that runs is asked about."""
        if self.process.phase is Phase.ENDED or self.replay is not None:
            self.process.stop()
            self.exit()
            return

        def leave(answer: str | None) -> None:
            if answer == "stop":
                self.process.stop()
            elif answer == "detach":
                self.process.leave()
            else:
                return
            self.exit()

        self.push_screen(LeaveScreen(), leave)

    async def action_quit(self) -> None:
        """Leave, by the key and the command that Textual has for it."""
        self.action_leave()

    def get_system_commands(self, screen: Screen[object]) -> Iterable[SystemCommand]:
        """Offer every action by name in the command palette."""
        yield from super().get_system_commands(screen)
        for name, what in BY_NAME.items():
            if self.check_action(name, ()):
                yield SystemCommand(what, self._about(name), getattr(self, f"action_{name}"))

    def _about(self, name: str) -> str:
        return (getattr(self, f"action_{name}").__doc__ or "").strip()
