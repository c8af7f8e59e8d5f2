"""Asks a person at the terminal of the command, whatever its streams lead to."""

from __future__ import annotations

import contextlib
import os
import termios

from hilbench.bench import Bench
from hilbench.bench.operator import CANNOT, DONE, Asked, NobodyThereError
from hilbench.errors import UsageError

__all__ = ["LIMIT_S", "PersonAtTerminal"]

LIMIT_S = 120.0
"""How long a person is waited for, in seconds: enough to walk to a robot and back (choice)."""

_TERMINAL = "/dev/tty"
_CLEAR_LINE = "\r\x1b[K"
"""A line of progress may stand there."""


class PersonAtTerminal:
    """See the module.

    Raises:
        UsageError: there is no terminal.
    """

    def __init__(self) -> None:
        try:
            self._fd = os.open(_TERMINAL, os.O_RDWR | os.O_NOCTTY | os.O_CLOEXEC)
        except OSError as error:
            hint = "run it at one, or name a command: --operator-hook CMD"
            raise UsageError("there is no terminal to ask at", where="--operator", hint=hint) from error

    def answer(self, bench: Bench, asked: Asked) -> str:
        """See `Somebody`: a line is waited for that begins an answer; an empty one says that something is done."""
        clauses = f"{', '.join(asked.clause_ids)}: " if asked.clause_ids else ""
        wanted = ", then Enter" if asked.to_do else f" {', '.join(asked.answers)}"
        self._prompt(f"{_CLEAR_LINE}{clauses}{asked.text}{wanted} (or {CANNOT}; within {LIMIT_S:g} s): ")
        end_s = bench.now_s + LIMIT_S
        while True:
            line = self._line(bench, max(0.0, end_s - bench.now_s))
            found = DONE if asked.to_do and not line else _begun_with(line, asked)
            if found:
                return found
            self._prompt(f"'{line}' is none of {', '.join((*asked.answers, CANNOT))}: ")

    def last(self, asked: Asked) -> None:
        """See `Somebody`."""
        self._say(f"{_CLEAR_LINE}the check is over: {asked.text}\n")

    def close(self) -> None:
        """See `Somebody`."""
        os.close(self._fd)

    def _line(self, bench: Bench, within_s: float) -> str:
        """Wait for a line."""
        typed = _Typed(self._fd)
        try:
            bench.scheduler.add_source(typed)
            bench.run_until(lambda: typed.ended, within_s)
        finally:
            bench.scheduler.remove_source(typed)
        if not typed.ended:
            self._say("\n")
            raise NobodyThereError(f"the operator did not answer within {LIMIT_S:g} s")
        if not typed.data.endswith(b"\n"):
            raise NobodyThereError("the operator has left the terminal")
        return typed.data.decode(errors="replace").strip().lower()

    def _prompt(self, text: str) -> None:
        """Ask; what was typed before is no answer."""
        with contextlib.suppress(termios.error):
            termios.tcflush(self._fd, termios.TCIFLUSH)
        self._say(text)

    def _say(self, text: str) -> None:
        with contextlib.suppress(OSError):
            os.write(self._fd, text.encode())


class _Typed:
    """A line that is being typed: an input of a locked scheduler."""

    def __init__(self, fd: int) -> None:
        self._fd = fd
        self.data = b""
        self.ended = False

    def fileno(self) -> int:
        """See `InputSource`."""
        return self._fd

    def on_readable(self, at_ns: int) -> None:
        """See `InputSource`; a terminal gives whole lines, and nothing more when it is gone."""
        del at_ns
        try:
            data = os.read(self._fd, 4096)
        except OSError:
            data = b""
        self.data += data
        self.ended = not data or self.data.endswith(b"\n")


def _begun_with(line: str, asked: Asked) -> str:
    """Return the one answer that begins with what was typed; empty for none or several."""
    found = [answer for answer in (*asked.answers, CANNOT) if line and answer.startswith(line)]
    return found[0] if len(found) == 1 else ""
