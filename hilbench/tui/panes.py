"""The panes: each shows one view of the model in the room it has."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

from rich.text import Text
from textual import events
from textual.binding import Binding
from textual.message import Message

from hilbench.tui.lines import Lines
from hilbench.tui.model.bench import BenchModel
from hilbench.tui.model.rows import rows_of
from hilbench.tui.views.above import world_view
from hilbench.tui.views.beside import beside_view
from hilbench.tui.views.checks import checks_view
from hilbench.tui.views.console import console_view
from hilbench.tui.views.counters import counters_view
from hilbench.tui.views.frames import frames_view
from hilbench.tui.views.head import head_view
from hilbench.tui.views.log import log_view
from hilbench.tui.views.messages import messages_view
from hilbench.tui.views.pins import pins_view
from hilbench.tui.views.plots import SPANS_S, plots_view
from hilbench.tui.views.states import machine_view
from hilbench.tui.views.status import link_view, strip_view
from hilbench.tui.views.tables import tables_view
from hilbench.tui.views.watchdogs import timers_view
from hilbench.tui.views.words import fit

__all__ = ["LOOKED_AT", "PANES", "Guide", "Head", "Pane", "PaneSpec", "PlotsPane", "RowsPane", "Strip"]

_FEW_STATES = 3
LOOKED_AT = 150
"""So many of the latest frames are folded into rows: of a full line more would take too long (choice)."""
_ROWS_OF_A_NOTCH = 3
"""How far a notch of the wheel points (choice)."""
View = Callable[[BenchModel, int, int], Sequence[Text]]


def _machines(model: BenchModel, width: int, height: int) -> list[Text]:
    """Share the rows among the machines, by how many states they have; small ones are shown whole."""
    machines = list(model.machines.values())
    if not machines:
        return [Text("no state machine to watch", "dim")]
    states = [max(2, len(machine.states)) for machine in machines]
    spare = height - sum(count + 1 for count in states)
    weights = states if spare >= 0 else [max(0, count - _FEW_STATES) for count in states]
    lines: list[Text] = []
    for number, (machine, count, weight) in enumerate(zip(machines, states, weights, strict=True)):
        left = height - len(lines)
        room = left if number == len(machines) - 1 else max(3, count + 1 + spare * weight // max(1, sum(weights)))
        lines += machine_view(machine, width, max(1, min(room, left)), model.ns)
    return lines


def _pins(model: BenchModel, width: int, height: int) -> list[Text]:
    """Show what stands beside a board, then its pins; in little room some of both, analog pins above all."""
    pins = model.pins.pins.values()
    analog = sum(bool(pin.volts) for pin in pins)
    beside = beside_view(model, width, max(1, height - analog - (len(pins) > analog)))
    if beside and not pins:
        return beside
    return [*beside, *pins_view(model.pins, width, max(1, height - len(beside)), model.ns)]


def _frames(model: BenchModel, width: int, height: int) -> list[Text]:
    """Show the latest frames, equal ones folded."""
    return frames_view(rows_of(model.frames.matching("", LOOKED_AT)), width, height)


class PaneSpec(NamedTuple):
    """What a pane is.

    Attributes:
        title: in its border.
        view: what is seen of a model in so many columns and rows.
        key: what gives it the screen.
        has: whether there is anything to see of a model.
    """

    title: str
    view: View
    key: str
    has: Callable[[BenchModel], bool] = lambda _: True


PANES: dict[str, PaneSpec] = {
    "link": PaneSpec("Link", lambda model, width, _: link_view(model, width), "1"),
    "timers": PaneSpec("Watchdogs", lambda model, width, _: timers_view(model, width), "2", lambda m: bool(m.machines)),
    "counters": PaneSpec(
        "Counters", lambda model, width, _: counters_view(model, width), "3", lambda m: bool(m.machines)
    ),
    "world": PaneSpec(
        "World",
        lambda model, width, height: world_view(model.world, width, height),
        "4",
        lambda m: bool(m.world.vehicle),
    ),
    "frames": PaneSpec(
        "Frames",
        _frames,
        "5",
        lambda m: bool(m.live.get("protocol") or m.live.get("speakers")),
    ),
    "states": PaneSpec("States", _machines, "6", lambda m: bool(m.machines)),
    "pins": PaneSpec(
        "Pins",
        _pins,
        "7",
        lambda m: bool(m.pins.pins or m.seen),
    ),
    "log": PaneSpec("Log", lambda model, width, height: log_view(model.log, width, height), "8"),
    "plots": PaneSpec(
        "Plots",
        lambda model, width, height: plots_view(model.signals, width, height, model.ns),
        "9",
        lambda m: bool(m.signals.usual()),
    ),
    "checks": PaneSpec(
        "Checks",
        lambda model, width, height: checks_view(model.checks, width, height),
        "0",
        lambda m: bool(m.checks.rows),
    ),
    "messages": PaneSpec(
        "Messages",
        lambda model, width, height: messages_view(model.messages, width, height, model.ns),
        "M",
        lambda m: bool(m.live.get("protocol") or m.live.get("speakers")),
    ),
    "tables": PaneSpec(
        "Tables",
        lambda model, width, height: tables_view(model.tables.shown, width, height, model.ns),
        "B",
        lambda m: bool(m.tables.shown),
    ),
    "console": PaneSpec(
        "Console",
        lambda model, width, height: console_view(model.console, width, height),
        "C",
        lambda m: bool(m.console.lines),
    ),
}
"""The panes by name, in the order of their keys."""


class Pane(Lines, can_focus=True):
    """A pane.

    Args:
        name: one of `PANES`.
    """

    class Chosen(Message):
        """The pane was clicked on twice: it is to have the whole screen, or to give it back."""

        def __init__(self, name: str) -> None:
            self.name = name
            super().__init__()

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self._view = PANES[name].view
        self.border_title = f"{PANES[name].key} {PANES[name].title}"
        self.model: BenchModel | None = None

    def lines_for(self, width: int, height: int) -> Sequence[Text]:
        """Return the lines that fit."""
        return [Text("waits for the bench", "dim")] if self.model is None else self.lines(self.model, width, height)

    def lines(self, model: BenchModel, width: int, height: int) -> Sequence[Text]:
        """Return what is shown of a model."""
        return self._view(model, width, height)

    def on_click(self, event: events.Click) -> None:
        """Ask for the whole screen."""
        if event.chain == 2:
            self.post_message(self.Chosen(str(self.id)))


class RowsPane(Pane):
    """A pane of rows, one of which is pointed at by arrows, wheel or a click; one more click opens it."""

    BINDINGS = [
        Binding("up", "move(-1)", "Up", show=False),
        Binding("down", "move(1)", "Down", show=False),
        Binding("pageup", "move(-10)", "Page up", show=False),
        Binding("pagedown", "move(10)", "Page down", show=False),
        Binding("escape", "back", "Back", show=False),
    ]

    def action_move(self, by: int) -> None:
        """Point at another row."""
        raise AssertionError(f"{self} has no row {by} further")

    def choose_row(self, row: int) -> None:
        """Point at what stands in a row of the pane; open it if it is pointed at already."""
        raise AssertionError(f"{self} has no row {row}")

    def on_click(self, event: events.Click) -> None:
        """Point at a row."""
        place = event.get_content_offset(self)
        if event.chain == 1 and place is not None:
            self.choose_row(place.y)

    def on_mouse_scroll_up(self, event: events.MouseScrollUp) -> None:
        """Point further up."""
        event.stop()
        self.action_move(-_ROWS_OF_A_NOTCH)

    def on_mouse_scroll_down(self, event: events.MouseScrollDown) -> None:
        """Point further down."""
        event.stop()
        self.action_move(_ROWS_OF_A_NOTCH)


class PlotsPane(Pane):
    """Signals over time.

    Attributes:
        signals: the names of those that are plotted; None for those that matter on such a bench.
        span_s: over how long.
    """

    def __init__(self) -> None:
        super().__init__("plots")
        self.signals: list[str] | None = None
        self.span_s = 20

    def lines(self, model: BenchModel, width: int, height: int) -> Sequence[Text]:
        """Return the plots."""
        return plots_view(model.signals, width, height, model.ns, chosen=self.signals, span_s=self.span_s)

    @property
    def plotted(self) -> list[str]:
        """The names of the signals that are plotted."""
        usual = [] if self.model is None else self.model.signals.usual()
        return usual if self.signals is None else self.signals

    def choose(self, signals: list[str] | None, span_s: int) -> None:
        """Plot other signals, or over another time."""
        self.signals, self.span_s = signals, span_s
        self.border_subtitle = f"{span_s} s"
        self.refresh()

    def spanned(self, by: int) -> int:
        """Return the next longer time, or the next shorter one."""
        at = min(range(len(SPANS_S)), key=lambda number: abs(SPANS_S[number] - self.span_s))
        return SPANS_S[max(0, min(len(SPANS_S) - 1, at + by))]


class Strip(Lines):
    """The most important of all panes in one line."""

    def __init__(self) -> None:
        super().__init__("strip")
        self.model: BenchModel | None = None

    def lines_for(self, width: int, height: int) -> Sequence[Text]:
        """Return the line."""
        del height
        return [] if self.model is None else [strip_view(self.model, width)]


class Head(Lines):
    """The first line: which bench it is, what matters most of it, and its time.

    Attributes:
        model: of the bench; None before anything is known of it.
        now: bench time, and how it passes.
        said: what is said besides.
    """

    def __init__(self) -> None:
        super().__init__("head")
        self.model: BenchModel | None = None
        self.now = self.said = ""

    def lines_for(self, width: int, height: int) -> Sequence[Text]:
        """Return the line."""
        del height
        if self.model is None:
            return [Text(f" hilbench  {self.now}")]
        return [head_view(self.model, self.now, width, self.said)]


class Guide(Lines):
    """The second line: what goes on, and what to press.

    Attributes:
        text: that.
    """

    def __init__(self) -> None:
        super().__init__("guide")
        self.text = Text()

    def lines_for(self, width: int, height: int) -> Sequence[Text]:
        """Return the line."""
        del height
        return [fit(self.text, width)]
