"""`hilbench proxy` as a process, between ptys and sockets, and what is wrong on its command line."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import socket
import subprocess
import threading
import tty

import pytest

from hilbench.bench import Bench
from hilbench.bench.lateness_log import LatenessLog
from hilbench.cli import main
from hilbench.clock import Scheduler
from hilbench.errors import UsageError
from hilbench.journal import Journal
from hilbench.links import Line, MemoryLink
from hilbench.plugins.discovery import PLUGINS
from hilbench.recordings.chunks import speaker_of
from hilbench.recordings.piecewise import open_pieces
from hilbench.serving.proxy import look_on, read_faults
from hilbench.serving.relay import CLIENT, SERVER, Relay
from hilbench.testing import FakeHostClock
from hilbench.tui.model.replay import Replay
from protocols.pkt import PROFILES, RequestTelemetry, encode_command, encode_frame
from tests.hilbench.forked import PATIENCE_S

REQUEST = encode_frame(encode_command(RequestTelemetry()), PROFILES["documented"].client.frames)
MS = 1_000_000
SYNC0 = bytes.fromhex("FAFB03000000")
SERVED = pytest.mark.real_time("a process that serves; its words and bytes are waited for, and nothing is timed")


class Proxy:
    """The command, with its client at a TCP door."""

    def __init__(self, process):
        self.process = process
        self.port = int(process.hear("stop with Ctrl-C").split("tcp 127.0.0.1:")[1].split()[0])
        self.client = self.come()

    def come(self):
        return socket.create_connection(("127.0.0.1", self.port), timeout=PATIENCE_S)

    def receive(self, count):
        data = b""
        while len(data) < count:
            more = self.client.recv(count - len(data))
            assert more, f"only {data.hex()} came"
            data += more
        return data

    def end(self):
        """Stop it; return what it printed."""
        self.process.send_signal(signal.SIGINT)
        out, self.said = self.process.communicate()
        assert self.process.returncode == 0, self.said
        return out


@pytest.fixture
def proxy(forkable, tmp_path):
    with contextlib.ExitStack() as stack:

        def start(*words):
            command = ("proxy", "tcp:0", *map(str, words))
            made = Proxy(stack.enter_context(forkable.start(*command, cwd=tmp_path, stdout=subprocess.PIPE)))
            stack.callback(made.client.close)
            return made

        yield start


@pytest.fixture
def board(tmp_path):
    """A pty in the place of a board's port: the master's descriptor, and its name."""
    master, slave = os.openpty()
    tty.setraw(slave)
    yield master, os.ttyname(slave)
    os.close(master)
    os.close(slave)


def read(descriptor, count):
    data = b""
    while len(data) < count:
        data += os.read(descriptor, count - len(data))
    return data


@SERVED
def test_bytes_pass_both_ways_and_into_the_journal(proxy, board, tmp_path):
    master, name = board
    between = proxy(f"serial:{name}", "--journal", "passed.jsonl")
    every = bytes(range(256))
    between.client.sendall(every)
    assert read(master, 256) == every
    os.write(master, every[::-1])
    assert between.receive(256) == every[::-1]
    between.end()
    assert "client: 256 bytes from it, 256 to it" in between.said
    recording = Journal.read(tmp_path / "passed.jsonl")
    assert recording.ended
    assert recording.header["proxy"] == ["tcp:0", f"serial:{name}"]
    passed = {"client": b"", "server": b""}
    for event in recording.events:
        if event["kind"] == "tx":
            passed[event["source"]] += bytes.fromhex(event["data"])
    assert passed == {"client": every, "server": every[::-1]}


@pytest.mark.parametrize("faulty", [False, True])
@SERVED
def test_a_recording_shows_the_frames_of_both_directions(proxy, board, tmp_path, faulty):
    master, name = board
    tmp_path.joinpath("faults.toml").write_text('[[faults]]\nkind = "noise"\nbyte = 1000000\ntowards = "b"\n')
    words = ("--protocol", "p2os", "--journal", "passed.jsonl", *(("--faults", "faults.toml") if faulty else ()))
    between = proxy(f"serial:{name}", *words)
    between.client.sendall(SYNC0)
    assert read(master, len(SYNC0)) == SYNC0
    os.write(master, SYNC0)
    assert between.receive(len(SYNC0)) == SYNC0
    between.end()
    replay = Replay(open_pieces(tmp_path / "passed.jsonl"))
    replay.work()
    frames = replay.model.frames.frames
    assert [(frame.sent, frame.good) for frame in frames] == [(True, True), (False, True)]
    assert [[region.name for region in frame.regions][2] for frame in frames] == ["number", "type"]


@pytest.mark.parametrize("clients", ["all", "first"])
@SERVED
def test_a_second_client_is_served_or_not(proxy, board, clients):
    master, name = board
    between = proxy(f"serial:{name}", "--clients", clients)
    between.client.sendall(b"first")
    assert read(master, 5) == b"first"
    with between.come() as second:
        if clients == "first":
            assert second.recv(1) == b""
        else:
            second.sendall(b"second")
            assert read(master, 6) == b"second"
            os.write(master, b"both")
            assert between.receive(4) == second.recv(4) == b"both"
    between.end()
    served, refused = "another client came: 2 are connected", "a client was refused"
    assert (served in between.said, refused in between.said) == (clients == "all", clients == "first")


@SERVED
def test_what_passed_is_in_the_journal_of_a_proxy_that_was_killed(proxy, board, tmp_path):
    master, name = board
    between = proxy(f"serial:{name}", "--journal", "passed.jsonl")
    between.client.sendall(b"before")
    assert read(master, 6) == b"before"
    patience = threading.Event()
    while b"6265666f7265" not in (tmp_path / "passed.jsonl").read_bytes():
        patience.wait(0.02)
    between.process.send_signal(signal.SIGKILL)
    between.process.wait()
    recording = Journal.read(tmp_path / "passed.jsonl")
    assert (recording.problem, recording.ended) == (None, False)
    assert b"before".hex() in {event.get("data") for event in recording.events}


@SERVED
def test_faults_strike_and_frames_are_printed(proxy, tmp_path):
    faults = tmp_path / "faults.toml"
    faults.write_text('[[faults]]\nkind = "flip"\nprobability = 1\nbit = 7\nfrom = "b"\n')
    between = proxy("rover-model", "--faults", "faults.toml", "--protocol", "pkt", "--json")
    between.client.sendall(REQUEST)
    assert b"PKT!" in bytes(value ^ 0x80 for value in between.receive(200))
    out = between.end()
    frames = [json.loads(line) for line in out.splitlines()]
    assert {frame["stream"] for frame in frames} == {"client", "server"}
    assert all(frame["kind"] == "frame" for frame in frames[:-1])
    assert "fault flip probability 1 bit 7 towards a struck (" in between.said


@SERVED
def test_a_far_end_that_hangs_up_is_looked_for(proxy):
    with socket.create_server(("127.0.0.1", 0)) as listener:
        between = proxy(f"socket://127.0.0.1:{listener.getsockname()[1]}")
        far, _ = listener.accept()
        between.client.sendall(b"there")
        assert far.recv(5, socket.MSG_WAITALL) == b"there"
        far.sendall(b"back!")
        assert between.receive(5) == b"back!"
        far.close()
        between.process.hear("server: the line is down")
        between.process.hear("server: the line is up")  # the listener is there, and takes whoever comes
        between.end()


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        (("tcp:x", "rover-model"), 2, "tcp:x: 'x' does not end in a port"),
        (("tcp:usart1=0", "rover-model"), 2, "leave out usart1="),
        (("tcp:0", "rovermodel"), 2, "rover-model"),
        (("tcp:0", "serial:/dev/ttyNONE"), 3, "no such port"),
        (("tcp:0", "rover-model", "--faults", "none.toml"), 2, "no such file of faults"),
        (("tcp:0",), 2, "B is missing"),
        (("tcp:0", "rover-model", "--clients", "one"), 2, "--clients: invalid choice: 'one' (choose from "),
    ],
)
def test_what_is_wrong_is_said_in_one_line(tmp_path, monkeypatch, capsys, words, code, said):
    monkeypatch.chdir(tmp_path)
    assert main(["proxy", *words]) == code
    line = capsys.readouterr().err
    assert line.startswith("hilbench: ")
    assert line.count("\n") == 1
    assert said in line


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (
            '[[faults]]\nkind = "flip"\nbyte = 1\nbit = 1\ntowards = "robot.host"',
            r"faults.toml:5: 'robot.host' is no end",
        ),
        ('[[faults]]\nkind = "drop"\nbyte = 1\nlink = 1', r"faults.toml:4: .*no link but 0"),
        ('[[faults]]\nkind = "drp"\nbyte = 1', r"faults.toml:2: .*'drp' is not a value it takes"),
        ("[world]", r"faults.toml:1: unknown key 'world'"),
    ],
)
def test_what_is_wrong_in_a_file_of_faults_is_said_with_its_line(tmp_path, text, said):
    path = tmp_path / "faults.toml"
    path.write_text(text)
    with pytest.raises(UsageError, match=said):
        read_faults(path)


def test_faults_without_a_direction_are_towards_the_board(tmp_path):
    path = tmp_path / "faults.toml"
    path.write_text('[[faults]]\nkind = "drop"\nbyte = 1\n[[faults]]\nkind = "disconnect"\nat_s = 1\nduration_s = 1\n')
    assert [entry.describe() for entry in read_faults(path)] == [
        "drop byte 1 towards b",
        "disconnect at_s 1 duration_s 1",
    ]


def test_a_recording_says_how_late_the_host_was():
    host, bench = FakeHostClock(), Bench(Scheduler(), Journal())
    ends = [MemoryLink(bench.scheduler, Line(baud=0), name=name).a for name in "ab"]
    for at_ms, late_ms in ((250, 30), (600, 20), (2900, 1), (4550, 40)):
        host.stall(host.host_ns + at_ms * MS, late_ms * MS)
    bench.scheduler.lock(host)
    look_on(bench, Relay(bench, *ends), LatenessLog(bench, "proxy"))
    bench.run_for(6.0)
    bench.scheduler.unlock()
    said = [(one["ns"], one["uncertainty_s"]) for one in bench.journal.recent if one["kind"] == "host-lateness"]
    expected = [(300, 0.03), (1300, 0.02), (4600, 0.04)]
    assert said == [(ms * MS, pytest.approx(late_s, rel=1 / 8)) for ms, late_s in expected]


def test_who_is_at_its_ends_is_known_without_a_system(monkeypatch):
    monkeypatch.setattr(type(PLUGINS.systems), "speakers", lambda self: {})
    assert [speaker_of(who) for who in (CLIENT, SERVER)] == ["host", "target"]
