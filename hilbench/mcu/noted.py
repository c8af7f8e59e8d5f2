"""What the emulated boards of a run have to say beside the verdicts: on what they wait, and what there is to note."""

from __future__ import annotations

from collections.abc import Iterable

from hilbench.judging.observations import EmulationNote
from hilbench.judging.outcome import printable
from hilbench.mcu.emulated import EmulatedBench

__all__ = ["Noted", "lacking"]


def lacking(benches: Iterable[EmulatedBench]) -> str:
    """Return on what that is not modelled boards wait, for people; empty if none waits on anything of the kind."""
    found = (emulated.lacking(name) for emulated in benches for name in emulated.machines)
    return " and ".join(dict.fromkeys(text for text in found if text))


_WORDS = ("board", "kind", "where", "text", "at")


class Noted:
    """Notes over all cases of a run: what the firmware does in each of them is said once."""

    def __init__(self) -> None:
        self._cases: dict[tuple[str, str, str, str], list[str]] = {}
        self._at: dict[tuple[str, str, str, str], str] = {}

    def take(self, case_id: str, emulated: EmulatedBench) -> None:
        """Take what there is to note at the end of a case."""
        for note in emulated.noted():
            board, kind, where, text, at = (printable(str(note[word])) for word in _WORDS)
            key = (board, kind, where, text)
            self._at.setdefault(key, at)
            cases = self._cases.setdefault(key, [])
            if case_id not in cases:
                cases.append(case_id)

    def notes(self) -> tuple[EmulationNote, ...]:
        """Return what was taken so far, in the order in which it was first seen."""
        return tuple(
            EmulationNote(board=board, kind=kind, where=where, text=text, at=self._at[key], case_ids=tuple(cases))
            for key, cases in self._cases.items()
            for board, kind, where, text in [key]
        )
