"""The folder of what runs: files that are of no use once their process has ended, and nobody else's business.

``$XDG_RUNTIME_DIR/hilbench`` where there is such a folder (XDG Base Directory Specification), else a folder of the
user's among the temporary ones.
"""

from __future__ import annotations

import os
import stat
import tempfile
from pathlib import Path

from hilbench.errors import UnavailableError

__all__ = ["check_private", "made_private", "runtime_folder"]


def runtime_folder() -> Path:
    """Return where it is, whether it exists or not."""
    runtime = os.environ.get("XDG_RUNTIME_DIR")
    if runtime and Path(runtime).is_dir():
        return Path(runtime) / "hilbench"
    return Path(tempfile.gettempdir()) / f"hilbench-{os.getuid()}"


def made_private(folder: Path) -> Path:
    """Make a folder that only its owner can look into, if it is not there; return it.

    Raises:
        OSError: it cannot be made.
        UnavailableError: somebody else has put it there, or can look into it.
    """
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    check_private(folder)
    return folder


def check_private(folder: Path) -> None:
    """Make sure that nobody else put the folder there, or can look into it.

    Raises:
        OSError: it is not there.
        UnavailableError: somebody did, or can.
    """
    status = folder.lstat()
    if not stat.S_ISDIR(status.st_mode) or status.st_uid != os.getuid() or status.st_mode & 0o077:
        raise UnavailableError("is not a private folder of yours", where=str(folder), hint="remove it")
