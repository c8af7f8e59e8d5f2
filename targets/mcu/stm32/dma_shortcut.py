"""An item that goes through a DMA stream at once, where nobody can tell it from two accesses one after the other.

Most bytes of a serial line that DMA moves come and go while the program sleeps, and nothing else happens in the handful
of cycles that they take. Then the access of the peripheral port and that of the memory port are made within the event
that asks for them, each at its own cycle: the time stands there meanwhile. Both ports are held for as long as they
would be busy.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from targets.mcu.errors import BusFault
from targets.mcu.stm32.dma_port import Port
from targets.mcu.stm32.dma_requests import Request
from targets.mcu.stm32.dma_stream import Stream
from targets.mcu.timebase import Timebase

__all__ = ["pass_unseen"]


def pass_unseen(
    time: Timebase,
    ports: tuple[Port, Port],
    requests: Sequence[Request],
    stream: Stream,
    *,
    fail: Callable[[], None],
    look: Callable[[], None],
) -> bool:
    """Move one item between peripheral and memory if nobody can tell that this happens at once.

    Args:
        time: cycles and events.
        ports: of the peripherals and of the memory.
        requests: that the stream listens to; one of them asks.
        stream: what moves the item; while it does, changes of the requests must not be acted on.
        fail: ends the stream with an error, called at the cycle at which an access has failed.
        look: sees what the stream wants next, called at the cycle at which it may.

    Returns:
        False if nothing was done.
    """
    of_peripheral, of_memory = ports
    for request in requests:
        if not request.private:
            return False
    now = time.now
    if not (stream.plain and of_peripheral.idle_at(now) and of_memory.idle_at(now)):
        return False
    fetched = now + of_peripheral.access_cycles
    stored = fetched + of_memory.access_cycles
    if not time.nobody_looks_until(stored):
        return False
    of_peripheral.hold(fetched)
    of_memory.hold(stored)
    for request in requests:
        request.once = False
    try:
        time.hold(fetched)
        stream.access_peripheral()
        time.hold(stored)
        stream.access_memory()
    except BusFault:
        time.at(time.now, fail)
    time.hold(now)
    if any(each.level or each.once for each in requests):
        # What comes in goes on when the peripheral port is free, what goes out when there is something to send.
        time.at(fetched if stream.incoming else stored, look)
    return True
