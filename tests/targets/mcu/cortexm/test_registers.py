"""The private peripheral bus: reset values, lanes, privilege, and what each register of NVIC, SCB, DWT and ITM does."""

from __future__ import annotations

import itertools

import pytest

from targets.mcu.cortexm.exceptions import Number
from targets.mcu.engine.api import Reg
from targets.mcu.errors import BusFault
from targets.mcu.fidelity import Fidelity

NVIC_ISER, NVIC_ICER, NVIC_ISPR, NVIC_ICPR, NVIC_IABR, NVIC_IPR = (
    0xE000_E000 + offset for offset in (0x100, 0x180, 0x200, 0x280, 0x300, 0x400)
)
ICSR, AIRCR, CCR, SHPR1, SHCSR, STIR = (0xE000_E000 + offset for offset in (0xD04, 0xD0C, 0xD14, 0xD18, 0xD24, 0xF00))
DWT_CTRL, DWT_CYCCNT, DEMCR = 0xE000_1000, 0xE000_1004, 0xE000_EDFC
ITM, ITM_TER, ITM_TPR, ITM_TCR, ITM_LAR, ITM_LSR = (
    0xE000_0000 + offset for offset in (0, 0xE00, 0xE40, 0xE80, 0xFB0, 0xFB4)
)
TRCENA = 1 << 24


class TestResetValues:
    @pytest.mark.parametrize(
        ("address", "value"),
        [
            (0xE000_E004, 1),  # up to 64 interrupt inputs
            (0xE000_E010, 0),
            (0xE000_E01C, 0x4000_2328),
            (0xE000_ED00, 0x411F_C231),
            (0xE000_ED04, 0),
            (0xE000_ED08, 0x0800_0000),  # where this rig resets from
            (0xE000_ED0C, 0xFA05_0000),
            (0xE000_ED10, 0),
            (0xE000_ED14, 0),
            (0xE000_ED24, 0),
            (0xE000_ED28, 0),
            (0xE000_ED2C, 0),
            (0xE000_ED40, 0x30),
            (0xE000_ED90, 0),  # no MPU
            (0xE000_EDFC, 0),
            (0xE000_2000, 0x260),
            (0xE004_0000, 0xB),
            (0xE00F_F000, 0xFFF0_F003),
            (0xE00F_FFE0, 0x10),
            (0xE00F_FFE4, 0x04),
        ],
    )
    def test_value(self, rig, address, value):
        assert rig.read(address) == value

    def test_every_register_reads_its_declared_reset_value(self, rig):
        for block in rig.core.blocks:
            if block.name in ("DWT", "ITM"):
                continue  # without a clock until the trace is enabled
            for offset, register in block.registers.items():
                if register.name not in ("ICTR", "VTOR", "DHCSR"):
                    assert block.read(offset) == register.reset, (block.name, register.name)

    def test_blocks_do_not_overlap_and_are_found_by_kilobyte(self, rig):
        places = sorted((block.base, block.base + block.size) for block in rig.core.peripherals)
        assert all(end <= start for (_, end), (start, _) in itertools.pairwise(places))
        assert all(block.size % 1024 == 0 for block in rig.core.peripherals)

    def test_the_rom_table_leads_to_the_blocks(self, rig):
        found = set()
        for offset in range(0, 24, 4):
            entry = rig.read(0xE00F_F000 + offset)
            if entry & 1:
                found.add(0xE00F_F000 + (entry & ~0xFFF) & 0xFFFF_FFFF)
        assert found == {block.base for block in rig.core.peripherals if block.name != "ROM"}
        assert rig.read(0xE00F_F018) == 0

    def test_reset_by_the_system_and_by_power(self, rig):
        rig.write(DEMCR, TRCENA | 1 << 16)
        rig.write(DWT_CTRL, 1)
        rig.write(ITM_LAR, 0xC5AC_CE55)
        rig.write(ITM_TER, 1)
        rig.write(NVIC_ISER, 1)
        rig.write(SHPR1 + 4, 0x4000_0000)
        rig.write(CCR, 0x200)
        rig.advance(100)
        rig.core.reset(0x0800_0000)
        assert rig.read(DEMCR) == TRCENA
        assert rig.read(DWT_CYCCNT) == 100
        assert rig.read(ITM_TER) == 1
        assert rig.read(NVIC_ISER) == rig.read(SHPR1 + 4) == rig.read(CCR) == 0
        rig.core.reset(0x0800_0000, power_on=True)
        assert rig.read(DEMCR) == 0
        rig.write(DEMCR, TRCENA)
        assert rig.read(DWT_CTRL) == 0x4000_0000
        assert rig.read(DWT_CYCCNT) == rig.read(ITM_TER) == 0

    def test_boot_loader_leaves_its_vector_table(self, rig):
        rig.core.reset(0x0800_0000)
        assert rig.peek("SCB", "VTOR") == 0x0800_0000

    def test_what_is_absent_says_so(self, rig):
        declared = {(b.name, r.name): r for b in rig.core.blocks for r in b.registers.values()}
        assert declared["DWT", "COMP0"].fidelity is Fidelity.ABSENT
        assert all(register.note for register in declared.values() if register.fidelity is not Fidelity.MODELLED)


class TestLanes:
    def test_priorities_by_byte_half_word_and_word(self, rig):
        rig.write(NVIC_IPR + 5, 0x7F, 1)
        rig.write(NVIC_IPR + 6, 0x1234, 2)
        assert rig.read(NVIC_IPR + 4) == 0x1030_7000
        assert rig.read(NVIC_IPR + 5, 1) == 0x70
        assert rig.core.exceptions.priorities[16 + 4 : 16 + 8] == [0, 0x70, 0x30, 0x10]
        rig.write(NVIC_IPR + 4, 0xFFFF_FFFF)
        assert rig.read(NVIC_IPR + 4) == 0xF0F0_F0F0

    def test_interrupts_that_are_not_there_have_no_priority(self, rig):
        rig.write(NVIC_IPR + 40, 0xFFFF_FFFF)
        assert rig.read(NVIC_IPR + 40) == 0x00F0_F0F0
        rig.write(NVIC_IPR + 236, 0xFFFF_FFFF)
        assert rig.read(NVIC_IPR + 236) == 0
        assert rig.chip.notes.all == []

    def test_system_priorities_by_byte(self, rig):
        rig.write(SHPR1 + 10, 0xFF, 1)  # PendSV
        rig.write(SHPR1 + 11, 0x80, 1)  # SysTick
        rig.write(SHPR1 + 7, 0x40, 1)  # SVCall
        rig.write(SHPR1 + 3, 0x40, 1)  # nothing
        assert [rig.read(SHPR1 + offset) for offset in (0, 4, 8)] == [0, 0x4000_0000, 0x80F0_0000]
        assert rig.core.exceptions.priorities[Number.PENDSV] == 0xF0

    def test_narrow_writes_to_bits_that_act_leave_the_others(self, rig):
        rig.write(ICSR, 1 << 26)
        rig.write(ICSR + 3, 1 << 4, 1)  # PENDSVSET
        assert rig.read(ICSR) >> 26 & 0b101 == 0b101
        rig.write(NVIC_ISER + 1, 0x01, 1)
        assert rig.read(NVIC_ISER) == 0x100
        rig.write(NVIC_ICER, 0xFF, 1)
        assert rig.read(NVIC_ISER) == 0x100

    def test_half_of_the_key_is_no_key(self, rig):
        rig.write(AIRCR, 0x0300, 2)
        assert rig.read(AIRCR) == 0xFA05_0000
        assert rig.chip.noted("misuse") == ["SCB_AIRCR"]

    def test_handler_control_by_byte(self, rig):
        rig.write(SHCSR, 0x0007_0000)
        rig.write(SHCSR + 2, 0x02, 1)
        assert rig.read(SHCSR) == 0x0002_0000


class TestPrivilege:
    @pytest.fixture
    def user(self, rig):
        rig.cpu.set(Reg.CONTROL, 1)
        return rig

    @pytest.mark.parametrize("address", [ICSR, NVIC_ISER, 0xE000_E018, DWT_CYCCNT, 0xE00F_F000, 0xE000_EFFC, ITM_TER])
    def test_unprivileged_access_is_a_bus_fault(self, user, address):
        with pytest.raises(BusFault):
            user.read(address)
        with pytest.raises(BusFault):
            user.write(address, 0)
        with pytest.raises(BusFault):
            user.read(address, 1)

    def test_handlers_are_privileged(self, user):
        user.interrupt(0)
        user.settle()
        user.read(ICSR)

    def test_stir_can_be_opened(self, rig):
        rig.write(CCR, 1 << 1)
        rig.cpu.set(Reg.CONTROL, 1)
        rig.write(STIR, 3)
        assert rig.core.exceptions.is_pending(19)

    def test_stimulus_ports_can_be_closed(self, rig):
        said = []
        rig.core.itm.on_stimulus = lambda port, size, value: said.append((port, size, value))
        rig.core.trace_as_debugger()
        rig.write(ITM_LAR, 0xC5AC_CE55)
        rig.write(ITM_TPR, 0b10)
        rig.cpu.set(Reg.CONTROL, 1)
        rig.write(ITM + 4 * 7, 0x41, 1)
        with pytest.raises(BusFault):
            rig.write(ITM + 4 * 8, 0x42, 1)
        assert said == [(7, 1, 0x41)]


class TestNvic:
    def test_enable_and_disable(self, rig):
        rig.write(NVIC_ISER + 4, 0xFFFF_FFFF)
        assert rig.read(NVIC_ISER + 4) == rig.read(NVIC_ICER + 4) == 0x7FF
        rig.write(NVIC_ICER + 4, 0x3)
        assert rig.read(NVIC_ISER + 4) == 0x7FC
        rig.write(NVIC_ISER + 8, 0xFFFF_FFFF)
        assert rig.read(NVIC_ISER + 8) == 0

    def test_pending_and_active(self, rig):
        rig.write(NVIC_ISER, 1 << 5)
        rig.write(NVIC_ISPR, 1 << 5 | 1 << 6)
        assert rig.read(NVIC_ISPR) == rig.read(NVIC_ICPR) == 0x60
        rig.settle()
        assert rig.read(NVIC_ISPR) == 0x40
        assert rig.read(NVIC_IABR) == 0x20
        rig.write(NVIC_IABR, 0)
        assert rig.read(NVIC_IABR) == 0x20
        rig.write(NVIC_ICPR, 1 << 6)
        assert rig.read(NVIC_ISPR) == 0

    def test_software_trigger(self, rig):
        rig.write(STIR, 42)
        assert rig.core.exceptions.is_pending(58)
        assert rig.read(STIR) == 0
        rig.write(STIR, 43)
        assert rig.chip.noted("misuse") == ["NVIC_STIR"]

    def test_an_interrupt_that_is_disabled_while_it_runs_goes_on(self, rig):
        rig.interrupt(0)
        rig.settle()
        rig.write(NVIC_ICER, 1)
        assert rig.read(NVIC_IABR) == 1
        rig.exit()
        assert rig.core.running == 0


class TestScb:
    def test_what_runs_and_what_is_pending(self, rig):
        rig.interrupt(3, priority=0x40)
        rig.settle()
        assert rig.read(ICSR) == 19 | 1 << 11
        rig.interrupt(5, priority=0x20)
        rig.settle()
        rig.interrupt(6, priority=0x60)
        assert rig.read(ICSR) == 21 | 22 << 12 | 1 << 22
        rig.cpu.set(Reg.PRIMASK, 1)
        assert rig.read(ICSR) >> 12 & 0x1FF == 22
        rig.cpu.set(Reg.BASEPRI, 0x50)
        assert rig.read(ICSR) >> 12 & 0x1FF == 0

    def test_pend_and_unpend(self, rig):
        rig.cpu.set(Reg.PRIMASK, 1)
        rig.write(ICSR, 1 << 28 | 1 << 26)
        assert rig.read(ICSR) == 1 << 28 | 1 << 26 | 14 << 12
        rig.write(ICSR, 1 << 27)
        assert rig.read(ICSR) == 1 << 26 | 15 << 12
        rig.write(ICSR, 1 << 25)
        assert rig.read(ICSR) == 0

    def test_system_handlers(self, rig):
        rig.write(SHCSR, 0x0007_0000)
        rig.svc()
        assert rig.read(SHCSR) == 0x0007_0080
        rig.exit()
        rig.write(SHCSR, 1 << 15)  # a supervisor call made pending by hand
        rig.settle()
        assert rig.core.running == Number.SVCALL
        rig.write(SHCSR, 0)
        assert not rig.core.exceptions.is_active(Number.SVCALL)

    def test_a_disabled_fault_stays_pending(self, rig):
        rig.write(SHCSR, 1 << 14)
        rig.settle()
        assert rig.began == []
        rig.write(SHCSR, 1 << 14 | 1 << 17)
        rig.settle()
        assert rig.began == [Number.BUS_FAULT]

    def test_vector_table(self, rig):
        rig.poke("SCB", "VTOR", 0xE000_0000 | rig.RAM | 0x17F)
        assert rig.peek("SCB", "VTOR") == rig.RAM | 0x100
        assert rig.chip.notes.all == []
        rig.poke("SCB", "VTOR", 0x0800_0080)
        assert rig.chip.noted("misuse") == ["SCB_VTOR"]

    @pytest.mark.parametrize("prigroup", range(8))
    def test_priority_grouping(self, rig, prigroup):
        rig.write(AIRCR, 0x05FA_0000 | prigroup << 8)
        assert rig.read(AIRCR) == 0xFA05_0000 | prigroup << 8
        assert rig.core.exceptions.group_priority(0xF0) == 0xF0 >> prigroup + 1 << prigroup + 1

    def test_reset_requests(self, rig):
        rig.write(AIRCR, 0x0000_0004)
        assert rig.chip.resets == []
        rig.write(AIRCR, 0x05FA_0004)
        assert rig.chip.resets == ["SFT"]
        asked = []
        rig.write(AIRCR, 0x05FA_0001)
        rig.core.scb.on_core_reset = lambda: asked.append(True)
        rig.write(AIRCR, 0x05FA_0001)
        assert asked == [True]
        assert rig.chip.resets == ["SFT"]
        assert rig.chip.noted("unmodelled") == ["SCB_AIRCR.VECTRESET"]

    def test_configuration(self, rig):
        rig.write(CCR, 0xFFFF_FFFF)
        assert rig.read(CCR) == 0x31B
        assert rig.chip.notes.all == []

    def test_there_is_no_debugger(self, rig):
        dhcsr = rig.address("SCB", "DHCSR")
        assert rig.read(dhcsr) & 1 << 25  # a reset since the last read
        assert not rig.read(dhcsr) & 1 << 25
        rig.write(dhcsr, 0xA05F_0001)
        assert not rig.read(dhcsr) & 1

    def test_debug_monitor(self, rig):
        rig.write(DEMCR, 1 << 17)
        rig.settle()
        assert rig.began == []
        assert rig.read(DEMCR) == 1 << 17
        rig.write(DEMCR, 1 << 17 | 1 << 16)
        rig.settle()
        assert rig.began == [Number.DEBUG_MONITOR]
        assert rig.read(DEMCR) == 1 << 16

    def test_reserved_addresses_are_noted(self, rig):
        assert rig.read(0xE000_E008 + 4) == 0
        rig.write(0xE000_EF40, 1)
        assert rig.chip.noted("reserved") == ["SCS_0x0C", "SCS_0xF40"]


class TestCycleCounter:
    def test_counts_while_both_enables_are_set(self, rig):
        rig.write(DEMCR, TRCENA)
        rig.advance(10)
        assert rig.read(DWT_CYCCNT) == 0
        rig.write(DWT_CTRL, 0x4000_0001)
        rig.advance(10)
        assert rig.read(DWT_CYCCNT) == 10
        rig.write(DWT_CTRL, 0x4000_0000)
        rig.advance(10)
        assert rig.read(DWT_CYCCNT) == 10
        rig.write(DWT_CTRL, 0x4000_0001)
        rig.advance(5)
        rig.write(DEMCR, 0)
        rig.advance(5)
        rig.write(DEMCR, TRCENA)
        rig.advance(5)
        assert rig.read(DWT_CYCCNT) == 20
        assert rig.chip.notes.all == []

    def test_can_be_set_and_wraps(self, rig):
        rig.write(DEMCR, TRCENA)
        rig.write(DWT_CYCCNT, 0xFFFF_FFF0)
        assert rig.read(DWT_CYCCNT) == 0xFFFF_FFF0
        rig.write(DWT_CTRL, 1)
        rig.advance(0x20)
        assert rig.read(DWT_CYCCNT) == 0x10
        rig.write(DWT_CYCCNT, 0)
        rig.advance(7)
        assert rig.read(DWT_CYCCNT) == 7

    def test_without_trace_enable_it_is_dead(self, rig):
        assert rig.read(DWT_CYCCNT) == 0x4000_0000
        rig.write(DWT_CTRL, 1)
        assert rig.chip.noted("misuse") == ["DWT_TRCENA"]
        rig.write(DEMCR, TRCENA)
        rig.advance(10)
        assert rig.read(DWT_CYCCNT) == 0

    def test_it_changes_with_time_alone_while_it_counts(self, rig):
        assert not rig.core.dwt.is_live(4)
        assert rig.core.dwt.count(4) is None
        rig.write(DEMCR, TRCENA)
        rig.write(DWT_CTRL, 1)
        assert rig.core.dwt.is_live(4)
        assert not rig.core.dwt.is_live(0)
        rig.advance(10)
        count = rig.core.dwt.count(4)
        for _ in range(3):
            assert count.at(rig.chip.time.now) == rig.read(DWT_CYCCNT)
            rig.advance(7)

    def test_what_is_absent_is_noted(self, rig):
        rig.write(DEMCR, TRCENA)
        rig.write(0xE000_1028, 4)
        assert rig.chip.noted("unmodelled") == ["DWT_FUNCTION0"]


class TestStimulus:
    @pytest.fixture
    def said(self, rig):
        said = []
        rig.core.itm.on_stimulus = lambda port, size, value: said.append((port, size, value))
        return said

    def enable(self, rig):
        """As firmware does that wants its trace on its own, such as the SWO example of libopencm3."""
        rig.write(DEMCR, TRCENA)
        rig.write(ITM_LAR, 0xC5AC_CE55)
        rig.write(ITM_TER, 0b11)
        rig.write(ITM_TCR, 0x0001_0001)

    def test_sizes(self, rig, said):
        self.enable(rig)
        rig.write(ITM, 0x41, 1)
        rig.write(ITM, 0x4241, 2)
        rig.write(ITM + 4, 0x4443_4241)
        assert said == [(0, 1, 0x41), (0, 2, 0x4241), (1, 4, 0x4443_4241)]

    def test_ready_where_it_takes(self, rig, said):
        self.enable(rig)
        assert rig.read(ITM) == 1
        assert rig.read(ITM, 1) == 1
        assert rig.read(ITM + 8) == 0
        rig.write(ITM + 8, 1)
        assert said == []

    def test_nothing_without_a_debugger(self, rig, said):
        assert rig.read(ITM) == rig.read(ITM_TCR) == 0
        rig.write(ITM, 0x41, 1)
        assert said == []

    def test_lock(self, rig):
        rig.write(DEMCR, TRCENA)
        assert rig.read(ITM_LSR) == 3
        rig.write(ITM_TER, 1)
        assert rig.read(ITM_TER) == 0
        assert rig.chip.noted("misuse") == ["ITM_LAR"]
        rig.write(ITM_LAR, 0xC5AC_CE55)
        assert rig.read(ITM_LSR) == 1
        rig.write(ITM_TER, 1)
        assert rig.read(ITM_TER) == 1
        rig.write(ITM_LAR, 0)
        rig.write(ITM_TER, 2)
        assert rig.read(ITM_TER) == 1

    def test_as_a_debugger_sets_it_up(self, rig, said):
        rig.core.trace_as_debugger()
        for _ in range(2):
            assert rig.read(ITM_TCR) & 1
            assert rig.read(ITM_TER) & 1
            assert rig.read(ITM)
            rig.write(ITM, 0x41, 1)
            rig.core.reset(0x0800_0000, power_on=True)
        assert said == [(0, 1, 0x41)] * 2
