"""What the firmware did that a user should know of, for the screen: what is said of many registers is said once."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

__all__ = ["note_lines"]

_MOST_NAMES = 3


def note_lines(notes: Iterable[Mapping[str, object]]) -> list[str]:
    """Return lines for notes, with the place of the first where several registers of a peripheral share one.

    Args:
        notes: in order, with `board`, `kind`, `where` (``CAN_MCR``), `text` and `at`, the place in the program or "".
    """
    groups: dict[tuple[object, ...], list[Mapping[str, object]]] = {}
    for note in notes:
        peripheral = str(note["where"]).partition("_")[0]
        groups.setdefault((note["board"], note["kind"], peripheral, note["text"]), []).append(note)
    return [_line(group) for group in groups.values()]


def _line(notes: list[Mapping[str, object]]) -> str:
    first = notes[0]
    names = [str(note["where"]) for note in notes]
    where = ", ".join(names) if len(names) <= _MOST_NAMES else f"{names[0]} and {len(names) - 1} more registers"
    at = f" ({first['at']})" if first["at"] else ""
    return f"{first['board']}: {where}: {first['text']}{at}"
