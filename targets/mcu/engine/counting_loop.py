"""A loop that waits for a counter: what each turn of it does, and so how many turns it takes, without executing them.

`CountingLoop` is made from one turn that was executed. Registers, flags and memory that a turn changes are either not
read by the next one, or are what the last turn left (`old = now`), or grow by what does not depend on themselves
(`elapsed += now - old`, `n -= 1`). So the values of many turns can be computed at once, one vector for each node of the
graph. The first turn in which one of the conditions does not hold goes another way: up to there all is known.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from targets.mcu.engine.dataflow import WORD, Graph, Node, Value
from targets.mcu.engine.follower import SP, Follower, NotUnderstood, Place, RegisterRead

__all__ = ["CountingLoop", "State", "Turns"]

State = dict[Place, int]
"""What is in the places that a turn reads, at its head. What it only writes is not kept: the next turn writes it."""


@dataclass(frozen=True, slots=True)
class _Carried:
    """A place that a turn reads and changes.

    Attributes:
        start: its node at the head of the loop.
        source: what it is after the turn, or what it has grown by.
        grows: whether it is the latter.
    """

    start: Node
    source: Node
    grows: bool


class CountingLoop:
    """What a turn of a loop computes.

    Args:
        turn: has followed one turn; it knows where SP was.

    Attributes:
        instructions: in a turn, as the engine counts them; the caller sets this and the next two.
        cycles: in a turn, by a timing model that knows each instruction's.
        offsets: instructions and cycles from the head to each instruction (an IT block is one).
        usual_turns: how many were passed over last.
        reads: of peripherals.
        starts: what a turn reads.

    Raises:
        NotUnderstood: a turn depends on the turns before in another way.
    """

    def __init__(self, turn: Follower) -> None:
        self.instructions = 0
        self.cycles = 0
        self.usual_turns = 0
        self.offsets: Sequence[tuple[int, int]] = ()
        self.reads: Sequence[RegisterRead] = turn.reads
        self.starts: Mapping[Place, Node] = turn.starts
        self._graph = graph = turn.graph
        self._code = turn.code
        self._ends = {place: node for place, node in turn.ends.items() if node != turn.starts.get(place)}
        conditions = list(turn.conditions)
        if SP in self._ends:  # put back from another register, as code with a frame pointer does
            conditions.append(self._fixed_stack(graph, self._ends.pop(SP)))
        self._conditions = [(node, graph.value[node]) for node in conditions]
        carried = {self.starts[place]: self._carry(place) for place in self._ends if place in self.starts}
        self._steps = list(_in_order(graph, [*conditions, *carried], carried))
        self._last = sorted(graph.needed_for(self._ends[place] for place in self._ends if place in self.starts))

    def _fixed_stack(self, graph: Graph, end: Node) -> Node:
        if graph.value[end] != graph.value[self.starts[SP]]:
            raise NotUnderstood("the stack moves")
        return end

    def _carry(self, place: Place) -> _Carried:
        start, end = self.starts[place], self._ends[place]
        increment = self._graph.increment(end, start) if start in self._graph.needed_for([end]) else None
        return _Carried(start, end, False) if increment is None else _Carried(start, increment, True)

    def is_still(self, half: Callable[[int], int]) -> bool:
        """Say whether the code is what it was."""
        return all(half(address) == value for address, value in self._code.items())

    def after(self, state: State, inputs: dict[Node, int]) -> State:
        """Return the state after one turn from inputs: everything that a turn gets from outside."""
        values: dict[Node, Value] = dict(inputs)
        self._graph.evaluate(self._last, values)
        return state | {place: values[node] for place, node in self._ends.items() if place in self.starts}

    def depends_on(self, unknown: dict[Node, int], values: Mapping[Node, Value]) -> bool:
        """Say whether the way, or what is carried, depends on bits that are not known.

        Args:
            unknown: such bits, by node; others are added.
            values: of all nodes.
        """
        for nodes, carried in self._steps:
            for node in nodes:
                if bits := self._graph.unknown_bits(node, values, unknown):
                    unknown[node] = bits
            if carried is not None and unknown.get(carried.source):
                return True
        return any(node in unknown for node, _expected in self._conditions)

    def carry(self, values: dict[Node, Value], count: int) -> int:
        """Compute `count` turns from what they get from outside; return the first that goes another way, or `count`."""
        for nodes, carried in self._steps:
            self._graph.evaluate(nodes, values)
            if carried is not None:
                values[carried.start] = _carried_values(carried, values, count)
        return min((_first_other(values[node], expected, count) for node, expected in self._conditions), default=count)


def _in_order(
    graph: Graph, wanted: Sequence[Node], carried: Mapping[Node, _Carried]
) -> Iterator[tuple[list[Node], _Carried | None]]:
    """Yield nodes to evaluate, and what is carried and can be computed after them.

    Raises:
        NotUnderstood: something depends on itself in the turn before.
    """
    done: set[Node] = set()
    open_: set[Node] = set()
    nodes: list[Node] = []

    def visit(node: Node) -> Iterator[tuple[list[Node], _Carried | None]]:
        nonlocal nodes
        if node in done:
            return
        if node in open_:
            raise NotUnderstood("a turn depends on the turns before")
        open_.add(node)
        way = carried.get(node)
        for argument in graph.arguments(node) if way is None else (way.source,):
            yield from visit(argument)
        if way is None:
            nodes.append(node)
        else:
            yield nodes, way
            nodes = []
        done.add(node)

    for node in wanted:
        yield from visit(node)
    yield nodes, None


def _carried_values(carried: _Carried, values: dict[Node, Value], count: int) -> Value:
    """Return a carried value at the head of each turn; the first is there already."""
    import numpy as np

    first, source = values[carried.start], values[carried.source]
    if not isinstance(source, np.ndarray):
        if not carried.grows and source == first:
            return first
        source = np.full(count, source, dtype=bool if isinstance(source, bool) else np.uint64)
    result = np.empty_like(source)
    result[0] = first
    if carried.grows:
        result[1:] = first + np.cumsum(source[:-1], dtype=np.uint64) & WORD
    else:
        result[1:] = source[:-1]
    return result


def _first_other(value: Value, expected: int, count: int) -> int:
    import numpy as np

    if not isinstance(value, np.ndarray):
        return count if value == expected else 0
    other = value != expected
    place = int(other.argmax())
    return place if other[place] else count


class Turns:
    """Some turns of a loop, one after the other.

    Args:
        loop: the loop.
        state: at its head, before the first of them.
        count: how many, at least one.
        given: what peripherals give, by node: the same in every turn, or a vector,
        unknown: and the bits of that that are not known.

    Attributes:
        unknown: it depends on bits that are not known.
        same_way: how many of them, from the first on, go the way that is known.
    """

    def __init__(
        self, loop: CountingLoop, state: State, count: int, given: Mapping[Node, Any], unknown: Mapping[Node, int]
    ) -> None:
        self._loop = loop
        self._state = state
        self._values: dict[Node, Value] = {node: state[place] for place, node in loop.starts.items()}
        self._values.update(given)
        self._inputs = tuple(self._values)
        self.same_way = loop.carry(self._values, count)
        self.unknown = bool(unknown) and loop.depends_on(dict(unknown), self._values)

    def state_after(self, turns: int) -> State:
        """Return the state at the head after so many of the turns that go the known way."""
        if turns == 0:
            return self._state
        return self._loop.after(self._state, {node: _at(self._values[node], turns - 1) for node in self._inputs})


def _at(value: Value, index: int) -> int:
    import numpy as np

    scalar: int = value[index].item() if isinstance(value, np.ndarray) else value
    return scalar
