"""Random sequences on a Cortex-M7, DSP and floating point too: as QEMU has them, and the same however a run is cut.

As `test_differential`: 20 400 sequences come from one seed, the first 400 are run every time. Registers and modes of
floating point begin as anything, NaNs with payloads and denormal numbers among them, and are compared bit by bit.
"""

from __future__ import annotations

import itertools
import os
import random
from collections import Counter

import pytest

from targets.mcu.cortexm.kinds import CORTEX_M7
from tests.targets.mcu.differential import coverage, m7, qemu, through_registers
from tests.targets.mcu.differential.encodings import ENCODINGS
from tests.targets.mcu.differential.encodings_m7 import ENCODINGS as MORE_ENCODINGS
from tests.targets.mcu.differential.encodings_m7 import decode
from tests.targets.mcu.differential.groups import M7
from tests.targets.mcu.differential.image import CASES, image_of, make_image
from tests.targets.mcu.differential.report import differences

SEED = 1
QUICK = range(400)
THOROUGH = [range(start, start + 2000) for start in range(QUICK.stop, QUICK.stop + 20_000, 2000)]
EXECUTED_MIN = 10
BOARD = "mps2-an500"
STEPPED = 40  # sequences of an image that are run instruction by instruction


def images_of(numbers):
    starts = range(numbers.start, numbers.stop, CASES)
    return [make_image(SEED, range(start, start + CASES), M7) for start in starts]


REST = pytest.mark.exhaustive("twenty thousand random sequences; the gate has four hundred of them")


@pytest.fixture(
    scope="module",
    params=[QUICK, *(pytest.param(numbers, marks=REST) for numbers in THOROUGH)],
    ids=lambda numbers: f"{numbers.start}-{numbers.stop - 1}",
)
def chunk(request):
    """Images, and what they write."""
    return [(image, m7.Run(image.data).output()) for image in images_of(request.param)]


@pytest.fixture
def needs_qemu():
    if qemu.missing():
        assert not os.environ.get("HILBENCH_EXHAUSTIVE"), f"a thorough run needs {qemu.PROGRAM}"
        pytest.skip(f"{qemu.PROGRAM} is not installed")


class TestSequences:
    @pytest.mark.usefixtures("needs_qemu")
    def test_qemu_executes_them_as_we_do(self, chunk):
        for image, ours in chunk:
            assert not differences(image, SEED, qemu.output_of(image.data, BOARD), ours)

    def test_a_run_may_be_cut_anywhere(self, chunk):
        for image, whole in chunk:
            pieces = random.Random(image.cases[0].number)
            cut = m7.Run(image.data).output(pieces.randint(1, 60) for _ in itertools.count())
            assert not differences(image, SEED, whole, cut)

    def test_a_slice_may_be_ended_from_within_every_access(self, chunk):
        for image, whole in chunk:
            run = through_registers.Run(image.data, stops=True, kind=CORTEX_M7)
            assert not differences(image, SEED, whole, run.output())


def test_a_run_may_be_cut_after_every_instruction():
    image = make_image(SEED, range(STEPPED), M7)
    whole = m7.Run(image.data).output()
    assert not differences(image, SEED, whole, m7.Run(image.data).output(itertools.repeat(1)))


def test_the_timing_model_changes_nothing_else():
    image = make_image(SEED, range(STEPPED), M7)
    whole = m7.Run(image.data).output()
    assert not differences(image, SEED, whole, m7.Run(image.data, "table").output())


def test_a_sequence_alone_does_what_it_does_among_others():
    image, alone, place = make_image(SEED, range(CASES), M7), image_of(SEED, 17, M7), 17
    among, by_itself = m7.Run(image.data).output(), m7.Run(alone.data).output()
    assert alone.result(by_itself, place) == image.result(among, place)
    assert sum(any(alone.result(by_itself, other)) for other in range(CASES)) == 1


def test_a_difference_is_told_with_the_core():
    image = make_image(SEED, range(3), M7)
    expected = m7.Run(image.data).output()
    place = 16 + image.result_size + 4 * 15  # s0 of sequence 1
    actual = expected[:place] + bytes(byte ^ 0xFF for byte in expected[place : place + 4]) + expected[place + 4 :]
    told = differences(image, SEED, expected, actual)
    assert "tests.targets.mcu.differential 1 1 m7" in told
    assert "s0: 0x" in told


@pytest.mark.exhaustive("counts what all twenty thousand sequences execute")
def test_every_encoding_is_executed():
    executed = Counter()
    for numbers in (QUICK, *THOROUGH):
        for image in images_of(numbers):
            for halves, count in coverage.executed_on_m7(image).items():
                encoding = decode(*halves)
                assert encoding is not None, [f"{half:04x}" for half in halves]
                executed[encoding.name] += count
    wanted = {encoding.name for encoding in (*ENCODINGS, *MORE_ENCODINGS) if not encoding.left_out}
    rare = {name: executed[name] for name in wanted if executed[name] < EXECUTED_MIN}
    assert not rare
