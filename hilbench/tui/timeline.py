"""The line of time of a recording; a click on it goes there."""

from __future__ import annotations

from collections.abc import Sequence

from rich.text import Text
from textual import events
from textual.message import Message

from hilbench.tui.lines import Lines
from hilbench.tui.model.replay import NS_PER_S, Replay
from hilbench.tui.views.timeline import time_at, timeline_view

__all__ = ["Timeline"]


class Timeline(Lines):
    """See the module.

    Attributes:
        replay: the recording; None of a bench that runs, which has no such line.
    """

    class Asked(Message):
        """Somebody wants to be at a bench time."""

        def __init__(self, ns: int) -> None:
            self.ns = ns
            super().__init__()

    def __init__(self, replay: Replay | None) -> None:
        super().__init__("timeline")
        self.replay = replay
        self._held = False

    def lines_for(self, width: int, height: int) -> Sequence[Text]:
        """Return the line."""
        del height
        replay = self.replay
        return [] if replay is None else [timeline_view(replay.length_ns, replay.now_ns, replay.marks, width)]

    def on_mouse_down(self, event: events.MouseDown) -> None:
        """Go there, and follow the mouse from now on."""
        self._held = True
        self.capture_mouse()
        self._ask(event.x)

    def on_mouse_move(self, event: events.MouseMove) -> None:
        """Go where the mouse goes."""
        if self._held:
            self._ask(event.x)

    def on_mouse_up(self) -> None:
        """Let go."""
        self._held = False
        self.release_mouse()

    def on_mouse_release(self) -> None:
        """Let go also where the button was let go above something else."""
        self._held = False

    def on_mouse_scroll_up(self, event: events.MouseScrollUp) -> None:
        """Go a second back."""
        self._go_by(event, -NS_PER_S)

    def on_mouse_scroll_down(self, event: events.MouseScrollDown) -> None:
        """Go a second on."""
        self._go_by(event, NS_PER_S)

    def _go_by(self, event: events.MouseEvent, span_ns: int) -> None:
        event.stop()
        if self.replay is not None:
            self.post_message(self.Asked(self.replay.now_ns + span_ns))

    def _ask(self, column: float) -> None:
        if self.replay is not None:
            self.post_message(self.Asked(time_at(int(column), self.replay.length_ns, self.content_size.width)))
