"""Where live benches are found: one private folder each, with the journal, the socket, and what the bench had to say.

Nothing here is heavy: ``hilbench attach`` looks here before it loads anything.
"""

from __future__ import annotations

import contextlib
import json
import shutil
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from hilbench.errors import UnavailableError
from hilbench.live.local_socket import connect_to
from hilbench.runtime_folder import made_private, runtime_folder

__all__ = ["Session", "new_session", "sessions"]

_PREFIX = "bench-"


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

    def remove(self) -> None:
        """Forget it, its journal too."""
        shutil.rmtree(self.folder, ignore_errors=True)


def new_session(name: str) -> Session:
    """Make the folder of a bench.

    Raises:
        UnavailableError: there is no place for it.
    """
    home = runtime_folder()
    try:
        made_private(home)
        word = "".join(letter if letter.isalnum() else "-" for letter in name)[:24]
        return Session(Path(tempfile.mkdtemp(prefix=f"{_PREFIX}{word}-", dir=home)))
    except OSError as error:
        raise UnavailableError(f"no place for a live bench: {error.strerror or error}", where=str(home)) from error


def sessions() -> Iterator[Session]:
    """Return the benches that answer, the latest first."""
    found = []
    for folder in runtime_folder().glob(f"{_PREFIX}*"):
        with contextlib.suppress(OSError):  # one that ends takes its folder along
            found.append((folder.stat().st_mtime, folder))
    yield from (session for _, folder in sorted(found, reverse=True) if (session := Session(folder)).alive())
