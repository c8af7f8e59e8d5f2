"""FLASH against RM0433 section 4: keys, flash words, erasing, errors, interrupts, option bytes, both banks."""

from __future__ import annotations

from fractions import Fraction
from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from targets.mcu.errors import BusFault
from targets.mcu.stm32h7.clock_limits import needed_wait_states
from targets.mcu.stm32h7.clocks import ClockTree
from targets.mcu.stm32h7.flash import Flash
from targets.mcu.testing import FakeChip, peek, poke
from tests.each import each

BASE, BANK_2, MB = 0x0800_0000, 0x0810_0000, 1 << 20
LOCK, PG, SER, BER, X64, FW, START = 1, 2, 4, 8, 3 << 4, 1 << 6, 1 << 7
BSY, WBNE, QW, EOP = 1, 2, 4, 1 << 16
WRPERR, PGSERR, STRBERR, INCERR = 1 << 17, 1 << 18, 1 << 19, 1 << 21
US, MS = Fraction(1, 1_000_000), Fraction(1, 1_000)
KEYS = 0x4567_0123, 0xCDEF_89AB


def build(pc=BASE):
    chip = FakeChip(hclk_hz=64_000_000)
    world = SimpleNamespace(chip=chip, pc=pc, scale=1, stalls=[], changes=[], latencies=[])
    tree = ClockTree()
    world.flash = flash = chip.add(
        Flash(0x5200_2000, chip.services, tree, size=2 * MB, scale=lambda: world.scale, pc=lambda: world.pc)
    )
    flash.reset()
    flash.stall_until = world.stalls.append
    flash.on_code_changed = lambda address, size: world.changes.append((address, size))
    flash.on_latency = world.latencies.append
    return world


@pytest.fixture
def world():
    return build()


def unlock(world, bank=1, control=PG | X64):
    for key in KEYS:
        poke(world.flash, f"KEYR{bank}", key)
    poke(world.flash, f"CR{bank}", control)


def store(world, address, *words):
    for index, word in enumerate(words):
        world.flash.program(address + 4 * index, 4, word)


def test_reset_values(world):
    wanted = {"ACR": 0x37, "CR1": 0x31, "CR2": 0x31, "SR1": 0, "OPTCR": 1, "BOOT_CURR": 0x1FF0_0800, "WPSN_CUR1R": 0xFF}
    assert {name: peek(world.flash, name) for name in wanted} == wanted
    assert peek(world.flash, "OPTSR_CUR") == peek(world.flash, "OPTSR_PRG")
    assert world.flash.read(0x100) == 0x37, "ACR stands among the registers of bank 2, too"


@pytest.mark.parametrize(("bank", "other"), [(1, 2), (2, 1)])
def test_each_bank_has_its_own_keys(world, bank, other):
    for key in KEYS:
        poke(world.flash, f"KEYR{bank}", key)
    assert not peek(world.flash, f"CR{bank}") & LOCK
    assert peek(world.flash, f"CR{other}") & LOCK
    poke(world.flash, f"CR{other}", PG)
    assert world.chip.noted("misuse") == [f"FLASH_CR{other}.LOCK"]


def test_a_wrong_key_is_a_bus_error_and_locks_until_a_reset(world):
    with pytest.raises(BusFault):
        poke(world.flash, "KEYR1", 1)
    with pytest.raises(BusFault):
        poke(world.flash, "KEYR1", KEYS[0])
    world.flash.reset()
    unlock(world)
    assert not peek(world.flash, "CR1") & LOCK


@given(st.integers(0, 2 * MB // 32 - 1), st.binary(min_size=32, max_size=32), st.permutations(range(8)))
def test_a_flash_word_is_programmed_when_its_32_bytes_are_there_in_any_order(number, data, order):
    world = build(pc=0x2000_0000)
    bank = 1 if number < MB // 32 else 2
    unlock(world, bank)
    for step, index in enumerate(order):
        assert peek(world.flash, f"SR{bank}") == (WBNE if step else 0)
        world.flash.program(
            BASE + 32 * number + 4 * index, 4, int.from_bytes(data[4 * index : 4 * index + 4], "little")
        )
    assert peek(world.flash, f"SR{bank}") == BSY | QW
    world.chip.advance_s(99 * US)
    assert world.changes == []
    world.chip.advance_s(2 * US)
    assert world.flash.memory[32 * number : 32 * number + 32] == data
    assert world.changes == [(BASE + 32 * number, 32)]
    assert peek(world.flash, f"SR{bank}") == EOP


def test_fw_programs_what_there_is(world):
    unlock(world)
    world.flash.program(BASE + 0x40, 1, 0x5A)
    poke(world.flash, "CR1", peek(world.flash, "CR1") | FW)
    world.chip.advance_s(101 * US)
    assert world.flash.memory[0x40:0x60] == b"\x5a" + b"\xff" * 31


@pytest.mark.parametrize(
    ("stores", "flag"), [(((0, 0), (32, 0)), INCERR), (((0, 0), (0, 0)), STRBERR), (((4, 0), (6, 0)), STRBERR)]
)
def test_stores_that_do_not_fit_empty_the_buffer(world, stores, flag):
    unlock(world)
    for offset, value in stores:
        world.flash.program(BASE + offset, 4, value)
    assert peek(world.flash, "SR1") == flag
    poke(world.flash, "CCR1", flag)
    assert (peek(world.flash, "SR1"), peek(world.flash, "CCR1")) == (0, 0)
    assert world.flash.memory == b"\xff" * 2 * MB


@pytest.mark.parametrize("control", [LOCK, 0, X64])
def test_without_pg_nothing_is_stored(world, control):
    if control != LOCK:
        unlock(world, control=control)
    store(world, BASE, *range(8))
    assert peek(world.flash, "SR1") == PGSERR


def test_a_flash_word_that_is_not_erased_is_said(world):
    unlock(world)
    store(world, BASE, *[0xF0F0_F0F0] * 8)
    world.chip.advance_s(101 * US)
    store(world, BASE, *[0x0FFF_0FFF] * 8)
    world.chip.advance_s(101 * US)
    assert world.flash.memory[:4] == bytes.fromhex("f000f000")
    assert world.chip.noted("misuse") == ["FLASH_CR1.PG"]


@pytest.mark.parametrize(("psize", "us"), [(0, 290), (1, 180), (2, 130), (3, 100)])
def test_programming_takes_its_time(world, psize, us):
    unlock(world, control=PG | psize << 4)
    store(world, BASE, *range(8))
    world.chip.advance_s((us - 1) * US)
    assert peek(world.flash, "SR1") & BSY
    world.chip.advance_s(2 * US)
    assert not peek(world.flash, "SR1") & BSY


@pytest.mark.parametrize(
    ("bank", "control", "erased"),
    [
        (1, SER | 3 << 8, (0x6_0000, 0x8_0000)),
        (2, SER | 7 << 8, (0x1E_0000, 0x20_0000)),
        (1, BER, (0, MB)),
        (2, BER, (MB, 2 * MB)),
    ],
)
def test_erasing(world, bank, control, erased):
    world.flash.memory[:] = bytes(2 * MB)
    unlock(world, bank, control | X64)
    poke(world.flash, f"CR{bank}", control | X64 | START)
    assert peek(world.flash, f"SR{bank}") == BSY | QW
    world.chip.advance_s(6000 * MS)
    start, end = erased
    assert world.flash.memory == bytes(start) + b"\xff" * (end - start) + bytes(2 * MB - end)
    assert (peek(world.flash, f"SR{bank}"), peek(world.flash, f"CR{bank}") & START) == (EOP, 0)


def test_mer_erases_both_banks(world):
    world.flash.memory[:] = bytes(2 * MB)
    poke(world.flash, "OPTKEYR", 0x0819_2A3B)
    poke(world.flash, "OPTKEYR", 0x4C5D_6E7F)
    poke(world.flash, "OPTCR", 1 << 4)
    world.chip.advance_s(30_000 * MS)
    assert world.flash.memory == b"\xff" * 2 * MB


@pytest.mark.parametrize(
    ("pc", "bank", "stalls"),
    [(BASE, 1, 1), (BASE, 2, 0), (BANK_2, 2, 1), (BANK_2, 1, 0)],
)
def test_only_the_bank_at_work_stalls_its_program(world, pc, bank, stalls):
    world.pc = pc
    unlock(world, bank)
    store(world, BASE if bank == 1 else BANK_2, *range(8))
    assert len(world.stalls) == stalls


def test_interrupts_come_where_they_are_enabled(world):
    irq = world.chip.irq(4)
    unlock(world, control=PG | X64 | EOP)
    store(world, BASE, *range(8))
    world.chip.advance_s(101 * US)
    assert irq.level
    poke(world.flash, "CCR1", EOP)
    assert not irq.level
    unlock_2 = PG | X64 | INCERR
    unlock(world, 2, unlock_2)
    store(world, BANK_2, 0)
    store(world, BANK_2 + 32, 0)
    assert irq.level


def options(world, **values):
    poke(world.flash, "OPTKEYR", 0x0819_2A3B)
    poke(world.flash, "OPTKEYR", 0x4C5D_6E7F)
    for name, value in values.items():
        poke(world.flash, name, value)
    poke(world.flash, "OPTCR", 2)
    world.chip.advance_s(20 * MS)


def test_option_bytes_hold_when_they_are_programmed_and_over_resets(world):
    poke(world.flash, "OPTCR", 2)
    assert world.chip.noted("misuse") == ["FLASH_OPTCR.OPTLOCK"]
    options(world, WPSN_PRG2R=0x7F)
    assert not peek(world.flash, "OPTSR_CUR") & 1
    world.flash.reset()
    assert peek(world.flash, "WPSN_CUR2R") == peek(world.flash, "WPSN_PRG2R") == 0x7F


def test_a_protected_sector_stays_as_it_is(world):
    options(world, WPSN_PRG2R=0x7F)
    unlock(world, 2)
    store(world, 0x081E_0000, *range(8))
    assert peek(world.flash, "SR2") == WRPERR
    store(world, 0x081D_FFE0, *range(8))
    world.chip.advance_s(101 * US)
    assert world.flash.memory[0x1D_FFE4] == 1
    poke(world.flash, "CR2", BER | START)
    assert peek(world.flash, "SR2") & WRPERR, "nor can the bank be erased"


@each(
    ("mhz", "scale", "wait_states"),
    [
        *((70, 0, 0), (71, 0, 1), (140, 0, 1), (210, 0, 2), (225, 0, 3), (240, 0, 4)),
        *((70, 1, 0), (200, 1, 2), (225, 1, 3), (55, 2, 0), (165, 2, 2), (45, 3, 0), (64, 3, 1), (180, 3, 3)),
    ],
)
def test_wait_states(mhz, scale, wait_states):
    assert needed_wait_states(Fraction(mhz * 1_000_000), scale) == wait_states


@pytest.mark.parametrize(("scale", "noted"), [(1, []), (3, ["FLASH_ACR.LATENCY"])])
def test_too_few_wait_states_are_said(world, scale, noted):
    world.scale = scale
    poke(world.flash, "ACR", 0)
    assert world.latencies == [0]
    assert world.chip.noted("misuse") == noted, "64 MHz takes none at scale 1, one at scale 3"
