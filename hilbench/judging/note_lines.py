"""What the firmware did that a user should know of, for the screen: what has one cause is said once."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

__all__ = ["note_lines", "notes_counted"]

_MOST_LINES = 2  # that say the same


def note_lines(notes: Iterable[Mapping[str, object]], *, each: bool = False) -> list[str]:
    """Return lines for notes; where many places share one, with the place of the first.

    Args:
        notes: in order, with `board`, `kind`, `where` (``CAN_MCR``, ``PE3``), `text` and `at`, the place in the program
            or "".
        each: a line for each of them.
    """
    groups: dict[tuple[object, ...], list[Mapping[str, object]]] = {}
    for note in notes:
        groups.setdefault((note["board"], note["kind"], note["text"]), []).append(note)
    return [line for group in groups.values() for line in _lines(group, each=each)]


def notes_counted(count: int, lines: int = 0, hint: str = "") -> str:
    """Say how many notes there are, and in how many lines they are shown if in fewer; `hint` how to get each."""
    fewer = f", in {lines} line{'s' if lines > 1 else ''}{hint}" if 0 < lines < count else ""
    return f"{count} note{'s' if count > 1 else ''} on what the firmware did{fewer}"


def _lines(notes: list[Mapping[str, object]], *, each: bool) -> list[str]:
    if each or len(notes) <= _MOST_LINES:
        return [_line(note) for note in notes]
    return [_line(notes[0], f" and {len(notes) - 1} more")]


def _line(note: Mapping[str, object], more: str = "") -> str:
    at = f" ({note['at']})" if note["at"] else ""
    return f"{note['board']}: {note['where']}{more}: {note['text']}{at}"
