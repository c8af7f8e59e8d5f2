"""Timers for a test: one, several with their signals between them, or one beside a slow one."""

from __future__ import annotations

import dataclasses

import pytest

from targets.mcu.pins import Pins
from targets.mcu.signals import Signals
from targets.mcu.stm32.tim import Timer
from targets.mcu.stm32.tim.kinds import KINDS
from targets.mcu.testing import FakeChip
from tests.targets.mcu.stm32.tim.side_by_side import Bench


@pytest.fixture(scope="session")
def make_bench():
    return Bench


@pytest.fixture
def bench():
    return Bench()


@pytest.fixture(scope="session")
def make_timer():
    """A chip in a test tube and one timer on it, its clock that of HCLK, 72 MHz."""

    def make(name, kinds=KINDS, **dividers):
        chip = FakeChip(72_000_000, dividers)
        return chip, chip.add(Timer(name, 0x4000_0000, chip.services, kinds[name]))

    return make


@pytest.fixture
def tim(make_timer):
    """A TIM2, as (chip, timer)."""
    return make_timer("TIM2")


@pytest.fixture(scope="session")
def make_timers():
    """Several timers on one chip, with all their signals between them."""

    def make(*names, kinds=KINDS):
        chip = FakeChip(72_000_000)
        pins = Pins((), chip.time, chip.notes)
        signals = Signals(pins)
        inside = {f"{name}_TRGO" for name in kinds}
        services = dataclasses.replace(
            chip.services,
            output=lambda name: signals.output(name) if name in inside else chip.output(name),
            input=lambda name: signals.input(name) if name in inside else chip.input(name),
        )
        timers = [
            chip.add(Timer(name, 0x4000_0000 + 0x400 * index, services, kinds[name]))
            for index, name in enumerate(names)
        ]
        return chip, *timers

    return make
