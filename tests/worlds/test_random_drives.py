"""Random drives in random rooms, by the program that drives a thousand of them (`python -m measure.random_drives`)."""

from __future__ import annotations

import pytest

from measure.random_drives import drive

SEEDS = (14, 29)
"""A rover and a Pioneer that run into something within a second and a half."""


@pytest.mark.parametrize("seed", SEEDS)
def test_nothing_gets_lost_goes_through_a_wall_or_creeps(physics, seed):
    done = drive(physics, seed, drive_s=1.5)
    assert done.problem == ""
    assert done.bumps > 0
