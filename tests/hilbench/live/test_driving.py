"""Who drives: the demo driver, then a hand as long as it holds on; on a clock that never waits."""

from __future__ import annotations

import itertools
import math
import os
import tty

import pytest

from hilbench.bench import Bench
from hilbench.clock import Scheduler
from hilbench.commands.live import in_scene
from hilbench.driving.control import RequestError
from hilbench.driving.driver import DEAD_MAN_NS, DEMO, Driver
from hilbench.errors import UnavailableError, UsageError
from hilbench.journal import Journal
from hilbench.live.actions import Actions
from hilbench.live.folders import Session
from hilbench.live.scenes import scene_for
from hilbench.live.session import LiveBench, LiveOptions
from hilbench.mcu.command_line import open_target
from hilbench.systems.rover.system import ROVER_ROOM
from hilbench.systems.vehicle.system import TRACK
from hilbench.terminal import arguments
from hilbench.testing import FakeHostClock
from hilbench.tui.model.bench import BenchModel
from hilbench.tui.views.status import strip_view
from protocols import pkt
from tests.each import each


@pytest.fixture
def live(tmp_path):
    """Make live benches whose time is the test's."""
    made = []

    def make(bench, *, scene=None, demo=True):
        folder = tmp_path / str(len(made))
        folder.mkdir()
        one = LiveBench(in_scene(open_target(bench), scene), LiveOptions(session=Session(folder), demo=demo))
        one.bench.scheduler.lock(FakeHostClock())
        made.append(one)
        return one

    yield make
    for one in made:
        one.close()


def told(live, kind):
    return [event for event in live.bench.journal.recent if event["kind"] == kind]


def speeds(live):
    """Return how far the robot went in each tenth of a second, in um."""
    poses = told(live, "pose")
    return [abs(b["x_m"] - a["x_m"]) + abs(b["y_m"] - a["y_m"]) for a, b in itertools.pairwise(poses)]


def test_the_demo_driver_connects_enables_and_drives(live):
    one = live("pioneer-plane")
    one.bench.run_for(2.5)
    assert [event["who"] for event in told(one, "driver")] == [DEMO]
    assert speeds(one)[-1] > 5_000


class Driven:
    """An operator that keeps the ways that it is driven, each once."""

    idle, in_session, pad_turn, circle = False, True, 1.0, (0.5, 1.0)

    def __init__(self, room_ahead_m):
        self.room_ahead_m, self.ways = room_ahead_m, []

    def drive(self, forward, turn):
        if [(forward, turn)] != self.ways[-1:]:
            self.ways.append((forward, turn))

    def tidy(self):
        pass


@each(
    ("room_ahead_m", "ways"),
    [
        (3.0, [(0.5, 1.0), (0.5, -1.0), (0.5, 1.0), (0.5, -1.0)]),
        (0.5, [(0.0, 0.6), (0.0, -0.6), (0.0, 0.6), (0.0, -0.6)]),
        (None, [(0.5, 1.0), (-0.5, -1.0), (0.5, -1.0), (-0.5, 1.0)]),  # each way and back: it sees no walls
    ],
)
def test_the_ways_of_the_demo_driver(room_ahead_m, ways):
    bench, operator = Bench(Scheduler(), Journal()), Driven(room_ahead_m)
    Driver(bench, operator, demo=True)
    bench.run_for(79.0)
    assert operator.ways == ways


def test_nobody_drives_where_no_demo_is_wanted(live):
    one = live("pioneer-plane", demo=False)
    one.bench.run_for(2.0)
    assert told(one, "tx") == []
    one.actions.obey({"do": "connect"})
    one.bench.run_for(2.0)
    assert one.rig.operator.in_session
    assert max(speeds(one)) == 0


def test_a_hand_takes_over_and_its_vehicle_stops_when_it_lets_go(live):
    one = live("pioneer-plane")
    one.bench.run_for(3.0)
    for _ in range(10):
        one.actions.obey({"do": "drive", "forward": 1.0, "turn": 0.0})
        one.bench.run_for(0.2)
    assert speeds(one)[-1] > 20_000
    let_go_ns = one.bench.now_ns - 200_000_000
    one.bench.run_for(4.0)
    assert speeds(one)[-1] == 0
    assert [event["who"] for event in told(one, "driver")] == [DEMO, "user", "dead man"]
    assert 0 <= told(one, "driver")[-1]["ns"] - let_go_ns - DEAD_MAN_NS < 100_000_000
    one.actions.obey({"do": "demo"})
    one.bench.run_for(2.0)
    assert speeds(one)[-1] > 5_000


def test_a_rover_that_lost_its_host_is_driven_again(live):
    one = live("rover-model")
    one.bench.run_for(3.0)
    one.actions.obey({"do": "inject", "kind": "disconnect", "duration_s": 4.0})
    one.bench.run_for(3.5)
    assert told(one, "machine")[-1]
    assert any(event.get("name") == "MotorsMustStop" for event in told(one, "event"))
    one.bench.run_for(3.0)
    commanded = [event for event in told(one, "event") if event.get("name") == "MotorsCommanded"]
    assert commanded[-1]["ns"] > one.bench.now_ns - 600_000_000


@pytest.mark.needs_physics
def test_the_demo_driver_turns_before_a_wall(live):
    one = live("pioneer", scene="corridor")
    one.bench.run_for(8.0)  # straight on it would be at the wall after six
    assert not [event for event in told(one, "event") if event["name"] in {"Stalled", "BumpStopped"}]


@pytest.mark.exhaustive("firmware in a room; the gate drives the model here, and firmware in wiring/test_rover_bench")
@pytest.mark.needs_physics
def test_the_rover_is_shown_on_a_floor_goes_round_on_it_and_is_reset(live):
    one = live("rover", scene=scene_for(open_target("rover")))
    assert one.bench.journal.header["live"]["scene"]["name"] == ROVER_ROOM
    one.bench.run_for(2.0)
    turned = [after["yaw_rad"] - before["yaw_rad"] for before, after in itertools.pairwise(told(one, "pose"))]
    assert sum(turn > 0 for turn in turned) > 0.8 * len(turned)
    assert max(abs(pose["x_m"]) for pose in told(one, "pose")) < 500_000
    one.actions.obey({"do": "reset"})
    one.bench.run_for(0.02)
    assert [event["source"] for event in told(one, "reset")] == ["brain"] * 2


def test_a_stand_in_a_file_of_ones_own_is_meant(tmp_path):
    own = tmp_path / "own.toml"
    ours = open_target("rover")
    images = (ours.path.parent / "../../../../targets").resolve()
    own.write_text(ours.path.read_text().replace("../../../../targets", str(images)))
    assert (scene_for(ours), scene_for(open_target(str(own)))) == (ROVER_ROOM, None)
    assert scene_for(open_target("vehicle")) == TRACK
    assert scene_for(open_target("pioneer")) == "room-with-boxes"
    others = ("pioneer-plane", "rover-model", "vehicle-model", "bluepill")
    assert {scene_for(open_target(name)) for name in others} == {None}


def test_a_scene_needs_a_world():
    with pytest.raises(UsageError, match="no target of this bench has a world"):
        in_scene(open_target("rover-model"), "corridor")


@pytest.mark.parametrize(
    ("request_", "why"),
    [
        ({"do": "fly"}, "this bench has no 'fly'"),
        ({"do": "drive", "forward": "x", "turn": 0}, "forward is a number from -1 to 1"),
        ({"do": "step", "seconds": 11}, "seconds is a number"),
        ({"do": "speed", "factor": float("nan")}, "factor is a number"),
        ({"do": "mark", "text": "x" * 201}, "at most 200 characters"),
        ({"do": "send", "data": "0"}, "data is bytes in hex"),
        ({"do": "send", "data": ""}, "data has 1 to 4096 bytes"),
        ({"do": "send", "data": "00", "line": "none"}, "no line 'none': host"),
    ],
)
def test_what_cannot_be_done_is_refused(live, request_, why):
    actions: Actions = live("rover-model").actions
    with pytest.raises(RequestError, match=why):
        actions.obey(request_)


def test_a_message_of_ones_own_goes_out_on_the_line_and_into_the_journal(live):
    one = live("rover-model", demo=False)
    one.bench.run_for(0.1)
    frame = pkt.encode_frame(pkt.encode_command(pkt.LedOn()))
    one.actions.obey({"do": "send", "data": frame.hex()})
    one.bench.run_for(0.1)
    answer = pkt.encode_report(pkt.ExecutionReport(opcode=1)).hex()
    assert ("station", frame.hex()) in [(event["source"], event["data"]) for event in told(one, "tx")]
    assert [event for event in told(one, "rx") if answer in event["data"]]


def test_only_serial_ports_are_attached_to(tmp_path):
    def attach(bench, *targets):
        choices = [arguments.target_choice(target) for target in targets]
        LiveBench(open_target(bench), LiveOptions(session=Session(tmp_path), targets=choices))

    with pytest.raises(UsageError, match="--target pioneer: is no serial port"):
        attach("pioneer-plane", "pioneer")
    with pytest.raises(UnavailableError, match="none"):
        attach("rover-model", f"serial:{tmp_path}/none")
    with pytest.raises(UsageError, match=r"one line, without a name.*write --target serial:a"):
        attach("rover-model", "serial:a", "serial:b")
    with pytest.raises(UsageError, match=r"one line, without a name.*write --target serial:a"):
        attach("pioneer-plane", "client=serial:a")
    with pytest.raises(
        UsageError, match="bench 'bluepill': no client of ours speaks to its boards; leave out --target"
    ):
        attach("bluepill", f"serial:{tmp_path}/none")


@pytest.mark.parametrize("attached", [True, False])
def test_how_late_the_host_was_is_recorded_of_what_is_real_alone(tmp_path, attached):
    master, slave = os.openpty()
    tty.setraw(slave)
    port = (arguments.target_choice(f"serial:{os.ttyname(slave)}"),)
    one = LiveBench(
        open_target("rover-model"), LiveOptions(session=Session(tmp_path), targets=port if attached else ())
    )
    host = FakeHostClock()
    host.stall(host.host_ns + 250_000_000, 30_000_000)
    one.bench.scheduler.lock(host)
    one.bench.run_for(2.0)
    said = [event["uncertainty_s"] for event in told(one, "host-lateness")]
    assert said == ([pytest.approx(0.03, rel=1 / 8)] if attached else [])
    one.close()
    os.close(master)
    os.close(slave)


@pytest.mark.needs_physics
def test_a_board_that_no_client_drives_is_shown_all_the_same(live):
    one = live("bluepill-robot")
    one.bench.run_for(0.3)
    assert one.driver is None
    assert "drive" not in one.actions.names
    assert one.bench.journal.header["live"]["machines"].keys() == {"robot"}
    assert told(one, "pose")


@pytest.mark.needs_physics
def test_a_board_is_given_a_stimulus(live):
    one = live("bluepill-robot")
    one.bench.run_for(0.1)
    one.actions.obey({"do": "stimulate", "text": "50ms:reset=press"})
    one.bench.run_for(0.1)
    assert [event["ns"] for event in told(one, "stimulus")] == [150_000_000]
    assert told(one, "reset")[-1]["reason"] == "PIN"
    with pytest.raises(ValueError, match="no stimulus"):
        one.actions.obey({"do": "stimulate", "text": "PA0"})
    assert "no stimulus" in told(one, "refused")[-1]["cause"]


def test_a_game_pad_turns_as_fast_as_the_one_of_the_original(live):
    one = live("pioneer-plane", demo=False)
    one.actions.obey({"do": "connect"})
    one.bench.run_for(2.0)
    for pad, mrad_s in ((False, 1047), (True, 1700)):
        for _ in range(15):
            one.actions.obey({"do": "drive", "forward": 0.0, "turn": 1.0, "pad": pad})
            one.bench.run_for(0.2)
        before, after = told(one, "pose")[-2:]
        turned = math.remainder((after["yaw_rad"] - before["yaw_rad"]) / 1e6, math.tau)
        assert turned * 1e4 == pytest.approx(mrad_s, abs=60)


def test_who_comes_late_is_told_what_stands(live):
    one = live("rover-model")
    one.bench.run_for(2.0)
    one.actions.obey({"do": "inject", "kind": "noise", "probability": 0.5, "count": 2})
    one.actions.obey({"do": "inject", "kind": "drop", "probability": 1e-6, "towards": "operator"})
    one.actions.obey({"do": "inject", "kind": "disconnect", "duration_s": 0.5})
    one.actions.obey({"do": "speed", "factor": 2.0})
    one.actions.obey({"do": "stop"})
    one.bench.run_for(2.9)  # just before everything is told again
    begins_ns = one.bench.now_ns
    one.bench.run_for(0.5)
    header = one.bench.journal.header
    events = list(one.bench.journal.recent)
    early, late = BenchModel(header), BenchModel(header)
    early.take([*events, {"ns": begins_ns, "kind": "clock", "source": "bench", "paused": False, "speed": 2.0}])
    late.take(event for event in events if event["ns"] > begins_ns)
    assert early.faults
    assert early.armed == ["noise 0.5 towards target", "drop 1e-06 towards station"]  # as those that strike are named
    for what in ("driver", "faults", "armed", "paused", "speed"):
        assert getattr(late, what) == getattr(early, what), what
    assert late.lines["host"].outages == early.lines["host"].outages == 1
    assert {name: (machine.state, machine.since_ns) for name, machine in late.machines.items()} == {
        name: (machine.state, machine.since_ns) for name, machine in early.machines.items()
    }


def test_the_present_pace_is_told_beside_that_of_the_whole_run(live):
    one = live("rover-model")
    one.bench.run_for(3.0)
    one.bench.scheduler.unlock()
    one.bench.scheduler.lock(host := FakeHostClock())
    one.bench.run_for(4.0)
    host.advance(2_000_000_000)
    one.bench.run_for(0.2)
    pace = told(one, "host-pace")[-1]
    assert pace["factor"] == pytest.approx(4.2 / 6.2, abs=0.01)
    assert pace["recent"] == pytest.approx(2.0 / 4.0, abs=0.03)
    one.bench.run_for(3.0)
    assert told(one, "host-pace")[-1]["recent"] == 1.0


@pytest.mark.parametrize(("bench", "who"), [("pioneer-plane", "client"), ("rover-model", "station")])
def test_a_client_that_speaks_when_it_is_time_has_missed_nothing(live, bench, who):
    one = live(bench)
    one.bench.run_for(5.0)
    timers = {}
    for event in told(one, "machine"):
        if event["source"] == who:
            timers |= event.get("timers", {})
    assert timers["KEEPALIVE"]["deadline_ns"] is not None
    assert (timers["KEEPALIVE"]["worst_ns"], timers["KEEPALIVE"]["margin_ns"]) == (None, None)
    heard = timers["SIP" if who == "client" else "REPORTS"]
    assert heard["worst_ns"] > 0
    model = BenchModel(one.bench.journal.header)
    model.take(one.bench.journal.recent)
    assert "KEEPALIVE" not in strip_view(model, 200).plain  # the tightest of those that matter
