"""Runs an image on an engine alone, whole or cut into pieces; its calls of the debugger are answered here."""

from __future__ import annotations

from collections.abc import Iterator

from targets.mcu.cortexm.kinds import CORTEX_M7, CoreKind
from targets.mcu.engine.api import Access, Reg, StopKind
from targets.mcu.engine.core_engine import CoreEngine
from targets.mcu.engine.timing import make_timing
from tests.targets.mcu.differential.image import FLASH, RAM, STACK_TOP

_FLASH_SIZE, _RAM_SIZE = 0x1_0000, 0x1_0000
_PPB = 0xE000_0000
_SYS_OPEN, _SYS_WRITE, _SYS_EXIT = 0x01, 0x05, 0x18
_NO_LIMIT = 1 << 40


class Run:
    """A run of an image.

    Args:
        image: what is in flash.
        timing: the timing model.
        kind: the core.
    """

    def __init__(self, image: bytes, timing: str = "flat", kind: CoreKind = CORTEX_M7) -> None:
        self._ram = bytearray(_RAM_SIZE)
        self.engine = engine = CoreEngine(make_timing(timing, kind), kind)
        engine.map_memory(FLASH, bytearray(image.ljust(_FLASH_SIZE, b"\xff")), writable=False)
        engine.map_memory(RAM, self._ram, writable=True)
        engine.map_registers(_PPB, 0x10_0000, Access(lambda _offset, _size: 0, lambda _offset, _size, _value: None))
        engine.set(Reg.XPSR, 1 << 24)
        engine.set(Reg.SP, STACK_TOP)
        engine.set(Reg.PC, int.from_bytes(image[4:8], "little") & ~1)
        self._output = bytearray()

    def output(self, pieces: Iterator[int] | None = None) -> bytes:
        """Run to the end, in pieces of so many instructions; return what the image wrote."""
        engine = self.engine
        while True:
            stop = engine.run(_NO_LIMIT, None if pieces is None else next(pieces))
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
            self._output += self._ram[start - RAM : start - RAM + length]
        self.engine.set(Reg.R0, 1 if operation == _SYS_OPEN else 0)

    def _word(self, address: int) -> int:
        return int.from_bytes(self._ram[address - RAM : address - RAM + 4], "little")
