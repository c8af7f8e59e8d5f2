"""The pages of docs/carla that are made from the code, for `generate.py`."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import fields
from typing import Any

from protocols.carla import (
    COMMAND_LAYOUT,
    DEADLINES,
    LINK_TABLE,
    MODE_TABLE,
    PARSER_TABLE,
    PROFILES,
    QUIRKS,
    STATUS_LAYOUT,
    STEP_TABLE,
    VECTORS,
    X_AXIS,
    Y_AXIS,
    DropReason,
    Layout,
    Mode,
)
from protocols.carla.clause import Clause
from protocols.carla.clauses import CLAUSES

Table = Callable[[Sequence[str], Iterable[Sequence[str]]], str]
Machine = Callable[[str, Any], str]

MEANINGS = {
    "steering": ("tyre angle x 1.2, rad, positive to the left", "steer, -1 to 1, CARLA's: positive to the right"),
    "steering_rate": ("its rate x 1.2, rad/s", "0"),
    "speed": ("speed, m/s", "throttle, 0 to 1"),
    "acceleration": ("acceleration, m/s^2", "brake, 0 to 1"),
    "jerk": ("jerk, m/s^3", "0"),
    "mode": ("1", "4"),
}
STATUS_MEANINGS = {
    "lon_speed_m_s": "longitudinal speed, m/s",
    "lat_speed_m_s": "lateral speed, m/s",
    "heading_rate_rad_s": "heading rate, rad/s",
    "steering_rad": "tyre angle, rad, positive to the left",
}


def states_page(table: Table, machine: Machine) -> str:
    """The modes, the control task, the simulator's side, the deadlines and the original's parser."""
    return (
        "# Who rules, and when\n\n"
        "All of this is data in `protocols/carla/states.py`. The board has a mode, and a control task that goes "
        "through its loop step by step; the original's is one FreeRTOS task (LMA-FEM-UNICAMP/microAutoware, "
        "taksControl.c). A pair without an edge changes nothing.\n\n"
        + _modes(table)
        + "\n"
        + _deadlines(table)
        + "\n"
        + machine("The control task", STEP_TABLE)
        + "\n"
        + machine("The simulator's side", LINK_TABLE)
        + "\n"
        + _parser(table)
    )


def _modes(table: Table) -> str:
    edges = [
        f"    {old.name} --> {edge.next_mode.name}: {trigger.name}"
        for (old, trigger), edge in MODE_TABLE.items()
        if edge.next_mode is not old
    ]
    rows = [
        (f"`{old.name}`", f"`{trigger.name}`: {trigger.value}", f"`{edge.next_mode.name}`", edge.source)
        for (old, trigger), edge in MODE_TABLE.items()
    ]
    return (
        "## The modes\n\nThe board starts as if in AUTOWARE, and waits for the driving stack's agent before it does "
        "anything. Lamps: AUTOWARE amber LD2, MANUAL green LD1, EMERGENCY red LD3.\n\n"
        + "\n".join(["```mermaid", "stateDiagram-v2", "    [*] --> AUTOWARE", *edges, "```", "", ""])
        + table(("Mode", "Trigger", "Next", "Source"), rows)
        + "\nIn each turn of its loop the control task looks for a request of the driving stack, then for a press of "
        "the joystick, then comes the block of AUTOWARE, that of MANUAL, that of EMERGENCY: a mode that one of "
        "them chooses is acted on in the same turn. A press in EMERGENCY is used up.\n"
    )


def _deadlines(table: Table) -> str:
    rows = [
        (f"`{one.name}`", f"{one.value_s * 1000:g} ms", str(one.misses), one.text, one.on_miss, one.source)
        for one in DEADLINES.values()
    ]
    return (
        "## The deadlines\n\n"
        + table(("Option", "Time", "Misses", "What is waited for", "Without it, in the original", "Source"), rows)
        + "\nThe hardened board keeps all of these. Without a command it sends, in place of the frame before, one with "
        "the steering of the last command and speed 0, and nothing at all before its first frame; without a status it "
        "reports nothing; it counts missing statuses while commands are missing, too; a status that waited longer than "
        "its deadline is no answer; and a driving stack that gives no sign for 3 s (a choice) counts as lost.\n"
    )


def _parser(table: Table) -> str:
    rows = [
        (f"`{state.name}`: {state.value}", f"`{trigger.name}`: {trigger.value}", f"`{following.name}`")
        for (state, trigger), following in PARSER_TABLE.items()
    ]
    reasons = [(f"`{reason.name}`", reason.value) for reason in DropReason]
    return (
        "## The original's parser\n\nThe same on both sides but for its letters. Fields are written as they "
        "come, in any order; (`FIELDS`, `END`) is a complete frame, whatever it had.\n\n"
        + table(("State", "Byte", "Next"), rows)
        + "\nThe hardened readers want every letter in its place, search what failed for the next `#`, and say why "
        "something was dropped:\n\n" + table(("Reason", "Meaning"), reasons)
    )


def frames_page(table: Table) -> str:
    """Both frames, their meaning mode by mode, examples, the joystick, profiles and quirks."""
    return (
        "# Frames of the simulator's line\n\n"
        "921600 baud, 8N1, no flow control. Floats are IEEE-754 binary32, little-endian. No length, no checksum, no "
        "escape, no number.\n\n"
        f"## Status: simulator to board, {STATUS_LAYOUT.length} bytes\n\n"
        + table(("Offset", "Letter", "Field"), _layout_rows(STATUS_LAYOUT, STATUS_MEANINGS))
        + f"\n## Command: board to simulator, {COMMAND_LAYOUT.length} bytes and a NUL\n\n"
        + _command_table(table)
        + "\nIn EMERGENCY, mode 0, all fields are 0. The NUL ends a C string in the original and is sent with the "
        "rest; 29 bytes without it are read as well.\n\n## Examples\n\n"
        + table(
            ("Id", "What it is", "Bytes"), [(name, one.text, f"`{_hex(one.data)}`") for name, one in VECTORS.items()]
        )
        + "\n## What can be\n\n"
        "`hardened` drops what is beyond these limits, in either direction, as damaged; all are assumed, far beyond "
        "what a car does.\n\n" + _limits_table(table) + "\n## The joystick\n\n"
        "A reading within the dead band around zero is 0; above it grows to 1 at the greatest, below it falls to -1 at "
        "the least. Steer is minus X, the upper half of Y is throttle, the lower half brake. The original does "
        "not clamp: a reading of 0 is a brake of 1.033.\n\n"
        + table(
            ("Axis", "Least", "Zero", "Greatest", "Dead band"),
            [
                (name, str(axis.least), str(axis.zero), str(axis.greatest), str(axis.dead_band))
                for name, axis in (("X, PF12, ADC1_INP6", X_AXIS), ("Y, PF11, ADC1_INP2", Y_AXIS))
            ],
        )
        + "\n## Profiles\n\n"
        + table(("Name", "What it is"), [(one.name, one.text) for one in PROFILES.values()])
        + "\n## Quirks\n\nEach is a set of options on top of `hardened` (`with_quirks`). H1 to H9 are the hazards of "
        "the published system, V1 the flag clash of its last firmware.\n\n"
        + table(
            ("Name", "What it does", "Board", "Simulator's side", "Source"),
            [
                (one.name, one.text, _settings(one.board), _settings(one.simulator), one.source)
                for one in QUIRKS.values()
            ],
        )
    )


def _limits_table(table: Table) -> str:
    """The limits of a status, and those of a command, which hold at the board after the factor and at the simulator."""
    board = PROFILES["hardened"].board
    kinds = (("status", board.status_limits), ("command", board.command_limits))
    rows = [
        (what, f"`{one.name}`", f"{getattr(limits, one.name):g}")
        for what, limits in kinds
        if limits is not None
        for one in fields(limits)
    ]
    return table(("Of a", "Figure", "Limit"), rows)


def _layout_rows(layout: Layout, meanings: dict[str, str]) -> list[tuple[str, str, str]]:
    at, rows = 1, [("0", "`#`", "")]
    for field in layout.fields:
        rows.append((f"{at} to {at + field.size}", f"`{chr(field.tag)}`", meanings[field.name]))
        at += 1 + field.size
    return [*rows, (str(at), "`$`", "")]


def _command_table(table: Table) -> str:
    plain = _layout_rows(COMMAND_LAYOUT, dict.fromkeys(MEANINGS, ""))
    both = [("", ""), *MEANINGS.values(), ("", "")]
    rows = [(at, letter, *texts) for (at, letter, _), texts in zip(plain, both, strict=True)]
    rows.append((str(COMMAND_LAYOUT.length), "`00`", "", ""))
    return table(("Offset", "Letter", f"AUTOWARE, {Mode.AUTOWARE:d}", f"MANUAL, {Mode.MANUAL:d}"), rows)


def _settings(options: Any) -> str:
    return ", ".join(f"`{name}`: {getattr(value, 'name', value)}" for name, value in options.items())


def _hex(data: bytes) -> str:
    return data.hex(" ").upper()


def _needs(clause: Clause) -> str:
    return ", ".join(clause.needs) + ("; by hand" if clause.by_hand else "")


def clauses_page(table: Table) -> str:
    """Every clause of both ends, with its profiles."""
    text = (
        "# What a vehicle-interface board and its simulator must do\n\n"
        "A clause belongs to profiles: *hardened* is what we ask, *v0* and *v1* what was shipped. Where shipped "
        "behaviour is a hazard, its twin says what is asked instead. F1 to F7 are frames of "
        "[frames.md](frames.md); a *status* is a frame like F4, a *command* one of the driving stack; where "
        "nothing is said they come at 20 and 30 Hz. Times hold within one tick, 1 ms, beside what the bench "
        "cannot tell apart. *By hand* somebody beside a board at ports does or sees what is needed, with "
        "`--operator`.\n\n"
    )
    head = ("Id", "Level", "Profiles", "Text", "Twin", "Needs", "Source")
    for suite in dict.fromkeys(clause.suite for clause in CLAUSES):
        rows = [
            (one.id, one.level, ", ".join(one.profiles), one.text, one.twin or "", _needs(one), one.source)
            for one in CLAUSES
            if one.suite == suite
        ]
        text += f"## {suite}: {len(rows)} clauses\n\n" + table(head, rows) + "\n"
    return text
