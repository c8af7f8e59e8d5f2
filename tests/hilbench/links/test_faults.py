from __future__ import annotations

from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hilbench.clock import Scheduler
from hilbench.errors import UnavailableError, UsageError
from hilbench.links import Line, MemoryLink
from hilbench.links.faults import Direction, Fault, FaultKind, FaultPlan, FaultyPort
from tests.each import each
from tests.share import examples

S = 10**9
BYTE_NS = 1_041_666


def run(*faults, data=b"abcdefgh", seed=0, wrap=False, direction=Direction.A_TO_B):
    """Send data over a line of 9600 baud with faults; return what came, when, and the two ends."""
    scheduler = Scheduler()
    plan = FaultPlan(faults, seed=seed)
    link = MemoryLink(scheduler, Line(baud=9600), faults=None if wrap else plan)
    a = FaultyPort(scheduler, link.a, plan) if wrap else link.a
    sender, receiver = (a, link.b) if direction is Direction.A_TO_B else (link.b, a)
    got, lines = [], []
    receiver.on_receive = lambda data, at_ns: got.append((data, at_ns))
    receiver.on_line = lambda up, at_ns: lines.append((up, at_ns))
    struck = []
    plan.on_fault = lambda fault, way, at_ns: struck.append((fault.kind, way))
    sender.write(data)
    scheduler.run_for(2 * S)
    sender.write(b"!")
    scheduler.run_for(S)
    return b"".join(data for data, _ in got), got, receiver, lines, struck


EXPECTED = [
    (Fault(kind=FaultKind.DROP, byte=2, count=3), b"abfgh!"),
    (Fault(kind=FaultKind.FLIP, byte=0, bit=5), b"Abcdefgh!"),
    (Fault(kind=FaultKind.DUPLICATE, byte=1, count=2), b"abbccdefgh!"),
    (Fault(kind=FaultKind.TRUNCATE, byte=3), b"abc!"),
    (Fault(kind=FaultKind.DROP, at_s=1.0), b"abcdefgh"),
    (Fault(kind=FaultKind.DELAY, byte=4, duration_s=0.5), b"abcdefgh!"),
    (Fault(kind=FaultKind.DROP, probability=1.0), b""),
    (Fault(kind=FaultKind.DROP, probability=0.0), b"abcdefgh!"),
]


@pytest.mark.parametrize("wrap", [False, True])
@pytest.mark.parametrize(("fault", "expected"), EXPECTED)
def test_bytes(fault, expected, wrap):
    assert run(fault, wrap=wrap)[0] == expected


@pytest.mark.parametrize("wrap", [False, True])
def test_the_other_wire(wrap):
    fault = Fault(kind=FaultKind.DROP, byte=0, direction=Direction.B_TO_A)
    assert run(fault, wrap=wrap, direction=Direction.B_TO_A)[0] == b"bcdefgh!"
    assert run(fault, wrap=wrap)[0] == b"abcdefgh!"


def test_time_on_the_wire():
    lost = run(Fault(kind=FaultKind.DROP, byte=0))[1]
    assert lost[0] == (b"b", 2 * BYTE_NS)
    delayed = run(Fault(kind=FaultKind.DELAY, byte=1, duration_s=0.5))[1]
    assert delayed[1] == (b"b", 2 * BYTE_NS + S // 2)
    noisy = run(Fault(kind=FaultKind.NOISE, byte=1, count=3))[1]
    assert len(noisy) == 12
    assert noisy[-2][1] == pytest.approx(11 * BYTE_NS, abs=20)
    spacing = [later - sooner for (_, sooner), (_, later) in pairwise(noisy[:11])]
    assert min(spacing) >= BYTE_NS


@settings(max_examples=examples(30))
@given(st.integers(0, 2**32), st.floats(0, 1))
def test_chance_is_decided_by_the_seed(seed, probability):
    faults = [Fault(kind=kind, probability=probability, count=2) for kind in (FaultKind.DROP, FaultKind.NOISE)]
    assert run(*faults, seed=seed)[1] == run(*faults, seed=seed)[1]


def test_seeds_differ():
    fault = Fault(kind=FaultKind.DROP, probability=0.5)
    data = bytes(range(200))
    results = {run(fault, seed=seed, data=data)[0] for seed in range(5)}
    assert len(results) == 5
    assert all(60 < len(result) < 140 for result in results)


@pytest.mark.parametrize("wrap", [False, True])
def test_disconnection(wrap):
    fault = Fault(kind=FaultKind.DISCONNECT, at_s=0.0035, duration_s=1)
    direction = Direction.B_TO_A
    data, _, _, lines, struck = run(fault, wrap=wrap, direction=direction)
    assert data == b"abc!"
    assert lines == [(False, 3_500_000), (True, 1_003_500_000)]
    assert struck == [(FaultKind.DISCONNECT, Direction.A_TO_B)]


@pytest.mark.parametrize("wrap", [False, True])
def test_break(wrap):
    receiver = run(Fault(kind=FaultKind.BREAK, at_s=0.5, duration_s=0.01), wrap=wrap)[2]
    assert receiver.counters.breaks == 1
    receiver = run(
        Fault(kind=FaultKind.BREAK, at_s=0.5, duration_s=0.01, direction=Direction.B_TO_A),
        wrap=wrap,
        direction=Direction.B_TO_A,
    )[2]
    assert receiver.counters.breaks == 1


@pytest.mark.parametrize("wrap", [False, True])
def test_a_sender_at_the_wrong_rate(wrap):
    data = run(Fault(kind=FaultKind.BAUD, at_s=0, duration_s=1.5, baud=14_400), wrap=wrap)[0]
    assert data[-1:] == b"!"
    assert b"abcdefgh" not in data


@each(
    ("fields", "complaint"),
    [
        ({"kind": FaultKind.DROP}, "exactly one"),
        ({"kind": FaultKind.DROP, "byte": 1, "at_s": 1.0}, "exactly one"),
        ({"kind": FaultKind.BREAK, "byte": 1}, "at_s"),
        ({"kind": FaultKind.DROP, "probability": 1.1}, "range"),
        ({"kind": FaultKind.DROP, "byte": -1}, "range"),
        ({"kind": FaultKind.FLIP, "byte": 1, "bit": 8}, "bit"),
        ({"kind": FaultKind.BAUD, "at_s": 1.0}, "baud"),
    ],
)
def test_nonsense_is_refused(fields, complaint):
    with pytest.raises(UsageError, match=complaint):
        Fault(**fields)


def test_a_wrapped_port_is_a_port():
    scheduler = Scheduler()
    link = MemoryLink(scheduler, Line(baud=9600))
    port = FaultyPort(scheduler, link.a, FaultPlan(()))
    port.baud = 19_200
    assert link.a.baud == port.baud == 19_200
    link.b.on_break = lambda at_ns: None
    port.send_break(1000)
    scheduler.run_for(S)
    assert link.b.counters.breaks == 1
    port.close()
    port.close()
    assert link.a.closed


BREAKS = (
    Fault(kind=FaultKind.BREAK, at_s=1.0, duration_s=0.1),
    Fault(kind=FaultKind.BREAK, at_s=1.0, duration_s=0.1, direction=Direction.B_TO_A),
    Fault(kind=FaultKind.FLIP, probability=1.0),
)


def test_a_break_that_shows_late_that_it_cannot_be_has_not_struck():
    """As at a real port whose driver knows none, while bytes are on the way; whoever asked for it is told."""
    scheduler = Scheduler()
    link, asked = MemoryLink(scheduler, Line(baud=9600)), []

    def send_break(duration_ns, refused):
        asked.append(duration_ns)
        if len(asked) > 1:
            error = UnavailableError("a break cannot be sent", where="it")
            scheduler.after(1000, lambda: refused(error), source="it")

    link.a.send_break = send_break
    plan, told = FaultPlan((BREAKS[0], BREAKS[0])), []
    plan.on_refused = lambda fault, reason, at_ns: told.append((reason, at_ns))
    port = FaultyPort(scheduler, link.a, plan)
    scheduler.run_for(2 * S)
    assert told == [("it: a break cannot be sent", S + 1000)]
    port.send_break(1000, lambda error: told.append(str(error)))
    scheduler.run_for(S)
    assert told[1:] == ["it: a break cannot be sent"]


def test_a_line_that_is_closed_has_no_faults():
    scheduler = Scheduler()
    port = FaultyPort(scheduler, MemoryLink(scheduler, Line(baud=9600)).a, FaultPlan(BREAKS))
    port.close()
    scheduler.run_for(2 * S)
    assert port.counters.breaks == 0


def test_a_port_that_was_left_is_sound():
    scheduler = Scheduler()
    link = MemoryLink(scheduler, Line(baud=9600))
    plan = FaultPlan(BREAKS)
    struck = []
    plan.on_fault = lambda fault, way, at_ns: struck.append(at_ns)
    port = FaultyPort(scheduler, link.a, plan)
    port.write(b"lost")
    port.detach()
    struck.clear()
    got = []
    link.b.on_receive = lambda data, at_ns: got.append(data)
    link.a.write(b"abc")
    scheduler.run_for(2 * S)
    assert (b"".join(got), struck, link.b.counters.breaks) == (b"abc", [], 0)


def test_faults_go_on_when_the_line_is_opened_again():
    scheduler = Scheduler()
    first, second = (MemoryLink(scheduler, Line(baud=9600)) for _ in range(2))
    port = FaultyPort(scheduler, first.a, FaultPlan((Fault(kind=FaultKind.FLIP, byte=3, bit=5),)))
    got = []
    for link in (first, second):
        link.b.on_receive = lambda data, at_ns: got.append(data)
    port.write(b"ab")
    scheduler.run_for(S)
    port.close()
    port.reopen(second.a)
    port.write(b"cdef")
    scheduler.run_for(S)
    assert b"".join(got) == b"abcDef"


def test_times_count_from_the_epoch():
    scheduler = Scheduler()
    scheduler.run_for(5 * S)
    faults = (Fault(kind=FaultKind.DROP, at_s=0.5), Fault(kind=FaultKind.BREAK, at_s=1.0, duration_s=0.1))
    plan = FaultPlan(faults, epoch_ns=5 * S)
    struck = []
    plan.on_fault = lambda fault, way, at_ns: struck.append((fault.kind, at_ns))
    link = MemoryLink(scheduler, Line(baud=9600), faults=plan)
    link.a.write(b"a")
    scheduler.run_for(S // 2)
    link.a.write(b"b")
    scheduler.run_for(S)
    assert struck == [(FaultKind.DROP, 5 * S + S // 2), (FaultKind.BREAK, 6 * S)]
