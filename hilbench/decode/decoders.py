"""The protocols whose frames can be read: bytes in, items out, in order and without a gap.

A protocol is loaded when a stream of it is read, for each takes its time.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from hilbench.decode.reading import DecodeOptions, Decoder, Speaker

__all__ = ["DECODERS"]


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
