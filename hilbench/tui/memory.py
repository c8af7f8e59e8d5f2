"""What a dashboard remembers between two times: theme, arrangements and plots, in a file of one's own.

A file that is damaged, or that cannot be written, costs what it would have held and a line in the log, nothing else.
"""

from __future__ import annotations

import os
from dataclasses import asdict
from pathlib import Path

import msgspec

from hilbench.plugins.dashboard import Dashboard
from hilbench.tui.model.arrangement import Arrangement, Column, arrangement_of

__all__ = ["Memory", "Remembered", "state_file"]


class _Kind(msgspec.Struct, forbid_unknown_fields=True):
    """What is remembered of a kind of bench: its arrangements, and the signals that are plotted over how long."""

    wide: Arrangement | None = None
    narrow: Arrangement | None = None
    signals: list[str] | None = None
    span_s: int = 20


class Remembered(msgspec.Struct, forbid_unknown_fields=True):
    """The file."""

    theme: str = ""
    kinds: dict[str, _Kind] = msgspec.field(default_factory=dict)


class Memory:
    """What is remembered.

    Args:
        path: the file; None to remember nothing beyond this time.

    Attributes:
        problems: what went wrong with the file, in a line each; whoever tells of it takes it out.
    """

    def __init__(self, path: Path | None = None) -> None:
        self.problems: list[str] = []
        self._path = path
        self._failed = False
        self._remembered = self._read()

    @property
    def theme(self) -> str:
        """The theme; empty if none was chosen."""
        return self._remembered.theme

    @theme.setter
    def theme(self, name: str) -> None:
        if name != self._remembered.theme:
            self._remembered.theme = name
            self._write()

    def arrangement(self, dashboard: Dashboard, *, wide: bool) -> Arrangement:
        """Return how a kind of bench is arranged: as somebody has, else as it says."""
        usual = arrangement_of(dashboard, wide=wide)
        known = self._kind(dashboard.kind)
        kept = known.wide if wide else known.narrow
        return usual if kept is None or sorted(kept.names) != sorted(usual.names) else kept

    def arrange(self, kind: str, arrangement: Arrangement | None, *, wide: bool) -> None:
        """Remember how a kind of bench is arranged; None: as it is without anybody's doing."""
        if wide:
            self._kind(kind).wide = arrangement
        else:
            self._kind(kind).narrow = arrangement
        self._write()

    def signals(self, kind: str) -> tuple[list[str] | None, int]:
        """Return which signals are plotted, None if nobody chose them, and over how many seconds."""
        known = self._kind(kind)
        return known.signals, max(1, known.span_s)

    def plot(self, kind: str, signals: list[str] | None, span_s: int) -> None:
        """Remember which signals are plotted, and over how many seconds."""
        known = self._kind(kind)
        known.signals, known.span_s = signals, span_s
        self._write()

    def _kind(self, kind: str) -> _Kind:
        return self._remembered.kinds.setdefault(kind, _Kind())

    def _read(self) -> Remembered:
        if self._path is None:
            return Remembered()
        try:
            found = msgspec.json.decode(self._path.read_bytes(), type=Remembered)
            _check(found)
        except FileNotFoundError:
            return Remembered()
        except (OSError, ValueError) as error:
            why = error.strerror if isinstance(error, OSError) else "is damaged"
            self.problems.append(f"{self._path}: {why}; the panes are as they are at first")
            return Remembered()
        return found

    def _write(self) -> None:
        if self._path is None or self._failed:
            return
        beside = self._path.with_name(f"{self._path.name}.{os.getpid()}")
        try:
            self._path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
            beside.write_bytes(msgspec.json.format(msgspec.json.encode(self._remembered)))
            beside.replace(self._path)
        except OSError as error:
            self._failed = True
            self.problems.append(f"{self._path}: {error.strerror}; what you arrange is forgotten when you leave")


def _check(found: Remembered) -> None:
    """Look whether the shares of all arrangements mean anything.

    Raises:
        ValueError: they do not.
    """
    for kind in found.kinds.values():
        for one in (kind.wide, kind.narrow):
            shares = [] if one is None else [column.share for column in one.columns] + _heights(one.columns)
            if not all(0 < share < 1e6 for share in shares) or (one is not None and not one.columns):
                raise ValueError("shares are above 0")


def _heights(columns: tuple[Column, ...]) -> list[float]:
    return [share for column in columns for share in dict(asdict(column)["panes"]).values()]


def state_file() -> Path:
    """Return the file: ``$XDG_STATE_HOME/hilbench/dashboard.json``, else below ``~/.local/state``.

    As of the XDG Base Directory Specification 0.8.
    """
    home = os.environ.get("XDG_STATE_HOME", "")
    folder = Path(home) if Path(home).is_absolute() else Path(os.environ.get("HOME", "/")) / ".local" / "state"
    return folder / "hilbench" / "dashboard.json"
