"""The faults of a bench file on the lines of a bench: which way they go, what they leave in the journal.

The ends of a link are named after the roles: ``peer`` is where a client sits, ``NAME.host`` the robot's end. Who sits
there depends on the case. Where a server is tested the checker is the client; where a client is tested the scripted
server stands in for the robot. So a fault ``towards = "robot.host"`` always strikes what a client says.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from hilbench.bench import Bench
from hilbench.benchfile.bench_file import is_checker_end
from hilbench.benchfile.fault_entries import FaultEntry
from hilbench.clock import NS_PER_S
from hilbench.links.faults import Direction, Fault, FaultKind, FaultPlan, FaultyPort
from hilbench.links.port import Port


def describe_faults(entries: Sequence[FaultEntry]) -> str:
    """Return the faults of a bench file in one line; empty if there are none."""
    return "; ".join(entry.describe() for entry in entries)


def plan_for(faults: LineFaults | None, link: int | None) -> FaultPlan | None:
    """Return what goes wrong on a link in memory; None if nothing does on any."""
    return None if faults is None else faults.plan_of(link)


def _nobody(_text: str) -> None:
    """Stand in for somebody who tells a person."""


@dataclass(slots=True, kw_only=True)
class _Strikes:
    count: int = 0
    last_ns: int = 0


class LineFaults:
    """The faults of a bench's lines, from now on.

    Args:
        bench: whose time and journal are used; ``at_s`` counts from its present time.
        entries: as in the bench file.
        seed: decides what chance decides.
        near_is_client: who owns the near end of each, ``a`` of a link in memory or this side of a port: the client, or
            the robot.
        on_interruption: called when a disconnection begins, before the ends are told.
        is_client_end: says whether an end that a fault is towards is the client's.

    Attributes:
        on_refused: called with a sentence for people when a fault cannot strike: a break at a port that knows none.
    """

    def __init__(
        self,
        bench: Bench,
        entries: Sequence[FaultEntry],
        *,
        seed: int,
        near_is_client: bool,
        on_interruption: Callable[[], None] = lambda: None,
        is_client_end: Callable[[str], bool] = is_checker_end,
    ) -> None:
        self._bench = bench
        self._entries = entries
        self._strikes = [_Strikes() for _ in entries]
        self._refusals: list[str] = []
        self.on_refused: Callable[[str], None] = _nobody
        self._on_interruption = on_interruption
        near_to_far, far_to_near = Direction.A_TO_B, Direction.B_TO_A
        to_client, to_robot = (far_to_near, near_to_far) if near_is_client else (near_to_far, far_to_near)
        self._faults = [
            Fault(
                kind=FaultKind(entry.kind),
                direction=to_client if is_client_end(str(entry.towards)) else to_robot,
                **entry.given,
            )
            for entry in entries
        ]
        self._seed = seed
        self._epoch_ns = bench.now_ns
        self._plans: dict[int | None, FaultPlan] = {}

    @property
    def plan(self) -> FaultPlan:
        """Those of link 0, the only one of most benches."""
        return self.plan_of(0)

    def plan_of(self, link: int | None) -> FaultPlan:
        """Those of a link, counted from 0 as in the bench file; none for None, a line that the file does not name."""
        if link not in self._plans:
            faults = (fault for fault, entry in zip(self._faults, self._entries, strict=True) if entry.link == link)
            plan = FaultPlan(tuple(faults), seed=self._seed + (link or 0), epoch_ns=self._epoch_ns)
            plan.on_fault = self._struck
            plan.on_refused = self._refused
            self._plans[link] = plan
        return self._plans[link]

    def on(self, port: Port, link: int | None = 0) -> FaultyPort:
        """Put the faults of a link between a port and its owner."""
        return FaultyPort(self._bench.scheduler, port, self.plan_of(link))

    def evidence(self) -> list[str]:
        """Return a line for each fault that has struck, and for each that could not."""
        return self._refusals + [
            f"{strikes.last_ns / NS_PER_S:10.4f} s  fault {entry.describe()} struck (number {strikes.count})"
            for entry, strikes in zip(self._entries, self._strikes, strict=True)
            if strikes.count
        ]

    def _number(self, fault: Fault) -> int:
        return next(index for index, known in enumerate(self._faults) if known is fault)

    def _refused(self, fault: Fault, reason: str, at_ns: int) -> None:
        number = self._number(fault)
        entry = self._entries[number]
        self._strikes[number].count = 0  # it would have struck once: a fault of the line has one time
        text = f"fault {entry.describe()} did not strike: {reason}"
        self._refusals.append(f"{at_ns / NS_PER_S:10.4f} s  {text}")
        self._bench.record("fault-refused", "line", number=number, fault=entry.kind, text=reason)
        self.on_refused(text)

    def _struck(self, fault: Fault, _direction: Direction, at_ns: int) -> None:
        number = self._number(fault)
        self._strikes[number].count += 1
        self._strikes[number].last_ns = at_ns
        entry = self._entries[number]
        self._bench.record("fault", "line", number=number, fault=entry.kind, towards=entry.towards or "both")
        if fault.kind is FaultKind.DISCONNECT:
            self._on_interruption()
