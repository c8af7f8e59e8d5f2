"""What an emulation lacks belongs to the verdict: no gap of ours is blamed on a firmware that waits there.

The images ask a serial flash behind QUADSPI, which the emulated F767 lacks, before they begin.
"""

from __future__ import annotations

import json
from types import SimpleNamespace

import pytest

from hilbench.cli import main
from targets.firmware import image_path
from targets.mcu.stm32.absent_blocks import Quadspi
from tests.share import few

BENCH = """
version = 1
suites = ["suite.py"]
[targets.brain]
board = "{board}"
firmware = '{image}'
"""
SUITE = """
from hilbench.check import case

@case("X1", text="The board answers.", source="here")
def test_answers(bench):
    bench.board.run(0.004)
    assert False, "no answer"

@case("X2", text="The board runs.", source="here")
def test_runs(bench):
    bench.board.run(0.001)
"""


def checked(tmp_path, capsys, image, board="nucleo-f767zi"):
    (tmp_path / "bench.toml").write_text(BENCH.format(image=image_path(image), board=board))
    (tmp_path / "suite.py").write_text(SUITE)
    files = ["--json", str(tmp_path / "r.json"), "--junit", str(tmp_path / "r.xml")]
    code = main(["check", str(tmp_path / "bench.toml"), *files])
    report = json.loads((tmp_path / "r.json").read_text())
    return code, report, capsys.readouterr().out.splitlines(), (tmp_path / "r.xml").read_text()


def test_a_clause_that_fails_while_the_firmware_waits_on_what_we_lack_is_inconclusive(tmp_path, capsys):
    code, report, lines, junit = checked(tmp_path, capsys, "rover-log-waits")
    assert code == report["exit_code"] == 4
    failed, passed = report["cases"]
    where = "waits in __wrap_main (log_memory.c:36), polling QUADSPI_SR; QUADSPI is not modelled: no memory answers"
    assert failed["verdict"] == "inconclusive"
    assert failed["cause"] == f"no answer: not counted against the target, because brain {where}"
    assert f"brain {where.partition(';')[0]}, at the end" in failed["evidence"]
    assert passed["verdict"] == "pass"
    first, *_ = (note for note in report["observed"]["notes"] if note["kind"] == "unmodelled")
    assert (first["board"], first["where"], first["at"]) == ("brain", "QUADSPI_DCR", "__wrap_main (log_memory.c:26)")
    assert first["case_ids"] == ["suite/answers", "suite/runs"]
    said = "QUADSPI_DCR and 4 more: QUADSPI is not modelled: no memory answers (__wrap_main (log_memory.c:26))"
    assert f"  brain: {said}" in lines
    assert said in junit
    assert lines[-1] == "exit 4: inconclusive; 5 notes on what the firmware did"


@pytest.mark.parametrize("image", few(["rover-log-no-0x81", "rover-mbed-log-no-0x81"], 1, "the gate has another image"))
def test_having_touched_what_we_lack_excuses_nothing(tmp_path, capsys, image):
    code, report, lines, junit = checked(tmp_path, capsys, image)
    assert code == report["exit_code"] == 1
    assert [case["verdict"] for case in report["cases"]] == ["fail", "pass"]
    assert report["cases"][0]["cause"] == "no answer"
    assert "QUADSPI is not modelled" in junit
    assert lines[-1] == "exit 1: the target violates a clause; 5 notes on what the firmware did"


def test_what_is_odd_about_an_image_stands_in_the_report(tmp_path, capsys):
    _, report, lines, junit = checked(tmp_path, capsys, "boot-application.bin", board="bluepill")
    said = "boot-application.bin: the raw bytes were linked for 0x08002000, judging by their vectors, and are put there"
    assert f"  brain: {said}" in lines
    assert said in junit
    notes = [(note["kind"], f"{note['where']}: {note['text']}") for note in report["observed"]["notes"]]
    assert ("image", said) in notes
    assert "on what the firmware did" in lines[-1]


@pytest.fixture
def waiting(emulate):
    """A board whose program begins to wait in a loop that polls these registers, and what it does then."""

    def build(*polled, boards=1, then=lambda _machine: None):
        def program(machine):
            block = machine.fake.add(Quadspi("QUADSPI", 0xA000_1000, machine.fake.services))
            machine.chip.blocks.append(block)
            machine.usart("USART1")
            loop = SimpleNamespace(pc=0x0800_0100, polled=polled)
            machine.at_ns(5 * MS, lambda: setattr(machine, "waits_in", loop))
            then(machine)

        emulated = emulate(program, *[lambda machine: machine.usart("USART1")] * (boards - 1))
        return emulated, emulated.machines["brain"]

    return build


MS = 1_000_000
QUADSPI_SR, QUADSPI_MISSING, USART1_SR = 0xA000_1008, 0xA000_1100, 0x4001_3800


@pytest.mark.parametrize(
    ("polled", "absent"),
    [
        ((QUADSPI_SR,), True),
        ((QUADSPI_MISSING,), True),
        ((QUADSPI_SR, QUADSPI_SR + 1), True),
        ((USART1_SR,), False),
        ((QUADSPI_SR, USART1_SR), False),
        ((), False),
        ((0x2000_0000,), False),
    ],
)
def test_it_waits_on_what_we_lack_where_nothing_else_could_end_the_wait(waiting, polled, absent):
    emulated, _ = waiting(*polled)
    emulated.bench.run_for(0.1)
    assert bool(emulated.lacking("brain")) is absent


def test_a_block_whose_clock_is_off_is_the_firmware_s_own_mistake(waiting):
    emulated, machine = waiting(QUADSPI_SR)
    emulated.bench.run_for(0.001)
    machine.chip.blocks[-1].clocked = False
    emulated.bench.run_for(0.1)
    assert emulated.lacking("brain") == ""


def test_an_interrupt_that_has_just_come_does_not_end_the_wait_but_a_write_does(waiting):
    """As a main loop does that looks at an absent register, too, and answers what its interrupts bring."""
    emulated, machine = waiting(QUADSPI_SR)
    emulated.bench.run_for(0.1)
    machine.waits_in = None
    assert emulated.lacking("brain")
    machine.writes += 1
    assert emulated.lacking("brain") == ""


@pytest.mark.parametrize(
    ("sends_at_ms", "heard_at_ms", "excused"),
    [
        (None, None, True),
        (None, 1, True),
        (2, None, False),
        (2, 1, False),  # it answered, and then waited
        (0.2, 1, True),  # it greeted, and waits since it was spoken to
        (0.98, 1, True),  # its greeting was still on the line
        (2, 50, True),  # it waited already
    ],
)
def test_who_said_something_after_it_was_spoken_to_and_before_it_waited_is_not_excused(
    waiting, sends_at_ms, heard_at_ms, excused
):
    def then(machine):
        if sends_at_ms is not None:
            machine.at_ns(round(sends_at_ms * MS), lambda: machine.send_all("USART1", b"!"))

    emulated, _ = waiting(QUADSPI_SR, then=then)  # from 5 ms on
    if heard_at_ms is not None:
        emulated.bench.run_for(heard_at_ms / 1000)
        emulated.ports["brain.usart1"].write(b"?")
    emulated.bench.run_for(0.1)
    assert bool(emulated.lacking("brain")) is excused


def test_resets_from_within_and_faults_are_noted_once(emulate):
    emulated = emulate(lambda _machine: None)
    machine = emulated.machines["brain"]
    fault = SimpleNamespace(causes=("PRECISERR",), describe=lambda: "HardFault: a read of nothing", pc=0x0800_0200)
    later = SimpleNamespace(causes=("PRECISERR",), describe=lambda: "HardFault: another read", pc=0x0800_0204)
    for cause in ("POR", "PIN", "IWDG", "IWDG"):
        machine.on_reset(cause)
        machine.on_fault(fault)
        machine.on_fault(later)
    noted = [(note["kind"], note["text"], note["at"]) for note in emulated.noted()]
    assert noted == [("fault", "HardFault: a read of nothing", "0x08000200"), ("reset", "IWDG", "")]


def test_how_a_firmware_came_to_its_end_is_noted_unless_it_is_well(emulate):
    for kind, status, noted in (("lockup", 1, ["lockup"]), ("exit", 0, []), ("exit", 3, ["exit"])):
        emulated = emulate(lambda machine, kind=kind, status=status: machine.end(kind, status))
        emulated.bench.run_until(lambda: False, 0.02)
        assert [note["kind"] for note in emulated.noted()] == noted
