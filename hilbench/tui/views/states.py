"""A state machine drawn from its table: a state a row, the present one lit, the last step an arrow beside them."""

from __future__ import annotations

from collections import Counter

from rich.text import Text

from hilbench.tui.model.machines import MachineModel
from hilbench.tui.views.words import DIM, HEAD, LIT, fit, seconds

__all__ = ["machine_view"]


def machine_view(machine: MachineModel, width: int, height: int, now_ns: int) -> list[Text]:
    """Return a state machine in so many rows at most.

    Where there is room, each state has its ways out below it; where there is none for all states, those far from the
    present one are left out.
    """
    head = Text.assemble((machine.title, HEAD), "  ", _why(machine, now_ns))
    states = machine.states
    if not states:
        return [fit(head, width), Text("no state is known", DIM)]
    rows = [_row(machine, state) for state in states]
    arrows = _arrows(states, machine)
    ways = {state: _ways(machine, state) for state in states}
    room = height - 1 - len(states)
    body: list[Text] = []
    order = sorted(states, key=lambda state: (state != machine.state, not machine.entries(state)))
    expanded = set(order[: max(0, room)])
    for state, row, arrow in zip(states, rows, arrows, strict=True):
        body.append(Text.assemble((arrow, "cyan"), row))
        if state in expanded and ways[state]:
            through = "│" if arrow in {"│ ", "╭─", "╭▶"} else " "
            body.append(Text.assemble((f"{through}     ", "cyan"), (ways[state], DIM)))
    body = _window(body, states.index(machine.state) if machine.state in states else 0, height - 1)
    return [fit(line, width) for line in (head, *body)]


def _why(machine: MachineModel, now_ns: int) -> Text:
    if not machine.state:
        return Text("nothing heard of it yet", DIM)
    by = f" by {machine.trigger}" if machine.trigger else ""
    return Text(f"{machine.state}{by}, for {seconds(max(0, now_ns - machine.since_ns))}")


def _row(machine: MachineModel, state: str) -> Text:
    lit = state == machine.state
    count = machine.entries(state)
    meaning = machine.table.get("states", {}).get(state, "")
    return Text.assemble(
        ("▶ " if lit else "  ", HEAD),
        (f" {state} ", LIT if lit else HEAD if count else DIM),
        (f" {count}x" if count else "", ""),
        (f"  {meaning}", DIM),
    )


def _ways(machine: MachineModel, state: str) -> str:
    """Return where a state leads, the ways that were taken first, with how often."""
    counts: Counter[str] = Counter()
    for before, trigger, after in machine.table.get("edges", ()):
        if before == state:
            counts[after if after != state else "itself"] += machine.visits.get((before, trigger), 0)
    taken = sorted(counts, key=lambda after: -counts[after])
    return (
        "to " + ", ".join(f"{after} {counts[after]}x" if counts[after] else after for after in taken) if taken else ""
    )


def _arrows(states: list[str], machine: MachineModel) -> list[str]:
    """Return the left margin: the way from the state before to the present one."""
    margin = ["  "] * len(states)
    if machine.came_from not in states or machine.state not in states or machine.came_from == machine.state:
        return margin
    begin, end = states.index(machine.came_from), states.index(machine.state)
    for row in range(min(begin, end) + 1, max(begin, end)):
        margin[row] = "│ "
    margin[begin] = "╭─" if begin < end else "╰─"
    margin[end] = "╰▶" if begin < end else "╭▶"
    return margin


def _window(lines: list[Text], wanted: int, height: int) -> list[Text]:
    """Return as many lines as there is room for, around a wanted one."""
    if len(lines) <= height:
        return lines
    begin = max(0, min(wanted - height // 2, len(lines) - height))
    return lines[begin : begin + height]
