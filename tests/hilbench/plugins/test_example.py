"""The example of a protocol that hilbench does not know: everything that knows protocols knows it, too."""

from __future__ import annotations

from pathlib import Path

import pytest

from hilbench.bench import Bench
from hilbench.bench.state_reporter import StateReporter
from hilbench.benchfile.reader import open_bench
from hilbench.clock import Scheduler
from hilbench.driving import real_port
from hilbench.journal import Journal
from hilbench.links import Line, MemoryLink
from hilbench.live.attached import open_attached
from hilbench.live.rigs import open_rig
from hilbench.recordings.piecewise import open_pieces
from hilbench.terminal.options import TargetChoice
from hilbench.tui.model.bench import BenchModel
from hilbench.tui.model.replay import Replay
from tests.share import few

ROOT = Path(__file__).parents[3]
TANK = ROOT / "examples" / "tank"
MODEL, BOARD = TANK / "model.toml", TANK / "board.toml"


@pytest.fixture(autouse=True)
def installed(example):
    """Install the example."""
    example(TANK)


RULES = [f"TANK{number}" for number in range(1, 6)]


def test_protocol_rules_and_model_are_as_short_as_the_page_says():
    files = ("__init__.py", "frames.py", "node.py", "plugin.py")
    assert sum(len((TANK / "tank" / name).read_text().splitlines()) for name in files) <= 150


@pytest.mark.parametrize("bench", [MODEL, BOARD], ids=["model", "board"])
def test_model_and_firmware_keep_its_rules(verdicts, hilbench, bench):
    assert verdicts(bench) == (0, dict.fromkeys(RULES, "pass"))
    assert hilbench("validate", bench)[0] == 0


def wrong_answer(monkeypatch, node):
    monkeypatch.setattr(node, "Level", lambda level, percent, tripped: node.Refused(1))


def wrong_valve(monkeypatch, node):
    monkeypatch.setattr(node.Node, "fire", lambda self, trigger: None)


def carries_out_everything(monkeypatch, node):
    monkeypatch.setattr(node, "Refused", lambda command: node.Read())


def believes_every_crc(monkeypatch, node):
    def look(held):
        size = held[0] + 3
        return node.look(held) if len(held) < size else frames.Frame(held[:size], held[1 : size - 2])

    from protocols.common import framing as frames

    monkeypatch.setattr(node, "ScanningReader", lambda _, gap_ns: frames.ScanningReader(look, gap_ns))


def late_watchdog(monkeypatch, node):
    monkeypatch.setattr(node, "WATCHDOG_S", 1.2)


def early_watchdog(monkeypatch, node):
    monkeypatch.setattr(node, "WATCHDOG_S", 0.9)


@pytest.mark.parametrize(
    ("defect", "rule"),
    [
        (wrong_answer, "TANK1"),
        (wrong_valve, "TANK2"),
        (carries_out_everything, "TANK3"),
        (believes_every_crc, "TANK4"),
        (late_watchdog, "TANK5"),
        (early_watchdog, "TANK5"),
    ],
)
def test_each_rule_finds_what_breaks_it(verdicts, monkeypatch, defect, rule):
    import tank.node

    defect(monkeypatch, tank.node)
    code, found = verdicts(MODEL)
    assert code == 1
    assert found[rule] == "fail"


def test_a_recording_of_it_is_judged_decoded_and_exported(verdicts, hilbench, tmp_path):
    journal = tmp_path / "run.jsonl"
    verdicts(MODEL, "--journal", journal)
    assert verdicts("--target", f"capture:{journal}") == (0, {"TANK1": "pass"})
    code, out, _ = hilbench("decode", "tank", journal)
    assert code == 1  # the checker sent what makes no sense
    assert "Level level_mm=850 percent=40 tripped=False" in out
    code, out, err = hilbench("export", journal, "--mcap", tmp_path / "run.mcap")
    assert code == 0
    assert "with the frames of tank" in out + err
    assert hilbench("replay", journal, "--into", MODEL)[0] == 0
    code, _, err = hilbench("replay", journal, "--into", f"serial:{tmp_path / 'port'}")
    assert code == 2
    assert "its record names no replay_bench; --into BENCH plays it to a model of its own" in err


def test_a_silent_node_is_found_in_a_recording(verdicts, tmp_path):
    journal = tmp_path / "run.jsonl"
    verdicts(MODEL, "--journal", journal)
    lines = journal.read_text().splitlines()
    case = next(number for number, line in enumerate(lines) if "a_wrong_crc" in line)
    level = next(line for line in lines[case:] if '"rx"' in line and '"0581' in line)
    kept = [*lines[:case], *(line for line in lines[case:] if line != level)]
    journal.write_text("\n".join(kept) + "\n")
    assert verdicts("--target", f"capture:{journal}")[1] == {"TANK1": "fail"}


def test_an_answer_as_late_as_its_recording_may_be_wrong_by_is_neither_passed_nor_failed(verdicts, tmp_path):
    from tank.frames import Level, Read, encode

    for after_ms, code, verdict in ((45, 0, "pass"), (51, 4, "inconclusive"), (60, 1, "fail")):
        journal = Journal(tmp_path / f"{after_ms}.jsonl", {})
        journal.record("tx", "client", 0, data=encode(Read()))
        journal.record("tx", "server", after_ms * 1_000_000, data=encode(Level(1, 0, False)))
        journal.record("note", "desk", 1_000_000_000, text="the end")
        journal.close()
        found = verdicts("--target", f"capture:{tmp_path / f'{after_ms}.jsonl'}")
        assert found == (code, {"TANK1": verdict}), after_ms


@pytest.mark.parametrize("bench", few([MODEL, BOARD], 1, "the gate has the model"), ids=["model", "board"])
def test_the_dashboard_shows_its_frames_states_and_watchdogs(tmp_path, bench):
    journal = tmp_path / "live.jsonl"
    made = Bench(Scheduler(), Journal())
    rig = open_rig(made, open_bench(str(bench)), seed=0)
    made.journal = Journal(journal, {"live": dict(rig.about)})
    reporter = StateReporter(made, rig.machines, rig.taps, senses=rig.senses, views=rig.views)
    reporter.after += [tap.flush for tap in rig.taps.values()]
    made.run_for(9.0)
    rig.close()
    made.journal.close(made.now_ns)
    replay = Replay(open_pieces(journal))
    replay.work()
    model = replay.model
    assert isinstance(model, BenchModel)
    assert {frame.item.name for frame in model.frames.frames} == {"Read", "SetValve", "Level"}
    assert model.machines["client"].state == "ASKING"
    if bench is MODEL:
        assert model.machines["device"].state == "OPEN"
        assert "WATCHDOG" in model.machines["device"].timers
    replay.go_to(2_000_000_000)
    replay.work()
    assert {frame.item.name for frame in replay.model.frames.frames} == {"Read", "Level"}


def test_the_dashboard_sends_nothing_to_a_real_node(monkeypatch):
    made = Bench(Scheduler(), Journal())
    link = MemoryLink(made.scheduler, Line(baud=115200), name="host")
    heard = bytearray()
    link.b.on_receive = lambda data, _at_ns: heard.extend(data)
    monkeypatch.setattr(real_port, "open_at", lambda *_: link.a)
    rig = open_attached(made, open_bench(str(MODEL)), [TargetChoice(spec="serial:/dev/nothing")], seed=0)
    made.run_for(9.0)
    assert not heard
    assert rig.about["protocol"] == "tank"
    link.b.write(b"\x05\x81")
    made.run_for(0.1)
    assert link.a.counters.received == 2


def test_a_node_is_served_at_its_rate_or_another():
    from hilbench.serving.served_model import served_target

    served = served_target(open_bench(str(MODEL)))
    assert (dict(served.lines), served.source) == ({"host": 115200}, "device")
    assert dict(served_target(open_bench(str(MODEL)), baud=9600).lines) == {"host": 9600}


def test_it_is_refused_where_it_does_not_belong(hilbench, tmp_path):
    for words, said in (
        ((MODEL, "--suite", "pkt-board"), "is a suite of PKT!, which this bench does not speak"),
        ((MODEL, "--target", "listen:tcp:0"), "a client that comes cannot be the target"),
        ((MODEL, "--target", "nod=serial:/dev/null"), "no target 'nod'; did you mean 'node'?"),
    ):
        code, out, err = hilbench("check", *words)
        assert (code, out, err.count("\n")) == (2, "", 1)
        assert said in err
