"""Runs a bench beside a program that reads and writes its line: in a thread, or while the program waits.

*In real time* a thread of its own runs the bench, locked to the host's clock. What the program writes is handed to that
thread; what comes is kept until it is read. Any thread of the program may call.

*Fast* there is no thread: the bench runs in whoever reads or flushes, as fast as the processor goes, and bench time
passes there alone, a read's timeout being bench time. So nothing depends on the host's speed, and two runs of one
program are the same. Programs with several threads at the line are not meant for it.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable
from functools import partial
from queue import SimpleQueue
from typing import Protocol

from hilbench.bench import Bench
from hilbench.benchfile.bench_file import BenchFile
from hilbench.clock import NS_PER_S, MonotonicHostClock, Scheduler
from hilbench.errors import HilbenchError, InternalError
from hilbench.journal import Journal
from hilbench.links.door import Input
from hilbench.serving.near_ends import NearEnd, open_near_end

__all__ = ["FastRunner", "RealTimeRunner", "Runner"]

_LONGEST_NS = 3600 * NS_PER_S
"""How much bench time a read without a timeout lets pass at a stretch."""


class Runner(Protocol):
    """A bench that runs beside a program; `failure` says why it runs no more."""

    failure: str

    def write(self, data: bytes) -> None:
        """Put bytes on the line."""

    def read(self, size: int, timeout_s: float | None) -> bytes:
        """Return up to `size` bytes, as soon as there are so many or the time is over."""

    @property
    def waiting(self) -> int:
        """Bytes that can be read at once."""

    @property
    def pending(self) -> int:
        """Bytes written that are not out yet."""

    def drain(self) -> None:
        """Wait until all is out that was written."""

    def do(self, action: Callable[[NearEnd], None]) -> None:
        """Have something done to the end of the line."""

    def discard(self) -> None:
        """Forget what came and was not read."""

    def cancel(self) -> None:
        """Have a read that waits return with what there is."""

    def close(self) -> None:
        """End the bench."""


class FastRunner:
    """See the module.

    Args:
        bench_file: what to build.
        line: which line; empty for the usual one.
        baud: rate of this end, bit/s.
        seed: of everything random.

    Raises:
        HilbenchError: it cannot be built.
    """

    def __init__(self, bench_file: BenchFile, *, line: str, baud: int, seed: int) -> None:
        self.failure = ""
        self._bench = Bench(Scheduler(), Journal())
        self._end = open_near_end(self._bench, bench_file, line=line, seed=seed, real_time=False)
        self._end.port.baud = baud
        self._came = bytearray()
        self._end.port.on_receive = lambda data, _at_ns: self._came.extend(data)

    def write(self, data: bytes) -> None:
        """Put bytes on the line, at the present."""
        self._end.port.write(data)

    def read(self, size: int, timeout_s: float | None) -> bytes:
        """Let bench time pass until there are so many bytes, or the timeout is over."""
        limit_ns = _LONGEST_NS if timeout_s is None else round(timeout_s * NS_PER_S)
        while not self.failure:
            enough = self._run(lambda: len(self._came) >= size, limit_ns)
            if enough or timeout_s is not None:
                break
        data = bytes(self._came[:size])
        del self._came[:size]
        return data

    @property
    def waiting(self) -> int:
        """Bytes that can be read at once."""
        return len(self._came)

    @property
    def pending(self) -> int:
        """Bytes written that are not out yet."""
        return self._end.port.pending

    def drain(self) -> None:
        """Let bench time pass until all is out."""
        self._run(lambda: not self._end.port.pending, _LONGEST_NS)

    def do(self, action: Callable[[NearEnd], None]) -> None:
        """Have something done to the end of the line."""
        action(self._end)

    def discard(self) -> None:
        """Forget what came and was not read."""
        self._came.clear()

    def cancel(self) -> None:
        """Do nothing: nobody waits while somebody else runs."""

    def close(self) -> None:
        """End the bench."""
        self._end.close()

    def _run(self, condition: Callable[[], bool], limit_ns: int) -> bool:
        scheduler = self._bench.scheduler
        over = scheduler.run_until(lambda: condition() or bool(self._end.ended()), scheduler.now_ns + limit_ns)
        self.failure = self._end.ended()
        return over and condition()


class RealTimeRunner:
    """See the module.

    Args:
        bench_file: what to build.
        line: which line; empty for the usual one.
        baud: rate of this end, bit/s.
        seed: of everything random.

    Raises:
        HilbenchError: it cannot be built.
    """

    def __init__(self, bench_file: BenchFile, *, line: str, baud: int, seed: int) -> None:
        self.failure = ""
        self._build = partial(open_near_end, bench_file=bench_file, line=line, seed=seed, real_time=True)
        self._baud = baud
        self._came = bytearray()
        self._there = threading.Condition()
        self._cancelled = False
        self._written = self._handed_over = self._on_line = 0
        self._wishes: SimpleQueue[Callable[[NearEnd], None]] = SimpleQueue()
        self._wake_read, self._wake_write = os.pipe()
        self._stopped = False
        self._closed = False
        self._built: SimpleQueue[HilbenchError | None] = SimpleQueue()
        self._thread = threading.Thread(target=self._run, name="hilbench", daemon=True)
        self._thread.start()
        refusal = self._built.get()
        if refusal is not None:
            self.close()
            raise refusal

    def write(self, data: bytes) -> None:
        """Have bytes put on the line."""
        with self._there:
            self._written += len(data)
        self.do(partial(self._put, data))

    def read(self, size: int, timeout_s: float | None) -> bytes:
        """Wait until there are so many bytes, or the timeout is over, in seconds of the host."""
        with self._there:
            self._there.wait_for(lambda: len(self._came) >= size or bool(self.failure) or self._cancelled, timeout_s)
            self._cancelled = False
            data = bytes(self._came[:size])
            del self._came[:size]
        return data

    @property
    def waiting(self) -> int:
        """Bytes that can be read at once."""
        return len(self._came)

    @property
    def pending(self) -> int:
        """Bytes written that are not out yet, as of the last thing that happened on the line."""
        return self._written - self._handed_over + self._on_line

    def drain(self) -> None:
        """Wait until all is out that was written."""
        with self._there:
            self._there.wait_for(lambda: not self.pending or bool(self.failure))

    def do(self, action: Callable[[NearEnd], None]) -> None:
        """Have something done to the end of the line, by the thread of the bench."""
        self._wishes.put(action)
        os.write(self._wake_write, b"!")

    def discard(self) -> None:
        """Forget what came and was not read."""
        with self._there:
            self._came.clear()

    def cancel(self) -> None:
        """Have a read that waits return with what there is."""
        with self._there:
            self._cancelled = True
            self._there.notify_all()

    def close(self) -> None:
        """End the bench and its thread; a second call does nothing."""
        if self._closed:
            return
        self._closed = True
        self.do(lambda _end: setattr(self, "_stopped", True))
        self._thread.join()
        os.close(self._wake_read)
        os.close(self._wake_write)

    # --- in the thread of the bench

    def _run(self) -> None:
        host = MonotonicHostClock()
        try:
            self._run_bench(host)
        except Exception as error:  # noqa: BLE001 - it is told to whoever reads, in whose thread it can be raised
            self._fail(f"the bench has ended: {error}")
            self._built.put(InternalError(f"the bench cannot be built: {error}"))
        finally:
            host.close()

    def _run_bench(self, host: MonotonicHostClock) -> None:
        bench = Bench(Scheduler(), Journal())
        try:
            end = self._build(bench)
        except HilbenchError as error:
            self._built.put(error)
            return
        wishes = Input(descriptor=self._wake_read, read=lambda at_ns: self._wished(bench, end, at_ns))
        end.port.baud = self._baud
        end.port.on_receive = self._received
        bench.scheduler.add_source(wishes)
        bench.scheduler.lock(host)
        self._built.put(None)
        try:
            bench.scheduler.run_until(lambda: self._look(end), None)
            self._fail(end.ended() or "the bench was closed")
        finally:
            bench.scheduler.remove_source(wishes)
            bench.scheduler.unlock()
            end.close()

    def _wished(self, bench: Bench, end: NearEnd, at_ns: int) -> None:
        for _ in os.read(self._wake_read, 256):
            bench.scheduler.at(at_ns, partial(self._wishes.get(), end), source="program")

    def _put(self, data: bytes, end: NearEnd) -> None:
        self._on_line += len(data)
        self._handed_over += len(data)
        end.port.write(data)

    def _received(self, data: bytes, _at_ns: int) -> None:
        with self._there:
            self._came += data
            self._there.notify_all()

    def _look(self, end: NearEnd) -> bool:
        """Say whether it is over; tell whoever waits for the line to be free."""
        if self._on_line:
            self._on_line = end.port.pending
            if not self.pending:
                with self._there:
                    self._there.notify_all()
        return self._stopped or bool(end.ended())

    def _fail(self, why: str) -> None:
        with self._there:
            self.failure = why
            self._there.notify_all()
