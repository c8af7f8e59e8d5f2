"""What the tests of the manual's timing diagrams have in common: registers by name, and a look at each tick."""

from __future__ import annotations

from targets.mcu.testing import peek, poke


def setup(timer, **registers):
    for name, value in registers.items():
        poke(timer, name, value)


def counts(chip, timer, ticks):
    """The counter now and after each of so many ticks."""
    seen = [peek(timer, "CNT")]
    for _ in range(ticks):
        chip.advance(1)
        seen.append(peek(timer, "CNT"))
    return seen


def flagged(chip, timer, ticks, flag):
    """The ticks, of so many, at which a flag is set, if it is cleared each time."""
    seen = []
    for _ in range(ticks):
        chip.advance(1)
        if peek(timer, "SR") & flag:
            seen.append(chip.time.now)
            poke(timer, "SR", ~flag & 0xFFFF)
    return seen
