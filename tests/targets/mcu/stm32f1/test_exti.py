"""Edges, masks, pending bits, interrupt lines."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from targets.mcu.testing import peek, poke

IRQS = {0: 6, 1: 7, 2: 8, 3: 9, 4: 10, 5: 23, 9: 23, 10: 40, 15: 40}


@pytest.mark.parametrize("line", IRQS)
def test_a_rising_edge_of_the_chosen_port_interrupts(pinout, line):
    bit = 1 << line
    poke(pinout.afio, f"EXTICR{line // 4 + 1}", 1 << 4 * (line % 4))
    poke(pinout.afio, "MAPR", 0b100 << 24)
    poke(pinout.exti, "IMR", bit)
    poke(pinout.exti, "RTSR", bit)
    pinout.pins[f"PA{line}"].drive(True)
    assert peek(pinout.exti, "PR") == 0
    pinout.chip.advance(5)
    pinout.pins[f"PB{line}"].drive(True)
    assert peek(pinout.exti, "PR") == bit
    assert pinout.chip.irq(IRQS[line]).rises == [5]
    poke(pinout.exti, "PR", bit)
    assert not pinout.chip.irq(IRQS[line]).level
    pinout.pins[f"PB{line}"].drive(False)
    assert peek(pinout.exti, "PR") == 0


@given(st.lists(st.tuples(st.sampled_from(["drive", "imr", "emr", "rtsr", "ftsr", "swier", "pr"]), st.integers(0, 3))))
def test_against_the_rules_written_out(make_pinout, steps):
    pinout = make_pinout()
    exti, events = pinout.exti, []
    exti.on_event = lambda: events.append(1)
    for number in (0, 1):
        pinout.mode(f"PA{number}", 0b1000)
    rule = dict.fromkeys(["drive", "imr", "emr", "rtsr", "ftsr", "swier", "pr"], 0)
    count = 0
    for step, value in steps:
        old = rule[step]
        hits = []
        if step == "drive":
            edges = (value & ~old & rule["rtsr"]) | (~value & old & rule["ftsr"])
            hits = [edges & 1, edges & 2]
            for number in (0, 1):
                pinout.pins[f"PA{number}"].drive(bool(value >> number & 1))
        else:
            poke(exti, step.upper(), value)
        if step == "swier":
            hits = [value & ~old]
            value |= old
        elif step == "pr":
            rule["swier"] &= ~value
            value = old & ~value
        rule[step] = value
        rule["pr"] |= sum(hits) & rule["imr"]
        count += sum(1 for hit in hits if hit & rule["emr"])
        assert (peek(exti, "PR"), peek(exti, "SWIER"), len(events)) == (rule["pr"], rule["swier"], count)
        for number in (0, 1):
            assert pinout.chip.irq(6 + number).level is bool(rule["pr"] & rule["imr"] & 1 << number)


def test_a_software_edge_of_a_masked_line_is_noted(pinout):
    """RM0008 section 10.3.5: a bit of SWIER sets the pending bit if IMR enables the line."""
    poke(pinout.exti, "EMR", 1 << 3)
    poke(pinout.exti, "SWIER", 1 << 3)  # meant as an event
    poke(pinout.exti, "IMR", 1 << 4)
    poke(pinout.exti, "SWIER", 1 << 4)
    assert pinout.chip.notes.all == []
    poke(pinout.exti, "SWIER", 1 << 5)
    poke(pinout.exti, "SWIER", 1 << 6)
    assert peek(pinout.exti, "PR") == 1 << 4
    (note,) = pinout.chip.notes.all
    assert (note.kind, note.where) == ("misuse", "EXTI_SWIER")
    assert "a line that IMR and EMR mask" in note.text


def test_lines_inside_the_chip(pinout):
    poke(pinout.exti, "IMR", 0b111 << 16)
    poke(pinout.exti, "RTSR", 0b111 << 16)
    for line, irq in ((16, 1), (17, 41), (18, 42)):
        pinout.signals.output(f"EXTI{line}").set(True)
        assert pinout.chip.irq(irq).level
    assert peek(pinout.exti, "PR") == 0b111 << 16


def test_registers_have_19_lines(pinout):
    for name in ("IMR", "EMR", "RTSR", "FTSR"):
        poke(pinout.exti, name, 0xFFFF_FFFF)
        assert peek(pinout.exti, name) == 0x7_FFFF


def test_an_unmasked_line_requests_what_is_already_pending(pinout):
    poke(pinout.exti, "IMR", 1)
    poke(pinout.exti, "SWIER", 1)
    poke(pinout.exti, "IMR", 0)
    assert not pinout.chip.irq(6).level
    poke(pinout.exti, "IMR", 1)
    assert pinout.chip.irq(6).level
    pinout.exti.reset()
    assert not pinout.chip.irq(6).level
    assert peek(pinout.exti, "PR") == 0
