"""The room of the panes: where each is, and borders that are dragged with the mouse."""

from __future__ import annotations

from collections.abc import Collection

from textual import events
from textual.geometry import NULL_OFFSET, Region, Size, Spacing
from textual.layout import ArrangeResult, Layout, WidgetPlacement
from textual.message import Message
from textual.widget import Widget

from hilbench.tui.model.arrangement import Arrangement, Box

__all__ = ["Body"]


class _Tiles(Layout):
    """Places panes as the body says."""

    name = "tiles"

    def arrange(self, parent: Widget, children: list[Widget], size: Size, greedy: bool = True) -> ArrangeResult:
        """Place all that are to be seen."""
        del greedy
        assert isinstance(parent, Body)
        boxes = parent.boxes(size.width, size.height)
        placed = []
        for child in children:
            box = boxes.get(str(child.id))
            if box is not None:
                placed.append(
                    WidgetPlacement(Region(box.x, box.y, box.width, box.height), NULL_OFFSET, Spacing(), child)
                )
        return placed


class Body(Widget):
    """See the module.

    Attributes:
        arrangement: where panes are.
        shown: those that are to be seen.
    """

    class Arranged(Message):
        """Somebody has moved a border."""

        def __init__(self, arrangement: Arrangement) -> None:
            self.arrangement = arrangement
            super().__init__()

    def __init__(self, *panes: Widget, arrangement: Arrangement) -> None:
        super().__init__(*panes, id="body")
        self.arrangement = arrangement
        self.shown: Collection[str] = ()
        self._tiles = _Tiles()
        self._held: tuple[str, bool, events.MouseEvent, Arrangement] | None = None

    @property
    def layout(self) -> Layout:
        """How its children are placed."""
        return self._tiles

    def boxes(self, width: int, height: int) -> dict[str, Box]:
        """Return where panes are; one that is to have all of the room need not be part of the arrangement."""
        if len(self.shown) == 1:
            return {name: Box(0, 0, width, height) for name in self.shown}
        return self.arrangement.boxes(self.shown, width, height)

    def arrange_as(self, arrangement: Arrangement, shown: Collection[str]) -> None:
        """Show these panes, so."""
        if (arrangement, list(shown)) == (self.arrangement, list(self.shown)):
            return
        self.arrangement, self.shown = arrangement, list(shown)
        for pane in self.children:
            pane.display = pane.id in self.shown
            pane.refresh(layout=True)  # a widget keeps its arrangement until a child of it asks for another

    def resize(self, name: str, *, dx: int = 0, dy: int = 0) -> None:
        """Make a pane larger or smaller by cells."""
        width, height = self.size
        self.post_message(self.Arranged(self.arrangement.resized(self.shown, width, height, name, dx=dx, dy=dy)))

    # --- the mouse

    def on_mouse_down(self, event: events.MouseDown) -> None:
        """Take hold of a border, if there is one."""
        held = self._border(event.screen_x - self.region.x, event.screen_y - self.region.y)
        if held is not None and len(self.shown) > 1:
            self._held = (*held, event, self.arrangement)
            self.capture_mouse()

    def on_mouse_move(self, event: events.MouseMove) -> None:
        """Move the border that is held."""
        if self._held is None:
            return
        name, across, begin, before = self._held
        width, height = self.size
        dx = round(event.screen_x - begin.screen_x) if across else 0
        dy = 0 if across else round(event.screen_y - begin.screen_y)
        self.post_message(self.Arranged(before.resized(self.shown, width, height, name, dx=dx, dy=dy)))

    def on_mouse_up(self) -> None:
        """Let go."""
        if self._held is not None:
            self._held = None
            self.release_mouse()

    def on_mouse_release(self) -> None:
        """Let go also where the button was let go above something else, such as a form that has come meanwhile."""
        self._held = None

    def _border(self, x: float, y: float) -> tuple[str, bool] | None:
        """Return the pane whose right border (True) or lower border (False) is moved when one drags this cell."""
        boxes = self.boxes(*self.size)
        for name, box in boxes.items():
            right, below = box.x + box.width, box.y + box.height
            if int(x) in {right - 1, right} and box.y <= y < below and right < self.size.width:
                return name, True
            if int(y) in {below - 1, below} and box.x <= x < right and below < self.size.height:
                return name, False
        return None
