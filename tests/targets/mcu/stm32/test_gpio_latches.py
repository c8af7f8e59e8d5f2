"""What is in C of a port with a multiplexer for each pin, against what Python makes of it."""

from __future__ import annotations

import functools
import itertools

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from targets.mcu.testing import peek, poke
from tests.share import examples
from tests.targets.mcu.stm32.latches import Script, actions

CONFIGURATIONS = st.tuples(st.sampled_from([1, 1, 1, 0, 2, 3]), st.integers(0, 1), st.integers(0, 3))


def configure(pinout, number, how, letter="K"):
    port, (mode, open_drain, pull) = pinout.ports[letter], how
    for register, width, value in (("OTYPER", 1, open_drain), ("PUPDR", 2, pull), ("MODER", 2, mode)):
        field = (1 << width) - 1 << width * number
        poke(port, register, peek(port, register) & ~field | value << width * number)


@settings(max_examples=examples(150), deadline=None)
@given(script=actions(CONFIGURATIONS), letter=st.sampled_from("CK"))
def test_a_port_is_the_same_whether_somebody_looks_at_its_pins(make_pinout, script, letter):
    """Port C has sixteen pins, port K eight, and the package none of them."""
    script = [(0, ("configure", (number, (1, 0, 0)))) for number in range(8)] + script
    act = functools.partial(configure, letter=letter)
    one, other = (Script(make_pinout(), letter, act, looks=looks) for looks in (False, True))
    assert one.run(script) == other.run(script)


@pytest.mark.parametrize("letter", "AK")
def test_python_is_not_asked_for_outputs_that_nobody_looks_at(pinout, letter):
    port = pinout.ports[letter]
    port.bank._set_latches = lambda _latches: pytest.fail("asked")
    for number in range(8):
        configure(pinout, number, (1, 0, 0), letter)
    pinout.pins[f"P{letter}3"].record()
    for value in range(0x100):
        poke(port, "ODR", value)
        assert peek(port, "IDR") & 0xFF == value
        pinout.chip.advance(3)
    edges = pinout.pins[f"P{letter}3"].take_edges()
    assert [edge.level for edge in edges] == [True, *[False, True] * 15]
    assert {later.cycle - edge.cycle for edge, later in itertools.pairwise(edges)} == {24}
