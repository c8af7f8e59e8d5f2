"""What is wrong with the parameters of motor commands and gains that a host sends, by the rover's document alone."""

from __future__ import annotations

import math
import struct
from collections.abc import Sequence

from protocols.pkt import COMMANDS, Schema

__all__ = ["turned_round", "wrong_parameters"]

_NUMBERS = {3: 2, 4: 2, 5: 3}
"""How many floats stand behind these opcodes."""
_THROTTLE = 3
_ROUNDED = 1e-6
"""What adds up to full throttle in single precision may be more by some of its steps of 1.2e-7. A choice."""
_LEAST = 1e-3
"""Nobody drives with less, of full throttle or in turns per minute. A choice."""


def wrong_parameters(payload: bytes) -> str:
    """Return what the document does not permit of a command's parameters; empty if nothing."""
    opcode, size = payload[0], len(payload) - 1
    if opcode not in _NUMBERS:
        return ""
    if size != (wanted := COMMANDS[Schema.V2][opcode].size):
        return f"0x{opcode:02X} has {size} bytes of parameters, required {wanted}"
    numbers = _read(payload, "<")
    if not all(map(math.isfinite, numbers)):
        return f"0x{opcode:02X} has a parameter that is no finite number"
    if opcode == _THROTTLE and max(map(abs, numbers)) > 1 + _ROUNDED:
        return f"0x{opcode:02X} has throttles of {_words(numbers)}, required -1 to 1"
    return ""


def turned_round(payloads: Sequence[bytes]) -> str:
    """Return what tells that all motor commands have the highest byte of a number first; empty if they have not.

    Read as they should be they hardly move anything, and read the other way round all of them do.
    """
    motors = [payload for payload in payloads if payload[0] in (3, 4) and any(_read(payload, "<"))]
    right = [abs(number) for payload in motors for number in _read(payload, "<")]
    other = [abs(number) for payload in motors for number in _read(payload, ">") if number]
    if not motors or max(right) >= _LEAST or not all(_LEAST <= number <= _most(motors) for number in other):
        return ""
    shown, other_way = (_words(_read(motors[0], order)) for order in "<>")
    return f"0x{motors[0][0]:02X} has {shown}, and {other_way} if the highest byte came first"


def _most(motors: Sequence[bytes]) -> float:
    return 1.0 if any(payload[0] == _THROTTLE for payload in motors) else 1000.0


def _read(payload: bytes, order: str) -> tuple[float, ...]:
    return struct.unpack_from(f"{order}{_NUMBERS[payload[0]]}f", payload, 1)


def _words(numbers: Sequence[float]) -> str:
    return " and ".join(f"{number:.4g}" for number in numbers)
