"""The conformance check for links must fail on a link that breaks a promise."""

from __future__ import annotations

import pytest

from hilbench.clock import Scheduler
from hilbench.links import Line, MemoryLink
from hilbench.links.faults import Direction, Fault, FaultKind, FaultPlan
from hilbench.testing import FakeHostClock, LinkUnderTest, check_link, link_pair
from tests.each import each


def check(*, faults=(), baud=9600, claimed_baud=9600, corrupt=lambda link: None):
    def make_link():
        scheduler = Scheduler()
        link = MemoryLink(scheduler, Line(baud=baud), faults=FaultPlan(tuple(faults)))
        corrupt(link)
        return LinkUnderTest(scheduler=scheduler, a=link.a, b=link.b, baud=claimed_baud)

    check_link(make_link)


def test_a_good_link_passes():
    check()


@each("direction", list(Direction))
@each(
    ("fault", "complaint"),
    [
        ({"kind": FaultKind.DROP, "byte": 100}, "255 of 256 bytes arrived; the first difference is at 100"),
        ({"kind": FaultKind.FLIP, "byte": 7}, "the first difference is at 7"),
        ({"kind": FaultKind.DUPLICATE, "byte": 255}, "1 bytes were invented"),
        ({"kind": FaultKind.DROP, "byte": 1500}, "of 2000 bytes arrived"),
        ({"kind": FaultKind.DISCONNECT, "at_s": 0.001, "duration_s": 100}, "0 of 256 bytes arrived"),
    ],
)
def test_corruptt_bytes_are_found(direction, fault, complaint):
    with pytest.raises(AssertionError, match=complaint) as caught:
        check(faults=[Fault(direction=direction, **fault)])
    if fault["kind"] is not FaultKind.DISCONNECT:
        assert str(caught.value).startswith("a to b" if direction is Direction.A_TO_B else "b to a")


def test_too_fast_is_found():
    with pytest.raises(AssertionError, match="9600 baud need"):
        check(baud=9700)
    with pytest.raises(AssertionError, match="9600 baud need"):
        check(baud=0)


@each("end", ["a", "b"])
def test_a_hang_up_that_is_not_told_is_found(end):
    def corrupt(link):
        getattr(link, end).line_changed = lambda up: None

    with pytest.raises(AssertionError, match=f"link.{end} was not notified"):
        check(corrupt=corrupt)


def test_a_callback_that_is_not_called_is_found():
    def corrupt(link):
        port = link.a
        port._set_line = lambda up, at_ns: setattr(port, "line_is_up", up)

    with pytest.raises(AssertionError, match="on_line did not say so"):
        check(corrupt=corrupt)


def test_a_closed_port_that_swallows_bytes_is_found():
    def corrupt(link):
        write = link.b.write
        link.b.write = lambda data: None if link.b.closed else write(data)

    with pytest.raises(AssertionError, match="raised no PortClosedError"):
        check(corrupt=corrupt)


def test_a_line_that_never_comes_up_is_found():
    with pytest.raises(AssertionError, match="never came up"):
        check(corrupt=lambda link: link.a.line_changed(False))


def test_link_pair():
    scheduler = Scheduler()
    a, b = link_pair(scheduler, baud=9600)
    got = []
    b.on_receive = lambda data, at_ns: got.append((data, at_ns))
    a.write(b"x")
    scheduler.run_for(10**9)
    assert got == [(b"x", 1_041_666)]


def test_a_fake_host_does_not_wait_for_ever():
    with pytest.raises(AssertionError, match="waits for ever"):
        FakeHostClock().wait_until(None)
