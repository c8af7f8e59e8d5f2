"""ADC1 in C does to the cycle what it did in Python, whatever is written when, and while voltages and clocks change."""

from __future__ import annotations

from fractions import Fraction

from hypothesis import given, settings
from hypothesis import strategies as st

from targets.mcu.pins import Pin
from targets.mcu.stm32.converters import Ends
from targets.mcu.stm32f1.adc import CHANNELS
from tests.share import examples
from tests.targets.mcu.stm32f1.adc.former import Former

CR1, CR2, DR = 0x04, 0x08, 0x4C
BY_SOFTWARE, TSVREFE, DUALMOD = 0x001E_F000, 1 << 23, 0xF << 16
CYCLES = st.integers(1, 60) | st.integers(1, 4000)

AROUND = st.one_of(
    st.tuples(st.just("wait"), CYCLES),
    st.tuples(st.just("rate"), st.sampled_from((0, 2, 4, 8))),
    st.tuples(st.just("hclk"), st.sampled_from((8, 56, 72))),
    st.tuples(st.just("volts"), st.integers(0, 15), st.floats(-0.5, 4.0)),
    st.tuples(st.just("ramp"), st.integers(0, 15), st.floats(0, 3.3), st.floats(0, 3.3), st.integers(1, 100_000)),
    st.tuples(st.just("pull"), st.integers(0, 15), st.sampled_from((None, 3.3, 1.0))),
)
PROGRAM = st.one_of(
    st.tuples(st.just("write"), st.sampled_from(range(0, 0x3C, 4)), st.integers(0, 0xFFFF_FFFF)),
    st.tuples(st.just("bits"), st.just(CR1), st.sets(st.integers(5, 12))),
    st.tuples(st.just("bits"), st.just(CR2), st.sets(st.sampled_from((1, 2, 3, 8, 11, 21, 22)))),
    st.tuples(st.just("bits"), st.just(CR2), st.sampled_from(({8, 22}, {21}))),
    st.tuples(st.just("read"), st.sampled_from((0, DR, DR, DR))),
)


class InPython:
    """A converter as it was, beside that of a rig."""

    def __init__(self, rig):
        self._rig = rig
        self.requests = rig.chip.dma("former")
        self.level, self.on_last = False, None
        ends = Ends(
            volts=lambda channel: self._at(channel) or 0.0,
            reference_volts=3.3,
            request=self,
            triggers={},
            injected_triggers={},
            note=lambda *_text: None,
        )
        self.unit = Former("ADC1", rig.chip.time, ends)

    def _at(self, channel):
        return self._rig.pins[CHANNELS["ADC1"][channel]].volts if channel < 16 else None

    def set(self, level):
        self.level = level
        self.requests.set(level)

    def write(self, offset, value):
        writable = self._rig.adcs[0].registers[offset].writable
        self.unit.write(offset, value & writable | self.unit.values[offset] & ~writable)


def put(pin, what, *values):
    if what == "volts":
        pin.drive_volts(*values)
    elif what == "ramp":
        pin.drive_ramp(*values[:2], in_ns=values[2])
    else:
        pin.drive_volts(*values, ohms=10_000.0)


def write(rig, former, offset, value):
    """Neither dual modes nor the sensor, and software as the trigger of both groups."""
    value = value & ~DUALMOD if offset == CR1 else value & ~TSVREFE | BY_SOFTWARE if offset == CR2 else value
    rig.adcs[0].write(offset, value)
    former.write(offset, value)


def act(rig, former, what, *more):
    if what == "wait":
        rig.chip.advance(*more)
    elif what == "rate":
        rig.chip.clocks.kernels["ADC"] = Fraction(*more)
        rig.chip.change_clock()
        former.unit.set_clock(*more)
    elif what == "hclk":
        rig.chip.change_clock(more[0] * 1_000_000)
    elif what == "read":
        assert rig.adcs[0].read(*more) == former.unit.read(*more)
    elif what == "write":
        write(rig, former, *more)
    elif what == "bits":
        write(rig, former, more[0], sum(1 << bit for bit in more[1]) | (more[0] == CR2))  # with ADON
    else:
        put(rig.pins[CHANNELS["ADC1"][more[0]]], what, *more[1:])


@given(actions=st.lists(PROGRAM | AROUND, min_size=10, max_size=40))
@settings(max_examples=examples(125))
def test_any_program(make_rig, actions):
    rig = make_rig()
    former = InPython(rig)
    former.unit.set_clock(4)
    beginning = (
        ("write", 0x2C, 2 << 20),
        ("write", 0x34, 5 << 10 | 3 << 5 | 1),
        ("bits", CR2, set()),
        ("bits", CR2, {22}),
    )
    for action in (*beginning, *actions):
        act(rig, former, *action)
        adc = rig.adcs[0]
        assert {offset: adc[offset] for offset in former.unit.values if offset in adc.registers} == former.unit.values
        assert rig.irq.level is former.unit.interrupt
        assert rig.chip.dma("ADC1").changes == former.requests.changes


@given(actions=st.lists(AROUND, max_size=30))
def test_what_is_known_of_a_voltage_is_what_stands_there(make_rig, actions):
    """All channels in turn for ever, beside a converter that asks for each voltage."""
    rig = make_rig()
    former = InPython(rig)
    former.unit.set_clock(4)
    sequence = [sum(rank << 5 * (rank % 6) for rank in range(first, min(first + 6, 16))) for first in (0, 6, 12)]
    begin = (0x2C, 15 << 20 | sequence[2]), (0x30, sequence[1]), (0x34, sequence[0]), (CR1, 1 << 8)
    for offset, value in (*begin, (CR2, 3), (CR2, 3 | 1 << 22)):
        write(rig, former, offset, value)
    for action in actions:
        act(rig, former, *action)
        rig.chip.advance(600)
        assert rig.adcs[0][DR] == former.unit.values[DR]


def test_a_voltage_that_stays_is_asked_for_once(rig, monkeypatch):
    asked = []
    volts = Pin.volts_for
    monkeypatch.setattr(Pin, "volts_for", lambda pin, *more: asked.append(pin.name) or volts(pin, *more))
    rig.on(cr2=2)
    rig.sequence(1)
    rig.start()
    rig.clocks(14 * 100)
    assert asked == ["PA1"]
    rig.volts(1, 2.0)
    rig.clocks(14 * 100)
    assert asked == ["PA1", "PA1"]
    assert rig.peek("DR") == round(2.0 / 3.3 * 4096)


def test_a_ramp_is_followed(rig):
    """Slower than a step with each conversion, and faster."""
    rig.on(cr2=2)
    rig.sequence(1)
    rig.start()
    for in_ns in (50_000, 10_000_000):
        rig.pins["PA1"].drive_ramp(0.0, 3.3, in_ns=in_ns)
        for _ in range(100):
            rig.clocks(1.5)
            volts = rig.pins["PA1"].volts
            rig.clocks(12.5)
            assert rig.peek("DR") == min(int(volts / 3.3 * 4096 + 0.5), 4095)
