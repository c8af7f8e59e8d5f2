"""The frames of each protocol: bytes in, items out, in order and without a gap.

A protocol is loaded when a stream of it is read, for each takes its time.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, Protocol

from hilbench.decode.items import Item

if TYPE_CHECKING:
    from protocols import pkt

__all__ = ["DECODERS", "DecodeOptions", "Decoder", "Speaker", "fields_of"]

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
    """Reads one stream."""

    def feed(self, data: bytes) -> Iterable[Item]:
        """Take bytes; return what they complete."""

    def finish(self) -> Iterable[Item]:
        """Return what is left when nothing more comes."""


def _pkt(options: DecodeOptions, speaker: Speaker) -> Decoder:
    from hilbench.decode.pkt_decoder import PktDecoder

    return PktDecoder(options, speaker)


def _p2os(options: DecodeOptions, speaker: Speaker) -> Decoder:
    from hilbench.decode.p2os_decoder import P2osDecoder

    return P2osDecoder(options, speaker)


def _autoware(options: DecodeOptions, speaker: Speaker) -> Decoder:
    from hilbench.decode.autoware_decoder import AutowareDecoder

    return AutowareDecoder(options, speaker)


def _carla(options: DecodeOptions, speaker: Speaker) -> Decoder:
    from hilbench.decode.carla_decoder import CarlaDecoder

    return CarlaDecoder(options, speaker)


DECODERS: Mapping[str, Callable[[DecodeOptions, Speaker], Decoder]] = {
    "pkt": _pkt,
    "p2os": _p2os,
    "autoware": _autoware,
    "carla": _carla,
}
"""By the name of the protocol."""


def fields_of(message: Any) -> dict[str, object]:
    """Return the fields of a message by their names."""
    return {field.name: getattr(message, field.name) for field in fields(message)}
