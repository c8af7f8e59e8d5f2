"""Results of long measurements, a line of JSON each: what is there is not measured again."""

from __future__ import annotations

import contextlib
import json
from pathlib import Path
from typing import TypeVar

__all__ = ["read"]

ResultT = TypeVar("ResultT")


def read(file: Path, kind: type[ResultT]) -> list[ResultT]:
    """Return the results that were appended so far; a last line that was cut is left out, and no file is none."""
    found = []
    for line in file.read_text(encoding="utf-8").splitlines() if file.is_file() else []:
        with contextlib.suppress(json.JSONDecodeError, TypeError):
            found.append(kind(**json.loads(line)))
    return found
