"""A core on a CPU that executes nothing: registers, memory, a clock, and the machine's loop around them."""

from __future__ import annotations

import pytest

from targets.mcu.cortexm.core import Core
from targets.mcu.cortexm.exceptions import Number
from targets.mcu.cortexm.kinds import CORTEX_M3, CORTEX_M7
from targets.mcu.engine.api import FLOAT_WORDS, Access, FaultKind, FloatAccess, Reg, Stop, StopKind
from targets.mcu.registers import Peripheral
from targets.mcu.testing import FakeChip

VECTORS, HANDLERS = 0x0800_0000, 0x0800_1000
RAM, RAM_SIZE = 0x2000_0000, 0x400
STACK_TOP = RAM + RAM_SIZE
MAIN = 0x0800_0400
SCS = 0xE000_E000


class FakeCpu:
    """Registers with banked stack pointers, as an engine has them."""

    def __init__(self) -> None:
        self.registers = dict.fromkeys(Reg, 0)
        self.registers[Reg.XPSR] = 1 << 24
        self.cycle = 0
        self.instructions = 0
        self.traps = (False, False)
        self.floats = [0] * FLOAT_WORDS
        self.float_access = FloatAccess.EVERYBODY
        self.float_context = (True, 0)

    def get_floats(self) -> list[int]:
        return list(self.floats)

    def set_floats(self, words: list[int]) -> None:
        assert len(words) == FLOAT_WORDS
        self.floats = list(words)

    def set_float_access(self, access: FloatAccess) -> None:
        self.float_access = access

    def set_float_context(self, *, automatic: bool, fpscr: int) -> None:
        self.float_context = automatic, fpscr

    def use_floats(self, *words: int) -> None:
        """Execute a floating-point instruction that leaves these in S0 and so on."""
        assert self.float_access is FloatAccess.EVERYBODY
        automatic, fpscr = self.float_context
        if automatic and not self.registers[Reg.CONTROL] & 4:
            self.registers[Reg.CONTROL] |= 4
            self.floats[32] = fpscr
        self.floats[: len(words)] = words

    def set_traps(self, *, division: bool, unaligned: bool) -> None:
        self.traps = division, unaligned

    def bank(self, register: Reg) -> Reg:
        if register is not Reg.SP:
            return register
        in_thread = not self.registers[Reg.XPSR] & 0x1FF
        return Reg.PSP if in_thread and self.registers[Reg.CONTROL] & 2 else Reg.MSP

    def get(self, register: Reg) -> int:
        return self.registers[self.bank(register)]

    def set(self, register: Reg, value: int) -> None:
        assert 0 <= value <= 0xFFFF_FFFF
        if register is Reg.CONTROL and self.registers[Reg.XPSR] & 0x1FF:
            value = value & ~2 | self.registers[Reg.CONTROL] & 2  # SPSEL cannot be written in handler mode
        self.registers[self.bank(register)] = value

    def get_many(self, registers: list[Reg]) -> list[int]:
        return [self.registers[register] for register in registers]

    def set_many(self, registers: list[Reg], values: list[int]) -> None:
        for register, value in zip(registers, values, strict=True):
            self.set(register, value)

    def add_cycles(self, cycles: int) -> None:
        self.cycle += cycles

    def skip(self, instructions: int, cycles: int) -> None:
        self.instructions += instructions
        self.cycle += cycles

    def set_wait_states(self, wait_states: int) -> None:
        raise AssertionError

    def map_memory(self, base: int, data: bytearray, *, writable: bool) -> None:
        raise AssertionError

    def map_registers(self, base: int, size: int, access: Access) -> None:
        raise AssertionError

    def forget(self, base: int, size: int) -> None:
        raise AssertionError

    def run(self, limit_cycle: int) -> Stop:
        raise AssertionError

    def stop_by(self, limit_cycle: int) -> None:
        raise AssertionError


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
        self.cpu = FakeCpu()
        self.memory = self.chip.bus
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
        self.core.exceptions.enable(1 << number)
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
