"""The u-blox NEO-6M, a GPS receiver. Start at `neo6m.py`."""

from __future__ import annotations

from targets.parts.neo6m.events import FixChanged, ReceiverNote, ReceiverStarted
from targets.parts.neo6m.neo6m import Neo6m
from targets.parts.neo6m.settings import Neo6mSettings

__all__ = ["FixChanged", "Neo6m", "Neo6mSettings", "ReceiverNote", "ReceiverStarted"]
