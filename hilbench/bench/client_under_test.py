"""A client that a suite puts to the test: a program we start, or whoever comes; ours stand with their protocols.

What can be asked of a client depends on which it is. Ours tells what it understood and does what it is told; of a
foreign program only its bytes are seen, so cases that need more are not applicable to it.
"""

from __future__ import annotations

import contextlib
import os
import shlex
import signal
import subprocess
import threading
from collections.abc import Iterator
from typing import Any

from hilbench.bench import Bench
from hilbench.bench.under_test import UnderTest
from hilbench.errors import UnavailableError
from hilbench.links import Port

EXEC_CAPABILITIES = frozenset({"client", "client.restart", "client.disconnect"})
LISTEN_CAPABILITIES = frozenset({"client"})

WAIT_FOR_CLIENT_S = 30.0
"""How long a case waits for a foreign client to come, in seconds. A choice: long enough to start one by hand."""

_TERMINATE_WITHIN_S = 3.0
_OUR_SIGNALS = (signal.SIGINT, signal.SIGTERM)


ClientUnderTest = UnderTest[Any]
"""A client that can be made to connect."""


class ExecClient:
    """A program that we start for each case, with the pty or the TCP port it is to connect to.

    Args:
        command: its command line, split as a shell would; ``{pty}`` and ``{port}`` are filled in by ``names``.
        names: what to fill in.
        own: what knows what it tells, if it has a line for that.
    """

    def __init__(self, command: str, names: dict[str, str], own: Any = None) -> None:
        self.own = own
        self._words = [_fill_in(word, names) for word in shlex.split(command)]
        self._process: subprocess.Popen[bytes] | None = None

    def start(self) -> None:
        """Start the program, in a session of its own so that all of it can be ended."""
        try:
            with _signals_heard():
                self._process = subprocess.Popen(
                    self._words, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, start_new_session=True
                )
        except OSError as error:
            raise UnavailableError(
                f"the client cannot be started: {error.strerror}", where=f"exec:{self._words[0]}"
            ) from None

    def ended(self) -> str:
        """Say how the program ended by itself; empty while it runs."""
        status = None if self._process is None else self._process.poll()
        if status is None:
            return ""
        return f"was killed by signal {-status}" if status < 0 else f"exited with status {status}"

    def disconnect(self) -> None:
        """Interrupt the program, as Ctrl-C would."""
        self._signal(signal.SIGINT)

    def close(self) -> None:
        """End the program: politely first."""
        if self._process is None:
            return
        self._signal(signal.SIGTERM)
        try:
            self._process.wait(_TERMINATE_WITHIN_S)
        except subprocess.TimeoutExpired:
            self._signal(signal.SIGKILL)
            self._process.wait()
        self._process = None

    def _signal(self, number: signal.Signals) -> None:
        if self._process is not None and self._process.poll() is None:
            os.killpg(self._process.pid, number)


@contextlib.contextmanager
def _signals_heard() -> Iterator[None]:
    """Have a program that is started meanwhile hear our signals.

    What a script starts with ``&`` ignores SIGINT, and so would the client by inheritance; but what is handled and not
    ignored is back at its default in another program.
    """
    main = threading.current_thread() is threading.main_thread()
    ignored = [number for number in _OUR_SIGNALS if main and signal.getsignal(number) is signal.SIG_IGN]
    for number in ignored:
        signal.signal(number, lambda _number, _frame: None)
    try:
        yield
    finally:
        for number in ignored:
            signal.signal(number, signal.SIG_IGN)


class ListenClient:
    """Whoever connects to our door: a fresh client for each case, as one has that is started again when it ends.

    Args:
        bench: whose time passes while we wait.
        port: the door.
    """

    own = None

    def __init__(self, bench: Bench, port: Port) -> None:
        self._bench = bench
        self._port = port
        self._is_used = port.line_is_up and port.counters.received > 0

    def start(self) -> None:
        """Wait until the client of the case before has gone, and another has come."""
        if self._is_used and not self._bench.run_until(lambda: not self._port.line_is_up, WAIT_FOR_CLIENT_S):
            raise UnavailableError(
                f"the client has not left within {WAIT_FOR_CLIENT_S * self._bench.timeout_scale:g} s",
                where=self._port.name,
                hint="each case needs a fresh client: start it again",
            )
        if not self._bench.run_until(lambda: self._port.line_is_up, WAIT_FOR_CLIENT_S):
            raise UnavailableError(
                f"no client came within {WAIT_FOR_CLIENT_S * self._bench.timeout_scale:g} s",
                where=self._port.name,
                hint="start it, or raise --timeout-scale",
            )

    def ended(self) -> str:
        """Return nothing: of a stranger only the line is seen."""
        return ""

    def disconnect(self) -> None:
        """Nothing can be done to a stranger."""

    def close(self) -> None:
        """Nothing to end."""


def _fill_in(word: str, names: dict[str, str]) -> str:
    for name, value in names.items():
        word = word.replace("{" + name + "}", value)
    return word
