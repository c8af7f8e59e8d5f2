"""The package exports what it says, and needs nothing but the standard library."""

from __future__ import annotations

from protocols import xrce
from tests.protocols.clauses import check_package


def test_package():
    check_package(xrce)
