from __future__ import annotations

import struct
from types import SimpleNamespace

import pytest

from targets.mcu.cortexm.kinds import CORTEX_M3
from targets.mcu.engine.api import Access, Reg
from targets.mcu.engine.core_engine import CoreEngine
from targets.mcu.engine.timing import make_timing

FLASH, RAM, REGISTERS = 0x0800_0000, 0x2000_0000, 0x4000_0000
CODE = FLASH + 0x100


class Machine:
    """An engine with flash, RAM and one kilobyte of registers that record."""

    def __init__(self, timing="flat", access=None, kind=CORTEX_M3):
        self.engine = CoreEngine(make_timing(timing, kind), kind)
        self.flash, self.ram = bytearray(b"\xff" * 0x4000), bytearray(0x1000)
        self.log = []
        self.on_access = lambda _kind, _offset: None
        self.value = 0
        self.stores = []
        self.engine.map_memory(FLASH, self.flash, writable=False)
        self.engine.map_memory(RAM, self.ram, writable=True)
        self.engine.map_registers(REGISTERS, 0x400, access or Access(self._read, self._write))
        self.engine.on_flash_store = lambda *store: self.stores.append(store)
        self.engine.set(Reg.SP, RAM + 0x1000)
        self.engine.set(Reg.XPSR, 1 << 24)

    def _read(self, offset, size):
        self.log.append(("read", offset, size, self.engine.cycle))
        self.on_access("read", offset)
        return self.value

    def _write(self, offset, size, value):
        self.log.append(("write", offset, size, value, self.engine.cycle))
        self.on_access("write", offset)

    def load(self, *halves, at=CODE):
        code = struct.pack(f"<{len(halves)}H", *halves)
        memory, base = (self.flash, FLASH) if at < RAM else (self.ram, RAM)
        memory[at - base : at - base + len(code)] = code
        self.engine.forget(at, len(code))
        self.engine.set(Reg.PC, at)

    def run(self, instructions=100):
        """Run for that many instructions' worth of cycles."""
        timing, engine = self.engine.timing, self.engine
        return engine.run(timing.cycle(engine.instructions + instructions))

    def regs(self):
        return [self.engine.get(reg) for reg in Reg]


@pytest.fixture(scope="session")
def make():
    return Machine


@pytest.fixture
def machine():
    return Machine()


@pytest.fixture
def at():
    return SimpleNamespace(flash=FLASH, ram=RAM, registers=REGISTERS, code=CODE)
