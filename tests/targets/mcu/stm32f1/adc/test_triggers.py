"""What starts a group, by the manual's tables (RM0008 tables 69 to 72)."""

from __future__ import annotations

import pytest

from targets.mcu.stm32.exti import STM32F1, Exti
from targets.mcu.testing import FakeChip, poke
from tests.each import each

# By EXTSEL and JEXTSEL; what stands behind the stroke comes in its place where AFIO says so.
REGULAR = {
    1: "TIM1_CC1 TIM1_CC2 TIM1_CC3 TIM2_CC2 TIM3_TRGO TIM4_CC4 EXTI11_EDGE/TIM8_TRGO",
    3: "TIM3_CC1 TIM2_CC3 TIM1_CC3 TIM8_CC1 TIM8_TRGO TIM5_CC1 TIM5_CC3",
}
INJECTED = {
    1: "TIM1_TRGO TIM1_CC4 TIM2_TRGO TIM2_CC1 TIM3_CC4 TIM4_TRGO EXTI15_EDGE/TIM8_CC4",
    3: "TIM1_TRGO TIM1_CC4 TIM4_CC3 TIM8_CC2 TIM8_CC4 TIM5_TRGO TIM5_CC4",
}
ROWS = [
    (unit, number, name, moved, injected)
    for injected, table in ((False, REGULAR), (True, INJECTED))
    for unit in (1, 2, 3)
    for number, names in enumerate(table[3 if unit == 3 else 1].split())
    for moved, name in enumerate(names.split("/"))
]


def test_each_trigger_starts_its_group_and_no_other(make_rig):
    names = {name for _, _, name, _, _ in ROWS}
    for unit, number, name, moved, injected in ROWS:
        rig = make_rig()
        if moved:
            rig.moved.add(f"ADC{unit}_{'ETRGINJ' if injected else 'ETRGREG'}")
        rig.on(cr2=1 << 15 | number << 12 if injected else 1 << 20 | number << 17, unit=unit)
        for other in names - {name}:
            rig.trigger(other)
        rig.clocks(20)
        assert rig.flags(unit) == set(), (unit, number, name)
        rig.trigger(name)
        rig.clocks(20)
        assert rig.flags(unit) == ({"JSTRT", "JEOC", "EOC"} if injected else {"STRT", "EOC"}), (unit, number, name)


@pytest.mark.parametrize("injected", [False, True])
def test_nobody_listens_without_need(rig, injected):
    rig.on(cr2=1 << 15 | 2 << 12 if injected else 1 << 20 | 4 << 17)
    listeners = rig.listeners["TIM2_TRGO" if injected else "TIM3_TRGO"]
    assert [listener.on_change is not None for listener in listeners].count(True) == 1
    rig.poke("CR2", 0)
    assert all(listener.on_change is None for listener in listeners)


def test_a_trigger_that_is_not_enabled_starts_nothing(rig):
    rig.poke("CR2", 1 | 4 << 17 | 2 << 12)
    rig.chip.advance(56)
    rig.trigger("TIM3_TRGO")
    rig.trigger("TIM2_TRGO")
    rig.clocks(20)
    assert rig.flags() == set()


@each(("rtsr", "ftsr", "pulses"), [(0, 0, 0), (1 << 11, 0, 1), (0, 1 << 11, 1), (1 << 11 | 1 << 15, 1 << 11, 2)])
def test_lines_of_exti_trigger_at_their_edges_whatever_is_masked(rtsr, ftsr, pulses):
    chip = FakeChip()
    exti = chip.add(Exti("EXTI", 0x4001_0400, chip.services, STM32F1))
    poke(exti, "RTSR", rtsr)
    poke(exti, "FTSR", ftsr)
    chip.input("EXTI11").drive(True)
    chip.input("EXTI11").drive(False)
    assert [level for _, level in chip.output("EXTI11_EDGE").edges] == [True, False] * pulses
    assert chip.output("EXTI15_EDGE").edges == []
