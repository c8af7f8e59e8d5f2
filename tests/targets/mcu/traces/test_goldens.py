"""Each image does what its golden trace says, to the cycle, however it is run.

After a change that is meant, `python -m tests.targets.mcu.traces --write` writes the goldens anew.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.targets.mcu.traces.goldens import abridged, difference, golden_path, lines_of
from tests.targets.mcu.traces.scenarios import PLAIN, RUNS, SCENARIOS, trace

ROOT = Path(__file__).parents[4]

# a second or more each
LONG = {"selftest-iwdg", "selftest-usart", "style-kernel-busy"}

# one for each thing that a machine may be doing when it is interrupted
FEW = (
    *("bad-lockup", "bad-iwdg-loop", "bench-tick-1khz", "bench-tick-1khz.table", "boot-combined", "echo-dma"),
    *("f767-demo", "f767-demo.table", "f767-sleep", "h753-demo", "h753-sleep"),
    *("style-irq-dma", "style-irq-dma.table", "style-kernel", "style-ll-sleep"),
)


def any_image_in_any_run():
    for name in SCENARIOS:
        if name in FEW or name in LONG:
            continue
        for label, run in RUNS.items():
            yield pytest.param(name, run, marks=pytest.mark.exhaustive("takes too long"), id=f"{name}-{label}")


def long_ones_apart(names):
    return [
        pytest.param(name, marks=pytest.mark.exhaustive("takes too long")) if name in LONG else name for name in names
    ]


def check(name, run=PLAIN, **options):
    found = abridged(*trace(SCENARIOS[name], run, **options))
    different = difference(lines_of(name), found)
    assert not different, f"{name}: {different}"


@pytest.mark.parametrize("name", long_ones_apart(SCENARIOS))
def test_the_trace_is_the_golden_one(name):
    check(name)


@pytest.mark.parametrize("run", RUNS.values(), ids=RUNS)
@pytest.mark.parametrize("name", FEW)
def test_it_does_not_matter_how_it_is_run(name, run):
    check(name, run)


@pytest.mark.parametrize(("name", "run"), list(any_image_in_any_run()))
def test_it_does_not_matter_how_any_image_is_run(name, run):
    check(name, run)


@pytest.mark.exhaustive("takes too long")
@pytest.mark.parametrize("run", ["executing-all", "steps-of-100-us", "irregular-steps"])
@pytest.mark.parametrize("name", sorted(LONG))
def test_it_does_not_matter_how_a_long_one_is_run(name, run):
    check(name, RUNS[run])


@pytest.mark.parametrize("seed", ["0", "4242"])
def test_it_does_not_matter_in_which_process(seed):
    found = subprocess.run(
        [sys.executable, "-m", "tests.targets.mcu.traces", *FEW],
        cwd=ROOT,
        env={**os.environ, "PYTHONHASHSEED": seed},
        capture_output=True,
        text=True,
    )
    assert (found.returncode, found.stdout, found.stderr) == (0, "", "")


@pytest.mark.parametrize("name", ["boot-combined", "selftest-crc", "style-registers"])
@pytest.mark.parametrize("ending", ["bin", "hex"])
def test_it_does_not_matter_in_which_format_the_image_is(name, ending):
    _, expected = trace(SCENARIOS[name])
    _, found = trace(SCENARIOS[name], image=f"{name}.{ending}")
    assert not difference(expected, found)


def test_every_golden_trace_has_its_scenario():
    assert {path.stem for path in golden_path("x").parent.glob("*.txt")} == set(SCENARIOS)
