"""``python -m hilbench.clock.stamping PORT OWNER``: reads a descriptor, and says when the bytes came.

A process of its own, for one that also computes stamps late. It looks again and again, so of each chunk it knows two
moments of the host's monotonic clock: the last at which there was nothing, and one at which it had it. How late this
process itself was run lies in between.

A look that finds nothing at a terminal proves that nothing had been written: it waits for what the kernel still hands
on (Linux, drivers/tty/n_tty.c: `n_tty_poll`).

PORT is the descriptor. OWNER is a socket that keeps records apart, to whoever opened it. The first one says whether the
system runs this process before others, `RUNS_FIRST` or not. Each other one is `HEAD` with both moments, then the bytes;
none if the port has hung up, and then it is the last one. This process ends when the owner has closed its end.
"""

from __future__ import annotations

import contextlib
import gc
import os
import select
import socket
import struct
import sys
from collections.abc import Callable, Sequence

from hilbench.clock.host import MonotonicHostClock
from hilbench.clock.precedence import OF_A_READER, freeze_memory, take_precedence

__all__ = ["CHUNK_BYTES", "HEAD", "RUNS_AS_OTHERS", "RUNS_FIRST", "stamp"]

HEAD = struct.Struct("=qq")
RUNS_FIRST, RUNS_AS_OTHERS = b"1", b"0"
CHUNK_BYTES = 4096
LOOK_EVERY_S = 0.0002
"""Choice: with it a byte's moment is known to some 0.2 ms, for a tenth of a processor."""


def stamp(port: int, owner: socket.socket, now_ns: Callable[[], int], look_every_s: float = LOOK_EVERY_S) -> None:
    """Read a port until it hangs up or its owner goes.

    Args:
        port: the descriptor, which does not block.
        owner: takes the records.
        now_ns: the host's monotonic time, in ns.
        look_every_s: how often it is looked for bytes, in seconds of the host.
    """
    nothing_ns = 0
    watched = port, owner.fileno()
    while True:
        looked_ns = now_ns()
        ready = select.select(watched, (), (), 0)[0]
        if not ready:
            nothing_ns = looked_ns
            select.select(watched, (), (), look_every_s)
            continue
        if owner.fileno() in ready:
            return
        data = _read(port)
        if data is not None:
            owner.send(HEAD.pack(nothing_ns, now_ns()) + data)
            if not data:
                return


def _read(port: int) -> bytes | None:
    """Return what is there; None if nothing is after all, and no byte if the port has hung up."""
    try:
        data = os.read(port, CHUNK_BYTES)
    except BlockingIOError:
        return None
    except OSError:
        return b""
    return data if data or _has_hung_up(port) else None


def _has_hung_up(port: int) -> bool:
    """Say whether a port that gives no byte is gone; else somebody has thrown away what was to be read (tcflush(3))."""
    if not os.isatty(port):
        return True
    poll = select.poll()
    poll.register(port, 0)  # hang-ups and errors are always reported
    return bool(poll.poll(0))


def main(words: Sequence[str]) -> None:
    """Do it."""
    port, owner = int(words[0]), socket.socket(fileno=int(words[1]))
    said = RUNS_FIRST if take_precedence(OF_A_READER) else RUNS_AS_OTHERS
    freeze_memory()
    gc.disable()
    with contextlib.suppress(OSError):  # the owner is gone
        owner.send(said)
        stamp(port, owner, MonotonicHostClock().monotonic_ns)


if __name__ == "__main__":
    main(sys.argv[1:])
