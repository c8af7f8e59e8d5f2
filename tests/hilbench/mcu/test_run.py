"""`hilbench run`: what it prints, what it returns, how it ends."""

from __future__ import annotations

import io
import json
import os
import re
import signal
import struct
from fractions import Fraction
from functools import partial

import pytest

from hilbench.benchfile.reader import open_bench
from hilbench.errors import UsageError
from hilbench.exit_codes import ExitCode
from hilbench.journal import Journal
from hilbench.serving.run import RunOptions, run
from hilbench.terminal.console import Console
from targets.mcu.pins import PadMode
from targets.mcu.services import Wave

SECOND_NS = 10**9


@pytest.fixture
def ran(bench_file, fake_maker):
    """Run programs; return exit code, standard output, standard error."""

    def go(*programs, more="", **options):
        out, err = io.StringIO(), io.StringIO()
        options = {"for_ns": SECOND_NS // 10} | options
        code = run(
            RunOptions(**options),
            bench_file(more, boards=len(programs)),
            Console(out, err),
            make_machine=fake_maker(*programs),
        )
        return code, out.getvalue(), err.getvalue()

    return go


def hello(machine):
    machine.usart("USART1")
    machine.send_all("USART1", b"hello\r\nworld")
    machine.output("PC13")
    machine.at_ns(50_000_000, lambda: machine.chip.pins["PC13"].set_latch(True))
    machine.at_ns(60_000_000, lambda: machine.notes.add("unmodelled", "ADC1_CR2", "ADC1 is not modelled"))
    machine.at_ns(70_000_000, lambda: machine.on_console(b"from a debugger\n", "semihosting"))
    machine.at_ns(80_000_000, machine.reset)


def test_it_ends_when_the_time_is_up_and_says_how_it_went(ran):
    code, out, err = ran(hello)
    assert (code, out) == (ExitCode.OK, "")
    assert err.startswith("ran 0.100000 s of bench time at ")
    assert "brain.usart1: 12 bytes sent" in err
    assert "1 note on what the firmware did:\n  brain: ADC1_CR2: ADC1 is not modelled\n" in err


def test_a_program_that_neither_waits_nor_sleeps_is_seen_in_its_functions(ran):
    """A kernel whose tasks yield for ever."""

    def program(machine):
        for step in range(40):
            machine.at_ns((2 + 10 * step) * 1_000_000, lambda pc=0x100 + (step % 3 == 0): setattr(machine, "pc", pc))

    _, _, err = ran(program, for_ns=400_000_000)
    assert re.search(
        r"^  brain: runs in f100 \(2\d of 32 looks at its program counter\), f101 \(1\d\), at the end$",
        err,
        re.MULTILINE,
    )


def test_resets_are_counted_by_cause_without_follow(ran):
    def program(machine):
        for ms, cause in ((10, "IWDG"), (20, "PIN"), (30, "IWDG")):
            machine.at_ns(ms * 1_000_000, partial(machine.on_reset, cause))

    _, _, err = ran(program)
    assert "  brain: 2 resets, the last at 0.030000 s (IWDG)\n" in err
    assert "  brain: 1 reset, at 0.020000 s (PIN)\n" in err
    _, out, _ = ran(program, as_json=True)
    assert json.loads(out)["resets"] == [
        {"board": "brain", "reason": "IWDG", "count": 2, "last_ns": 30_000_000},
        {"board": "brain", "reason": "PIN", "count": 1, "last_ns": 20_000_000},
    ]


def test_an_oscillator_that_starts_at_the_end_says_when_it_will_be_ready(ran):
    def program(machine):
        machine.chip.starting["LSE"] = Fraction(2_000_123_457, 10**9)

    _, _, err = ran(program)
    assert "  brain: LSE starts, and is ready at 2.000123 s\n" in err
    _, out, _ = ran(program, as_json=True)
    assert json.loads(out)["starting"] == {"brain": {"LSE": 2_000_123_457}}


def noisy(machine):
    for where in ("CAN_MCR", "ADC1_CR2", *(f"CAN_FR{number}" for number in range(4)), "ADC1_CR1"):
        machine.notes.add("unmodelled", where, f"{where[:3]} is not modelled")
    for number in range(29):
        machine.notes.add("misuse", f"PE{number}", "configured by the program, but this package has no such pin")
    machine.notes.add("misuse", "CAN_MSR", "CAN is not modelled")
    machine.notes.add("unmodelled", "CAN_BTR", "the rate is only kept")


def test_notes_of_one_cause_are_one_line(ran):
    """The journal and JSON have each."""
    _, _, err = ran(noisy)
    assert err.splitlines()[2:] == [
        "38 notes on what the firmware did, in 6 lines (--notes all for each):",
        "  brain: CAN_MCR and 4 more: CAN is not modelled",
        "  brain: ADC1_CR2: ADC is not modelled",
        "  brain: ADC1_CR1: ADC is not modelled",
        "  brain: PE0 and 28 more: configured by the program, but this package has no such pin",
        "  brain: CAN_MSR: CAN is not modelled",
        "  brain: CAN_BTR: the rate is only kept",
    ]
    _, out, _ = ran(noisy, as_json=True)
    assert len(json.loads(out)["notes"]) == 38


def test_each_note_is_told_if_wanted(ran):
    _, _, err = ran(noisy, each_note=True)
    lines = err.splitlines()[2:]
    assert lines[0] == "38 notes on what the firmware did:"
    assert len(lines) == 39


def test_follow_tells_the_first_notes_of_a_cause_and_that_there_are_more(ran):
    def of_pins(out):
        return [line.split(maxsplit=2)[2] for line in out.splitlines() if "PE" in line]

    said = "configured by the program, but this package has no such pin"
    _, out, _ = ran(noisy, follow=True)
    assert of_pins(out) == [
        f"note: PE0: {said}",
        f"note: PE1: {said}",
        "note: PE2, and more of this cause (--notes all)",
    ]
    _, out, _ = ran(noisy, follow=True, each_note=True)
    assert len(of_pins(out)) == 29


def test_what_is_odd_about_an_image_is_a_note_of_the_run(ran, image):
    image.write_bytes(struct.pack("<II", 0x2000_5000, 0x0800_4009) + b"\xfe\xe7")
    said = "a.bin: the raw bytes were linked for 0x08004000, judging by their vectors, and are put there"
    _, _, err = ran(lambda _machine: None)
    assert f"2 notes on what the firmware did:\n  brain: {said}\n" in err
    _, out, _ = ran(lambda _machine: None, follow=True)
    assert out.splitlines()[0].split(maxsplit=2) == ["0.000000", "brain", f"note: {said}"]
    _, out, _ = ran(lambda _machine: None, as_json=True)
    assert [(note["kind"], note["where"]) for note in json.loads(out)["notes"]] == [("image", "a.bin")] * 2


def test_follow_tells_everything_line_by_line_in_order_of_time(ran):
    code, out, _ = ran(hello, follow=True)
    lines = [line.split(maxsplit=2) for line in out.splitlines()]
    assert code == ExitCode.OK
    assert [line[1:] for line in lines] == [
        ["brain.PC13", "low (LED PC13 on)"],
        ["brain.usart1", "> hello"],
        ["brain.PC13", "high (LED PC13 off)"],
        ["brain", "note: ADC1_CR2: ADC1 is not modelled"],
        ["brain.semihosting", "> from a debugger"],
        ["brain", "reset (PIN)"],
        ["brain.usart1", "> world"],
    ]


def test_what_would_not_show_is_escaped(ran):
    def program(machine):
        machine.usart("USART1")
        machine.send_all("USART1", b"\x1b[2J\xff\x07\t.\xc3\xa4\n")

    _, out, _ = ran(program, follow=True)
    assert out.split("> ")[1] == "\\x1b[2J\\xff\\x07\t.ä\n"


def test_a_fast_pin_is_told_once(ran):
    def program(machine):
        machine.output("PA8")
        machine.every(10_000, lambda: machine.chip.pins["PA8"].set_latch(machine.chip.pins["PA8"].level is False))

    _, out, _ = ran(program, follow=True, for_ns=SECOND_NS)
    told = [line.split(maxsplit=2)[2] for line in out.splitlines() if "period" in line]
    assert told == ["period 20000 ns, high 10000 ns (50.00 %)"]


def test_a_period_that_is_no_whole_number_of_nanoseconds_is_told_once_too(ran):
    def program(machine):
        machine.output("PA8")
        pin = machine.chip.pins["PA8"]

        def toggle(cycle):
            machine.time.at(cycle, lambda: (pin.set_latch(pin.level is False), toggle(cycle + 7000)))

        toggle(7000)

    _, out, _ = ran(program, follow=True, for_ns=SECOND_NS // 2)
    assert len([line for line in out.splitlines() if "period 1944" in line]) == 1


def test_the_duty_of_a_clock_is_not_taken_from_rounded_times(ran):
    def program(machine):
        clock = machine.chip.signals.output("MCO")
        machine.chip.signals.route("MCO", "PA8")
        machine.chip.pins["PA8"].configure(PadMode.AF_PUSH_PULL, latch=False, pull=None)
        machine.at_ns(30_000_000, lambda: clock.set_wave(Wave(hz=Fraction(8_000_000), duty=Fraction(1, 2))))

    _, out, _ = ran(program, follow=True)
    told = [line.split(maxsplit=2)[2] for line in out.splitlines() if "period" in line]
    assert told == ["period 125 ns, high 62 ns (50.00 %)"]


@pytest.mark.parametrize(("mode", "text"), [("Sleep", ""), ("Stop", ", in Stop mode")])
def test_where_the_cpu_sleeps_at_the_end(ran, mode, text):
    _, _, err = ran(lambda machine: setattr(machine, "asleep", (mode, 0x0800_0124)))
    assert f"  brain: sleeps in 0x08000124{text}, at the end\n" in err


@pytest.mark.parametrize(("status", "code"), [(0, ExitCode.OK), (3, ExitCode.VIOLATION)])
def test_firmware_that_ends_itself_gives_its_status(ran, status, code):
    got, _, err = ran(lambda machine: machine.at_ns(30_000_000, lambda: machine.end("exit", status)), for_ns=None)
    assert got == code
    first = err.splitlines()[0]
    assert first == (
        f"hilbench: brain: the firmware ended with status {status}: main (main.c:7), PC 0x08000124, after 0.030000 s"
    )
    assert "ran 0.030000 s" in err


def test_firmware_that_cannot_run_on_is_one_line_and_exit_1(ran):
    got, _, err = ran(lambda machine: machine.at_ns(30_000_000, lambda: machine.end("lockup", 1)), for_ns=None)
    assert got == ExitCode.VIOLATION
    assert err.splitlines()[0] == (
        "hilbench: brain: lockup in main (main.c:7), PC 0x08000124, after 0.030000 s: as told"
    )


def test_the_first_of_two_boards_to_end_ends_the_run(ran):
    def late(machine):
        machine.at_ns(9_000_000, machine.end)

    def soon(machine):
        machine.at_ns(8_000_000, lambda: machine.end("exit", 4))

    got, out, _ = ran(late, soon, as_json=True)
    report = json.loads(out)
    assert (got, report["exit_code"]) == (ExitCode.VIOLATION, 1)
    assert (report["end"]["board"], report["end"]["ns"], report["bench_time_s"]) == ("other", 8_000_000, 0.008)


def test_json_is_all_of_the_standard_output(ran):
    code, out, err = ran(hello, as_json=True)
    report = json.loads(out)
    assert (code, err) == (ExitCode.OK, "")
    assert report["bench_time_s"] == 0.1
    assert report["end"] is None
    assert report["lines"]["brain.usart1"] == {"sent": 12, "framing_errors": 0}
    assert [note["where"] for note in report["notes"]] == ["ADC1_CR2"]


def test_two_runs_are_the_same(ran, tmp_path):
    events = []
    for name in ("a", "b"):
        ran(hello, journal=tmp_path / name)
        events.append(Journal.read(tmp_path / name).events)
    assert events[0] == events[1]
    assert {"tx", "pin", "note", "console", "reset"} <= {event["kind"] for event in events[0]}


def test_in_real_time_it_is_no_faster_than_the_clock(ran):
    _, out, _ = ran(hello, realtime=True, as_json=True)
    assert json.loads(out)["real_time_factor"] <= 1.05


def test_an_interrupted_run_says_so_and_is_complete(ran, tmp_path):
    def program(machine):
        hello(machine)
        machine.at_ns(90_000_000, lambda: os.kill(os.getpid(), signal.SIGINT))

    code, _, err = ran(program, for_ns=None, journal=tmp_path / "j")
    assert code == ExitCode.INTERRUPTED
    assert err.startswith("interrupted after 0.")
    assert Journal.read(tmp_path / "j").ended


def test_what_cannot_be_run_is_said_in_one_line(ran):
    with pytest.raises(UsageError, match="--follow and --json both want the standard output"):
        ran(hello, follow=True, as_json=True)
    with pytest.raises(UsageError, match=r"^pioneer: runs no firmware; serve it: hilbench serve pioneer --pty ./p2$"):
        run(RunOptions(), open_bench("pioneer"), Console(io.StringIO(), io.StringIO()))


def test_time_in_which_all_programs_sleep_passes_in_longer_rounds(ran):
    machines = []

    def sleeper(machine):
        machines.append(machine)
        machine.asleep = ("Stop", 0x0800_0124)
        machine.at_ns(1500 * SECOND_NS, lambda: setattr(machine, "asleep", None))

    code, _, err = ran(sleeper, for_ns=2000 * SECOND_NS)
    assert code == ExitCode.OK
    assert err.startswith("ran 2000.000000 s")
    asleep = [ns for ns in machines[0].runs if ns <= 1500 * SECOND_NS]
    assert len(asleep) < 16_000
    awake = [ns for ns in machines[0].runs if ns > 1510 * SECOND_NS]
    assert awake[1] - awake[0] == SECOND_NS // 100
