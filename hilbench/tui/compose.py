"""The form of a message: its fields, edited, the bytes that they make, and a button that sends them."""

from __future__ import annotations

from collections.abc import Iterator

from textual.app import ComposeResult
from textual.binding import Binding
from textual.containers import Horizontal, Vertical, VerticalScroll
from textual.content import Content
from textual.widgets import Button, Input, Label, Static

from hilbench.tui.dialogs import Dialog
from hilbench.tui.model.editing import can_be_edited, edited, text_in, values_of
from hilbench.tui.model.frames import FrameModel

__all__ = ["ComposeScreen"]

_SHOWN_BYTES = 64


class ComposeScreen(Dialog[bytes]):
    """See the module.

    Args:
        frame: the last frame of the message; its values stand in the form at first.
    """

    BINDINGS = [Binding("escape", "dismiss", "Close"), Binding("ctrl+s", "send", "Send")]

    def __init__(self, frame: FrameModel) -> None:
        super().__init__()
        self._frame = frame
        self._values = values_of(frame.item.message)

    def compose(self) -> ComposeResult:
        """Show the form."""
        on = f" on the line '{self._frame.line}'" if self._frame.line else ""
        with Vertical(classes="dialog"):
            yield Label(f"Send {self._frame.item.name} to the target{on}")
            with VerticalScroll(id="message", can_focus=False):
                yield from self._rows()
            yield Static(id="bytes")
            with Horizontal(classes="buttons"):
                yield Button("Send (ctrl+s)", id="send", variant="warning")
                yield Button("Close (esc)", id="close")

    def _rows(self) -> Iterator[Horizontal]:
        for name, value in self._values.items():
            shown = Input(text_in(value), id=f"field-{name}", disabled=not can_be_edited(value), compact=True)
            yield Horizontal(Label(name), shown, classes="row")

    def on_mount(self) -> None:
        """Show the bytes of what stands there."""
        self._look()

    def on_input_changed(self) -> None:
        """Show the bytes that it makes now."""
        self._look()

    def on_input_submitted(self) -> None:
        """Go to the next field: what goes to a port is sent by the button or ctrl+s alone."""
        self.focus_next()

    def on_button_pressed(self, event: Button.Pressed) -> None:
        """Send it, or do not."""
        if event.button.id == "send":
            self.action_send()
        else:
            self.dismiss(None)

    def action_send(self) -> None:
        """Send what stands there, if it makes a frame."""
        try:
            self.dismiss(self._made())
        except ValueError:
            self._look()

    def _made(self) -> bytes:
        typed = {str(one.id).removeprefix("field-"): one.value for one in self.query(Input) if not one.disabled}
        return self._frame.made_anew(edited(self._frame.item.message, typed))

    def _look(self) -> None:
        try:
            data, why = self._made(), ""
        except ValueError as error:
            data, why = b"", str(error)
        more = " ..." if len(data) > _SHOWN_BYTES else ""
        said = why or f"{len(data)} bytes: {data[:_SHOWN_BYTES].hex(' ').upper()}{more}"
        self.query_one("#bytes", Static).update(Content.styled(said, "$text-error" if why else "$text-muted"))
        self.query_one("#send", Button).disabled = bool(why)
