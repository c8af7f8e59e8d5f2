"""Each defect that our rover firmware can be built with is found on the emulated board, by a clause of `documented`.

What finds the same defects in the behavioural model is in docs/rover-defects.md; here one clause each is enough.
"""

from __future__ import annotations

import pytest

from hilbench.bench.shared import Shared
from hilbench.benchfile.reader import open_bench
from hilbench.check import CheckOptions, Verdict, run_suites
from hilbench.journal import Journal
from hilbench.mcu.board_provider import BoardProvider
from hilbench.terminal.options import TargetChoice
from measure.mutants.rover import FIRMWARE_ALONE
from targets.firmware import image_names, image_path

pytestmark = pytest.mark.needs_physics

FOUND_BY = {
    "no-0x81": "P02D",
    "0x81-leds-only": "P04D",
    "no-resync": "P11D",
    "no-frame-timeout": "P23D",
    "timer-since-reset": "P23D",
    "no-link-timeout": "P24D",
    "link-stops-report-only": "P24D",
    "eagain-11": "P25D",
    "polled": "P48D",
    "no-len-check": "P22D",
    "throttle-unchecked": "P28D",
    "rpm-150": "P29D",
    "slots-32": "P29D",
    "pid-offsets": "P38D",
    "stale-byte-84": "P39D",
    "no-gps": "P40D",
    "gps-order": "P40D",
    "accel-g": "P41D",
    "quat-wxyz": "P42D",
    "nan-quaternion": "P42D",
    "first-rpm-1": "P43D",
    "led-shared": "P44D",
    "pid-windup": "P45D",
    "pid-no-reset": "P46D",
    "rpm-held": "P47D",
    "slow-start": "P49D",
    "no-periodic-reports": "P30",
    "g0-rates": "P30",
}
FOUND_IN_MOTION = {"status-zero": "R21"}
"""By the suite rover-motion; its own tests run it."""
UNFOUND = {"kd-ki-getters": "no clause asks for 0x85"}
OTHERS = {
    *("9600", "dma", "g0", "g2", "log-no-0x81", "log-waits", "mbed-log-no-0x81", "mbed-start", "pid-report"),
    *("pwm-1khz", "term", "v1b"),
}
"""Images that are no documented rover with a defect."""


def checked(image, clauses):
    choices = [TargetChoice(name="brain.documented", spec=f"nucleo-f767zi:{image_path(image)}")]
    shared = Shared(bench_file=open_bench("rover"), timeout_scale=1.0, journal=Journal())
    select = f"documented and ({' or '.join(sorted(set(clauses)))})"
    options = CheckOptions(bench="rover", suites=("pkt-board",), select=select)
    return run_suites(options, BoardProvider(shared, choices))


def verdicts(image, clauses):
    return {case.clause_ids[0]: case.verdict for case in checked(image, clauses).cases}


def test_every_image_is_known():
    images = {name.removeprefix("rover-") for name in image_names() if name.startswith("rover-")}
    assert images == {*FOUND_BY, *FOUND_IN_MOTION, *UNFOUND, *OTHERS}


def test_images_that_the_model_has_not_are_on_the_page():
    assert {name for name, *_ in FIRMWARE_ALONE} == {*FOUND_IN_MOTION, *UNFOUND}
    finders = {name: by for name, _, _, by in FIRMWARE_ALONE}
    assert all(finders[name].startswith(clause) for name, clause in FOUND_IN_MOTION.items())
    assert all(finders[name].startswith("nothing") for name in UNFOUND)


def test_more_than_fifteen_are_found():
    assert len(FOUND_BY) > 15


@pytest.mark.exhaustive("each image with a defect; the gate has four of them, and each clause against the model")
@pytest.mark.parametrize(("defect", "clause"), FOUND_BY.items())
def test_the_defect_is_found(defect, clause):
    assert verdicts(f"rover-{defect}", [clause])[clause] is Verdict.FAIL


@pytest.mark.exhaustive("seconds in the emulator; the gate has its answer on the board alone")
def test_the_start_of_mbed_leads_to_a_rover_that_answers():
    assert set(verdicts("rover-mbed-start", ["P01", "P02D"]).values()) == {Verdict.PASS}


@pytest.mark.exhaustive("two dozen clauses in the emulator; the gate has some of them on each image")
@pytest.mark.parametrize("image", ["rover", "rover-dma"])
def test_the_rover_without_defects_passes_them_all(image):
    assert set(verdicts(image, FOUND_BY.values()).values()) == {Verdict.PASS}


@pytest.mark.exhaustive("seconds of bench time; the gate has a short case on each of these images")
@pytest.mark.parametrize(
    ("image", "found", "code"),
    [
        ("log-waits", {"P01": Verdict.INCONCLUSIVE, "P02D": Verdict.INCONCLUSIVE}, 4),
        ("log-no-0x81", {"P01": Verdict.PASS, "P02D": Verdict.FAIL}, 1),
        ("mbed-log-no-0x81", {"P01": Verdict.PASS, "P02D": Verdict.FAIL}, 1),
    ],
)
def test_a_rover_that_asks_for_what_the_emulation_lacks(image, found, code):
    report = checked(f"rover-{image}", found)
    assert {case.clause_ids[0]: case.verdict for case in report.cases} == found
    assert report.exit_code == code
    assert any(note.where.startswith("QUADSPI") for note in report.observed.notes)
    waits = [case for case in report.cases if case.verdict is Verdict.INCONCLUSIVE]
    assert all("polling QUADSPI_SR; QUADSPI is not modelled" in case.cause for case in waits)
