"""A core on a CPU without code: registers, memory, a clock, and the machine's loop around them."""

from __future__ import annotations

import pytest

from targets.mcu.cortexm.core import Core
from targets.mcu.cortexm.exceptions import Number
from targets.mcu.cortexm.kinds import CORTEX_M3, CORTEX_M7
from targets.mcu.engine.api import Access, FaultKind, FloatAccess, Reg, Stop, StopKind
from targets.mcu.engine.core_engine import CoreEngine
from targets.mcu.engine.timing import make_timing
from targets.mcu.registers import Peripheral
from targets.mcu.testing import FakeChip

VECTORS, HANDLERS = 0x0800_0000, 0x0800_1000
RAM, RAM_SIZE = 0x2000_0000, 0x400
STACK_TOP = RAM + RAM_SIZE
MAIN = 0x0800_0400
SCS = 0xE000_E000


class Cpu(CoreEngine):
    """A core without code, whose memory is that of a bus."""

    def __init__(self, kind, bus) -> None:
        super().__init__(make_timing("table", kind), kind)
        for base, size in ((0, 0xE000_0000), (0xE000_0000, 0x2000_0000)):
            self.map_registers(base, size, self._window(bus, base))
        self.set(Reg.XPSR, 1 << 24)

    @staticmethod
    def _window(bus, base) -> Access:
        return Access(
            lambda offset, size: bus.read(base + offset, size),
            lambda offset, size, value: bus.write(base + offset, size, value),
        )

    @property
    def registers(self) -> dict[Reg, int]:
        return {register: self.get(register) for register in Reg}

    @property
    def floats(self) -> list[int]:
        return self.get_floats()

    def put_float(self, place: int, word: int) -> None:
        words = self.get_floats()
        words[place] = word
        self.set_floats(words)

    def use_floats(self, *words: int) -> None:
        """Do as a floating-point instruction does that leaves these in S0 and so on."""
        assert self.float_access is FloatAccess.EVERYBODY
        automatic, fpscr = self.float_context
        if automatic and not self.get(Reg.CONTROL) & 4:
            self.set(Reg.CONTROL, self.get(Reg.CONTROL) | 4)
            self.put_float(32, fpscr)
        for place, word in enumerate(words):
            self.put_float(place, word)

    @property
    def float_access(self) -> FloatAccess:
        return FloatAccess(self._state.float_access)

    @property
    def float_context(self) -> tuple[bool, int]:
        """Whether the first instruction begins one, and the FPSCR that it gets."""
        kept = self.exceptions
        return bool(kept.fpccr >> 31), kept.last_fpscr & ~0x07C0_0000 | kept.fpdscr

    @property
    def traps(self) -> tuple[bool, bool]:
        return bool(self._state.trap_division), bool(self._state.trap_unaligned)

    @property
    def is_marked(self) -> bool:
        """Whether an LDREX is open."""
        return bool(self._state.exclusive)

    def mark(self) -> None:
        self._state.exclusive = True


class Rig:
    """A core after reset, with a vector table, a stack and handlers that only have addresses.

    Attributes:
        taken: the exceptions that began, in order, with the cycle at which they did.
    """

    VECTORS = VECTORS
    RAM = RAM
    STACK_TOP = STACK_TOP
    MAIN = MAIN

    def __init__(self, kind=CORTEX_M3, *, power_on: bool = True) -> None:
        self.chip = FakeChip(hclk_hz=72_000_000)
        self.memory = self.chip.bus
        self.cpu = Cpu(kind, self.memory)
        self.core = Core(self.cpu, self.chip.services, kind)
        self.memory.load(RAM, bytes(RAM_SIZE))
        self.memory.load(VECTORS, bytes(0x500))
        self.memory.write(VECTORS, 4, STACK_TOP)
        self.memory.write(VECTORS + 4, 4, MAIN | 1)
        for number in range(2, self.core.exceptions.count):
            self.memory.write(VECTORS + 4 * number, 4, self.handler(number) | 1)
        self.taken: list[tuple[int, int]] = []
        self.core.reset(VECTORS, power_on=power_on)

    @staticmethod
    def handler(number: int) -> int:
        return HANDLERS + 0x10 * number

    # --- registers on the bus

    def block_at(self, address: int) -> Peripheral:
        for block in self.core.peripherals:
            if block.base <= address < block.base + block.size:
                return block
        raise AssertionError(hex(address))

    def read(self, address: int, size: int = 4) -> int:
        block = self.block_at(address)
        if size == 4:
            return block.read(address - block.base)
        return block.read_part(address - block.base, size)

    def write(self, address: int, value: int, size: int = 4) -> None:
        block = self.block_at(address)
        if size == 4:
            block.write(address - block.base, value)
        else:
            block.write_part(address - block.base, size, value)

    def address(self, block: str, register: str) -> int:
        for candidate in self.core.blocks:
            for offset, declared in candidate.registers.items():
                if candidate.name == block and declared.name == register:
                    return candidate.base + offset
        raise AssertionError(f"{block}.{register}")

    def peek(self, block: str, register: str) -> int:
        return self.read(self.address(block, register))

    def poke(self, block: str, register: str, value: int) -> None:
        self.write(self.address(block, register), value)

    # --- the machine's loop

    def settle(self) -> None:
        """Let everything be taken that can be, with the events on the way."""
        while True:
            self.chip.time.run_due(self.cpu.cycle)
            before = self.core.running, self.core.exceptions.active
            if not self.core.take():
                return
            if self.core.exceptions.active & ~before[1]:
                self.taken.append((self.core.running, self.cpu.cycle))

    def advance(self, cycles: int) -> None:
        """Let cycles pass without an instruction, then take what can be taken."""
        self.cpu.add_cycles(cycles)
        self.settle()

    def interrupt(self, irq: int, *, priority: int | None = None) -> None:
        """Enable an interrupt and pulse its line."""
        number = Number.FIRST_IRQ + irq
        if priority is not None:
            self.core.exceptions.set_priority(number, priority)
        self.core.exceptions.enable(number)
        self.core.irq(irq).set(True)
        self.core.irq(irq).set(False)

    def stop(self, kind: StopKind, value: int = 0) -> None:
        self.core.handle(Stop(kind, value))
        self.settle()

    def svc(self) -> None:
        self.cpu.set(Reg.PC, self.cpu.get(Reg.PC) + 2)
        self.stop(StopKind.SVC)

    def fault(self, fault: FaultKind, address: int = 0) -> None:
        self.core.handle(Stop(StopKind.FAULT, fault=fault, address=address))
        self.settle()

    def exit(self, exc_return: int | None = None) -> None:
        """Return from the exception that runs, by its LR if nothing else is said."""
        value = self.cpu.get(Reg.LR) if exc_return is None else exc_return
        self.stop(StopKind.EXCEPTION_RETURN, value)

    @property
    def began(self) -> list[int]:
        return [number for number, _ in self.taken]


@pytest.fixture
def rig() -> Rig:
    return Rig()


@pytest.fixture
def make_rig() -> type[Rig]:
    return Rig


@pytest.fixture
def m7() -> Rig:
    """Like `rig`, but a Cortex-M7."""
    return Rig(CORTEX_M7)


@pytest.fixture(scope="module")
def shared_rig() -> Rig:
    """For properties, which reset it for every example."""
    return Rig()
