"""What a person at a vehicle-interface board sees: where the stick is, the switch, lights and lamps, who is there."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from rich.text import Text

from hilbench.plugins.dashboard import BAD, DIM, GOOD, HEAD

__all__ = ["COCKPIT_ROWS", "cockpit_view"]

_COLUMNS, _ROWS = 11, 5
COCKPIT_ROWS = _ROWS + 1
"""With the field of the stick; with fewer rows, its place is said in figures alone."""
_LIGHTS = {"green": "green", "amber": "yellow", "red": "red"}


def cockpit_view(seen: Mapping[str, Any], width: int, height: int = COCKPIT_ROWS) -> list[Text]:
    """Return the stick as seen from above, and beside it what can be read; what matters most first in a few rows.

    Args:
        seen: what the journal tells of the car and the board.
        width: cells in a line; what is longer is cut by whoever shows it.
        height: rows there are.
    """
    del width
    reached = [_reported(seen), _who(seen), _car(seen)]
    if seen["stick"] is None:  # of a board at two ports
        at_board = Text("joystick, lights and lamps are at the board, where nobody here sees them", DIM)
        return [at_board, *reached]
    beside = [_lights(seen), _lamps(seen), *reached]
    right, forward = seen["stick"]
    where = f"{right:+.2f} right  {forward:+.2f} ahead"
    if height < COCKPIT_ROWS:
        return [Text.assemble(("stick     ", HEAD), where), _reported(seen), _lights(seen), _lamps(seen), *reached[1:]]
    return [
        Text.assemble((" stick  ", HEAD), where),
        *(Text.assemble(stick, "  ", said) for stick, said in zip(_stick(right, forward), beside, strict=True)),
    ]


def _stick(right: float, forward: float) -> list[Text]:
    """Return the field of the stick; up is forward."""
    column = round((right + 1) / 2 * (_COLUMNS - 1))
    row = round((1 - forward) / 2 * (_ROWS - 1))
    lines = []
    for at in range(_ROWS):
        cells = ["─" if at == _ROWS // 2 else " "] * _COLUMNS
        cells[_COLUMNS // 2] = "┼" if at == _ROWS // 2 else "│"
        line = Text("".join(cells), DIM)
        if at == row:
            line = Text.assemble(("".join(cells[:column]), DIM), ("●", HEAD), ("".join(cells[column + 1 :]), DIM))
        lines.append(Text.assemble(" ", line))
    return lines


def _lights(seen: Mapping[str, Any]) -> Text:
    lit = seen["lights"]
    shown = [((f"● {name}" if name in lit else f"○ {name}"), _LIGHTS[name] if name in lit else DIM) for name in _LIGHTS]
    return Text.assemble(("lights    ", HEAD), *[part for one in shown for part in (one, " ")])


def _lamps(seen: Mapping[str, Any]) -> Text:
    left, right = seen["lamps"]
    pressed = seen["pressed"]
    return Text.assemble(
        ("lamps     ", HEAD), ("◀ lit" if left else "◁ off", "yellow" if left else DIM), "  ",
        ("lit ▶" if right else "off ▷", "yellow" if right else DIM),
        ("   switch ", HEAD), ("pressed" if pressed else "open", "" if pressed else DIM),
    )  # fmt: skip


def _reported(seen: Mapping[str, Any]) -> Text:
    return Text.assemble(("reported  ", HEAD), seen["reported"] or "nothing yet")


def _who(seen: Mapping[str, Any]) -> Text:
    stack = ("runs  ", GOOD) if seen["stack_on"] else ("PAUSED", BAD)
    simulator = ("runs", GOOD) if seen["simulator_on"] else ("PAUSED", BAD)
    return Text.assemble(("stack     ", HEAD), stack, ("   simulator ", HEAD), simulator)


def _car(seen: Mapping[str, Any]) -> Text:
    offset_m = seen["offset_m"]
    where = f"{abs(offset_m):.2f} m {'left' if offset_m >= 0 else 'right'}"
    said = f"{seen['speed_m_s'] * 3.6:.1f} km/h, tyres {math.degrees(seen['tyre_rad']):+.1f}°, {where}"
    return Text.assemble(("car       ", HEAD), said)
