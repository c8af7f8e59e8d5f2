"""The suite of the rover's motion: what is right passes, and each clause has something wrong that fails it."""

from __future__ import annotations

from dataclasses import replace

import msgspec
import pytest

from hilbench.check import Verdict
from hilbench.cli import main
from hilbench.exit_codes import ExitCode
from hilbench.systems.rover.motion_clauses import CLAUSES
from measure.mutants.alterations import setting, swapped
from measure.mutants.altered_bench import AlteredBench, first_of_each

pytestmark = pytest.mark.needs_physics

IDS = {clause.id for clause in CLAUSES}
BENCH = AlteredBench(bench="rover", board="nucleo-f767zi", suite="rover-motion", clause_ids=IDS)
SHORT = "flags or unequal_throttles"


def motor(**settings):
    return setting("dc-motor", **settings)


def disc(**settings):
    return setting("tachometer-disc", **settings)


def imu(**settings):
    return setting("mpu9250", **settings)


def gps(**settings):
    return setting("neo6m", **settings)


def signals(part, **others):
    """Show a part something else of the world."""

    def alter(bench_file):
        plan = bench_file.parts[part]
        parts = {**bench_file.parts, part: replace(plan, signals={**plan.signals, **others})}
        return replace(bench_file, parts=parts)

    return alter


def elsewhere(scene):
    """Let it all happen in another scene."""
    return lambda bench_file: replace(bench_file, world=msgspec.structs.replace(bench_file.world, scene=scene))


MUTANTS = [
    # clause, cases, what is wrong, image that runs instead; the first of each clause is found soonest
    ("R01", "throttle_to_speed", motor(idle_speed_rad_s=22.0), {}),
    ("R01", "throttle_to_speed", motor(stall_torque_nm=0.07), {}),
    ("R01", "throttle_to_speed", setting("l298n", drop_1a_v=1.8), {}),
    ("R02", "as_the_original", motor(running_torque_nm=0.0095), {}),
    ("R02", "as_the_original", setting("cells", cells=3), {}),
    ("R03", "breakaway", motor(breakaway_torque_nm=0.0095), {}),
    ("R03", "breakaway", motor(friction_speed_rad_s=8.0), {}),
    ("R04", "both_directions", setting("motor_rb", reversed=True), {}),
    ("R04", "both_directions", swapped("driver.in3", "driver.in4"), {}),
    ("R05", "flags", swapped("driver.ena", "driver.enb"), {}),
    ("R06", "gains_at_power_up", None, {"documented": "rover-slots-32"}),
    ("R07", "settles_in_the_air", None, {"documented": "rover-pid-offsets"}),
    ("R07", "settles_in_the_air", disc(extra_pulses=1), {}),
    ("R08", "settles_on_the_floor", None, {"documented": "rover-slots-32"}),
    ("R09", "tachometers", None, {"documented": "rover-rpm-150"}),
    ("R09", "tachometers", disc(missed=0.1), {}),
    ("R09", "tachometers", disc(slots=32), {}),
    ("R09", "tachometers", swapped("tacho_lf.out", "tacho_lb.out"), {}),
    ("R09", "tachometers", setting("tacho_rf", extra_pulses=7), {}),
    ("R10", "straight_on", motor(idle_speed_rad_s=22.0), {}),
    ("R11", "turning_on_the_spot", elsewhere("carpet"), {}),
    ("R12", "turning_on_a_carpet", elsewhere("hard-floor"), {}),
    ("R13", "unequal_throttles", swapped("driver.in3", "driver.in4"), {}),
    ("R14", "inertial_sensor_at_rest", None, {"documented": "rover-accel-g"}),
    ("R14", "inertial_sensor_at_rest", imu(mount_pitch_deg=10.0), {}),
    ("R14", "inertial_sensor_at_rest", imu(temperature_degc=40.0), {}),
    ("R15", "gyroscope", signals("imu", wz="wx", wx="wz"), {}),
    ("R15", "gyroscope", imu(mount_roll_deg=20.0), {}),
    ("R16", "attitude_on_a_ramp", None, {"documented": "rover-nan-quaternion"}),
    ("R16", "attitude_on_a_ramp", None, {"documented": "rover-quat-wxyz"}),
    ("R16", "attitude_on_a_ramp", None, {"documented": "rover-accel-g"}),
    ("R16", "attitude_on_a_ramp", imu(mount_roll_deg=15.0), {}),
    ("R17", "heading_after_a_turn", imu(x_axis_bearing_deg=90.0), {}),
    ("R17", "heading_after_a_turn", signals("imu", wz="wx"), {}),
    ("R17", "heading_after_a_turn", imu(field_down_nt=14749.0), {}),
    ("R18", "accuracy_of_the_position", None, {"documented": "rover-gps-order"}),
    ("R18", "accuracy_of_the_position", None, {"documented": "rover-no-gps"}),
    ("R18", "accuracy_of_the_position", gps(accuracy_m=25.0), {}),
    ("R19", "positions_along_a_way", signals("gps", x="y", y="x"), {}),
    ("R19", "positions_along_a_way", gps(accuracy_m=25.0), {}),
    ("R20", "without_a_fix", None, {"documented": "rover-stale-byte-84"}),
    ("R21", "receiver_that_is_not_understood", None, {"documented": "rover-status-zero"}),
    ("R21", "receiver_that_is_not_understood", None, {"documented": "rover-no-periodic-reports"}),
    ("R22", "bus_of_the_inertial_sensor and [deaf]", None, {"documented": "rover-status-zero"}),
    ("R22", "bus_of_the_inertial_sensor and [stuck]", None, {"documented": "rover-status-zero"}),
    ("R23", "lost_link and [throttles]", None, {"documented": "rover-no-link-timeout"}),
    ("R23", "lost_link and [setpoints]", None, {"documented": "rover-no-link-timeout"}),
    ("R23", "lost_link", None, {"documented": "rover-link-stops-report-only"}),
    ("R24", "a_stalled_wheel", disc(spurious_hz=20.0), {}),
    ("R24", "a_stalled_wheel", swapped("tacho_rf.out", "tacho_rb.out"), {}),
    ("R25", "a_wall", elsewhere("hard-floor"), {}),
    ("R26", "an_empty_battery", setting("battery", charge=1.0), {}),
    ("R27", "sensor_on_its_side", imu(mount_pitch_deg=30.0), {}),
    ("R27", "sensor_on_its_nose", None, {"documented": "rover-accel-g"}),
]
LONG = {"R06", "R08", "R09", "R17", "R18", "R19", "R20", "R21", "R22", "R23", "R24", "R25"}
"""What no mistake fails within half a second of the emulator: positions, settled speeds, broken sensors, lost links."""


@pytest.mark.slow("our firmware drives for two seconds of bench time")
def test_what_is_right_passes():
    BENCH.require_right(SHORT)


@pytest.mark.slow("one mistake for each clause, in the emulator")
@pytest.mark.parametrize("ids", [IDS - LONG, LONG], ids=["quick", "long"])
def test_each_clause_finds_what_is_wrong(ids):
    assert BENCH.require_found(row for row in first_of_each(MUTANTS) if row[0] in ids) == ids


@pytest.mark.exhaustive("all mistakes, for seconds each in the emulator; the gate has one of each clause")
def test_each_clause_finds_everything_that_is_wrong():
    assert BENCH.require_found(MUTANTS) == IDS


@pytest.mark.exhaustive("the whole suite on an image in the emulator")
def test_the_last_published_firmware_fails_what_it_never_did():
    """Gains, speeds above 150 rpm, units, orders, position, STATUS, lost link; it drives as well as any other."""
    report = BENCH.check(images={"documented": "rover-g2"})
    failed = {one.id for one in report.clauses if one.verdict is Verdict.FAIL}
    assert failed == {"R07", "R08", "R09", "R14", *(f"R{number}" for number in range(16, 25)), "R27"}
    assert {one.verdict for one in report.clauses} == {Verdict.PASS, Verdict.FAIL}


def test_every_clause_has_a_case_and_something_wrong_that_fails_it():
    BENCH.require_complete(mutant[0] for mutant in MUTANTS)


def test_on_another_bench_it_does_not_apply(capsys):
    assert main(["check", "rover-model", "--suite", "rover-motion"]) == ExitCode.INCONCLUSIVE
    assert "nothing that was selected applies" in capsys.readouterr().out


@pytest.fixture(scope="module")
def report():
    return BENCH.check()


@pytest.mark.exhaustive("the whole suite in the emulator; the gate has its short cases")
class TestAll:
    def test_every_clause_passes(self, report):
        BENCH.require_all_right(report)

    def test_it_takes_as_long_as_it_says(self, report, require_declared_times):
        require_declared_times(report.clauses, BENCH.cases())

    def test_equal_runs_have_equal_hashes(self, report):
        BENCH.require_same_hashes(report, "R05 or R14 or R24")
