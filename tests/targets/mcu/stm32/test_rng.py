from __future__ import annotations

from fractions import Fraction

import pytest

from targets.mcu.stm32.rng import Rng
from targets.mcu.testing import FakeChip, peek, poke

RNGEN, IE, DRDY, CECS, CEIS = 4, 8, 1, 2, 32
FIRST, NEXT = 46 * 9 // 2, 42 * 9 // 2  # at 216 MHz and 48 MHz


@pytest.fixture
def chip():
    chip = FakeChip(hclk_hz=216_000_000)
    chip.clocks.kernels["RNG"] = Fraction(9, 2)
    return chip


@pytest.fixture
def rng(chip):
    return chip.add(Rng(0x5006_0800, chip.services, seed="nucleo"))


def numbers(rng, chip, count):
    found = []
    poke(rng, "CR", RNGEN)
    for _ in range(count):
        while not peek(rng, "SR") & DRDY:
            chip.advance(1)
        found.append(peek(rng, "DR"))
    return found


def test_the_first_number(rng, chip):
    poke(rng, "CR", RNGEN)
    chip.advance(FIRST - 1)
    assert peek(rng, "SR") == 0
    chip.advance(1)
    assert peek(rng, "SR") == DRDY
    assert peek(rng, "DR") != 0
    assert peek(rng, "SR") == 0


def test_the_next_ones(rng, chip):
    numbers(rng, chip, 1)
    before = chip.time.now
    numbers(rng, chip, 2)
    assert chip.time.now == before + 2 * NEXT


def test_a_number_waits(rng, chip):
    poke(rng, "CR", RNGEN)
    chip.advance(10 * FIRST)
    assert peek(rng, "SR") == DRDY
    poke(rng, "CR", 0)
    assert peek(rng, "DR") != 0
    chip.advance(10 * FIRST)
    assert peek(rng, "SR") == 0


def test_without_waiting_there_is_none(rng, chip):
    poke(rng, "CR", RNGEN)
    assert peek(rng, "DR") == 0
    assert chip.noted("misuse") == ["RNG_DR"]


def test_the_same_in_every_run_but_not_on_every_board(chip):
    def run(seed):
        return numbers(Rng(0x5006_0800, chip.services, seed=seed), chip, 8)

    assert run("a") == run("a") != run("b")
    assert len(set(run("a"))) == 8


def test_a_reset_goes_on_and_power_begins_anew(rng, chip):
    first = numbers(rng, chip, 3)
    rng.reset()
    assert peek(rng, "CR") == 0
    assert numbers(rng, chip, 3) != first
    rng.reset()
    rng.power_on()
    assert numbers(rng, chip, 3) == first


def test_bits_are_even(rng, chip):
    ones = sum(number.bit_count() for number in numbers(rng, chip, 1000))
    assert abs(ones - 16_000) < 500


def test_interrupt(rng, chip):
    poke(rng, "CR", RNGEN | IE)
    chip.advance(FIRST)
    assert chip.irq(80).level
    peek(rng, "DR")
    assert not chip.irq(80).level


@pytest.mark.parametrize("cycles", [Fraction(0), Fraction(33, 2)])
def test_a_clock_that_is_too_slow(rng, chip, cycles):
    chip.clocks.kernels["RNG"] = cycles
    poke(rng, "CR", RNGEN | IE)
    chip.advance(100_000)
    assert peek(rng, "SR") == CECS | CEIS
    assert chip.irq(80).level
    assert chip.noted("misuse") == ["RNG_SR.CECS"]
    chip.clocks.kernels["RNG"] = Fraction(16)
    chip.change_clock()
    poke(rng, "SR", 0xFFFF_FFFF)
    assert peek(rng, "SR") == CEIS
    poke(rng, "SR", 0)
    assert not chip.irq(80).level
    chip.advance(42 * 16)
    assert peek(rng, "SR") == DRDY
