"""Runs an image on the bare engine with the block not in memory but behind registers: every access is a call.

So loads and stores of every kind take the way that firmware takes to a peripheral, and the run can be ended from within
any of them, as an event that an access makes due earlier does.
"""

from __future__ import annotations

from targets.mcu.cortexm.kinds import CORTEX_M3, CoreKind
from targets.mcu.engine.api import Access, Reg, StopKind
from targets.mcu.engine.core_engine import CoreEngine
from targets.mcu.engine.timing import make_timing
from tests.targets.mcu.differential.image import BLOCK, FLASH, RAM, STACK_TOP

_PAGE = 0x400
_FLASH_SIZE, _RAM_SIZE = 0x1_0000, 0x1_0000
_PPB = 0xE000_0000
_SYS_OPEN, _SYS_WRITE, _SYS_EXIT = 0x01, 0x05, 0x18
_NO_LIMIT = 1 << 40


class Run:
    """A run of an image.

    Args:
        image: what is in flash.
        stops: end the slice with every access to the block.
        kind: the core.

    Attributes:
        accesses: to the block, so far.
        slices: that the run took, so far.
    """

    def __init__(self, image: bytes, *, stops: bool, kind: CoreKind = CORTEX_M3) -> None:
        self.accesses = self.slices = 0
        self._stops = stops
        self._block = bytearray(_PAGE)
        self._below, self._above = bytearray(BLOCK - RAM), bytearray(RAM + _RAM_SIZE - BLOCK - _PAGE)
        self._engine = engine = CoreEngine(make_timing("flat", kind), kind)
        engine.map_memory(FLASH, bytearray(image.ljust(_FLASH_SIZE, b"\xff")), writable=False)
        engine.map_memory(RAM, self._below, writable=True)
        engine.map_registers(BLOCK, _PAGE, Access(self._read, self._write))
        engine.map_registers(_PPB, 0x10_0000, Access(lambda _offset, _size: 0, lambda _offset, _size, _value: None))
        engine.map_memory(BLOCK + _PAGE, self._above, writable=True)
        engine.set(Reg.XPSR, 1 << 24)
        engine.set(Reg.SP, STACK_TOP)
        engine.set(Reg.PC, int.from_bytes(image[4:8], "little") & ~1)
        self._flash = image
        self._output = bytearray()

    def output(self) -> bytes:
        """Run to the end; return what the image wrote."""
        engine = self._engine
        while True:
            stop = engine.run(_NO_LIMIT)
            self.slices += 1
            if stop.kind is StopKind.LIMIT:
                continue
            assert stop.kind is StopKind.BREAKPOINT, (stop, hex(engine.get(Reg.PC)))
            if engine.get(Reg.R0) == _SYS_EXIT:
                return bytes(self._output)
            self._answer(engine.get(Reg.R0), engine.get(Reg.R1))
            engine.set(Reg.PC, engine.get(Reg.PC) + 2)

    def _answer(self, operation: int, block: int) -> None:
        if operation == _SYS_WRITE:
            start, length = self._word(block + 4), self._word(block + 8)
            self._output += bytes(self._byte(start + at) for at in range(length))
        self._engine.set(Reg.R0, 1 if operation == _SYS_OPEN else 0)

    def _read(self, offset: int, size: int) -> int:
        self._count()
        return int.from_bytes(self._block[offset : offset + size], "little")

    def _write(self, offset: int, size: int, value: int) -> None:
        self._count()
        self._block[offset : offset + size] = (value & ((1 << 8 * size) - 1)).to_bytes(size, "little")

    def _count(self) -> None:
        self.accesses += 1
        if self._stops:
            self._engine.stop_by(0)

    def _word(self, address: int) -> int:
        return sum(self._byte(address + at) << 8 * at for at in range(4))

    def _byte(self, address: int) -> int:
        memory, base = next(
            (memory, base)
            for memory, base in ((self._above, BLOCK + _PAGE), (self._block, BLOCK), (self._below, RAM))
            if address >= base
        )
        return memory[address - base]
