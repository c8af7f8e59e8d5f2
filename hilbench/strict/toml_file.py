"""A TOML file that somebody wrote, read so that every mistake in it can be named with its line."""

from __future__ import annotations

import io
import re
import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from hilbench.errors import UsageError
from hilbench.strict.changes import Change, apply, stands
from hilbench.strict.toml_lines import find_line
from targets.boards import board_names

_LINE = re.compile(r" \(at line (\d+), column \d+\)$")

_LONGEST_BYTES = 1 << 20
"""Nobody writes so much by hand (choice); a device never ends."""

_ELF = b"\x7fELF"
_RUN_IT = "`hilbench run {board}:{path}` runs it; `hilbench check` takes a bench file that names it"


class TomlFile:
    """One file.

    Args:
        path: where it is.
        kind: what it is to be, for the message if there is none: ``bench file``.
        hint: what to do if there is none.
        changes: what is to be otherwise than it stands there.

    Raises:
        UsageError: it cannot be read, or is not TOML; the line is named. A change leads nowhere.

    Attributes:
        text: what stands in it.
        data: what that means, with the changes.
    """

    def __init__(self, path: Path, kind: str, hint: str | None = None, changes: Sequence[Change] = ()) -> None:
        self.path = path
        self._changes = tuple(changes)
        self.text = _text(path, kind, hint)
        try:
            self.data: dict[str, Any] = tomllib.loads(self.text)
        except tomllib.TOMLDecodeError as error:
            raise _syntax_error(path, str(error)) from None
        except RecursionError:
            raise UsageError("has too many nested brackets", where=str(path)) from None
        apply(self.data, self._changes)

    def place(self, path: tuple[str | int, ...]) -> str:
        """Return the file and line of a key, or of the table it would be in; of one that was changed, the change."""
        for change in reversed(self._changes):
            if _made_by(change, tuple(map(str, path)), self.text):
                return change.where
        line = find_line(self.text, path)
        return f"{self.path}:{line}" if line is not None else str(self.path)


def _made_by(change: Change, path: tuple[str, ...], text: str) -> bool:
    """Say whether what stands at a path came by a change: it is in what that put there, or a table made for it."""
    if path[: len(change.path)] == change.path:
        return True
    return path == change.path[: len(path)] and not stands(tomllib.loads(text), path)


def _syntax_error(path: Path, message: str) -> UsageError:
    place = _LINE.search(message)
    if place is None:
        return UsageError(f"is not TOML: {message}", where=str(path))
    return UsageError(f"is not TOML: {message[: place.start()]}", where=f"{path}:{place[1]}")


def _text(path: Path, kind: str, hint: str | None) -> str:
    try:
        with path.open("rb") as file:
            data = file.read(_LONGEST_BYTES + 1)
        if len(data) > _LONGEST_BYTES:
            raise UsageError(f"too large for a {kind}: more than {_LONGEST_BYTES} bytes", where=str(path))
        if data.startswith(_ELF):
            raise UsageError(
                f"is firmware, and no {kind}", where=str(path), hint=_RUN_IT.format(board=board_names()[0], path=path)
            )
        return io.TextIOWrapper(io.BytesIO(data), encoding="utf-8").read()
    except UnicodeDecodeError as error:
        raise UsageError(f"is not UTF-8 text: {error.reason} at byte {error.start}", where=str(path)) from None
    except FileNotFoundError:
        raise UsageError(f"no such {kind}", where=str(path), hint=hint) from None
    except OSError as error:
        raise UsageError(f"cannot be read: {error.strerror}", where=str(path)) from None
