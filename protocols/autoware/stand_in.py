"""The frames of the stand-in link, with its options; see `protocols.common.flagged`.

They are those of the serial stream of Micro XRCE-DDS, so that an agent can take over the line; the payload is ours
(`payload.py`).
"""

from __future__ import annotations

from protocols.autoware.options import FramingOptions
from protocols.common import flagged
from protocols.common.flagged import CRC_BYTES, NOISE_RUN, Dropped, DropReason, Frame, crc16

__all__ = [
    "CRC_BYTES",
    "NOISE_RUN",
    "DropReason",
    "Dropped",
    "Frame",
    "FrameReader",
    "crc16",
    "encode_frame",
    "longest_frame",
]

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
