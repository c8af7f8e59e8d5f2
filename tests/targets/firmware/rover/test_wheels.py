"""Wheel speeds from the times of the slots: RPM = 60 / (20 dt), as the manual has it."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from protocols.pkt import FrameReader, decode_report
from tests.each import each
from tests.share import examples

LEFT_FRONT, RIGHT_FRONT, LEFT_BACK, RIGHT_BACK = range(4)


class Bench:
    """A rover whose wheels turn evenly."""

    def __init__(self, rover, image="rover", **options):
        self.chip = rover(image, sensors=False, **options)

    def turn(self, rpm, seconds, wheels=range(4), slots=20):
        period_s = 60 / (slots * rpm)
        for _ in range(max(1, round(seconds / period_s))):
            self.chip.run(period_s)
            for wheel in wheels:
                self.chip.turn(wheel)
        self.last_us = self.chip.now_us
        return self

    @property
    def rpm(self):
        """Of the left front wheel, now."""
        self.chip.code.call("tachometer_rpm", LEFT_FRONT)
        return self.chip.code.float_result

    @property
    def report(self):
        """The latest report of motion."""
        payloads = [frame.payload for frame in FrameReader().receive(self.chip.fetch(), 0)]
        return [decode_report(payload) for payload in payloads if payload[0] == 0x83][-1]


@settings(max_examples=examples(15))
@given(rpm=st.floats(12.1, 990.0))
def test_an_even_speed_is_shown(rover_factory, rpm):
    report = Bench(rover_factory).turn(rpm, 1.0).report
    assert report.rpm == pytest.approx((rpm,) * 4, rel=1e-3)


def test_slots_are_counted_wheel_by_wheel(rover):
    bench = Bench(rover)
    for wheel in range(4):
        bench.turn(100, 0.3, wheels=range(wheel + 1))
    bench.chip.run(0.3)
    assert bench.report.ticks == (40, 30, 20, 10)


def test_a_wheel_that_stops_is_as_slow_as_its_last_slot_is_old(rover):
    """At 100 rpm a slot is due after 30 ms."""
    bench = Bench(rover).turn(100, 0.5)
    chip = bench.chip
    for age_s in (0.1, 0.3, 0.9):
        chip.run(age_s - (chip.now_us - bench.last_us) / 1e6)
        slowest = 60 / (20 * age_s)
        assert slowest <= bench.rpm <= slowest * (1 + 0.06 / age_s)  # two readings of 20 ms, and one on the way
    chip.run(0.4)
    assert bench.report.rpm == (0.0,) * 4


@each("image", ["rover-rpm-held", "rover-g2"])
def test_a_wheel_that_stops_goes_on_being_shown_for_a_second(rover, image):
    bench = Bench(rover, image).turn(100, 0.5)
    bench.chip.run(0.95)
    assert bench.report.rpm == pytest.approx((100.0,) * 4, rel=1e-3)
    bench.chip.run(0.35)
    assert bench.report.rpm == (0.0,) * 4


def test_the_first_slot_after_a_stop_says_nothing(rover):
    bench = Bench(rover).turn(100, 0.5)
    bench.chip.run(5.0)
    bench.chip.turn(LEFT_FRONT)
    bench.chip.run(0.3)
    assert bench.report.rpm == (0.0,) * 4


def test_below_three_rpm_nothing_is_seen(rover):
    assert Bench(rover).turn(3.1, 4.0).report.rpm == pytest.approx((3.1,) * 4, rel=1e-3)
    assert Bench(rover).turn(2.9, 4.0).report.rpm == (0.0,) * 4


def test_above_a_thousand_rpm_is_a_bounce(rover):
    assert Bench(rover).turn(1100, 0.3).report.rpm == (0.0,) * 4


def test_one_bounce_does_not_pass_the_median(rover):
    """At 300 rpm a slot passes every 10 ms, so that a bounce spoils one reading at most."""
    bench = Bench(rover).turn(300, 0.5)
    bench.chip.run(0.0001)
    bench.chip.turn(LEFT_FRONT)
    for _ in range(10):
        assert bench.rpm == pytest.approx(300, rel=0.02)
        bench.turn(300, 0.01)


def test_fast_wheels_are_shown(rover):
    assert Bench(rover).turn(180, 0.5).report.rpm == pytest.approx((180.0,) * 4, rel=1e-3)
    for image in ("rover-rpm-150", "rover-g2"):
        assert Bench(rover, image).turn(180, 0.5).report.rpm == (0.0,) * 4
        assert Bench(rover, image).turn(140, 0.5).report.rpm == pytest.approx((140.0,) * 4, rel=1e-3)


def test_slots_of_the_wrong_disc(rover):
    assert Bench(rover, "rover-slots-32").turn(160, 0.5).report.rpm == pytest.approx((100.0,) * 4, rel=1e-3)


def test_time_wraps_after_71_minutes(rover):
    bench = Bench(rover, at_us=2**32 - 300_000).turn(100, 0.6)
    assert bench.chip.now_us > 2**32
    assert bench.report.rpm == pytest.approx((100.0,) * 4, rel=1e-3)


def test_a_wheel_that_stood_for_71_minutes_has_not_moved(rover):
    """The age of its last slot has wrapped, and a new one must not look like a turn at speed."""
    bench = Bench(rover).turn(100, 0.5)
    bench.chip.run(2.0)
    bench.chip.now_us += 2**32 - 2_000_000 - 20_000
    bench.chip.turn(LEFT_FRONT)
    bench.chip.code.call("tachometer_update", bench.chip.now_us)
    assert bench.rpm == 0.0


def test_a_side_is_as_fast_as_its_slower_wheel_and_has_the_sign_of_its_throttle(rover):
    bench = Bench(rover)
    for _ in range(10):
        bench.turn(100, 0.03, wheels=[LEFT_BACK])
        bench.turn(100, 0.03)
    side_rpm = []
    for side in (0, 1):
        bench.chip.code.call("tachometer_side_rpm", side)
        side_rpm.append(bench.chip.code.float_result)
    assert side_rpm == pytest.approx([50.0, 50.0], rel=1e-3)
