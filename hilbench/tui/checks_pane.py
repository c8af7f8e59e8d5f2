"""The pane of verdicts: the clauses of a run, one of them pointed at, and that one whole."""

from __future__ import annotations

from collections.abc import Sequence

from rich.text import Text
from textual.binding import Binding
from textual.content import Content

from hilbench.tui.model.bench import BenchModel
from hilbench.tui.model.checks import CheckedModel, ChecksModel
from hilbench.tui.panes import RowsPane
from hilbench.tui.views.checks import checks_view, clause_view, clauses_shown
from hilbench.tui.views.words import DIM

__all__ = ["ChecksPane"]


class ChecksPane(RowsPane):
    """See the module.

    Attributes:
        run: a run of this dashboard's; None to show what the journal itself tells of cases.
        chosen: the clause that is pointed at; empty while none is.
        opened: whether it is shown whole.
        said: what stands below if the run came to nothing: why.
    """

    BINDINGS = [Binding("enter", "open", "Evidence")]

    def __init__(self) -> None:
        super().__init__("checks")
        self.run: ChecksModel | None = None
        self.chosen = ""
        self.opened = False
        self.said: Sequence[str] = ()
        self._above = 0
        self._drawn: Sequence[CheckedModel] = ()

    def take(self, checks: ChecksModel, title: str, text: str, *, ended: bool) -> None:
        """Show a run; where it came to no verdict, show what it said."""
        if checks is not self.run:
            self.run, self.chosen, self.opened = checks, "", False
        self.border_subtitle = Content(title if ended else f"{title}, runs")
        self.said = text.splitlines()

    def forget(self) -> None:
        """Show what the journal itself tells of cases."""
        self.run, self.chosen, self.opened, self.said = None, "", False, ()
        self.border_subtitle = ""

    def checks_of(self, model: BenchModel) -> ChecksModel:
        """Return the run that is shown."""
        return model.checks if self.run is None else self.run

    def lines(self, model: BenchModel, width: int, height: int) -> Sequence[Text]:
        """Return the clauses, and above them the one that is opened."""
        checks = self.checks_of(model)
        whole: list[Text] = []
        row = checks.rows.get(self.chosen)
        if self.opened and row is not None:
            whole = [*clause_view(row, width, max(1, height - 4)), Text("─" * width, DIM)]
        said = [Text(line) for line in self.said[-height:]] if not checks.rows else []
        room = max(1, height - len(whole))
        self._above = len(whole) + 1
        self._drawn = clauses_shown(checks, room, self.chosen, self._drawn)
        return [*whole, *(said or checks_view(checks, width, room, chosen=self.chosen, shown=self._drawn))]

    def action_move(self, by: int) -> None:
        """Point at another clause."""
        names = self._names()
        if names:
            at = names.index(self.chosen) + by if self.chosen in names else (0 if by > 0 else len(names) - 1)
            self.chosen = names[max(0, min(len(names) - 1, at))]
        self.refresh()

    def choose_row(self, row: int) -> None:
        """Point at the clause in a row; show it whole, or no more, if it is pointed at."""
        if not self._above <= row < self._above + len(self._drawn):
            return
        clause = self._drawn[row - self._above].id
        if clause == self.chosen:
            self.opened = not self.opened
        self.chosen = clause
        self.refresh()

    def action_open(self) -> None:
        """Show the clause whole, or no more."""
        names = self._names()
        if self.chosen not in names and names:
            bad = [row.id for row in self.checks_of(self.model).rows.values() if row.bad] if self.model else []
            self.chosen = (bad or names)[0]
        self.opened = not self.opened
        self.refresh()

    def action_back(self) -> None:
        """Close the clause; then point at none; then give the screen back."""
        if self.opened:
            self.opened = False
        elif self.chosen:
            self.chosen = ""
        else:
            self.app.action_unzoom()  # type: ignore[attr-defined]
        self.refresh()

    def _names(self) -> list[str]:
        return [] if self.model is None else list(self.checks_of(self.model).rows)
