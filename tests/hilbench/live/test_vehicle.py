"""A vehicle interface on a live bench: who drives its car, what each side's silence does, what is told of the board."""

from __future__ import annotations

import dataclasses

import msgspec
import pytest

from hilbench.bench import Bench
from hilbench.bench.devices import LinesActor
from hilbench.clock import Scheduler
from hilbench.commands.live import in_scene
from hilbench.driving.control import RequestError
from hilbench.driving.driver import DEAD_MAN_NS
from hilbench.driving.rig import Rig
from hilbench.errors import UsageError
from hilbench.journal import Journal
from hilbench.links import Line, MemoryLink
from hilbench.links.faults import Fault, FaultKind
from hilbench.live.actions import Actions
from hilbench.live.attached import ports_asked
from hilbench.live.folders import Session
from hilbench.live.scenes import scene_for
from hilbench.live.session import LiveBench, LiveOptions
from hilbench.mcu.command_line import open_target
from hilbench.systems.vehicle.board_views import BoardFromOutside, Sight
from hilbench.systems.vehicle.driver import DEMO
from hilbench.systems.vehicle.live import SIMULATOR, STACK, attached_vehicle
from hilbench.systems.vehicle.system import TRACK
from hilbench.terminal import arguments
from hilbench.testing import FakeHostClock
from targets.parts.joystick import CODES, JoystickSettings
from targets.robots.vehicle_interface import SIMULATOR_LINE, STACK_LINE, VehicleInterface, VehicleSettings
from tests.each import each


class Live:
    """A live bench of a vehicle, whose time is the test's."""

    def __init__(self, folder, bench, *, demo=True):
        folder.mkdir()
        bench_file = open_target(bench)
        bench_file = in_scene(bench_file, scene_for(bench_file))
        self.path = folder / "journal.jsonl"
        self.live = LiveBench(bench_file, LiveOptions(session=Session(folder), demo=demo))
        self.live.bench.scheduler.lock(FakeHostClock())
        self.about = self.live.bench.journal.header["live"]
        self.read, self.events = 0, []

    def run(self, seconds):
        self.live.bench.run_for(seconds)
        return self.seen

    def run_until(self, mode, limit_s):
        """Run until the board is in a mode; say whether it got there."""
        return self.live.bench.run_until(lambda: self.mode is mode, limit_s)

    def do(self, name, **more):
        self.live.actions.obey({"do": name, **more})

    def drive(self, forward, turn, seconds):
        for _ in range(round(seconds / 0.2)):
            self.do("drive", forward=forward, turn=turn)
            self.run(0.2)
        return self.seen

    @property
    def seen(self):
        return self.live.rig.views["vehicle"]()

    @property
    def mode(self):
        return self.live.rig.machines["board"].state

    def told(self, kind):
        self.live.bench.journal.flush_step()
        with self.path.open("rb") as journal:
            journal.seek(self.read)
            data = journal.read()
        self.read += len(data)
        self.events += msgspec.json.decode(b"[" + b",".join(data.splitlines()) + b"]")
        return [event for event in self.events if event["kind"] == kind]

    def who(self):
        return [event["who"] for event in self.told("driver")]


@pytest.fixture
def vehicle(tmp_path):
    made = []

    def make(bench="vehicle-model", **more):
        made.append(Live(tmp_path / str(len(made)), bench, **more))
        return made[-1]

    yield make
    for one in made:
        one.live.close()


@pytest.fixture
def begun(vehicle):
    """A car that the driving stack has begun to drive."""
    one = vehicle()
    one.run(0.3)
    assert one.mode is Sight.AUTOWARE
    return one


@pytest.fixture
def driving(vehicle):
    """A car that the driving stack has brought to 2 m/s."""
    one = vehicle()
    seen = one.run(1.6)
    assert seen["speed_m_s"] > 1.8
    return one


def test_the_driving_stack_drives_along_the_track_until_somebody_takes_over(driving):
    assert (driving.mode, driving.seen["reported"], driving.seen["lights"]) == (
        Sight.AUTOWARE, "AUTONOMOUS", ["amber"],
    )  # fmt: skip
    seen = driving.drive(0.5, 0.4, 1.0)
    assert (driving.mode, seen["lights"]) == (Sight.MANUAL, ["green"])
    assert seen["stick"] == [-0.12, 0.5]
    assert seen["tyre_rad"] > 0.05  # to the left
    assert driving.who() == ["nobody", DEMO, "user"]
    assert [event["kind"] for event in driving.told("press")] == ["press"]


def test_a_hand_that_lets_go_brakes_until_the_car_stands(driving):
    driving.drive(0.5, 0.0, 0.6)
    let_go_ns = driving.live.bench.now_ns - 200_000_000
    assert driving.run(0.7)["stick"] == [0.0, -1.0]
    released = driving.told("driver")[-1]
    assert released["who"] == "dead man"
    assert 0 <= released["ns"] - let_go_ns - DEAD_MAN_NS < 100_000_000
    seen = driving.run(2.0)
    assert seen["speed_m_s"] < 0.05
    assert seen["stick"] == [0.0, 0.0]


def test_stop_stops_whoever_rules(driving):
    driving.do("stop")
    seen = driving.run(1.5)
    assert (seen["speed_m_s"], driving.mode) == (0.0, Sight.AUTOWARE)
    assert driving.run(0.3)["speed_m_s"] == 0.0
    driving.do("demo")
    assert driving.run(0.6)["speed_m_s"] > 0.5


def test_the_modes_are_asked_for_and_the_answers_told(driving):
    driving.do("mode", mode="MANUAL")
    driving.run(3.5)
    assert driving.mode is Sight.MANUAL
    assert driving.seen["speed_m_s"] < 0.05
    driving.do("mode", mode="AUTOWARE")
    assert driving.run(0.5)["reported"] == "AUTONOMOUS"
    assert [(event["mode"], event["said"]) for event in driving.told("answer")] == [
        ("MANUAL", "granted"), ("AUTOWARE", "granted"),
    ]  # fmt: skip


def test_the_switch_toggles_and_the_board_debounces_it(driving):
    driving.do("press")
    driving.run(0.3)
    driving.do("press")
    assert driving.run(0.3)["reported"] == "MANUAL"
    ignored = [event for event in driving.told("event") if event["name"] == "PressIgnored"]
    assert [event["value"]["reason"] for event in ignored] == ["TOO_EARLY"]


@pytest.mark.exhaustive("the suites lose the simulator; the gate pauses the driving stack here")
def test_a_simulator_that_is_paused_is_an_emergency_and_its_return_ends_it_in_manual(driving):
    driving.do("simulator", on=False)
    assert driving.run(0.9)["reported"] == "AUTONOMOUS"
    seen = driving.run(1.6)
    assert (driving.mode, seen["lights"], seen["simulator_on"]) == (Sight.EMERGENCY, ["red"], False)
    assert seen["speed_m_s"] < 0.05
    driving.do("mode", mode="AUTOWARE")
    driving.run(0.5)
    assert driving.told("answer")[-1]["said"] == "refused"
    driving.do("simulator", on=True)
    driving.run(0.5)
    assert driving.mode is Sight.MANUAL
    assert driving.run_until(Sight.AUTOWARE, 3.0)  # the demo driver asks again


def test_a_driving_stack_that_is_paused_leaves_the_car_to_the_joystick(begun):
    begun.do("stack", on=False)
    assert begun.run(2.0)["reported"] == "MANUAL"
    assert begun.live.rig.machines["stack"].state.name == "CLOSED"
    with pytest.raises(RequestError, match="the driving stack is paused"):
        begun.do("mode", mode="AUTOWARE")
    begun.do("stack", on=True)
    assert begun.run_until(Sight.AUTOWARE, 4.5)


def test_a_driving_stack_whose_line_was_cut_speaks_up_again(begun):
    begun.do("inject", kind="disconnect", duration_s=0.5, line="stack")
    begun.run(0.4)
    changes = [event["value"]["trigger"] for event in begun.told("event") if event["name"] == "StateChanged"]
    assert "LINE_DOWN" in changes
    stack = begun.live.rig.machines["stack"]
    assert begun.live.bench.run_until(lambda: stack.state.name == "HEARD", 2.0)
    assert begun.run_until(Sight.AUTOWARE, 4.0)


def test_faults_go_onto_the_line_that_is_named(begun):
    begun.do("inject", kind="noise", probability=0.5, count=2, line="simulator")
    begun.run(0.5)
    assert {event["towards"] for event in begun.told("fault")} == {"board"}
    board = begun.live.rig.machines["board"]
    assert board.counters.noise + board.counters.bad_letters > 0
    with pytest.raises(RequestError, match="no line 'host': simulator, stack"):
        begun.do("inject", kind="noise", line="host")


def test_lamps_are_asked_for_through_the_board(begun):
    lit = set()
    begun.do("lamps", which="left")
    for _ in range(8):
        lit.add(tuple(begun.run(0.1)["lamps"]))
    assert lit == {(True, False), (False, False)}
    begun.do("lamps", which="hazard")
    lit = {tuple(begun.run(0.1)["lamps"]) for _ in range(8)}
    assert lit == {(True, True), (False, False)}


def test_a_car_without_reverse_gear_is_put_back_to_where_it_began(driving):
    driving.do("restart")
    driving.run(0.2)
    pose = driving.told("pose")[-1]
    assert abs(pose["x_m"]) < 100_000
    assert driving.run(0.6)["speed_m_s"] > 0.5


REFUSED = {
    "mode is AUTOWARE or MANUAL": {"do": "mode", "mode": "EMERGENCY"},
    "on is true or false": {"do": "stack"},
    "which is one of off, left, right, hazard": {"do": "lamps", "which": "all"},
    "this bench has no 'connect'": {"do": "connect"},
}


def test_what_cannot_be_done_is_refused(vehicle):
    actions = vehicle().live.actions
    for why, request in REFUSED.items():
        with pytest.raises(RequestError, match=why):
            actions.obey(request)
    with pytest.raises(RequestError, match="on is true or false"):
        actions.obey({"do": "simulator", "on": 1})


@pytest.mark.slow("the emulated board, with its client of DDS-XRCE: four seconds of a drive")
def test_a_board_with_micro_ros_is_driven_through_an_agent(vehicle):
    one = vehicle("vehicle-micro-ros")
    assert one.run_until(Sight.AUTOWARE, 2.0)
    one.run(2.0)
    assert one.seen["reported"] == "AUTONOMOUS"
    assert one.seen["speed_m_s"] > 0.2
    assert one.live.rig.about["speakers"]["stack"]["protocol"] == "xrce"
    one.do("stack", on=False)
    one.run(1.6)
    assert one.mode is not Sight.AUTOWARE


@each("bench", ["vehicle", "vehicle-model"])
@each(
    ("targets", "why"),
    [
        (["serial:/dev/ttyUSB0"], r"does not say which line.*write --target simulator=... --target stack=..."),
        (["stack=serial:/dev/ttyUSB0"], "nothing at the line 'simulator'"),
        (["stack=serial:/dev/ttyUSB0", "simulator=serial:/dev/ttyUSB0"], "two lines at one port"),
    ],
)
def test_each_of_two_lines_has_a_port(bench, targets, why):
    with pytest.raises(UsageError, match=why):
        ports_asked(open_target(bench), [arguments.target_choice(target) for target in targets])


@pytest.fixture
def at_ports():
    """A board that somebody else runs at the far ends of two lines, and what attaches to it."""
    bench = Bench(Scheduler(), Journal())
    links = {name: MemoryLink(bench.scheduler, Line(baud=921_600), name=name) for name in (SIMULATOR, STACK)}
    board = VehicleInterface(VehicleSettings())
    LinesActor(bench, board, {SIMULATOR_LINE: links[SIMULATOR].b, STACK_LINE: links[STACK].b}, name="foreign")
    vehicle, world = attached_vehicle(bench, {name: link.a for name, link in links.items()}, seed=0)
    driver = vehicle.drive(False)
    yield bench, board, vehicle, driver
    world.close()


@pytest.mark.exhaustive("as the model is, which is in the gate")
def test_a_board_at_two_ports_is_driven_by_the_stack_once_it_is_asked_for(at_ports):
    bench, board, vehicle, driver = at_ports
    bench.run_for(1.5)
    assert vehicle.machines["board"].state is Sight.AUTOWARE
    assert vehicle.look()["speed_m_s"] == 0.0  # nobody drives unasked
    driver.commands["mode"]({"mode": "AUTOWARE"})
    bench.run_for(2.0)
    seen = vehicle.look()
    assert seen["speed_m_s"] > 1.0
    assert (seen["lights"], seen["lamps"], seen["stick"]) == (None, None, None)
    board.press(bench.now_ns)  # by whoever stands beside it
    bench.run_for(3.5)
    assert vehicle.machines["board"].state is Sight.MANUAL  # and he is not asked again
    driver.commands["mode"]({"mode": "AUTOWARE"})
    bench.run_for(0.5)
    driver.stop()
    bench.run_for(1.5)
    assert vehicle.look()["speed_m_s"] == 0.0


def test_what_is_sent_on_a_line_that_is_down_feeds_no_watchdog(at_ports):
    bench, _, vehicle, driver = at_ports
    driver.commands["mode"]({"mode": "AUTOWARE"})
    bench.run_for(1.0)
    before = dataclasses.replace(vehicle.machines["board"].counters)
    for tap in vehicle.taps.values():
        tap.inject(Fault(kind=FaultKind.DISCONNECT, at_s=0.0, duration_s=5.0))
    bench.run_for(2.0)
    board = vehicle.machines["board"]
    assert board.counters == before
    assert max(board.deadlines.values()) < bench.now_ns


def test_a_joystick_in_somebody_elses_hand_is_not_offered(at_ports):
    bench, _, vehicle, driver = at_ports
    actions = Actions(bench, Rig(taps=vehicle.taps, operator=None, machines={}, demo=False), driver)
    assert {"drive", "press", "demo"}.isdisjoint(actions.names)
    assert {"stop", "mode", "stack", "simulator", "lamps", "restart", "inject"} <= set(actions.names)


def test_nobody_drives_where_no_demo_is_wanted(vehicle):
    one = vehicle(demo=False)
    assert one.run(1.5)["speed_m_s"] == 0.0
    assert one.who() == ["nobody"]


def test_the_margins_of_the_board_are_told(begun):
    begun.run(1.0)
    timers = next(
        event["timers"] for event in reversed(begun.told("machine")) if event["source"] == "board" and "timers" in event
    )
    command, status = timers["COMMAND"], timers["STATUS"]
    assert (command["span_ns"], status["span_ns"]) == (110_000_000, 100_000_000)
    assert 70_000_000 < command["worst_ns"] <= command["margin_ns"] < 110_000_000  # commands come every 33 ms
    assert 40_000_000 < status["worst_ns"] <= status["margin_ns"] < 100_000_000  # statuses every 50 ms
    begun.do("simulator", on=False)
    begun.run(0.85)
    misses = next(event["misses"] for event in reversed(begun.told("machine")) if "misses" in event)
    assert misses["STATUS"][0] >= 7
    assert misses["STATUS"][1] == 10


def test_the_header_says_who_speaks_what_where_and_what_the_machines_are(vehicle):
    about = vehicle().about
    assert about["speakers"] == {
        "car": {"protocol": "carla", "line": "simulator"},
        "stack": {"protocol": "autoware", "line": "stack"},
    }
    assert list(about["machines"]) == ["board", "car", "stack", "board link", "task"]
    assert about["machines"]["board"]["states"]["EMERGENCY"] == "the car is stopped"
    assert about["lane"]["closed"]
    assert (about["vehicle"], about["physics"]) == ("car", "plane")


@pytest.mark.needs_physics
@pytest.mark.exhaustive("the gate drives the model of the board, and a rover that is firmware; here are both")
def test_firmware_on_a_board_is_seen_from_outside_and_driven(vehicle):
    assert scene_for(open_target("vehicle")) == TRACK
    one = vehicle("vehicle")
    assert one.about["scene"]["name"] == TRACK
    assert one.about["machines"]["board"]["seen"] == "from its frames"
    assert "task" not in one.about["machines"]
    assert one.run(1.5)["speed_m_s"] > 0.5
    assert (one.mode, one.seen["lights"]) == (Sight.AUTOWARE, ["amber"])
    one.drive(0.5, 0.0, 0.4)
    assert (one.mode, one.seen["lights"]) == (Sight.MANUAL, ["green"])
    wipers = one.told("volts")[-1]["pins"]
    moved = [event["value"] for event in one.told("event") if event["name"] == "JoystickMoved"][-1]
    for pin, axis, place in zip(("PF12", "PF11"), JoystickSettings().axes, (moved["x"], moved["y"]), strict=True):
        assert wipers[f"brain.{pin}"] == [pytest.approx(axis.code(place) / CODES * 3.3, abs=1e-4), 3.3]
    changes = [event["value"] for event in one.told("event") if event["name"] == "ModeSeen"]
    assert [(change["old"], change["new"]) for change in changes] == [("NO_FRAME", "AUTOWARE"), ("AUTOWARE", "MANUAL")]


class Clock:
    """The bench as `BoardFromOutside` needs it."""

    def __init__(self):
        self.now_ns = 0
        self.events = []

    def record_event(self, source, event):
        self.events.append(event)


def test_from_outside_a_board_has_the_mode_of_its_frames_and_deadlines_that_count_from_what_it_was_sent():
    clock = Clock()
    board = BoardFromOutside(clock)
    board.command_sent()
    assert (board.state, board.deadlines) == (Sight.NO_FRAME, {})
    board.frame(None)
    assert board.state is Sight.NO_FRAME
    board.frame(1)
    board.status_sent()
    due = {owed.name: ns // 1_000_000 for owed, ns in board.deadlines.items()}
    assert due == {"COMMAND": 110, "COMMANDS_LOST": 1100, "STATUS": 100, "STATUS_LOST": 1000}
    board.frame(4)
    due = {owed.name: ns // 1_000_000 for owed, ns in board.deadlines.items()}
    assert due == {"STATUS": 100, "STATUS_LOST": 1600}
    board.frame(0)
    board.frame(0)
    assert board.deadlines == {}
    assert (board.counters.frames_emergency, board.counters.emergencies) == (2, 1)
    assert [event.new for event in clock.events] == [Sight.AUTOWARE, Sight.MANUAL, Sight.EMERGENCY]
    assert sum(board.visits.values()) == 3
