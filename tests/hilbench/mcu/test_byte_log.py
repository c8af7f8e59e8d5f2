"""Bytes come into the journal by the chunk, however often somebody asks for what is not there yet."""

from __future__ import annotations

from hilbench.bench import Bench
from hilbench.bench.byte_log import CHUNK_NS, ByteLog
from hilbench.clock import NS_PER_MS, Scheduler
from hilbench.journal import Journal
from tests.each import each

SPAN_NS = 2000 * NS_PER_MS
BYTE_NS = NS_PER_MS


@each("flush_ns", [None, 100 * NS_PER_MS, 7 * NS_PER_MS])
def test_a_line_that_never_rests_makes_an_event_for_each_chunk(flush_ns):
    bench = Bench(Scheduler(), Journal())
    log = ByteLog(bench, "rx", "host")
    events, sent = [], bytearray()
    bench.journal.on_event = events.append

    def add():
        sent.append(len(sent) % 256)
        log.add(sent[-1:], bench.now_ns)
        bench.scheduler.after(BYTE_NS, add)

    def flush():
        log.flush()
        bench.scheduler.after(flush_ns, flush)

    add()
    if flush_ns:
        flush()
    bench.run_for(SPAN_NS / 1e9)
    log.flush()
    assert b"".join(bytes.fromhex(event["data"]) for event in events) == bytes(sent)
    assert len(events) <= SPAN_NS // CHUNK_NS + (SPAN_NS // flush_ns if flush_ns else 0) + 1
    assert all(event["ns"] - event["from_ns"] <= CHUNK_NS for event in events)
