"""The frames of a serial line, with the options of this protocol; see `protocols.common.flagged`.

The specification (OMG DDS-XRCE 1.0, Annex C.1.1.6) wants the CRC of RFC 1662 over addresses, length and payload; what
clients and agents in use have instead is CRC-16/ARC over the payload alone.
"""

from __future__ import annotations

from protocols.common import flagged
from protocols.common.flagged import NOISE_RUN, Dropped, DropReason, Frame
from protocols.xrce.options import FramingOptions

__all__ = ["NOISE_RUN", "DropReason", "Dropped", "Frame", "FrameReader", "encode_frame", "longest_frame"]

_DEFAULTS = FramingOptions()


class FrameReader(flagged.FrameReader):
    """Finds frames in a stream."""

    def __init__(self, options: FramingOptions = _DEFAULTS) -> None:
        super().__init__(options)


def encode_frame(payload: bytes, options: FramingOptions = _DEFAULTS) -> bytes:
    """The whole frame around a payload.

    Raises:
        LocalProtocolError: the payload is longer than the options allow.
    """
    return flagged.encode_frame(payload, options)


def longest_frame(options: FramingOptions = _DEFAULTS) -> int:
    """The size of the longest frame, in bytes."""
    return flagged.longest_frame(options)
