"""The host that the suite ``pkt-host`` puts to the test: our ground station, a program we start, or whoever comes."""

from __future__ import annotations

from typing import Protocol

from hilbench.check.verdicts import Violation
from hilbench.ground_station import GroundStation
from protocols.pkt import LocalProtocolError

__all__ = ["OWN_HOST_CAPABILITIES", "HostUnderTest", "OwnHost"]

OWN_HOST_CAPABILITIES = frozenset({"client", "client.report", "client.commands", "client.disconnect"})


class HostUnderTest(Protocol):
    """A host that can be made to speak to its rover."""

    @property
    def own(self) -> GroundStation | None:
        """Our own ground station, which can be commanded and asked; None if it is a foreign one."""

    def start(self) -> None:
        """Have the host speak to its rover, from scratch.

        Raises:
            UnavailableError: it cannot be started, or nobody came.
        """

    def ended(self) -> str:
        """Say how the host ended by itself, as in "exited with status 3"; empty while it lives."""

    def disconnect(self) -> None:
        """Have the user of the host take leave."""

    def close(self) -> None:
        """Make sure the host is gone."""


class OwnHost:
    """The ground station of this package."""

    def __init__(self, station: GroundStation) -> None:
        self._station = station

    @property
    def own(self) -> GroundStation:
        """The station itself."""
        return self._station

    def start(self) -> None:
        """Begin to ask.

        Raises:
            Violation: it does not want to.
        """
        try:
            self._station.connect()
        except LocalProtocolError as error:
            raise Violation(f"the host does not begin: {error}") from error

    def ended(self) -> str:
        """Return nothing: it lives and dies with its bench."""
        return ""

    def disconnect(self) -> None:
        """Take leave.

        Raises:
            Violation: it does not want to.
        """
        try:
            self._station.disconnect()
        except LocalProtocolError as error:
            raise Violation(f"the host does not take its leave: {error}") from error

    def close(self) -> None:
        """Nothing to do: it lives and dies with its bench."""
