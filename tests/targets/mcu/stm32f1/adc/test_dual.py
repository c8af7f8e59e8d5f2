"""ADC1 and ADC2 together (RM0008 section 11.9, its figures)."""

from __future__ import annotations

import pytest

from tests.each import each

SCAN, JDISCEN, CONT, DMA = 1 << 8, 1 << 12, 2, 1 << 8
TIM3, TIM2 = 1 << 20 | 4 << 17, 1 << 15 | 2 << 12
SHORTEST = 14


@pytest.fixture
def pair(make_rig):
    """Both on in a mode, ADC1 triggered by TIM3_TRGO and TIM2_TRGO (injected), with channels of their own."""

    def make(mode, *, cr1=SCAN, cr2=0, channels=((0, 1, 2), (5, 4, 3)), injected=((6, 7), (9, 8))):
        rig = make_rig()
        rig.on(cr1=cr1 | mode << 16, cr2=cr2 | DMA | TIM3 | TIM2)
        rig.on(cr1=cr1, cr2=cr2, unit=2)
        for unit in (1, 2):
            rig.sequence(*channels[unit - 1], unit=unit)
            rig.injected(*injected[unit - 1], unit=unit)
        return rig

    return make


def test_regular_simultaneous(pair, expected):
    """Figure 29: 32 bits for each pair, EOC of both at the end."""
    rig = pair(6)
    found = rig.drain()
    rig.trigger("TIM3_TRGO")
    rig.clocks(3 * SHORTEST - 1)
    assert (rig.flags(1), rig.flags(2)) == ({"STRT"}, {"STRT"})
    rig.clocks(2)
    assert rig.flags(2) == {"STRT", "EOC"}
    assert found == [
        (SHORTEST * number, expected(one) | expected(other) << 16)
        for number, (one, other) in enumerate(zip((0, 1, 2), (5, 4, 3), strict=True), 1)
    ]


def test_injected_simultaneous(pair, expected):
    """Figure 28."""
    rig = pair(5)
    rig.trigger("TIM2_TRGO")
    rig.clocks(2 * SHORTEST)
    for unit, channels in ((1, (6, 7)), (2, (9, 8))):
        assert rig.flags(unit) >= {"JSTRT", "JEOC"}
        assert [rig.peek(f"JDR{number}", unit) for number in (1, 2)] == [expected(channel) for channel in channels]


def test_fast_interleaved(pair, expected):
    """Figure 30: ADC2 at once, ADC1 7 clocks later; continuous, one after the other each 7 clocks."""
    rig = pair(7, cr1=0, cr2=CONT, channels=((3,), (3,)))
    found = rig.drain()
    rig.trigger("TIM3_TRGO")
    rig.clocks(SHORTEST - 1)
    assert rig.flags(2) == {"STRT"}
    rig.clocks(1)
    assert rig.flags(2) == {"STRT", "EOC"}
    rig.clocks(2 * SHORTEST)
    assert found == [(7 + SHORTEST * n, expected(3) << 16 | expected(3)) for n in (1, 2)]


def test_slow_interleaved(pair, expected):
    """Figure 31: ADC2 at once, ADC1 14 clocks later, ADC2 again 28 clocks after the first, by themselves."""
    rig = pair(8, cr1=0, channels=((2,), (2,)))
    found, ends = rig.drain(), []
    rig.trigger("TIM3_TRGO")
    for clock in range(1, 80):
        rig.clocks(1)
        if "EOC" in rig.flags(2):
            rig.poke("SR", 0, unit=2)
            ends.append(clock)
    assert ends == [14, 42, 70]
    assert found == [(28 * n, expected(2) << 16 | expected(2)) for n in (1, 2)]
    rig.poke("CR2", 0)
    rig.poke("CR2", 0, unit=2)
    rig.clocks(100)
    assert len(found) == 2


def test_another_mode_forgets_what_was_to_follow(pair):
    rig = pair(7, cr1=0)
    rig.trigger("TIM3_TRGO")
    rig.clocks(3)
    rig.poke("CR1", 0)
    rig.clocks(100)
    assert (rig.flags(1), rig.flags(2)) == (set(), {"STRT", "EOC"})


@pytest.mark.parametrize("unit", [1, 2])
def test_slow_interleaved_ends_with_either(pair, unit):
    rig = pair(8, cr1=0, channels=((2,), (2,)))
    rig.trigger("TIM3_TRGO")
    rig.clocks(28 + 7)
    rig.poke("CR2", 0, unit)
    rig.clocks(28)
    for other in (1, 2):
        rig.poke("SR", 0, other)
    rig.clocks(100)
    assert rig.flags(1) == rig.flags(2) == set()


def test_alternate_trigger(pair):
    """Figure 32: the first trigger is for all injected channels of ADC1, the next one for those of ADC2."""
    rig = pair(9)
    turns = []
    for _ in range(4):
        rig.trigger("TIM2_TRGO")
        rig.clocks(2 * SHORTEST)
        turns.append(tuple("JEOC" in rig.flags(unit) for unit in (1, 2)))
        rig.poke("SR", 0, unit=1)
        rig.poke("SR", 0, unit=2)
    assert turns == [(True, False), (False, True)] * 2


def test_alternate_trigger_one_channel_each_time(pair, expected):
    """Figure 33: with JDISCEN."""
    rig = pair(9, cr1=SCAN | JDISCEN)
    for step, (unit, register, channel) in enumerate(((1, 1, 6), (2, 1, 9), (1, 2, 7), (2, 2, 8))):
        rig.trigger("TIM2_TRGO")
        rig.clocks(SHORTEST)
        assert rig.peek(f"JDR{register}", unit) == expected(channel), step
        assert ("JEOC" in rig.flags(unit)) is (register == 2)


def test_simultaneous_and_an_injected_pair_between(pair, expected):
    """Section 11.9.6: both regular groups are broken off, and go on together."""
    rig = pair(1)
    found = rig.drain()
    rig.trigger("TIM3_TRGO")
    rig.clocks(SHORTEST + 5)
    rig.trigger("TIM2_TRGO")
    rig.clocks(200)
    assert [clock for clock, _ in found] == [
        SHORTEST,
        SHORTEST + 5 + 2 * SHORTEST + SHORTEST,
        4 * SHORTEST + 5 + SHORTEST,
    ]
    assert found[-1][1] == expected(2) | expected(3) << 16
    assert all(rig.flags(unit) == {"STRT", "EOC", "JSTRT", "JEOC"} for unit in (2,))


def test_simultaneous_and_alternate_triggers_between(pair, expected):
    """Figure 34: the one injects, and the regular group of the other waits for it."""
    rig = pair(2)
    found = rig.drain()
    rig.trigger("TIM3_TRGO")
    rig.clocks(SHORTEST + 5)
    rig.trigger("TIM2_TRGO")
    rig.clocks(2 * SHORTEST)
    assert (rig.flags(1) >= {"JEOC"}, "JEOC" in rig.flags(2)) == (True, False)
    rig.clocks(200)
    assert [clock for clock, _ in found] == [SHORTEST, 4 * SHORTEST + 5, 5 * SHORTEST + 5]
    assert found[1][1] == expected(1) | expected(4) << 16


@each("mode", [6, 7, 8, 5, 9])
def test_a_slave_that_takes_no_part_is_noted(make_rig, mode):
    rig = make_rig()
    rig.on(cr1=mode << 16, cr2=TIM3 | TIM2)
    rig.trigger("TIM3_TRGO")
    rig.trigger("TIM2_TRGO")
    rig.clocks(100)
    assert rig.flags(2) == set()
    assert "ADC1_CR1.DUALMOD" in rig.chip.noted("misuse")


def test_modes_that_are_none_or_not_whole_are_noted(rig):
    rig.poke("CR1", 0xB << 16)
    assert rig.chip.noted("reserved") == ["ADC1_CR1.DUALMOD"]
    rig.poke("CR1", 0x3 << 16)
    assert rig.chip.noted("unmodelled") == ["ADC1_CR1.DUALMOD"]
    rig.poke("CR1", 0x6 << 16, unit=2)
    assert not rig.peek("CR1", unit=2)


@pytest.mark.parametrize(("lacking", "trigger"), [(1 << 20, "TIM3_TRGO"), (1 << 15, "TIM2_TRGO")])
def test_without_its_triggers_the_slave_takes_no_part(pair, lacking, trigger):
    rig = pair(1)
    rig.poke("CR2", rig.peek("CR2", 2) & ~lacking, unit=2)
    rig.trigger(trigger)
    rig.clocks(3 * SHORTEST)
    assert "EOC" in rig.flags(1)
    assert not rig.flags(2)
    assert rig.chip.noted("misuse") == ["ADC1_CR1.DUALMOD"]


def test_alone_the_upper_half_is_empty(rig):
    for unit in (1, 2):
        rig.on(unit=unit)
        rig.sequence(3, unit=unit)
        rig.start(unit=unit)
    rig.clocks(SHORTEST)
    assert rig.peek("DR") >> 16 == 0
