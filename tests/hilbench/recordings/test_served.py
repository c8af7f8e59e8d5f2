"""The journal of a served model has what its client says, and when, before the model hears it."""

from __future__ import annotations

from hilbench.bench import Bench
from hilbench.clock import Scheduler
from hilbench.journal import Journal
from hilbench.links import Line, MemoryLink
from hilbench.serving.serve import _record_received


def test_bytes_to_the_model_are_recorded_and_reach_it():
    scheduler = Scheduler()
    bench = Bench(scheduler, Journal())
    link = MemoryLink(scheduler, Line(baud=9600), name="host")
    heard = []
    link.b.on_receive = lambda data, at_ns: heard.append((data, at_ns, len(bench.journal.recent)))
    _record_received(bench, "robot", link.b)
    link.a.write(b"abc")
    scheduler.run_until(lambda: False, 10_000_000)
    assert b"".join(data for data, _, _ in heard) == b"abc"
    told = [(bytes.fromhex(event["data"]), event["ns"]) for event in bench.journal.recent]
    assert told == [(data, at_ns) for data, at_ns, _ in heard]
    assert [count for _, _, count in heard] == list(range(1, len(heard) + 1))
    assert {(event["kind"], event["source"]) for event in bench.journal.recent} == {("rx", "robot")}
