"""Our images on the emulated NUCLEO-H753ZI."""

from __future__ import annotations

import itertools
import math
import re

import pytest

from targets.mcu.bus import Bus
from targets.mcu.stm32.exti_ports import ExtiPorts
from targets.mcu.stm32.m7_chip import M7Chip
from targets.mcu.stm32.rcc import BasicRcc
from targets.mcu.stm32h7.chip import Stm32h753
from targets.mcu.stm32h7.exti import Exti
from targets.mcu.stm32h7.flash import Flash
from targets.mcu.stm32h7.hsem import Hsem
from targets.mcu.stm32h7.pwr import Pwr
from targets.mcu.stm32h7.rcc import Rcc
from tests.each import each
from tests.targets.firmware.defect import Defect, finds_it, some

MS = 1_000_000


@each("timing", ["flat", "table"])
def test_the_self_test_of_the_chip_passes(start, timing):
    run = start("h753-chip", timing=timing).to(1500)
    assert run.machine.ended is not None, run.console
    assert (run.machine.ended.kind, run.machine.ended.status) == ("exit", 0), run.console.decode()
    passed, failed = run.checks
    assert (len(passed), failed) == (63, [])


DEFECTS = [
    Defect("SRAM1 has no alias", "chip", Stm32h753, "_map", "base=D2_RAM_ALIAS", "base=0x6000_0000"),
    Defect("all RAM shows the same bytes", "chip", M7Chip, "_map_ram", "offset += size", "offset += 0"),
    Defect("the supply is ready without a word", "chip", Pwr, "power_on", "= False", "= True"),
    Defect("the supply can be chosen again", "chip", Pwr, "write_CR3", "if self._supplied:", "if False:"),
    Defect("PLL settings do not hold", "chip", Rcc, "_write_settings", "(value & ~fixed)", "value"),
    Defect("PLL1 may be switched off", "chip", Rcc, "_needed_bits", "needed |= at.PLLON[0]", "pass"),
    Defect("CSI may be switched off", "chip", Rcc, "_needed_bits", "Source.CSI: at.CSION", "Source.CSI: 0"),
    Defect("no interrupt", "chip", Rcc, "_update_lines", "flags & self[at.CIER] & _LINES", "False"),
    Defect("the PLL starts at once", "chip", BasicRcc, "_oscillator", "start_s, stop_s", "start_s / 1000, stop_s"),
    Defect("gates are always open", "chip", BasicRcc, "_apply_gates", "bool(self[offset] & bit)", "True"),
    Defect("resets reset nothing", "chip", BasicRcc, "_write_resets", "peripheral.reset()", "pass"),
    Defect("no second place for CPU 1", "chip", Rcc, "write", "home = _home(offset)", "home = offset"),
    Defect("no lock", "chip", Flash, "_store", "if not control & PG or control & LOCK", "if False"),
    Defect(
        "one key opens both banks",
        "chip",
        Flash,
        "_unlock",
        "self[control] &= ~LOCK",
        "self[CR1] = self[CR1 + BANK] = 0",
    ),
    Defect("any flash word", "chip", Flash, "_store", "!= offset // FLASH_WORD", "< 0"),
    Defect("stored twice", "chip", Flash, "_store", "offset + index in buffer for", "False for"),
    Defect("programs each store", "chip", Flash, "_store", "if len(buffer) < FLASH_WORD", "if False"),
    Defect("FW does nothing", "chip", Flash, "_take_control", "if value & FW and", "if False and"),
    Defect("erases nothing", "chip", Flash, "_erase", 'b"\\xff" * size', "bytes(size)"),
    Defect(
        "the other bank stalls, too", "chip", Flash, "_begin", "self._bank_of(self._pc() - FLASH_BASE) == bank", "True"
    ),
    Defect("no interrupt at the end", "chip", Flash, "_end", "set_=EOP", "set_=0"),
    Defect("CR opens without keys", "chip", Flash, "_write_control", "if self[control] & LOCK", "if False"),
    Defect("port A only", "chip", ExtiPorts, "_choose_ports", "_PORTS[port]", "_PORTS[0]"),
    Defect("both edges", "chip", Exti, "_listener", "RTSR if level else FTSR", "FTSR"),
    Defect("CPUPR clears nothing in SWIER", "chip", Exti, "write", "SWIER] &= ~value", "SWIER] &= -1"),
    Defect("a read takes nothing", "chip", Hsem, "read", "self[number] = LOCK | CPU", "pass"),
    Defect("anybody releases", "chip", Hsem, "_ask", "elif self[offset] == LOCK | owner:", "else:"),
    Defect("a release is no interrupt", "chip", Hsem, "_release", "1 << offset // 4", "0"),
    Defect("words are lost", "chip", Bus, "window", "peripheral.write(address - peripheral.base & ~3, value)", "pass"),
]


@pytest.mark.parametrize("defect", some(DEFECTS, 2))
def test_each_defect_of_the_chip_is_found(start, put_in, defect):
    put_in(defect)
    assert finds_it(start(f"h753-{defect.test}").to(1500)), "the self-test passes all the same"


def test_what_the_floating_point_unit_works_out_at_480_mhz(start):
    run = start("h753-demo").to(20)
    text = run.sent["USART3"].decode("ascii")
    assert text.startswith("Nucleo-H753ZI at 480 MHz\r\n")
    numbers = [float(number) for number in re.findall(r"\d+\.\d{15}", text)]
    assert numbers == pytest.approx([math.pi, sum(1 / n for n in range(1, 101)), 1 / 3], rel=2e-7)
    assert not run.machine.notes.all, "it misuses nothing, and nothing that it touches is missing"


def test_the_light_blinks_to_the_cycle_and_the_button_switches_the_other(start):
    run = start("h753-demo").record("PB0", "PE1").drive("PC13", (100.5, True), (200.5, None)).to(1100)
    pins = run.machine.chip.pins
    on, *others = [edge.cycle for edge in pins["PB0"].edges[1:]]
    wanted = [120_000_000 * count for count in (1, 2, 3)]
    assert [cycle - on for cycle in others] == pytest.approx(wanted, abs=1), "an instruction is a fraction of a cycle"
    levels = [(edge.ns // MS, edge.level) for edge in pins["PE1"].edges]
    assert levels == [(0, False), (101, True), (201, False)], "within the next tick"


def test_it_echoes(start):
    run = start("h753-demo").send("USART3", b"hello", baud=115_200, at_ms=21).to(20)
    run.sent["USART3"].clear()
    assert run.to(25).sent["USART3"] == b"hello"


@each("timing", ["flat", "table"])
def test_timers_by_a_cycle_counter_that_nobody_unlocked_and_one_shot_after_another(start, timing):
    run = start("h753-one-shot", timing=timing).record("PB0", "PE1").to(25)
    assert run.resets == ["POR"]
    for pin, period in (("PB0", 480_000), ("PE1", 144_000)):
        cycles = [edge.cycle for edge in run.machine.chip.pins[pin].edges[1:]]
        assert len(cycles) > 20
        assert all(abs(later - cycle - period) < 150 for cycle, later in itertools.pairwise(cycles))
    assert not run.machine.notes.all


def test_the_button_ends_stop_mode_and_standby(start):
    run, asleep = start("h753-sleep"), []
    for step in range(5):
        run.drive("PC13", (50 + 50 * step, True), (55 + 50 * step, None)).to(40 + 50 * step)
        asleep.append(run.machine.asleep[0])
    assert asleep == ["Stop", "Standby", "Stop", "Standby", "Sleep"]
    assert run.resets == ["POR", "STANDBY", "STANDBY"]
    assert run.sent["USART3"].decode().splitlines() == [
        *("Stop", "awake on HSI", "Standby"),
        *("reset by WKUP4", "Stop", "awake on HSI", "Standby"),
        *("reset by WKUP4", "enough"),
    ]
    assert not run.machine.notes.all
