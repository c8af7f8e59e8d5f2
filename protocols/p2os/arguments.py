"""The argument of a command: three types, and the packing of two bytes into one integer.

| Type byte | Argument             | Value bytes                                        |
|-----------|----------------------|----------------------------------------------------|
| `3B`      | non-negative integer | magnitude, two bytes, low byte first               |
| `1B`      | negative integer     | **magnitude**, not two's complement: -1 is `01 00` |
| `2B`      | string               | one length byte, then that many bytes              |

(Pioneer 2 Operations Manual, client-server chapter; AriaCoda ArRobotPacket.cpp and ArRobot.cpp; Player p2os driver.)

Real senders bend these rules, and the decoder follows them: a type byte with no value behind it (the Player driver
sends SETO so), magnitudes of 8000 hex and more with type `3B` (its VEL2), an uncounted NUL behind a string (ARIA's
`comStr`), and raw bytes without a length byte (ARIA's `comDataN`).
"""

from __future__ import annotations

import enum

from protocols.p2os.errors import LocalProtocolError, RemoteProtocolError

__all__ = [
    "ArgumentForm",
    "BytePacking",
    "decode_argument",
    "encode_argument",
    "pack_bytes",
    "unpack_bytes",
    "unpack_signed_bytes",
]

POSITIVE, NEGATIVE, STRING = 0x3B, 0x1B, 0x2B
_MAX_MAGNITUDE = 0xFFFF
_MAX_STRING = 0xFF


class ArgumentForm(enum.Enum):
    """How an argument is written; all but the first exist to say what a bending sender says."""

    PLAIN = "as the manual has it"
    STRING_WITH_NUL = "a string followed by a NUL that its length does not count (ARIA comStr)"
    RAW_STRING = "bytes straight behind the type, without a length (ARIA comDataN)"
    TYPE_ONLY = "a type byte without a value (Player's SETO)"


def encode_argument(argument: int | bytes | None, form: ArgumentForm = ArgumentForm.PLAIN) -> bytes:
    """The bytes behind the command number.

    Args:
        argument: an integer of -65535..65535, a string of at most 255 bytes, or None for no argument at all.
        form: one of the senders' ways; see `ArgumentForm`.

    Raises:
        LocalProtocolError: the argument does not fit its type.
    """
    if form is ArgumentForm.TYPE_ONLY:
        return bytes((STRING if isinstance(argument, bytes) else POSITIVE,))
    if argument is None:
        return b""
    if isinstance(argument, int):
        return _encode_integer(argument)
    if form is ArgumentForm.RAW_STRING:
        return bytes((STRING,)) + argument
    if len(argument) > _MAX_STRING:
        raise LocalProtocolError(f"a string of {len(argument)} bytes has no one-byte length")
    return bytes((STRING, len(argument))) + argument + (b"\0" if form is ArgumentForm.STRING_WITH_NUL else b"")


def _encode_integer(value: int) -> bytes:
    if abs(value) > _MAX_MAGNITUDE:
        raise LocalProtocolError(f"the integer {value} does not fit in sixteen bits of magnitude")
    return bytes((NEGATIVE if value < 0 else POSITIVE,)) + abs(value).to_bytes(2, "little")


def decode_argument(data: bytes, *, raw_string: bool = False) -> int | bytes | None:
    """The argument behind the command number; None where there is none or only its type.

    Args:
        data: the body without its first byte.
        raw_string: take a string whose length byte reaches past the end for raw bytes without a length, as ARIA's
            `comDataN` sends them.

    Raises:
        RemoteProtocolError: unknown type, half an integer, or a string longer than the body.
    """
    if not data:
        return None
    kind, value = data[0], data[1:]
    if kind not in (POSITIVE, NEGATIVE, STRING):
        raise RemoteProtocolError(f"argument type {kind:02X} is none of 3B, 1B, 2B")
    if not value:
        return None
    if kind == STRING:
        return _decode_string(value, raw_string=raw_string)
    if len(value) == 1:
        raise RemoteProtocolError("half an integer argument")
    magnitude = int.from_bytes(value[:2], "little")
    return -magnitude if kind == NEGATIVE else magnitude


def _decode_string(value: bytes, *, raw_string: bool) -> bytes:
    length, text = value[0], value[1:]
    if length <= len(text):
        return text[:length]
    if raw_string:
        return value
    raise RemoteProtocolError(f"a string of {length} bytes in {len(text)}")


class BytePacking(enum.Enum):
    """How the two bytes of VEL2, DIGOUT, PTUPOS become an integer argument; a server reads both alike."""

    SIGNED = "a signed sixteen-bit word, sent as sign and magnitude (AriaCoda ArRobot.cpp, com2Bytes)"
    RAW = "the two bytes as they are, type 3B (Player p2os driver, p2os.cc)"


def pack_bytes(high: int, low: int, packing: BytePacking = BytePacking.SIGNED) -> int:
    """One integer argument from two bytes, each -128..255.

    Raises:
        LocalProtocolError: a value that is no byte.
    """
    for name, byte in (("high", high), ("low", low)):
        if not -128 <= byte <= _MAX_STRING:
            raise LocalProtocolError(f"{name} byte {byte} is not -128..255")
    word = (high & 0xFF) << 8 | (low & 0xFF)
    return word - 0x10000 if packing is BytePacking.SIGNED and word & 0x8000 else word


def unpack_bytes(argument: int) -> tuple[int, int]:
    """The (high, low) bytes, each 0..255, of an integer argument in either packing."""
    word = argument & 0xFFFF
    return word >> 8, word & 0xFF


def unpack_signed_bytes(argument: int) -> tuple[int, int]:
    """The (high, low) bytes, each -128..127, of an integer argument in either packing."""
    high, low = unpack_bytes(argument)
    return (high ^ 0x80) - 0x80, (low ^ 0x80) - 0x80
