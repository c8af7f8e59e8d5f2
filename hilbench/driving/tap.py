"""The operator's end of a line on a live bench: what comes is recorded, and faults are put in while the bench runs.

Nothing stands between the operator and the line until the first fault is asked for: a wrapper that decides on each byte
costs time.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from functools import partial

from hilbench.bench import Bench
from hilbench.bench.byte_log import ByteLog
from hilbench.links import Port
from hilbench.links.faults import ByteFaults, Direction, Fault, FaultKind, FaultPlan, FaultyPort
from hilbench.links.front import PortInFront
from hilbench.links.uart import Fate, Injector

__all__ = ["Tap"]

_LINE_KINDS = frozenset({FaultKind.BREAK, FaultKind.DISCONNECT, FaultKind.BAUD})


class _Wire:
    """What decides on the bytes of one direction: of the faults in force, the first that strikes a byte."""

    def __init__(self) -> None:
        self.faults: list[ByteFaults] = []

    def fate(self, value: int, at_ns: int) -> Fate | None:
        fates = [faults.fate(value, at_ns) for faults in self.faults]
        return next((fate for fate in fates if fate is not None), None)


class _GrowingPlan(FaultPlan):
    """A plan that takes more faults while the bench runs."""

    def __init__(self, *, seed: int) -> None:
        super().__init__((), seed=seed)
        self.wires = {direction: _Wire() for direction in Direction}

    def injector(self, direction: Direction) -> Injector:
        return self.wires[direction]


class Tap(PortInFront):
    """A port between a line and its operator.

    Args:
        bench: whose journal and time are used.
        port: the line; its callbacks belong to the tap from now on.
        source: who receives, for the journal.
        seed: decides what chance decides in faults.
        far: what is at the other end, for the journal.

    Attributes:
        struck: how often each fault struck, by its kind and whom it was on the way to.
        outages: how often the line went down.
    """

    def __init__(self, bench: Bench, port: Port, source: str, *, seed: int, far: str = "target") -> None:
        super().__init__(port)
        self._bench = bench
        self._source = source
        self._far = far
        self._line = port
        self._seed = seed
        self._plan: _GrowingPlan | None = None
        self._heard = ByteLog(bench, "rx", source)
        self._strikes = 0
        self._of_line: list[FaultPlan] = []
        self.struck: Counter[tuple[str, str]] = Counter()
        self._breaks: list[Fault] = []  # that were said to have struck
        self.outages = 0
        self.counters = port.counters

    # --- a port

    def write(self, data: bytes) -> None:
        """Hand bytes to the line, as far as faults let them through."""
        self.on_sent(data, self._bench.now_ns)
        self.port.write(data)

    def send(self, data: bytes) -> None:
        """Put bytes on the line and into the journal that somebody has made by hand, beside what the operator sends."""
        self._bench.record("tx", self._source, data=data)
        self.write(data)

    def flush(self) -> None:
        """Record what came and is not recorded yet."""
        self._heard.flush()

    def _received(self, data: bytes, at_ns: int) -> None:
        self._heard.add(data, at_ns)
        self.on_receive(data, at_ns)

    def _set_line(self, up: bool, at_ns: int) -> None:
        self.outages += self.line_is_up and not up
        super()._set_line(up, at_ns)

    # --- faults

    def inject(self, fault: Fault, on_struck: Callable[[], None] = lambda: None) -> None:
        """Let something go wrong from now on; times of faults of the line count from now.

        Args:
            fault: what.
            on_struck: called each time it strikes.
        """
        plan = self._plan or self._arm()
        now_ns = self._bench.now_ns
        single = FaultPlan((fault,), seed=self._seed + self._strikes, epoch_ns=now_ns)
        self._strikes += 1
        single.on_fault = partial(self._struck, on_struck)
        single.on_refused = self._refused
        if fault.kind in _LINE_KINDS:
            assert isinstance(self.port, FaultyPort)
            single.arm(self._bench.scheduler, self.port)
            self._of_line.append(single)
        else:
            plan.wires[fault.direction].faults.append(ByteFaults(single, fault.direction, [fault]))

    def towards(self, direction: Direction) -> str:
        """Return whom bytes of a direction are on the way to, for the journal."""
        return self._far if direction is Direction.A_TO_B else self._source

    def clear(self) -> int:
        """Take back all faults but a break that has begun; return how many there were."""
        wires = [] if self._plan is None else list(self._plan.wires.values())
        count = sum(len(wire.faults) for wire in wires)
        for wire in wires:
            wire.faults.clear()
        count += sum(plan.take_back(self._bench.scheduler) for plan in self._of_line)
        self._of_line.clear()
        return count

    def _arm(self) -> _GrowingPlan:
        self._plan = _GrowingPlan(seed=self._seed)
        self._stand_before(FaultyPort(self._bench.scheduler, self._line, self._plan))
        return self._plan

    def _refused(self, fault: Fault, reason: str, at_ns: int) -> None:
        if any(fault is one for one in self._breaks):  # it shows late that it cannot be
            self.struck[fault.kind.value, self.towards(fault.direction)] -= 1
            self._breaks = [one for one in self._breaks if one is not fault]
        self._bench.journal.record("fault-refused", "line", max(at_ns, 0), fault=fault.kind.value, text=reason)

    def _struck(self, on_struck: Callable[[], None], fault: Fault, direction: Direction, at_ns: int) -> None:
        towards = self.towards(direction)
        self.struck[fault.kind.value, towards] += 1
        if fault.kind is FaultKind.BREAK:
            self._breaks.append(fault)
        self._bench.journal.record("fault", "line", max(at_ns, 0), fault=fault.kind.value, towards=towards)
        on_struck()
