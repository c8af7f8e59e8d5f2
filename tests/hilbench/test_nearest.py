"""What is said to somebody who wrote a name that does not exist."""

from __future__ import annotations

from hilbench.nearest import did_you_mean
from targets.mcu.variants import VARIANTS
from tests.each import each


@each(
    ("written", "meant"),
    [
        ("STM32F103RG", "STM32F103RE"),
        ("stm32f103re", "STM32F103RE"),
        ("STM32F103C8T6", "STM32F103C8"),
        ("stm32f103vet6", "STM32F103VE"),
        ("STM32F103ZF", "STM32F103ZE"),
        ("STM32F746ZG", "STM32F767ZG"),
    ],
)
def test_of_a_chip_that_is_not_there_the_nearest_that_is(written, meant):
    assert did_you_mean(written, VARIANTS, "chips") == f"did you mean '{meant}'?"


def test_a_name_that_begins_with_another_by_chance_does_not_mean_it():
    assert did_you_mean("firmware", ["f", "timing"], "known keys") == "known keys: f, timing"
