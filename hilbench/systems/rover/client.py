"""The host that the suite ``pkt-host`` puts to the test: our ground station, a program we start, or whoever comes."""

from __future__ import annotations

from hilbench.bench.under_test import OwnUnderTest, UnderTest
from hilbench.systems.rover.ground_station import GroundStation
from hilbench.systems.rover.reporting_station import ReportingStation
from protocols.pkt import LocalProtocolError

__all__ = ["OWN_HOST_CAPABILITIES", "HostUnderTest", "OwnHost"]

OWN_HOST_CAPABILITIES = frozenset({"client", "client.report", "client.commands", "client.disconnect"})

HostUnderTest = UnderTest[GroundStation | ReportingStation]
"""A host that can be made to speak to its rover."""


class OwnHost(OwnUnderTest[GroundStation]):
    """The ground station of this package."""

    def __init__(self, station: GroundStation) -> None:
        super().__init__(station, called="host", refusal=LocalProtocolError)
