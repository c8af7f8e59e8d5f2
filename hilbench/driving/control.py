"""The socket by which a live bench is commanded: a line of JSON each way, and nobody is ever waited for.

A request is ``{"id": 7, "do": "drive", ...}``, its answer ``{"id": 7, "ok": true}``, or ``"ok": false`` and why as
``error``. The socket is its owner's alone (mode 0600, in a folder of mode 0700). Who does not read answers is cut off.
"""

from __future__ import annotations

import contextlib
import json
import select
import socket
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from hilbench.clock import EventClass, Scheduler
from hilbench.driving.local_socket import listen_at
from hilbench.errors import HilbenchError, UnavailableError

__all__ = ["Control", "Request", "RequestError"]

_LONGEST_LINE = 4096
_READ_BYTES = 4096

Request = Mapping[str, Any]


class RequestError(Exception):
    """A request that cannot be done, and why, for people."""


@dataclass(slots=True, eq=False)
class _Client:
    """A connection.

    Attributes:
        farewell: whether it has said that it leaves; None of one that has said nothing at all.
    """

    control: Control
    socket: socket.socket
    data: bytes = b""
    farewell: bool | None = None

    def fileno(self) -> int:
        return self.socket.fileno()

    def on_readable(self, at_ns: int) -> None:
        self.control.read(self, at_ns)


@dataclass(slots=True, eq=False)
class Control:
    """The socket of a bench.

    Args:
        scheduler: who owns the time at which requests are done.
        path: where the socket is made.
        obey: does what a request says; what it raises as `RequestError` or `HilbenchError` is the answer.

    Attributes:
        farewell: whether the client that left last said so; one that says nothing has died. Who asks for nothing is no
            client.
        left_ns: the bench time at which the last client left, or 0 before the first; None while there is one.
    """

    scheduler: Scheduler
    path: Path
    obey: Callable[[Request], None]
    farewell: bool = False
    left_ns: int | None = 0
    _listener: socket.socket = field(init=False)
    _clients: list[_Client] = field(default_factory=list)

    def __post_init__(self) -> None:
        """Listen.

        Raises:
            UnavailableError: the socket cannot be made.
        """
        try:
            self._listener = listen_at(self.path)
        except OSError as error:
            raise UnavailableError(f"no socket: {error.strerror or error}", where=str(self.path)) from error
        self.scheduler.add_source(self)

    def close(self) -> None:
        """Hang up."""
        for client in list(self._clients):
            self._drop(client)
        self.scheduler.remove_source(self)
        self._listener.close()
        with contextlib.suppress(OSError):
            self.path.unlink()

    def wait(self) -> None:
        """Wait, while bench time stands still, until something comes, and do it."""
        sources: list[Control | _Client] = [self, *self._clients]
        for source in select.select(sources, (), ())[0]:
            source.on_readable(self.scheduler.now_ns)

    # --- a source of the scheduler

    def fileno(self) -> int:
        """Return the descriptor of the listening socket."""
        return self._listener.fileno()

    def on_readable(self, _at_ns: int) -> None:
        """Take a client."""
        with contextlib.suppress(OSError):
            connection, _ = self._listener.accept()
            connection.setblocking(False)
            client = _Client(self, connection)
            self._clients.append(client)
            self.left_ns = None
            self.scheduler.add_source(client)

    def read(self, client: _Client, at_ns: int) -> None:
        """Take what a client says; done at `at_ns`, or at once while nothing runs."""
        try:
            data = client.socket.recv(_READ_BYTES)
        except BlockingIOError:
            return
        except OSError:
            data = b""
        if not data:
            self._drop(client)
            return
        *lines, client.data = (client.data + data).split(b"\n")
        if len(client.data) > _LONGEST_LINE:
            self._drop(client)
        for line in lines:
            self._book(client, line, at_ns)

    def _book(self, client: _Client, line: bytes, at_ns: int) -> None:
        if self.scheduler.locked:
            self.scheduler.at(at_ns, lambda: self._do(client, line), order=EventClass.INPUT, source="~control")
        else:
            self._do(client, line)

    def _do(self, client: _Client, line: bytes) -> None:
        answer: dict[str, Any] = {"id": None, "ok": True}
        try:
            request = _read(line)
            answer["id"] = request.get("id")
            client.farewell = request.get("do") == "farewell"
            if client not in self._clients:  # it was gone before its last words were due
                self.farewell = client.farewell
            if not client.farewell:
                self.obey(request)
        except RecursionError:  # brackets without end
            answer |= {"ok": False, "error": "a request is a plain object"}
        except (RequestError, HilbenchError, ValueError, TypeError, KeyError) as error:
            answer |= {"ok": False, "error": str(error)}
        self._answer(client, answer)

    def _answer(self, client: _Client, answer: Mapping[str, Any]) -> None:
        data = json.dumps(answer).encode() + b"\n"
        try:
            sent = client.socket.send(data)
        except (BrokenPipeError, ConnectionResetError):
            return  # he has left; what he has said before that is still to be read
        except OSError:
            sent = 0
        if sent != len(data):
            self._drop(client)

    def _drop(self, client: _Client) -> None:
        if client in self._clients:
            self._clients.remove(client)
            self.scheduler.remove_source(client)
            client.socket.close()
            if client.farewell is not None:
                self.farewell = client.farewell
            if not self._clients:
                self.left_ns = self.scheduler.now_ns


def _read(line: bytes) -> Request:
    request = json.loads(line)
    if not isinstance(request, dict):
        raise RequestError("a request is an object")
    return request
