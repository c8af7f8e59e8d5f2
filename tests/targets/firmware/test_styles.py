"""The images in different styles, echoes and benchmarks: that they do what their sources say."""

from __future__ import annotations

import itertools
import math

import pytest

from tests.each import each

MS = 1_000_000
TEXT = bytes(range(256))
OTHER_TIMING = pytest.mark.exhaustive("the other timing model; the gate has golden traces with it")


def periods_ms(run, pin):
    edges = run.edges_ms(pin)[1:]  # the first is the pin's becoming an output
    return [round(later - earlier, 3) for earlier, later in itertools.pairwise(edges)]


def test_registers_blinks_at_about_1_hz(start):
    run = start("style-registers").record("PC13").to(1500)
    periods = periods_ms(run, "PC13")[1:]
    assert len(periods) >= 2
    assert all(300 < period < 700 for period in periods)
    assert not run.machine.notes.all


def test_hal_ticks_and_echoes_in_upper_case(start):
    run = start("style-hal").record("PB0", "PC13").send("USART2", b"shout", baud=115_200, at_ms=250).to(450)
    text = run.sent["USART2"]
    assert text.startswith(b"style-hal at 72000000 Hz\r\ntick 1\r\n")
    assert b"tick 4\r\n" in text
    assert b"SHOUT" in text
    assert set(periods_ms(run, "PB0")[1:]) == {5.0}
    assert not run.misuses


def test_hal_pwm_grows_with_each_tick(start):
    run = start("style-hal").record("PA6").to(350)
    edges = run.machine.chip.pins["PA6"].edges
    pulses = [(rise, fall) for (_, rise, up), (_, fall, _down) in itertools.pairwise(edges) if up]
    widths = [fall - rise for rise, fall in pulses]
    assert sorted(set(widths)) == [100_000, 200_000, 300_000]
    assert widths == sorted(widths)
    assert {later - earlier for (earlier, _), (later, _) in itertools.pairwise(pulses)} == {1_000_000}


def test_a_clock_at_osc_in_is_the_way_to_72_mhz_on_the_nucleo(start):
    run = start("style-hse-bypass").record("PA5").send("USART2", b"twice", baud=115_200, at_ms=20)
    run.drive("PC13", (70, False), (80, None), (90, False), (100, None)).to(210)
    assert run.sent["USART2"] == b"style-hse-bypass at 72000000 Hz\r\ntwicebutton 1\r\nbutton 2\r\n"
    assert set(map(round, periods_ms(run, "PA5"))) == {50}
    assert not run.machine.notes.all


def test_a_sine_by_dma_and_an_echo_on_a_device_of_high_density(start):
    run = start("style-dac-dma").send("UART4", b"Sine", baud=115_200, at_ms=50)
    machine, volts = run.machine, []
    for sample in range(64):
        machine.at_ns(int(150 * MS + sample * MS / 32), lambda: volts.append(machine.chip.pins["PA4"].volts))
    run.to(160)
    codes = [round(value * 4095 / 3.3) for value in volts]
    assert codes[:32] == codes[32:]
    assert sorted(codes[:32]) == sorted(round(2048 + 2000 * math.sin(2 * math.pi * n / 32)) for n in range(32))
    assert max(codes) == 4048
    assert run.sent["UART4"] == b"style-dac-dma at 32000 samples/s\r\nsINEwave 102\r\n"
    assert not machine.notes.all


@pytest.mark.exhaustive("seconds in the emulator; the gate has its golden trace")
def test_a_device_of_the_value_line(start):
    run = start("style-value-line").record("PC8", "PC9", "PA2").send("USART1", b"echo", baud=115_200, at_ms=30)
    run.drive("PA0", (60, True), (80, False))
    machine, volts = run.machine, []
    for step in range(8):
        machine.at_ns(100 * MS + step * MS // 2, lambda: volts.append(machine.chip.pins["PA4"].volts))
    run.to(260)
    assert run.sent["USART1"] == b"style-value-line at 24 MHz\r\necho"
    assert set(periods_ms(run, "PC8")) == {50.0}
    assert [round(ms) for ms in run.edges_ms("PC9")[1:]] == [60, 80]
    assert set(periods_ms(run, "PA2")[2:]) == {0.25, 0.75}
    assert sorted(round(volt, 3) for volt in volts) == sorted(2 * [0.0, 1.1, 2.2, 3.3])
    assert not machine.notes.all


def test_interrupts_and_dma(start):
    run = start("style-irq-dma").record("PC13", "PB1")
    run.drive("PA0", (50, False), (51, True), (70, False), (71, None))
    run.send("USART1", b"led\r\nwhat\r\ncount\r\n", baud=115_200, at_ms=100).to(200)
    assert run.sent["USART1"].decode().splitlines() == [
        "style-irq-dma",
        "button",
        "button",
        "ok",
        "? what",
        "bytes 18 ticks 10 presses 2",
    ]
    assert run.edges_ms("PC13")[1:] == [pytest.approx(100 + 50 / 115.2, abs=1.5)]
    assert set(periods_ms(run, "PB1")) == {10.0}
    assert not run.misuses


@each("name", ["style-kernel", "style-kernel-busy"])
def test_kernel(start, name):
    run = start(name).record("PA0", "PA1", "PA2").to(450)
    assert run.sent["USART1"].startswith(b"messages 50 wrong 0 sum ")
    assert b"messages 100 wrong 0" in run.sent["USART1"]
    for pin, period in (("PA0", 1), ("PA1", 5), ("PA2", 20)):
        mean = periods_ms(run, pin)
        assert sum(mean) / len(mean) == pytest.approx(period, rel=0.02)
    assert not run.misuses


def test_a_kernel_that_is_entered_by_an_escalated_supervisor_call(start):
    run = start("style-escalated-svc").record("PA0", "PA1", "PC13").to(250)
    assert run.sent["USART1"] == b"toggles 20\r\ntoggles 40\r\n"
    for pin, period in (("PA0", 1), ("PA1", 5)):
        assert all(abs(found - period) < 0.02 for found in periods_ms(run, pin)[1:])
    assert not run.edges_ms("PC13")[1:]
    assert not run.machine.notes.all


def test_clocks_at_mco(start):
    run, told = start("style-mco").record("PA8", "PC13"), []
    pin = run.machine.chip.pins["PA8"]
    pin.on_wave = lambda wave: told.append((round(run.machine.now_ns / MS), wave and wave.hz / 10**6))
    run.to(30)
    assert told == [(1, 8), (11, 36), (16, 8), (21, None), (26, 8)]
    assert [edge.level for edge in pin.edges] == [False, None, False]
    assert not run.machine.notes.all


def test_sleep_and_stop(start):
    run = start("style-ll-sleep").record("PC13").drive("PA0", (1500, True), (1510, False)).to(1499)
    assert run.sent["USART1"] == b"stop\r\n"
    assert periods_ms(run, "PC13") == [100.0] * 9
    run.to(2700)
    assert run.sent["USART1"] == b"stop\r\nwoken 1\r\nstop\r\n"
    assert not run.misuses


def test_swj_cfg_is_polled_until_it_reads_back(start):
    run = start("style-swj").record("PB3").to(20)
    assert run.sent["USART1"] == b"only SWD is left\r\n"
    assert set(periods_ms(run, "PB3")[1:]) == {1.0}
    assert [(note.kind, note.where) for note in run.machine.notes.all] == [("assumed", "AFIO_MAPR.SWJ_CFG")]


@each("name", ["boot-combined", "boot-application"])
def test_the_application_runs_at_its_address(start, name):
    run = start(name).to(50)
    assert run.sent["USART1"] == b"application at 0x8002000\r\n"
    assert run.machine.bus.read(0xE000_ED08, 4) == 0x0800_2000
    assert not run.misuses


@each(("name", "pin"), [("boot-combined", False), ("boot-loader", None), ("boot-loader", False)])
def test_the_boot_loader_stays(start, name, pin):
    run = start(name).record("PC13").drive("PB9", (0, pin)).to(300)
    assert not run.sent["USART1"]
    assert len(run.edges_ms("PC13")) > 5


@pytest.mark.parametrize("timing", ["flat", pytest.param("table", marks=OTHER_TIMING)])
@pytest.mark.parametrize(
    ("name", "usarts", "baud"),
    [
        ("echo-irq", ["USART1"], 115_200),
        ("echo-irq-921600", ["USART1"], 921_600),
        ("echo-dma", ["USART1"], 921_600),
        ("echo-all", ["USART1", "USART2", "USART3"], 115_200),
    ],
)
def test_echo(start, name, usarts, baud, timing):
    run = start(name, timing=timing)
    for usart in usarts:
        run.send(usart, TEXT, baud=baud, at_ms=10)
    run.to(10 + len(TEXT) * 10_000 / baud + 3)
    assert {usart: bytes(run.sent[usart]) for usart in usarts} == dict.fromkeys(usarts, TEXT)
    assert not run.misuses


def test_bench_tick_toggles_each_millisecond(start):
    run = start("bench-tick-1khz").record("PA0").to(50)
    assert set(periods_ms(run, "PA0")) == {1.0}


def test_bench_adc_dma_loses_nothing(start):
    run = start("bench-adc-dma").record("PA2").to(20)
    at = [edge.cycle for edge in run.machine.chip.pins["PA2"].edges][1:]
    assert {later - earlier for earlier, later in itertools.pairwise(at)} == {512 * 84}
    lost = run.machine.image.symbols.find("lost").address - 0x2000_0000
    assert run.machine.ram[lost : lost + 4] == bytes(4)


def test_bench_busy_gets_round(start):
    run = start("bench-busy").record("PA0").to(300)
    assert len(run.edges_ms("PA0")) >= 2
    assert run.machine.ended is None


def test_the_clock_is_kept_through_stop_and_standby(start):
    run = start("style-clock").to(80_000)
    assert run.sent["USART1"].decode().splitlines() == [
        "started  2024-02-28 23:59:50",
        "stopped  2024-02-29 00:00:06",
        "woken    2024-02-29 00:01:07",
    ]
    assert run.resets == ["POR", "STANDBY"]
    assert not run.misuses


def test_a_year_in_standby_is_exact_to_the_second(start):
    """2024 is a leap year: 366 days after 29 February 2024 it is 1 March 2025, at the same second."""
    run = start("style-clock").to(70_000)
    rtc = run.machine.chip.rtc
    assert run.machine.asleep[0] == "Standby"
    rtc._alarm = rtc.count_now + 366 * 86_400 - 1
    rtc._plan()
    year_ms = 366 * 86_400 * 1000
    run.to(70_000 + year_ms - 1000)
    assert run.resets == ["POR"]
    run.to(70_000 + year_ms + 1000)
    assert run.sent["USART1"].decode().splitlines()[-1] == "woken    2025-03-01 00:00:57"


@pytest.mark.exhaustive("the same for Stop; the gate has Standby, and the RTC alone for a year")
def test_a_year_in_stop_is_exact_to_the_second(start):
    """From 28 February 2024 to 28 February 2025 it is 366 days, too."""
    run = start("style-clock").to(10_000)
    rtc = run.machine.chip.rtc
    assert run.machine.asleep[0] == "Stop"
    rtc._alarm = rtc.count_now + 366 * 86_400 - 1
    rtc._plan()
    begun_s = rtc.count_now
    run.to(10_000 + 366 * 86_400 * 1000 - 1000)
    assert len(run.sent["USART1"].splitlines()) == 1
    run.to(10_000 + 366 * 86_400 * 1000 + 1000)
    assert rtc.count_now - begun_s in (366 * 86_400, 366 * 86_400 + 1)
    assert run.sent["USART1"].decode().splitlines()[1] == "stopped  2025-02-28 23:59:57"
