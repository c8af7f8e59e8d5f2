"""A live bench as a process: what it tells, what it obeys, and what is left of it when either side dies."""

from __future__ import annotations

import json
import os
import signal
import stat
import subprocess
import sys

import pytest

from hilbench.journal import Journal

pytestmark = pytest.mark.real_time("a bench runs in a process of its own")
PATIENCE_S = 600
OF_FIRMWARE = pytest.mark.exhaustive(
    "test_driving drives the same board on a clock that never waits; here in real time"
)


def is_event(kind, **fields):
    return lambda event: event["kind"] == kind and all(event.get(name) == value for name, value in fields.items())


def test_a_pioneer_is_driven_by_the_demo_and_then_by_hand(live):
    bench = live("pioneer-plane")
    bench.do("speed", factor=8)
    assert stat.S_IMODE(os.stat(bench.session.socket).st_mode) == 0o600
    assert "drive" in bench.session.describe()["actions"]
    bench.wait_for(lambda event: event["kind"] == "pose" and abs(event["x_m"]) > 1000)
    bench.do("drive", forward=-0.5, turn=0.0)
    by_hand = bench.wait_for(is_event("driver", who="user"))
    released = bench.wait_for(is_event("driver", who="dead man"))
    assert released["ns"] - by_hand["ns"] >= 700_000_000
    assert bench.ask("drive", forward=2, turn=0) == {
        "id": 1, "ok": False, "error": "forward is a number from -1 to 1",
    }  # fmt: skip
    assert bench.ask("reset")["error"] == "this bench has no 'reset'"
    bench.do("quit")
    assert bench.process.wait(PATIENCE_S) == 0
    assert Journal.read(bench.session.journal).ended
    assert not bench.session.socket.exists()


def test_bench_time_stands_still_goes_a_step_and_goes_on(rover):
    bench = rover
    bench.do("pause")
    stood_ns = bench.wait_for(is_event("clock", paused=True))["ns"]
    for _ in range(20):
        bench.do("hello")
    assert bench.events()[-1]["ns"] == stood_ns
    steps = [{"id": 1, "do": "step", "seconds": seconds} for seconds in (0.1, 0.1, 0.05)]
    bench.client.sendall(b"".join(json.dumps(step).encode() + b"\n" for step in steps))
    assert [json.loads(bench.answers.readline()) for _ in steps] == [{"id": 1, "ok": True}] * len(steps)
    bench.wait_for(lambda event: event["kind"] == "clock" and event["paused"] and event["ns"] == stood_ns + 250_000_000)
    bench.do("speed", factor=4)
    bench.wait_for(is_event("clock", paused=True, speed=4.0))
    bench.do("resume")
    bench.wait_for(is_event("clock", paused=False, speed=4.0))
    bench.wait_for(lambda event: event["kind"] == "host-pace" and event["ns"] > stood_ns + 300_000_000)
    bench.do("speed", factor=1)


def test_faults_marks_and_strangers(rover):
    bench = rover
    bench.do("inject", kind="noise", probability=0.3, count=2)
    bench.wait_for(is_event("fault", fault="noise", towards="target"))
    bench.do("clear-faults")
    bench.do("mark", text="here it was")
    assert bench.wait_for(is_event("action", do="mark"))["with"] == {"text": "here it was"}
    assert bench.ask("inject", kind="ghost")["error"].startswith("no fault 'ghost'")
    bench.do("mark", text="behind it")
    bench.wait_for(is_event("action", do="mark", **{"with": {"text": "behind it"}}))
    told = [event for event in bench.events() if event.get("source") == "user"]
    asked, refused = told[-3:-1]
    assert (asked["kind"], asked["do"], asked["with"]) == ("action", "inject", {"kind": "ghost"})
    assert (refused["kind"], refused["do"]) == ("refused", "inject")
    assert refused["cause"].startswith("no fault 'ghost'")
    bench.client.sendall(b"nonsense\n")
    assert '"ok": false' in bench.answers.readline()
    bench.client.sendall(b"[]\n")
    assert "a request is an object" in bench.answers.readline()


def test_a_bench_that_is_left_with_a_word_goes_on(rover):
    bench = rover
    bench.do("farewell")
    bench.leave()
    assert bench.session.alive()
    bench.join()
    bench.do("hello")


def test_a_paused_bench_whose_dashboard_dies_ends_in_good_order(live):
    bench = live("rover-model")
    bench.do("pause")
    bench.wait_for(is_event("clock", paused=True))
    bench.leave()
    assert bench.process.wait(PATIENCE_S) == 0
    assert Journal.read(bench.session.journal).ended


def test_a_killed_bench_leaves_what_can_be_read(live):
    bench = live("pioneer-plane")
    bench.wait_for(is_event("pose"))
    bench.process.send_signal(signal.SIGKILL)
    bench.process.wait(PATIENCE_S)
    recording = Journal.read(bench.session.journal)
    assert recording.events
    assert not recording.ended
    assert not bench.session.alive()


@OF_FIRMWARE
@pytest.mark.needs_physics
def test_firmware_on_a_board_is_driven_and_reset(live):
    bench = live("rover")
    bench.wait_for(is_event("machine", source="station", state="LINKED"))
    bench.wait_for(is_event("pin", source="brain.PB11", level=True))
    bench.do("reset")
    bench.wait_for(is_event("reset", source="brain"))


@pytest.mark.exhaustive("three processes in turn; the gate has such a port in links/test_reconnecting")
def test_a_port_that_goes_and_comes_again_is_shown_as_such(live, tmp_path):
    def serve():
        words = [sys.executable, "-m", "hilbench", "serve", "rover-model", "--pty", str(tmp_path / "port")]
        process = subprocess.Popen(words, stderr=subprocess.PIPE, text=True)
        assert "serving at" in process.stderr.readline()
        return process

    def end(process):
        process.terminate()
        process.wait(PATIENCE_S)
        process.stderr.close()

    served = serve()
    try:
        bench = live("rover-model", "--target", f"serial:{tmp_path / 'port'}@115200")
        assert "demo" not in bench.session.describe()["actions"]
        bench.do("connect")
        bench.wait_for(is_event("machine", source="station", state="LINKED"))
        end(served)
        gone = bench.wait_for(is_event("link", up=False))
        served = serve()
        back = bench.wait_for(lambda event: is_event("link", up=True)(event) and event["ns"] > gone["ns"])
        bench.wait_for(lambda event: event.get("state") == "LINKED" and event["ns"] >= back["ns"])
    finally:
        end(served)
