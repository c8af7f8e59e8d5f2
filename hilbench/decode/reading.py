"""How a stream is read, and what reads one."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Sequence
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, Protocol

from hilbench.decode.items import Item

if TYPE_CHECKING:
    from protocols import pkt

__all__ = ["DecodeOptions", "Decoder", "Speaker", "fields_of"]

Speaker = str
"""Who sends a stream: ``host``, ``target``, or nothing if that is not known."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DecodeOptions:
    """How bytes are read.

    Attributes:
        framing: PKT!: where a payload ends; behind its length if None.
        schema: PKT!: what stands in it; that of the second firmware if None.
    """

    framing: pkt.Framing | None = None
    schema: pkt.Schema | None = None


class Decoder(Protocol):
    """Reads one stream. Whoever looks at few of many frames finds them all, and reads those."""

    def find(self, data: bytes) -> Sequence[Any]:
        """Take bytes; return what they complete, not read yet."""

    def sort(self, found: Any) -> Hashable:
        """Return what tells a frame that was found from those of other messages; None of bytes that are no frame."""

    def read(self, found: Any) -> Item:
        """Read what was found."""

    def feed(self, data: bytes) -> Iterable[Item]:
        """Take bytes; return what they complete."""

    def finish(self) -> Iterable[Item]:
        """Return what is left when nothing more comes."""


def fields_of(message: Any) -> dict[str, object]:
    """Return the fields of a message by their names."""
    return {field.name: getattr(message, field.name) for field in fields(message)}
