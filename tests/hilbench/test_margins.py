"""How much time was left of timers: what is kept of a case, and when it goes into its journal."""

from __future__ import annotations

import enum
from dataclasses import dataclass, field

from hilbench.bench import Bench
from hilbench.bench.margins import MOST_POINTS, Margins
from hilbench.bench.state_reporter import Sense
from hilbench.check.bench_provider import make_provider
from hilbench.clock import NS_PER_MS, Scheduler
from hilbench.journal import Journal
from hilbench.judging.provider import CaseInfo
from hilbench.recordings.event_form import wrong_with
from hilbench.terminal.options import CheckOptions
from tests.each import each


class Timers(enum.Enum):
    """The timers of something that is looked at."""

    FED = "a watchdog"
    WAIT = "for something"
    REST = "for a while"


@dataclass
class Looked:
    """Something that is looked at, as a test wants it to be."""

    deadlines: dict = field(default_factory=dict)


class Kept:
    """Margins of a machine on a bench, and what they say at the end."""

    def __init__(self):
        self.bench = Bench(Scheduler(), Journal())
        self.looked = Looked()
        senses = {"it": {"WAIT": Sense.WAIT, "REST": Sense.REST}}
        self.margins = Margins(self.bench, lambda: {"it": self.looked}, senses)

    def after(self, ms, timer, span_ms=None):
        """Set a timer for so long, or end it, after so long."""
        self.bench.run_for(ms / 1000)
        self.looked.deadlines.pop(timer, None)
        if span_ms is not None:
            self.looked.deadlines[timer] = self.bench.now_ns + span_ms * NS_PER_MS
        self.bench.on_settled()

    def told(self):
        self.margins.end()
        self.margins.record()
        events = [event for event in self.bench.journal.recent if event["kind"] == "margins"]
        return {(event["source"], event["timer"]): event["points"] for event in events}


def in_ms(points):
    return [[ns / NS_PER_MS for ns in point] for point in points]


def test_a_watchdog_has_what_was_left_when_it_was_fed_and_zero_when_it_ran_out():
    kept = Kept()
    kept.after(0, Timers.FED, 100)
    kept.after(30, Timers.FED, 200)  # 70 left of 100
    kept.after(200, Timers.FED)  # ran out
    kept.after(5, Timers.FED, 100)
    kept.after(50, Timers.FED)  # ended by somebody
    assert in_ms(kept.told()["it", "FED"]) == [[30, 70, 100], [230, 0, 200]]


def test_what_was_waited_for_has_a_margin_and_a_rest_has_none():
    kept = Kept()
    kept.after(0, Timers.WAIT, 100)
    kept.after(0, Timers.REST, 100)
    kept.after(40, Timers.WAIT)
    kept.after(80, Timers.REST)
    assert {timer: in_ms(points) for timer, points in kept.told().items()} == {("it", "WAIT"): [[40, 60, 100]]}


def test_of_very_many_points_the_least_are_kept():
    kept = Kept()
    for number in range(5 * MOST_POINTS):
        kept.after(1 if number != 1234 else 9, Timers.FED, 10)
    points = kept.told()["it", "FED"]
    assert MOST_POINTS // 2 <= len(points) <= MOST_POINTS
    assert [left_ns for _, left_ns, _ in points].count(NS_PER_MS) == 1
    assert points == sorted(points)


def test_a_machine_that_cannot_be_looked_at_costs_nobody_anything():
    kept = Kept()
    kept.after(0, Timers.FED, 100)
    kept.after(30, Timers.FED, 100)
    kept.looked.deadlines[Timers.REST] = "soon"
    kept.after(30, Timers.FED, 100)
    assert in_ms(kept.told()["it", "FED"]) == [[30, 70, 100]]


def test_no_time_is_one_that_a_reader_would_refuse():
    kept = Kept()
    for deadline_ns in (-5, 2**80, 0.5, 10**6):
        kept.looked.deadlines[Timers.FED] = deadline_ns
        kept.bench.on_settled()
    assert len(kept.told()["it", "FED"]) == 3
    assert [wrong_with(event) for event in kept.bench.journal.recent] == [""]


def of_case(verdict, *, keep=True):
    """Return the margins of a case of a robot that ends with a verdict, and its hash."""
    provider = make_provider(CheckOptions(bench="pioneer-plane"))
    info = CaseInfo(id="suite/it", clause_ids=("X",), seed=1, needs=frozenset({"server"}))
    with provider.open_case(info) as case:
        if keep:
            case.keep_margins()
        case.peer.start()
        for _ in range(3):
            case.bench.run_for(0.5)
            case.peer.send(0)
        case.bench.run_for(2.5)
        case.finish(verdict, "because")
        found = [event for event in case.journal.recent if event["kind"] == "margins"]
        kinds = [event["kind"] for event in case.journal.recent]
        hashed = case.case_hash()
    provider.close()
    return found, kinds, hashed


def test_a_case_that_does_not_pass_tells_them_behind_its_verdict_and_outside_of_its_hash():
    (event,), kinds, hashed = of_case("fail")
    assert (event["source"], event["timer"]) == ("robot", "WATCHDOG")
    assert [round(left_ns / NS_PER_MS) for _, left_ns, _ in event["points"][-3:]] == [1500, 1500, 0]
    assert {span_ns for _, _, span_ns in event["points"]} == {2000 * NS_PER_MS}
    assert kinds[-3:] == ["verdict", "margins", "case-end"]
    assert of_case("fail", keep=False)[1:] == ([kind for kind in kinds if kind != "margins"], hashed)


@each("verdict", ["pass", "not-applicable"])
def test_a_case_that_is_not_told_has_none(verdict):
    assert of_case(verdict)[0] == []
