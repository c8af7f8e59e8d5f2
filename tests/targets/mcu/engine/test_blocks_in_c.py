"""Registers that C answers for: the same as if every access went by Python, and what goes wrong there comes out."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from targets.mcu.bus import Bus
from targets.mcu.stm32f1.usart import Usart
from targets.mcu.testing import FakeChip

BASE = 0x4000_0000
BRR, CR1, CR3 = 0x08, 0x0C, 0x14
LOADS = {1: 0x7808, 2: 0x8808, 4: 0x6808}  # ldrb, ldrh, ldr of R0, [R1]
STORES = {1: 0x700A, 2: 0x800A, 4: 0x600A}  # strb, strh, str of R2, [R1]

ACCESSES = st.lists(
    st.tuples(st.booleans(), st.sampled_from((1, 2, 4)), st.integers(0, 0x1F), st.integers(0, 0xFFFF_FFFF)), max_size=20
)


class Rig:
    """A USART that is open at 8N1, a core, and what it has sent."""

    def __init__(self, make, *, through_python):
        self.chip = chip = FakeChip(hclk_hz=72_000_000)
        self.usart = usart = chip.add(Usart("USART1", BASE, chip.services, bus="APB2", irq=37))
        bus = Bus(chip.notes)
        bus.add(usart)
        self.machine = make(access=bus.window(BASE))
        self.engine = engine = self.machine.engine
        engine.live_in(chip.time)
        engine.attach(usart.in_c)
        engine.through_python = through_python
        self.sent = []
        usart.on_frame = lambda frame: self.sent.append((chip.time.now, frame.bits))
        for offset, value in ((BRR, 16), (CR1, 0x200C), (CR3, 0xC0)):
            usart.write(offset, value)

    def access(self, is_load, size, offset, value):
        """Execute one load or store; return what was read."""
        self.machine.load((LOADS if is_load else STORES)[size], 0xE7FE)
        self.engine.set(1, BASE + offset)
        self.engine.set(2, value)
        self.engine.run(1 << 40, 1)
        self.chip.time.run_due(self.engine.cycle)
        return self.engine.get(0)

    @property
    def state(self):
        registers = [self.usart[offset] for offset in range(0, 0x1C, 4)]
        return registers, self.sent, self.chip.irq(37).changes, self.chip.dma("USART1_TX").changes, self.chip.noted()


@given(ACCESSES)
def test_it_makes_no_difference_who_answers(make, accesses):
    in_c, in_python = (Rig(make, through_python=through) for through in (False, True))
    for access in accesses:
        assert in_c.access(*access) == in_python.access(*access)
    assert in_c.state == in_python.state


def test_without_its_clock_it_is_left_to_the_bus(make):
    rig = Rig(make, through_python=False)
    rig.usart.clocked = False
    rig.access(False, 4, 0x04, 0x55)
    assert rig.access(True, 4, 0x00, 0) == 0
    rig.chip.advance(10_000)
    assert not rig.sent
    assert rig.chip.noted("clock-off")


def test_what_a_listener_raises_ends_the_run_and_comes_out(make):
    def fail(_frame):
        raise LookupError("the listener")

    rig = Rig(make, through_python=False)
    rig.chip.advance(10_000)  # past the preamble
    rig.usart.on_frame = fail
    with pytest.raises(LookupError, match="the listener"):
        rig.access(False, 4, 0x04, 0x55)
    rig.engine.run(1 << 40, 1)  # and it is over with that


def test_what_a_listener_raises_at_an_event_comes_out_of_time(make):
    def fail(_data, _errors):
        raise LookupError("the listener")

    rig = Rig(make, through_python=False)
    rig.usart.on_word = fail
    rig.usart.receive(rig.usart.format.frame(0x41, rig.chip.time.seconds(rig.chip.time.now), 1 / rig.usart.baud_hz))
    with pytest.raises(LookupError, match="the listener"):
        rig.chip.advance(10_000)
    rig.chip.advance(10_000)
