"""What is wired to a board here is wired as in the tests of the wiring."""

from __future__ import annotations

from tests.hilbench.wiring.conftest import bench, machine, pin, read

__all__ = ["bench", "machine", "pin", "read"]
