"""A port whose bytes pass a door of this machine on their way."""

from __future__ import annotations

from typing import Protocol

from hilbench.links.front import PortInFront
from hilbench.links.port import Port

__all__ = ["Route", "ThroughPort"]


class Route(Protocol):
    """Where bytes pass, in both directions; none is kept back.

    Attributes:
        passed: how many have, both ways together.
    """

    passed: int

    def to_far_end(self, data: bytes) -> bytes:
        """Pass bytes from the near end; return what comes out.

        Raises:
            UnavailableError: some do not come out.
        """

    def to_near_end(self, data: bytes) -> bytes:
        """Pass bytes from the far end; return what comes out.

        Raises:
            UnavailableError: some do not come out.
        """


class ThroughPort(PortInFront):
    """A port of whose line a route is a part. A break goes past it: not every kind of route knows one.

    Args:
        port: the port; its callbacks belong to this one from now on.
        route: what the bytes pass; it stays when the port is closed, for the next one of this name.
    """

    def __init__(self, port: Port, route: Route) -> None:
        super().__init__(port)
        self._route = route
        self.counters = port.counters
        port.on_sent = self._handed_over

    def write(self, data: bytes) -> None:
        """Hand bytes to the port, by way of the route."""
        self.port.write(self._route.to_far_end(data))

    def _received(self, data: bytes, at_ns: int) -> None:
        self.on_receive(self._route.to_near_end(data), at_ns)

    def _handed_over(self, data: bytes, at_ns: int) -> None:
        self.on_sent(data, at_ns)
