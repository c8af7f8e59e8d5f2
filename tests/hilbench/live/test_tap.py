"""What somebody has injected by hand: counted as having struck, and no more than it has."""

from __future__ import annotations

from hilbench.bench import Bench
from hilbench.clock import Scheduler
from hilbench.driving.tap import Tap
from hilbench.errors import UnavailableError
from hilbench.journal import Journal
from hilbench.links import Line, MemoryLink
from hilbench.links.faults import Direction, Fault, FaultKind


def test_a_break_that_shows_late_that_it_cannot_be_is_not_counted():
    bench = Bench(Scheduler(), Journal())
    link = MemoryLink(bench.scheduler, Line(baud=9600), name="host")
    error, answers = UnavailableError("a break cannot be sent", where="it"), iter(["sent", "late", "at once"])

    def send_break(_duration_ns, refused):
        answer = next(answers)
        if answer == "at once":
            raise error
        if answer == "late":
            bench.scheduler.after(1000, lambda: refused(error), source="it")

    link.a.send_break = send_break
    tap, counts = Tap(bench, link.a, "station", seed=1), []
    for _ in range(3):
        tap.inject(Fault(kind=FaultKind.BREAK, at_s=0.0, duration_s=0.001, direction=Direction.A_TO_B))
        bench.run_for(0.1)
        counts.append(tap.struck["break", tap.towards(Direction.A_TO_B)])
    assert counts == [1, 1, 1]
    assert [event["kind"] for event in bench.journal.recent] == ["fault", "fault", "fault-refused", "fault-refused"]
