"""Pixels as a file that every viewer shows."""

from __future__ import annotations

import struct
import zlib

__all__ = ["png"]

GREY, COLOUR = 0, 2
"""Types of a PNG, by the channels of its pixels."""


def png(pixels: bytes, width: int, height: int) -> bytes:
    """Return pixels of 8 bits a channel, row by row from above, as PNG (RFC 2083): grey of one channel, or RGB."""

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    row = len(pixels) // height
    unfiltered = b"".join(b"\0" + pixels[at : at + row] for at in range(0, height * row, row))
    header = struct.pack(">IIBBBBB", width, height, 8, GREY if row == width else COLOUR, 0, 0, 0)
    return (
        b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(unfiltered)) + chunk(b"IEND", b"")
    )
