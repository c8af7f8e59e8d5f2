"""The pane of messages: each with its rate and last fields; one of them field by field, and which are plotted."""

from __future__ import annotations

from collections.abc import Sequence

from rich.text import Text
from textual.binding import Binding
from textual.message import Message

from hilbench.tui.model.bench import BenchModel
from hilbench.tui.model.frames import MessageModel
from hilbench.tui.model.signals import field_signal
from hilbench.tui.panes import RowsPane
from hilbench.tui.views.messages import message_view, messages_view

__all__ = ["MessagesPane"]


class MessagesPane(RowsPane):
    """See the module.

    Attributes:
        chosen: the message that is pointed at, as of `FrameModel.message`; None while none is.
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

    def __init__(self) -> None:
        super().__init__("messages")
        self.chosen: tuple[str, bool, str] | None = None
        self.opened = False
        self.field = 0
        self.plotted: Sequence[str] = ()
        self._above = 0

    def lines(self, model: BenchModel, width: int, height: int) -> Sequence[Text]:
        """Return the messages, or the one that is opened."""
        message = self.pointed_at
        if not self.opened or message is None:
            return messages_view(model.messages, width, height, model.ns, chosen=self.chosen)
        plotted = [one.name for one in message.latest.fields if field_signal(message.latest, one.name) in self.plotted]
        return message_view(message, width, height, model.ns, field=self.field, plotted=plotted)

    @property
    def pointed_at(self) -> MessageModel | None:
        """The message that is pointed at."""
        return next((one for one in self._messages() if one.latest.message == self.chosen), None)

    def forget(self) -> None:
        """Point at nothing."""
        self.chosen, self.opened = None, False

    def action_move(self, by: int) -> None:
        """Point at another message, or at another field of the one that is opened."""
        message, messages = self.pointed_at, self._messages()
        if self.opened and message is not None:
            self.field = max(0, min(len(message.latest.fields) - 1, self.field + by))
        elif messages:
            at = messages.index(message) + by if message is not None else 0
            self.chosen = messages[max(0, min(len(messages) - 1, at))].latest.message
        self.refresh()

    def choose_row(self, row: int) -> None:
        """Point at what stands in a row; open or plot it if it is pointed at."""
        before = self.chosen, self.field
        if self.opened:
            self.action_move(row - 1 - self.field)
        else:
            messages = self._messages()
            if 1 <= row <= len(messages):
                self.chosen = messages[row - 1].latest.message
        if (self.chosen, self.field) == before:
            self.action_open()
        self.refresh()

    def action_open(self) -> None:
        """Show the message field by field; plot the field that is pointed at, or do so no more."""
        if self.chosen is None:
            self.action_move(0)
        message = self.pointed_at
        if self.opened and message is not None and self.field < len(message.latest.fields):
            field = message.latest.fields[self.field]
            if field.numbers:
                self.post_message(self.Plotted(field_signal(message.latest, field.name)))
        else:
            self.opened, self.field = message is not None, 0
        self.refresh()

    def action_back(self) -> None:
        """Close the message; then point at none; then give the screen back."""
        if self.opened:
            self.opened = False
        elif self.chosen is not None:
            self.chosen = None
        else:
            self.app.action_unzoom()  # type: ignore[attr-defined]
        self.refresh()

    def _messages(self) -> list[MessageModel]:
        return [] if self.model is None else self.model.messages
