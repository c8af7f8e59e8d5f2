"""What a part puts on the analog pins of an emulated board is told by a live bench, and by no other."""

from __future__ import annotations

import pytest

from hilbench.journal import Journal
from hilbench.live.folders import Session
from hilbench.live.session import LiveBench, LiveOptions
from hilbench.mcu.command_line import open_target
from hilbench.mcu.emulated import EmulatedBench
from hilbench.testing import FakeHostClock
from hilbench.tui.model.bench import BenchModel
from targets.firmware import image_path
from targets.parts.joystick import CODES, JoystickSettings

BENCH = """
version = 1
[targets.brain]
board = "bluepill"
firmware = "{firmware}"
timing = "flat"
[parts.stick]
kind = "joystick"
pins = {{ vrx = "brain.PA0", vry = "brain.PA1", sw = "brain.PA2" }}
[parts.stick.settings]
noise_v = {noise_v}
noise_period_ms = 150.0
"""


@pytest.fixture
def bench_file(tmp_path):
    def make(noise_v):
        path = tmp_path / "stick.toml"
        path.write_text(BENCH.format(firmware=image_path("bench-tick-1khz.elf"), noise_v=noise_v))
        return open_target(str(path))

    return make


def told(folder, bench_file, seconds, kinds=("volts",)):
    """Run a live bench on a clock that never waits, and return what it tells, of voltages or of something else."""
    path = folder / "journal.jsonl"
    live = LiveBench(bench_file, LiveOptions(session=Session(folder), journal=path))
    live.bench.scheduler.lock(FakeHostClock())
    live.bench.run_for(seconds)
    live.close()
    return [event for event in Journal.read(path).events if event["kind"] in kinds]


def test_levels_of_pins_are_told_again_for_who_does_not_read_from_the_beginning(tmp_path, bench_file):
    *events, last = told(tmp_path, bench_file(0.0), 5.05, {"pin", "pwm", "standing"})
    assert last["kind"] == "standing"
    levels = {event["source"]: event["level"] for event in events if event["kind"] != "standing"}
    assert levels
    assert {pin: level for pin, (level, _, _) in last["pins"].items()} == levels
    model = BenchModel({})
    model.take([last])
    assert {pin: one.level for pin, one in model.pins.pins.items()} == levels


def test_a_voltage_that_stays_is_told_once(tmp_path, bench_file):
    (event,) = told(tmp_path, bench_file(0.0), 0.35)
    x_v, y_v = (pytest.approx(axis.zero / CODES * 3.3, abs=1e-4) for axis in JoystickSettings().axes)
    assert (event["ns"], event["pins"]) == (0, {"brain.PA0": [x_v, 3.3], "brain.PA1": [y_v, 3.3]})


def test_voltages_that_move_are_told_ten_times_a_second_at_most(tmp_path, bench_file):
    events = told(tmp_path, bench_file(0.1), 0.75)
    assert [event["ns"] // 1_000_000 for event in events] == [0, 200, 300, 500, 600]
    assert len({tuple(event["pins"]["brain.PA0"]) for event in events}) == len(events)


def test_a_bench_that_is_not_live_tells_none(bench_file):
    emulated = EmulatedBench(bench_file(0.1))
    emulated.bench.run_for(0.25)
    emulated.close()
    assert emulated.surroundings.parts.volts()
    assert "volts" not in {event["kind"] for event in emulated.bench.journal.recent}
