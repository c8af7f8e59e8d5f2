"""Every message that there was as a table."""

from __future__ import annotations

from collections.abc import Sequence

from rich.text import Text

from hilbench.tui.model.frames import MessageModel
from hilbench.tui.views.frames import fields_text
from hilbench.tui.views.words import DIM, HEAD, LIT, fit, ns_words

__all__ = ["messages_view"]

_WITH_COUNT = 80
"""With fewer columns there is room for the rate alone (choice)."""


def messages_view(
    messages: Sequence[MessageModel], width: int, height: int, now_ns: int, *, chosen: object = None
) -> list[Text]:
    """Return a message a line: its rate, how many there were, how old the last is, and what that says.

    Args:
        messages: those that there were.
        width: cells in a line.
        height: lines there are.
        now_ns: bench time.
        chosen: the message that is pointed at, see `FrameModel.message`.
    """
    if not messages:
        return [fit(Text("no message yet", DIM), width)]
    line = max(len(one.latest.line) for one in messages)
    name = min(max(len(one.latest.item.name) for one in messages), max(8, width // 3))
    at = next((number for number, one in enumerate(messages) if one.latest.message == chosen), 0)
    room = max(1, height - 1)
    begin = max(0, min(at - room // 2, len(messages) - room))
    shown = messages[begin : begin + room]
    rest = f"{'count':>7} {'last':>9}  fields" if width >= _WITH_COUNT else "fields"
    head = f"   {'':<{line + bool(line)}}{'message':<{name}} {'per s':>7}  {rest}"
    return [fit(Text(head, DIM), width), *(_line(one, line, name, width, now_ns, chosen) for one in shown)]


def _line(message: MessageModel, line: int, breadth: int, width: int, now_ns: int, chosen: object) -> Text:
    latest, points = message.latest, chosen == message.latest.message
    name = latest.item.name
    shown = name if len(name) <= breadth else f"{name[: breadth - 1]}…"
    text = Text.assemble(
        ("▸" if points else " ", HEAD),
        ("> " if latest.sent else "< ", "cyan" if latest.sent else "yellow"),
        (f"{latest.line:<{line}} " if line else "", DIM),
        (f"{shown:<{breadth}} ", HEAD),
        f"{message.per_s(now_ns):>7.1f}  ",
        (f"{message.count:>7} {ns_words(max(0, now_ns - latest.ns)):>9}  " if width >= _WITH_COUNT else "", DIM),
        fields_text(latest),
    )
    text = fit(text, width)
    return Text(f"{text.plain:<{width}}", LIT) if points else text
