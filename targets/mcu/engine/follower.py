"""Follows a stretch of Thumb-2 code along the way that it took, and writes down what it computes as a graph of values.

It understands what compilers make waiting loops of: arithmetic, logic, shifts, fields, multiplications and divisions,
loads and stores, the stack, IT blocks, branches, calls and returns (encodings: DDI0403 chapter A7). Anything else is
`NotUnderstood`. Whatever decides where the code goes or what it accesses becomes a condition: in another run the graph
holds if each of these nodes has the same value.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol

from targets.mcu.engine.dataflow import WORD, Graph, Node

__all__ = ["FLAGS", "SP", "Follower", "NotUnderstood", "Place", "RegisterRead", "Surroundings", "is_wide"]

SP, LR, PC = 13, 14, 15
N, Z, C, V = FLAGS = (31, 30, 29, 28)
"""Places of the flags: their bits in xPSR."""

Place = int | tuple[int, int]
"""Where a value is kept: a core register R0 to LR, a flag, or memory at (address, bytes)."""

_RAM_BASE, _RAM_END = 0x2000_0000, 0x2200_0000
_FLASH_BASE, _REGISTERS_BASE = 0x0800_0000, 0x4000_0000
_ALWAYS = 14
_HIGHEST_CODE = 0x4000_0000


def is_wide(first: int) -> bool:
    """Say whether a half-word begins an instruction of 32 bits (DDI0403 section A5.1)."""
    return first >> 11 in (0b11101, 0b11110, 0b11111)


class NotUnderstood(Exception):  # noqa: N818 - no failure
    """The code does something that a graph of values cannot tell."""


class Surroundings(Protocol):
    """What the code works on."""

    def core_register(self, number: int) -> int:
        """Return R0 to LR or xPSR (16) as it was at the beginning."""

    def half(self, address: int) -> int:
        """Return a half-word of code."""

    def memory(self, address: int, size: int) -> int | None:
        """Return what memory held at the beginning, or None where there is none."""

    def register(self, address: int, size: int) -> int | None:
        """Return what the next read of a peripheral gave, or None if it was not one of this address."""


@dataclass(frozen=True, slots=True)
class RegisterRead:
    """A read of a peripheral.

    Attributes:
        node: what it gave.
        address: of it.
        size: in bytes.
        instruction: which of the instructions did it; an IT block is one.
        conditional: it stands in an IT block.
    """

    node: Node
    address: int
    size: int
    instruction: int
    conditional: bool


@dataclass(slots=True)
class Follower:
    """Follows code from `pc` on.

    Attributes:
        surroundings: what it works on.
        pc: of the next instruction.
        graph: what is computed.
        starts: the places that are read before they are written, with their inputs.
        ends: the places that are written, with what is in them now.
        conditions: nodes that must have the same value in another run.
        reads: of peripherals, in order.
        instructions: followed so far; an IT block is one.
        code: half-words that were looked at, by address.
        next_pc: where it goes on after this instruction.
        in_block: within an IT block, where most 16-bit instructions leave the flags alone.
    """

    surroundings: Surroundings
    pc: int
    graph: Graph = field(default_factory=Graph)
    starts: dict[Place, Node] = field(default_factory=dict)
    ends: dict[Place, Node] = field(default_factory=dict)
    conditions: dict[Node, None] = field(default_factory=dict)
    reads: list[RegisterRead] = field(default_factory=list)
    instructions: int = 0
    code: dict[int, int] = field(default_factory=dict)
    next_pc: int = 0
    in_block: bool = False
    _bytes: dict[int, Place] = field(default_factory=dict)

    def half(self, address: int) -> int:
        """Return a half-word of code, and remember that it was looked at."""
        half = self.code[address] = self.surroundings.half(address)
        return half

    # --- places

    def get(self, number: int) -> Node:
        """Return a core register as an operand; PC reads as the instruction's address + 4."""
        if number == PC:
            return self.graph.constant(self.pc + 4)
        return self.at(number)

    def set(self, number: int, node: Node) -> None:
        """Write a core register; PC is a jump."""
        if number == PC:
            self.jump_to(node)
        else:
            self.ends[number] = node

    def at(self, place: Place) -> Node:
        """Return what is in a place now."""
        node = self.ends.get(place)
        if node is None:
            node = self.starts.get(place)
        if node is None:
            node = self.starts[place] = self.graph.input(self._initial(place))
        return node

    def _initial(self, place: Place) -> int:
        if isinstance(place, tuple):
            value = self.surroundings.memory(*place)
            if value is None:
                raise NotUnderstood(f"no memory at 0x{place[0]:08X}")
            return value
        if place in FLAGS:
            return bool(self.surroundings.core_register(16) >> place & 1)
        return self.surroundings.core_register(place)

    def constant(self, value: int) -> Node:
        """Return the node of a constant."""
        return self.graph.constant(value & WORD)

    # --- memory

    def load(self, address: Node, size: int, *, signed: bool = False) -> Node:
        """Return what is loaded from an address."""
        self.fix(address)
        place = self.graph.value[address]
        node = self._read_register(place, size) if place >= _REGISTERS_BASE else self._load(place, size)
        if signed:
            node = self.graph.asr(self.graph.lsl(node, 32 - 8 * size), 32 - 8 * size)
        return node

    def _load(self, address: int, size: int) -> Node:
        if not _FLASH_BASE <= address < _RAM_END:
            raise NotUnderstood(f"a load from 0x{address:08X}")
        self._claim(address, size)
        return self.at((address, size))

    def _read_register(self, address: int, size: int) -> Node:
        value = self.surroundings.register(address, size)
        if value is None:
            raise NotUnderstood(f"a load from 0x{address:08X}")
        node = self.graph.input(value)
        self.reads.append(RegisterRead(node, address, size, self.instructions, self.in_block))
        return node

    def store(self, address: Node, size: int, node: Node) -> None:
        """Store a word, half-word or byte."""
        self.fix(address)
        place = self.graph.value[address]
        if not _RAM_BASE <= place < _RAM_END or self.surroundings.memory(place, size) is None:
            raise NotUnderstood(f"a store to 0x{place:08X}")
        self._claim(place, size)
        if size < 4:
            node = self.graph.both(node, self.constant((1 << 8 * size) - 1))
        self.ends[place, size] = node

    def _claim(self, address: int, size: int) -> None:
        """Make sure that no byte belongs to two places."""
        for byte in range(address, address + size):
            if self._bytes.setdefault(byte, (address, size)) != (address, size):
                raise NotUnderstood(f"0x{byte:08X} is accessed in different sizes")

    # --- where the code goes

    def fix(self, node: Node) -> None:
        """Let it be a condition that the node has the value that it has here."""
        if not self.graph.is_constant(node):
            self.conditions[node] = None

    def branch(self, address: int) -> None:
        """Go on at an address."""
        self.next_pc = address & WORD

    def jump_to(self, node: Node) -> None:
        """Go on where a register or the stack says."""
        self.fix(node)
        target = self.graph.value[node]
        if not target & 1 or target >= _HIGHEST_CODE:
            raise NotUnderstood(f"a jump to 0x{target:08X}")
        self.next_pc = target & ~1

    def branch_if(self, condition: Node, address: int) -> None:
        """Go on at an address if a truth value is true."""
        self.fix(condition)
        if self.graph.value[condition]:
            self.branch(address)

    def branch_under(self, condition: int, address: int) -> None:
        """Go on at an address under a condition code."""
        if self.holds(condition):
            self.branch(address)

    def call(self, address: int) -> None:
        """Branch and keep the return address."""
        self.set(LR, self.constant(self.next_pc | 1))
        self.branch(address)

    def call_to(self, node: Node) -> None:
        """Call where a register says."""
        link = self.constant(self.next_pc | 1)
        self.jump_to(node)
        self.set(LR, link)

    def holds(self, code: int) -> bool:
        """Say whether a condition (its code, 0 to 15) holds; that it does becomes a condition of the graph."""
        if code >= _ALWAYS:
            return True
        node = self._condition(code >> 1)
        self.fix(node)
        return bool(self.graph.value[node]) is not bool(code & 1)

    def _condition(self, code: int) -> Node:
        """Return the condition of an even code, halved: EQ, CS, MI, VS, HI, GE, GT."""
        graph, at = self.graph, self.at
        if code < 4:
            return at((Z, C, N, V)[code])
        if code == 4:
            return graph.both(at(C), graph.negated(at(Z)))
        less = graph.differing(at(N), at(V))
        return graph.negated(less if code == 5 else graph.either(less, at(Z)))

    # --- flags

    def set_nz(self, result: Node) -> None:
        """Set N and Z by a result."""
        self.ends[N] = self.graph.negative(result)
        self.ends[Z] = self.graph.equal(result, self.constant(0))

    def set_flag(self, flag: int, node: Node | None) -> None:
        """Set a flag, if there is something to set it to."""
        if node is not None:
            self.ends[flag] = node

    def plus(self, a: Node, b: Node, *, flags: bool, carry_in: Node | None = None) -> Node:
        """Return a + b, perhaps + a carry, and set the flags by it if asked to."""
        graph = self.graph
        result = graph.add(a, b)
        if carry_in is not None:
            result = graph.add(result, graph.word(carry_in))
        if flags:
            self.set_nz(result)
            self.ends[C] = graph.carry(a, b, graph.constant(False) if carry_in is None else carry_in)
            self.ends[V] = graph.overflow(a, b, result)
        return result

    def minus(self, a: Node, b: Node, *, flags: bool) -> Node:
        """Return a - b, and set the flags by it if asked to."""
        graph = self.graph
        result = graph.sub(a, b)
        if flags:
            self.set_nz(result)
            self.ends[C] = graph.not_below(a, b)
            self.ends[V] = graph.overflow_of_sub(a, b, result)
        return result

    def minus_with_carry(self, a: Node, b: Node, *, flags: bool) -> Node:
        """Return a - b - (1 - C), and set the flags by it if asked to."""
        return self.plus(a, self.graph.complement(b), flags=flags, carry_in=self.at(C))

    # --- shifts

    def shifted(self, node: Node, kind: int, amount: int) -> tuple[Node, Node | None]:
        """Return a value shifted by 0 to 255 bits, and the carry of it; none for 0 bits.

        Args:
            node: the value.
            kind: 0 LSL, 1 LSR, 2 ASR, 3 ROR.
            amount: bits.
        """
        graph = self.graph
        if amount == 0:
            return node, None
        if kind == 3:
            result = graph.ror(node, amount % 32)
            return result, graph.negative(result)
        if kind == 2:
            amount = min(amount, 32)
            return graph.asr(node, amount), graph.bit(node, amount - 1)
        if amount > 32:
            return self.constant(0), graph.constant(False)
        if kind == 1:
            return graph.lsr(node, amount), graph.bit(node, amount - 1)
        return graph.lsl(node, amount), graph.bit(node, 32 - amount)

    def fixed_amount(self, number: int) -> int:
        """Return the shift that a register asks for, which must be the same in every run."""
        amount = self.graph.both(self.get(number), self.constant(0xFF))
        self.fix(amount)
        return self.graph.value[amount]

    def divided(self, a: Node, b: Node, *, signed: bool) -> Node:
        """Return a / b, rounded towards zero; the divisor must be the same in every run, and not zero."""
        graph = self.graph
        self.fix(b)
        divisor = graph.value[b]
        if divisor == 0:
            raise NotUnderstood("a division by zero")
        if not signed:
            return graph.divide(a, divisor)
        negative = divisor >> 31
        sign = graph.asr(a, 31)
        quotient = graph.divide(graph.sub(graph.differing(a, sign), sign), -divisor & WORD if negative else divisor)
        if negative:
            sign = graph.complement(sign)
        return graph.sub(graph.differing(quotient, sign), sign)
