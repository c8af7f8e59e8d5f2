"""Values as functions of other values: what a stretch of code computes, for one run through it or for many at once.

A node is a 32-bit value or a truth value. It is a constant, an input, or an operation on other nodes; equal ones are
made once, and so is what follows from constants alone. Every operation here takes ints and bools as well as vectors
(uint64 and bool) of as many runs, and gives what the same operation gives on ints.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

__all__ = ["WORD", "Graph", "Node", "Value"]

WORD = 0xFFFF_FFFF
_SIGN = 1 << 31

Node = int
Value = Any
"""An int or bool, or a vector of them."""
_Operation = Callable[..., Value]


class Graph:
    """Nodes, each with the value that it had in one run.

    Attributes:
        value: of each node in that run.
    """

    def __init__(self) -> None:
        self.value: list[int] = []
        self._operations: list[tuple[_Operation | None, tuple[Node, ...]]] = []
        self._made: dict[object, Node] = {}
        self._constants: set[Node] = set()

    # --- leaves

    def constant(self, value: int) -> Node:
        """Return the node of a value that is always the same."""
        node = self._made.get((type(value), value))
        if node is None:
            node = self._made[type(value), value] = self._append(None, (), value)
            self._constants.add(node)
        return node

    def input(self, value: int) -> Node:
        """Return a new node whose value comes from outside."""
        return self._append(None, (), value)

    def is_constant(self, node: Node) -> bool:
        """Say whether the value is the same in all runs by what the code is."""
        return node in self._constants

    # --- operations

    def apply(self, operation: _Operation, *arguments: Node) -> Node:
        """Return the node of an operation on nodes."""
        key = (operation, arguments)
        node = self._made.get(key)
        if node is None:
            value = operation(*(self.value[argument] for argument in arguments))
            if all(argument in self._constants for argument in arguments):
                return self.constant(value)
            node = self._made[key] = self._append(operation, arguments, value)
        return node

    def add(self, a: Node, b: Node) -> Node:
        """Return a + b; constants are gathered, so that what is taken away and put back leaves nothing."""
        if self.is_constant(a):
            a, b = b, a
        if not self.is_constant(b):
            return self.apply(_add, a, b)
        operation, arguments = self._operations[a]
        if operation is _add and self.is_constant(arguments[1]):
            a, b = arguments[0], self.constant(_add(self.value[arguments[1]], self.value[b]))
        return self.apply(_add, a, b) if self.value[b] else a

    def sub(self, a: Node, b: Node) -> Node:
        """Return a - b."""
        if self.is_constant(b):
            return self.add(a, self.constant(-self.value[b] & WORD))
        return self.apply(_sub, a, b)

    def both(self, a: Node, b: Node) -> Node:
        """Return a & b, of words or truth values."""
        return self.apply(operator.and_, a, b)

    def either(self, a: Node, b: Node) -> Node:
        """Return a | b, of words or truth values."""
        return self.apply(operator.or_, a, b)

    def differing(self, a: Node, b: Node) -> Node:
        """Return a ^ b, of words or truth values."""
        return self.apply(operator.xor, a, b)

    def complement(self, a: Node) -> Node:
        """Return ~a of a word."""
        return self.apply(operator.xor, a, self.constant(WORD))

    def negated(self, a: Node) -> Node:
        """Return the opposite of a truth value."""
        return self.apply(operator.xor, a, self.constant(True))

    def word(self, a: Node) -> Node:
        """Return 0 or 1 for a truth value."""
        return self.apply(_word, a)

    def mul(self, a: Node, b: Node) -> Node:
        """Return the lower word of a * b."""
        return self.apply(_mul, a, b)

    def mul_high(self, a: Node, b: Node) -> Node:
        """Return the upper word of a * b, unsigned."""
        return self.apply(_mul_high, a, b)

    def divide(self, a: Node, b: int) -> Node:
        """Return a / b, unsigned, rounded down; b not zero."""
        return self.apply(operator.floordiv, a, self.constant(b))

    def lsl(self, a: Node, bits: int) -> Node:
        """Return a shifted to the left by 0 to 32 bits."""
        return self.apply(_lsl, a, self.constant(bits)) if bits else a

    def lsr(self, a: Node, bits: int) -> Node:
        """Return a shifted to the right by 0 to 32 bits."""
        return self.apply(operator.rshift, a, self.constant(bits)) if bits else a

    def asr(self, a: Node, bits: int) -> Node:
        """Return a shifted to the right by 0 to 32 bits with its sign."""
        return self.apply(_asr, a, self.constant(bits)) if bits else a

    def ror(self, a: Node, bits: int) -> Node:
        """Return a rotated to the right by 0 to 31 bits."""
        return self.apply(_ror, a, self.constant(bits)) if bits else a

    def bit(self, a: Node, number: int) -> Node:
        """Return a bit of a word as a truth value."""
        return self.apply(_bit, a, self.constant(number))

    def equal(self, a: Node, b: Node) -> Node:
        """Return whether two words are equal."""
        return self.apply(operator.eq, a, b)

    def not_below(self, a: Node, b: Node) -> Node:
        """Return whether a >= b, unsigned: the carry of a - b."""
        return self.apply(operator.ge, a, b)

    def negative(self, a: Node) -> Node:
        """Return bit 31."""
        return self.apply(operator.ge, a, self.constant(_SIGN))

    def carry(self, a: Node, b: Node, carry_in: Node) -> Node:
        """Return the carry of a + b + a truth value."""
        return self.apply(_carry, a, b, carry_in)

    def overflow(self, a: Node, b: Node, result: Node) -> Node:
        """Return whether a + b = result has left the range of signed numbers."""
        return self.apply(_overflow, a, b, result)

    def overflow_of_sub(self, a: Node, b: Node, result: Node) -> Node:
        """Return whether a - b = result has left the range of signed numbers."""
        return self.apply(_overflow_of_sub, a, b, result)

    # --- questions

    def arguments(self, node: Node) -> tuple[Node, ...]:
        """Return what the node is computed from."""
        return self._operations[node][1]

    def needed_for(self, wanted: Iterable[Node]) -> set[Node]:
        """Return all that the wanted nodes are computed from, and themselves."""
        needed: set[Node] = set()
        todo = list(wanted)
        while todo:
            node = todo.pop()
            if node not in needed:
                needed.add(node)
                todo.extend(self._operations[node][1])
        return needed

    def increment(self, node: Node, start: Node) -> Node | None:
        """Return node - start, if the node is `start` plus or minus what does not depend on `start`; otherwise None."""
        if node == start:
            return self.constant(0)
        operation, arguments = self._operations[node]
        if operation not in (_add, _sub):
            return None
        a, b = arguments
        if start not in self.needed_for([b]):
            left = self.increment(a, start)
            if left is None:
                return None
            return self.add(left, b) if operation is _add else self.sub(left, b)
        if operation is _add and start not in self.needed_for([a]):
            right = self.increment(b, start)
            return None if right is None else self.add(a, right)
        return None

    def evaluate(self, nodes: Sequence[Node], values: dict[Node, Value]) -> None:
        """Add the values of operations, given in an order in which each comes after what it needs."""
        for node in nodes:
            operation, arguments = self._operations[node]
            if operation is not None:
                values[node] = operation(*[values[argument] for argument in arguments])
            elif node in self._constants:
                values[node] = self.value[node]

    def unknown_bits(self, node: Node, values: Mapping[Node, Value], unknown: Mapping[Node, int]) -> int:
        """Return the bits of an operation's result that are not known, from those of its arguments.

        Args:
            node: the operation.
            values: of its arguments; where one is the same in all runs, it tells more.
            unknown: bits of its arguments, where there are any.
        """
        operation, arguments = self._operations[node]
        bits = [unknown.get(argument, 0) for argument in arguments]
        if operation is None or not any(bits):
            return 0
        (a, *others), first, second = bits, values[arguments[0]], values[arguments[-1]]
        b = any(others)
        if b and not a and operation in (operator.and_, operator.or_, operator.xor):
            a, b, second = bits[1], False, first
        if b or len(arguments) == 1 or not isinstance(second, int):
            return WORD
        if operation in (operator.and_, operator.rshift, _lsl, _asr, _ror):
            result: int = operation(a, second)
            return result
        if operation is operator.or_:
            return a & ~second
        if operation is operator.xor:
            return a
        if operation is _bit:
            return a >> second & 1
        return a >> 31 if operation is operator.ge and second == _SIGN else WORD

    def _append(self, operation: _Operation | None, arguments: tuple[Node, ...], value: int) -> Node:
        self._operations.append((operation, arguments))
        self.value.append(value)
        return len(self.value) - 1


# Vectors are unsigned and longer than a word, so sums, differences and products come out right in the lower word.


def _word(a: Value) -> Value:
    return int(a) if isinstance(a, int) else a.astype("u8")


def _add(a: Value, b: Value) -> Value:
    return a + b & WORD


def _sub(a: Value, b: Value) -> Value:
    return a - b & WORD


def _mul(a: Value, b: Value) -> Value:
    return a * b & WORD


def _mul_high(a: Value, b: Value) -> Value:
    return a * b >> 32


def _lsl(a: Value, bits: int) -> Value:
    return a << bits & WORD


def _asr(a: Value, bits: int) -> Value:
    return (a >> bits | (a >> 31) * ((WORD << 32 - bits) & WORD)) & WORD


def _ror(a: Value, bits: int) -> Value:
    return (a >> bits | a << 32 - bits) & WORD


def _bit(a: Value, number: int) -> Value:
    return a >> number & 1 == 1


def _carry(a: Value, b: Value, carry_in: Value) -> Value:
    return a + b + carry_in > WORD


def _overflow(a: Value, b: Value, result: Value) -> Value:
    return ((a ^ result) & (b ^ result)) >= _SIGN


def _overflow_of_sub(a: Value, b: Value, result: Value) -> Value:
    return ((a ^ b) & (a ^ result)) >= _SIGN
