"""Our images on the emulated NUCLEO-F767ZI."""

from __future__ import annotations

import math
import re
from fractions import Fraction
from functools import partial

import pytest

from targets.boards import built_in_board
from targets.firmware import image_path
from targets.mcu.image import limits_of, load_image
from targets.mcu.machine import Machine
from targets.mcu.serial_line import SerialFormat
from targets.mcu.stm32.exti import Exti
from targets.mcu.stm32.rcc import BasicRcc
from targets.mcu.stm32f7.chip import Stm32f767
from targets.mcu.stm32f7.flash import Flash
from targets.mcu.stm32f7.pwr import Pwr
from targets.mcu.stm32f7.rcc import Rcc
from targets.mcu.stm32f7.syscfg import Syscfg
from tests.targets.firmware.defect import Defect, finds_it, some

MS = 1_000_000
FORMAT = SerialFormat.parse("8N1")


@pytest.fixture
def nucleo():
    board = built_in_board("nucleo-f767zi")

    def start(name, **options):
        machine = Machine(board, load_image(image_path(name), limits_of(board.variant)), **options)
        machine.sent, machine.said = bytearray(), bytearray()
        machine.chip.usarts["USART3"].on_frame = lambda frame: machine.sent.append(frame.bits & 0xFF)
        machine.on_console = lambda text, _channel: machine.said.extend(text)
        return machine

    return start


@pytest.mark.parametrize("timing", ["flat", "table"])
def test_the_self_test_of_the_chip_passes(nucleo, timing):
    machine = nucleo("f767-chip", timing=timing)
    machine.run_to(2500 * MS)
    lines = machine.said.decode().splitlines()
    assert machine.ended is not None, lines
    assert (machine.ended.kind, machine.ended.status) == ("exit", 0), lines
    assert lines[-1] == f"done {len(lines) - 1} ok 0 failed"
    assert len(lines) == 43


DEFECTS = [
    Defect(
        "no flash by ITCM",
        "chip",
        Stm32f767,
        "_map",
        "base=0x0020_0000, data=flash.memory",
        "base=0x0020_0000, data=system",
    ),
    Defect("boots from AXI", "chip", Stm32f767, "boot", "table = settings.boot_address(pin)", "table = ITCM_RAM"),
    Defect(
        "PLL settings do not hold",
        "chip",
        Rcc,
        "write_PLLCFGR",
        "if self[CR] & (PLLON",
        "if False and self[CR] & (PLLON",
    ),
    Defect("the PLL starts at once", "chip", BasicRcc, "_oscillator", "start_s, stop_s", "start_s / 1000, stop_s"),
    Defect("gates are always open", "chip", BasicRcc, "_apply_gates", "bool(self[offset] & bit)", "True"),
    Defect("resets reset nothing", "chip", BasicRcc, "_write_resets", "peripheral.reset()", "pass"),
    Defect("VOS does not hold", "chip", Pwr, "write_CR1", "and self._pll_on", "and False"),
    Defect("over-drive is never on", "chip", Pwr, "_set_over_drive", "| ODSWRDY if on", "if on"),
    Defect("no lock", "chip", Flash, "_program", "if not self[CR] & PG or self[CR] & LOCK", "if False"),
    Defect("any width", "chip", Flash, "_program", "elif size != wanted", "elif False"),
    Defect("zeros become ones", "chip", Flash, "_program", "(old & value).to_bytes", "value.to_bytes"),
    Defect("erases nothing", "chip", Flash, "_erase", 'b"\\xff" * size', "bytes(size)"),
    Defect("EOP never comes", "chip", Flash, "_end", "EOP if self[CR] & EOPIE else 0", "0"),
    Defect("CR opens without keys", "chip", Flash, "write_CR", "if self[CR] & LOCK", "if False"),
    Defect("port A only", "chip", Syscfg, "_choose_ports", "PORTS[port]", "PORTS[0]"),
    Defect("PR clears nothing in SWIER", "chip", Exti, "write_PR", "self[0x10] &= ~value", "pass"),
]


@pytest.mark.parametrize("defect", some(DEFECTS, 2))
def test_each_defect_of_the_chip_is_found(start, put_in, defect):
    put_in(defect)
    assert finds_it(start(f"f767-{defect.test}").to(2500)), "the self-test passes all the same"


def test_what_the_floating_point_unit_works_out(nucleo):
    machine = nucleo("f767-demo")
    machine.run_to(20 * MS)
    text = machine.sent.decode("ascii")
    assert text.startswith("Nucleo-F767ZI at 216 MHz\r\n")
    numbers = [float(number) for number in re.findall(r"\d+\.\d{15}", text)]
    assert numbers == pytest.approx([math.pi, sum(1 / n for n in range(1, 101)), 1 / 3], rel=2e-7)
    assert numbers[0] == pytest.approx(math.pi, abs=2e-15)
    assert not machine.notes.all, "it misuses nothing, and nothing that it touches is missing"


def test_the_light_blinks_to_the_cycle_and_the_button_switches_the_other(nucleo):
    machine = nucleo("f767-demo")
    for pin in ("PB0", "PB7"):
        machine.chip.pins[pin].record()
    machine.at_ns(100_500_000, lambda: machine.chip.pins["PC13"].drive(True))
    machine.at_ns(200_500_000, lambda: machine.chip.pins["PC13"].drive(None))
    machine.run_to(1100 * MS)
    assert machine.time.hclk_hz == 216_000_000
    on, *others = [edge.cycle for edge in machine.chip.pins["PB0"].edges[1:]]
    assert [cycle - on for cycle in others] == [54_000_000 * count for count in (1, 2, 3)]
    levels = [(edge.ns // MS, edge.level) for edge in machine.chip.pins["PB7"].edges]
    assert levels == [(0, False), (101, True), (201, False)], "within the next tick"


def test_the_button_ends_stop_mode_and_standby(nucleo):
    machine = nucleo("f767-sleep")
    resets, asleep = [], []
    machine.on_reset = resets.append
    for step in range(5):
        machine.at_ns((50 + 50 * step) * MS, lambda: machine.chip.pins["PC13"].drive(True))
        machine.at_ns((55 + 50 * step) * MS, lambda: machine.chip.pins["PC13"].drive(None))
        machine.run_to((40 + 50 * step) * MS)
        asleep.append(machine.asleep[0])
    assert asleep == ["Stop", "Standby", "Stop", "Standby", "Sleep"]
    assert resets == ["POR", "STANDBY", "STANDBY"]
    assert machine.sent.decode().splitlines() == [
        *("Stop", "awake on HSI", "Standby"),
        *("reset by WKUP4", "Stop", "awake on HSI", "Standby"),
        *("reset by WKUP4", "enough"),
    ]
    assert not machine.notes.all


def test_alarms_of_the_low_power_ticker_come_in_sleep_in_stop_and_beyond_the_end_of_a_period(nucleo):
    machine = nucleo("f767-ticker")
    modes = set()
    for step in range(1, 48):
        machine.run_to(100 * step * MS)
        modes.add(machine.asleep and machine.asleep[0])
    begin, *alarms, fired, first, second, end = machine.sent.decode().splitlines()
    assert (begin, fired, end) == ("tickers run", "fired at once", "enough")
    lines = [re.fullmatch(r"(\d+) ticks, late by (\d+)", line) for line in (*alarms, first, second)]
    assert [int(line[1]) for line in lines] == [3277, 1, 4, 33, 300, 20_000, 100, 28_000, 28_000]
    restart = 11  # ticks: a match shows one late, and the clock takes 0.3 ms to be fast again
    assert [int(line[2]) for line in lines] == [restart, restart + 5, restart + 5] + [restart] * 6
    assert modes == {None, "Sleep", "Stop"}
    assert not machine.notes.all


def test_it_echoes(nucleo):
    machine = nucleo("f767-demo")
    machine.run_to(20 * MS)
    machine.sent.clear()
    bit_s = Fraction(1, 115_200)
    for index, byte in enumerate(b"hello"):
        frame = FORMAT.frame(byte, Fraction(21, 1000) + 10 * index * bit_s, bit_s)
        machine.at_ns(int(frame.start_s * 10**9), partial(machine.chip.usarts["USART3"].receive, frame))
    machine.run_to(25 * MS)
    assert bytes(machine.sent) == b"hello"
