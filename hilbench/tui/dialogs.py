"""What asks and what explains: help, leaving, a fault to put in, a word to mark a moment with, another bench."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from rich.text import Text
from textual import events
from textual.app import ComposeResult
from textual.binding import Binding
from textual.containers import Horizontal, Vertical, VerticalScroll
from textual.screen import ModalScreen
from textual.widgets import Button, Input, Label, OptionList, Select, Static
from textual.widgets.option_list import Option

from hilbench.tui.check_run import CheckRun

__all__ = ["CheckScreen", "HelpScreen", "InjectScreen", "LeaveScreen", "PickScreen", "WordScreen"]

HELP = """\
[b]What you see[/b]
Everything comes from the bench's journal, times are bench time. The bench is a process of its own: it does not wait
for this screen, and goes on without it.

[b]1 Link[/b]       bytes, rates, errors of the line; how well the host keeps up
[b]2 Watchdogs[/b]  timers running down; [i]min[/i]: the least that was ever left when one was fed
[b]3 Counters[/b]   of both ends; red counts what went wrong
[b]4 World[/b]      from above: the way in green, what the sonar hears in red
[b]5 Frames[/b]     > sent, < heard; [b]h[/b] holds the list, arrows point at a frame, [b]enter[/b] shows its bytes.
             [b]/[/b] filters: words that must be there, [b]-word[/b] must not, [b]>[/b] or [b]<[/b], [b]![/b] not sound
[b]6 States[/b]     each state of the table; lit: the present one; [i]3x[/i]: how often it was come to
[b]7 Pins[/b]       of emulated boards: level, the last two seconds, duty and period
[b]8 Log[/b]        changes of state, faults, what you did, what firmware says

[b]Keys[/b]
[b]1[/b] to [b]8[/b]       that pane alone; again, or [b]escape[/b]: all of them.  [b]tab[/b]: the next pane
[b]w a s d[/b]      drive, as arrows do outside of the frames; capitals: full speed. Hold the key: 0.7 s after
             it came last the vehicle stops (dead man). You take over from the demo driver.
[b]space[/b]        stop at once                        [b]o[/b]  let the demo driver go on
[b]c[/b]  [b]x[/b]         connect, disconnect                 [b]r[/b]  press the reset button of a board
[b]p[/b]  [b]n[/b]         pause or go on; 0.1 s further       [b]+[/b]  [b]-[/b]  twice as fast, half as fast
[b]i[/b]  [b]u[/b]         put a fault on the line; take all back
[b]m[/b]            mark this moment in the journal     [b]g[/b]  save the screen as SVG
[b]b[/b]  [b]t[/b]         another bench; check a fresh one    [b]q[/b]  leave: stop the bench, or detach from it
[b]ctrl+p[/b]       all commands by name

[b]Of a recording[/b]
[b]p[/b] plays; [b]left right[/b] a second, with shift ten; [b], .[/b] an event; [b]e[/b] the next error
"""


class HelpScreen(ModalScreen[None]):
    """What everything means."""

    BINDINGS = [Binding("escape,q,question_mark", "dismiss", "Close")]

    def compose(self) -> ComposeResult:
        """Show the text."""
        with VerticalScroll(id="help", classes="dialog"):
            yield Static(HELP)

    def on_mount(self) -> None:
        """Let the arrows scroll."""
        self.query_one("#help").focus()


class LeaveScreen(ModalScreen[str]):
    """Stop the bench, or let it run."""

    BINDINGS = [
        Binding("s", "leave('stop')", "Stop"),
        Binding("d", "leave('detach')", "Detach"),
        Binding("escape", "leave('stay')", "Stay"),
        Binding("left,up", "app.focus_previous", show=False),
        Binding("right,down", "app.focus_next", show=False),
    ]

    def compose(self) -> ComposeResult:
        """Ask."""
        with Vertical(classes="dialog"):
            yield Label("The bench is running. Leave it how?")
            with Horizontal(classes="buttons"):
                yield Button("Stop it (s)", id="stop", variant="error")
                yield Button("Detach (d)", id="detach", variant="primary")
                yield Button("Stay (esc)", id="stay")
            yield Label("Detached it goes on; 'hilbench attach' comes back to it.", classes="hint")

    def on_button_pressed(self, event: Button.Pressed) -> None:
        """Take the answer."""
        self.dismiss(str(event.button.id))

    def action_leave(self, answer: str) -> None:
        """Take the answer."""
        self.dismiss(answer)


class WordScreen(ModalScreen[str]):
    """One line of text.

    Args:
        question: what is asked.
        value: what stands there at first.
    """

    BINDINGS = [Binding("escape", "dismiss", "Close")]

    def __init__(self, question: str, value: str = "") -> None:
        super().__init__()
        self._question, self._value = question, value

    def compose(self) -> ComposeResult:
        """Ask."""
        with Vertical(classes="dialog"):
            yield Label(self._question)
            yield Input(self._value, id="word", max_length=200)

    def on_input_submitted(self, event: Input.Submitted) -> None:
        """Take the answer."""
        self.dismiss(event.value)


class CheckScreen(ModalScreen[None]):
    """A suite that runs, and what it finds.

    Args:
        run: the run; it ends when this is left.
    """

    BINDINGS = [Binding("escape,q", "leave", "Close")]

    def __init__(self, run: CheckRun) -> None:
        super().__init__()
        self._run = run

    def compose(self) -> ComposeResult:
        """Show what it says."""
        with Vertical(classes="dialog", id="check"):
            yield Label(f"{self._run.suite}, on a fresh bench of the same kind, in virtual time", id="check-head")
            with VerticalScroll(id="check-text"):
                yield Static(id="check-said")

    def on_mount(self) -> None:
        """Let the arrows scroll."""
        self.query_one("#check-text").focus()

    def look(self) -> None:
        """Show what it has said since."""
        if self._run.poll():
            self.query_one("#check-said", Static).update(Text(self._run.text))
            self.query_one("#check-text").scroll_end(animate=False)
            if self._run.code is not None:
                self.query_one("#check-head", Label).update(f"{self._run.suite}: exit code {self._run.code}. esc: back")

    def on_unmount(self) -> None:
        """End it."""
        self._run.stop()

    def action_leave(self) -> None:
        """Go back."""
        self.dismiss()


_KINDS: Mapping[str, str] = {
    "noise": "noise: random bytes before a byte",
    "drop": "drop: bytes are lost",
    "flip": "flip: a bit of a byte is inverted",
    "duplicate": "duplicate: bytes come twice",
    "truncate": "truncate: what waits is lost",
    "delay": "delay: the line idles before a byte",
    "break": "break: the line is held low",
    "disconnect": "disconnect: both ways",
    "baud": "baud: the sender at another rate",
}
_OF_THE_LINE = frozenset({"break", "disconnect", "baud"})
_LASTING = frozenset({"delay", *_OF_THE_LINE})
_COUNTED = frozenset({"noise", "drop", "flip", "duplicate"})


class InjectScreen(ModalScreen[dict[str, object]]):
    """A fault for the line."""

    BINDINGS = [Binding("escape", "dismiss", "Close"), Binding("ctrl+s", "put", "Put in")]

    def compose(self) -> ComposeResult:
        """Show the form."""
        with Vertical(classes="dialog"):
            yield Label("Put a fault on the line")
            yield Select([(text, kind) for kind, text in _KINDS.items()], value="noise", allow_blank=False, id="kind")
            yield Select(
                [("towards the target", "target"), ("towards us", "operator")],
                value="target", allow_blank=False, id="towards",
            )  # fmt: skip
            with Horizontal(classes="fields"):
                yield Input("5", id="percent", type="number", placeholder="percent of bytes; empty: once")
                yield Input("3", id="count", type="integer", placeholder="bytes")
                yield Input("0.5", id="seconds", type="number", placeholder="seconds")
            yield Label("percent of bytes (empty: once, now)  bytes  seconds", classes="hint")
            with Horizontal(classes="buttons"):
                yield Button("Put in (ctrl+s)", id="put", variant="warning")

    def on_button_pressed(self, _event: Button.Pressed) -> None:
        """Take the form."""
        self.action_put()

    def on_input_submitted(self, _event: Input.Submitted) -> None:
        """Take the form."""
        self.action_put()

    def action_put(self) -> None:
        """Take the form, as far as its fields mean anything for the kind."""
        kind = str(self.query_one("#kind", Select).value)
        percent = _number(self.query_one("#percent", Input).value)
        asked: dict[str, object] = {"kind": kind, "towards": str(self.query_one("#towards", Select).value)}
        if kind not in _OF_THE_LINE and percent:
            asked["probability"] = min(1.0, percent / 100)
        if kind in _COUNTED:
            asked["count"] = max(1, round(_number(self.query_one("#count", Input).value) or 1))
        if kind in _LASTING:
            asked["duration_s"] = max(0.001, _number(self.query_one("#seconds", Input).value) or 0.5)
        if kind == "baud":
            asked["baud"] = 19_200
        self.dismiss(asked)


class PickScreen(ModalScreen[str]):
    """One of several.

    Args:
        question: what is asked.
        choices: names and what they are.
    """

    BINDINGS = [Binding("escape", "dismiss", "Close")]

    def __init__(self, question: str, choices: Sequence[tuple[str, str]]) -> None:
        super().__init__()
        self._question, self._choices = question, choices

    def compose(self) -> ComposeResult:
        """Show the list."""
        with Vertical(classes="dialog"):
            yield Label(self._question)
            yield OptionList(*(Option(f"[b]{name:<16}[/b] {text}", id=name) for name, text in self._choices))

    def on_option_list_option_selected(self, event: OptionList.OptionSelected) -> None:
        """Take the answer."""
        self.dismiss(str(event.option_id))

    def on_key(self, event: events.Key) -> None:
        """Let nothing through to the screen below."""
        if event.key in {"w", "a", "s", "d"}:
            event.stop()


def _number(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None
