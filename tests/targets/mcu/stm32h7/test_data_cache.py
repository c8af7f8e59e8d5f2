"""What DMA and the data cache would make of each other on silicon is noted where it may matter, and only there."""

from __future__ import annotations

from pathlib import Path

import pytest

from targets.boards import built_in_board
from targets.mcu.image import Image, Segment
from targets.mcu.machine import Machine
from targets.mcu.symbols import NO_SYMBOLS

CCR, MPU_CTRL, MPU_RNR, MPU_RBAR, MPU_RASR = 0xE000_ED14, 0xE000_ED94, 0xE000_ED98, 0xE000_ED9C, 0xE000_EDA0
DCISW, DCCMVAC, DCIMVAC = 0xE000_EF60, 0xE000_EF68, 0xE000_EF5C
DC, ON, DEFAULT_MAP = 1 << 16, 1, 1 << 2
SIZE_32K, NORMAL_UNCACHED, NORMAL_CACHED, SHAREABLE = 14 << 1, 1 << 19, 1 << 19 | 3 << 16, 1 << 18
AXI, SRAM1, SRAM3, SRAM4 = 0x2400_0000, 0x3000_0000, 0x3004_0000, 0x3800_0000
DMA1 = 0x4002_0000


class Bench:
    """A machine whose CPU turns in a circle, while a test plays the program over the bus."""

    def __init__(self):
        table = (0x2002_0000).to_bytes(4, "little") + (0x0800_0009).to_bytes(4, "little") + b"\xfe\xe7" * 4
        image = Image(
            path=Path("image"),
            format="bin",
            digest="",
            segments=(Segment(0x0800_0000, table),),
            table=0x0800_0000,
            stack_pointer=0x2002_0000,
            reset_vector=0x0800_0009,
            flash_bytes=0,
            ram_bytes=0,
            symbols=NO_SYMBOLS,
            notes=(),
        )
        self.machine = Machine(built_in_board("nucleo-h753zi"), image)
        self.machine.run_to(1000)
        self.put(0x5802_4400 + 0xD8, 1)  # DMA1

    def put(self, address, value):
        self.machine.bus.write(address, 4, value)

    def region(self, number, base, attributes, *, subregions_off=0):
        self.put(MPU_RNR, number)
        self.put(MPU_RBAR, base)
        self.put(MPU_RASR, attributes | SIZE_32K | subregions_off << 8 | ON)

    def copy(self, source, target):
        """Let DMA1 copy a word from memory to memory."""
        stream = DMA1 + 0x10
        self.put(DMA1 + 0x08, 0xFFFF_FFFF)
        self.put(stream + 0x04, 1)
        self.put(stream + 0x08, source)
        self.put(stream + 0x0C, target)
        self.put(stream + 0x14, 0x21)  # with FIFO, from memory to memory
        self.put(stream, 2 << 6 | 2 << 11 | 2 << 13 | 1)
        self.machine.run_to(self.machine.now_ns + 10_000)

    @property
    def noted(self):
        return [note.where for note in self.machine.notes.all if note.kind == "assumed"]


@pytest.fixture
def bench():
    return Bench()


def test_with_the_cache_off_there_is_nothing_to_say(bench):
    bench.copy(AXI, SRAM1)
    assert bench.noted == []


@pytest.mark.parametrize(("source", "target"), [(AXI, SRAM1), (SRAM4, SRAM3)])
def test_memory_that_the_cache_may_hold_is_said_once(bench, source, target):
    bench.put(CCR, DC)
    bench.copy(source, target)
    bench.copy(source, target)
    assert bench.noted == ["CCR.DC"]


@pytest.mark.parametrize("operation", [DCCMVAC, DCIMVAC])
def test_who_cleans_or_invalidates_knows_of_it(bench, operation):
    bench.put(DCISW, 0)  # as before the cache is switched on
    bench.put(CCR, DC)
    bench.put(operation, AXI)
    bench.copy(AXI, SRAM1)
    assert bench.noted == []


def test_emptying_the_cache_before_its_use_is_no_such_knowledge(bench):
    bench.put(DCISW, 0)
    bench.put(CCR, DC)
    bench.copy(AXI, SRAM1)
    assert bench.noted == ["CCR.DC"]


@pytest.mark.parametrize("attributes", [NORMAL_UNCACHED, NORMAL_CACHED | SHAREABLE, 0, 1 << 16])
def test_regions_without_caching_are_nothing_to_speak_of(bench, attributes):
    bench.put(CCR, DC)
    bench.region(0, AXI, attributes)
    bench.region(1, SRAM3, attributes)
    bench.put(MPU_CTRL, ON | DEFAULT_MAP)
    bench.copy(AXI, SRAM3)
    bench.copy(AXI + 0x7FFC, SRAM3 + 0x7FFC)
    assert bench.noted == []
    bench.copy(AXI + 0x8000, SRAM3)
    assert bench.noted == ["CCR.DC"], "behind the region"


def test_the_region_with_the_highest_number_counts_and_subregions_that_are_off_do_not(bench):
    bench.put(CCR, DC)
    bench.region(0, AXI, NORMAL_CACHED)
    bench.region(1, AXI, NORMAL_UNCACHED, subregions_off=0b0000_0010)
    bench.put(MPU_CTRL, ON | DEFAULT_MAP)
    bench.copy(AXI, AXI + 0x7FFC)
    assert bench.noted == []
    bench.copy(AXI + 0x1000, AXI)
    assert bench.noted == ["CCR.DC"]


def test_regions_count_while_the_mpu_is_on(bench):
    bench.put(CCR, DC)
    bench.region(0, AXI, NORMAL_UNCACHED)
    bench.copy(AXI, AXI + 0x100)
    assert bench.noted == ["CCR.DC"]


def test_a_reset_forgets_what_was_cleaned(bench):
    bench.put(DCCMVAC, AXI)
    bench.machine.reset("PIN")
    bench.machine.run_to(bench.machine.now_ns + 10_000)
    bench.put(0x5802_4400 + 0xD8, 1)
    bench.put(CCR, DC)
    bench.copy(AXI, SRAM1)
    assert bench.noted == ["CCR.DC"]
