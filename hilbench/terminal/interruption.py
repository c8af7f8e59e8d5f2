"""What Ctrl-C does, and SIGTERM (a CI system cancels a job), and SIGHUP (a terminal is closed), which do the same.

As long as nothing is held that must be given back, the process ends on the spot: an exception would come out of
whatever is just being imported, or be swallowed by it, or crash what cannot stand one (msgspec 0.22, which calls back
into Python while it looks at types). Before a command opens anything it has the exception raised instead, and what was
recorded is completed.
"""

from __future__ import annotations

import contextlib
import os
import signal
from types import FrameType
from typing import NoReturn

__all__ = ["ENDINGS", "end_at_once", "ignore", "raise_once"]

ENDINGS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)

_INTERRUPTED = 130  # hilbench.exit_codes.ExitCode.INTERRUPTED, which is not imported yet


def end_at_once() -> None:
    """End the process with one line when a signal comes."""
    _handle(_end)


def raise_once() -> None:
    """Raise `KeyboardInterrupt` when a signal comes.

    Only the first of them interrupts: what comes after it must not tear the report apart that it asked for.
    """
    _handle(_interrupt)


def ignore() -> None:
    """Let nothing interrupt any more."""
    _handle(signal.SIG_IGN)


def _handle(handler: signal._HANDLER) -> None:
    with contextlib.suppress(ValueError):  # not in the main thread: an embedding program's business
        for number in ENDINGS:
            signal.signal(number, handler)


def _end(_number: int, _frame: FrameType | None) -> NoReturn:
    with contextlib.suppress(OSError):
        os.write(2, b"hilbench: interrupted\n")
    os._exit(_INTERRUPTED)


def _interrupt(_number: int, _frame: FrameType | None) -> NoReturn:
    ignore()
    raise KeyboardInterrupt
