"""A way for each of the checker's lines."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Mapping

from hilbench.errors import UnavailableError
from hilbench.links import Port
from hilbench.through.port import Route, ThroughPort
from hilbench.through.way import Way

__all__ = ["Routes"]

_WORDS: Mapping[str, str] = {
    "pty": "pseudo-terminals of this machine",
    "tcp": "TCP sockets of this machine",
    "rfc2217": "RFC 2217 within this machine",
    "proxy": "pseudo-terminals of this machine, a proxy between two each",
}
"""The ways there are, and what a report says of them."""


class Routes:
    """Ways that are kept for the whole run, and end with `close`.

    Args:
        kind: one of `hilbench.terminal.options.THROUGH`.
    """

    def __init__(self, kind: str) -> None:
        self._kind = kind
        self._refused = ""
        self._routes: dict[str, Route] = {}
        self._stack = contextlib.ExitStack()

    @property
    def words(self) -> str:
        """What has passed where, for a report."""
        kind = _WORDS[self._kind]
        if self._routes:
            return f"through {kind}"
        if self._refused:
            return f"{self._refused} could not be led through {kind}"
        return f"nothing has passed {kind}: the checker has had no line"

    @property
    def passed(self) -> int:
        """Bytes that have passed the ways there are, both directions together."""
        return sum(route.passed for route in self._routes.values())

    def __call__(self, port: Port) -> Port:
        """Return what stands for the port now.

        Raises:
            UnavailableError: there is no way, for want of pseudo-terminals, sockets or descriptors.
        """
        if port.name not in self._routes:
            self._routes[port.name] = self._open(port.name)
        return ThroughPort(port, self._routes[port.name])

    def close(self) -> None:
        """Give up all ways; a second call does nothing."""
        self._stack.close()
        self._routes.clear()

    def _open(self, name: str) -> Route:
        self._refused = name
        try:
            way = Way(self._kind, name)
        except OSError as error:
            hint = "see ulimit -n" if error.errno is not None else None
            message = f"no way through {_WORDS[self._kind]}: {os.strerror(error.errno) if error.errno else error}"
            raise UnavailableError(message, where=name, hint=hint) from error
        self._stack.callback(way.close)
        return way
