"""What bytes turn out to be: frames that say something, frames that do not, and the rest."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum

__all__ = ["Item", "Kind"]


class Kind(Enum):
    """How far bytes could be read."""

    FRAME = "frame"
    """A sound frame that says something."""
    UNREADABLE = "unreadable"
    """A sound frame whose content makes no sense."""
    DROPPED = "dropped"
    """Bytes that belong to no sound frame."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Item:
    """Some bytes of a stream.

    Attributes:
        kind: how far they could be read.
        name: of the message; else why there is none.
        raw: the bytes.
        fields: what the message says.
        message: the protocol's own object of it, which a check waits for by its class; None where there is none.
    """

    kind: Kind
    name: str
    raw: bytes
    fields: Mapping[str, object] = field(default_factory=dict)
    message: object = None
