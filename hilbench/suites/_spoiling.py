"""Corrupted frames, as members of a family: bits turned, other values in place, checksums by another rule."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

from protocols.common.checksum import Checksum

__all__ = ["WrongByte", "other_rules", "other_values", "single_bits"]


@dataclass(frozen=True, slots=True)
class WrongByte:
    """A value at a place of a frame, counted from 0, where another one belongs."""

    place: int
    value: int

    def put_into(self, frame: bytes) -> bytes:
        """Return the frame with it."""
        return frame[: self.place] + bytes((self.value,)) + frame[self.place + 1 :]


Members = Sequence[tuple[str, WrongByte]]


def single_bits(frame: bytes, names: Mapping[int, str]) -> Members:
    """Turn each bit of these bytes; they are named by their places."""
    return [
        (f"{name}, bit {bit}", WrongByte(place, frame[place] ^ 1 << bit))
        for place, name in names.items()
        for bit in range(8)
    ]


def other_values(frame: bytes, names: Mapping[int, str], but: Collection[int] = ()) -> Members:
    """Put each other value into each of these bytes, but for those of `single_bits`, and for these values."""
    single = {wrong for _, wrong in single_bits(frame, names)}
    wrong = [
        (f"{name} is {value:02X}", WrongByte(place, value))
        for place, name in names.items()
        for value in range(256)
        if value != frame[place] and value not in but
    ]
    return [(what, one) for what, one in wrong if one not in single]


def other_rules(frame: bytes, rule: Checksum) -> Sequence[tuple[str, bytes]]:
    """Put the checksum into a frame that a rule makes of it which is a little other than this one."""
    others = {
        "begun with every bit of the first value turned": replace(rule, begin=rule.begin ^ ((1 << 8 * rule.size) - 1)),
        "without the first byte": replace(rule, first=rule.first + 1),
        "with the byte before the first": replace(rule, first=rule.first - 1),
        "with its bytes swapped": replace(rule, order="little" if rule.order == "big" else "big"),
    }
    made = {what: other.mended(frame) for what, other in others.items()}
    return [(f"a checksum {what}", wrong) for what, wrong in made.items() if wrong != frame]
