"""FLASH against PM0075: keys, programming and erase rules and times, protection, option bytes."""

from __future__ import annotations

import dataclasses
from fractions import Fraction
from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from targets.mcu.errors import BusFault
from targets.mcu.stm32f1.clocks import ClockTree, Source, rates_of
from targets.mcu.stm32f1.flash import Flash
from targets.mcu.stm32f1.options import FACTORY, decode
from targets.mcu.testing import FakeChip, peek, poke
from tests.each import each

KEY1, KEY2 = 0x4567_0123, 0xCDEF_89AB
PAGE_4 = 0x0800_1000


def build():
    chip = FakeChip()
    tree = ClockTree()
    flash = Flash(0x4002_2000, dataclasses.replace(chip.services, clocks=tree), tree, size=0x1_0000)
    world = SimpleNamespace(chip=chip, flash=flash, tree=tree, changes=[], stalls=[], waits=[])
    flash.on_code_changed = lambda address, size: world.changes.append((address, size))
    flash.stall_until = world.stalls.append
    flash.on_latency = world.waits.append
    return world


@pytest.fixture
def world():
    return build()


@pytest.fixture
def open_flash(world):
    unlock(world.flash)
    return world


def unlock(flash):
    poke(flash, "KEYR", KEY1)
    poke(flash, "KEYR", KEY2)


def unlock_options(flash):
    poke(flash, "OPTKEYR", KEY1)
    poke(flash, "OPTKEYR", KEY2)


def finish(world, seconds=Fraction(1)):
    world.chip.advance_s(seconds)


def test_reset_values(world):
    values = {name: peek(world.flash, name) for name in ("ACR", "KEYR", "OPTKEYR", "SR", "CR", "AR", "OBR", "WRPR")}
    assert values == {
        "ACR": 0x30,
        "KEYR": 0,
        "OPTKEYR": 0,
        "SR": 0,
        "CR": 0x80,
        "AR": 0,
        "OBR": 0x03FF_FFFC,
        "WRPR": 0xFFFF_FFFF,
    }


# --- wait states


def test_wait_states_are_told_when_they_change(world):
    poke(world.flash, "ACR", 0x12)
    poke(world.flash, "ACR", 0x02)
    poke(world.flash, "ACR", 0x10)
    assert world.waits == [2, 0]


def test_prefetch_status_follows_its_enable(world):
    poke(world.flash, "ACR", 0x00)
    assert peek(world.flash, "ACR") == 0x00
    poke(world.flash, "ACR", 0x12)
    assert peek(world.flash, "ACR") == 0x32


@each(("mul", "needed"), [(4, 0), (5, 1), (8, 1), (9, 2), (12, 2)])
def test_too_few_wait_states_are_noted(mul, needed):
    for wait_states in range(3):
        world = build()
        poke(world.flash, "ACR", 0x10 | wait_states)
        world.tree.set(rates_of((mul - 2) << 18 | 1 << 16, Source.PLL, Fraction(6_000_000)), stopped=False)
        world.flash.after_clock_change()
        assert ("FLASH_ACR.LATENCY" in world.chip.noted("misuse")) is (wait_states < needed)


# --- keys


def test_the_two_keys_unlock(world):
    poke(world.flash, "KEYR", KEY1)
    assert peek(world.flash, "CR") == 0x80
    poke(world.flash, "KEYR", KEY2)
    assert peek(world.flash, "CR") == 0x00


@given(wrong=st.integers(0, 0xFFFF_FFFF), second=st.booleans())
def test_a_wrong_key_is_a_bus_error_and_locks_until_reset(wrong, second):
    world = build()
    if wrong == (KEY2 if second else KEY1):
        return
    if second:
        poke(world.flash, "KEYR", KEY1)
    with pytest.raises(BusFault):
        poke(world.flash, "KEYR", wrong)
    with pytest.raises(BusFault):
        unlock(world.flash)
    assert peek(world.flash, "CR") == 0x80
    world.flash.reset()
    unlock(world.flash)
    assert peek(world.flash, "CR") == 0x00


def test_keys_while_unlocked_do_nothing(open_flash):
    unlock(open_flash.flash)
    assert peek(open_flash.flash, "CR") == 0


def test_cr_cannot_be_written_while_locked(world):
    poke(world.flash, "CR", 0x01)
    assert peek(world.flash, "CR") == 0x80
    assert world.chip.noted("misuse") == ["FLASH_CR.LOCK"]


def test_lock_can_be_written(open_flash):
    poke(open_flash.flash, "CR", 0x80)
    assert peek(open_flash.flash, "CR") == 0x80
    unlock(open_flash.flash)
    assert peek(open_flash.flash, "CR") == 0


# --- programming


def test_a_half_word_takes_52_and_a_half_microseconds(open_flash):
    world, flash = open_flash, open_flash.flash
    poke(flash, "CR", 1)
    flash.program(PAGE_4, 2, 0x1234)
    assert peek(flash, "SR") == 1
    assert world.stalls == [420]
    world.chip.advance(419)
    assert peek(flash, "SR") == 1
    assert flash.memory[0x1000:0x1002] == b"\xff\xff"
    world.chip.advance(1)
    assert peek(flash, "SR") == 0x20
    assert flash.memory[0x1000:0x1002] == b"\x34\x12"
    assert world.changes == [(PAGE_4, 2)]
    poke(flash, "SR", 0x20)
    assert peek(flash, "SR") == 0


def test_the_alias_at_zero_is_the_flash(open_flash):
    poke(open_flash.flash, "CR", 1)
    open_flash.flash.program(0x1000, 2, 0)
    finish(open_flash)
    assert open_flash.flash.memory[0x1000:0x1002] == b"\0\0"


def test_only_erased_half_words_can_be_programmed_unless_to_zero(open_flash):
    world, flash = open_flash, open_flash.flash
    flash.load(PAGE_4, b"\xff\x0f")
    poke(flash, "CR", 1)
    flash.program(PAGE_4, 2, 0x0FF0)
    assert peek(flash, "SR") == 0x04
    poke(flash, "SR", 0x04)
    flash.program(PAGE_4, 2, 0x0000)
    finish(world)
    assert peek(flash, "SR") == 0x20
    assert flash.memory[0x1000:0x1002] == b"\0\0"


@pytest.mark.parametrize("size", [1, 4])
def test_anything_but_a_half_word_is_a_bus_error(open_flash, size):
    poke(open_flash.flash, "CR", 1)
    with pytest.raises(BusFault):
        open_flash.flash.program(PAGE_4, size, 0)
    assert peek(open_flash.flash, "SR") == 0


def test_a_store_without_pg_is_a_bus_error(open_flash):
    with pytest.raises(BusFault):
        open_flash.flash.program(PAGE_4, 2, 0)


def test_registers_are_blocked_while_busy(open_flash):
    world, flash = open_flash, open_flash.flash
    poke(flash, "CR", 1)
    flash.program(PAGE_4, 2, 0x1234)
    poke(flash, "CR", 0)
    assert peek(flash, "CR") == 1
    finish(world)
    poke(flash, "CR", 0)
    assert peek(flash, "CR") == 0


def test_a_store_while_busy_waits(open_flash):
    world, flash = open_flash, open_flash.flash
    poke(flash, "CR", 1)
    for index in range(3):
        flash.program(PAGE_4 + 2 * index, 2, index + 1)
    finish(world)
    assert flash.memory[0x1000:0x1006] == b"\x01\x00\x02\x00\x03\x00"
    assert world.stalls == [420, 840, 1260]


# --- erasing


def test_erasing_a_page(open_flash):
    world, flash = open_flash, open_flash.flash
    flash.load(0x0800_0C00, bytes(0xC00))
    poke(flash, "CR", 0x02)
    poke(flash, "AR", PAGE_4 + 0x123)
    poke(flash, "CR", 0x42)
    assert peek(flash, "CR") == 0x42
    assert peek(flash, "SR") == 1
    world.chip.advance(159_999)
    assert peek(flash, "SR") == 1
    world.chip.advance(1)  # 20 ms
    assert peek(flash, "SR") == 0x20
    assert peek(flash, "CR") == 0x02
    assert flash.memory[0xC00:0x1000] == bytes(0x400)
    assert flash.memory[0x1000:0x1400] == b"\xff" * 0x400
    assert flash.memory[0x1400:0x1800] == bytes(0x400)
    assert world.changes == [(PAGE_4, 0x400)]


def test_mass_erase(open_flash):
    flash = open_flash.flash
    flash.load(0x0800_0000, bytes(0x1_0000))
    poke(flash, "CR", 0x44)
    finish(open_flash)
    assert flash.memory == b"\xff" * 0x1_0000
    assert open_flash.changes == [(0x0800_0000, 0x1_0000)]


def test_strt_with_nothing_chosen_starts_nothing(open_flash):
    poke(open_flash.flash, "CR", 0x40)
    assert peek(open_flash.flash, "SR") == 0
    assert peek(open_flash.flash, "CR") == 0
    poke(open_flash.flash, "CR", 0x42)  # AR is 0: not in flash
    assert peek(open_flash.flash, "SR") == 0


def test_contents_survive_a_reset_and_an_operation_does_not(open_flash):
    world, flash = open_flash, open_flash.flash
    flash.load(PAGE_4, b"\x01\x02")
    poke(flash, "AR", PAGE_4)
    poke(flash, "CR", 0x02)
    poke(flash, "CR", 0x42)
    flash.reset()
    finish(world)
    assert peek(flash, "SR") == 0
    assert peek(flash, "CR") == 0x80
    assert flash.memory[0x1000:0x1002] == b"\x01\x02"


# --- interrupts


def test_end_of_operation_interrupt(open_flash):
    world, flash = open_flash, open_flash.flash
    poke(flash, "CR", 0x1001)
    flash.program(PAGE_4, 2, 1)
    assert not world.chip.irq(4).level
    finish(world)
    assert world.chip.irq(4).rises == [420]
    poke(flash, "SR", 0x20)
    assert not world.chip.irq(4).level


def test_error_interrupt(open_flash):
    world, flash = open_flash, open_flash.flash
    flash.load(PAGE_4, b"\0\0")
    poke(flash, "CR", 0x0001)
    flash.program(PAGE_4, 2, 1)
    assert not world.chip.irq(4).level
    poke(flash, "CR", 0x0401)
    assert world.chip.irq(4).level
    poke(flash, "SR", 0x04)
    assert not world.chip.irq(4).level


# --- option bytes and protection


def write_option(world, offset, value):
    flash = world.flash
    poke(flash, "CR", 0x210)
    flash.program(0x1FFF_F800 + offset, 2, value)
    finish(world)


def erase_options(world):
    unlock_options(world.flash)
    poke(world.flash, "CR", 0x220)
    poke(world.flash, "CR", 0x260)
    finish(world)


def test_factory_options():
    settings = decode(FACTORY)
    assert settings.obr == 0x03FF_FFFC
    assert settings.wrpr == 0xFFFF_FFFF
    assert not settings.read_protected
    assert not settings.hardware_watchdog


def test_optwre_needs_its_keys(open_flash):
    poke(open_flash.flash, "CR", 0x200)
    assert peek(open_flash.flash, "CR") == 0
    unlock_options(open_flash.flash)
    assert peek(open_flash.flash, "CR") == 0x200
    poke(open_flash.flash, "CR", 0)
    assert peek(open_flash.flash, "CR") == 0


def test_options_need_optwre(open_flash):
    poke(open_flash.flash, "CR", 0x10)
    with pytest.raises(BusFault):
        open_flash.flash.program(0x1FFF_F804, 2, 0x55)


def test_an_option_gets_its_complement_and_counts_after_reset(open_flash):
    world, flash = open_flash, open_flash.flash
    erase_options(world)
    assert flash.options == b"\xff" * 16
    write_option(world, 0, 0xA5)
    write_option(world, 4, 0x12)
    assert flash.options[:6] == b"\xa5\x5a\xff\xff\x12\xed"
    assert peek(flash, "OBR") == 0x03FF_FFFC
    flash.reset()
    assert peek(flash, "OBR") == 0x03FC_4BFC


def test_a_programmed_option_cannot_be_programmed_again(open_flash):
    unlock_options(open_flash.flash)
    write_option(open_flash, 0, 0x00)
    assert peek(open_flash.flash, "SR") == 0x04


def test_write_protection(open_flash):
    world, flash = open_flash, open_flash.flash
    erase_options(world)
    write_option(world, 0, 0xA5)
    write_option(world, 8, 0xFD)  # WRP0: pages 4 to 7
    flash.reset()
    assert peek(flash, "WRPR") == 0xFFFF_FFFD
    unlock(flash)
    for address, status in ((0x0800_0FFE, 0x20), (0x0800_1000, 0x10), (0x0800_1FFE, 0x10), (0x0800_2000, 0x20)):
        poke(flash, "CR", 0x01)
        flash.program(address, 2, 0x5555)
        finish(world)
        assert peek(flash, "SR") == status, hex(address)
        poke(flash, "SR", 0x34)
    poke(flash, "AR", 0x0800_1400)
    poke(flash, "CR", 0x42)
    assert peek(flash, "SR") == 0x10
    assert peek(flash, "CR") == 0x02
    poke(flash, "SR", 0x10)
    poke(flash, "CR", 0x44)
    assert peek(flash, "SR") == 0x10


def test_read_protection_guards_the_first_pages_and_costs_the_flash_to_take_off(open_flash):
    world, flash = open_flash, open_flash.flash
    flash.load(0x0800_4000, b"secret")
    erase_options(world)
    flash.reset()
    assert peek(flash, "OBR") & 2
    unlock(flash)
    poke(flash, "CR", 1)
    flash.program(0x0800_0FFE, 2, 1)
    assert peek(flash, "SR") == 0x10
    poke(flash, "SR", 0x30)
    unlock_options(flash)
    write_option(world, 0, 0xA5)
    assert flash.memory[0x4000:0x4006] == b"\xff" * 6
    flash.reset()
    assert not peek(flash, "OBR") & 2


@given(values=st.binary(min_size=8, max_size=8))
def test_matching_options_decode_to_what_was_stored(values):
    stored = bytes(part for value in values for part in (value, value ^ 0xFF))
    settings = decode(stored)
    assert not settings.obr & 1
    assert settings.obr >> 2 & 0xFF == values[1]
    assert settings.obr >> 10 & 0xFF == values[2]
    assert settings.obr >> 18 & 0xFF == values[3]
    assert settings.wrpr.to_bytes(4, "little") == values[4:]
    assert settings.read_protected is (values[0] != 0xA5)
    assert settings.hardware_watchdog is not bool(values[1] & 1)


@given(index=st.integers(1, 7), flip=st.integers(1, 0xFE))
def test_a_byte_beside_a_wrong_complement_counts_as_erased(index, flip):
    stored = bytearray(FACTORY)
    stored[2 * index + 1] ^= flip
    settings = decode(stored)
    assert settings.obr == 0x03FF_FFFD
    assert settings.wrpr == 0xFFFF_FFFF


def test_loading_outside_of_flash_is_refused(world):
    with pytest.raises(BusFault):
        world.flash.load(0x0800_FFFF, b"ab")
