"""Errors meant for people: one line that says what is wrong, where, and what to do next.

HilbenchError
├── UsageError            exit 2   a bench file with an unknown key; a pty path that is somebody's file
├── UnavailableError      exit 3   no such port, port busy, no physics, a shadowed package
│   └── AwayError                  a board was unplugged while it was tested, and may be plugged in again
└── InternalError         exit 5   a rule of our own code was broken
    └── PortClosedError            a port was written to after it was closed
"""

from __future__ import annotations

from typing import ClassVar

from hilbench.exit_codes import ExitCode


class HilbenchError(Exception):
    """Something a person must know about, in one line.

    Args:
        message: What is wrong, without a full stop.
        where: The file and line, port, link or option it is about.
        hint: What to do next.
    """

    exit_code: ClassVar[ExitCode] = ExitCode.DEFECT

    def __init__(self, message: str, *, where: str | None = None, hint: str | None = None) -> None:
        super().__init__(message)
        self.message = message
        self.where = where
        self.hint = hint

    def __str__(self) -> str:
        text = f"{self.where}: {self.message}" if self.where else self.message
        if self.hint:
            text = f"{text}; {self.hint}"
        return " ".join(text.split())


class UsageError(HilbenchError):
    """The command line, the bench file or an argument is wrong.

    Example scenarios: an unknown key in a bench file; a suite expression that selects nothing; `--pty` on a path that
    holds a regular file.
    """

    exit_code = ExitCode.USAGE


class PluginError(UsageError):
    """Code that a plug-in brings did what it must not."""


class UnavailableError(HilbenchError):
    """Something the run needs is not there.

    Example scenarios: the serial port does not exist or belongs to another program; the TCP port is taken; PyBullet is
    not installed; another distribution shadows the package `protocols`.
    """

    exit_code = ExitCode.UNAVAILABLE


class AwayError(UnavailableError):
    """Something the run needs has gone for now, and is looked for: this case says nothing, the next one may.

    Example scenario: a board's plug is pulled while a case runs.
    """


class InternalError(HilbenchError):
    """A defect in hilbench: a rule that its own code must keep was broken."""

    exit_code = ExitCode.DEFECT


class PortClosedError(InternalError):
    """A port was written to after it had been closed."""
