"""Watchdogs and other timers as bars that run down, and deadlines that were missed in a row."""

from __future__ import annotations

from rich.text import Text

from hilbench.tui.model.bench import BenchModel
from hilbench.tui.model.machines import TimerModel
from hilbench.tui.views.words import BAD, DIM, GOOD, HEAD, bar, fit, ns_words

__all__ = ["timers_view"]

_NEAR = 0.25
"""The share of a timer that is left when it is shown as near its end."""
_WITH_LAST = 70


def timers_view(model: BenchModel, width: int) -> list[Text]:
    """Return the timers of every machine as bars that run down, and what was missed in a row."""
    lines: list[Text] = []
    machines = [machine for machine in model.machines.values() if machine.timers or machine.misses]
    names = [name for machine in machines for name in (*machine.timers, *map(_missed, machine.misses))]
    column = max(11, *(len(name) + 1 for name in names), 0)
    for machine in machines:
        lines.append(fit(Text(machine.title, HEAD), width))
        lines += [fit(_timer(name, timer, model.ns, width, column), width) for name, timer in machine.timers.items()]
        lines += [fit(_misses(name, about, width, column), width) for name, about in machine.misses.items()]
    return lines or [Text("no timer has run yet", DIM)]


def _timer(name: str, timer: TimerModel, now_ns: int, width: int, column: int) -> Text:
    room = _room(width, column)
    left_ns = timer.left_ns(now_ns)
    if left_ns is None:
        return Text.assemble(f"  {name:<{column}}", (" " * room + f"{'stopped':>10}", DIM), _margins(timer, width))
    share = left_ns / max(1, timer.span_ns)
    style = BAD if share < _NEAR and timer.worst_ns is not None else GOOD
    shown = (bar(share, room), style), f" {ns_words(left_ns):>9}"
    return Text.assemble(f"  {name:<{column}}", *shown, _margins(timer, width))


def _misses(name: str, about: tuple[int, int, int], width: int, column: int) -> Text:
    """Return how many deadlines were missed in a row: the bar grows, and at its end something happens."""
    now, most, worst = about
    share = now / max(1, most)
    said = f" {f'{now} of {most}':>9}"
    style = BAD if share > 1 - _NEAR else DIM if not now else ""
    shown = (bar(share, _room(width, column)), style), said, (f"  most {worst}", DIM)
    return Text.assemble(f"  {_missed(name):<{column}}", *shown)


def _missed(name: str) -> str:
    return f"{name} missed"


def _room(width: int, column: int) -> int:
    """Return how long a bar may be: behind it stand what is left, and one margin, or two where there is room."""
    return max(6, width - column - (42 if width >= _WITH_LAST else 26))


def _margins(timer: TimerModel, width: int) -> Text:
    """Return the margins: the least that was ever left, and where there is room what was the last time."""
    said = Text()
    if timer.worst_ns is not None:
        bad = 0 < timer.worst_ns < _NEAR * timer.span_ns
        said.append(f"  min {ns_words(timer.worst_ns)}" if timer.worst_ns else "  ran out", BAD if bad else DIM)
    if timer.span_ns and (timer.worst_ns is None or timer.is_fast):
        said.append(f"  of {ns_words(timer.span_ns)}", DIM)
    elif timer.margin_ns and width >= _WITH_LAST:
        said.append(f"  last {ns_words(timer.margin_ns)}", DIM)
    return said
