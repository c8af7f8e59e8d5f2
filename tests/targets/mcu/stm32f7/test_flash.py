"""FLASH against RM0410 section 3: sectors, programming by width, errors, protection, option bytes, wait states."""

from __future__ import annotations

import dataclasses
from fractions import Fraction
from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from targets.mcu.errors import BusFault
from targets.mcu.stm32f7.clocks import ClockTree, Rates
from targets.mcu.stm32f7.flash import Flash
from targets.mcu.stm32f7.options import FACTORY_OPTCR, FACTORY_OPTCR1, Options, decode, encode
from targets.mcu.stm32f7.sectors import sectors_of
from targets.mcu.testing import FakeChip, peek, poke
from tests.each import each

BASE = 0x0800_0000
KB = 1024
PG, SER, MER1, MER2, STRT, EOPIE, ERRIE, LOCK = (1 << bit for bit in (0, 1, 2, 15, 16, 24, 25, 31))
X32 = 2 << 8
EOP, OPERR, WRPERR, PGAERR, PGPERR, ERSERR, BSY = (1 << bit for bit in (0, 1, 4, 5, 6, 7, 16))
US = Fraction(1, 1_000_000)


def build(size=2048 * KB):
    chip = FakeChip(hclk_hz=16_000_000)
    tree = ClockTree()
    flash = chip.add(Flash(0x4002_3C00, dataclasses.replace(chip.services, clocks=tree), tree, size=size))
    world = SimpleNamespace(chip=chip, flash=flash, tree=tree, changed=[], latency=[], stalls=[])
    flash.on_code_changed = lambda address, size: world.changed.append((address, size))
    flash.on_latency = world.latency.append
    flash.stall_until = world.stalls.append
    return world


def unlock(world):
    poke(world.flash, "KEYR", 0x4567_0123)
    poke(world.flash, "KEYR", 0xCDEF_89AB)
    return world


@pytest.fixture
def locked():
    return build()


@pytest.fixture
def world():
    return unlock(build())


def word(world, offset):
    return int.from_bytes(world.flash.memory[offset : offset + 4], "little")


# --- sectors


@each(
    ("size_kb", "dual", "sizes"),
    [
        (2048, False, [*[32] * 4, 128, *[256] * 7]),
        (1024, False, [*[32] * 4, 128, *[256] * 3]),
        (2048, True, 2 * [*[16] * 4, 64, *[128] * 7]),
        (1024, True, 2 * [*[16] * 4, 64, *[128] * 3]),
    ],
)
def test_sectors_are_those_of_the_tables(size_kb, dual, sizes):
    sectors = sectors_of(size_kb * KB, dual_bank=dual)
    assert [sector.size // KB for sector in sectors] == sizes
    assert [sector.index for sector in sectors] == list(range(len(sizes)))
    assert [one.offset + one.size for one in sectors] == [*(one.offset for one in sectors[1:]), size_kb * KB]
    if dual:
        assert [sector.number for sector in sectors[len(sizes) // 2 :]][:2] == [16, 17], "bit 4 of SNB is bank 2"


# --- programming


def test_locked_until_both_keys(locked):
    locked.flash.program(BASE, 4, 0)
    assert (word(locked, 0), peek(locked.flash, "SR")) == (0xFFFF_FFFF, ERSERR)
    poke(locked.flash, "CR", PG)
    assert peek(locked.flash, "CR") == LOCK
    poke(locked.flash, "KEYR", 0x4567_0123)
    with pytest.raises(BusFault, match="FLASH_KEYR got a wrong key"):
        poke(locked.flash, "KEYR", 0x4567_0123)
    with pytest.raises(BusFault):
        poke(locked.flash, "KEYR", 0x4567_0123)
    locked.flash.reset()
    assert peek(unlock(locked).flash, "CR") == 0


@given(
    width=st.integers(0, 2),
    stores=st.lists(st.tuples(st.integers(0, 15), st.integers(0, 0xFFFF_FFFF)), min_size=1, max_size=8),
)
def test_programming_clears_bits_and_sets_none(width, stores):
    world = unlock(build())
    size = 1 << width
    naive = bytearray(b"\xff" * 64)
    poke(world.flash, "CR", PG | width << 8)
    for slot, value in stores:
        value &= (1 << 8 * size) - 1
        world.flash.program(BASE + slot * size, size, value)
        for index, byte in enumerate(value.to_bytes(size, "little")):
            naive[slot * size + index] &= byte
    world.chip.advance_s(len(stores) * 16 * US)
    assert world.flash.memory[:64] == naive
    assert not peek(world.flash, "SR")


def test_a_word_takes_16_us_and_both_addresses_are_told(world):
    poke(world.flash, "CR", PG | X32)
    world.flash.program(BASE + 8, 4, 0x1234_5678)
    assert (peek(world.flash, "SR"), word(world, 8), world.stalls) == (BSY, 0xFFFF_FFFF, [256])
    world.chip.advance(255)
    assert peek(world.flash, "SR") == BSY
    world.chip.advance(1)
    assert (peek(world.flash, "SR"), word(world, 8)) == (0, 0x1234_5678)
    assert world.changed == [(BASE + 8, 4), (0x0020_0008, 4)]


def test_stores_while_busy_follow_one_another(world):
    poke(world.flash, "CR", PG | X32)
    for index in range(3):
        world.flash.program(BASE + 4 * index, 4, index)
    world.chip.advance(3 * 256 - 1)
    assert [word(world, 4 * index) for index in range(3)] == [0, 1, 0xFFFF_FFFF]
    world.chip.advance(1)
    assert word(world, 8) == 2


@pytest.mark.parametrize(
    ("control", "address", "size", "error"),
    [
        (X32, BASE, 4, ERSERR),
        (PG | X32, BASE, 2, PGPERR),
        (PG | 1 << 8, BASE, 4, PGPERR),
        (PG | 3 << 8, BASE, 4, PGPERR),
        (PG | X32, BASE + 30, 4, PGAERR),
    ],
)
def test_stores_that_are_lost_say_why(world, control, address, size, error):
    poke(world.flash, "CR", control | ERRIE)
    world.flash.program(address, size, 0)
    assert peek(world.flash, "SR") == error | OPERR
    assert world.chip.irq(4).level
    poke(world.flash, "SR", error | OPERR)
    assert (peek(world.flash, "SR"), world.chip.irq(4).level) == (0, False)
    assert world.flash.memory == b"\xff" * len(world.flash.memory)


@pytest.mark.parametrize("address", [0x0020_0000, 0x1FFF_0000, 0x1FF0_F000])
def test_stores_elsewhere_are_bus_errors(world, address):
    poke(world.flash, "CR", PG | X32)
    with pytest.raises(BusFault, match="AXI"):
        world.flash.program(address, 4, 0)


# --- erasing


@each("dual", [False, True])
def test_each_sector_is_erased_alone(dual):
    world = build()
    optcr = FACTORY_OPTCR & ~(dual << 29)
    world.flash.load(0x1FFF_0000, encode(Options(optcr=optcr, optcr1=FACTORY_OPTCR1)))
    world.flash.reset()
    for sector in sectors_of(2048 * KB, dual_bank=dual):
        unlock(world)
        world.flash.memory[:] = bytes(2048 * KB)
        poke(world.flash, "CR", SER | sector.number << 3 | STRT | X32 | EOPIE)
        assert peek(world.flash, "SR") == BSY
        world.chip.advance_s(Fraction(2))
        assert (peek(world.flash, "SR"), peek(world.flash, "CR") & STRT) == (EOP, 0)
        erased = sector.offset, sector.offset + sector.size
        assert world.flash.memory[erased[0] : erased[1]] == b"\xff" * sector.size
        assert world.flash.memory.count(b"\xff") == sector.size
        world.flash.reset()


@each(("control", "kept"), [(MER1, slice(1024 * KB, None)), (MER2, slice(0, 1024 * KB))])
def test_mass_erase_of_one_of_two_banks(control, kept):
    world = build()
    world.flash.load(0x1FFF_0000, encode(Options(optcr=FACTORY_OPTCR & ~(1 << 29), optcr1=FACTORY_OPTCR1)))
    world.flash.reset()
    world.flash.memory[:] = bytes(2048 * KB)
    poke(unlock(world).flash, "CR", control | STRT)
    world.chip.advance_s(Fraction(8))
    assert not peek(world.flash, "SR")
    assert world.flash.memory[kept] == bytes(1024 * KB)
    assert world.flash.memory.count(b"\xff") == 1024 * KB


def test_mass_erase_of_the_one_bank(world):
    world.flash.memory[:] = bytes(2048 * KB)
    poke(world.flash, "CR", MER1 | STRT)
    world.chip.advance_s(Fraction(16))
    assert world.flash.memory == b"\xff" * 2048 * KB


@pytest.mark.parametrize("control", [STRT, SER | MER1 | STRT, SER | 12 << 3 | STRT])
def test_nothing_to_start(world, control):
    poke(world.flash, "CR", control)
    assert peek(world.flash, "SR") == ERSERR
    assert "FLASH_CR.STRT" in world.chip.noted("misuse")


def test_a_reset_cuts_an_operation_short(world):
    poke(world.flash, "CR", PG | X32)
    world.flash.program(BASE, 4, 0)
    world.flash.reset()
    world.chip.advance_s(Fraction(1))
    assert (word(world, 0), peek(world.flash, "SR"), peek(world.flash, "CR")) == (0xFFFF_FFFF, 0, LOCK)


# --- option bytes


def unlock_options(world):
    poke(world.flash, "OPTKEYR", 0x0819_2A3B)
    poke(world.flash, "OPTKEYR", 0x4C5D_6E7F)


def test_factory_settings(locked):
    settings = locked.flash.settings
    assert (peek(locked.flash, "OPTCR"), peek(locked.flash, "OPTCR1")) == (0xFFFF_AAFD, 0x0040_0080)
    assert (settings.boot_address(0), settings.boot_address(1)) == (0x0020_0000, 0x0010_0000)
    flags = settings.hardware_watchdog, settings.reset_on_stop, settings.reset_on_standby, settings.dual_bank
    assert not any(flags)
    assert settings.read_level == 0
    assert bytes(locked.flash.options[:4]) == b"\xff\xaa\x00\x55"


@given(optcr=st.integers(0, 0xFFFF_FFFF), optcr1=st.integers(0, 0xFFFF_FFFF))
def test_what_is_stored_is_read_again(optcr, optcr1):
    options = Options(optcr=optcr & 0xFFFF_FFFC, optcr1=optcr1)
    assert decode(encode(options)) == options


def test_option_bytes_are_programmed_by_optstrt(locked):
    poke(locked.flash, "OPTCR", 0)
    assert peek(locked.flash, "OPTCR") == 0xFFFF_AAFD, "locked"
    unlock_options(locked)
    poke(locked.flash, "OPTCR1", 0x0040_2000)
    poke(locked.flash, "OPTCR", 0xFFFF_AADC)
    assert not locked.flash.settings.hardware_watchdog
    poke(locked.flash, "OPTCR", 0xFFFF_AADC | 2)
    assert peek(locked.flash, "SR") == BSY
    locked.chip.advance_s(Fraction(1))
    assert locked.flash.settings.hardware_watchdog
    assert locked.flash.settings.boot_address(0) == 0x0800_0000
    locked.flash.reset()
    assert (peek(locked.flash, "OPTCR"), peek(locked.flash, "OPTCR1")) == (0xFFFF_AADD, 0x0040_2000)


def test_a_protected_sector_stays_as_it_is(locked):
    unlock_options(unlock(locked))
    poke(locked.flash, "OPTCR", (0xFFFF_AAFC & ~(1 << 16 + 4)) | 2)
    locked.chip.advance_s(Fraction(1))
    poke(locked.flash, "CR", PG | X32)
    locked.flash.program(BASE + 128 * KB, 4, 0)
    locked.flash.program(BASE + 256 * KB, 4, 0)
    locked.chip.advance_s(Fraction(1))
    assert (word(locked, 128 * KB), word(locked, 256 * KB), peek(locked.flash, "SR")) == (0xFFFF_FFFF, 0, WRPERR)
    for control in (SER | 4 << 3, MER1):
        poke(locked.flash, "SR", WRPERR)
        poke(locked.flash, "CR", control | STRT)
        assert peek(locked.flash, "SR") == WRPERR


def test_taking_the_read_protection_off_erases_everything(locked):
    unlock_options(locked)
    poke(locked.flash, "OPTCR", 0xFFFF_55FC | 2)
    locked.chip.advance_s(Fraction(1))
    assert locked.flash.settings.read_level == 1
    locked.flash.memory[:] = bytes(2048 * KB)
    poke(locked.flash, "OPTCR", 0xFFFF_AAFC | 2)
    locked.chip.advance_s(Fraction(17))
    assert (locked.flash.settings.read_level, locked.flash.memory) == (0, b"\xff" * 2048 * KB)


def test_level_2_is_for_good(locked):
    unlock_options(locked)
    poke(locked.flash, "OPTCR", 0xFFFF_CCFC | 2)
    locked.chip.advance_s(Fraction(1))
    poke(locked.flash, "OPTCR", 0xFFFF_AAFC | 2)
    locked.chip.advance_s(Fraction(17))
    assert locked.flash.settings.read_level == 2
    assert "FLASH_OPTCR.RDP" in locked.chip.noted("misuse")


# --- wait states


@pytest.mark.parametrize(("mhz", "needed"), [(30, 0), (31, 1), (60, 1), (180, 5), (210, 6), (211, 7), (216, 7)])
def test_wait_states_that_a_rate_asks_for(world, mhz, needed):
    rate = Fraction(mhz * 1_000_000)
    world.tree.set(Rates(sysclk=rate, hclk=rate, apb1=4, apb2=2, all_timers=False), stopped=False)
    poke(world.flash, "ACR", needed | 0x300)
    assert world.chip.noted("misuse") == []
    assert world.latency == ([needed] if needed else [])
    if needed:
        poke(world.flash, "ACR", needed - 1)
        assert world.chip.noted("misuse") == ["FLASH_ACR.LATENCY"]
