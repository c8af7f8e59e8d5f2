"""The page of the campaign, made from its record."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

Row = Mapping[str, object]

NAMES = {
    "a": "pins straight to the wheels (`bluepill`)",
    "b": "pins over the P2OS adapter (`bluepill-robot`), the same image",
    "c": "P2OS by the program itself (`bluepill-p2os`)",
}

_HEAD = """\
# The dodger in twenty rooms, in three ways

Made by `make campaign` (`python -m measure.campaign`); the data is in [campaign.json](campaign.json). Do not edit.

The rooms are those of the scene `room-with-boxes`: 10 x 10 m, twelve boxes placed by the seed. Each drive is three
minutes of bench time, from the middle of the room. A *contact* is a step of the physics (240 in a second) at which any
part of the robot touches anything but the floor; the *clearance* is the least distance between the outlines of the
robot and of any box or wall, seen from above, ten times a second. What the suite `bluepill-dodge` requires of a drive
is in [bluepill.md](bluepill.md#the-dodger).

"""


def page(record: Sequence[Row]) -> str:
    """Return the page."""
    return _HEAD + _summary(record) + "\n" + _rooms(record)


def _summary(record: Sequence[Row]) -> str:
    lines = ["| | Way | Drives | With contact | Way driven, m | Least clearance, m | Longest turn, s | Backed |"]
    lines.append("|---|---|--:|--:|--:|--:|--:|--:|")
    for way, name in NAMES.items():
        rows = [row for row in record if row["way"] == way]
        if rows:
            touched = sum(1 for row in rows if row["contacts"] or row["end"])
            driven = f"{_least(rows, 'way_m'):.1f} to {-_least(rows, 'way_m', -1):.1f}"
            clearance, turn = _least(rows, "least_clearance_m"), -_least(rows, "longest_turn_s", -1)
            backs = sum(round(_number(row, "backs")) for row in rows)
            figures = f"{driven} | {clearance:.2f} | {turn:.1f} | {backs}"
            lines.append(f"| {way} | {name} | {len(rows)} | {touched} | {figures} |")
    return "\n".join(lines) + "\n"


def _least(rows: Iterable[Row], name: str, sign: int = 1) -> float:
    return min(sign * _number(row, name) for row in rows)


def _number(row: Row, name: str) -> float:
    value = row[name]
    assert isinstance(value, int | float)
    return float(value)


def _rooms(record: Sequence[Row]) -> str:
    found = {(row["seed"], row["way"]): row for row in record}
    lines = ["For each seed and way: metres driven, contacts, changes of state, least clearance in metres.", ""]
    lines.append("| Seed |" + "".join(f" {way}: m | contacts | changes | clearance |" for way in NAMES))
    lines.append("|--:|" + "--:|" * 4 * len(NAMES))
    for seed in sorted({int(_number(row, "seed")) for row in record}):
        cells = [_cells(found.get((seed, way))) for way in NAMES]
        lines.append(f"| {seed} | " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def _cells(row: Row | None) -> str:
    if row is None:
        return "- | - | - | -"
    clearance = _number(row, "least_clearance_m")
    return f"{_number(row, 'way_m'):.1f} | {row['contacts']} | {row['changes']} | {clearance:.2f}"
