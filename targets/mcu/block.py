"""A block of registers that is in C (``block.h``): it answers the CPU there, and the bus and people through here."""

from __future__ import annotations

import ctypes
import functools
import weakref
from collections.abc import Callable, Mapping
from typing import Any

from targets.mcu.core.library import structure, with_lock_held
from targets.mcu.errors import EngineError
from targets.mcu.registers import Peripheral, Register
from targets.mcu.timebase import Timebase

__all__ = ["BlockInC", "Kept", "PeripheralInC", "library"]

_NOT_HERE = (1 << 64) - 1


class Kept:
    """Registers by their offsets, in memory that C sees too."""

    __slots__ = ("_words",)

    def __init__(self, words: memoryview) -> None:
        self._words = words

    def __getitem__(self, offset: int) -> int:
        return self._words[offset >> 2]

    def __setitem__(self, offset: int, value: int) -> None:
        self._words[offset >> 2] = value


class BlockInC:
    """See the module.

    Args:
        time: the chip's cycles and events.
        block: ``struct hil_block *``, or None: there was no memory.
        free: ends its life.
        base: address of the first register.
        registers: by offset.

    Attributes:
        block: for `CoreEngine.attach`.
        registers: ``struct hil_registers``.
        values: what is kept for the registers.

    Raises:
        EngineError: there is no memory.
    """

    def __init__(
        self,
        time: Timebase,
        block: int | None,
        free: Callable[[ctypes.c_void_p], None],
        *,
        base: int,
        registers: Mapping[int, Register],
    ) -> None:
        if not block:
            raise EngineError("there is no memory for a peripheral")
        self._time = time
        self.block = ctypes.c_void_p(block)
        weakref.finalize(self, free, self.block).atexit = False
        time.keep_alive(self)
        functions = library()
        self.registers: Any = structure("hil_registers").from_address(functions.hil_registers_of(self.block))
        self.registers.base = base
        for offset, register in registers.items():
            self.registers.writable[offset >> 2] = register.writable
            self.registers.ignored[offset >> 2] = register.ignored
        self.values = Kept(memoryview(self.registers.values).cast("B").cast("I"))
        self._store: Callable[[int, int], bool] = functools.partial(functions.hil_block_store, self.block)
        self._load: Callable[[int], int] = functools.partial(functions.hil_block_load, self.block)

    def load(self, offset: int) -> int | None:
        """Read a register as a program does, with its effects; None: it is for Python."""
        value = self._load(offset >> 2)
        self._time.raise_kept()
        return None if value == _NOT_HERE else value

    def store(self, offset: int, value: int) -> bool:
        """Write one; False: nothing was done, it is for Python."""
        done = self._store(offset >> 2, value)
        self._time.raise_kept()
        return done

    def keep(self, trouble: BaseException) -> None:
        """Have an exception come out of whatever lets time pass."""
        self._time.keep(trouble)


class PeripheralInC(Peripheral):
    """A peripheral with `in_c`, which its constructor makes before that of this class is called."""

    in_c: BlockInC

    @property
    def clocked(self) -> bool:
        """False while the clock gate is shut."""
        return bool(self.in_c.registers.clocked)

    @clocked.setter
    def clocked(self, clocked: bool) -> None:
        self.in_c.registers.clocked = clocked

    def read(self, offset: int) -> int:
        """Read a register; see `Peripheral.read`."""
        value = self.in_c.load(offset) if offset in self.registers else None
        return super().read(offset) if value is None else value

    def write(self, offset: int, value: int) -> None:
        """Write a register; see `Peripheral.write`."""
        if offset not in self.registers or not self.in_c.store(offset, value):
            super().write(offset, value)


@functools.cache
def library() -> Any:
    """Return the library, with the functions of blocks declared, called with Python's lock held."""
    functions: Any = with_lock_held()
    pointer, word = ctypes.c_void_p, ctypes.c_uint32
    functions.hil_registers_of.argtypes, functions.hil_registers_of.restype = (pointer,), pointer
    functions.hil_block_load.argtypes, functions.hil_block_load.restype = (pointer, word), ctypes.c_uint64
    functions.hil_block_store.argtypes, functions.hil_block_store.restype = (pointer, word, word), ctypes.c_bool
    return functions
