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
    assert [*bench.tables["agent"]()["topics"].rows] == ["/speed"]
    rig.close()


def test_a_board_whose_agent_is_not_there_asks_again_and_again():
    board, sent = SpeedBoard(NoOptions()), []
    for second in range(40):
        sent += [second] * bool(board.advance(second * SECOND))
    assert len(sent) > 30
    assert {type(event) for event in board.take_events()} == {xrce.StateChanged, xrce.SessionClosed}


def test_the_tables_of_an_agent_are_at_its_bench(tmp_path):
    """With a type of one's own, which stands in a folder beside the bench file."""
    share = tmp_path / "share" / "std_msgs" / "msg"
    share.mkdir(parents=True)
    (share / "Float32.msg").write_text("float32 speed_m_s")
    file = tmp_path / "my.toml"
    file.write_text('version = 1\n[targets.agent]\nmodel = "xrce-agent"\nsettings = { types = ["share"] }\n')
    bench = Bench(Scheduler(), Journal())
    rig = XRCE_AGENT.rig(bench, open_bench(str(file)), seed=0)
    bench.tables["device"]()
    bench.run_for(3.0)
    tables = bench.tables["device"]()
    assert {name: [*table.rows] for name, table in tables.items()} == {
        "clients": ["host"],
        "topics": ["/speed"],
        "services": [],
        "actions": [],
    }
    row = tables["topics"].rows["/speed"]
    assert [*row.last] == ["speed_m_s"]
    assert 15 <= row.count <= 30
    assert tables["clients"].rows["host"].count == row.count
    rig.close()


def test_an_agent_at_the_side_of_a_client_has_tables_too():
    bench = Bench(Scheduler(), Journal())
    rig = XRCE_AGENT.rig(bench, open_bench("xrce-client"), seed=0)
    bench.run_for(1.0)
    assert [*bench.tables["client"]()["topics"].rows] == ["/speed"]
    rig.close()
