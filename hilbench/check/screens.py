"""Pictures of the screen of the dashboard at the moment a case fails, in a folder, named after the cases.

Who draws them is handed in: nothing here knows the dashboard, and nothing of it is loaded before a case has failed.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from hilbench.errors import UnavailableError, UsageError
from hilbench.files import write_atomically
from hilbench.judging.provider import CaseView
from hilbench.judging.verdicts import Verdict

__all__ = ["Draw", "Screens", "make_folder"]

Draw = Callable[[Mapping[str, Any], Sequence[Mapping[str, Any]], str], str]
"""Makes an SVG of the header of a journal, its events, and one line that says what has happened."""

SHOWN_VERDICTS = frozenset({Verdict.FAIL, Verdict.ERROR, Verdict.INCONCLUSIVE})
_UNSAFE = re.compile(r"[^A-Za-z0-9._=-]+")
_LONGEST_NAME = 120


def make_folder(folder: Path) -> None:
    """Make the folder of the pictures, before anything runs.

    Raises:
        UsageError: there is something else, or it cannot be made.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        reason = "is no folder" if folder.exists() else f"cannot be made: {error.strerror}"
        raise UsageError(reason, where=f"--screens {folder}") from error


class Screens:
    """See the module.

    Args:
        folder: where they are written; it is there.
        draw: makes them.
        bench: the name of the bench.

    Attributes:
        problem: why one could not be drawn or written, the first time; None if all could. No verdict changes for it.
    """

    def __init__(self, folder: Path, draw: Draw, bench: str) -> None:
        self.problem: UnavailableError | None = None
        self._folder = folder
        self._draw = draw
        self._bench = bench
        self._taken: set[str] = set()
        self._names: dict[str, str] = {}

    def plan(self, case_ids: Iterable[str]) -> None:
        """Give the picture of each of these cases its name, in their order."""
        self._names = {case_id: self._name(case_id) for case_id in case_ids}

    def save(self, case_id: str, view: CaseView, verdict: Verdict, cause: str) -> str:
        """Draw what was to be seen of a case; return the name of the file, empty if there is none."""
        path = self._folder / (self._names.get(case_id) or self._name(case_id))
        header = {"kind": "journal", "bench": self._bench, "live": view.about}
        try:
            drawn = self._draw(header, view.events, f"{verdict.value.upper()} {case_id}: {cause}")
            write_atomically(path, drawn)
        except UnavailableError as error:
            self.problem = self.problem or error
            return ""
        except Exception as error:  # noqa: BLE001 - a picture that cannot be drawn must not cost the run
            said = f"the screen could not be drawn: {type(error).__name__}: {error}"
            self.problem = self.problem or UnavailableError(said, where=str(path))
            return ""
        return str(path)

    def _name(self, case_id: str) -> str:
        stem = _UNSAFE.sub("_", case_id).strip("_")[:_LONGEST_NAME]
        name, number = stem, 1
        while name in self._taken:
            number += 1
            name = f"{stem}-{number}"
        self._taken.add(name)
        return f"{name}.svg"
