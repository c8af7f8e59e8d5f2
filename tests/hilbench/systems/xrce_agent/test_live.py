"""What stands on a live bench of the agent: a board of ours as its client, or our agent at a port."""

from __future__ import annotations

from hilbench.bench import Bench
from hilbench.bench.devices import DeviceActor
from hilbench.benchfile.reader import open_bench
from hilbench.clock import Scheduler
from hilbench.journal import Journal
from hilbench.links import Line, MemoryLink
from hilbench.plugins.discovery import PLUGINS
from hilbench.systems.xrce_agent import live
from hilbench.systems.xrce_agent.board import SpeedBoard
from hilbench.systems.xrce_agent.system import XRCE_AGENT
from protocols import xrce
from protocols.common.decoding import NoOptions

SECOND = 1_000_000_000


def test_a_board_and_the_agent_find_each_other_and_speed_goes_round(tmp_path):
    journal = Journal(tmp_path / "j")
    bench = Bench(Scheduler(), journal)
    rig = XRCE_AGENT.rig(bench, open_bench("xrce-agent"), seed=0)
    bench.run_for(3.0)
    assert {name: machine.state for name, machine in rig.machines.items()} == {
        "client": xrce.ClientState.OPEN,
        "device": xrce.AgentState.OPEN,
    }
    rig.close()
    journal.close(bench.now_ns)
    decoder = PLUGINS.get("xrce", "here").decoder(NoOptions(), "target")
    said = [
        item.name
        for event in Journal.read(tmp_path / "j").events
        if event["kind"] == "tx" and event["source"] == "device"
        for item in decoder.feed(bytes.fromhex(event["data"]))
    ]
    assert said[0] == "StatusAgent"
    assert said.count("StatusReply") == 6
    assert 20 <= said.count("TopicData") <= 30


def test_our_agent_at_a_port_takes_the_board_that_is_there(monkeypatch):
    bench = Bench(Scheduler(), Journal())
    link = MemoryLink(bench.scheduler, Line(baud=115200), name="port")
    board = SpeedBoard(NoOptions())
    DeviceActor(bench, board, link.b, name="board")
    monkeypatch.setattr(live, "open_at", lambda *_: link.a)
    rig = XRCE_AGENT.attached_rig(bench, open_bench("xrce-agent"), {"": "serial:/dev/ttyUSB0"}, seed=0)
    bench.run_for(3.0)
    assert board.observed.state is xrce.ClientState.OPEN
    assert rig.machines["agent"].state is xrce.AgentState.OPEN
    assert rig.machines["agent"].counters.frames_in > 25
    assert board.observed.counters.frames_in > 25
    rig.close()


def test_a_board_whose_agent_is_not_there_asks_again_and_again():
    board, sent = SpeedBoard(NoOptions()), []
    for second in range(40):
        sent += [second] * bool(board.advance(second * SECOND))
    assert len(sent) > 30
    assert {type(event) for event in board.take_events()} == {xrce.StateChanged, xrce.SessionClosed}
