"""Randomness without a memory: what is drawn depends on the seed, on its purpose and on a number, and on nothing else.

A part that draws the noise of its sample 17 gets the same noise whether it was asked for samples 1 to 16 or not, so
that it makes no difference how a run was cut into pieces.
"""

from __future__ import annotations

import hashlib
import math
import struct

__all__ = ["gaussians", "uniforms"]

_PAIRS = 4
_WORDS = struct.Struct(f"<{2 * _PAIRS}Q")
_SCALE = 2.0**-53


def uniforms(seed: int, purpose: str, index: int) -> tuple[float, ...]:
    """Return eight numbers in 0..1 (1 excluded).

    Args:
        seed: of the part; any whole number.
        purpose: what they are for, up to 16 letters.
        index: number of the drawing, 0 or more.
    """
    key = (seed % 2**64).to_bytes(8, "little")
    person = purpose.encode().ljust(16, b"\0")
    digest = hashlib.blake2b(index.to_bytes(8, "little"), digest_size=_WORDS.size, key=key, person=person).digest()
    return tuple((word >> 11) * _SCALE for word in _WORDS.unpack(digest))


def gaussians(seed: int, purpose: str, index: int) -> tuple[float, ...]:
    """Return eight numbers of mean 0 and standard deviation 1 (Box and Muller); see `uniforms`."""
    drawn = uniforms(seed, purpose, index)
    found: list[float] = []
    for pair in range(_PAIRS):
        radius = math.sqrt(-2.0 * math.log(1.0 - drawn[2 * pair]))
        angle = 2.0 * math.pi * drawn[2 * pair + 1]
        found += (radius * math.cos(angle), radius * math.sin(angle))
    return tuple(found)
