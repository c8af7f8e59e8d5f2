"""Faults in a bench file: what is refused, and that each kind strikes where the file says."""

from __future__ import annotations

import re
import signal
import socket
import sys
import textwrap
from itertools import pairwise
from pathlib import Path
from typing import get_args, get_type_hints

import pytest

from hilbench.bench.locked_providers import LockedProvider
from hilbench.bench.shared import Shared
from hilbench.benchfile.fault_entries import FaultEntry
from hilbench.benchfile.reader import open_bench
from hilbench.check import CheckOptions, Verdict, run_suites
from hilbench.check.bench_provider import make_provider
from hilbench.check.report import matrix
from hilbench.errors import UsageError
from hilbench.journal import Journal
from hilbench.judging.provider import CaseInfo
from hilbench.links import Line, MemoryLink
from hilbench.links.faults import FaultKind
from hilbench.systems.pioneer.provider import VirtualProvider
from hilbench.terminal.options import TargetChoice
from protocols.p2os import SyncEcho, encode_packet
from tests.hilbench.forked import PATIENCE_S

HEAD = 'version = 1\n[world]\nphysics = "plane"\n[targets.robot]\nmodel = "pioneer-2dx"\n'
LINES = HEAD.count("\n")
BYTE_NS = 1_041_666
ECHO = encode_packet(SyncEcho(number=0))

NO_PASS = {Verdict.FAIL, Verdict.INCONCLUSIVE}
"""What becomes of a case in real time that fails; the latter on a host that was late."""


@pytest.fixture
def bench_file(tmp_path):
    """Write a bench file with faults; return its path."""

    def write(*faults):
        file = tmp_path / "faulty.toml"
        file.write_text(HEAD + "".join(f"[[faults]]\n{fault}\n" for fault in faults))
        return str(file)

    return write


@pytest.fixture
def open_case(bench_file):
    """Open a case of a virtual bench with faults; return it and its journal."""

    def open_it(*faults, seed=1, needs=()):
        journal = Journal()
        shared = Shared(bench_file=open_bench(bench_file(*faults)), timeout_scale=1.0, journal=journal)
        case = CaseInfo(id="x/y", clause_ids=("X",), seed=seed, needs=frozenset(needs))
        return VirtualProvider(shared).open_case(case), journal

    return open_it


@pytest.fixture
def answer(open_case):
    """Send SYNC0 to the virtual robot; return what came back, when, the line's changes, the port, the strikes."""

    def ask(*faults, seed=1):
        opened, journal = open_case(*faults, seed=seed)
        with opened as bench:
            got, lines = [], []
            port = bench.peer.port
            port.on_receive = lambda data, at_ns: got.append((data, at_ns))
            port.on_line = lambda up, at_ns: lines.append((up, at_ns))
            bench.bench.run_for(0.001)
            bench.peer.send(0)
            bench.bench.run_for(1.0)
        struck = [event for event in journal.recent if event["kind"] == "fault"]
        return b"".join(data for data, _ in got), [at_ns for _, at_ns in got], lines, port, struck

    return ask


TOWARDS = 'towards = "peer"\n'


def test_without_faults_there_is_an_echo(answer):
    data, _, lines, _, struck = answer()
    assert (data, lines, struck) == (ECHO, [], [])


@pytest.mark.parametrize(
    ("fault", "expected"),
    [
        ('kind = "drop"\nbyte = 2\ncount = 2', ECHO[:2] + ECHO[4:]),
        ('kind = "flip"\nbyte = 3\nbit = 6', ECHO[:3] + b"\x40" + ECHO[4:]),
        ('kind = "duplicate"\nbyte = 1', ECHO[:2] + ECHO[1:]),
        ('kind = "truncate"\nbyte = 2', ECHO[:2]),
        ('kind = "drop"\nat_s = 0.0', ECHO[1:]),
        ('kind = "drop"\nprobability = 1', b""),
    ],
)
def test_a_fault_of_bytes_strikes_the_bytes(answer, fault, expected):
    data, _, _, _, struck = answer(TOWARDS + fault)
    assert data == expected
    assert struck
    assert {(event["fault"], event["towards"], event["number"]) for event in struck} == {
        (fault.split('"')[1], "peer", 0)
    }


def test_delay_moves_what_follows(answer):
    data, usual_ns, *_ = answer()
    delayed, times_ns, _, _, (event,) = answer(TOWARDS + 'kind = "delay"\nbyte = 2\nduration_s = 0.25')
    assert delayed == data
    later_ns = [late - soon for soon, late in zip(usual_ns, times_ns, strict=True)]
    assert later_ns == pytest.approx([0, 0] + [250_000_000] * 4, abs=1)  # a new count of bit times begins
    assert event["fault"] == "delay"


def test_noise_comes_before_a_byte_and_takes_its_time(answer):
    data, times_ns, _, _, (event,) = answer(TOWARDS + 'kind = "noise"\nbyte = 1\ncount = 5')
    assert (data[:1], data[6:], len(data)) == (ECHO[:1], ECHO[1:], 11)
    assert min(later - sooner for sooner, later in pairwise(times_ns)) >= BYTE_NS
    assert event["fault"] == "noise"


def test_a_break_is_heard(answer):
    data, _, _, port, (event,) = answer(TOWARDS + 'kind = "break"\nat_s = 0.5\nduration_s = 0.02')
    assert data == ECHO
    assert port.counters.breaks == 1
    assert (event["fault"], event["ns"]) == ("break", 500_000_000)


def test_a_disconnection_is_both_ways_and_ends(answer):
    data, _, lines, _, (event,) = answer('kind = "disconnect"\nat_s = 0.0\nduration_s = 0.75')
    assert data == b""
    assert lines == [(False, 0), (True, 750_000_000)]
    assert (event["fault"], event["towards"]) == ("disconnect", "both")


def test_a_disconnection_does_not_look_like_a_target_that_is_gone(open_case):
    opened, _ = open_case('kind = "disconnect"\nat_s = 0.5\nduration_s = 0.75')
    with opened as bench:
        bench.peer.run(1.0)
        assert not bench.peer.port.line_is_up
        bench.peer.run(0.5)
        bench.peer.sync(0)


def test_a_sender_at_the_wrong_rate_is_garbage(answer):
    data, _, _, port, (event,) = answer(TOWARDS + 'kind = "baud"\nat_s = 0\nduration_s = 1\nbaud = 14400')
    assert data
    assert ECHO not in data
    assert port.counters.framing_errors > 0
    assert event["fault"] == "baud"


@pytest.mark.parametrize("way", ['towards = "robot.host"\n', 'from = "peer"\n', ""])
def test_what_goes_to_the_robot_does_not_reach_it(answer, way):
    data, *_, (event,) = answer(f'{way}kind = "drop"\nbyte = 0')
    assert data == b""
    assert event["towards"] == "robot.host"


def test_with_a_client_under_test_the_robots_end_is_the_scripted_servers(open_case):
    opened, _ = open_case('towards = "robot.host"\nkind = "flip"\nbit = 0\nbyte = 3', needs={"client"})
    with opened as bench:
        server = bench.server
        bench.client.start()
        assert server.wait(lambda: bool(server.dropped), 1.0)
        assert server.wait(lambda: bool(server.received), 2.0)
        assert server.received[0].name == "SYNC0"
        assert "fault flip byte 3 bit 0 towards robot.host struck (number 1)" in bench.evidence()[-1]


def test_chance_is_decided_by_the_seed_of_the_case(answer):
    noisy = TOWARDS + 'kind = "drop"\nprobability = 0.3'

    def strikes(seed):
        return [event["ns"] for event in answer(noisy, seed=seed)[4]]

    by_seed = [strikes(seed) for seed in range(8)]
    assert by_seed == [strikes(seed) for seed in range(8)]
    assert len({tuple(times) for times in by_seed}) > 3


def test_two_faults_are_told_apart(answer):
    same = TOWARDS + 'kind = "drop"\nbyte = 1'
    *_, struck = answer(same, same)
    assert [event["number"] for event in struck] == [0, 1]


@pytest.mark.parametrize(
    ("entry", "line", "message"),
    [
        ('kind = "flp"\nbyte = 1', 2, "'flp' is not a value it takes; did you mean 'flip'?"),
        ("byte = 1", 1, "the key 'kind' is missing"),
        ('kind = "drop"', 2, "kind 'drop' needs one of at_s, byte, probability"),
        ('kind = "drop"\nat_s = 1\nbyte = 3', 4, "byte cannot go with at_s"),
        ('kind = "drop"\nbyte = 1\nbit = 3', 4, "bit does not apply to kind 'drop'"),
        ('kind = "flip"\nbyte = 1', 2, "kind 'flip' needs bit"),
        ('kind = "flip"\nbyte = 1\nbit = 8', 4, "must be a whole number <= 7"),
        ('kind = "break"\nbyte = 3\nduration_s = 1', 2, "is a fault of the line, not of a byte, and needs at_s"),
        ('kind = "delay"\nbyte = 3', 2, "kind 'delay' needs duration_s"),
        ('kind = "baud"\nat_s = 1\nduration_s = 1\nbaud = 1', 5, "must be a whole number >= 300"),
        ('kind = "disconnect"\nat_s = 1\nduration_s = inf', 4, "must be a number <= 1000000"),
        ('kind = "disconnect"\nat_s = nan\nduration_s = 1', 3, "must be a number"),
        ('kind = "disconnect"\nat_s = 1\nduration_s = 1\nfrom = "peer"', 5, "from does not apply to kind"),
        ('kind = "drop"\nprobability = 0', 3, "must be a number > 0"),
        ('kind = "drop"\nprobabilty = 1', 3, "unknown key 'probabilty' in [faults[0]]; did you mean 'probability'?"),
        ('kind = "drop"\nbyte = 1\ntowards = "robt.host"', 4, "not an end of the link; did you mean 'robot.host'?"),
        ('kind = "drop"\nbyte = 1\ntowards = "peer"\nfrom = "peer"', 5, "from cannot go with towards"),
        ('kind = "drop"\nbyte = 1\nlink = 1', 4, "there is no link 1: this bench has one line, link 0"),
        ('kind = "drop"\nbyte = 1\n[[faults]]\nkind = "drop"\nbyte = "x"', 6, "must be a whole number, not a text"),
    ],
)
def test_what_is_wrong_is_one_line_with_its_place(bench_file, entry, line, message):
    path = bench_file(entry)
    with pytest.raises(UsageError) as raised:
        open_bench(path)
    said = str(raised.value)
    assert said.startswith(f"{path}:{LINES + line}: ")
    assert message in said
    assert "\n" not in said


def test_every_kind_of_the_links_can_be_written():
    assert set(get_args(get_type_hints(FaultEntry)["kind"])) == {kind.value for kind in FaultKind}


def test_the_example_in_the_docs_is_right(tmp_path):
    page = (Path(__file__).parents[2] / "docs" / "faults.md").read_text()
    (text,) = re.findall(r"```toml\n(.*?)```", page, re.DOTALL)
    file = tmp_path / "docs.toml"
    file.write_text(text)
    assert [fault.describe() for fault in open_bench(str(file)).faults] == [
        "flip at_s 3.2 bit 3 towards robot.host",
        "noise probability 0.001 count 4 towards peer",
        "disconnect at_s 8 duration_s 0.5",
    ]
    listed = re.findall(r"^\| `(\w+)` \|", page, re.MULTILINE)
    assert set(listed) == {"kind", *(kind.value for kind in FaultKind)}


def test_figures_are_told_whole(bench_file):
    (fault,) = open_bench(bench_file('kind = "drop"\nbyte = 12345678\ncount = 10')).faults
    assert fault.describe() == "drop byte 12345678 count 10 towards robot.host"


def test_a_link_written_the_other_way_round(tmp_path):
    file = tmp_path / "turned.toml"
    file.write_text(HEAD + '[[links]]\nends = ["robot.host", "peer"]\n[[faults]]\nkind = "drop"\nbyte = 1\n')
    assert open_bench(str(file)).faults[0].towards == "peer"


# --- real ports: the faults hold for each case anew, and the line is sound in between


LOOP_SUITE = '''
from __future__ import annotations
from hilbench.check import case

TEXT = dict(text="What is sent comes back.", source="a plug that joins Tx and Rx")

def echoed(peer, data):
    """Send this and a full stop; return what comes back before the full stop, or until the line is down."""
    got = bytearray()
    take = peer.port.on_receive
    peer.port.on_receive = lambda data, at_ns: (got.extend(data), take(data, at_ns))
    peer.write(data + b".")
    peer.bench.run_until(lambda: got.endswith(b".") or not peer.port.line_is_up, 60.0)
    return bytes(got).removesuffix(b".")

@case("L1", **TEXT)
def test_first(peer): assert echoed(peer, b"abcd") == b"abcd"

@case("L2", **TEXT)
def test_second(peer): assert echoed(peer, b"wxyz") == b"wxyz"

@case("L3", **TEXT)
def test_opened_again(peer, bench):
    assert echoed(peer, b"a") == b"a"
    bench.hang_up()
    bench.reconnect()
    assert echoed(peer, b"bcd") == b"bcd"
'''


@pytest.fixture
def check_loop(tmp_path, bench_file):
    """Run the suite above at a port whose Tx and Rx are joined, in real time."""

    def run(*faults, select=""):
        suite = tmp_path / "test_loop.py"
        suite.write_text(textwrap.dedent(LOOP_SUITE))
        targets = (TargetChoice(spec="serial:loop://"),)
        options = CheckOptions(bench=bench_file(*faults), suites=(str(suite),), targets=targets, select=select)
        provider = make_provider(options)
        try:
            return run_suites(options, provider)
        finally:
            provider.close()

    return run


@pytest.fixture
def in_bench_time(monkeypatch, skips):
    """Let a line in memory take the place of the port."""

    def open_serial(self, target):
        line = MemoryLink(self._scheduler, Line(baud=target.baud), name="loop")
        line.b.on_receive = lambda data, _at_ns: line.b.write(data)
        self._ports.append(line.a)
        return line.a

    monkeypatch.setattr(LockedProvider, "_open_serial", open_serial)


@pytest.mark.usefixtures("in_bench_time")
def test_a_sound_port(check_loop):
    assert [clause.verdict for clause in check_loop().clauses] == [Verdict.PASS] * 3


FLIP = 'towards = "robot.host"\nkind = "flip"\nbyte = 2\nbit = 0'


@pytest.mark.real_time("a port is opened as the one of a board is; a host that is late makes the case inconclusive")
def test_a_faulty_port_in_real_time(check_loop):
    (first, *_) = check_loop(FLIP, select="L1").clauses
    assert first.verdict in NO_PASS
    assert "b'abbd'" in first.cause


@pytest.mark.usefixtures("in_bench_time")
def test_a_faulty_port_strikes_in_every_case_anew(check_loop):
    report = check_loop(FLIP)
    assert {clause.verdict for clause in report.clauses} == {Verdict.FAIL}
    assert "b'abbd'" in report.clauses[0].cause
    assert "b'wxxz'" in report.clauses[1].cause
    assert "b'ccd'" in report.clauses[2].cause, "byte 2 of the case, whatever was opened in between"
    assert "fault flip byte 2 bit 0 towards robot.host struck" in "\n".join(report.clauses[0].evidence)
    assert report.bench["faults"] == "flip byte 2 bit 0 towards robot.host"
    first_line = matrix.render(report, colours=False, width=None).splitlines()[0]
    assert "faults flip byte 2 bit 0 towards robot.host" in first_line


@pytest.mark.usefixtures("in_bench_time")
def test_a_disconnection_is_the_lines_and_does_not_lose_the_target(check_loop):
    report = check_loop('kind = "disconnect"\nat_s = 0\nduration_s = 100')
    assert {clause.verdict for clause in report.clauses[:2]} == {Verdict.FAIL}
    assert report.clauses[2].verdict is Verdict.FAIL, "opened again, but the first byte was lost before"
    assert report.stopped == ""


CLIENT = """
import serial, sys
port = serial.Serial(sys.argv[1], 9600)
port.write(bytes.fromhex("FAFB03000000"))
port.close()
"""

CLIENT_SUITE = """
from __future__ import annotations
from hilbench.check import case

@case("K1", text="It says SYNC0.", source="ours", needs=("client",))
def test_sync0(server, client):
    client.start()
    server.wait(lambda: server.bytes_received > 0, 60.0)
    server.wait(lambda: not server.port.line_is_up, 60.0)  # the client is gone, and all it said is heard
    assert server.received and server.received[0].name == "SYNC0"
"""


@pytest.mark.real_time("a program of somebody else; it is waited for, and a late host makes the case inconclusive")
def test_a_foreign_client_is_misheard(tmp_path, bench_file):
    (tmp_path / "client.py").write_text(CLIENT)
    suite = tmp_path / "test_client.py"
    suite.write_text(CLIENT_SUITE)
    verdicts = []
    for faults in ((), ('from = "peer"\nkind = "drop"\nbyte = 1',)):
        options = CheckOptions(
            bench=bench_file(*faults),
            suites=(str(suite),),
            targets=(TargetChoice(spec=f"exec:{sys.executable} {tmp_path / 'client.py'} {{pty}}"),),
        )
        provider = make_provider(options)
        try:
            verdicts.append(run_suites(options, provider).clauses[0].verdict)
        finally:
            provider.close()
    assert verdicts[0] is Verdict.PASS
    assert verdicts[1] in NO_PASS


@pytest.mark.real_time("a process that serves; its bytes are waited for, and nothing is timed")
def test_serve_has_the_faults_on_its_door(forkable, bench_file, tmp_path):
    journal = tmp_path / "journal.jsonl"
    bench = bench_file(TOWARDS + 'kind = "drop"\nbyte = 0')
    with forkable.start("serve", bench, "--tcp", "127.0.0.1:0", "--journal", journal) as serving:
        said = serving.hear("stop with")
        port = int(re.search(r"serving at tcp .*:(\d+),", said)[1])
        assert "faults on the line: drop byte 0 towards peer" in said
        with socket.create_connection(("127.0.0.1", port), timeout=PATIENCE_S) as client:
            client.sendall(ECHO)
            got = b""
            while len(got) < len(ECHO) - 1:
                got += client.recv(100)
        assert got == ECHO[1:]
        serving.send_signal(signal.SIGTERM)
        serving.communicate()
    recording = Journal.read(journal)
    events = recording.events
    assert recording.header["faults"] == ["drop byte 0 towards peer"]
    assert recording.header["bench_sha256"] == open_bench(bench).digest
    assert [event["fault"] for event in events if event["kind"] == "fault"] == ["drop"]
