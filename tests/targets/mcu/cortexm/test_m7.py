"""What a Cortex-M7 shows in its system control space, and what its debug blocks ask for."""

from __future__ import annotations

import pytest

from targets.mcu.cortexm.kinds import CORES, CORTEX_M3, CORTEX_M7, CORTEX_M7_R1P1

KEY = 0xC5AC_CE55
DWT_CTRL, DWT_CYCCNT, DWT_LAR, DWT_LSR = 0xE000_1000, 0xE000_1004, 0xE000_1FB0, 0xE000_1FB4
DEMCR, TRCENA = 0xE000_EDFC, 1 << 24


class TestIdentification:
    @pytest.mark.parametrize(
        ("address", "value"),
        [
            (0xE000_ED00, 0x411F_C270),  # CPUID
            (0xE000_E004, 3),  # ICTR: 97 to 128 interrupts
            (0xE000_E01C, 1 << 30 | 18750),
            (0xE000_ED14, 0x0004_0200),  # CCR: BP, STKALIGN
            (0xE000_ED78, 0x0900_0003),
            (0xE000_ED7C, 0x8303_C003),
            (0xE000_ED90, 0x800),  # MPU_TYPE: 8 regions
            (0xE000_EF34, 0xC000_0000),
            (0xE000_EF40, 0x1011_0221),
            (0xE000_EF44, 0x1200_0011),
            (0xE000_EF48, 0x40),
        ],
    )
    def test_values(self, m7, address, value):
        assert m7.read(address) == value

    def test_an_m3_has_none_of_it(self, rig):
        assert rig.read(0xE000_ED00) == 0x411F_C231
        assert rig.read(0xE000_ED90) == 0
        for address in (0xE000_ED78, 0xE000_EF34, 0xE000_EF40):
            assert rig.read(address) == 0
            assert f"SCS_0x{address & 0xFFF:02X}" in rig.chip.noted("reserved")

    def test_every_register_reads_its_declared_reset_value(self, m7):
        for block in m7.core.blocks:
            if block.name in ("DWT", "ITM", "TPIU"):
                continue  # without a clock until the trace is enabled
            for offset, register in block.registers.items():
                if register.name not in ("VTOR", "DHCSR") and not register.name.startswith("RBAR"):
                    assert block.read(offset) == register.reset, (block.name, register.name)

    def test_interrupts(self, m7):
        m7.write(0xE000_E10C, 0xFFFF_FFFF)
        assert m7.read(0xE000_E10C) == 0x3FFF  # 96 to 109
        m7.interrupt(109)
        m7.settle()
        assert m7.began == [125]

    def test_stkalign_is_read_only(self, m7):
        m7.poke("SCB", "CCR", 0)
        assert m7.peek("SCB", "CCR") == 0x0004_0200

    def test_the_vector_table_may_be_anywhere(self, m7):
        m7.poke("SCB", "VTOR", 0xFFFF_FFFF)
        assert m7.peek("SCB", "VTOR") == 0xFFFF_FF80

    def test_kinds_by_name(self):
        assert CORES == {"Cortex-M3": CORTEX_M3, "Cortex-M7": CORTEX_M7, "Cortex-M7 r1p1": CORTEX_M7_R1P1}


class TestCaches:
    def test_sizes(self, m7):
        def size(ccsidr):
            sets, ways, line = (ccsidr >> 13 & 0x7FFF) + 1, (ccsidr >> 3 & 0x3FF) + 1, 1 << (ccsidr & 7) + 4
            return sets * ways * line, ways

        assert size(m7.peek("CACHE", "CCSIDR")) == (16384, 4)
        m7.poke("CACHE", "CSSELR", 0xFFFF_FFFF)
        assert m7.peek("CACHE", "CSSELR") == 1
        assert size(m7.peek("CACHE", "CCSIDR")) == (16384, 2)

    def test_operations_read_as_zero(self, m7):
        for address in (0xE000_EF50, 0xE000_EF58, 0xE000_EF5C, 0xE000_EF60, 0xE000_EF64, 0xE000_EF68, 0xE000_EF74):
            m7.write(address, 0x2000_0000)
            assert m7.read(address) == 0
        assert not m7.chip.noted()

    def test_the_data_cache_is_said_once(self, m7):
        m7.poke("SCB", "CCR", 1 << 17)
        assert not m7.chip.noted()
        m7.poke("SCB", "CCR", 1 << 16 | 1 << 17)
        m7.poke("SCB", "CCR", 1 << 16 | 1 << 17)
        assert m7.peek("SCB", "CCR") == 0x0007_0200
        assert m7.chip.noted("unmodelled") == ["SCB_CCR.DC"]

    def test_an_m3_has_none(self, rig):
        rig.poke("SCB", "CCR", 1 << 16 | 1 << 17)
        assert rig.peek("SCB", "CCR") == 0
        assert not rig.chip.noted()


class TestMemoryProtection:
    def test_regions_are_remembered(self, m7):
        for region in range(8):
            m7.poke("MPU", "RNR", region)
            m7.poke("MPU", "RBAR", 0x2000_0000 + 0x1000 * region)
            m7.poke("MPU", "RASR", 0x0300_0017 + region)
        m7.poke("MPU", "RNR", 5)
        assert m7.peek("MPU", "RBAR") == 0x2000_5000 | 5
        assert m7.peek("MPU", "RASR") == 0x0300_001C

    def test_a_region_chosen_by_its_address(self, m7):
        m7.poke("MPU", "RBAR", 0x2000_0000 | 1 << 4 | 3)
        m7.poke("MPU", "RASR_A1", 0x17)
        m7.poke("MPU", "RBAR_A2", 0x4000_0000 | 1 << 4 | 6)
        assert m7.peek("MPU", "RNR") == 6
        m7.poke("MPU", "RNR", 3)
        assert (m7.peek("MPU", "RBAR_A3"), m7.peek("MPU", "RASR")) == (0x2000_0003, 0x17)

    def test_a_region_that_there_is_not(self, m7):
        """QEMU ignores both writes."""
        m7.poke("MPU", "RNR", 9)
        assert m7.peek("MPU", "RNR") == 1
        m7.poke("MPU", "RBAR", 0x2000_0000 | 1 << 4 | 10)
        assert m7.peek("MPU", "RNR") == 2
        assert m7.chip.noted("misuse") == ["MPU_RNR"]

    def test_that_nothing_is_refused_is_said(self, m7):
        m7.poke("MPU", "CTRL", 4)
        assert not m7.chip.noted()
        m7.poke("MPU", "CTRL", 5)
        assert m7.peek("MPU", "CTRL") == 5
        assert m7.chip.noted("unmodelled") == ["MPU_CTRL.ENABLE"]

    def test_reset(self, m7):
        m7.poke("MPU", "RASR", 0x17)
        m7.core.reset(m7.VECTORS)
        assert m7.peek("MPU", "RASR") == 0


class TestCycleCounter:
    def test_it_is_locked(self, m7):
        m7.write(DEMCR, TRCENA)
        assert m7.read(DWT_LSR) == 3
        m7.write(DWT_CTRL, 1)
        m7.advance(100)
        assert m7.read(DWT_CYCCNT) == 0
        assert m7.chip.noted("misuse") == ["DWT_LAR"]

    def test_the_key_opens_it(self, m7):
        m7.write(DEMCR, TRCENA)
        m7.write(DWT_LAR, KEY)
        assert m7.read(DWT_LSR) == 1
        assert m7.read(DWT_LAR) == 0
        m7.write(DWT_CTRL, 1)
        m7.advance(100)
        assert m7.read(DWT_CYCCNT) == 100
        m7.write(DWT_LAR, 0)
        m7.write(DWT_CYCCNT, 0)
        assert m7.read(DWT_CYCCNT) == 100
        m7.core.reset(m7.VECTORS, power_on=True)
        m7.write(DEMCR, TRCENA)
        assert m7.read(DWT_LSR) == 3

    def test_an_stm32h7_needs_no_key(self, make_rig):
        """Programs that count on it there leave LAR alone or ask LSR first; both have to work."""
        h7 = make_rig(CORTEX_M7_R1P1)
        h7.write(DEMCR, TRCENA)
        assert h7.read(DWT_LSR) == 0
        h7.write(DWT_CTRL, 1)
        h7.advance(100)
        assert h7.read(DWT_CYCCNT) == 100
        for value in (KEY, 0):
            h7.write(DWT_LAR, value)
            assert (h7.read(DWT_LAR), h7.read(DWT_LSR)) == (0, 0)
        h7.write(DWT_CYCCNT, 7)
        assert h7.read(DWT_CYCCNT) == 7
        assert not h7.chip.noted()

    def test_an_m3_needs_no_key(self, rig):
        rig.write(DEMCR, TRCENA)
        rig.write(DWT_CTRL, 1)
        rig.advance(100)
        assert rig.read(DWT_CYCCNT) == 100
