"""Benches made late, in bench time: bytes are read late and handed over late, as by a host that is busy.

So it shows without a busy host what verdicts make of lateness: a right peer is never accused, and what a wrong one says
is held against it all the same.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from unittest.mock import patch

from hilbench.bench import Bench
from hilbench.clock import NS_PER_S, Scheduler
from hilbench.judging.provider import BenchProvider
from hilbench.judging.uncertainty import OfTimes
from hilbench.judging.verdicts import Verdict
from hilbench.links import Port
from hilbench.links.front import PortInFront
from hilbench.pace.lateness import Lateness

__all__ = ["BLAMED", "AtPort", "late_benches"]

BLAMED = frozenset({Verdict.FAIL, Verdict.ERROR})
"""What no right peer may get of a late bench: blame, or a suite that stumbles."""

_AT_PORT = frozenset(
    {"P2OS", "PKT!", "CARLA", "server", "board", "stack", "simulator", "client", "client.disconnect"}
) | {*("baud", "hangup", "reopen")}


class AtPort:
    """A provider that sees no more of a target than its lines.

    Args:
        provider: sees all of it.
    """

    def __init__(self, provider: BenchProvider) -> None:
        self.open_case = provider.open_case
        self.describe = provider.describe
        self.close = provider.close
        self.capabilities = frozenset(
            one for one in provider.capabilities if one in _AT_PORT or one.startswith("program ")
        )


class _LatePort(PortInFront):
    """A port whose bytes wait for somebody to wake up, both ways, for as long as chance has it; none overtakes another.

    Args:
        scheduler: whose time passes.
        port: the port.
        most_s: how long they wait at most, in seconds.
        seed: decides for how long.
    """

    def __init__(self, scheduler: Scheduler, port: Port, most_s: float, seed: int) -> None:
        super().__init__(port)
        self._scheduler = scheduler
        self._most_ns = round(most_s * NS_PER_S)
        self._chance = random.Random(seed)
        self._free_ns = {True: 0, False: 0}
        self.counters = port.counters
        port.on_sent = self._handed_over

    def write(self, data: bytes) -> None:
        """Hand bytes over, late."""
        self._later(True, partial(self.port.write, data))

    def _handed_over(self, data: bytes, at_ns: int) -> None:
        self.on_sent(data, at_ns)

    def _received(self, data: bytes, _at_ns: int) -> None:
        self._later(False, lambda: self.on_receive(data, self._scheduler.now_ns))

    def _later(self, out: bool, action: Callable[[], None]) -> None:
        when_ns = max(self._free_ns[out], self._scheduler.now_ns + self._chance.randrange(self._most_ns + 1))
        self._free_ns[out] = when_ns
        self._scheduler.at(when_ns, action, source="late")


@contextmanager
def late_benches(late_s: float, seed: int = 0) -> Iterator[None]:
    """Make every bench late that is opened in the ``with`` block, and let it say so.

    Args:
        late_s: how late, there and back together, in seconds.
        seed: decides when.
    """

    def near_end(bench: Bench, port: Port) -> Port:
        return _LatePort(bench.scheduler, port, late_s / 2, seed)

    def uncertainty_s(_bench: Bench, _since_ns: int) -> OfTimes:
        return OfTimes(late_s)

    def own_lateness(_bench: Bench, _since_ns: int) -> Lateness:
        return Lateness(late_ns=round(late_s * NS_PER_S))

    with (
        patch.object(Bench, "near_end", near_end),
        patch.object(Bench, "uncertainty_s", uncertainty_s),
        patch.object(Bench, "own_lateness", own_lateness),
    ):
        yield
