"""The trace of a machine: what is in it, in which order, and that taking it in parts changes nothing."""

from __future__ import annotations

import pytest

from targets.boards import built_in_board
from targets.firmware import image_path
from targets.mcu.image import limits_for, load_image
from targets.mcu.machine import Machine
from targets.mcu.trace import TRACE_VERSION, Trace

MS = 1_000_000


@pytest.fixture
def make():
    board = built_in_board("bluepill")

    def maker(name, **options):
        return Machine(board, load_image(image_path(name), limits_for(board.chip)), **options)

    return maker


def texts(lines):
    return [line.split(" ", 2)[2] for line in lines]


def test_the_header_says_what_was_run(make):
    machine = make("bench-tick-1khz", timing="table")
    header = Trace(machine).header()
    assert header[0] == f"# trace {TRACE_VERSION}"
    assert header[-1] == "# timing table"
    assert machine.image.digest in header[2]
    assert "STM32F103C8" in header[1]


def test_lines_have_cycle_and_time_in_order(make):
    machine = make("boot-combined")
    trace = Trace(machine)
    machine.run_to(20 * MS)
    lines = trace.close()
    cycles = [int(line.split()[0]) for line in lines]
    times = [int(line.split()[1]) for line in lines]
    assert cycles == sorted(cycles)
    assert times == sorted(times)
    assert texts(lines)[0] == "reset POR"
    assert texts(lines)[-1].startswith("stands after ")


def test_frames_handlers_console_and_end(make):
    machine = make("selftest-systick")
    trace = Trace(machine)
    machine.run_to(1000 * MS)
    found = texts(trace.close())
    assert "runs SysTick" in found
    assert "runs Thread mode" in found
    assert any(text.startswith("console semihosting 'ok ") for text in found)
    assert found[-2].startswith("end exit status 0")

    machine = make("boot-combined")
    trace = Trace(machine)
    machine.run_to(20 * MS)
    found = texts(trace.close())
    sends = next(text for text in found if " sends " in text)
    assert found.index(sends) == next(index for index, text in enumerate(found) if " tx " in text) - 1
    assert sum(" sends " in text for text in found) == 1


def test_a_fault_stands_where_it_happened(make):
    machine = make("bad-lockup")
    trace = Trace(machine)
    machine.run_to(100 * MS)
    faults = [text for text in texts(trace.close()) if text.startswith("fault ")]
    assert faults == [
        "fault UNDEFINSTR at 0x08000168 in Thread mode: HardFault",
        "fault PRECISERR at 0x08000172 in HardFault, accessed 0x60000004: lockup",
    ]


@pytest.mark.parametrize("step_ns", [50_000, 777_777])
def test_taken_in_parts_it_is_the_same(make, step_ns):
    whole, parts = make("style-irq-dma"), make("style-irq-dma")
    one, other = Trace(whole), Trace(parts)
    whole.run_to(10 * MS)
    lines = []
    for limit_ns in range(step_ns, 10 * MS, step_ns):
        parts.run_to(limit_ns)
        lines += other.take()
    parts.run_to(10 * MS)
    assert lines + other.close() == one.close()


def test_chosen_pins_alone(make):
    machine = make("boot-combined")
    trace = Trace(machine, pins=["PC13"])
    machine.run_to(20 * MS)
    assert {text.split()[1] for text in texts(trace.close()) if text.startswith("pin ")} == {"PC13"}


def test_who_had_the_callbacks_before_is_still_called(make):
    machine = make("boot-combined")
    frames, resets = [], []
    machine.chip.usarts["USART1"].on_frame = frames.append
    machine.on_reset = resets.append
    trace = Trace(machine)
    machine.run_to(20 * MS)
    assert len(frames) == sum(" tx " in text for text in texts(trace.close())) > 0
    assert resets == ["POR"]


def test_a_note_is_its_kind_and_place_and_its_words_may_change(make):
    machine = make("boot-combined")
    trace = Trace(machine)
    machine.notes.add("misuse", "GPIOA_CRL", "some words", pc=0x0800_0100)
    machine.notes.add("assumed", "SCB_CFSR.PRECISERR", "others")
    notes = [text for text in texts(trace.close()) if text.startswith("note ")]
    assert notes == ["note misuse GPIOA_CRL at 0x08000100", "note assumed SCB_CFSR.PRECISERR"]
