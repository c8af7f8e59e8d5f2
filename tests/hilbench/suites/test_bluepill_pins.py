"""The suite of the Blue Pill's pins: what is right passes, and each clause has something wrong that fails it."""

from __future__ import annotations

from dataclasses import replace

import pytest

from hilbench.benchfile.bench_file import Net, PinEnd, TerminalEnd
from hilbench.cli import main
from hilbench.exit_codes import ExitCode
from hilbench.systems.bluepill.pins_clauses import CLAUSES
from measure.mutants.alterations import setting, swapped
from measure.mutants.altered_bench import AlteredBench, first_of_each
from targets.firmware import image_path
from targets.parts.p2os_adapter.link import RobotLink

pytestmark = pytest.mark.needs_physics

MINE = {clause.id for clause in CLAUSES} - {"G13"}
BENCH = AlteredBench(bench="bluepill", board="bluepill", suite="bluepill-pins", clause_ids=MINE)
SHORT = (
    "all_sensors_on_wheels or threshold_of_the_simulation or threshold_as_on_the_robot or pins_of_the_encoders or "
    "bit_order_of_the_encoders or bit_order_as_on_the_adapter or majority or no_sensors"
)


def motor(**settings):
    return setting("motor-code", **settings)


def switch(**settings):
    return setting("distance-switch", **settings)


def encoder(**settings):
    return setting("encoder-3bit", **settings)


def adapter(**settings):
    return setting("p2os-adapter", **settings)


def moved(terminal, pin):
    """Solder a terminal to another pin; to none if that is empty."""

    def alter(bench_file):
        nets = [net for net in bench_file.nets if terminal not in map(str, net.terminals)]
        if pin:
            part, _, name = terminal.partition(".")
            nets.append(Net(pins=(PinEnd(board="brain", pin=pin),), terminals=(TerminalEnd(part=part, terminal=name),)))
        return replace(bench_file, nets=tuple(nets))

    return alter


def held(pin, supply):
    """Solder a pin to a supply."""

    def alter(bench_file):
        net = Net(pins=(PinEnd(board="brain", pin=pin),), supplies=frozenset({supply}))
        return replace(bench_file, nets=(*bench_file.nets, net))

    return alter


def signals_swapped(one, other):
    """Show two parts of a kind what the other one is to be shown."""

    def alter(bench_file):
        parts = dict(bench_file.parts)
        parts[one] = replace(parts[one], signals=bench_file.parts[other].signals)
        parts[other] = replace(parts[other], signals=bench_file.parts[one].signals)
        return replace(bench_file, parts=parts)

    return alter


def only_on(part, alter):
    """Make a mistake only on benches with this part."""
    return lambda bench_file: alter(bench_file) if part in bench_file.parts else bench_file


MUTANTS = [
    # clause, cases, what is wrong, programs that run instead; the first of each clause is found soonest
    ("G01", "words_on_wheels", None, {"words": "broken-bit-order"}),
    ("G01", "words_on_the_adapter", adapter(motor_order="msb-first"), {}),
    ("G01", "words_on_wheels", motor(bit_order="msb-first"), {}),
    ("G02", "motion_on_wheels", motor(speed_per_code_m_s=0.055), {}),
    ("G02", "motion_on_the_adapter", adapter(speed_range_mm_s=450), {}),
    ("G03", "a_step_on_the_adapter", None, {"words": "robot-sweep"}),
    ("G03", "a_step_on_wheels", None, {"words": "robot-sweep"}),
    ("G04", "all_codes_on_wheels", swapped("motor_left.comm1", "motor_right.comm1"), {}),
    ("G04", "all_codes_on_the_adapter", adapter(turn_range_mrad_s=400), {}),
    ("G05", "each_sensor_on_wheels", swapped("switch_3.out", "switch_4.out"), {}),
    ("G05", "each_sensor_on_wheels", switch(threshold_m=0.2), {}),
    ("G05", "each_sensor_on_the_adapter", adapter(dd1_forced_low=False), {}),
    ("G05", "each_sensor_on_the_adapter", swapped("adapter.dd3", "adapter.dd4"), {}),
    ("G05", "the_outer_sensors", adapter(dd7_8_driven=False), {}),
    ("G06", "all_sensors_on_wheels", switch(period_ms=30.0), {}),
    ("G06", "all_sensors_on_the_adapter", moved("adapter.dd5", ""), {}),
    ("G07", "threshold_of_the_simulation", switch(profile="robot", threshold_m=0.5), {}),
    ("G07", "threshold_as_on_the_robot", switch(profile="simulation", threshold_m=1.0), {}),
    ("G07", "threshold_of_the_adapter", adapter(distance_threshold_m=0.999), {}),
    ("G07", "threshold_of_the_adapter", adapter(distance_sense="far"), {}),
    ("G08", "reaction_on_wheels", motor(period_ms=400.0), {}),
    ("G08", "reaction_on_the_adapter", None, {"reactive": "robot-sensors"}),
    ("G09", "encoders_forward", encoder(bit_order="msb-first"), {}),
    ("G10", "encoders_backward", encoder(form="truncating"), {}),
    ("G10", "its_own_wheel", signals_swapped("encoder_left", "encoder_right"), {}),
    ("G10", "encoders_backward_as", encoder(form="floor"), {}),
    ("G11", "pins_of_the_encoders", moved("encoder_left.s3", "PB15"), {}),
    ("G12", "bit_order_of_the_encoders", encoder(bit_order="msb-first"), {}),
    ("G12", "bit_order_as_on_the_adapter", encoder(bit_order="lsb-first"), {}),
    ("G12", "bit_order_of_the_adapter", adapter(encoder_order="lsb-first"), {}),
    ("G12", "bit_order_of_a_mended_adapter", adapter(encoder_order="msb-first"), {}),
    ("G14", "sensors_on_both", swapped("adapter.dd3", "adapter.dd4"), {}),
    ("G14", "words_on_both", only_on("adapter", held("PB7", "gnd")), {}),
    ("G15", "the_first_second", adapter(dead_time_s=0.0), {}),
    ("G15", "short_pulses", adapter(connection_sample_ms=2.0), {}),
    ("G16", "majority and PB7", adapter(motor_reads=3), {}),
    ("G17", "is_noticed", adapter(safe_stop_s=None), {}),
    ("G17", "drives_on", adapter(safe_stop_s=2.0), {}),
    ("G18", "kept_alive", adapter(pulse_s=0.6), {}),
    ("G18", "kept_alive", adapter(enable_ms=200.0), {}),
    ("G19", "the_game_pad", adapter(trigger_mm_s=450), {}),
    ("G20", "turning_on_wheels", motor(speed_per_code_m_s=0.05), {}),
    ("G20", "turning_on_the_adapter", adapter(turning="differential"), {}),
    ("G20", "turning_on_a_mended_adapter", adapter(turning="published"), {}),
    ("G21", "ramp_on_wheels", motor(speed_per_code_m_s=0.04), {}),
    ("G21", "ramp_on_the_adapter", adapter(speed_range_mm_s=350), {}),
    ("G22", "the_reset_line", moved("adapter.rst", ""), {}),
    ("G23", "no_sensors", held("PA4", "3v3"), {}),
    ("G23", "motors_without_sensors", motor(period_ms=0.0), {}),
    ("G24", "period", motor(period_ms=90.0), {}),
    ("G24", "period", motor(period_ms=0.0), {}),
    ("G25", "left_inputs", motor(reads="odr"), {}),
    ("G25", "left_inputs_as_published", motor(reads="pins"), {}),
]


def test_what_is_right_passes():
    BENCH.require_right(SHORT)


@pytest.mark.slow("each clause and a mistake that it has to find, in the emulator")
def test_each_clause_finds_what_is_wrong():
    assert BENCH.require_found(first_of_each(MUTANTS), until_found=True) == MINE


@pytest.mark.exhaustive("all mistakes, some for many seconds in the emulator; the gate has one for each clause")
def test_each_clause_finds_everything_that_is_wrong():
    assert BENCH.require_found(MUTANTS) == MINE


def test_an_image_with_the_wrong_order_of_bits_is_found_from_the_command_line(capsys):
    image = image_path("broken-bit-order")
    words = ["check", "bluepill", "--target", f"brain.words=bluepill:{image}", "--suite", "bluepill-pins"]
    assert main([*words, "-k", "words_on_wheels"]) == ExitCode.VIOLATION
    assert "code 3: PB7..5 carry 011, not 110" in capsys.readouterr().out


def test_an_adapter_that_never_lets_the_robot_go_is_found(monkeypatch):
    want = RobotLink.want
    monkeypatch.setattr(RobotLink, "want", lambda link, wanted, now_ns: want(link, True, now_ns) if wanted else None)
    assert BENCH.require_found([("G15", "robot_is_let_go", None, {})]) == {"G15"}


def test_every_clause_has_a_case_and_something_wrong_that_fails_it():
    BENCH.require_complete(mutant[0] for mutant in MUTANTS)


def test_on_another_bench_it_does_not_apply(capsys):
    assert main(["check", "pioneer-plane", "--suite", "bluepill-pins"]) == ExitCode.INCONCLUSIVE
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
        BENCH.require_same_hashes(report, "G05 or G08 or G14 or G22")
