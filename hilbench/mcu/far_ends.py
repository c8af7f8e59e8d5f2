"""The far ends of the USARTs' lines, with the faults of the bench file on those that have any."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial

from hilbench.bench import Bench
from hilbench.bench.line_faults import LineFaults
from hilbench.benchfile.bench_file import BenchFile
from hilbench.links.faults import Direction, Fault, FaultPlan, FaultyPort
from hilbench.mcu.usart_port import UsartPort

__all__ = ["FarEnds", "FaultyUsartPort"]


class FaultyUsartPort(FaultyPort):
    """The far end of a USART's line with faults on it.

    RX and TX have no carrier: a line that is interrupted is silent, and neither end is notified.

    Args:
        bench: whose time is used.
        port: the far end; its callbacks belong to this one from now on.
        plan: what goes wrong.

    Attributes:
        taps: called with the bytes that this end reads and the bench time of them, before `on_receive`.
    """

    def __init__(self, bench: Bench, port: UsartPort, plan: FaultPlan) -> None:
        self.taps: list[Callable[[bytes, int], None]] = []
        self._usart_port = port
        super().__init__(bench.scheduler, port, plan)

    def hang_up(self) -> None:
        """Interrupt the line: nothing passes either way, and what waits is lost."""
        self._interrupted = True
        self._usart_port.lose()

    def restore(self) -> None:
        """Let bytes pass again."""
        self._interrupted = False

    def _judge_sent(self, plan: FaultPlan) -> None:
        """Have the port judge bytes as they begin, so that those that are lost or come beside take their time."""
        plan.on_fault = partial(self._tell, plan.on_fault)
        self._usart_port.strike_with(plan.injector(Direction.A_TO_B))

    def _tell(self, struck: Callable[[Fault, Direction, int], None], fault: Fault, way: Direction, at_ns: int) -> None:
        """Tell of a fault when the bench is there: what the port judges is ahead of it."""
        tell = partial(struck, fault, way, at_ns)
        if at_ns > self._scheduler.now_ns:
            self._usart_port.output(at_ns, tell)
        else:
            tell()

    def _deliver(self, data: bytes, now_ns: int) -> None:
        for tap in self.taps:
            tap(data, now_ns)
        super()._deliver(data, now_ns)


class FarEnds:
    """See the module.

    Args:
        bench: whose time and journal are used; times of faults count from its present one.
        bench_file: the links, and what goes wrong on them.
        ports: the far ends without faults, as ``BOARD.usart1``.
        seed: decides what chance decides.

    Attributes:
        faults: what goes wrong on the lines; None if nothing does.
    """

    def __init__(self, bench: Bench, bench_file: BenchFile, ports: Mapping[str, UsartPort], *, seed: int) -> None:
        self._ports = ports
        self._faulty: dict[str, FaultyUsartPort] = {}
        self.faults: LineFaults | None = None
        if bench_file.faults:
            self.faults = LineFaults(
                bench,
                bench_file.faults,
                seed=seed,
                near_is_client=True,
                is_client_end=lambda end: end not in ports,
            )
            for number, link in enumerate(bench_file.links):
                plan = self.faults.plan_of(number)
                for end in link.ends:
                    if plan.faults and end in ports:
                        self._faulty[end] = FaultyUsartPort(bench, ports[end], plan)

    def tell_of_refusals(self, say: Callable[[str], None]) -> None:
        """Have a person told of faults that cannot strike."""
        if self.faults is not None:
            self.faults.on_refused = say

    def __contains__(self, end: str) -> bool:
        return end in self._ports

    def __getitem__(self, end: str) -> UsartPort | FaultyUsartPort:
        """Return a far end; it has one owner.

        Raises:
            KeyError: there is none of that name.
        """
        return self._faulty.get(end) or self._ports[end]

    def reacting(self, end: str) -> UsartPort | FaultyUsartPort:
        """Return a far end for an owner who may answer each byte at once, so that the chip waits for that.

        Raises:
            KeyError: there is none of that name.
        """
        self._ports[end].reacts = True
        return self[end]
