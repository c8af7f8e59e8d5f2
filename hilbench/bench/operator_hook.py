"""Asks a command, which switches a relay or looks by a camera, as a person would with his hands and eyes.

It is run once for each request, with the request's name and words behind its own, and JSON on its standard input. Exit
status 0 says that it is done, and the first line of its output is the answer where one is wanted; `CANNOT_STATUS` says
that it cannot. With any other status it is broken, and the run ends.
"""

from __future__ import annotations

import contextlib
import json
import shutil
import subprocess
import tempfile
from collections.abc import Iterator, Sequence
from typing import IO

from hilbench.bench import Bench
from hilbench.bench.operator import CANNOT, DONE, Asked
from hilbench.benchfile.line_hooks import COMMAND_LIMIT_S
from hilbench.errors import UnavailableError, UsageError

__all__ = ["CANNOT_STATUS", "CommandAsOperator"]

CANNOT_STATUS = 3
"""As our own exit code for what is not available."""

_WHERE = "--operator-hook"


class CommandAsOperator:
    """See the module.

    Args:
        command: its words.

    Raises:
        UsageError: there is no such command.
    """

    def __init__(self, command: Sequence[str]) -> None:
        if not command or shutil.which(command[0]) is None:
            name = command[0] if command else ""
            raise UsageError(f"'{name}' is no command that can be run", where=_WHERE, hint="name one with its path")
        self._command = command

    def answer(self, bench: Bench, asked: Asked) -> str:
        """See `Somebody`."""
        with self._running(asked) as (process, output, errors):
            if not bench.run_until(lambda: process.poll() is not None, COMMAND_LIMIT_S):
                raise UnavailableError(f"{self._command[0]} did not end within {COMMAND_LIMIT_S:g} s", where=_WHERE)
            return self._said(asked, process.returncode, _lines(output), _lines(errors))

    def last(self, asked: Asked) -> None:
        """See `Somebody`; what comes of it changes nothing any more."""
        with contextlib.suppress(UnavailableError, subprocess.TimeoutExpired), self._running(asked) as (process, *_):
            process.wait(COMMAND_LIMIT_S)

    def close(self) -> None:
        """See `Somebody`."""

    @contextlib.contextmanager
    def _running(self, asked: Asked) -> Iterator[tuple[subprocess.Popen[bytes], IO[bytes], IO[bytes]]]:
        words = [*self._command, asked.name, *asked.words]
        with tempfile.TemporaryFile() as output, tempfile.TemporaryFile() as errors:
            try:
                process = subprocess.Popen(words, stdin=subprocess.PIPE, stdout=output, stderr=errors)
            except OSError as error:
                raise UnavailableError(f"{words[0]} cannot be run: {error.strerror}", where=_WHERE) from error
            try:
                _tell(process, asked)
                yield process, output, errors
            finally:
                process.kill()  # nothing, where it has ended
                process.wait()

    def _said(self, asked: Asked, status: int, output: Sequence[str], errors: Sequence[str]) -> str:
        """Return what the command has answered, by its exit status and its output."""
        if status == CANNOT_STATUS:
            return CANNOT
        if status:
            words = "".join(f": {line}" for line in (*output, *errors)[-1:])
            raise UnavailableError(f"{self._command[0]} {asked.name} ended with status {status}{words}", where=_WHERE)
        answer = DONE if asked.to_do else "".join(output[:1]).strip().lower()
        if answer not in asked.answers:
            message = f"{self._command[0]} {asked.name} answered '{answer}', and not {' or '.join(asked.answers)}"
            raise UnavailableError(message, where=_WHERE)
        return answer


def _lines(stream: IO[bytes]) -> Sequence[str]:
    stream.seek(0)
    return stream.read().decode(errors="replace").strip().splitlines()


def _tell(process: subprocess.Popen[bytes], asked: Asked) -> None:
    """Give a command its request as JSON; it need not read it."""
    assert process.stdin is not None
    answers = [] if asked.to_do else [*asked.answers]
    request = {"request": asked.name, "words": [*asked.words], "text": asked.text, "answers": answers}
    with contextlib.suppress(BrokenPipeError):
        process.stdin.write(json.dumps({**request, "clauses": [*asked.clause_ids]}).encode() + b"\n")
        process.stdin.flush()
    with contextlib.suppress(BrokenPipeError):
        process.stdin.close()
