"""hilbench: a hardware-in-the-loop bench for serial protocol stacks."""

from __future__ import annotations

__version__ = "0.1.0"
