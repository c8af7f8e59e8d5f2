"""What a program may ask to be trapped (SCB_CCR) and Unicorn by itself does not: divisions by zero, unaligned accesses.

Both are hooks, which are put in when the program asks for them, so that they cost nothing until then:

- Divisions are looked up in the image, and each gets a hook that reads its divisor before it is executed. One in RAM is
  not found.
- For unaligned accesses every access to memory is looked at; a program that asks for that runs several times slower.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

__all__ = ["Traps", "find_divisions"]


class Traps:
    """The hooks for both traps.

    Args:
        uc: the Unicorn instance.
        register: returns the value of a core register by its number, 0 to 15.
        on_division: called before a division by zero; it must end the slice and undo it.
        on_unaligned: called with the address of an unaligned access; it must end the slice after the instruction.
    """

    def __init__(
        self,
        uc: Any,
        register: Callable[[int], int],
        on_division: Callable[[], None],
        on_unaligned: Callable[[int], None],
    ) -> None:
        self._uc = uc
        self._register = register
        self._on_division = on_division
        self._on_unaligned = on_unaligned
        self._divisions: dict[int, int] = {}
        self._accesses: int | None = None
        self.catches_divisions = False

    def catch_divisions(self, memories: list[tuple[int, bytes]]) -> None:
        """Catch divisions by zero in the code of these memories, (base, contents), from now on; none: no more."""
        self.catches_divisions = bool(memories)
        while self._divisions:
            self._uc.hook_del(self._divisions.popitem()[1])
        for base, code in memories:
            self.note_divisions(base, code)

    def note_divisions(self, base: int, code: bytes) -> None:
        """Catch divisions in code that was put to `base` since."""
        import unicorn

        for offset, divisor in find_divisions(code):
            address = base + offset
            if address in self._divisions:
                self._uc.hook_del(self._divisions.pop(address))
            self._divisions[address] = self._uc.hook_add(
                unicorn.UC_HOOK_CODE, self._about_to_divide, divisor, begin=address, end=address
            )

    def catch_unaligned(self, wanted: bool) -> None:
        """Catch unaligned accesses from now on, or no more."""
        import unicorn

        if wanted and self._accesses is None:
            kinds = unicorn.UC_HOOK_MEM_READ | unicorn.UC_HOOK_MEM_WRITE
            self._accesses = self._uc.hook_add(kinds, self._accessed)
        elif not wanted and self._accesses is not None:
            self._uc.hook_del(self._accesses)
            self._accesses = None

    def _about_to_divide(self, _uc: object, _address: int, _size: int, divisor: int) -> None:
        if not self._register(divisor):
            self._on_division()

    def _accessed(self, _uc: object, _access: int, address: int, size: int, _value: int, _data: object) -> None:
        if address & size - 1:
            self._on_unaligned(address)


def find_divisions(code: bytes) -> Iterator[tuple[int, int]]:
    """Return offset and divisor register of whatever looks like SDIV or UDIV (DDI0403, both encodings T1).

    Where it is data, its hook is never called.
    """
    at = code.find(0xFB)
    while at >= 0:
        if at % 2 and at + 3 <= len(code):
            second, third, fourth = code[at - 1], code[at + 1], code[at + 2]
            if second & 0xD0 == 0x90 and third & 0xF0 == 0xF0 and fourth & 0xF0 == 0xF0:
                yield at - 1, third & 0xF
        at = code.find(0xFB, at + 1)
