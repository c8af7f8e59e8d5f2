"""The example of a system that hilbench does not know: a head on a bus of servos, which moves in a world."""

from __future__ import annotations

import contextlib
import math
import sys
from pathlib import Path

import pytest

from hilbench.bench import Bench
from hilbench.bench.state_reporter import StateReporter
from hilbench.benchfile.bench_model import World
from hilbench.benchfile.reader import open_bench
from hilbench.cli import COMMANDS
from hilbench.clock import Scheduler
from hilbench.commands import dashboard
from hilbench.journal import Journal
from hilbench.links import Line, MemoryLink
from hilbench.live.rigs import open_rig
from hilbench.mcu.emulated import EmulatedBench
from hilbench.recordings.piecewise import open_pieces
from hilbench.serving.served_model import served_target
from hilbench.tui import bench_process
from hilbench.tui.model.replay import Replay

ROOT = Path(__file__).parents[3]
PANTILT = ROOT / "examples" / "pantilt"
FILE = PANTILT / "pantilt" / "benches" / "pantilt.toml"
RULES = [f"PT{number}" for number in range(1, 10)]


@pytest.fixture(autouse=True)
def installed(example):
    """Install the example."""
    example(PANTILT)


def test_it_is_as_short_as_was_asked_for():
    assert sum(len(file.read_text().splitlines()) for file in PANTILT.rglob("*.py")) <= 500


@pytest.mark.needs_physics
@pytest.mark.slow("a whole suite, with each step of the physics")
def test_the_model_keeps_its_rules_and_a_recording_of_it_is_judged_and_decoded(verdicts, hilbench, tmp_path):
    journal = tmp_path / "run.jsonl"
    assert verdicts("pantilt", "--journal", journal) == (0, dict.fromkeys(RULES, "pass"))
    assert verdicts("--target", f"capture:{journal}") == (0, {"PT1": "pass"})
    code, out, _ = hilbench("decode", "pantilt", journal)
    assert code == 1  # the checker sent what makes no sense
    assert "Status servo=2 angle_cdeg=" in out


@pytest.mark.slow("a whole suite on an emulated board, with a tick each millisecond")
def test_the_firmware_keeps_the_rules_that_need_no_truth(verdicts):
    unknown = dict.fromkeys(("PT2", "PT3", "PT6", "PT9"), "not-applicable")
    assert verdicts("pantilt-board") == (0, {**dict.fromkeys(RULES, "pass"), **unknown})


def test_the_firmware_turns_as_fast_as_a_servo_and_says_so_on_its_pins():
    from pantilt.frames import Goal, Read, Status, Torque, decode, encode, look

    from protocols.common.framing import ScanningReader

    with contextlib.closing(EmulatedBench(open_bench("pantilt-board"), seed=0)) as emulated:
        heard, reader, port = [], ScanningReader(look), emulated.ports["head.usart1"]
        port.on_receive = lambda data, at_ns: heard.extend(map(decode, reader.receive(data, at_ns)))
        emulated.bench.run_for(0.1)
        port.write(encode(Torque(1, True)) + encode(Goal(1, 3000)))
        for seconds in (0.25, 0.35):
            emulated.bench.run_for(seconds)
            port.write(encode(Read(1)))
        emulated.bench.run_for(0.05)
        assert [type(one) for one in heard] == [Status] * 4
        assert [one.angle_cdeg for one in heard] == [0, 0, pytest.approx(1500, abs=10), 3000]
        edges = [one for one in emulated.bench.journal.recent if (one["kind"], one["source"]) == ("pin", "head.PA0")]
        (rise, fall) = edges[-2:] if not edges[-1]["level"] else edges[-3:-1]
        assert fall["ns"] - rise["ns"] == 1_800_000


def stands_still(monkeypatch, head):
    monkeypatch.setattr(head.Servo, "step", lambda self: None)


def says_its_goal(monkeypatch, head):
    right = head.Servo.status

    def status(self):
        return right(self)._replace(angle_cdeg=round(100 * math.degrees(self.goal_rad)))

    monkeypatch.setattr(head.Servo, "status", status)


def goes_anywhere(monkeypatch, head):
    monkeypatch.setattr(head, "LIMITS_DEG", {"pan": 400, "tilt": 400})


def late_watchdog(monkeypatch, head):
    monkeypatch.setattr(head, "WATCHDOG_S", 1.2)


def hears_every_id(monkeypatch, head):
    from pantilt.frames import frame

    right = head.Servo.take

    def take(self, found):
        raw = frame(head.IDS[self.joint], found.payload)
        right(self, type(found)(raw, found.payload))

    monkeypatch.setattr(head.Servo, "take", take)


def says_no_load(monkeypatch, head):
    right = head.Servo.status
    monkeypatch.setattr(head.Servo, "status", lambda self: right(self)._replace(load_percent=0))


@pytest.mark.needs_physics
@pytest.mark.parametrize(
    ("defect", "rule", "cases"),
    [
        (stands_still, "PT2", "a_goal_is_reached"),
        (says_its_goal, "PT3", "where_the_joint_is"),
        (goes_anywhere, "PT4", "beyond_the_limit"),
        (hears_every_id, "PT6", "for_each_other"),
        (late_watchdog, "PT7", "watchdog"),
        (says_no_load, "PT9", "blocked"),
    ],
)
def test_each_rule_finds_what_breaks_it(verdicts, monkeypatch, defect, rule, cases):
    import pantilt.head

    defect(monkeypatch, pantilt.head)
    code, found = verdicts("pantilt", "-k", cases)
    assert (code, found[rule]) == (1, "fail")


@pytest.mark.needs_physics
def test_its_joints_have_signals_for_parts():
    from hilbench.mcu.bare_vehicle import BareVehicle
    from hilbench.plugins.discovery import PLUGINS

    kind = PLUGINS.systems.vehicle("pantilt")
    bench = Bench(Scheduler(), Journal())
    there = BareVehicle(bench, World(vehicle="pantilt"), seed=0)
    signals = kind.wire(there.body, ["pan_angle", "tilt_speed"])
    signals.drive("pan", 0.5)
    signals.drive("tilt", -0.2)
    bench.run_for(1.0)
    assert signals.read() == {"pan_angle": pytest.approx(0.5, abs=0.01), "tilt_speed": pytest.approx(-0.2, abs=1e-3)}
    there.close()


@pytest.mark.needs_physics
def test_the_dashboard_shows_its_frames_states_watchdogs_and_world(tmp_path):
    journal = tmp_path / "live.jsonl"
    made = Bench(Scheduler(), Journal())
    rig = open_rig(made, open_bench("pantilt"), seed=0)
    made.journal = Journal(journal, {"live": dict(rig.about)})
    reporter = StateReporter(made, rig.machines, rig.taps, senses=rig.senses, views=rig.views)
    reporter.after += [tap.flush for tap in rig.taps.values()]
    made.run_for(3.5)
    rig.close()
    made.journal.close(made.now_ns)
    replay = Replay(open_pieces(journal))
    replay.work()
    model = replay.model
    assert {frame.item.name for frame in model.frames.frames} == {"Torque", "Goal", "Read", "Status"}
    assert {name: machine.state for name, machine in model.machines.items()} == {
        "client": "SWEEPING",
        "pan": "HOLDING",
        "tilt": "HOLDING",
    }
    assert "WATCHDOG" in model.machines["pan"].timers
    shown = [line.plain.split() for line in model.dashboard.view(model.seen, 60, 2)]
    assert [(joint, float(angle[:-1])) for joint, _, angle in shown] == [
        (joint, pytest.approx(model.seen[joint], abs=0.06)) for joint in ("pan", "tilt")
    ]
    assert 1 < model.seen["pan"] < 59  # on its way from one place to the next
    assert (model.world.vehicle, model.world.scene, len(model.world.boxes)) == ("pantilt", "desk", 1)
    assert model.world.pose is not None


@pytest.mark.needs_physics
def test_a_head_is_served_in_its_world():
    from pantilt.frames import Goal, Status, Torque, decode, encode, look

    from protocols.common.framing import ScanningReader

    served = served_target(open_bench("pantilt"), scene="empty")
    assert (dict(served.lines), served.source) == ({"host": 115200}, "device")
    bench, heard = Bench(Scheduler(), Journal()), []
    link = MemoryLink(bench.scheduler, Line(baud=115200), name="host")
    reader = ScanningReader(look)
    link.a.on_receive = lambda data, at_ns: heard.extend(map(decode, reader.receive(data, at_ns)))
    close = served.make(bench, {"host": link.b})
    link.a.write(encode(Torque(1, True)) + encode(Goal(1, 2000)))
    bench.run_for(0.9)
    link.a.write(encode(Torque(1, True)))
    bench.run_for(0.1)
    assert [type(one) for one in heard] == [Status] * 3
    assert heard[-1].angle_cdeg == pytest.approx(2000, abs=50)
    close()


def test_its_bench_is_known_by_name_and_validated_by_its_file_without_its_code(hilbench):
    said = "hilbench: pantilt: comes with a plug-in, and none is run here; name the bench file itself\n"
    assert hilbench("validate", "pantilt") == (2, "", said)
    assert hilbench("validate", FILE) == (0, f"{FILE}: ok\n", "")
    assert "pantilt.plugin" not in sys.modules
    assert open_bench("pantilt").path == FILE


def test_its_bench_stands_where_a_command_does(hilbench, monkeypatch):
    monkeypatch.setattr(dashboard, "require_terminal", lambda hint: None)
    monkeypatch.setattr(dashboard, "show", lambda process: process)
    monkeypatch.setattr(bench_process.BenchProcess, "start", lambda words, name: len(words) if name == "pantilt" else 9)
    assert hilbench("pantilt")[0] == 3  # it is started with its name and a seed


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["pantlit"], "unknown command 'pantlit'; did you mean 'pantilt'?"),
        (["check", "pantil"], "pantil: no such bench; did you mean 'pantilt'?"),
        (["serve", "pantlit"], "pantlit: no such bench; did you mean 'pantilt'?"),
        (["validate", "pantil"], "pantil: no such bench; did you mean 'pantilt'?"),
        (["qqq"], f"unknown command 'qqq'; commands: {', '.join(COMMANDS)}"),
    ],
)
def test_a_name_near_that_of_its_bench_is_suggested_without_its_code(hilbench, words, said):
    assert hilbench(*words) == (2, "", f"hilbench: {said}\n")
    assert "pantilt.plugin" not in sys.modules


def test_it_does_not_stand_beside_boards(hilbench, tmp_path):
    image = ROOT / "targets/firmware/images/echo-irq.elf"
    bench = tmp_path / "both.toml"
    bench.write_text(
        f'version = 1\n[targets.head]\nmodel = "pantilt"\n[targets.brain]\nboard = "bluepill"\nfirmware = "{image}"\n'
        '[world]\nvehicle = "pantilt"\n[[links]]\nends = ["peer", "brain.usart1"]\n'
    )
    tmp_path.joinpath("test_it.py").write_text(
        'from hilbench.check import case\n@case("A1", text="a", level="must", source="a")\ndef test_a(peer): pass\n'
    )
    code, _, err = hilbench("check", bench, "--suite", tmp_path / "test_it.py")
    assert code == 2, err
    assert "system 'pantilt' has no model that stands beside boards" in err
