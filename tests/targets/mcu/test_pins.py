"""Levels, pulls, contention, records and wires."""

from __future__ import annotations

from fractions import Fraction
from functools import partial

import pytest
from hypothesis import given
from hypothesis import strategies as st

from targets.mcu.errors import BoardError
from targets.mcu.nets import Nets
from targets.mcu.pins import NEVER, PadMode, Pins, Source
from targets.mcu.services import Wave
from targets.mcu.signals import Signals
from targets.mcu.testing import FakeChip

NAMES = ("PA0", "PA1", "PA2", "PA3")


def make(bonded=None, hclk_hz=72_000_000):
    chip = FakeChip(hclk_hz)
    return chip, Pins(NAMES, chip.time, chip.notes, bonded=bonded)


def push_pull(pin, level):
    pin.configure(PadMode.PUSH_PULL, latch=level, pull=None)


def test_a_pin_that_nobody_drives_floats_and_reads_low():
    _, pins = make()
    assert pins["PA0"].level is None
    assert pins["PA0"].volts is None
    assert pins["PA0"].reads_high is False


def test_outputs_decide_the_level():
    _, pins = make()
    pin = pins["PA0"]
    push_pull(pin, True)
    assert pin.level is True
    pin.set_latch(False)
    assert pin.level is False
    pin.configure(PadMode.OPEN_DRAIN, latch=True, pull=None)
    assert pin.level is None
    pin.drive(True)
    assert pin.level is True
    pin.drive(True, ohms=4_700)
    pin.set_latch(False)
    assert pin.level is False


def test_the_edges_of_all_pins_are_taken_at_once():
    """Those of a pin that is not followed any more stay until it is followed again, or asked."""
    chip, pins = make()
    for name in ("PA2", "PA0", "PA1"):
        push_pull(pins[name], False)
        pins[name].follow()
    for name in ("PA2", "PA0", "PA2"):
        chip.advance(1)
        pins[name].set_latch(pins[name].level is False)
    pins["PA0"].follow(on=False)
    assert [(pin.name, [edge.cycle for edge in edges]) for pin, edges in pins.take_followed()] == [("PA2", [1, 3])]
    assert pins.take_followed() == []
    pins["PA0"].follow()
    assert [(pin.name, [edge.cycle for edge in edges]) for pin, edges in pins.take_followed()] == [("PA0", [2])]
    pins["PA2"].set_latch(True)
    assert len(pins["PA2"].take_followed()) == 1
    assert pins.take_followed() == []


def test_who_reads_all_pins_takes_nothing_from_who_records_one():
    chip, pins = make()
    pin = pins["PA0"]
    push_pull(pin, False)
    pin.follow()
    pin.record()
    chip.advance(1)
    pin.set_latch(True)
    ((_, followed),) = pins.take_followed()
    pin.follow(on=False)
    chip.advance(1)
    pin.set_latch(False)
    assert [edge.cycle for edge in followed] == [1]
    assert [edge.cycle for edge in pin.take_edges()] == [1, 2]


def test_a_pull_yields_to_a_driver_and_comes_back():
    _, pins = make()
    pin = pins["PA0"]
    pin.configure(PadMode.INPUT, latch=True, pull=True)
    assert pin.level is True
    pin.drive(False)
    assert pin.level is False
    pin.drive(None)
    assert pin.level is True


def test_the_stronger_resistor_wins():
    _, pins = make()
    pin = pins["PA0"]
    pin.configure(PadMode.INPUT, latch=True, pull=True)
    pin.drive(False, ohms=10_000)
    assert pin.volts == pytest.approx(3.3 * 10 / 50)
    assert pin.level is False
    pin.drive(False, ohms=1_000_000)
    assert pin.level is True


def test_two_drivers_that_contradict_each_other_are_noted():
    chip, pins = make()
    pin = pins["PA0"]
    push_pull(pin, True)
    assert not chip.notes.all
    pin.drive(False)
    assert pin.level is False
    assert chip.noted("misuse") == ["PA0"]


def test_an_analog_level_has_the_hysteresis_of_the_datasheet():
    _, pins = make()
    pin = pins["PA0"]
    assert pins.vil_volts == pytest.approx(1.164)
    assert pins.vih_volts == pytest.approx(1.833)
    levels = []
    for volts in (0.0, 1.5, 1.9, 1.5, 1.1, 1.5):
        pin.drive_volts(volts)
        assert pin.volts == pytest.approx(volts)
        levels.append(pin.level)
    assert levels == [False, False, True, True, False, False]
    pin.drive_volts(None)
    assert pin.level is None


def test_an_analog_pad_reads_low_but_has_its_level():
    _, pins = make()
    pin = pins["PA0"]
    pin.drive(True)
    assert pin.reads_high
    pin.configure(PadMode.ANALOG, latch=False, pull=None)
    assert pin.level is True
    assert not pin.reads_high


def test_a_claimed_pad_is_out_of_the_hands_of_its_port():
    _, pins = make()
    pin = pins["PA0"]
    pin.claim("the debug port", pull=True)
    push_pull(pin, False)
    assert (pin.level, pin.claimed_by) == (True, "the debug port")
    pin.unclaim()
    assert (pin.level, pin.claimed_by) == (False, None)
    pin.claim("an oscillator", analog=True)
    pin.drive(True)
    assert not pin.reads_high


def test_edges_carry_cycle_and_time_and_are_taken_once():
    chip, pins = make()
    pin = pins["PA0"]
    push_pull(pin, False)
    pin.record()
    seen = []
    pin.on_edge(lambda *edge: seen.append(edge))
    chip.advance(72)
    pin.set_latch(True)
    chip.advance(1)
    pin.set_latch(True)
    pin.configure(PadMode.INPUT, latch=True, pull=None)
    assert pin.edges == [(72, 1000, True), (73, 1013, None)]
    assert seen == pin.edges
    assert pin.take_edges() == seen
    assert pin.take_edges() == []
    pin.record(False)
    push_pull(pin, True)
    assert pin.edges == []
    assert len(seen) == 3


def test_without_a_record_nothing_is_kept():
    chip, pins = make()
    pin = pins["PA0"]
    push_pull(pin, False)
    for _ in range(10):
        chip.advance(1)
        pin.set_latch(not pin.level)
    assert pin.edges == []


def test_a_pin_outside_the_package_cannot_be_driven_or_wired():
    _, pins = make(bonded=["PA0"])
    with pytest.raises(BoardError):
        pins["PA1"].drive(True)
    with pytest.raises(BoardError):
        Nets().wire("w", pins["PA0"], pins["PA1"])
    with pytest.raises(BoardError):
        pins["PF0"].drive(True)
    assert "PA1" in pins
    assert len(list(pins)) == len(pins) == 4


def test_a_wire_joins_pins_of_one_chip():
    _, pins = make()
    a, b = pins["PA0"], pins["PA1"]
    push_pull(a, True)
    nets = Nets()
    net = nets.wire("loop", a, b)
    assert nets["loop"] is net
    assert b.level is True
    a.set_latch(False)
    assert b.level is False
    a.configure(PadMode.INPUT, latch=False, pull=True)
    assert b.level is True
    b.drive(False)
    assert a.level is False
    b.drive(None)
    assert a.level is True


def test_an_open_drain_bus_is_low_while_anybody_pulls_it():
    _, pins = make()
    ends = [pins[name] for name in NAMES[:3]]
    for pin in ends:
        pin.configure(PadMode.OPEN_DRAIN, latch=True, pull=None)
    Nets().wire("bus", *ends, pull=True)
    assert [pin.level for pin in ends] == [True] * 3
    ends[1].set_latch(False)
    ends[2].set_latch(False)
    assert [pin.level for pin in ends] == [False] * 3
    ends[1].set_latch(True)
    assert [pin.level for pin in ends] == [False] * 3
    ends[2].set_latch(True)
    assert [pin.level for pin in ends] == [True] * 3


def test_a_wire_between_chips_delivers_at_bench_time():
    chip_a, pins_a = make()
    _, pins_b = make(hclk_hz=8_000_000)
    waiting = []
    pins_b.deliver = lambda ns, action: waiting.append((ns, action))
    Nets().wire("link", pins_a["PA0"], pins_b["PA3"])
    waiting.clear()
    chip_a.advance(720)
    push_pull(pins_a["PA0"], True)
    assert [ns for ns, _ in waiting] == [10_000]
    assert pins_b["PA3"].level is None
    waiting[0][1]()
    assert pins_b["PA3"].level is True


def test_wires_are_named_once_and_have_two_ends():
    _, pins = make()
    nets = Nets()
    nets.wire("w", pins["PA0"], pins["PA1"])
    with pytest.raises(BoardError):
        nets.wire("w", pins["PA2"], pins["PA3"])
    with pytest.raises(BoardError):
        nets.wire("v", pins["PA2"], pins["PA2"])


def test_signals_reach_pins_only_in_alternate_function():
    _, pins = make()
    signals = Signals(pins)
    signals.route("TX", "PA0")
    out, listener = signals.output("TX"), signals.input("TX")
    heard = []
    listener.on_change = heard.append
    out.set(True)
    assert not out.at_pin()
    assert not listener.level()
    pins["PA0"].configure(PadMode.AF_PUSH_PULL, latch=False, pull=None)
    assert out.at_pin()
    assert listener.level()
    out.set(False)
    out.set(None)
    assert pins["PA0"].level is None
    assert heard == [True, False]


def test_an_open_drain_alternate_function_only_pulls_down():
    _, pins = make()
    signals = Signals(pins)
    signals.route("SDA", "PA0")
    pins["PA0"].configure(PadMode.AF_OPEN_DRAIN, latch=False, pull=None)
    signals.output("SDA").set(True)
    assert pins["PA0"].level is None
    signals.output("SDA").set(False)
    assert pins["PA0"].level is False


def test_two_peripherals_on_one_pin_are_noted():
    chip, pins = make()
    signals = Signals(pins)
    for name in ("A", "B"):
        signals.route(name, "PA0")
        signals.output(name)
    pins["PA0"].configure(PadMode.AF_PUSH_PULL, latch=False, pull=None)
    signals.output("B").set(True)
    assert pins["PA0"].level is True
    signals.output("A").set(False)
    assert pins["PA0"].level is False
    assert chip.noted() == ["PA0"]


def test_a_wave_is_told_while_the_pad_carries_it():
    chip, pins = make()
    signals, pin, told = Signals(pins), pins["PA0"], []
    pin.on_wave = told.append
    clock, wave = signals.output("CLOCK"), Wave(hz=Fraction(8_000_000), duty=Fraction(1, 2))
    signals.route("CLOCK", "PA0")
    clock.set(False)
    clock.set_wave(wave)
    assert pin.wave is None
    pin.configure(PadMode.AF_PUSH_PULL, latch=False, pull=None)
    assert pin.wave is wave
    assert pin.level is False
    assert not chip.noted()
    Nets().wire("clock", pin, pins["PA1"])
    assert chip.noted("unmodelled") == ["PA0"], "the other end hears no edges"
    pin.configure(PadMode.INPUT, latch=False, pull=None)
    clock.set_wave(None)
    assert told == [wave, None]


def test_a_signal_inside_the_chip_goes_from_output_to_input():
    _, pins = make()
    signals = Signals(pins)
    heard = []
    signals.input("TRGO").on_change = heard.append
    signals.output("TRGO").set(True)
    signals.output("TRGO").set(None)
    assert heard == [True, False]
    assert not signals.input("nobody").level()


def test_rerouting_an_input_tells_of_the_other_pins_level():
    _, pins = make()
    signals = Signals(pins)
    heard = []
    signals.input("RX").on_change = heard.append
    signals.route("RX", "PA0")
    pins["PA1"].drive(True)
    signals.route("RX", "PA1")
    pins["PA0"].drive(True)
    pins["PA1"].drive(False)
    signals.route("RX", None)
    assert signals.route_of("RX") is None
    assert heard == [True, False]


class Square:
    """A peripheral that makes an edge every 10 cycles and tells of each only while it must."""

    def __init__(self, chip, signal):
        self.chip, self.signal = chip, signal
        self.done = 0
        self.events = 0
        self._event = None
        signal.refresh = self.refresh
        signal.on_watch = self.plan

    def refresh(self):
        now = self.chip.time.now
        while self.done + 10 <= now:
            self.done += 10
            self.signal.set_at(self.done, self.done % 20 == 10)

    def plan(self):
        self.chip.time.cancel(self._event)
        if self.signal.watch() == 2:
            self._event = self.chip.time.at(self.done + 10, self.happen)

    def happen(self):
        self.events += 1
        self.refresh()
        self.plan()


@given(
    st.lists(
        st.tuples(
            st.integers(0, 37),
            st.sampled_from(["record", "stop", "follow", "let go", "listen", "take", "take followed", "level"]),
        ),
        max_size=30,
    )
)
def test_lazy_edges_are_those_of_a_pin_that_is_always_watched(steps):
    chip, pins = make()
    signals = Signals(pins)
    signals.route("PWM", "PA0")
    square = Square(chip, signals.output("PWM"))
    pin = pins["PA0"]
    pin.configure(PadMode.AF_PUSH_PULL, latch=False, pull=None)
    expected, got, heard, live = [], [], [], []
    expected_followed, followed = [], []
    switches = {
        "record": pin.record,
        "stop": partial(pin.record, on=False),
        "follow": pin.follow,
        "let go": partial(pin.follow, on=False),
        "level": lambda: None,
    }

    def levels(now):
        return None if now < 10 else now // 10 % 2 == 1

    def listen(cycle, ns, level):
        heard.append((cycle, level))

    for cycles, step in steps:
        before = chip.time.now
        chip.advance(cycles)
        span = [(c, c % 20 == 10) for c in range(10, chip.time.now + 1, 10) if c > before]
        if pin.recording:
            expected += span
        if pin.following:
            expected_followed += span
        if listen in pin._listeners:
            live += span
        if step in switches:
            switches[step]()
        elif step == "take":
            got += [(edge.cycle, edge.level) for edge in pin.take_edges()]
        elif step == "take followed":
            followed += [(edge.cycle, edge.level) for _, edges in pins.take_followed() for edge in edges]
        else:
            (pin.off_edge if listen in pin._listeners else pin.on_edge)(listen)
        assert step != "level" or pin.level is levels(chip.time.now)
    got += [(edge.cycle, edge.level) for edge in pin.take_edges()]
    followed += [(edge.cycle, edge.level) for edge in pin.take_followed()]
    assert got == expected
    assert followed == expected_followed
    assert heard == live
    assert square.events == len(live)


class TestKnownVolts:
    """Whoever asks for a voltage learns for how long it stays as good as that."""

    STEP_VOLTS = 3.3 / 8192

    def known(self, pin):
        """Return the voltage, the cycle until which it counts, and the list of those who were told to forget it."""
        forgotten = []
        return *pin.volts_for(self.STEP_VOLTS, lambda: forgotten.append(pin.name)), forgotten

    @pytest.mark.parametrize(
        "change",
        [
            lambda pin: pin.drive_volts(2.0),
            lambda pin: pin.drive_ramp(0.0, 1.0, in_ns=1000),
            lambda pin: pin.put_out(Source(1.0, 1.0)),
            lambda pin: pin.configure(PadMode.INPUT, latch=False, pull=True),
            lambda pin: pin.claim("an oscillator", analog=True),
        ],
    )
    def test_one_that_stays_is_forgotten_once_it_may_not(self, change):
        _, pins = make()
        pin = pins["PA0"]
        pin.drive_volts(1.0)
        volts, until, forgotten = self.known(pin)
        assert (volts, until, forgotten) == (1.0, NEVER, [])
        change(pin)
        pin.drive_volts(1.5)
        assert forgotten == ["PA0"]

    def test_of_a_pad_that_the_chip_drives_nobody_knows(self):
        chip, pins = make()
        for mode in (PadMode.PUSH_PULL, PadMode.OPEN_DRAIN, PadMode.AF_PUSH_PULL, PadMode.AF_OPEN_DRAIN):
            pins["PA0"].configure(mode, latch=True, pull=None)
            assert self.known(pins["PA0"])[1] == chip.time.now

    @given(
        volts=st.tuples(st.floats(0, 3.3), st.floats(0, 3.3)),
        in_ns=st.integers(1, 100) | st.integers(1, 10**9),
        pull=st.sampled_from((None, True, False)),
        waits=st.lists(st.integers(1, 300) | st.integers(1, 10**7), max_size=8),
    )
    def test_a_ramp_stays_within_a_step_for_as_long_as_it_says(self, volts, in_ns, pull, waits):
        chip, pins = make()
        pin = pins["PA0"]
        pin.configure(PadMode.INPUT, latch=False, pull=pull)
        pin.drive_ramp(*volts, in_ns=in_ns, ohms=5_000.0)
        for wait in waits:
            chip.advance(wait)
            found, until, _ = self.known(pin)
            if until > chip.time.now:
                chip.advance_to(min(until, chip.time.now + 10**9) - 1)
                assert pin.volts // self.STEP_VOLTS == found // self.STEP_VOLTS

    def test_a_slow_one_is_asked_for_once_a_step(self):
        chip, pins = make()
        pin = pins["PA0"]
        pin.drive_ramp(0.0, 64 * self.STEP_VOLTS, in_ns=64_000)
        asked = 0
        while (until := self.known(pin)[1]) != NEVER:
            chip.advance_to(max(until, chip.time.now + 1))
            asked += 1
        assert asked < 4 * 64
