"""What can be seen of a case, kind by kind; and that looking leaves no trace."""

from __future__ import annotations

from hilbench.check.bench_provider import make_provider
from hilbench.judging.provider import CaseInfo, CaseView
from hilbench.terminal.options import CheckOptions
from hilbench.tui.model.frames import FramesModel
from protocols import carla
from tests.each import each


def look(bench, needs, scenario, *, watch=True):
    """Run a scenario on a bench of its own; return its hash and the view."""
    provider = make_provider(CheckOptions(bench=bench))
    info = CaseInfo(id="suite/it", clause_ids=("X",), seed=1, needs=frozenset(needs))
    with provider.open_case(info) as case:
        if watch:
            case.watch()
        scenario(case)
        case.finish("fail", "because")
        view = case.view() if watch else None
        hashed = case.case_hash()
    provider.close()
    return hashed, view


def drive(case):
    case.peer.start()
    case.bench.run_for(0.5)


def call(case):
    case.client.start()
    case.server.expect_session(3.0)


def ask(case):
    case.peer.request()
    case.bench.run_for(0.5)


def wait(case):
    case.bench.run_for(0.5)


BOARD = {"board", "board link", "task"}
KINDS = {
    "robot": ("pioneer-plane", ("server",), drive, {"robot"}, {"host"}, ("checker", "p2os")),
    "client": ("pioneer-plane", ("client",), call, {"client"}, {"host"}, ("server", "p2os")),
    "rover": ("rover-model", ("PKT!", "server"), ask, {"rover"}, {"host"}, ("checker", "pkt")),
    "rover's host": ("rover-model", ("PKT!", "client"), wait, {"station"}, {"host"}, ("rover", "pkt")),
    "vehicle": (
        "vehicle-model",
        ("CARLA", "board"),
        wait,
        {"board", "board link", "task"},
        {"usart2", "usart3"},
        (None, None),
    ),
}


@each("kind", KINDS)
def test_a_view_has_what_there_is_and_leaves_no_trace(kind):
    bench, needs, scenario, machines, lines, spoken = KINDS[kind]
    hashed, view = look(bench, needs, scenario)
    unwatched, _ = look(bench, needs, scenario, watch=False)
    assert hashed == unwatched
    assert isinstance(view, CaseView)
    assert set(view.about["machines"]) == machines
    assert (view.about.get("operator"), view.about.get("protocol")) == spoken
    told = {(event["kind"], event["source"]) for event in view.events}
    assert {("machine", name) for name in machines} | {("link", name) for name in lines} <= told
    assert (view.events[0]["kind"], view.events[-1]["kind"]) == ("case", "link")
    assert [event["verdict"] for event in view.events if event["kind"] == "verdict"] == ["fail"]


def test_a_timer_of_a_view_has_the_margins_of_the_whole_case():
    _, view = look("pioneer-plane", ("server",), drive)
    last = [event for event in view.events if event["kind"] == "machine"][-1]
    assert last["state"] == "OPEN"
    (timer,) = last["timers"].values()
    assert timer["span_ns"] == 2_000_000_000
    assert timer["deadline_ns"] - last["ns"] < timer["span_ns"]


def talk(case):
    case.simulator.write(b"no frame at all")
    case.stack.write(bytes.fromhex("7e0000010081c060"))
    for _ in range(3):
        case.simulator.write(carla.encode_status(carla.StatusFrame()))
        case.bench.run_for(0.1)


def test_of_two_lines_each_has_the_frames_that_were_on_it():
    _, view = look("vehicle-model", ("CARLA", "board", "stack"), talk)
    frames = FramesModel(view.about)
    for event in view.events:
        if event["kind"] in {"tx", "rx"}:
            frames.take(event)
    said = {(frame.line, frame.sent, frame.item.name) for frame in frames.frames}
    assert {("stack", True, "AgentPing"), ("simulator", True, "Status"), ("stack", False, "ControlModeReport")} <= said
    assert {name for line, sent, name in said if line == "simulator" and not sent} <= {"AUTOWARE", "MANUAL"}
    unsound = [(frame.line, frame.sent, frame.item.raw) for frame in frames.frames if not frame.good]
    assert unsound == [("simulator", True, b"no frame at all")]
