"""What happened, a line each: changes of state, faults, what somebody did, what firmware said."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from hilbench.plugins.dashboard import Dashboard
from hilbench.tui.model.machines import is_change

__all__ = ["LogLine", "LogModel", "line_of"]

Event = Mapping[str, Any]
KEPT_LINES = 1000


@dataclass(slots=True)
class LogLine:
    """A line; `count` times in a row, the last time at `ns`."""

    ns: int
    source: str
    text: str
    bad: bool = False
    count: int = 1


class LogModel:
    """The latest lines.

    Args:
        dashboard: says what makes no line, and what is bad.
    """

    def __init__(self, dashboard: Dashboard) -> None:
        self.lines: deque[LogLine] = deque(maxlen=KEPT_LINES)
        self.errors = 0
        self._dashboard = dashboard

    def take(self, event: Event) -> None:
        """Take an event; most of them make no line."""
        found = line_of(event, self._dashboard)
        if found is None:
            return
        self.say(event["ns"], event["source"], *found)

    def say(self, ns: int, source: str, text: str, bad: bool = True) -> None:
        """Add a line; the one before, once more, if it says the same."""
        self.errors += bad
        last = self.lines[-1] if self.lines else None
        if last is not None and (last.source, last.text) == (source, text):
            last.count += 1
            last.ns = ns
            return
        self.lines.append(LogLine(ns, source, text, bad))


def line_of(event: Event, dashboard: Dashboard) -> tuple[str, bool] | None:
    """Return the text of an event, and whether it tells of something bad; None if it is for the other panes."""
    if event["kind"] == "event":
        return _reported(event, dashboard)
    said = _SAID.get(event["kind"]) or dashboard.said.get(event["kind"])
    return None if said is None else said(event)


def _reported(event: Event, dashboard: Dashboard) -> tuple[str, bool] | None:
    name, value = event["name"], event.get("value", {})
    if name in dashboard.routine:
        return None
    if is_change(value):
        return f"{value['old']} -> {value['new']} ({value['trigger']})", False
    if name == "FrameDropped":
        data = value.get("data", "")
        return f"dropped {value.get('reason', '')}: {data[:24]}{'...' if len(data) > 24 else ''}", True
    about = " ".join(f"{key}={_short(one)}" for key, one in value.items())
    return f"{name} {about}".strip(), name in dashboard.bad


def _action(event: Event) -> str:
    about = " ".join(f"{key}={_short(one)}" for key, one in event.get("with", {}).items())
    return f"you: {event['do']} {about}".strip()


def _short(value: Any) -> str:
    text = "..." if isinstance(value, dict | list) else f"{value:.5g}" if isinstance(value, float) else str(value)
    return text if len(text) <= 32 else f"{text[:31]}…"


def _note(event: Event) -> str:
    return f"{event.get('note', 'note')}: {event.get('where', '')} {event.get('text', '')}".strip()


def _end(event: Event) -> str:
    return f"the firmware ended: {event.get('cause', '')} {event.get('at', '')}".strip()


def _console(event: Event) -> str:
    return "says " + bytes.fromhex(event["data"]).decode("utf-8", errors="replace").strip()


def _clock(event: Event) -> str:
    return f"{'paused' if event['paused'] else 'runs'} at {event['speed']:g} x"


_SAID: Mapping[str, Callable[[Event], tuple[str, bool] | None]] = {
    "fault": lambda event: (f"fault: {event['fault']} towards {event['towards']}", True),
    "fault-refused": lambda event: (f"fault: {event['fault']} did not strike: {event['text']}", True),
    "action": lambda event: (_action(event), False),
    "refused": lambda event: (f"refused: {event['do']}: {event.get('cause', '')}", True),
    "driver": lambda event: (f"driver: {event['who']}", False),
    "line": lambda event: (f"line {'up' if event['up'] else 'down'}", not event["up"]),
    "baud": lambda event: (f"{event['baud']} baud", False),
    "reset": lambda event: (f"reset: {event.get('reason', '')}", False),
    "note": lambda event: (_note(event), True),
    "end": lambda event: (_end(event), True),
    "console": lambda event: (_console(event), False),
    "stimulus": lambda event: (f"stimulus {event['text']}", False),
    "clock": lambda event: (_clock(event), False),
}
