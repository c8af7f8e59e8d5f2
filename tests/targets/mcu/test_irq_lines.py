"""Several peripherals at one interrupt input."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from targets.mcu.irq_lines import IrqLines
from targets.mcu.services import drive_in_c
from targets.mcu.testing import FakeChip


@given(steps=st.lists(st.tuples(st.integers(0, 2), st.booleans()), max_size=20))
def test_the_input_is_the_or_of_its_lines(steps):
    chip = FakeChip()
    lines = IrqLines(chip.irq)
    sources, alone = [lines.line(24) for _ in range(3)], lines.line(25)
    levels = [False] * 3
    for index, level in steps:
        sources[index].set(level)
        levels[index] = level
        assert chip.irq(24).level is any(levels)
    assert not chip.irq(25).level
    alone.set(True)
    assert chip.irq(25).level


class Input:
    """An input of a core in C."""

    core = object()
    driven_in_c = False

    def set(self, level):
        self.level = level


def test_to_ask_who_drives_an_input_decides_nothing():
    lines = IrqLines(lambda _number: Input())
    first = lines.line(24)
    assert first.core is Input.core
    second = lines.line(24)
    assert (first.core, second.core) == (None, None)


def test_who_drives_an_input_in_c_drives_it_alone():
    lines = IrqLines(lambda _number: Input())
    shared, alone = [lines.line(24), lines.line(24)], [lines.line(25), lines.line(26)]
    assert drive_in_c([alone[0], shared[0]]) is None
    lines.line(25)
    assert drive_in_c(alone[1:]) is Input.core
    with pytest.raises(AssertionError, match="alone"):
        lines.line(26)


def test_an_input_that_the_core_lacks():
    def no_input(number):
        raise ValueError(number)

    with pytest.raises(ValueError, match="300"):
        IrqLines(no_input).line(300)
