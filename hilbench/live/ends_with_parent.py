"""``python -P -m hilbench.live.ends_with_parent FOLDER COMMAND ...``: it ends with whoever started it.

Its standard input is a pipe into which nobody writes, so it ends when the other process does, however that ends. Then
the folder, which was the other's to remove, is removed, and the command is interrupted.
"""

from __future__ import annotations

import os
import shutil
import signal
import sys
import threading

from hilbench import __main__ as command

__all__ = ["words_of"]


def words_of(folder: str) -> list[str]:
    """Return how a command is started whose folder this is; its own words follow, its standard input is a pipe."""
    return [sys.executable, "-P", "-m", __name__, folder]


def _end_with_stdin(folder: str) -> None:
    while os.read(0, 1):
        pass
    shutil.rmtree(folder, ignore_errors=True)
    os.kill(os.getpid(), signal.SIGINT)


def main() -> int:
    """Run the command."""
    folder = sys.argv.pop(1)
    threading.Thread(target=_end_with_stdin, args=(folder,), daemon=True).start()
    return command.main()


if __name__ == "__main__":
    sys.exit(main())
