"""Each image does what its golden trace says, to the cycle, however it is run.

After a change that is meant, `python -m tests.targets.mcu.traces --write` writes the goldens anew.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.each import each
from tests.targets.mcu.traces.goldens import abridged, difference, golden_path, lines_of
from tests.targets.mcu.traces.scenarios import PLAIN, RUNS, SCENARIOS, trace

ROOT = Path(__file__).parents[4]

# Executed whole or in small steps these take seconds.
LONG = {"selftest-iwdg", "selftest-usart", "style-kernel-busy"}
# Awaits a crystal for two seconds at 216 MHz: executed whole that takes minutes.
NEVER_WHOLE = {"f767-ticker"}
WAYS_FOR_LONG = ("executing-all", "steps-of-100-us", "irregular-steps")

# One for each thing that a machine may be doing when it is interrupted. Each is run in one or two of the ways.
FEW = (
    ("bad-lockup", "bad-iwdg-loop", "bench-tick-1khz", "f767-demo.table", "h753-demo"),
    ("f767-sleep", "h753-sleep", "style-irq-dma", "bench-tick-1khz.table", "echo-dma"),
    ("style-irq-dma.table", "style-kernel", "style-ll-sleep", "boot-combined", "f767-demo"),
)
OTHER_WAY = pytest.mark.exhaustive("each image in all ways; the gate has a dozen images, and each way with one of them")
WAYS_OF_FEW = [
    pytest.param(name, list(RUNS)[column + half * len(row)], marks=OTHER_WAY if row is FEW[2] else ())
    for row, halves in zip(FEW, ((0,), (1,), (0, 1)), strict=True)
    for column, name in enumerate(row)
    for half in halves
] + [(name, "hooked") for name in ("bad-iwdg-loop", "style-kernel", "style-ll-sleep", "style-irq-dma.table")]


JUDGED = pytest.mark.exhaustive("the gate has what tests of this image require, or the trace of one like it")


def check(name, way=None):
    found = abridged(*trace(SCENARIOS[name], PLAIN if way is None else RUNS[way]))
    different = difference(lines_of(name), found)
    assert not different, f"{name}, {way or 'plain'}: {different}"


def of_the_gate(name):
    """Self-tests judge themselves (firmware/test_selftests), as do those that other tests look at."""
    if name.startswith("selftest-"):
        return name in {"selftest-cpu", "selftest-systick", "selftest-gpio"}
    return name not in {"bench-adc-dma", "echo-all", "echo-irq-921600", "h753-lptim", "style-arduino", "style-bus-ways",
                        "style-dac-dma", "style-escalated-svc", "style-hal-buses", "style-kernel-busy",
                        "style-ll-buses", "style-opencm3", "vehicle-v0", "vehicle-v1"}  # fmt: skip


@pytest.mark.parametrize(
    "name",
    [name if of_the_gate(name) else pytest.param(name, marks=JUDGED) for name in SCENARIOS],
)
def test_the_trace_is_the_golden_one(name):
    check(name)


@pytest.mark.parametrize(("name", "way"), WAYS_OF_FEW)
def test_it_does_not_matter_how_it_is_run(name, way):
    check(name, way)


@OTHER_WAY
@pytest.mark.parametrize("name", SCENARIOS)
def test_it_does_not_matter_how_any_image_is_run(name):
    for way in WAYS_FOR_LONG if name in LONG else RUNS:
        if RUNS[way].skip_idle or name not in NEVER_WHOLE:
            check(name, way)


@pytest.mark.parametrize(
    ("seed", "names"),
    [
        pytest.param("4242", ("echo-dma", "f767-demo", "h753-demo"), id="one-of-each-family"),
        pytest.param(
            "0",
            [name for row in FEW for name in row],
            marks=pytest.mark.exhaustive("more images with another seed; the gate has one of each family"),
            id="all",
        ),
    ],
)
def test_it_does_not_matter_in_which_process(seed, names):
    found = subprocess.run(
        [sys.executable, "-m", "tests.targets.mcu.traces", *names],
        cwd=ROOT,
        env={**os.environ, "PYTHONHASHSEED": seed},
        capture_output=True,
        text=True,
    )
    assert (found.returncode, found.stdout, found.stderr) == (0, "", "")


@each("name", ["boot-combined", "selftest-crc", "style-registers"])
def test_it_does_not_matter_in_which_format_the_image_is(name):
    _, expected = trace(SCENARIOS[name])
    for ending in ("bin", "hex"):
        _, found = trace(SCENARIOS[name], image=f"{name}.{ending}")
        assert not difference(expected, found), ending


def test_every_golden_trace_has_its_scenario():
    assert {path.stem for path in golden_path("x").parent.glob("*.txt")} == set(SCENARIOS)
