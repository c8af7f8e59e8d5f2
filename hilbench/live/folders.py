"""Where live benches are found: one private folder each, with the journal, the socket, and what the bench had to say.

Who uses a folder, the bench and each dashboard of it, has it locked as long as his process lives (flock(2), shared).
One that nobody has locked was left behind, by a dashboard that was killed for example, and is cleared away by the next
start: at once where the bench ended in good order, after a day where it did not, for its journal says what happened
(choice).

Nothing here is heavy: ``hilbench attach`` looks here before it loads anything.
"""

from __future__ import annotations

import contextlib
import fcntl
import json
import os
import shutil
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from hilbench.driving.local_socket import connect_to
from hilbench.errors import UnavailableError
from hilbench.files.runtime_folder import made_private, runtime_folder

__all__ = ["Session", "new_session", "sessions"]

_PREFIX = "bench-"
_MADE_WITHIN_S = 60
"""So long a folder may be there that is not locked yet (choice)."""
_KEPT_S = 24 * 3600
_END_MARK, _END_BYTES = b'"kind":"host-end"', 200
"""How a journal ends that was closed in good order."""


@dataclass(frozen=True, slots=True)
class Session:
    """A live bench, or what is left of one.

    Attributes:
        folder: only its owner may look into it.
    """

    folder: Path

    @property
    def name(self) -> str:
        """What it is called on the command line."""
        return self.folder.name.removeprefix(_PREFIX)

    @property
    def journal(self) -> Path:
        """What happens there."""
        return self.folder / "journal.jsonl"

    @property
    def socket(self) -> Path:
        """Where it takes commands."""
        return self.folder / "control"

    @property
    def talk(self) -> Path:
        """What the process says that is no event: its last words."""
        return self.folder / "talk.txt"

    @property
    def about(self) -> Path:
        """What it is: the bench, the process."""
        return self.folder / "about.json"

    def describe(self) -> dict[str, object]:
        """Return what is known of it; nothing if it has not begun."""
        try:
            about = json.loads(self.about.read_text())
        except (OSError, ValueError):
            return {}
        return about if isinstance(about, dict) else {}

    def alive(self) -> bool:
        """Say whether anybody answers there."""
        try:
            connect_to(self.socket).close()
        except OSError:
            return False
        return True

    def hold(self) -> Hold:
        """Have it kept as long as this process lives, or until it lets go."""
        return Hold(self.folder)

    def ended_well(self, journal: Path | None = None) -> bool:
        """Say whether a journal of it, its own if none is named, was closed in good order, or never begun."""
        try:
            with (journal or self.journal).open("rb") as data:
                data.seek(max(0, data.seek(0, os.SEEK_END) - _END_BYTES))
                return _END_MARK in data.read()
        except OSError:
            return True

    def remove(self) -> None:
        """Forget it, its journal too."""
        shutil.rmtree(self.folder, ignore_errors=True)


class Hold:
    """A folder that somebody uses.

    Args:
        folder: which; where it cannot be locked it is used all the same.
    """

    def __init__(self, folder: Path) -> None:
        self._descriptor: int | None = None
        with contextlib.suppress(OSError):
            self._descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
            fcntl.flock(self._descriptor, fcntl.LOCK_SH | fcntl.LOCK_NB)

    def release(self) -> None:
        """Let go; a second call does nothing."""
        if self._descriptor is not None:
            os.close(self._descriptor)
        self._descriptor = None


def new_session(name: str) -> Session:
    """Make the folder of a bench, and clear away those that were left behind.

    Raises:
        UnavailableError: there is no place for it.
    """
    home = runtime_folder()
    try:
        made_private(home)
        word = "".join(letter if letter.isalnum() else "-" for letter in name)[:24]
        folder = Path(tempfile.mkdtemp(prefix=f"{_PREFIX}{word}-", dir=home))
        _clear_left_behind(home, folder.stat().st_mtime)
    except OSError as error:
        raise UnavailableError(
            f"no folder for a live bench can be made: {error.strerror or error}", where=str(home)
        ) from error
    return Session(folder)


def sessions() -> Iterator[Session]:
    """Return the benches that answer, the latest first."""
    found = []
    for folder in runtime_folder().glob(f"{_PREFIX}*"):
        with contextlib.suppress(OSError):  # one that ends takes its folder along
            found.append((folder.stat().st_mtime, folder))
    yield from (session for _, folder in sorted(found, reverse=True) if (session := Session(folder)).alive())


def _clear_left_behind(home: Path, now_s: float) -> None:
    """Remove what nobody has any more.

    Args:
        home: where the folders are.
        now_s: the time of the file system, in seconds; the host's monotonic time is not that of files.
    """
    for folder in home.glob(f"{_PREFIX}*"):
        with contextlib.suppress(OSError):
            session = Session(folder)
            age_s = now_s - max(path.stat().st_mtime for path in (folder, *folder.iterdir()))
            if age_s >= (_MADE_WITHIN_S if session.ended_well() else _KEPT_S):
                _clear(session)


def _clear(session: Session) -> None:
    """Remove a folder, unless somebody has it, or a bench answers there all the same.

    Raises:
        OSError: somebody has it, or it is gone.
    """
    descriptor = os.open(session.folder, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW | os.O_CLOEXEC)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        if not session.alive():
            session.remove()
    finally:
        os.close(descriptor)
