"""Firing order, firing times, and readings that are listed once."""

from __future__ import annotations

import dataclasses

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from targets.robots.pioneer.settings import RobotSettings
from targets.robots.pioneer.sonar import MOST_PER_SIP, SonarArrays

MS = 1_000_000
FRONT = RobotSettings()
BOTH = dataclasses.replace(FRONT, sonar_discs=tuple(range(16)))


class Discs:
    def __init__(self) -> None:
        self.fired: list[int] = []

    def __call__(self, disc: int) -> float | None:
        self.fired.append(disc)
        return None if disc == 7 else 1.0 + disc / 10


def turns(arrays: SonarArrays, count: int) -> None:
    for _ in range(count):
        arrays.advance()


def test_one_disc_of_each_array_every_40_ms() -> None:
    discs = Discs()
    arrays = SonarArrays(BOTH, discs)
    assert arrays.next_deadline_ns() is None
    arrays.switch(True, 5 * MS)
    deadlines = []
    for _ in range(8):
        deadlines.append(arrays.next_deadline_ns())
        arrays.advance()
    assert deadlines == [(5 + 40 * n) * MS for n in range(1, 9)]
    assert discs.fired == [disc for pair in zip(range(8), range(8, 16), strict=True) for disc in pair]


def test_readings_are_listed_once_with_their_distance() -> None:
    arrays = SonarArrays(FRONT, Discs())
    arrays.switch(True, 0)
    turns(arrays, 8)
    echoes = arrays.take_fresh()
    assert [echo.disc for echo in echoes] == list(range(8))
    assert echoes[3].range_mm == pytest.approx(1300.0)
    assert echoes[7].range_mm == FRONT.sonar_no_echo_mm
    assert arrays.take_fresh() == ()


@given(numbers=st.binary(max_size=40), count=st.integers(1, 60))
@settings(deadline=None)
def test_polling_fires_exactly_what_is_named_in_order(numbers: bytes, count: int) -> None:
    discs = Discs()
    arrays = SonarArrays(FRONT, discs)
    arrays.switch(True, 0)
    arrays.poll(numbers)
    turns(arrays, count)
    named = [number - 1 for number in numbers if 1 <= number <= 8][:16]
    sequence = named or ([] if not numbers else list(range(8)))
    assert discs.fired == [sequence[k % len(sequence)] for k in range(count) if sequence]
    assert len(arrays.take_fresh()) <= MOST_PER_SIP


def test_an_empty_string_silences_until_sonar_is_switched_on_again() -> None:
    discs = Discs()
    arrays = SonarArrays(FRONT, discs)
    arrays.switch(True, 0)
    arrays.poll(bytes((2, 2, 1)))
    arrays.poll(b"")
    turns(arrays, 5)
    assert discs.fired == []
    arrays.switch(True, 0)
    turns(arrays, 3)
    assert sorted(discs.fired) == [0, 1, 1]


def test_a_disc_that_is_not_fitted_is_silent() -> None:
    discs = Discs()
    arrays = SonarArrays(FRONT, discs)
    arrays.switch(True, 0)
    arrays.poll(bytes((9, 10, 1)))
    turns(arrays, 4)
    assert discs.fired == [0, 0, 0, 0]


def test_switching_off_discards_and_on_starts_over() -> None:
    discs = Discs()
    arrays = SonarArrays(FRONT, discs)
    arrays.switch(True, 0)
    turns(arrays, 3)
    arrays.switch(False, 100 * MS)
    assert not arrays.on
    assert arrays.take_fresh() == ()
    arrays.switch(True, 200 * MS)
    assert arrays.next_deadline_ns() == 240 * MS
    turns(arrays, 1)
    assert discs.fired == [0, 1, 2, 0]


def test_no_more_than_sixteen_readings_at_a_time_and_none_lost() -> None:
    many = dataclasses.replace(FRONT, subclass="p2pb", sonar_discs=tuple(range(24)))
    arrays = SonarArrays(many, Discs())
    arrays.switch(True, 0)
    turns(arrays, 8)
    first, second = arrays.take_fresh(), arrays.take_fresh()
    assert (len(first), len(second)) == (16, 8)
    assert {echo.disc for echo in first + second} == set(range(24))
