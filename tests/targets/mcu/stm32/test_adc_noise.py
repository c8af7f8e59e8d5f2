"""Noise of the converters: off unless a board asks for it, then with its deviation, and the same in every run."""

from __future__ import annotations

import dataclasses
import statistics

import pytest

from targets.boards import built_in_board
from targets.firmware import image_path
from targets.mcu.chip_limits import limits_for
from targets.mcu.image import load_image
from targets.mcu.machine import Machine
from targets.mcu.pins import Source
from targets.mcu.stm32.adc_noise import QUIET, AdcNoise
from targets.mcu.testing import peek, poke

COUNT = 200


def test_a_quiet_converter_is_left_alone():
    def volts(_channel):
        return 1.0

    assert QUIET.on("ADC1", volts) is volts


def test_the_sequences():
    """Normal with the given deviation; another for each converter and seed, the same when made anew."""

    def draw(seed, converter):
        sample = AdcNoise(0.01, seed).on(converter, float)
        return [sample(3) for _ in range(4000)]

    first = draw("a board", "ADC1")
    assert first == draw("a board", "ADC1")
    assert first not in (draw("a board", "ADC2"), draw("another", "ADC1"))
    assert statistics.mean(first) == pytest.approx(3.0, abs=0.001)
    assert statistics.stdev(first) == pytest.approx(0.01, rel=0.05)


def readings(noise_lsb):
    """What ADC1 of a Blue Pill reads of half the supply at PA1."""
    board = dataclasses.replace(built_in_board("bluepill"), adc_noise_lsb=noise_lsb)
    machine = Machine(board, load_image(image_path("bench-tick-1khz"), limits_for(board.chip)))
    chip = machine.chip
    chip.reset("POR")
    poke(chip.rcc, "APB2ENR", 1 << 9)
    chip.pins["PA1"].set_source("test", Source(1.65, 1.0))
    adc = chip.adcs["ADC1"]
    poke(adc, "SQR3", 1)
    poke(adc, "CR2", 1)
    found = []
    for _ in range(COUNT):
        poke(adc, "CR2", 1)
        machine.time.run_due(machine.time.now + 100)
        found.append(peek(adc, "DR"))
    return found


def test_of_a_chip():
    assert readings(0.0) == [2048] * COUNT
    noisy = readings(3.0)
    assert noisy == readings(3.0)
    assert statistics.mean(noisy) == pytest.approx(2048, abs=1)
    assert statistics.stdev(noisy) == pytest.approx(3, rel=0.2)


@pytest.mark.parametrize("family", ["f767", "h753"])
def test_of_other_families(family):
    board = dataclasses.replace(built_in_board(f"nucleo-{family}zi"), adc_noise_lsb=2.0)
    machine = Machine(board, load_image(image_path(f"{family}-demo"), limits_for(board.chip)))
    unit = machine.chip.peripherals["ADC" if family == "f767" else "ADC12"]._units[0]
    machine.chip.pins["PA3"].set_source("test", Source(1.65, 1.0))
    channel = 3 if family == "f767" else 15
    volts = [unit._ends.volts(channel) for _ in range(COUNT)]
    assert statistics.stdev(volts) == pytest.approx(2 * 3.3 / 4096, rel=0.2)
