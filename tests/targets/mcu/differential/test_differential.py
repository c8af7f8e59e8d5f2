"""Random sequences on our machine: as QEMU executes them, and the same however a run is cut.

20 400 sequences come from one seed. The first 400 are run every time, all where HILBENCH_EXHAUSTIVE is set; there QEMU
must be installed. `test_vectors` holds against the architecture manual.
"""

from __future__ import annotations

import itertools
import os
import random
from collections import Counter

import pytest

from targets.mcu.engine.api import Reg
from tests.targets.mcu.differential import coverage, qemu, through_registers
from tests.targets.mcu.differential.emulated import make_machine, output_of, run, run_cut, run_in_steps
from tests.targets.mcu.differential.encodings import ENCODINGS, LEFT_OUT, decode, is_wide
from tests.targets.mcu.differential.image import CASES, image_of, make_image
from tests.targets.mcu.differential.report import differences

SEED = 1
QUICK = range(400)
THOROUGH = [range(start, start + 2000) for start in range(QUICK.stop, QUICK.stop + 20_000, 2000)]
EXECUTED_MIN = 10

_counts: dict[range, Counter] = {}


class Chunk:
    """A part of the series: its images, what they write when our machine runs them in one go, how long they take."""

    def __init__(self, numbers):
        starts = range(numbers.start, numbers.stop, CASES)
        self.images = [make_image(SEED, range(start, start + CASES)) for start in starts]
        self.outputs, self.cycles = [], []
        for image in self.images:
            machine, output = make_machine(image.data)
            self.outputs.append(run(machine, output))
            self.cycles.append(machine.cycle)

    def counts(self):
        """Return how often each instruction is executed."""
        return sum((coverage.executed(image) for image in self.images), Counter())


REST = pytest.mark.exhaustive("twenty thousand random sequences; the gate has four hundred of them")


@pytest.fixture(
    scope="module",
    params=[QUICK, *(pytest.param(numbers, marks=REST) for numbers in THOROUGH)],
    ids=lambda numbers: f"{numbers.start}-{numbers.stop - 1}",
)
def chunk(request):
    made = Chunk(request.param)
    if request.param is not QUICK:
        _counts[request.param] = made.counts()
    return made


@pytest.fixture
def needs_qemu():
    if qemu.missing():
        assert not os.environ.get("HILBENCH_EXHAUSTIVE"), f"a thorough run needs {qemu.PROGRAM}"
        pytest.skip(f"{qemu.PROGRAM} is not installed")


@pytest.fixture(scope="module")
def counts():
    """How often each instruction was executed in the whole series; most of it is known from the tests above."""
    return sum((_counts.get(numbers) or Chunk(numbers).counts() for numbers in (QUICK, *THOROUGH)), Counter())


class TestSequences:
    @pytest.mark.usefixtures("needs_qemu")
    def test_qemu_executes_them_as_we_do(self, chunk):
        for image, ours in zip(chunk.images, chunk.outputs, strict=True):
            assert not differences(image, SEED, qemu.output_of(image.data), ours)

    def test_a_run_may_be_cut_after_every_instruction(self, chunk):
        for image, whole, cycle in zip(chunk.images, chunk.outputs, chunk.cycles, strict=True):
            machine, output = make_machine(image.data)
            assert not differences(image, SEED, whole, run_in_steps(machine, output, image))
            assert machine.cycle == cycle

    def test_a_run_may_be_cut_anywhere(self, chunk):
        for image, whole, cycle in zip(chunk.images, chunk.outputs, chunk.cycles, strict=True):
            machine, output = make_machine(image.data)
            pieces = random.Random(image.cases[0].number)
            cut = run_cut(machine, output, (pieces.randint(1, 60) for _ in itertools.count()))
            assert not differences(image, SEED, whole, cut)
            assert machine.cycle == cycle

    def test_a_slice_may_be_ended_from_within_every_access(self, chunk):
        for image, whole in zip(chunk.images, chunk.outputs, strict=True):
            assert not differences(image, SEED, whole, through_registers.Run(image.data, stops=True).output())


def test_steps_do_not_skip_the_beginning_of_a_sequence():
    image = make_image(SEED, range(20))
    machine, output = make_machine(image.data)
    begun, run_to = set(), machine.run_to
    machine.run_to = lambda limit_ns: (begun.add(machine.engine.get(Reg.PC)), run_to(limit_ns))
    run_in_steps(machine, output, image)
    assert begun >= {case.body for case in image.cases}


def test_memory_behind_registers_is_memory():
    image = make_image(SEED, range(CASES))
    through = through_registers.Run(image.data, stops=False)
    assert not differences(image, SEED, output_of(image.data), through.output())
    assert through.accesses > CASES * 128
    assert through.slices == 4  # one for each call of the debugger


def test_the_timing_model_changes_nothing_else():
    image = make_image(SEED, range(CASES // 4))
    whole = output_of(image.data)
    assert not differences(image, SEED, whole, run(*make_machine(image.data, "table")))
    assert not differences(image, SEED, whole, run_in_steps(*make_machine(image.data, "table"), image))


@pytest.mark.parametrize(
    "number",
    [
        CASES + 17,
        *(pytest.param(n, marks=pytest.mark.exhaustive("the first and the last, too")) for n in (CASES, 2 * CASES - 1)),
    ],
)
def test_a_sequence_alone_does_what_it_does_among_others(number):
    image = make_image(SEED, range(CASES, 2 * CASES))
    alone, place = image_of(SEED, number), number - CASES
    assert alone.cases[place].halves == image.cases[place].halves
    among, by_itself = output_of(image.data), output_of(alone.data)
    assert alone.result(by_itself, place) == image.result(among, place)
    assert sum(any(alone.result(by_itself, other)) for other in range(CASES)) == 1


def test_a_difference_is_told_with_code_and_number():
    image = make_image(SEED, range(3))
    expected = output_of(image.data)
    place = 16 + 64  # the first word of the result of sequence 1
    actual = expected[:place] + bytes(byte ^ 0xFF for byte in expected[place : place + 4]) + expected[place + 4 :]
    told = differences(image, SEED, expected, actual)
    assert "tests.targets.mcu.differential 1 1" in told
    assert "sequence 0" not in told
    assert f"{image.cases[1].names[0]}: 0x" in told


@pytest.mark.exhaustive("counts what all twenty thousand sequences execute")
class TestWhatIsExecuted:
    """That the series has what it is meant to have."""

    def test_every_encoding_of_the_table(self, counts):
        executed = Counter()
        for halves, count in counts.items():
            encoding = decode(*halves)
            assert encoding is not None, [f"{half:04x}" for half in halves]
            executed[encoding] += count
        rare = {encoding.name: executed[encoding] for encoding in ENCODINGS if executed[encoding] < EXECUTED_MIN}
        assert rare == {encoding.name: 0 for encoding in ENCODINGS if encoding.left_out}

    def test_every_condition(self, counts):
        blocks = {halves[0] >> 4 & 15 for halves in counts if halves[0] >> 8 == 0xBF and halves[0] & 15}
        narrow = {halves[0] >> 8 & 15 for halves in counts if halves[0] >> 12 == 0xD}
        wide = {first >> 6 & 15 for first, second in counts if first >> 11 == 0x1E and second & 0xD000 == 0x8000}
        assert blocks == set(range(15))
        assert narrow == set(range(14))
        assert wide >= set(range(14))  # above are the instructions that look alike

    def test_every_mask_of_it(self, counts):
        masks = {halves[0] & 15 for halves in counts if halves[0] >> 8 == 0xBF}
        assert masks == set(range(16))

    def test_every_special_register(self, counts):
        read = {second & 0xFF for first, second in counts if first == 0xF3EF and second >> 14 == 2}
        written = {second & 0xFF for first, second in counts if first >> 5 == 0x79C and second >> 14 == 2}
        assert read == {0, 1, 2, 3, 5, 6, 7, 8, 9, 16, 17, 18, 19, 20}
        assert written == {0, 1, 2, 3, 8, 9, 16, 17, 18, 19}


def test_the_table_tells_apart_what_it_lists():
    """Each encoding is found by its own code, unless an earlier one is a special case of it."""
    for encoding in ENCODINGS:
        wide = encoding.mask >= 1 << 16
        first, second = (encoding.value >> 16, encoding.value & 0xFFFF) if wide else (encoding.value, 0)
        assert is_wide(first) is wide
        found = decode(first, second)
        assert found is not None
        assert found.group == encoding.group or found.mask & encoding.mask == encoding.mask
    assert {encoding.name.split()[0] for encoding in ENCODINGS if encoding.left_out} == set(LEFT_OUT)
