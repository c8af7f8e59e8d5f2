"""Our own client of a Pioneer, put to the test."""

from __future__ import annotations

from hilbench.bench.under_test import OwnUnderTest, UnderTest
from hilbench.systems.pioneer.client import P2osClient
from hilbench.systems.pioneer.reporting_client import ReportingClient
from protocols.p2os import LocalProtocolError

__all__ = ["OWN_CAPABILITIES", "ClientUnderTest", "OwnClient"]

OWN_CAPABILITIES = frozenset(
    {"client", "client.restart", "client.disconnect", "client.commands", "client.report", "client.options"}
)

ClientUnderTest = UnderTest[P2osClient | ReportingClient]
"""A client that can be made to connect."""


class OwnClient(OwnUnderTest[P2osClient]):
    """The client of this package."""

    def __init__(self, client: P2osClient) -> None:
        super().__init__(client, called="client", refusal=LocalProtocolError)
