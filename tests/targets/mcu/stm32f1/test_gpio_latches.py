"""What is in C of a port of the STM32F1, against what Python makes of it."""

from __future__ import annotations

from hypothesis import given, settings
from hypothesis import strategies as st

from tests.share import examples
from tests.targets.mcu.stm32.latches import Script, actions

PUSH_PULL = 0b0011


def configure(pinout, number, nibble):
    pinout.mode(f"PB{number}", nibble)


@settings(max_examples=examples(150), deadline=None)
@given(script=actions(st.one_of(st.just(PUSH_PULL), st.integers(0, 15))))
def test_a_port_is_the_same_whether_somebody_looks_at_its_pins(make_pinout, script):
    script = [(0, ("configure", (number, PUSH_PULL))) for number in range(8)] + script
    one, other = (Script(make_pinout(), "B", configure, looks=looks) for looks in (False, True))
    assert one.run(script) == other.run(script)
