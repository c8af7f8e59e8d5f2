"""A thousand million bytes each way through links in memory without pace: none lost, none changed; bytes per second.

Run by `make soak`. LINKS_SOAK_BYTES sets another amount, of which a tenth goes through the proxy's relay, a tenth
through a shared door, and a ten-thousandth passes between a station and the emulated rover; LINKS_SOAK_SEED sets
another seed.
"""

from __future__ import annotations

import os
import random
import time

import pytest

from hilbench.bench import Bench
from hilbench.clock import Scheduler
from hilbench.journal import Journal
from hilbench.links import Line, MemoryLink
from hilbench.serving.doors import SharedDoor
from hilbench.serving.relay import CLIENT, SERVER, Relay
from measure.proxy_soak import converse, told
from measure.soak.streams import LARGEST, Stream

BYTES = int(os.environ.get("LINKS_SOAK_BYTES", "1_000_000_000"))
SEED = int(os.environ.get("LINKS_SOAK_SEED", "1"))


def pump(scheduler, one, other, total):
    """Send so many bytes each way at once; return both streams, and bytes per second of both ways together."""
    chance = random.Random(SEED)
    there, back = Stream(SEED), Stream(SEED + 1)
    other.on_receive = lambda data, _at_ns: there.take(data)
    one.on_receive = lambda data, _at_ns: back.take(data)
    began_s = time.monotonic()
    while there.sent < total:
        count = min(chance.randint(1, LARGEST), total - there.sent)
        one.write(there.coming(count))
        other.write(back.coming(count))
        there.sent = back.sent = there.sent + count
        scheduler.run_for(1)
    scheduler.run_for(10**6)
    for stream in (there, back):
        assert (stream.received, stream.different) == (total, 0)
    return 2 * total / (time.monotonic() - began_s)


def test_a_line_in_memory(say):
    total = BYTES * 8 // 10
    scheduler = Scheduler()
    link = MemoryLink(scheduler, Line(baud=0))
    rate = pump(scheduler, link.a, link.b, total)
    assert link.a.counters == link.b.counters
    assert link.a.counters.lost == link.a.counters.overruns == 0
    say(f"memory: {total} bytes each way, none lost, {rate / 1e6:.0f} MB/s")


def test_a_shared_door(say):
    total = BYTES // 10
    scheduler = Scheduler()
    link = MemoryLink(scheduler, Line(baud=0))
    link.b.line_is_up = False
    door = SharedDoor([link.b])
    link.b.line_changed(True)
    rate = pump(scheduler, link.a, door, total)
    say(f"shared door: {total} bytes each way, none lost, {rate / 1e6:.0f} MB/s")


def test_the_relay_of_the_proxy(say):
    total = BYTES // 10
    scheduler = Scheduler()
    client, server = (MemoryLink(scheduler, Line(baud=0), name=name) for name in (CLIENT, SERVER))
    Relay(Bench(scheduler, Journal()), client.b, server.a, record=False)
    rate = pump(scheduler, client.a, server.b, total)
    say(f"relay: {total} bytes each way, none of them different, {rate / 1e6:.0f} MB/s")


@pytest.mark.parametrize("image", ["rover", "rover-dma"])
def test_a_station_and_the_rovers_firmware_with_a_proxy_in_between(say, image):
    """See `measure.proxy_soak`, which does more of it."""
    outcome = converse(image, max(BYTES // 10_000, 10_000), SEED)
    say(f"a station, a proxy and the emulated rover ({image}): {told([outcome])}")
    assert outcome.sound
