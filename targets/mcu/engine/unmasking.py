"""Finds the instructions that may take an interrupt mask away: CPSIE and MSR to PRIMASK, BASEPRI or FAULTMASK.

Masks go away in exception returns as well, where the engine stops by itself (encodings: DDI0403 sections A6.7.33 and
B5.2.3). What stands in constants may look the same; it is never executed.
"""

from __future__ import annotations

import re
from collections.abc import Iterator

__all__ = ["LONGEST", "unmasking_places"]

LONGEST = 4
"""Bytes of the longest of these instructions."""

_UNMASKING = re.compile(rb"(?=[\x61-\x67]\xb6|[\x80-\x8f]\xf3[\x10-\x13]\x88)", re.DOTALL)


def unmasking_places(code: bytes | bytearray) -> Iterator[int]:
    """Return the even offsets at which one of these instructions may stand."""
    return (match.start() for match in _UNMASKING.finditer(code) if match.start() % 2 == 0)
