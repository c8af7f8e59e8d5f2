"""What happens at one end of a line in every protocol."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

__all__ = ["FrameDropped", "StateChanged", "Transmit"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Transmit:
    """Bytes to be written to the line now, whole frames."""

    data: bytes


@dataclass(frozen=True, slots=True, kw_only=True)
class StateChanged:
    """The machine went from one state to another."""

    old: Enum
    new: Enum
    trigger: Enum


@dataclass(frozen=True, slots=True, kw_only=True)
class FrameDropped:
    """Bytes that did not become a message; `data` is what stood on the line."""

    reason: Enum
    data: bytes
