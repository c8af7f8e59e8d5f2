"""For tests of what is built on hilbench: a host clock in your hands, a pair of ports, a check for anybody's link."""

from __future__ import annotations

import heapq
import itertools
import random
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial

from hilbench.clock import NS_PER_S, InputSource, Scheduler
from hilbench.errors import PortClosedError
from hilbench.links.memory import MemoryLink, MemoryPort
from hilbench.links.port import Line, Port


class FakeHostClock:
    """A host clock that jumps to whatever is waited for, and whose inputs and stalls are scripted.

    Attributes:
        host_ns: The host's monotonic time in ns.
    """

    def __init__(self, host_ns: int = 1_000 * NS_PER_S) -> None:
        self.host_ns = host_ns
        self.watched: list[InputSource] = []
        self._arrivals: list[tuple[int, int, InputSource]] = []
        self._stalls: list[tuple[int, int]] = []
        self._sequence = itertools.count()

    def monotonic_ns(self) -> int:
        """Return the host's monotonic time in ns."""
        return self.host_ns

    def advance(self, duration_ns: int) -> None:
        """Let host time pass, as an entry that computes for long does."""
        self.host_ns += duration_ns

    def arrive(self, host_ns: int, source: InputSource) -> None:
        """Make `source` readable at host time `host_ns`."""
        heapq.heappush(self._arrivals, (host_ns, next(self._sequence), source))

    def stall(self, host_ns: int, duration_ns: int) -> None:
        """Let the first wait that would end at or after `host_ns` end `duration_ns` too late."""
        heapq.heappush(self._stalls, (host_ns, duration_ns))

    def wait_until(self, host_ns: int | None) -> Sequence[InputSource]:
        """Jump to `host_ns` or to the next arrival; return the inputs readable then."""
        ends_ns = [self._arrivals[0][0]] if self._arrivals else []
        if host_ns is not None:
            ends_ns.append(host_ns)
        if not ends_ns:
            raise AssertionError("the bench waits for ever: no entry, no deadline and no scripted arrival")
        self.host_ns = max(self.host_ns, min(ends_ns))
        if self._stalls and self._stalls[0][0] <= self.host_ns:
            self.host_ns += heapq.heappop(self._stalls)[1]
        ready: list[InputSource] = []
        while self._arrivals and self._arrivals[0][0] <= self.host_ns:
            source = heapq.heappop(self._arrivals)[2]
            if source in self.watched and source not in ready:
                ready.append(source)
        return ready

    def watch(self, source: InputSource) -> None:
        """Begin to watch `source`."""
        self.watched.append(source)

    def unwatch(self, source: InputSource) -> None:
        """Stop watching `source`."""
        self.watched.remove(source)


def link_pair(scheduler: Scheduler, *, baud: int = 115_200, name: str = "link") -> tuple[MemoryPort, MemoryPort]:
    """Return the two ends of a line inside the bench; `baud` in bit/s, 0 for no pace."""
    link = MemoryLink(scheduler, Line(baud=baud), name=name)
    return link.a, link.b


@dataclass(frozen=True, slots=True, kw_only=True)
class LinkUnderTest:
    """Two ends of a link to be checked.

    Attributes:
        scheduler: What runs it; locked if anything of the link is real.
        a: One end.
        b: The other.
        baud: The rate neither direction may exceed, bit/s; 0 if there is none.
    """

    scheduler: Scheduler
    a: Port
    b: Port
    baud: int


def check_link(
    make_link: Callable[[], LinkUnderTest], *, large_bytes: int = 2000, patience_s: float = 20, hangs_up: bool = True
) -> None:
    """Check that a link keeps the promises of `Port`; for links of your own as well as for ours.

    Bytes arrive complete, in order, with nothing invented, in both directions at once; not faster than the baud rate;
    a large transfer passes; the other end is notified when one is closed; a closed port refuses to write and may be
    closed again.

    Args:
        make_link: Makes a fresh link; called several times. Both ends are closed here.
        large_bytes: Size of the large transfer each way.
        patience_s: Bench seconds to wait for anything.
        hangs_up: Whether the link tells one end that the other was closed; one with something in between does not.

    Raises:
        AssertionError: a promise is broken; the message says which.
    """
    patience_ns = round(patience_s * NS_PER_S)
    hanging_up = (_check_b_hangs_up, _check_a_hangs_up) if hangs_up else ()
    for check in (_check_bytes, _check_large, *hanging_up):
        link = make_link()
        try:
            _wait(link, partial(_line_is_up, link), patience_ns, "the line never came up")
            check(link, (_End(link.a), _End(link.b)), large_bytes, patience_ns)
        finally:
            link.a.close()
            link.b.close()


def _line_is_up(link: LinkUnderTest) -> bool:
    return link.a.line_is_up and link.b.line_is_up


@dataclass(slots=True)
class _End:
    """Keeps what one end reports."""

    port: Port
    data: bytearray = field(default_factory=bytearray)
    times_ns: list[int] = field(default_factory=list)
    lines: list[bool] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.port.on_receive = self._received
        self.port.on_line = lambda up, _at_ns: self.lines.append(up)

    def _received(self, data: bytes, at_ns: int) -> None:
        self.data += data
        self.times_ns += [at_ns] * len(data)


def _wait(link: LinkUnderTest, condition: Callable[[], bool], patience_ns: int, complaint: str) -> None:
    if not link.scheduler.run_until(condition, link.scheduler.now_ns + patience_ns):
        raise AssertionError(complaint)


def _require(condition: bool, complaint: str) -> None:
    if not condition:
        raise AssertionError(complaint)


def _exchange(link: LinkUnderTest, ends: tuple[_End, _End], data: tuple[bytes, bytes], patience_ns: int) -> None:
    """Send `data` both ways at once and look at what comes out."""
    a, b = ends
    for end in ends:
        end.data.clear()
        end.times_ns.clear()
    start_ns = link.scheduler.now_ns
    a.port.write(data[0])
    b.port.write(data[1])
    link.scheduler.run_until(
        lambda: len(b.data) >= len(data[0]) and len(a.data) >= len(data[1]), start_ns + patience_ns
    )
    _compare(b, data[0], "a to b")
    _compare(a, data[1], "b to a")
    link.scheduler.run_for(Line(baud=link.baud).bytes_ns(4))
    for end, sent, way in ((b, data[0], "a to b"), (a, data[1], "b to a")):
        _require(len(end.data) == len(sent), f"{way}: {len(end.data) - len(sent)} bytes were invented")
        took_ns = end.times_ns[-1] - start_ns
        least_ns = Line(baud=link.baud).bytes_ns(len(sent))
        _require(took_ns >= least_ns, f"{way}: {len(sent)} bytes took {took_ns} ns; {link.baud} baud need {least_ns}")
        _require(end.times_ns == sorted(end.times_ns), f"{way}: the times of the bytes run backwards")


def _compare(end: _End, sent: bytes, way: str) -> None:
    got = bytes(end.data[: len(sent)])
    if got != sent:
        position = next((i for i, (x, y) in enumerate(zip(got, sent, strict=False)) if x != y), len(got))
        raise AssertionError(f"{way}: {len(got)} of {len(sent)} bytes arrived; the first difference is at {position}")


def _check_bytes(link: LinkUnderTest, ends: tuple[_End, _End], _large_bytes: int, patience_ns: int) -> None:
    _exchange(link, ends, (bytes(range(256)), bytes(reversed(range(256)))), patience_ns)
    _exchange(link, ends, (b"\x00", b"\xff"), patience_ns)


def _check_large(link: LinkUnderTest, ends: tuple[_End, _End], large_bytes: int, patience_ns: int) -> None:
    source = random.Random(1)
    _exchange(link, ends, (source.randbytes(large_bytes), source.randbytes(large_bytes)), patience_ns)


def _check_b_hangs_up(link: LinkUnderTest, ends: tuple[_End, _End], _large_bytes: int, patience_ns: int) -> None:
    _check_hang_up(link, ends[1], ends[0], patience_ns)


def _check_a_hangs_up(link: LinkUnderTest, ends: tuple[_End, _End], _large_bytes: int, patience_ns: int) -> None:
    _check_hang_up(link, ends[0], ends[1], patience_ns)


def _check_hang_up(link: LinkUnderTest, closing: _End, other: _End, patience_ns: int) -> None:
    name = closing.port.name
    closing.port.write(b"last words")
    _wait(link, lambda: bytes(other.data) == b"last words", patience_ns, f"{name}: the last bytes did not arrive")
    closing.port.close()
    _wait(
        link, lambda: not other.port.line_is_up, patience_ns, f"{other.port.name} was not notified that {name} hung up"
    )
    _require(other.lines[-1:] == [False], f"{other.port.name}: the line is down but on_line did not say so")
    try:
        closing.port.write(b"!")
    except PortClosedError:
        pass
    else:
        raise AssertionError(f"{name}: a write after close() raised no PortClosedError")
    closing.port.close()
