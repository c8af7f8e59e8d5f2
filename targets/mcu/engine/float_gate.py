"""Stops at floating-point instructions while CPACR denies them; Unicorn itself always executes them.

Their places are looked up in the image while access is denied, and each gets a hook that is called before it is
executed; the instruction is then undone, as one whose access fails is. What executes in RAM is looked at instruction by
instruction then. Nothing of this costs anything once the program has allowed access, which is one of the first things
that it does if it has such instructions at all. Where data look like one of them, their hook is never called.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

from targets.mcu.engine.api import FloatAccess

__all__ = ["FloatGate", "float_runs", "is_float"]

# By their upper bytes, 1 for those that may be (DDI0403 section A5.3.18): the first half is 111x 11xx, but not 111x
# 1111 of Advanced SIMD; the second has the number of the coprocessor, 10 or 11, in the lower four bits.
_FIRST = bytes(value & 0xEC == 0xEC and value & 3 != 3 for value in range(256))
_SECOND = bytes(value & 0xE == 0xA for value in range(256))


class FloatGate:
    """The hooks.

    Args:
        uc: the Unicorn instance.
        half: gives the half-word of memory at an even address.
        privileged: says whether the instruction in flight is privileged.
        on_denied: called before an instruction that is denied; it must end the slice and undo it.
    """

    def __init__(
        self, uc: Any, half: Callable[[int], int], privileged: Callable[[], bool], on_denied: Callable[[], None]
    ) -> None:
        self._uc = uc
        self._half = half
        self._privileged = privileged
        self._on_denied = on_denied
        self._hooks: list[int] = []
        self._places: set[int] = set()
        self.access = FloatAccess.EVERYBODY

    def set(self, access: FloatAccess, memories: Sequence[tuple[int, bytearray, bool]]) -> None:
        """Let those execute who may; `memories` are all there are, (base, contents, writable)."""
        self.access = access
        while self._hooks:
            self._uc.hook_del(self._hooks.pop())
        self._places.clear()
        if access is FloatAccess.EVERYBODY:
            return
        for base, data, writable in memories:
            if writable:
                self._hook(base, base + len(data))
            else:
                self.note(base, data)

    def note(self, base: int, code: bytes | bytearray) -> None:
        """Look at code that was put to `base` since."""
        if self.access is FloatAccess.EVERYBODY:
            return
        for start, end in float_runs(code):
            if base + start not in self._places:
                self._places.add(base + start)
                self._hook(base + start, base + end)

    def _hook(self, start: int, end: int) -> None:
        import unicorn

        self._hooks.append(self._uc.hook_add(unicorn.UC_HOOK_CODE, self._about_to, begin=start, end=end - 1))

    def _about_to(self, _uc: object, address: int, _size: int, _data: object) -> None:
        if not is_float(self._half(address), self._half(address + 2)):
            return
        if self.access is FloatAccess.NOBODY or not self._privileged():
            self._on_denied()


def is_float(first: int, second: int) -> bool:
    """Say whether these halves are an instruction of coprocessors 10 and 11, which are floating point."""
    return first & 0xEC00 == 0xEC00 and first & 0x0300 != 0x0300 and second >> 8 & 0xE == 0xA


def float_runs(code: bytes | bytearray) -> Iterator[tuple[int, int]]:
    """Yield where floating-point instructions may stand, one behind the other: start and end offsets."""
    firsts, seconds = bytes(code[1:-2:2]).translate(_FIRST), bytes(code[3::2]).translate(_SECOND)
    both = int.from_bytes(firsts, "little") & int.from_bytes(seconds, "little")
    places = both.to_bytes(len(seconds), "little")
    start = end = -1
    at = places.find(1)
    while at >= 0:
        if 2 * at > end:
            if start >= 0:
                yield start, end
            start = 2 * at
        end = 2 * at + 4
        at = places.find(1, at + 1)
    if start >= 0:
        yield start, end
