"""Noise of a converter's readings, where a board has it (`Board.adc_noise_lsb`): normal, and the same in every run.

It is added to the voltage that is sampled (choice: on silicon reference, source and comparator share in it), so a code
at an end of the range stays there. Each converter has a sequence of its own, which goes on over resets (choice).
"""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import dataclass

__all__ = ["ADC_STEPS", "QUIET", "AdcNoise"]

ADC_STEPS = 1 << 12
"""In the range of the 12 bits in which `Board.adc_noise_lsb` is given."""


@dataclass(frozen=True, slots=True)
class AdcNoise:
    """The noise of a board's converters.

    Attributes:
        rms_volts: its standard deviation.
        seed: what its sequences are made of, with the name of the converter.
    """

    rms_volts: float = 0.0
    seed: str = ""

    def on(self, converter: str, volts: Callable[[int], float]) -> Callable[[int], float]:
        """Return what a converter samples that is connected to `volts`, the voltage by channel."""
        if not self.rms_volts:
            return volts
        gauss = random.Random(f"{self.seed} {converter}").gauss
        return lambda channel: volts(channel) + gauss(0.0, self.rms_volts)


QUIET = AdcNoise()
"""None."""
