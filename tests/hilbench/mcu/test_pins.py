"""Pins of emulated boards: in the journal, as waveforms, over wires to other boards."""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise

import pytest

from hilbench.mcu.pin_log import LOOK_NS, WINDOW_NS
from targets.mcu.pins import PadMode
from targets.mcu.services import Wave


def toggling(pin, period_ns, duty=0.5):
    """A program with a square wave at a pin."""

    def program(machine):
        machine.output(pin)

        def rise():
            machine.chip.pins[pin].set_latch(True)
            machine.at_ns(machine.now_ns + round(period_ns * duty), lambda: machine.chip.pins[pin].set_latch(False))

        machine.every(period_ns, rise)

    return program


def events(emulated, kind):
    return [event for event in emulated.bench.journal.recent if event["kind"] == kind]


def test_a_slow_pin_is_told_edge_by_edge(emulate):
    emulated = emulate(toggling("PC13", 50_000_000))
    emulated.bench.run_for(0.2)
    told = [(event["ns"] // 1_000_000, event["source"], event["level"]) for event in events(emulated, "pin")]
    assert told[1:] == [
        (ms, "brain.PC13", level)
        for ms, level in ((50, True), (75, False), (100, True), (125, False), (150, True), (175, False), (200, True))
    ]
    assert told[0] == (0, "brain.PC13", False)  # it floated, and is an output now
    assert events(emulated, "pwm") == []


def test_a_fast_pin_is_told_by_period_and_duty(emulate):
    emulated = emulate(toggling("PA8", 50_000, duty=0.3))
    emulated.bench.run_for(0.35)
    told = events(emulated, "pwm")
    assert len(events(emulated, "pin")) == 20
    assert [event["in_ns"] for event in told] == [WINDOW_NS, LOOK_NS, LOOK_NS]
    for event in told:
        assert abs(event["period_ns"] - 50_000) <= 14
        assert abs(event["high_ns"] - 15_000) <= 14
    assert abs(told[1]["edges"] - 2 * LOOK_NS // 50_000) <= 2


def test_a_pin_that_comes_to_rest_is_slow_again(emulate):
    emulated = emulate(toggling("PA8", 50_000))
    machine = emulated.machines["brain"]
    pin = machine.chip.pins["PA8"]
    emulated.bench.run_for(0.15)
    machine.stop_all()
    emulated.bench.run_for(0.3)
    pin.set_latch(not pin.level)
    emulated.bench.run_for(0.01)
    assert events(emulated, "pin")[-1]["level"] is pin.level
    assert events(emulated, "pwm")[-1]["edges"] == 0


def test_what_is_too_fast_for_edges_is_told_by_period_and_duty(emulate):
    """8 MHz from 30 ms to 230 ms."""

    def program(machine):
        signals, pin = machine.chip.signals, machine.chip.pins["PA8"]
        clock = signals.output("MCO")
        signals.route("MCO", "PA8")
        pin.configure(PadMode.AF_PUSH_PULL, latch=False, pull=None)
        clock.set(False)
        machine.at_ns(30_000_000, lambda: clock.set_wave(Wave(hz=Fraction(8_000_000), duty=Fraction(1, 2))))
        machine.at_ns(230_000_000, lambda: clock.set_wave(None))

    emulated = emulate(program)
    emulated.bench.run_for(0.35)
    told = [
        (event["ns"], event.get("period_ns"), event.get("high_ns"), event["edges"], event["in_ns"])
        for event in events(emulated, "pwm")
    ]
    assert told == [
        (30_000_000, 125, 62, 0, 0),
        (100_000_000, 125, 62, 1_120_000, 70_000_000),
        (200_000_000, 125, 62, 1_600_000, WINDOW_NS),
        (230_000_000, None, None, 480_000, 30_000_000),
    ]
    assert [event["level"] for event in events(emulated, "pin") if event["source"] == "brain.PA8"] == [False]
    assert [event.get("duty") for event in events(emulated, "pwm")] == [0.5, 0.5, 0.5, None]


def test_a_wire_joins_pins_of_two_boards(emulate):
    seen = []

    def listener(machine):
        machine.chip.pins["PB1"].on_edge(lambda _cycle, ns, level: seen.append((ns, level)))

    wire = '[[wires]]\nends = ["brain.PA0", "other.PB1"]\n'
    emulated = emulate(toggling("PA0", 1_000_000), listener, more=wire)
    emulated.bench.run_for(0.01)
    edges = [(round(ns / 500_000), level) for ns, level in seen if level is not None]
    assert edges[-4:] == [(17, False), (18, True), (19, False), (20, True)]
    for ns, _ in seen[1:]:
        assert ns % 500_000 < 20_000 or ns % 500_000 > 499_980


def test_a_pin_at_a_supply(emulate):
    more = '[[wires]]\nends = ["brain.PA0", "3v3"]\n[[wires]]\nends = ["brain.PA1", "gnd", "brain.PA2"]\n'
    emulated = emulate(lambda _machine: None, more=more)
    pins = emulated.machines["brain"].chip.pins
    assert [pins[name].level for name in ("PA0", "PA1", "PA2", "PA3")] == [True, False, False, None]


# --- waveforms


def read_vcd(path):
    """Return timescale, names by identifier, and changes as (ns, name, value)."""
    names, changes, scope, now = {}, [], [], None
    timescale = ""
    for line in path.read_text().splitlines():
        words = line.split()
        if line.startswith("$timescale"):
            timescale = " ".join(words[1:-1])
        elif line.startswith("$scope"):
            scope.append(words[2])
        elif line.startswith("$upscope"):
            scope.pop()
        elif line.startswith("$var"):
            names[words[3]] = ".".join([*scope, words[4]])
        elif line.startswith("#"):
            now = int(line[1:])
        elif line[:1] in "01xz" and now is not None:
            changes.append((now, names[line[1:]], line[0]))
    return timescale, names, changes


def test_waveforms_have_pins_nets_and_lines_in_order_of_time(emulate, tmp_path):
    def program(machine):
        toggling("PA0", 100_000)(machine)
        machine.echo("USART1")

    more = '[[wires]]\nends = ["brain.PA0", "brain.PA1"]\n'
    emulated = emulate(program, more=more, vcd=tmp_path / "w.vcd")
    emulated.bench.run_for(0.001)
    emulated.ports["brain.usart1"].write(b"\x55")
    emulated.bench.run_for(0.001)
    emulated.close()
    timescale, names, changes = read_vcd(tmp_path / "w.vcd")
    assert timescale == "1 ns"
    assert {"brain.pins.PA0", "brain.usart1.tx", "brain.usart1.rx", "nets.brain_PA0--brain_PA1"} <= set(names.values())
    times = [ns for ns, _, _ in changes]
    assert times == sorted(times)
    tx = [(ns, value) for ns, name, value in changes if name == "brain.usart1.tx" and ns]
    assert [value for _, value in tx] == list("0101010101")  # start bit, 0x55 from its lowest bit on, stop bit
    bit_ns = [after - before for (before, _), (after, _) in pairwise(tx)]
    assert all(abs(length - 8680) <= 1 for length in bit_ns)
    for name in ("brain.pins.PA0", "brain.pins.PA1", "nets.brain_PA0--brain_PA1"):
        rises = [ns for ns, changed, value in changes if changed == name and value == "1"]
        assert [round(ns / 100_000) for ns in rises] == list(range(1, 21)), name


def test_waveforms_cost_no_edges_of_fast_pins(emulate, tmp_path):
    emulated = emulate(toggling("PA8", 20_000), vcd=tmp_path / "w.vcd")
    emulated.bench.run_for(0.25)
    emulated.close()
    _, _, changes = read_vcd(tmp_path / "w.vcd")
    assert len([1 for _, name, value in changes if name == "brain.pins.PA8" and value == "1"]) == 12_500


def test_waveforms_that_cannot_be_written(emulate, tmp_path):
    from hilbench.errors import UnavailableError

    with pytest.raises(UnavailableError, match="the waveforms cannot be written"):
        emulate(lambda _machine: None, vcd=tmp_path / "none" / "w.vcd")
