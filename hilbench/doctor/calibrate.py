"""Measures a port: how long a byte takes there and back, how that varies, and how exactly a block is paced.

Something must send back what it gets: a plug that joins TX and RX, or firmware that echoes. A byte passes the wire once
with a plug and twice with firmware, which cannot be told apart; only once is taken off, and not even that where a block
comes back faster than its bytes fit through a wire of that rate. So the figure is never too low.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from hilbench.bench.stamps import ByteStamps, PortStamps
from hilbench.clock import NS_PER_MS, NS_PER_S, HostClock, MonotonicHostClock, Scheduler, wall_time_iso
from hilbench.clock.precedence import OF_A_BENCH, freeze_memory, take_precedence
from hilbench.errors import UnavailableError
from hilbench.links import Line, Port, SerialPort
from hilbench.links.serial_target import SerialTarget, located, parse_serial_target
from hilbench.links.stamped import StampingProcess
from hilbench.ports.calibration import Calibration, keep, key_of, port_at
from hilbench.ports.listing import PortEnumerator, PortInfo, list_ports
from hilbench.terminal import own_process

__all__ = ["Calibrated", "calibrate", "measure"]

ROUND_TRIPS = 200
_FIRST_NS = NS_PER_S
"""How long the first byte may take: a chip that sleeps, a board that was reset when it was opened."""
_LOST_NS = NS_PER_S // 4
_QUIET_NS = 100 * NS_PER_MS
_SETTLE_NS = 5 * NS_PER_S
_BLOCK_S = 0.25
_BLOCK_BYTES = (64, 4096)
# Fewer bytes behind the first piece do not say how fast the line is.
_ENOUGH = 16
_ECHOES = "a plug that joins TX and RX, or firmware that echoes, such as targets/firmware/images/echo-irq.elf"


@dataclass(frozen=True, slots=True, kw_only=True)
class Calibrated:
    """A port that was measured.

    Attributes:
        calibration: what was measured.
        kept: the file it was written to; None if it is not kept.
        why_not: why it is not kept; empty if it is.
    """

    calibration: Calibration
    kept: Path | None
    why_not: str = ""


def calibrate(text: str, ports: PortEnumerator | None = None) -> Calibrated:
    """Open a port, measure it, and keep what was measured.

    Args:
        text: the port as a target, with or without ``serial:``.
        ports: says which ports there are; those of this machine by default.

    Raises:
        UsageError: the text is not a port.
        UnavailableError: it cannot be opened, nothing comes back, or something else.
    """
    there = (ports or list_ports)()
    target = located(parse_serial_target(text), lambda: there)
    key = key_of(target.url, there)
    calibration = _measure_at(target, key or target.url, port_at(target.url, there))
    kept, why_not = None, ""
    if calibration.lost:
        why_not = f"{calibration.lost} bytes did not come back, or too late to say how late; look at plug and rate"
    elif key is None:
        why_not = "a pseudo-terminal cannot be known again"
    else:
        try:
            kept = keep(calibration)
        except UnavailableError as error:  # what was measured is reported all the same
            why_not = str(error)
    return Calibrated(calibration=calibration, kept=kept, why_not=why_not)


def _measure_at(target: SerialTarget, key: str, info: PortInfo | None) -> Calibration:
    scheduler, clock = Scheduler(), MonotonicHostClock()
    stamps = None
    if own_process.is_ours():
        stamps = PortStamps(ByteStamps(StampingProcess))
        freeze_memory()
        take_precedence(OF_A_BENCH)
    try:
        scheduler.lock(clock)
        port = SerialPort(scheduler, target, stamps=stamps)
        try:
            return measure(
                scheduler, clock, port, key=key, latency_ms=info.latency_ms if info else None, trips=ROUND_TRIPS
            )
        finally:
            port.close()
    finally:
        if scheduler.locked:
            scheduler.unlock()
        clock.close()


def measure(
    scheduler: Scheduler, clock: HostClock, port: Port, *, key: str, latency_ms: int | None, trips: int
) -> Calibration:
    """Measure an open port whose rate is set; the scheduler is locked.

    Raises:
        UnavailableError: nothing comes back, or something else.
    """
    line = Line(baud=port.baud)
    echo = _Echo(scheduler, clock, port)
    echo.wait_for_quiet()
    if echo.round_trip_ns(_FIRST_NS) is None:
        raise _nothing(port, echo)
    trips_ns = [ns for ns in (echo.round_trip_ns(_LOST_NS) for _ in range(trips)) if ns is not None]
    if not trips_ns:
        raise _nothing(port, echo)
    count = min(max(round(port.baud / line.bits_per_byte * _BLOCK_S), _BLOCK_BYTES[0]), _BLOCK_BYTES[1])
    block = echo.block(count, line.bytes_ns(count) + 2 * NS_PER_S)
    wire_ns = line.bytes_ns(1) if block.was_on_a_wire(line) else 0
    excess = sorted(max(0, ns - wire_ns) for ns in trips_ns)
    return Calibration(
        key=key,
        target=port.name,
        measured_at=wall_time_iso(),
        baud=port.baud,
        latency_ms=latency_ms,
        round_trips=len(excess),
        lost=trips - len(excess),
        wire_s=wire_ns / NS_PER_S,
        excess_p50_s=_quantile(excess, 0.5) / NS_PER_S,
        excess_p99_s=_quantile(excess, 0.99) / NS_PER_S,
        excess_max_s=excess[-1] / NS_PER_S,
        jitter_s=(excess[-1] - excess[0]) / NS_PER_S,
        paced_bytes=count,
        paced_returned=block.right,
        paced_expected_s=line.bytes_ns(block.behind_the_first) / NS_PER_S,
        paced_measured_s=block.took_ns / NS_PER_S if block.right == block.got == count else None,
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class _Block:
    """What came back of bytes that were sent at once.

    Attributes:
        got: how many bytes came.
        right: how many of them are as they were sent, from the first on.
        behind_the_first: how many came behind the first piece: an adapter hands on several at a time.
        took_ns: from the first piece to the last.
    """

    got: int
    right: int
    behind_the_first: int
    took_ns: int

    def was_on_a_wire(self, line: Line) -> bool:
        """Say whether they came at most twice as fast as the line is, and enough of them to say so."""
        return self.behind_the_first >= _ENOUGH and 2 * self.took_ns >= line.bytes_ns(self.behind_the_first)


class _Echo:
    """Sends bytes and times what comes back, by the host's clock.

    Attributes:
        got: what came back since the last bytes were sent.
    """

    def __init__(self, scheduler: Scheduler, clock: HostClock, port: Port) -> None:
        self._scheduler = scheduler
        self._clock = clock
        self._port = port
        self._sent = 0
        self._pieces: list[tuple[int, int]] = []
        self.got = bytearray()
        port.on_receive = self._receive

    def wait_for_quiet(self) -> None:
        """Let pass what was on its way, at most for some seconds: a board that was reset may greet."""
        end_ns = self._scheduler.now_ns + _SETTLE_NS
        while self._scheduler.now_ns < end_ns:
            self._forget()
            self._wait(lambda: bool(self.got), _QUIET_NS)
            if not self.got:
                break

    def round_trip_ns(self, patience_ns: int) -> int | None:
        """Return how long a byte was away; None if it did not come back as it was, or with others."""
        self._forget()
        # From '!' to '~', another one each time: one that comes late is not taken for the next.
        byte = 0x21 + self._sent % 0x5E
        self._sent += 1
        start_ns = self._clock.monotonic_ns()
        self._port.write(bytes([byte]))
        self._wait(lambda: byte in self.got, patience_ns)
        return self._pieces[-1][1] - start_ns if bytes(self.got) == bytes([byte]) else None

    def block(self, count: int, patience_ns: int) -> _Block:
        """Send so many bytes at once; return what came back of them."""
        self._forget()
        block = bytes(0x21 + place % 0x5E for place in range(count))
        self._port.write(block)
        self._wait(lambda: len(self.got) >= count, patience_ns)
        pairs = enumerate(zip(self.got, block, strict=False))
        first_length, first_ns = self._pieces[0] if self._pieces else (0, 0)
        return _Block(
            got=len(self.got),
            right=next((place for place, (got, sent) in pairs if got != sent), min(len(self.got), count)),
            behind_the_first=len(self.got) - first_length,
            took_ns=self._pieces[-1][1] - first_ns if self._pieces else 0,
        )

    def _forget(self) -> None:
        self.got.clear()
        self._pieces.clear()

    def _receive(self, data: bytes, at_ns: int) -> None:
        self.got += data
        since_ns = self._scheduler.now_ns + self._scheduler.behind_ns - at_ns
        self._pieces.append((len(data), self._clock.monotonic_ns() - since_ns))

    def _wait(self, condition: Callable[[], bool], patience_ns: int) -> None:
        self._scheduler.run_until(condition, self._scheduler.now_ns + patience_ns)


def _nothing(port: Port, echo: _Echo) -> UnavailableError:
    if echo.got:
        what = f"what comes back is not what was sent: {bytes(echo.got[:16]).hex(' ').upper()}"
        return UnavailableError(what, where=port.name, hint=f"attach {_ECHOES}; is {port.baud} baud right?")
    return UnavailableError(f"nothing comes back at {port.baud} baud", where=port.name, hint=f"attach {_ECHOES}")


def _quantile(ordered: Sequence[int], share: float) -> int:
    """Return the value that at least `share` of the values do not exceed."""
    return ordered[max(0, -int(-share * len(ordered) // 1) - 1)]
