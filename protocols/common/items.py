"""What a decoder makes of bytes: messages, frames without a meaning, and bytes in no frame."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum

__all__ = ["Item", "Kind"]


class Kind(Enum):
    """How far bytes could be decoded."""

    FRAME = "frame"
    """A valid frame with a known message."""
    UNREADABLE = "unreadable"
    """A valid frame whose content makes no sense."""
    DROPPED = "dropped"
    """Bytes that belong to no valid frame."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Item:
    """Some bytes of a stream.

    Attributes:
        kind: how far they could be decoded.
        name: the name of the message, or why there is none.
        raw: the bytes.
        fields: the fields of the message, by name.
        message: the protocol's own object of the message; a check waits for it by its class. None if there is none.
    """

    kind: Kind
    name: str
    raw: bytes
    fields: Mapping[str, object] = field(default_factory=dict)
    message: object = None
