"""A device at several lines: what it is told of each, and where its bytes go."""

from __future__ import annotations

from hilbench.bench import Bench
from hilbench.bench.devices import LinesActor
from hilbench.clock import Scheduler
from hilbench.journal import Journal
from hilbench.links import Line, MemoryLink

BAUD = 921_600
MS = 1_000_000
OTHER = {"left": "right", "right": "left"}


class Crossing:
    """Puts what it hears at one line on the other, and a dot on the first one every millisecond."""

    def __init__(self):
        self.due_ns, self.down, self.events = MS, [], []

    def receive(self, line, data, now_ns):
        self.events.append((line, data))
        return [(OTHER[line], data), *self.advance(now_ns)]

    def advance(self, now_ns):
        if now_ns < self.due_ns:
            return []
        self.due_ns += MS
        return [("left", b".")]

    def next_deadline_ns(self):
        return self.due_ns

    def line_down(self, line, now_ns):
        self.down.append((line, now_ns))
        return [(OTHER[line], b"!")]

    def take_events(self):
        events, self.events = self.events, []
        return events


def test_each_line_gets_its_own():
    bench = Bench(Scheduler(), Journal())
    links = {name: MemoryLink(bench.scheduler, Line(baud=BAUD), name=name) for name in ("left", "right")}
    heard = {name: [] for name in links}
    for name, link in links.items():
        link.a.on_receive = lambda data, _at_ns, name=name: heard[name].append(data)
    device, told = Crossing(), []
    LinesActor(bench, device, {name: link.b for name, link in links.items()}, name="crossing", on_event=told.append)
    links["left"].a.write(b"x")
    bench.run_for(0.0025)
    assert b"".join(heard["left"]) == b".."
    assert b"".join(heard["right"]) == b"x"
    assert told == [("left", b"x")]
    links["left"].hang_up()
    bench.run_for(0.0004)
    assert device.down == [("left", 2_500_000)]
    assert b"".join(heard["right"]) == b"x!"
    sent = [(event["line"], event["data"]) for event in bench.journal.recent if event["kind"] == "tx"]
    assert [line for line, _ in sent] == ["right", "left", "left", "right"]
