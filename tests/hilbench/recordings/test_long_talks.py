"""Judging twice as long a recording takes twice the work."""

from __future__ import annotations

import pytest

from hilbench.recordings.listening import Heard
from protocols import p2os, pkt

MS = 1_000_000
SYNCS = [p2os.encode_command(p2os.Command(number=number)) for number in range(3)]
IDENTIFICATION = p2os.encode_frame(p2os.Identification(name="desk", subclass="p2dx").encode())
OPEN = p2os.encode_command(p2os.Command(number=1))
DRIVING = p2os.encode_frame(p2os.Sip(moving=True, left_raw=100, right_raw=100).encode())
DECELERATION = p2os.encode_command(p2os.Command(number=p2os.CommandNumber.SETA, argument=-200))
REQUEST = pkt.encode_frame(pkt.encode_command(pkt.RequestTelemetry()))
REPORT = pkt.encode_frame(pkt.encode_report(pkt.GeneralReport(), pkt.Schema.V2))


def session(cycles):
    """A robot that drives, whose client sends a PULSE or a SETA in each cycle."""
    yield from ((0, "tx", SYNCS[0]), (20, "rx", SYNCS[0]), (50, "tx", SYNCS[1]), (70, "rx", SYNCS[1]))
    yield from ((100, "tx", SYNCS[2]), (150, "rx", IDENTIFICATION), (160, "tx", OPEN))
    for number in range(cycles):
        yield 250 + 100 * number, "rx", DRIVING
        yield 300 + 100 * number, "tx", SYNCS[0] if number % 2 else DECELERATION


def requests(cycles):
    for number in range(cycles):
        yield 100 * number, "tx", REQUEST
        yield 100 * number + 20, "rx", REPORT


@pytest.fixture
def looks(monkeypatch):
    """How often something was asked when it was heard, or who said it, in a list of one."""
    counted = [0]

    def counting(field):
        def look(heard):
            counted[0] += 1
            return field.__get__(heard)

        return property(look, field.__set__)

    for name in ("ns", "by"):
        monkeypatch.setattr(Heard, name, counting(vars(Heard)[name]))
    return counted


@pytest.mark.parametrize(("protocol", "talk"), [("p2os", session), ("pkt", requests)])
def test_twice_as_long_takes_twice_the_work(wrong, looks, protocol, talk):
    counts = []
    for cycles in (100, 200):
        looks[0] = 0
        assert wrong(protocol, [(ms * MS, way, data) for ms, way, data in talk(cycles)]) == []
        counts.append(looks[0])
    assert counts[1] < 2.2 * counts[0]
