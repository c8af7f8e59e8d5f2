"""The same accesses to registers on our machine and on the simulator of the `labwired` package (MIT, version 0.25.0).

Both run one program, `sequencer.s`: it carries out a list of accesses and keeps what it reads, so that both sides see
loads and stores of a CPU. `labwired` knows no time at which an oscillator is ready or a flag is set, so sequences wait
for flags, and only values are compared.
"""

from __future__ import annotations

import fnmatch
import struct
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import pytest

from targets.boards import built_in_board
from targets.mcu.image import limits_for, load_image
from targets.mcu.machine import Machine
from targets.mcu.serial_line import SerialFormat, SerialFrame

HERE = Path(__file__).parent
FLASH, RAM = 0x0800_0000, 0x2000_0000
CODE, FAULT, INTERRUPT, OPERATIONS = 0x200, 0x258, 0x264, 0x1000
DONE, RESULTS, INTERRUPTS = RAM + 0x400, RAM + 0x404, RAM + 0x3000
DOES = ("end", "read4", "write4", "read2", "write2", "read1", "write1", "delay", "wait")
STEP_NS, LIMIT_NS, LINE_NS = 500_000, 60_000_000, 200_000

NOT_COMPARED = {"RCC_CR": 0x0000_FF00}
"""HSICAL differs from chip to chip (RM0008 section 7.3.1)."""


@dataclass(frozen=True)
class Operation:
    """One access. `register` is for people and for `NOT_COMPARED`; with a `label` its result is compared."""

    does: str
    address: int = 0
    value: int = 0
    register: str = ""
    label: tuple[str, str] | None = None


@dataclass(frozen=True)
class Program:
    """Accesses, and what comes in at USART1 while they go on."""

    operations: tuple[Operation, ...]
    line: bytes = b""

    def elf(self):
        """Return it as the smallest ELF file that both sides take."""
        vectors = [RAM + 0x5000, FLASH + CODE | 1] + [FLASH + FAULT | 1] * 5 + [FLASH + INTERRUPT | 1] * 69
        code = bytes.fromhex((HERE / "sequencer.hex").read_text())
        image = (struct.pack("<76I", *vectors).ljust(CODE, b"\0") + code).ljust(OPERATIONS, b"\0")
        for operation in (*self.operations, Operation("end")):
            image += struct.pack("<3I", DOES.index(operation.does), operation.address, operation.value)
        header = (b"\x7fELF\1\1\1", 2, 40, 1, FLASH + CODE | 1, 52, 0, 0x0500_0200, 52, 32, 1, 40, 0, 0)
        segment = (1, 0x1000, FLASH, FLASH, len(image), len(image), 5, 0x1000)
        elf = struct.pack("<16s2H5I6H", *header) + struct.pack("<8I", *segment)
        return elf.ljust(0x1000, b"\0") + image


class Bench:
    """Runs programs on both sides."""

    def __init__(self, labwired, folder):
        self._labwired = labwired
        self._board = built_in_board("bluepill")
        self._elf = folder / "program.elf"
        parts = self._machine(Program(())).core.blocks, self._machine(Program(())).chip.peripherals.values()
        self.parts = {part.name: part for group in parts for part in group}
        self.registers = {
            f"{part.name}_{register.name}": (part.base + offset, register)
            for part in self.parts.values()
            for offset, register in part.registers.items()
        }

    def run(self, program):
        """Return what ours and theirs give: pairs for each operation, and the interrupts taken, by operation."""
        (ours, ours_taken), (theirs, theirs_taken) = self._ours(program), self._theirs(program)
        masks = [~NOT_COMPARED.get(operation.register, 0) for operation in program.operations]
        pairs = [(a & mask, b & mask) for mask, a, b in zip(masks, ours, theirs, strict=True)]
        return pairs, (ours_taken, theirs_taken)

    def _machine(self, program):
        self._elf.write_bytes(program.elf())
        return Machine(self._board, load_image(self._elf, limits_for(self._board.chip)))

    def _ours(self, program):
        machine = self._machine(program)
        machine.run_to(LINE_NS)
        start, bit = Fraction(LINE_NS, 10**9), Fraction(1, 115_200)
        for byte in program.line:
            frame = SerialFrame(start_s=start, bit_s=bit, bits=byte, bit_count=SerialFormat().word_bits)
            machine.chip.usarts["USART1"].receive(frame)
            start = frame.end_s
        while not machine.bus.read(DONE, 4):
            assert machine.now_ns < LIMIT_NS, "our machine does not come to the end"
            machine.run_to(machine.now_ns + STEP_NS)
        return _read(program, lambda address, size: bytes(machine.ram[address - RAM : address - RAM + size]))

    def _theirs(self, program):
        self._elf.write_bytes(program.elf())
        with self._labwired.Sim(self._elf, chip="stm32f103", uart="uart1") as sim:
            sim.run_for(LINE_NS / 1e9)
            sim.send_bytes(program.line)
            while not sim.read_u32(DONE):
                assert sim.time * 1e9 < LIMIT_NS, "labwired does not come to the end"
                sim.run_for(STEP_NS / 1e9)
            return _read(program, sim.read_memory)


def _read(program, memory):
    """Return the results, and the interrupts as (number of the operation, number of the exception)."""
    count = len(program.operations)
    results = struct.unpack(f"<{count}I", memory(RESULTS, 4 * count))
    noted = struct.unpack("<64I", memory(INTERRUPTS, 256))
    return results, [divmod(word, 1 << 16) for word in noted if word]


@dataclass(frozen=True)
class Disagreement:
    """One line of the table."""

    where: str
    what: str
    ours: str
    theirs: str
    right: str
    why: str

    def covers(self, where, what):
        return fnmatch.fnmatchcase(where, self.where) and fnmatch.fnmatchcase(what, self.what)

    def agrees(self, ours, theirs):
        return fnmatch.fnmatchcase(f"{ours:X}", self.ours) and fnmatch.fnmatchcase(f"{theirs:X}", self.theirs)


class Table:
    """disagreements.txt: what is known to differ, and who is right."""

    def __init__(self):
        lines = (HERE / "disagreements.txt").read_text(encoding="utf-8").splitlines()
        rows = [[cell.strip() for cell in line.split("|")] for line in lines if line and not line.startswith("#")]
        self.rows = [Disagreement(*row) for row in rows]

    def complaints(self, where, what, ours, theirs):
        """Return what is wrong with the table, given one comparison: nothing, or one line."""
        rows = [row for row in self.rows if row.covers(where, what)]
        seen = f"{where} | {what} | {ours:X} | {theirs:X}"
        if len(rows) > 1:
            return [f"{len(rows)} lines for {seen}"]
        if ours == theirs:
            return [f"no disagreement any more: {seen}"] if rows else []
        if not rows:
            return [f"not listed: {seen}"]
        return [] if rows[0].agrees(ours, theirs) else [f"another disagreement than listed: {seen}"]


@pytest.fixture(scope="session")
def bench(tmp_path_factory):
    labwired = pytest.importorskip("labwired", reason="labwired has no wheel for this machine")
    return Bench(labwired, tmp_path_factory.mktemp("second-opinion"))


@pytest.fixture(scope="session")
def sequencer():
    """The program that both sides run, and where its handlers are in it."""
    code = bytes.fromhex((HERE / "sequencer.hex").read_text())
    return {"code": code, "fault": FAULT - CODE, "interrupt": INTERRUPT - CODE}


@pytest.fixture(scope="session")
def table():
    return Table()


@pytest.fixture(scope="session")
def make_program():
    """Makes a program of operations: (does, register name or address, value, label)."""
    return lambda bench, steps, line=b"": Program(tuple(_operation(bench, *step) for step in steps), line)


@pytest.fixture(scope="session")
def compare(bench, table):
    """Runs a program on both sides; returns what is wrong with the table."""

    def run(program):
        pairs, taken = bench.run(program)
        complaints = []
        for operation, (ours, theirs) in zip(program.operations, pairs, strict=True):
            if operation.label is not None:
                complaints += table.complaints(*operation.label, ours, theirs)
        return complaints, taken

    return run


def _operation(bench, does, where=0, value=0, label=None):
    if isinstance(where, int):
        return Operation(does, where, value, label=label)
    return Operation(does, bench.registers[where][0], value, where, label)
