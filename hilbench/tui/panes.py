"""The panes: each shows one view of the model in the room it has."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from rich.text import Text
from textual import events
from textual.binding import Binding
from textual.message import Message
from textual.widget import Widget

from hilbench.tui.model.bench import BenchModel
from hilbench.tui.model.frames import FrameModel
from hilbench.tui.views.above import world_view
from hilbench.tui.views.frames import frame_view, frames_view
from hilbench.tui.views.log import log_view
from hilbench.tui.views.pins import pins_view
from hilbench.tui.views.states import machine_view
from hilbench.tui.views.status import counters_view, link_view, strip_view, timers_view

__all__ = ["PANES", "FramesPane", "Pane", "Strip", "pane_names"]

View = Callable[[BenchModel, int, int], Sequence[Text]]


def _machines(model: BenchModel, width: int, height: int) -> list[Text]:
    """Share the rows among the machines, by how many states they have."""
    machines = list(model.machines.values())
    if not machines:
        return [Text("no state machine to watch", "dim")]
    states = [max(2, len(machine.states)) for machine in machines]
    spare = height - sum(count + 1 for count in states)
    lines: list[Text] = []
    for number, (machine, count) in enumerate(zip(machines, states, strict=True)):
        left = height - len(lines)
        room = left if number == len(machines) - 1 else max(3, count + 1 + spare * count // sum(states))
        lines += machine_view(machine, width, min(room, left), model.ns)
    return lines


PANES: dict[str, tuple[str, View]] = {
    "link": ("Link", lambda model, width, _height: link_view(model, width)),
    "timers": ("Watchdogs", lambda model, width, _height: timers_view(model, width)),
    "counters": ("Counters", lambda model, width, _height: counters_view(model, width)),
    "world": ("World", lambda model, width, height: world_view(model.world, width, height)),
    "frames": ("Frames", lambda model, width, height: frames_view(list(model.frames.frames), width, height)),
    "states": ("States", _machines),
    "pins": ("Pins", lambda model, width, height: pins_view(model.pins, width, height, model.ns)),
    "log": ("Log", lambda model, width, height: log_view(model.log, width, height)),
}
"""Title and view of each pane by its name, in the order of the keys 1 to 8."""


def pane_names() -> tuple[str, ...]:
    """Return the names of the panes, in the order of their keys."""
    return tuple(PANES)


class Pane(Widget, can_focus=True):
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
        super().__init__(id=name)
        title, self._view = PANES[name]
        self.border_title = f"{pane_names().index(name) + 1} {title}"
        self.model: BenchModel | None = None

    def render(self) -> Text:
        """Return the lines that fit."""
        width, height = self.content_size
        if self.model is None or width < 1 or height < 1:
            return Text("waits for the bench", "dim")
        return Text("\n").join(self.lines(self.model, width, height)[:height])

    def lines(self, model: BenchModel, width: int, height: int) -> Sequence[Text]:
        """Return what is shown of a model."""
        return self._view(model, width, height)

    def on_click(self, event: events.Click) -> None:
        """Ask for the whole screen."""
        if event.chain == 2:
            self.post_message(self.Chosen(str(self.id)))


class FramesPane(Pane):
    """The frames: filtered, held, and one of them byte by byte.

    Attributes:
        pattern: the filter.
        held: the frames that are shown while the list stands still; None while it runs.
        chosen: the number of the frame that is pointed at; None while the list runs.
        opened: whether that frame is shown byte by byte.
    """

    BINDINGS = [
        Binding("up", "move(-1)", "Up", show=False),
        Binding("down", "move(1)", "Down", show=False),
        Binding("pageup", "move(-10)", "Page up", show=False),
        Binding("pagedown", "move(10)", "Page down", show=False),
        Binding("enter", "open", "Bytes"),
        Binding("h", "hold", "Hold"),
        Binding("escape", "back", "Back", show=False),
    ]

    def __init__(self) -> None:
        super().__init__("frames")
        self.pattern = ""
        self.held: list[FrameModel] | None = None
        self.chosen: int | None = None
        self.opened = False

    def lines(self, model: BenchModel, width: int, height: int) -> Sequence[Text]:
        """Return the frames, and above them the one that is opened."""
        frames = self._shown(model, height if self.held is None else 400)
        frame = self._chosen_of(frames)
        said: list[Text] = []
        if self.opened and frame is not None:
            said = frame_view(frame, model.frames.protocol, model.frames.options, width)[: max(1, height - 4)]
            said = [*said, Text("─" * width, "dim")]
        room = height - len(said)
        if self.held is not None and frame is not None:
            at = frames.index(frame)
            end = max(room, min(len(frames), at + room // 2 + 1))
            frames = frames[max(0, end - room) : end]
        empty = f"no frame has '{self.pattern}'" if self.pattern else "no frame yet"
        return [*said, *frames_view(frames, width, room, chosen=self.chosen, empty=empty)]

    def filter(self, pattern: str) -> None:
        """Let only those frames pass that a pattern lets pass."""
        self.pattern = pattern
        self.held, self.chosen, self.opened = None, None, False
        self._tell()

    def action_hold(self) -> None:
        """Let the list stand still, or run on."""
        if self.held is None:
            self._hold()
        else:
            self.held, self.chosen, self.opened = None, None, False
        self._tell()

    def action_move(self, by: int) -> None:
        """Point at another frame."""
        frames = self._hold()
        frame = self._chosen_of(frames)
        if frame is not None:
            at = frames.index(frame) + by
            self.chosen = frames[max(0, min(len(frames) - 1, at))].number
        self._tell()

    def action_open(self) -> None:
        """Show the frame byte by byte, or no more."""
        self._hold()
        self.opened = not self.opened
        self._tell()

    def action_back(self) -> None:
        """Close the frame; then let the list run on; then give the screen back."""
        if self.opened:
            self.opened = False
        elif self.held is not None:
            self.held, self.chosen = None, None
        else:
            self.app.action_unzoom()  # type: ignore[attr-defined]
        self._tell()

    def _shown(self, model: BenchModel, count: int) -> list[FrameModel]:
        return model.frames.matching(self.pattern, count) if self.held is None else self.held

    def _hold(self) -> list[FrameModel]:
        if self.held is None:
            self.held = [] if self.model is None else self.model.frames.matching(self.pattern, 400)
            self.chosen = self.held[-1].number if self.held else None
        return self.held

    def _chosen_of(self, frames: Sequence[FrameModel]) -> FrameModel | None:
        return next((frame for frame in frames if frame.number == self.chosen), None)

    def _tell(self) -> None:
        words = [f"filter: {self.pattern}"] if self.pattern else []
        words += ["held"] if self.held is not None else []
        self.border_subtitle = ", ".join(words)
        self.refresh()


class Strip(Widget):
    """The most important of all panes in one line."""

    def __init__(self) -> None:
        super().__init__(id="strip")
        self.model: BenchModel | None = None

    def render(self) -> Text:
        """Return the line."""
        return Text("") if self.model is None else strip_view(self.model, self.content_size.width)
