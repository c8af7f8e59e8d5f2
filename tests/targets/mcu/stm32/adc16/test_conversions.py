"""Conversions of a 16-bit ADC: how long they take, in which order, what comes of them (RM0433 section 25.4)."""

from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

ADSTART, JADSTART, ADSTP = 1 << 2, 1 << 3, 1 << 4
ONE_SHOT, CIRCULAR, OVRMOD, CONT, AUTDLY, DISCEN = 1, 3, 1 << 12, 1 << 13, 1 << 14, 1 << 16
JAUTO, AWD1SGL, AWD1EN = 1 << 25, 1 << 22, 1 << 23
RISING = 1 << 10
SAMPLING = [Fraction(twice, 2) for twice in (3, 5, 17, 33, 65, 129, 775, 1621)]
CONVERSION = {16: Fraction(17, 2), 14: Fraction(15, 2), 12: Fraction(13, 2), 10: Fraction(11, 2), 8: Fraction(9, 2)}
CYCLES = 16


# --- times


@pytest.mark.parametrize("bits", CONVERSION)
@pytest.mark.parametrize("smp", range(8))
def test_a_conversion_takes_its_time(rig, expected, bits, smp):
    rig.on(bits=bits)
    rig.sequence(5)
    rig.sampling(smp)
    start = rig.chip.time.now
    rig.start()
    rig.chip.advance_to(start + CYCLES * SAMPLING[smp] - 1)
    assert not rig.flags()
    rig.chip.advance(1)
    assert rig.flags() == {"EOSMP"}
    rig.chip.advance_to(start + CYCLES * (SAMPLING[smp] + CONVERSION[bits]) - 1)
    assert rig.flags() == {"EOSMP"}
    rig.chip.advance(1)
    assert rig.flags() == {"EOSMP", "EOC", "EOS"}
    assert not rig.peek("CR") & ADSTART
    assert rig.peek("DR") == expected(0.5, bits)
    assert rig.flags() == {"EOSMP", "EOS"}


PRESCALERS = (1, 2, 4, 6, 8, 10, 12, 16, 32, 64, 128, 256)


@pytest.mark.parametrize(
    ("ccr", "cycles"),
    [(presc << 18, 16 * divider) for presc, divider in enumerate(PRESCALERS)]
    + [(1 << 16, 4), (2 << 16, 8), (3 << 16, 16)],
)
def test_the_clock_of_revision_v(rig, ccr, cycles):
    """The kernel clock or that of AHB, which takes two cycles here, divided and then halved."""
    rig.on()
    rig.poke("CCR", ccr)
    rig.sequence(1)
    start = rig.chip.time.now
    rig.start()
    rig.chip.advance_to(start + 10 * cycles - 1)
    assert "EOC" not in rig.flags()
    rig.chip.advance(1)
    assert "EOC" in rig.flags()


def test_a_joystick_at_full_length(make_rig, expected):
    """ADC at 60 MHz / 256 / 2, channels 6 and 2 for 387.5 clocks each, without end: 396 clocks a result, exactly."""
    rig = make_rig()
    rig.poke("CCR", 11 << 18)
    rig.on(cfgr=CONT | OVRMOD | CIRCULAR, boost=0)
    rig.chip.advance(100_000)
    rig.sequence(6, 2)
    rig.sampling(6)
    rig.volts |= {6: 1.65, 2: 3.3}
    found = rig.drain()
    start = rig.chip.time.now
    rig.start()
    rig.chip.advance(4096 * 396 * 8 + 1)
    assert [value for _, value in found] == [expected(1.65), expected(3.3)] * 4
    assert [cycle - start - 1 for cycle, _ in found] == [4096 * 396 * number for number in range(1, 9)]
    assert not rig.flags() & {"OVR"}
    assert not rig.chip.noted("misuse")


def test_a_clock_that_is_no_whole_number_of_cycles_does_not_drift(make_rig):
    """7 MHz beside 480 MHz: a clock takes 960/7 cycles, a result 9600/7; each comes at the first cycle not before."""
    rig = make_rig(kernel_hz=7_000_000)
    rig.on(cfgr=CONT | OVRMOD | CIRCULAR)
    rig.chip.advance(10_000)
    rig.sequence(1)
    found = rig.drain()
    start = rig.chip.time.now
    rig.start()
    rig.chip.advance(200_000)
    assert len(found) == 145
    assert [cycle - start - 1 for cycle, _ in found] == [-(-9600 * n // 7) for n in range(1, 146)]


def test_a_change_of_the_clock_in_the_midst_of_a_conversion(rig):
    rig.on()
    rig.sequence(1)
    start = rig.chip.time.now
    rig.start()
    rig.chip.advance(5 * CYCLES)
    rig.kernel_hz /= 4
    rig.adc.after_clock_change()
    rig.chip.advance_to(start + 5 * CYCLES + 20 * CYCLES - 1)
    assert "EOC" not in rig.flags()
    rig.chip.advance(1)
    assert "EOC" in rig.flags()


# --- order


@given(
    channels=st.lists(st.integers(0, 15), min_size=1, max_size=16),
    smps=st.lists(st.integers(0, 5), min_size=20, max_size=20),
    bits=st.sampled_from(sorted(CONVERSION)),
)
def test_a_sequence_gives_each_channel_in_its_turn(make_rig, expected, channels, smps, bits):
    rig = make_rig().on(cfgr=OVRMOD | CIRCULAR, bits=bits)
    rig.sequence(*channels)
    for channel, smp in enumerate(smps):
        rig.sampling(smp, channel)
    found = rig.drain()
    start = rig.chip.time.now
    rig.start()
    rig.clocks(20 * 140)
    ends, clock = [], 0
    for channel in channels:
        clock += SAMPLING[smps[channel]] + CONVERSION[bits]
        ends.append(clock * CYCLES)
    assert [cycle - start - 1 for cycle, _ in found] == ends
    assert [value for _, value in found] == [expected(channel / 10, bits) for channel in channels]
    assert "EOS" in rig.flags()
    assert not rig.peek("CR") & ADSTART


def test_the_voltage_counts_at_the_end_of_the_sampling_time(rig, expected):
    rig.on()
    rig.sequence(1)
    rig.sampling(3)
    rig.start()
    rig.chip.advance(16 * CYCLES)
    rig.volts[1] = 2.0
    rig.chip.advance(8)
    rig.volts[1] = 3.0
    rig.clocks(10)
    assert rig.peek("DR") == expected(2.0)


def test_discontinuous_mode_takes_some_steps_with_each_start(rig, expected):
    """Two at a time of a sequence of three: the second start takes what is left."""
    rig.on(cfgr=DISCEN | 1 << 17)
    rig.sequence(1, 2, 3)
    seen = []
    for steps in (2, 1):
        rig.start()
        for _ in range(steps):
            assert rig.peek("CR") & ADSTART
            rig.clocks(10)
            seen.append((rig.peek("DR"), "EOS" in rig.flags()))
        assert not rig.peek("CR") & ADSTART
    assert seen == [(expected(0.1), False), (expected(0.2), False), (expected(0.3), True)]


def test_a_trigger_starts_what_was_asked_for(rig, expected):
    rig.on(cfgr=RISING | 13 << 5)
    rig.sequence(4)
    rig.trigger("TIM6_TRGO", True)
    rig.clocks(20)
    assert not rig.flags()
    rig.trigger("TIM6_TRGO", False)
    rig.start()
    for _ in range(3):
        rig.trigger("TIM6_TRGO", True)
        rig.clocks(10)
        assert rig.peek("DR") == expected(0.4)
        rig.trigger("TIM6_TRGO", False)
    assert rig.peek("CR") & ADSTART
    rig.set("CR", ADSTP)
    rig.clear()
    rig.trigger("TIM6_TRGO", True)
    rig.clocks(20)
    assert not rig.flags()


def test_a_trigger_that_is_not_modelled_says_so(rig):
    rig.on(cfgr=RISING | 6 << 5)
    rig.start()
    assert rig.chip.noted("unmodelled") == ["ADC1_CFGR.EXTSEL"]


def test_stop_ends_a_conversion_without_a_result(rig):
    rig.on(cfgr=CONT)
    rig.sequence(1)
    rig.start()
    rig.clocks(9)
    rig.set("CR", ADSTP)
    rig.clocks(100)
    assert rig.flags() == {"EOSMP"}
    rig.start()
    rig.clocks(10)
    assert "EOC" in rig.flags()


# --- overrun and DMA


def test_an_overrun_preserves_the_old_result(rig, expected):
    rig.on(cfgr=CONT)
    rig.sequence(1, 2)
    rig.start()
    rig.clocks(20)
    assert rig.flags() == {"EOSMP", "EOC", "EOS", "OVR"}
    assert rig.peek("DR") == expected(0.1)
    rig.clocks(20)
    assert not rig.flags() & {"EOC"}, "while OVR is set what comes is lost"
    rig.clear()
    rig.clocks(10)
    assert rig.peek("DR") == expected(0.1)


def test_an_overrun_may_overwrite_it(rig, expected):
    rig.on(cfgr=CONT | OVRMOD)
    rig.sequence(1, 2)
    rig.start()
    rig.clocks(20)
    assert rig.flags() == {"EOSMP", "EOC", "EOS", "OVR"}
    assert rig.peek("DR") == expected(0.2)


def test_an_overrun_blocks_requests_until_it_is_cleared(rig):
    rig.on(cfgr=CONT | OVRMOD | CIRCULAR)
    rig.sequence(1)
    rig.poke("IER", 1 << 4)
    rig.start()
    rig.clocks(10)
    assert rig.requests.line("ADC1").level
    rig.clocks(10)
    assert not rig.requests.line("ADC1").level
    assert rig.irq.level
    rig.clear("OVR")
    assert not rig.irq.level
    assert rig.requests.line("ADC1").level


@pytest.mark.parametrize(("mode", "more"), [(ONE_SHOT, False), (CIRCULAR, True)])
def test_after_the_last_transfer_one_shot_mode_asks_no_more(rig, mode, more):
    rig.on(cfgr=CONT | OVRMOD | mode)
    rig.sequence(1)
    rig.start()
    rig.clocks(10)
    line = rig.requests.line("ADC1")
    assert line.level
    rig.peek("DR")
    line.on_last()
    rig.clocks(10)
    assert line.level is more


def test_without_dmngt_nobody_is_asked(rig):
    rig.on()
    rig.sequence(1)
    rig.start()
    rig.clocks(10)
    assert not rig.requests.line("ADC1").level


def test_auto_delay_waits_until_the_result_was_read(rig):
    rig.on(cfgr=CONT | AUTDLY)
    rig.sequence(1)
    rig.start()
    rig.clocks(50)
    assert rig.flags() == {"EOSMP", "EOC", "EOS"}
    rig.peek("DR")
    rig.clocks(9)
    assert "EOC" not in rig.flags()
    rig.clocks(1)
    assert "EOC" in rig.flags()


# --- injected group


def test_injected_channels_break_in(rig, expected):
    rig.on(cfgr=OVRMOD)
    rig.sequence(1)
    rig.injected(3, 4)
    rig.start()
    rig.clocks(5)
    rig.start(JADSTART)
    rig.clocks(10)
    assert rig.flags() >= {"JEOC"}
    assert "JEOS" not in rig.flags()
    rig.clocks(10)
    assert "JEOS" in rig.flags()
    assert not rig.peek("CR") & JADSTART
    assert "EOC" not in rig.flags(), "the regular conversion begins anew"
    assert [rig.peek("JDR1"), rig.peek("JDR2")] == [expected(0.3), expected(0.4)]
    assert "JEOC" not in rig.flags()
    rig.clocks(10)
    assert rig.peek("DR") == expected(0.1)


def test_injected_channels_may_follow_the_regular_ones(rig, expected):
    rig.on(cfgr=JAUTO)
    rig.sequence(1)
    rig.injected(3)
    rig.start()
    rig.clocks(20)
    assert rig.flags() >= {"EOS", "JEOS"}
    assert rig.peek("JDR1") == expected(0.3)


def test_an_injected_trigger(rig, expected):
    rig.on()
    rig.injected(3, trigger=1 << 7 | 14 << 2)
    rig.start(JADSTART)
    rig.trigger("TIM6_TRGO", True)
    rig.clocks(10)
    assert rig.peek("JDR1") == expected(0.3)
    assert rig.peek("CR") & JADSTART


# --- what becomes of a result


@given(volts=st.floats(-1, 4), bits=st.sampled_from(sorted(CONVERSION)))
def test_the_code_of_a_voltage(make_rig, volts, bits):
    rig = make_rig().on(bits=bits)
    rig.volts[0] = volts
    rig.sequence(0)
    rig.start()
    rig.clocks(10)
    steps = 1 << bits
    assert rig.peek("DR") == max(0, min(steps - 1, int(volts / 3.3 * steps + 0.5)))


@pytest.mark.parametrize(
    ("ofr", "bits", "dr"),
    [
        (5 << 26 | 0x1000, 16, 9930 - 0x1000),
        (4 << 26 | 0x1000, 16, 9930),
        (5 << 26 | 0x8000, 16, (9930 - 0x8000) & 0xFFFF_FFFF),
        (5 << 26 | 0x0100, 12, 621 - 0x10),
        (5 << 26 | 0xFFFF, 8, (39 - 0xFF) & 0xFFFF_FFFF),
        (1 << 31 | 5 << 26 | 0xFFFF, 8, -128 & 0xFFFF_FFFF),
    ],
)
def test_an_offset_is_subtracted_from_its_channel(rig, ofr, bits, dr):
    rig.on(bits=bits)
    rig.poke("OFR2", ofr)
    rig.sequence(5)
    rig.start()
    rig.clocks(10)
    assert rig.peek("DR") == dr


@given(ratio=st.integers(1, 64), shift=st.integers(0, 8), left=st.integers(0, 3))
def test_oversampling_adds_and_shifts(make_rig, expected, ratio, shift, left):
    rig = make_rig().on(cfgr2=1 | shift << 5 | ratio - 1 << 16 | left << 28)
    rig.sequence(5)
    rig.start()
    rig.clocks(10 * ratio - 1)
    assert "EOC" not in rig.flags()
    rig.clocks(1)
    assert rig.flags() == {"EOSMP", "EOC", "EOS"}
    assert rig.peek("DR") == (expected(0.5) * ratio >> shift) << left


def test_triggered_oversampling_adds_one_with_each_start(rig, expected):
    rig.on(cfgr=RISING | 13 << 5, cfgr2=1 | 1 << 9 | 2 << 16)
    rig.sequence(5, 6)
    rig.start()
    found = []
    for _ in range(6):
        rig.trigger("TIM6_TRGO", True)
        rig.trigger("TIM6_TRGO", False)
        rig.clocks(10)
        found.append((rig.peek("DR") if "EOC" in rig.flags() else None, "EOS" in rig.flags()))
    assert found == [(None, False)] * 2 + [(3 * expected(0.5), False)] * 1 + [(None, False)] * 2 + [
        (3 * expected(0.6), True)
    ]


@pytest.mark.parametrize(
    ("volts", "bits", "flags"),
    [(1.0, 16, set()), (0.4, 16, {"AWD1"}), (2.5, 12, {"AWD1"}), (1.0, 12, set())],
)
def test_the_first_watchdog_looks_at_what_cfgr_says(rig, volts, bits, flags):
    rig.on(cfgr=AWD1EN | AWD1SGL | 3 << 26, bits=bits)
    rig.volts |= {2: 0.0, 3: volts}
    rig.poke("LTR1", 0x2800)
    rig.poke("HTR1", 0x8000)
    rig.sequence(3, 2)
    rig.start()
    rig.clocks(20)
    assert rig.flags() & {"AWD1", "AWD2", "AWD3"} == flags


def test_the_other_watchdogs_have_channels_of_their_own(rig):
    rig.on()
    rig.poke("AWD2CR", 1 << 2)
    rig.poke("HTR2", 0x0100)
    rig.poke("AWD3CR", 1 << 3)
    rig.poke("LTR3", 0x0100)
    rig.poke("IER", 1 << 8)
    rig.sequence(3, 2)
    rig.start()
    rig.clocks(10)
    assert not rig.irq.level
    rig.clocks(10)
    assert rig.flags() & {"AWD1", "AWD2", "AWD3"} == {"AWD2"}
    assert rig.irq.level


# --- inputs


def test_a_channel_that_is_not_preselected_sees_nothing(rig):
    rig.on()
    rig.poke("PCSEL", 1 << 4)
    rig.sequence(5)
    rig.start()
    rig.clocks(10)
    assert rig.peek("DR") == 0
    assert rig.chip.noted("misuse") == ["ADC1_PCSEL"]


def test_a_pin_that_floats_is_zero_volts(rig):
    rig.on()
    rig.volts[5] = None
    rig.sequence(5)
    rig.start()
    rig.clocks(10)
    assert rig.peek("DR") == 0
    assert rig.chip.noted("misuse") == ["ADC1.INP5"]


@pytest.mark.parametrize(("channel", "bit", "volts"), [(17, 24, 3.3 / 4), (18, 23, 0.61), (19, 22, 1.216)])
def test_channels_inside_the_chip(rig, expected, channel, bit, volts):
    rig.on(unit=2)
    rig.sequence(channel, unit=2)
    for ccr, seen in ((0, 0), (1 << bit, expected(volts))):
        rig.poke("CCR", ccr)
        rig.set("ADC2_CR", ADSTART)
        rig.clocks(10)
        assert rig.peek("ADC2_DR") == seen


def test_too_fast_for_boost_is_noted(make_rig):
    for kernel_hz, boost, noted in ((12_500_000, 0, []), (12_600_000, 0, ["ADC1_CR.BOOST"]), (50_000_000, 2, [])):
        rig = make_rig(kernel_hz=kernel_hz).on(boost=boost)
        assert rig.chip.noted("misuse") == noted


def test_both_converters_share_status_and_interrupt(rig):
    rig.on().on(unit=2)
    rig.sequence(1, unit=2)
    rig.poke("ADC2_IER", 1 << 2)
    rig.set("ADC2_CR", ADSTART)
    rig.clocks(10)
    assert rig.peek("CSR") == 0x000F_0001
    assert rig.irq.level
    rig.peek("ADC2_DR")
    assert not rig.irq.level
