"""The low-power timers of both Nucleo-144 in their places: gates, clocks by RCC, pins, interrupts, each other."""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise

from targets.boards import built_in_board
from targets.mcu.testing import peek, poke
from tests.each import each
from tests.targets.mcu.stm32.small_programs import start

CMPM, ARRM, EXTTRIG, CMPOK, ARROK = (1 << bit for bit in range(5))
ENABLE, SNGSTRT, CNTSTRT = 1, 2, 4
COUNTMODE, RISING = 1 << 23, 1 << 17
ISPR = 0xE000_E200
LSI_HZ = Fraction(32_000)
US = Fraction(1, 1_000_000)


class Nucleo:
    """A board on HSI whose program hangs: a test plays it."""

    def __init__(self, name, gates, choose_lsi):
        machine = start(built_in_board(name))
        self.chip, self.time, self.bus = machine.chip, machine.time, machine.bus
        rcc = self.chip.rcc
        for register, bits in gates.items():
            poke(rcc, register, peek(rcc, register) | bits)
        poke(rcc, "CSR", 1)  # LSION
        for register, value in choose_lsi.items():
            poke(rcc, register, value)
        self.advance(1000 * US)

    def advance(self, seconds):
        end_s = self.time.seconds(self.time.now) + seconds
        while (cycle := self.time.cycle_at(end_s)) > self.time.now:
            due = self.time.next_cycle()
            self.time.run_due(cycle if due is None else min(cycle, due))

    def ticks(self, count):
        """Let ticks of the LSI pass, and the cycle in which the last of them falls."""
        self.advance(count / LSI_HZ)

    def begin(self, timer, reload, compare, *, settings=0, enables=0, bits=CNTSTRT):
        poke(timer, "CFGR", settings)
        poke(timer, "IER", enables)
        poke(timer, "CR", ENABLE)
        poke(timer, "ARR", reload)
        poke(timer, "CMP", compare)
        self.ticks(5)
        assert peek(timer, "ISR") & (ARROK | CMPOK) == ARROK | CMPOK
        poke(timer, "ICR", 0x7F)
        poke(timer, "CR", ENABLE | bits)
        self.ticks(3)

    def timer(self, number):
        return self.chip.peripherals[f"LPTIM{number}"]

    def pending(self, irq):
        return bool(self.bus.read(ISPR + 4 * (irq // 32), 4) >> irq % 32 & 1)


def f767():
    gates = {"APB1ENR": 1 << 9, "AHB1ENR": 0x7F}
    return Nucleo("nucleo-f767zi", gates, {"DCKCFGR2": 1 << 24})


def h753():
    gates = {"APB1LENR": 1 << 9, "APB4ENR": 0x1E00, "AHB4ENR": 0x7F}
    return Nucleo("nucleo-h753zi", gates, {"D2CCIP2R": 4 << 28, "D3CCIPR": 4 << 10 | 4 << 13})


@each(("make", "numbers"), [(f767, (1,)), (h753, range(1, 6))])
def test_each_counts_on_the_clock_that_rcc_chooses_and_in_stop_and_not_without_its_gate(make, numbers):
    nucleo = make()
    timers = [nucleo.timer(number) for number in numbers]
    for timer in timers:
        nucleo.begin(timer, 0xFFFF, 0xFFFF)
    marks = [[peek(timer, "CNT") for timer in timers]]
    nucleo.ticks(320)
    marks.append([peek(timer, "CNT") for timer in timers])
    nucleo.chip.stop_clocks()
    nucleo.ticks(100)
    nucleo.chip.restart_clocks()
    marks.append([peek(timer, "CNT") for timer in timers])
    rcc = nucleo.chip.rcc
    for register in ("APB1ENR", "APB1LENR", "APB4ENR"):
        if register in {one.name for one in rcc.registers.values()}:
            poke(rcc, register, 0)
    nucleo.ticks(100)
    marks.append([peek(timer, "CNT") for timer in timers])
    for first, running, stopped, gated in zip(*marks, strict=True):
        assert running - first == 320
        assert 99 <= stopped - running <= 101
        assert gated == stopped
    assert not [note for note in nucleo.chip.services.notes.all if note.where.startswith("LPTIM")]


def test_on_the_clock_of_the_bus_it_stands_still_in_stop():
    nucleo = f767()
    poke(nucleo.chip.rcc, "DCKCFGR2", 0)
    timer = nucleo.timer(1)
    nucleo.begin(timer, 0xFFFF, 0xFFFF)
    before = peek(timer, "CNT")
    nucleo.chip.stop_clocks()
    nucleo.ticks(100)
    nucleo.chip.restart_clocks()
    assert peek(timer, "CNT") == before


@each(("unmasked", "wakes"), [({"IMR": 1 << 23, "RTSR": 1 << 23}, True), ({}, False)])
def test_the_f767_wakes_up_by_its_line_of_exti(unmasked, wakes):
    nucleo = f767()
    for register, bits in unmasked.items():
        poke(nucleo.chip.exti, register, bits)
    nucleo.begin(nucleo.timer(1), 99, 9, enables=CMPM)
    nucleo.chip.stop_clocks()
    nucleo.ticks(20)
    assert nucleo.pending(93) is wakes
    nucleo.chip.restart_clocks()
    assert nucleo.pending(93)


@each("masked", [{1, 4, 5}, {2, 3}])
def test_those_of_the_h753_wake_up_unless_their_direct_line_is_masked(masked):
    nucleo = h753()
    exti = nucleo.chip.exti
    lines = {1: (93, 47), 2: (138, 48), 3: (139, 50), 4: (140, 52), 5: (141, 53)}
    for number in masked:
        poke(exti, "CPUIMR2", peek(exti, "CPUIMR2") & ~(1 << lines[number][1] - 32))
    for number in lines:
        nucleo.begin(nucleo.timer(number), 999, 99, enables=CMPM)
    nucleo.chip.stop_clocks()
    nucleo.ticks(200)
    assert {number for number, (irq, _) in lines.items() if not nucleo.pending(irq)} == masked


@each(("number", "line"), [(2, 49), (3, 51)])
def test_two_of_the_h753_have_an_output_that_is_an_edge_for_exti(number, line):
    nucleo = h753()
    exti, bit = nucleo.chip.exti, 1 << line - 32
    poke(exti, "RTSR2", bit)
    poke(exti, "CPUIMR2", peek(exti, "CPUIMR2") | bit)
    nucleo.begin(nucleo.timer(number), 0xFFFF, 9)
    assert peek(exti, "CPUPR2") == 0
    nucleo.ticks(30)
    assert peek(exti, "CPUPR2") == bit


@each("make", [f767, h753])
@each(("chosen", "alarm"), [(1, "RTC_ALRA"), (2, "RTC_ALRB")])
def test_the_alarms_of_the_rtc_are_triggers(make, chosen, alarm):
    nucleo = make()
    timer = nucleo.timer(1)
    nucleo.begin(timer, 0xFFFF, 0xFFFF, settings=RISING | chosen << 13, bits=SNGSTRT)
    signals = {name: nucleo.chip.services.output(name) for name in ("RTC_ALRA", "RTC_ALRB")}
    other = next(name for name in signals if name != alarm)
    signals[other].set(True)
    nucleo.ticks(5)
    assert not peek(timer, "ISR") & EXTTRIG
    signals[alarm].set(True)
    nucleo.ticks(5)
    assert peek(timer, "ISR") & EXTTRIG


def test_the_output_of_one_is_the_trigger_of_another_and_an_edge_for_exti():
    nucleo = h753()
    exti = nucleo.chip.exti
    poke(exti, "RTSR2", 1 << 17)
    poke(exti, "CPUIMR2", peek(exti, "CPUIMR2") | 1 << 17)
    nucleo.begin(nucleo.timer(3), 0xFFFF, 0xFFFF, settings=RISING, bits=SNGSTRT)
    nucleo.begin(nucleo.timer(2), 0xFFFF, 9)
    assert peek(nucleo.timer(3), "CNT") == 0
    nucleo.ticks(30)
    assert peek(nucleo.timer(3), "ISR") == EXTTRIG
    assert peek(nucleo.timer(3), "CNT") in (17, 18)
    assert peek(exti, "CPUPR2") == 1 << 17


@each(("make", "output", "out_af", "in_af"), [(f767, "PG13", 3, 3), (h753, "PG13", 1, 1)])
def test_pins(make, output, out_af, in_af):
    nucleo = make()
    port = nucleo.chip.peripherals["GPIOG"]
    for pin, function in ((13, out_af), (12, in_af)):
        poke(port, "MODER", peek(port, "MODER") & ~(3 << 2 * pin) | 2 << 2 * pin)
        poke(port, "AFRH", peek(port, "AFRH") | function << 4 * (pin - 8))
    pins, timer = nucleo.chip.pins, nucleo.timer(1)
    nucleo.begin(timer, 9, 4)
    levels = []
    for _ in range(20):
        levels.append(pins[output].reads_high)
        nucleo.ticks(1)
    assert sum(levels) == 10
    assert sum(a is not b for a, b in pairwise(levels)) in (3, 4)
    poke(timer, "CR", 0)
    nucleo.begin(timer, 0xFFFF, 0xFFFF, settings=COUNTMODE)
    for _ in range(7):
        for high in (True, False):
            pins["PG12"].drive(high)
            nucleo.ticks(3)
    assert peek(timer, "CNT") == 7
