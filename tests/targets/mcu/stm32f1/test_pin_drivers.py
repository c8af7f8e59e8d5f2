"""Ports, AFIO and EXTI as drivers use them: StdPeriph, STM32 HAL, libopencm3, Arduino core."""

from __future__ import annotations

import pytest

from targets.mcu.pins import PadMode
from targets.mcu.testing import peek, poke

KEY = 1 << 16


def modify(peripheral, register, clear=0, put=0):
    poke(peripheral, register, peek(peripheral, register) & ~clear | put)


# --- the lock


def hal_lock_pin(port, pins):
    """HAL_GPIO_LockPin: its status."""
    for value in (KEY | pins, pins, KEY | pins):
        poke(port, "LCKR", value)
    peek(port, "LCKR")
    return bool(peek(port, "LCKR") & KEY)


def test_locks_of_the_drivers_succeed_once(pinout):
    port = pinout.ports["A"]
    pinout.mode("PA3", 0b0011)
    assert hal_lock_pin(port, 1 << 3)
    pinout.mode("PA3", 0b0100)
    assert pinout.pins["PA3"]._mode is PadMode.PUSH_PULL
    pinout.mode("PA4", 0b0011)
    assert pinout.pins["PA4"]._mode is PadMode.PUSH_PULL
    assert hal_lock_pin(port, 1 << 4)  # the status says locked, of the first lock
    pinout.mode("PA4", 0b0100)
    assert pinout.pins["PA4"]._mode is PadMode.INPUT


# --- remapping


def std_periph_remap(afio, remap, on=True):
    """GPIO_PinRemapConfig of the StdPeriph library, with its constants."""
    value = peek(afio, "MAPR")
    shift, bits = (remap & 0x000F_0000) >> 16, remap & 0xFFFF
    if remap & 0x0030_0000 == 0x0030_0000:
        value &= 0xF0FF_FFFF
        poke(afio, "MAPR", peek(afio, "MAPR") & 0xF0FF_FFFF)
    elif remap & 0x0010_0000:
        value = value & ~(3 << shift) | 0x0F00_0000
    else:
        value = value & ~(bits << (remap >> 21) * 16) | 0x0F00_0000
    if on:
        value |= bits << (remap >> 21) * 16
    poke(afio, "MAPR", value & 0xFFFF_FFFF)


PARTIAL_TIM3, FULL_TIM2, REMAP_USART1, JTAG_DISABLE = 0x001A_0800, 0x0018_0300, 0x0000_0004, 0x0030_0200


@pytest.mark.parametrize("jtag_first", [True, False])
def test_std_periph_remaps_in_any_order(pinout, jtag_first):
    """It writes SWJ_CFG = 111 with every other remap, which leaves the debug pins as they are."""
    remaps = [PARTIAL_TIM3, FULL_TIM2, REMAP_USART1]
    for remap in [JTAG_DISABLE, *remaps] if jtag_first else [*remaps, JTAG_DISABLE]:
        std_periph_remap(pinout.afio, remap)
    routes = [pinout.signals.route_of(name) for name in ("TIM3_CH1", "TIM2_CH1", "TIM2_CH4", "USART1_TX")]
    assert routes == ["PB4", "PA15", "PB11", "PB6"]
    assert [pinout.pins[name].claimed_by is None for name in ("PA13", "PA14", "PA15", "PB3", "PB4")] == [
        False, False, True, True, True,
    ]  # fmt: skip
    std_periph_remap(pinout.afio, FULL_TIM2, on=False)
    assert pinout.signals.route_of("TIM2_CH1") == "PA0"
    assert pinout.pins["PB3"].claimed_by is None


def test_hal_remaps(pinout):
    """__HAL_AFIO_REMAP_SWJ_NOJTAG and then __HAL_AFIO_REMAP_TIM3_PARTIAL, as read-modify-writes."""
    modify(pinout.afio, "MAPR", 7 << 24, 2 << 24)
    modify(pinout.afio, "MAPR", 3 << 10, 7 << 24 | 2 << 10)
    assert pinout.signals.route_of("TIM3_CH2") == "PB5"
    assert pinout.pins["PA15"].claimed_by is None
    assert peek(pinout.afio, "MAPR") == 7 << 24 | 2 << 10


def test_a_freed_jtag_pin_is_a_pin_like_any_other(pinout):
    pin = pinout.pins["PB3"]
    pinout.mode("PB3", 0b0011)
    poke(pinout.ports["B"], "BSRR", 1 << 3)
    assert pin.level is None
    poke(pinout.afio, "MAPR", 2 << 24)
    assert pin.level is True
    poke(pinout.ports["B"], "BRR", 1 << 3)
    assert pin.level is False


# --- external interrupts


def hal_exti_init(pinout, port, number, *, rising=False, falling=False, pull=None, event=False):
    """HAL_GPIO_Init with GPIO_MODE_IT_... or GPIO_MODE_EVT_...."""
    bit = 1 << number
    if pull is not None:
        poke(pinout.ports[port], "BSRR" if pull else "BRR", bit)
    pinout.mode(f"P{port}{number}", 0b0100 if pull is None else 0b1000)
    register, shift = f"EXTICR{number // 4 + 1}", 4 * (number % 4)
    modify(pinout.afio, register, 0xF << shift, "ABCDE".index(port) << shift)
    for name, on in (("RTSR", rising), ("FTSR", falling), ("EMR", event), ("IMR", not event)):
        modify(pinout.exti, name, bit, bit if on else 0)


def test_a_button_with_a_pull_up(pinout):
    """Setting the line up makes no interrupt, although routing it to the port changes its level."""
    hal_exti_init(pinout, "B", 5, falling=True, pull=True)
    line = pinout.chip.irq(23)
    assert not line.level
    pinout.chip.advance(100)
    pinout.pins["PB5"].drive(False)
    assert line.rises == [100]
    assert peek(pinout.exti, "PR") == 1 << 5
    poke(pinout.exti, "PR", 1 << 5)
    assert not line.level
    pinout.pins["PB5"].drive(None)
    assert not line.level


def test_lines_that_share_an_interrupt_are_served_one_by_one(pinout):
    """HAL_GPIO_EXTI_IRQHandler clears the bit of its pin; the request stays until all are cleared."""
    for number in (6, 7, 9):
        hal_exti_init(pinout, "A", number, rising=True, pull=False)
    for number in (6, 7, 9):
        pinout.pins[f"PA{number}"].drive(True)
    for number, still in ((6, True), (7, True), (9, False)):
        assert peek(pinout.exti, "PR") & 1 << number
        poke(pinout.exti, "PR", 1 << number)
        assert pinout.chip.irq(23).level is still


def test_clearing_by_read_modify_write_clears_all(pinout):
    for number in (6, 7):
        hal_exti_init(pinout, "A", number, rising=True, pull=False)
        pinout.pins[f"PA{number}"].drive(True)
    modify(pinout.exti, "PR", 0, 1 << 6)
    assert peek(pinout.exti, "PR") == 0


def test_both_edges_of_a_fast_input_are_counted(pinout):
    """An encoder by interrupts, as Arduino libraries do it: every edge, none twice."""
    hal_exti_init(pinout, "A", 1, rising=True, falling=True)
    edges = 0
    for number in range(1_000):
        pinout.chip.advance(720)
        pinout.pins["PA1"].drive(number % 2 == 0)
        edges += pinout.chip.irq(7).level
        poke(pinout.exti, "PR", 1 << 1)
    assert edges == 1_000


def test_an_event_sets_no_pending_bit(pinout):
    events = []
    pinout.exti.on_event = lambda: events.append(pinout.chip.time.now)
    hal_exti_init(pinout, "C", 13, rising=True, event=True)
    pinout.chip.advance(7)
    pinout.pins["PC13"].drive(True)
    assert events == [7]
    assert peek(pinout.exti, "PR") == 0
    assert not pinout.chip.irq(40).level


def test_a_software_interrupt_wants_imr_and_can_be_repeated_after_pr(pinout):
    """SWIER without IMR leaves its bit set; it then makes no interrupt before PR is cleared (the edge is 0 to 1)."""
    poke(pinout.exti, "SWIER", 1 << 4)
    poke(pinout.exti, "IMR", 1 << 4)
    assert not pinout.chip.irq(10).level
    poke(pinout.exti, "SWIER", 1 << 4)
    assert not pinout.chip.irq(10).level
    poke(pinout.exti, "PR", 1 << 4)
    assert peek(pinout.exti, "SWIER") == 0
    poke(pinout.exti, "SWIER", 1 << 4)
    assert pinout.chip.irq(10).level


def test_an_output_of_the_program_can_interrupt_it(pinout):
    hal_exti_init(pinout, "A", 2, rising=True)
    pinout.mode("PA2", 0b0011)
    poke(pinout.ports["A"], "BSRR", 1 << 2)
    assert pinout.chip.irq(8).level
