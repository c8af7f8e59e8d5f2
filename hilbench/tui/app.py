"""The dashboard on a terminal: panes around one model, keys that ask the bench for something."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from functools import partial

from textual.app import ComposeResult, SystemCommand
from textual.driver import Driver
from textual.screen import Screen
from textual.widgets import Static

from hilbench.errors import HilbenchError
from hilbench.plugins import dashboard as plugins
from hilbench.tui.bench_process import BenchProcess, Phase
from hilbench.tui.body import Body
from hilbench.tui.check_run import CheckRun
from hilbench.tui.checks_pane import ChecksPane
from hilbench.tui.compose import ComposeScreen
from hilbench.tui.dialogs import (
    HelpScreen,
    LeaveScreen,
    PanesScreen,
    PickScreen,
    SuiteScreen,
    ToggleScreen,
    WordScreen,
)
from hilbench.tui.fields_pane import FieldsPane
from hilbench.tui.frames_pane import FramesPane
from hilbench.tui.key_line import KeyLine
from hilbench.tui.keys import BY_NAME, KEYS, key_of, wanted_now
from hilbench.tui.memory import Memory
from hilbench.tui.messages_pane import MessagesPane
from hilbench.tui.model.arrangement import Arrangement, arrangement_of
from hilbench.tui.model.dashboards import ROBOT
from hilbench.tui.model.frames import FrameModel
from hilbench.tui.model.replay import Replay
from hilbench.tui.pad_hand import PadHand
from hilbench.tui.pads import Pads
from hilbench.tui.panes import PANES, Guide, Head, Pane, PlotsPane, Strip
from hilbench.tui.recorded import RecordedBench
from hilbench.tui.saving import Saving
from hilbench.tui.tables_pane import TablesPane
from hilbench.tui.terminal import Terminal, end_by_signals, terminal_driver
from hilbench.tui.theme import terminal_theme
from hilbench.tui.timeline import Timeline
from hilbench.tui.views.frames import fields_text
from hilbench.tui.views.head import guide_view
from hilbench.tui.views.help import help_text

__all__ = ["FRAMES_PER_S", "Dashboard"]

FRAMES_PER_S = 10
_LOOKS_ON_THE_WAY = 10
"""While a recording is on its way, all panes are drawn once in so many looks: drawing takes its time (choice)."""
_BREATH_S = 0.005
_WIDE = 132
_ROWS_OF_A_PANE = 11
"""On a screen that is not wide, a pane more for each so many rows; three at least (choice)."""
_SPECIAL: dict[str, Callable[[], Pane]] = {
    "frames": FramesPane,
    "plots": PlotsPane,
    "checks": ChecksPane,
    "messages": MessagesPane,
    "tables": TablesPane,
}
_OF_FIELDS: tuple[type[MessagesPane | TablesPane], ...] = (MessagesPane, TablesPane)
OpenBench = Callable[[str], BenchProcess]


class Dashboard(Saving):
    """See the module.

    Args:
        process: the bench, or a recording.
        replay: the recording's events and the place in it; None of a bench that runs.
        benches: the benches that can be opened instead, by name and what they are.
        open_bench: opens one of them.
        memory: what is remembered from the last time; None for nothing.
        pads: the game pads at this machine; those that there are if None, and none where it does not look by itself.
        ticking: whether it looks at the bench by itself; a test does it by hand.
        theme: the theme to begin with; empty for the one that is remembered.

    Attributes:
        zoomed: the pane that has all of the room; empty if none has.
        run_of_suite: the latest run of a suite; None before there was one.
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
        memory: Memory | None = None,
        pads: Pads | None = None,
        ticking: bool = True,
        theme: str = "",
    ) -> None:
        super().__init__(process, replay)
        self._pad = PadHand(pads or (Pads() if ticking else None))
        self.zoomed = ""
        self.run_of_suite: CheckRun | None = None
        self._benches = list(benches)
        self._open_bench = open_bench
        self._memory = memory or Memory()
        self._ticking = ticking
        self._hurries = False
        self._put_off = 0
        if not ticking:
            self._most_s = math.inf
        self._plots_of = ""
        self._known: tuple[object, ...] = ()
        self._said_of_end = ""
        chosen = theme or self._memory.theme
        if chosen in self.available_themes:
            self.theme = chosen
        self.watch_theme(self.theme)

    def compose(self) -> ComposeResult:
        """Put all panes into the body; it says where each is."""
        yield Head()
        yield Guide()
        yield Static(id="ended")
        panes = (_SPECIAL.get(name, partial(Pane, name))() for name in PANES)
        yield Body(*panes, arrangement=arrangement_of(ROBOT, wide=True))
        yield Strip()
        yield Timeline(self.replay).set_class(self.replay is not None, "recorded")
        yield KeyLine()

    def on_mount(self) -> None:
        """Begin to look. A signal that ends the process gives the terminal back first."""
        if self._ticking:
            self.set_interval(1 / FRAMES_PER_S, self._look_again)
            end_by_signals(self.exit)
        self.look()

    def on_unmount(self) -> None:
        """Let go of the game pad; end the suite that runs, if one does."""
        self._pad.close()
        if self.run_of_suite is not None:
            self.run_of_suite.stop()

    def get_driver_class(self) -> type[Driver]:
        """Return what drives the terminal."""
        return terminal_driver(super().get_driver_class())

    def _look_again(self) -> None:
        """Look, unless the terminal is gone: then nobody will see anything, and the bench is left to itself."""
        if isinstance(self._driver, Terminal) and self._driver.is_lost:
            self.exit()
        else:
            self.look()
            if not self._hurries:
                self._hurry()

    def _hurry(self) -> None:
        """Have a recording that is not where it is wanted go on between two looks; keys are heard in between."""
        self._hurries = self.replay is not None and bool(self.replay.progress)
        if self._hurries and self.replay is not None:
            self.work(self.replay)
            self.set_timer(_BREATH_S, self._hurry)

    # --- what is seen

    def open(self, process: BenchProcess | RecordedBench, replay: Replay | None = None) -> None:
        """Watch another bench, or a recording, with nothing left of the one before."""
        super().open(process, replay)
        self.zoomed = ""
        if self.run_of_suite is not None:
            self.run_of_suite.stop()
        self.run_of_suite = None
        self.query_one(FramesPane).filter("")
        self.query_one(ChecksPane).forget()
        for kind in _OF_FIELDS:
            self.query_one(kind).forget()
        timeline = self.query_one(Timeline)
        timeline.replay = replay
        timeline.set_class(replay is not None, "recorded")

    def show(self) -> None:
        """Show what is known."""
        self._tell_problems()
        self._look_at_pad()
        self._look_at_suite()
        self.offer_keys()
        self._arrange()
        self._look_at_model()
        if self.replay is not None:
            self.query_one(Timeline).look()
        head, guide = self.query_one(Head), self.query_one(Guide)
        head.model, head.now, head.said = self.model, self._headline(), self._pad.text
        head.look()
        actions = [*self.process.actions, *["check"] * bool(self.suites)] if self.process.phase is Phase.LIVE else ()
        guide.text = guide_view(self.model, actions, self.size.width, recorded=self.replay is not None)
        guide.display = self.process.phase is not Phase.ENDED
        guide.look()
        self.query_one(KeyLine).look(wanted_now(self.model, recorded=self.replay is not None))
        ended, said = self.query_one("#ended", Static), ""
        if self.process.phase is Phase.ENDED:
            said = self._epitaph().replace("[", "\\[")
        if said != self._said_of_end:
            self._said_of_end = said
            ended.update(said)
        ended.display = bool(said)

    def _look_at_model(self) -> None:
        """Have all panes look at what is known, if it is more than they have seen."""
        model, run = self.model, self.run_of_suite
        known = (model, model.taken if model is not None else 0, run, run.code if run is not None else 0)
        if known == self._known and (run is None or run.code is not None):
            return
        if self._ticking and self.replay is not None and self.replay.progress:
            self._put_off = (self._put_off + 1) % _LOOKS_ON_THE_WAY
            if self._put_off != 1:
                return
        self._known = known
        for pane in self.query(Pane):
            pane.model = model
            if pane.display:
                pane.look()
        strip = self.query_one(Strip)
        strip.model = model
        if strip.display:
            strip.look()

    def _look_at_pad(self) -> None:
        if self.replay is None and self.process.phase is Phase.LIVE:
            for said in self._pad.look(self.process, self.stopwatch.elapsed_s()):
                self.say(said)

    def _tell_problems(self) -> None:
        if self.model is not None:
            for problem in self._memory.problems:
                self.model.log.say(self.model.ns, "screen", problem)
                self._known = ()
            self._memory.problems.clear()

    # --- arrangement

    @property
    def _wide(self) -> bool:
        return self.size.width >= _WIDE

    @property
    def _shown_as(self) -> plugins.Dashboard:
        return ROBOT if self.model is None else self.model.dashboard

    @property
    def arrangement(self) -> Arrangement:
        """Where the panes are, on this bench and on a screen as wide as this one."""
        return self._memory.arrangement(self._shown_as, wide=self._wide)

    def available(self) -> list[str]:
        """Return the panes that have something to show."""
        model = self.model
        if model is None:
            return list(PANES)
        return [
            name
            for name, pane in PANES.items()
            if pane.has(model) or (name == "checks" and self.run_of_suite is not None)
        ]

    def on_resize(self) -> None:
        """Share the room out anew."""
        self._arrange()

    def _arrange(self) -> None:
        """Show what there is room for: columns, or the first few panes one below the other, or one pane."""
        kind = self._shown_as.kind
        if kind != self._plots_of:
            self._plots_of = kind
            self.query_one(PlotsPane).choose(*self._memory.signals(kind))
            self._look_at_plotted()
        arrangement = self.arrangement
        most = len(PANES) if self._wide else max(3, self.size.height // _ROWS_OF_A_PANE + 1)
        shown = [self.zoomed] if self.zoomed else arrangement.seen(self.available(), most)
        self.query_one(Body).arrange_as(arrangement, shown)
        self.query_one(Strip).display = not self._wide or bool(self.zoomed)

    def _rearrange(self, arrangement: Arrangement | None) -> None:
        self._memory.arrange(self._shown_as.kind, arrangement, wide=self._wide)
        self._arrange()

    def on_body_arranged(self, message: Body.Arranged) -> None:
        """Take what somebody has made of the panes."""
        self._rearrange(message.arrangement)

    def action_resize(self, dx: int, dy: int) -> None:
        """Make the pane that has the focus larger or smaller, by cells."""
        focused = self.focused
        shown = list(self.query_one(Body).shown)
        name = focused.id if focused is not None and focused.id in shown else shown[0] if shown else ""
        self.query_one(Body).resize(str(name), dx=dx, dy=dy)

    def action_panes(self) -> None:
        """Choose which panes are shown, and where."""

        def rows() -> list[tuple[str, bool, str]]:
            has = set(self.available())
            return [
                (
                    name,
                    name not in self.arrangement.hidden,
                    f"{PANES[name].key}  column {number}{'' if name in has else ', nothing to show yet'}",
                )
                for number, column in enumerate(self.arrangement.columns, 1)
                for name in column.names
            ]

        self.push_screen(
            PanesScreen(
                rows,
                lambda name: self._rearrange(self.arrangement.toggled(name)),
                move=lambda name, columns, places: self._rearrange(
                    self.arrangement.moved(name, columns=columns, places=places)
                ),
                reset=lambda: self._rearrange(None),
            )
        )

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

    def on_timeline_asked(self, message: Timeline.Asked) -> None:
        """Go to another place of the recording."""
        if self.replay is not None:
            self.replay.go_to(message.ns)
            self.look()

    def action_theme(self) -> None:
        """Choose another theme; each is seen while it is pointed at."""
        before = self.theme
        rows = [(name, "dark" if one.dark else "light") for name, one in sorted(self.available_themes.items())]

        def keep(name: str | None) -> None:
            self.theme = name or before

        self.push_screen(PickScreen("Which theme?", rows, at=before, look=keep), keep)

    def watch_theme(self, theme: str) -> None:
        """Remember the theme, however it was chosen, and take the colours of all views from it."""
        self._memory.theme = theme
        colours = terminal_theme(self.current_theme)
        if colours is not None:
            self.ansi_theme_dark = self.ansi_theme_light = colours

    # --- plots

    def action_span(self, by: int) -> None:
        """Plot a longer time, or a shorter one."""
        plots = self.query_one(PlotsPane)
        self._plot(plots.signals, plots.spanned(by))

    def action_signals(self) -> None:
        """Choose which signals are plotted."""
        plots = self.query_one(PlotsPane)
        if self.model is None or not self.model.signals.signals:
            self.say("nothing with a unit was recorded yet")
            return

        def rows() -> list[tuple[str, bool, str]]:
            signals = self.model.signals if self.model is not None else None
            names = [] if signals is None else [*signals.signals, *(set(plots.plotted) - signals.signals.keys())]
            found = [(name, signals.signal(name)) for name in names] if signals is not None else []
            return [(name, name in plots.plotted, "" if one is None else one.unit) for name, one in found]

        self.push_screen(ToggleScreen("Plot which signals?", rows, self._toggle_plot))

    def on_fields_pane_plotted(self, message: FieldsPane.Plotted) -> None:
        """Plot a field of a message or of a row, or do so no more."""
        self._toggle_plot(message.name)
        shown = "plots" in self.query_one(Body).shown
        has = message.name in self.query_one(PlotsPane).plotted
        if not shown:
            self.say(f"{message.name} is {'' if has else 'no more '}plotted: 9 shows it")

    def _toggle_plot(self, name: str) -> None:
        plots = self.query_one(PlotsPane)
        kept = [one for one in plots.plotted if one != name]
        self._plot(kept if name in plots.plotted else [name, *plots.plotted], plots.span_s)

    def _plot(self, signals: list[str] | None, span_s: int) -> None:
        self.query_one(PlotsPane).choose(signals, span_s)
        self._look_at_plotted()
        self._memory.plot(self._shown_as.kind, signals, span_s)

    def _look_at_plotted(self) -> None:
        for kind in _OF_FIELDS:
            pane = self.query_one(kind)
            pane.plotted = self.query_one(PlotsPane).plotted
            pane.refresh()

    # --- suites

    def action_check(self) -> None:
        """Ask for a suite and run it on a fresh bench of the same kind."""
        if self.run_of_suite is not None and self.run_of_suite.code is None:
            self.say("a suite runs; 'Stop the suite' of ctrl+p ends it")
            return

        def run_it(asked: tuple[str, str] | None) -> None:
            if asked is None:
                return
            suite, select = asked
            self.process.send("mark", text=f"suite {suite} {select}".strip())
            self.run_of_suite = CheckRun(str(self.process.about["file"]), suite, select)
            if "checks" not in self.arrangement.seen(self.available(), len(PANES) if self._wide else 0):
                self.zoomed = "checks"
            self.look()
            self.query_one(ChecksPane).focus()

        self.push_screen(SuiteScreen({suite: self._examples(suite) for suite in self.suites}), run_it)

    def _examples(self, suite: str) -> list[str]:
        """Return the first clauses of a suite, as far as a protocol of this bench has them."""
        protocols = self.model.frames.protocols if self.model is not None else []
        clauses = (clause for protocol in protocols for clause in protocol.clauses())
        return [clause.id for clause in clauses if clause.suite == suite][:2]

    def action_stop_check(self) -> None:
        """End the suite that runs."""
        if self.run_of_suite is None or self.run_of_suite.code is not None:
            self.say("no suite runs")
        else:
            self.run_of_suite.stop()

    def _look_at_suite(self) -> None:
        run = self.run_of_suite
        if run is not None:
            run.poll()
            self.query_one(ChecksPane).take(run.checks, run.title, run.text, ended=run.code is not None)

    # --- the rest

    def action_filter(self) -> None:
        """Ask for a filter of the frames."""
        frames = self.query_one(FramesPane)

        def filter_by(pattern: str | None) -> None:
            if pattern is not None:
                frames.filter(pattern)

        self.push_screen(WordScreen("Frames with (words, -word, > < !):", frames.pattern), filter_by)

    def action_compose(self) -> None:
        """Edit a message and send it: the one that is pointed at, or one of those that there were."""
        messages = self.model.messages if self.model is not None else []
        there = [one.latest for one in messages if one.latest.can_be_made]
        pointed_at = self.query_one(MessagesPane).pointed_at
        if not there:
            self.say("no message was heard or sent yet whose protocol makes frames")
        elif self.focused is self.query_one(MessagesPane) and pointed_at is not None:
            self._compose(pointed_at.latest)
        else:
            there.sort(key=lambda frame: not frame.sent)
            named = {f"{'>' if one.sent else '<'} {one.line} {one.item.name}".replace("  ", " "): one for one in there}
            rows = [(name, fields_text(one).plain[:60]) for name, one in named.items()]
            self.push_screen(
                PickScreen("Send which message? You can edit it first.", rows),
                lambda name: self._compose(named[name]) if name else None,
            )

    def _compose(self, frame: FrameModel) -> None:
        def send(data: bytes | None) -> None:
            if data:
                self.process.send("send", data=data.hex(), **({"line": frame.line} if frame.line else {}))

        if frame.can_be_made:
            self.push_screen(ComposeScreen(frame), send)
        else:
            self.say(f"its protocol makes no frame of {frame.item.name}")

    def action_help(self) -> None:
        """Explain what is seen here, what to try, and the keys."""
        actions = self.process.actions if self.process.phase is Phase.LIVE else ()
        panes = [(PANES[name].key, name, PANES[name].title) for name in self.available()]
        self.push_screen(HelpScreen(help_text(self.model, actions, panes, recorded=self.replay is not None)))

    def action_pick(self) -> None:
        """Ask for another bench and open it."""

        def open_it(name: str | None) -> None:
            if name and self._open_bench is not None:
                try:
                    opened = self._open_bench(name)
                except HilbenchError as error:
                    self.say(str(error), severity="error")
                    return
                self.process.stop()
                self.open(opened)
                self.look()

        self.push_screen(PickScreen("Open which bench? The present one is stopped.", self._benches), open_it)

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
        """Offer every action by name in the command palette, and none of Textual's own."""
        del screen
        for what, (name, arguments) in BY_NAME.items():
            if self.check_action(name, arguments):
                action = getattr(self, f"action_{name}")
                yield _command(what, key_of(name, arguments), partial(action, *arguments), action.__doc__ or "")
        for number, key in enumerate(self.keys):
            if self.check_action("ask", (number,)):
                yield _command(f"Target: {key.title}", key.key, partial(self.action_ask, number), key.help)


def _command(what: str, key: str, do: Callable[[], object], explained: str) -> SystemCommand:
    """Return a command of the palette, with its key behind its name."""
    return SystemCommand(f"{what}  ({key})" if key else what, explained.strip(), do)
