"""The floating-point registers between two slices: S0 to S31, which D0 to D15 are pairs of, and FPSCR."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from typing import Any

from targets.mcu.engine.api import FLOAT_WORDS

__all__ = ["FloatFile"]

_DOUBLES = 16


class FloatFile:
    """Floating-point registers of a Unicorn instance.

    Args:
        lib: Unicorn's library.
        handle: the instance in it.
        arm_const: Unicorn's names of registers.
    """

    def __init__(self, lib: Any, handle: Any, arm_const: Any) -> None:
        self._lib, self._handle = lib, handle
        self._values = (ctypes.c_uint32 * FLOAT_WORDS)()
        first = ctypes.addressof(self._values)
        ids = [getattr(arm_const, f"UC_ARM_REG_D{number}") for number in range(_DOUBLES)]
        self._ids = (ctypes.c_int * (_DOUBLES + 1))(*ids, arm_const.UC_ARM_REG_FPSCR)
        self._pointers = (ctypes.c_void_p * (_DOUBLES + 1))(*(first + 8 * place for place in range(_DOUBLES + 1)))

    def get(self) -> list[int]:
        """Return S0 to S31 and FPSCR."""
        self._lib.uc_reg_read_batch(self._handle, self._ids, self._pointers, _DOUBLES + 1)
        return list(self._values)

    def set(self, words: Sequence[int]) -> None:
        """Set S0 to S31 and FPSCR; not while the core executes."""
        self._values[:] = list(words)
        self._lib.uc_reg_write_batch(self._handle, self._ids, self._pointers, _DOUBLES + 1)

    def contents(self) -> bytes:
        """Return all of them, as bytes to compare."""
        self._lib.uc_reg_read_batch(self._handle, self._ids, self._pointers, _DOUBLES + 1)
        return bytes(self._values)
