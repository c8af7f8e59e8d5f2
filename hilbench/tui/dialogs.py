"""What asks and what explains: help, leaving, a fault to put in, a word, a suite, one of several, some of several."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TypeVar

from textual import events
from textual.app import ComposeResult
from textual.binding import Binding
from textual.containers import Horizontal, Vertical, VerticalScroll
from textual.content import Content
from textual.markup import MarkupError
from textual.screen import ModalScreen
from textual.widgets import Button, Input, Label, OptionList, Select, Static
from textual.widgets.option_list import Option

__all__ = [
    "Dialog",
    "HelpScreen",
    "InjectScreen",
    "LeaveScreen",
    "PanesScreen",
    "PickScreen",
    "SuiteScreen",
    "ToggleScreen",
    "WordScreen",
]


Answer = TypeVar("Answer")


class Dialog(ModalScreen[Answer]):
    """What stands above the panes; a click beside it closes it without an answer."""

    def on_click(self, event: events.Click) -> None:
        """Close it, if nothing of it was clicked on."""
        if event.widget is self:
            self.dismiss(None)


def _content(text: str) -> Content:
    """Return text of which some may be a plug-in's: as it stands where its markup is wrong."""
    try:
        return Content.from_markup(text)
    except MarkupError:
        return Content(text)


class HelpScreen(Dialog[None]):
    """What everything means.

    Args:
        text: in Textual's markup.
    """

    BINDINGS = [Binding("escape,q,question_mark", "dismiss", "Close")]

    def __init__(self, text: str) -> None:
        super().__init__()
        self._text = text

    def compose(self) -> ComposeResult:
        """Show the text."""
        with VerticalScroll(id="help", classes="dialog"):
            yield Static(_content(self._text))

    def on_mount(self) -> None:
        """Let the arrows scroll."""
        self.query_one("#help").focus()


class LeaveScreen(Dialog[str]):
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


class WordScreen(Dialog[str]):
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


class SuiteScreen(Dialog[tuple[str, str]]):
    """A suite, and which of its clauses.

    Args:
        suites: those of the bench, each with a few of its clauses as an example.
    """

    BINDINGS = [Binding("escape", "dismiss", "Close"), Binding("ctrl+s", "run", "Run")]

    def __init__(self, suites: Mapping[str, Sequence[str]]) -> None:
        super().__init__()
        self._suites = suites

    def compose(self) -> ComposeResult:
        """Ask."""
        with Vertical(classes="dialog"):
            yield Label("Run which suite? On a fresh bench; the live one goes on meanwhile.")
            yield OptionList(*(Option(suite, id=suite) for suite in self._suites), id="suites")
            yield Label("Only these clauses or words; empty: all of them", classes="hint")
            yield Input(id="select")
            with Horizontal(classes="buttons"):
                yield Button("Run (ctrl+s)", id="run", variant="primary")
                yield Button("Close (esc)", id="close")

    def on_mount(self) -> None:
        """Let enter take the first suite at once."""
        self.query_one("#suites").focus()

    def on_option_list_option_highlighted(self, event: OptionList.OptionHighlighted) -> None:
        """Give an example that fits the suite."""
        self.query_one("#select", Input).placeholder = " or ".join(self._suites[str(event.option_id)])

    def on_option_list_option_selected(self) -> None:
        """Take the answer."""
        self.action_run()

    def on_input_submitted(self) -> None:
        """Take the answer."""
        self.action_run()

    def on_button_pressed(self, event: Button.Pressed) -> None:
        """Take the answer, or none."""
        if event.button.id == "run":
            self.action_run()
        else:
            self.dismiss(None)

    def action_run(self) -> None:
        """Take the answer."""
        suite = list(self._suites)[self.query_one("#suites", OptionList).highlighted or 0]
        self.dismiss((suite, self.query_one("#select", Input).value.strip()))


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


class InjectScreen(Dialog[dict[str, object]]):
    """A fault for the line.

    Args:
        lines: our ends of the lines; where there are several, one is asked for.
    """

    BINDINGS = [Binding("escape", "dismiss", "Close"), Binding("ctrl+s", "put", "Put in")]

    def __init__(self, lines: Sequence[str] = ()) -> None:
        super().__init__()
        self._lines = lines if len(lines) > 1 else ()

    def compose(self) -> ComposeResult:
        """Show the form."""
        with Vertical(classes="dialog"):
            yield Label("Put a fault on the line")
            yield Select([(text, kind) for kind, text in _KINDS.items()], value="noise", allow_blank=False, id="kind")
            yield Select(
                [("towards the target", "target"), ("towards us", "operator")],
                value="target", allow_blank=False, id="towards",
            )  # fmt: skip
            if self._lines:
                choices = [(f"on the line '{line}'", line) for line in self._lines]
                yield Select(choices, value=self._lines[0], allow_blank=False, id="line")
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
        if self._lines:
            asked["line"] = str(self.query_one("#line", Select).value)
        if kind not in _OF_THE_LINE and percent:
            asked["probability"] = min(1.0, percent / 100)
        if kind in _COUNTED:
            asked["count"] = max(1, round(_number(self.query_one("#count", Input).value) or 1))
        if kind in _LASTING:
            asked["duration_s"] = max(0.001, _number(self.query_one("#seconds", Input).value) or 0.5)
        if kind == "baud":
            asked["baud"] = 19_200
        self.dismiss(asked)


class PickScreen(Dialog[str]):
    """One of several.

    Args:
        question: what is asked.
        choices: names and what they are.
        at: the one that is pointed at first; the first if empty.
        look: is called with the one that is pointed at.
    """

    BINDINGS = [Binding("escape", "dismiss", "Close")]

    def __init__(
        self,
        question: str,
        choices: Sequence[tuple[str, str]],
        *,
        at: str = "",
        look: Callable[[str], None] = lambda _: None,
    ) -> None:
        super().__init__()
        self._question, self._choices = question, choices
        self._at, self._look = at, look

    def compose(self) -> ComposeResult:
        """Show the list."""
        with Vertical(classes="dialog"):
            yield Label(self._question)
            breadth = max([16, *(len(name) for name, _ in self._choices)])
            yield OptionList(*(Option(_bold(f"{name:<{breadth}} ", text), id=name) for name, text in self._choices))

    def on_mount(self) -> None:
        """Point at one."""
        names = [name for name, _ in self._choices]
        if self._at in names:
            self.query_one(OptionList).highlighted = names.index(self._at)

    def on_option_list_option_highlighted(self, event: OptionList.OptionHighlighted) -> None:
        """Tell who wants to see it."""
        self._look(str(event.option_id))

    def on_option_list_option_selected(self, event: OptionList.OptionSelected) -> None:
        """Take the answer."""
        self.dismiss(str(event.option_id))

    def on_key(self, event: events.Key) -> None:
        """Let nothing through to the screen below."""
        if event.key in {"w", "a", "s", "d"}:
            event.stop()


class ToggleScreen(Dialog[None]):
    """Some of several; each choice is in force at once.

    Args:
        question: what is asked.
        rows: gives names, whether each is chosen, and what it is.
        toggle: chooses one, or does so no more.
    """

    BINDINGS = [Binding("escape,q,P,L", "dismiss", "Close")]
    HINT = "enter, space or a click: shown or not; escape: back"

    def __init__(
        self, question: str, rows: Callable[[], Sequence[tuple[str, bool, str]]], toggle: Callable[[str], None]
    ) -> None:
        super().__init__()
        self._question, self._rows, self._toggle = question, rows, toggle

    def compose(self) -> ComposeResult:
        """Show the list."""
        with Vertical(classes="dialog"):
            yield Label(self._question)
            yield OptionList(id="several")
            yield Label(self.HINT, classes="hint")

    def on_mount(self) -> None:
        """Fill the list."""
        self.fill()

    def fill(self, name: str = "") -> None:
        """Show what is chosen now, with one of them pointed at."""
        several = self.query_one("#several", OptionList)
        at = several.highlighted or 0
        rows = self._rows()
        several.clear_options()
        several.add_options([Option(_bold(f"{'●' if on else '○'} {one:<14} ", text), id=one) for one, on, text in rows])
        names = [one for one, _, _ in rows]
        several.highlighted = names.index(name) if name in names else min(at, len(names) - 1) if names else None

    @property
    def pointed_at(self) -> str:
        """The one that is pointed at."""
        several = self.query_one("#several", OptionList)
        return "" if several.highlighted is None else str(several.get_option_at_index(several.highlighted).id)

    def on_key(self, event: events.Key) -> None:
        """Take space for enter, and let nothing of it through to the screen below."""
        if event.key == "space":
            event.stop()
            if self.pointed_at:
                self._toggle(self.pointed_at)
                self.fill()

    def on_option_list_option_selected(self, event: OptionList.OptionSelected) -> None:
        """Choose it, or do so no more."""
        self._toggle(str(event.option_id))
        self.fill()


class PanesScreen(ToggleScreen):
    """Which panes, and where.

    Args:
        rows, toggle: as of `ToggleScreen`.
        move: moves a pane by so many columns, and so many places down.
        reset: arranges all as at first.
    """

    BINDINGS = [
        Binding("less_than_sign,left", "move(-1, 0)", "To the left"),
        Binding("greater_than_sign,right", "move(1, 0)", "To the right"),
        Binding("left_curly_bracket,shift+up", "move(0, -1)", "Up"),
        Binding("right_curly_bracket,shift+down", "move(0, 1)", "Down"),
        Binding("r", "reset", "As at first"),
    ]
    HINT = "enter: shown or not; left right: column; { }: up, down; r: as at first"

    def __init__(
        self,
        rows: Callable[[], Sequence[tuple[str, bool, str]]],
        toggle: Callable[[str], None],
        *,
        move: Callable[[str, int, int], None],
        reset: Callable[[], None],
    ) -> None:
        super().__init__("Which panes, and where?", rows, toggle)
        self._move, self._reset = move, reset

    def action_move(self, columns: int, places: int) -> None:
        """Move the pane that is pointed at."""
        name = self.pointed_at
        self._move(name, columns, places)
        self.fill(name)

    def action_reset(self) -> None:
        """Arrange all as at first."""
        self._reset()
        self.fill()


def _bold(name: str, text: str) -> Content:
    """Return a name and what it is; brackets in it are brackets, and no markup."""
    return Content.assemble((name, "bold"), text)


def _number(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None
