"""The pane of frames: filtered, folded, held, and one of them byte by byte."""

from __future__ import annotations

from collections.abc import Sequence

from rich.text import Text
from textual.binding import Binding
from textual.content import Content

from hilbench.tui.model.bench import BenchModel
from hilbench.tui.model.frames import KEPT_FRAMES, FrameModel
from hilbench.tui.model.rows import FrameRow, rows_of
from hilbench.tui.panes import LOOKED_AT, RowsPane
from hilbench.tui.views.frames import frame_view, frames_view
from hilbench.tui.views.words import DIM

__all__ = ["FramesPane"]

_HELD_FRAMES = 400


class FramesPane(RowsPane):
    """See the module.

    Attributes:
        pattern: the filter.
        folds: whether equal frames in a row are one row.
        held: the frames that are shown while the list stands still; None while it runs.
        chosen: the number of the frame that is pointed at; None while the list runs.
        opened: whether that frame is shown byte by byte.
    """

    BINDINGS = [
        Binding("enter", "open", "Bytes"),
        Binding("h", "hold", "Hold"),
        Binding("F", "fold", "Fold"),
    ]

    def __init__(self) -> None:
        super().__init__("frames")
        self.pattern = ""
        self.folds = True
        self.held: list[FrameModel] | None = None
        self.chosen: int | None = None
        self.opened = False
        self._end = 0
        self._drawn: tuple[int, Sequence[FrameRow]] = (0, ())

    def lines(self, model: BenchModel, width: int, height: int) -> Sequence[Text]:
        """Return the rows, and above them the frame that is opened."""
        held = self.held is not None
        frames = self.held if self.held is not None else model.frames.matching(self.pattern, LOOKED_AT)
        rows = rows_of(frames, fold=self.folds)
        row = self._chosen_of(rows)
        said: list[Text] = []
        if self.opened and row is not None:
            said = frame_view(row.frame, width)[: max(1, height - 4)]
            said = [*said, Text("─" * width, DIM)]
        room = height - len(said)
        if held and row is not None:
            at = rows.index(row)
            self._end = min(len(rows), max(room, at + 1, min(self._end, at + room)))
            rows = rows[max(0, self._end - room) : self._end]
        self._drawn = len(said), rows[-room:]
        empty = f"no frame has '{self.pattern}'" if self.pattern else "no frame yet"
        chosen = None if row is None else row.number
        return [*said, *frames_view(rows, width, room, chosen=chosen, empty=empty)]

    def selected(self) -> list[FrameModel]:
        """Return the frames of the row that is pointed at; else all that the filter lets pass."""
        if self.held is not None:
            row = self._chosen_of(rows_of(self.held, fold=self.folds))
            return self.held if row is None else row.frames
        return [] if self.model is None else self.model.frames.matching(self.pattern, KEPT_FRAMES)

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

    def action_fold(self) -> None:
        """Fold equal frames in a row, or show each."""
        self.folds = not self.folds
        self._tell()

    def action_move(self, by: int) -> None:
        """Point at another row."""
        rows = rows_of(self._hold(), fold=self.folds)
        row = self._chosen_of(rows)
        if row is not None:
            self.chosen = rows[max(0, min(len(rows) - 1, rows.index(row) + by))].number
        self._tell()

    def choose_row(self, row: int) -> None:
        """Point at a row, and hold the list; show its frame byte by byte, or no more, if it is pointed at."""
        above, rows = self._drawn
        if not above <= row < above + len(rows):
            return
        number = rows[row - above].number
        if self.held is not None and self.chosen == number:
            self.opened = not self.opened
        else:
            self._hold()
            self.chosen = number
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

    def _hold(self) -> list[FrameModel]:
        if self.held is None:
            self.held = [] if self.model is None else self.model.frames.matching(self.pattern, _HELD_FRAMES)
            self.chosen = self.held[-1].number if self.held else None
            self._end = len(self.held)
        return self.held

    def _chosen_of(self, rows: Sequence[FrameRow]) -> FrameRow | None:
        """Return the row of the frame that is pointed at, which may be one of several in it."""
        return next((row for row in rows if any(frame.number == self.chosen for frame in row.frames)), None)

    def _tell(self) -> None:
        words = [f"filter: {self.pattern}"] if self.pattern else []
        words += ["held"] if self.held is not None else []
        words += [] if self.folds else ["each frame"]
        self.border_subtitle = Content(", ".join(words))  # somebody's words, and no markup
        self.refresh()
