"""Cells in series: voltage by charge, sag, what is drawn, and the protection."""

from __future__ import annotations

import itertools

import pytest

from targets.parts import Ports
from targets.parts.battery import Battery, BatteryOff, BatterySettings, cell_volts

STEP_NS = 1_000_000_000


@pytest.fixture
def battery():
    def make(**settings):
        told = []
        part = Battery(BatterySettings(**settings), Ports(tell=told.append), seed=0)
        part.power_on(0)
        part.told = told
        return part

    return make


def draw(battery, current_a, seconds=1):
    """Draw a current for so many steps of a second; return what the battery gives in the last of them."""
    for _ in range(seconds):
        battery.feed({"current": current_a})
        given = battery.before_step(0, STEP_NS)
    return given


def test_two_full_cells_have_8_4_volts(battery):
    assert draw(battery(), 0.0) == pytest.approx({"emf": 8.4, "resistance": 0.12, "volts": 8.4})


def test_the_voltage_sags_with_the_current(battery):
    given = draw(battery(resistance_ohm=0.2), 1.5)
    assert given["volts"] == pytest.approx(8.4 - 0.2 * 1.5)
    assert given["emf"] == pytest.approx(8.4)


def test_charge_is_what_flows_times_time(battery):
    part = battery(capacity_ah=2.0)
    draw(part, 1.0, 3600)
    assert part.charge == pytest.approx(0.5)
    assert draw(part, 0.0)["emf"] == pytest.approx(2 * cell_volts(0.5), rel=1e-6)


def test_cells_fall_with_their_charge_from_4_2_to_3_volts():
    volts = [cell_volts(charge / 100) for charge in range(101)]
    assert (volts[0], volts[-1]) == (3.0, 4.2)
    assert all(less < more for less, more in itertools.pairwise(volts))
    assert cell_volts(0.5) == pytest.approx((3.70 + 3.84) / 2)


def test_below_its_cutoff_it_gives_nothing_more(battery):
    part = battery(charge=0.02, resistance_ohm=1.0)
    assert draw(part, 0.5)["volts"] > 5.0
    assert draw(part, 3.0) == {"emf": 0.0, "resistance": 1.0, "volts": 0.0}
    assert draw(part, 0.0)["volts"] == 0.0
    (off,) = part.told
    assert isinstance(off, BatteryOff)
    assert off.volts < 5.0
    part.power_on(0)
    assert draw(part, 0.0)["volts"] > 5.0


def test_it_is_never_more_than_full_nor_less_than_empty(battery):
    part = battery(capacity_ah=0.1, charge=0.9)
    draw(part, -5.0, 3600)
    assert part.charge == 1.0
    part = battery(capacity_ah=0.1, cutoff_v=0.0)
    draw(part, 5.0, 3600)
    assert part.charge == 0.0
    assert draw(part, 100.0)["volts"] == 0.0
