"""A pane of things that have fields: one a row; one of them opened, field by field, and which are plotted."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from typing import Any

from rich.text import Text
from textual.binding import Binding
from textual.message import Message

from hilbench.tui.model.bench import BenchModel
from hilbench.tui.model.frames import Field
from hilbench.tui.panes import RowsPane
from hilbench.tui.views.opened import opened_view

__all__ = ["FieldsPane"]


class FieldsPane(RowsPane):
    """See the module; what the things are says who derives from it.

    Attributes:
        chosen: the name of the one that is pointed at; None while none is.
        opened: whether it is shown field by field.
        field: the number of the field that is pointed at then.
        plotted: the names of all signals that are plotted.
    """

    BINDINGS = [Binding("enter", "open", "Fields, plot")]

    class Plotted(Message):
        """A field is to be plotted, or no more."""

        def __init__(self, name: str) -> None:
            self.name = name
            super().__init__()

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.chosen: object = None
        self.opened = False
        self.field = 0
        self.plotted: Sequence[str] = ()

    # --- what the things are

    @abstractmethod
    def things(self) -> Sequence[Any]:
        """Return all of them, in their order."""

    @abstractmethod
    def name_of(self, thing: Any) -> object:
        """Return what one is known by."""

    @abstractmethod
    def fields_of(self, thing: Any) -> Sequence[Field]:
        """Return its fields."""

    @abstractmethod
    def signal_of(self, thing: Any, field: str) -> str:
        """Return what one of its fields is called as a figure."""

    @abstractmethod
    def title_of(self, thing: Any, now_ns: int) -> tuple[str, str]:
        """Return what it is called, and what is said of it besides."""

    @abstractmethod
    def listed(self, model: BenchModel, width: int, height: int) -> Sequence[Text]:
        """Return the rows."""

    @abstractmethod
    def name_at(self, row: int) -> object:
        """Return what the one in a row is known by; None where none stands."""

    # --- what is seen

    def lines(self, model: BenchModel, width: int, height: int) -> Sequence[Text]:
        """Return the rows, or the one that is opened."""
        thing = self.pointed_at
        if not self.opened or thing is None:
            return self.listed(model, width, height)
        fields = self.fields_of(thing)
        plotted = [one.name for one in fields if self.signal_of(thing, one.name) in self.plotted]
        title, said = self.title_of(thing, model.ns)
        return opened_view(title, said, fields, width, height, field=self.field, plotted=plotted)

    @property
    def pointed_at(self) -> Any:
        """The one that is pointed at; None while none is."""
        return next((one for one in self.things() if self.name_of(one) == self.chosen), None)

    def forget(self) -> None:
        """Point at nothing."""
        self.chosen, self.opened = None, False

    def action_move(self, by: int) -> None:
        """Point at another one, or at another field of the one that is opened."""
        thing, things = self.pointed_at, self.things()
        if self.opened and thing is not None:
            self.field = max(0, min(len(self.fields_of(thing)) - 1, self.field + by))
        elif things:
            at = things.index(thing) + by if thing is not None else 0
            self.chosen = self.name_of(things[max(0, min(len(things) - 1, at))])
        self.refresh()

    def choose_row(self, row: int) -> None:
        """Point at what stands in a row; open or plot it if it is pointed at."""
        before = self.chosen, self.field
        if self.opened:
            self.action_move(row - 1 - self.field)
        else:
            self.chosen = self.name_at(row) or self.chosen
        if (self.chosen, self.field) == before:
            self.action_open()
        self.refresh()

    def action_open(self) -> None:
        """Show it field by field; plot the field that is pointed at, or do so no more."""
        if self.chosen is None:
            self.action_move(0)
        thing = self.pointed_at
        fields = self.fields_of(thing) if thing is not None else ()
        if self.opened and self.field < len(fields):
            field = fields[self.field]
            if field.numbers:
                self.post_message(self.Plotted(self.signal_of(thing, field.name)))
        else:
            self.opened, self.field = thing is not None, 0
        self.refresh()

    def action_back(self) -> None:
        """Close it; then point at none; then give the screen back."""
        if self.opened:
            self.opened = False
        elif self.chosen is not None:
            self.chosen = None
        else:
            self.app.action_unzoom()  # type: ignore[attr-defined]
        self.refresh()
