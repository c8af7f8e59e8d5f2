"""What a TARGET may be, and what stands at a port in the place of a board: nobody sends it what it is not to get."""

from __future__ import annotations

import os
import tty
from contextlib import contextmanager

import pytest

from hilbench.benchfile.target_grammar import Target, TargetKind, parse_target
from hilbench.check import CheckOptions, Verdict, run_suites
from hilbench.check.bench_provider import make_provider
from hilbench.cli import main
from hilbench.clock import NS_PER_MS
from hilbench.errors import UsageError
from hilbench.terminal.options import TargetChoice
from targets.firmware import image_path
from tests.each import each
from tests.share import few


@each(
    ("text", "kind", "name", "rest"),
    [
        ("pioneer", TargetKind.MODEL, "pioneer", ""),
        ("vehicle-model:v1", TargetKind.MODEL, "vehicle-model", "v1"),
        ("bluepill:a b.elf", TargetKind.BOARD, "bluepill", "a b.elf"),
        ("./mine.toml:C:x.hex", TargetKind.BOARD, "./mine.toml", "C:x.hex"),
        ("serial:/dev/ttyUSB0@9600,dtr=off", TargetKind.SERIAL, "serial", "/dev/ttyUSB0@9600,dtr=off"),
        ("serial:usb=0483:374b", TargetKind.SERIAL, "serial", "usb=0483:374b"),
        ("rfc2217://host:4000", TargetKind.SERIAL, "rfc2217", "//host:4000"),
        ("listen:pty:./p", TargetKind.LISTEN, "listen", "pty:./p"),
        ("listen:tcp:0.0.0.0:8000", TargetKind.LISTEN, "listen", "tcp:0.0.0.0:8000"),
        ("exec:nc socket://localhost {port}", TargetKind.EXEC, "exec", "nc socket://localhost {port}"),
        ("capture:run.pcap", TargetKind.CAPTURE, "capture", "run.pcap"),
    ],
)
def test_a_target_of_each_kind(text, kind, name, rest):
    assert parse_target(text, "--target") == Target(kind=kind, text=text, name=name, rest=rest)


@each(
    ("text", "said"),
    [
        ("", "not a target"),
        ("pionere", "not a target; did you mean 'pioneer'?"),
        ("seral:/dev/ttyUSB0", "not a target; did you mean 'serial'?"),
        ("tty:/dev/a", "a target begins with one of: pioneer, rover-model, vehicle-model, bluepill, "),
        ("/dev/ttyUSB0@9600", "not a target; write serial:/dev/ttyUSB0@9600"),
        ("nothing", "not a target; a target is one of: pioneer, "),
        ("bluepil:x.elf", "not a target; did you mean 'bluepill'?"),
        ("bluepill:", "names no image; write bluepill:IMAGE"),
        ("serial:", "not a serial port"),
        ("serial:/dev/a@0", "not a serial port"),
        ("serial:/dev/a@9600,speed=1", "'speed=1' is no setting of a port"),
        ("listen:/dev/a", "not an endpoint; write listen:pty:PATH or listen:tcp:[HOST:]PORT"),
        ("listen:pty:", "not an endpoint"),
        ("exec:", "does not say where to connect"),
        ("exec:'x {pty}", "cannot be split into words: No closing quotation"),
        ("capture:", "names no recording; write capture:FILE"),
    ],
)
def test_what_is_no_target_is_refused_in_one_line(text, said):
    with pytest.raises(UsageError) as raised:
        parse_target(text, "--target")
    assert said in str(raised.value)
    assert "\n" not in str(raised.value)


# --- at a port

SUITE = """\
from hilbench.check import case

@case("X01", text="as it says", level="must", source="mine")
def test_it_echoes(bench):
    line = bench.board.usart("usart1")
    line.write(b"ping")
    line.expect(b"ping", within_s=2.0)

@case("X02", text="as it says", level="must", source="mine")
def test_it_blinks(bench):
    assert bench.board.pin("PC13").level is not None

@case("X03", text="as it says", level="must", source="mine")
def test_the_other_line(bench):
    bench.board.usart("usart2").write(b"never")

@case("X04", text="as it says", level="must", source="mine")
def test_a_part(bench):
    assert bench.parts
"""


class Board:
    """What is at the other end of a pty: it keeps what comes, and may echo it. It lives in bench time."""

    def __init__(self, descriptor, *, echoes):
        self.heard = b""
        self._descriptor = descriptor
        self._echoes = echoes

    def live(self, scheduler):
        try:
            data = os.read(self._descriptor, 4096)
        except BlockingIOError:
            data = b""
        self.heard += data
        if self._echoes and data:
            os.write(self._descriptor, data)
        scheduler.after(NS_PER_MS, lambda: self.live(scheduler))


@contextmanager
def board_at_a_port(*, echoes=False):
    master, slave = os.openpty()
    tty.setraw(slave)
    os.set_blocking(master, False)
    try:
        yield Board(master, echoes=echoes), f"serial:{os.ttyname(slave)}"
    finally:
        os.close(master)
        os.close(slave)


@pytest.fixture
def own_bench(tmp_path):
    (tmp_path / "test_mine.py").write_text(SUITE)
    file = tmp_path / "hilbench.toml"
    file.write_text(
        'version = 1\nsuites = ["test_mine.py"]\n'
        f'[targets.brain]\nboard = "bluepill"\nfirmware = "{image_path("echo-irq")}"\n'
    )
    return file


LINES = '[[links]]\nends = ["peer.a", "brain.usart2"]\n[[links]]\nends = ["peer.b", "brain.usart3"]\n'


def check(board, spec, bench, *, name="", suites=()):
    options = CheckOptions(bench=str(bench), targets=(TargetChoice(spec=spec, name=name),), suites=suites)
    provider = make_provider(options)
    board.live(provider._scheduler)
    return run_suites(options, provider)


@pytest.mark.usefixtures("skips")
def test_a_user_s_suite_runs_at_a_port_and_nothing_else_is_sent_there(own_bench):
    with board_at_a_port(echoes=True) as (board, spec):
        report = check(board, spec, own_bench)
        assert board.heard == b"ping"
    assert [(case.verdict, case.cause) for case in report.cases] == [
        (Verdict.PASS, ""),
        (Verdict.NOT_APPLICABLE, "a port shows no 'pin' of a board"),
        (Verdict.NOT_APPLICABLE, "usart2 of brain is not at the port: usart1 is"),
        (Verdict.NOT_APPLICABLE, "a board at a port has no 'parts'"),
    ]
    assert report.bench["target"].startswith("brain.usart1 at /dev/pts/")


@pytest.mark.usefixtures("skips")
def test_a_board_that_does_not_answer_fails_there_as_it_would_in_the_emulator(own_bench):
    with board_at_a_port() as (board, spec):
        report = check(board, spec, own_bench, name="brain.usart1")
        assert board.heard == b"ping"
    assert report.cases[0].verdict is Verdict.FAIL
    assert "did not send b'ping' within 2.0 s, but b''" in report.cases[0].cause


@pytest.mark.usefixtures("skips")
@pytest.mark.parametrize(
    ("name", "usart"),
    few([("a", "usart2"), ("b", "usart3"), ("", "usart2"), ("brain.usart1", "usart1")], 2, "the other names"),
)
def test_lines_with_names_make_no_vehicle_interface_of_a_board(own_bench, name, usart):
    own_bench.write_text(own_bench.read_text() + LINES)
    with board_at_a_port() as (board, spec):
        report = check(board, spec, own_bench, name=name)
        assert board.heard == {"usart1": b"ping", "usart2": b"never", "usart3": b""}[usart]
    assert report.bench["target"].startswith(f"brain.{usart} at ")


@pytest.mark.usefixtures("skips")
def test_a_board_that_is_unplugged_violates_nothing(own_bench):
    suite = own_bench.parent / "test_mine.py"
    suite.write_text(
        SUITE.replace("    line.expect(", "    os.close(bench.peer.unplug)\n    line.expect(").replace(
            "from", "import os\nfrom", 1
        )
    )
    master, slave = os.openpty()
    tty.setraw(slave)
    options = CheckOptions(
        bench=str(own_bench), targets=(TargetChoice(spec=f"serial:{os.ttyname(slave)}"),), select="X01"
    )
    provider = make_provider(options)
    provider._make_peer = lambda port, make=provider._make_peer: _with(make(port), unplug=master)
    os.close(slave)
    report = run_suites(options, provider)
    assert (report.cases[0].verdict, report.exit_code) == (Verdict.ERROR, 3)


def _with(thing, **attributes):
    vars(thing).update(attributes)
    return thing


def test_a_bench_without_a_pioneer_is_not_spoken_to_in_p2os(tmp_path, capsys):
    (tmp_path / "test_mine.py").write_text(SUITE)
    file = tmp_path / "hilbench.toml"
    file.write_text('version = 1\nsuites = ["test_mine.py"]\n[targets.car]\nmodel = "car-host"\n')
    with board_at_a_port() as (board, spec):
        for target in (spec, "listen:tcp:0"):
            assert main(["check", str(file), "--target", target]) == 2
            assert "names no vehicle interface among its targets" in capsys.readouterr().err
        with pytest.raises(BlockingIOError):
            os.read(board._descriptor, 1)


def test_a_smaller_chip_is_no_other_board(own_bench):
    own_bench.write_text(own_bench.read_text() + "chip = 'STM32F103C4'\n")
    make_provider(
        CheckOptions(bench=str(own_bench), targets=(TargetChoice(spec=f"bluepill:{image_path('echo-irq')}"),))
    ).close()


@pytest.mark.parametrize(
    ("bench", "words", "code", "said"),
    [
        ("bluepill", [], 4, ""),
        (
            "pioneer-plane",
            ["--suite", "pkt-board"],
            2,
            "--suite pkt-board: is a suite of PKT!, which this bench does not speak",
        ),
        ("pioneer-plane", ["--suite", "vehicle-board"], 2, "is a suite of CARLA"),
        ("rover-model", ["--suite", "p2os-server"], 2, "is a suite of P2OS"),
        ("rover-model", ["--suite", "vehicle-host"], 2, "is a suite of CARLA"),
        ("rover", ["--suite", "p2os-server"], 2, "is a suite of P2OS"),
        ("bluepill", ["--suite", "p2os-server"], 2, "is a suite of P2OS"),
        ("vehicle-model", ["--suite", "pkt-board"], 2, "nothing at the line 'stack'"),
    ],
)
def test_a_foreign_suite_sends_nothing_to_a_port(bench, words, code, said, capsys):
    name = "simulator=" if bench == "vehicle-model" else ""
    with board_at_a_port() as (board, spec):
        assert main(["check", bench, "--target", f"{name}{spec}", *words]) == code
        with pytest.raises(BlockingIOError):
            os.read(board._descriptor, 1)
    err = capsys.readouterr().err
    assert said in err
    assert err.count("\n") == (code == 2)


def test_a_user_s_suite_does_not_share_a_port_with_one_of_another_protocol(own_bench, capsys):
    with board_at_a_port() as (board, spec):
        words = ["--suite", "pkt-board", "--suite", str(own_bench.parent / "test_mine.py")]
        assert main(["check", str(own_bench), "--target", spec, *words]) == 2
        with pytest.raises(BlockingIOError):
            os.read(board._descriptor, 1)
    assert "--suite pkt-board: is a suite of PKT!, which this bench does not speak" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("bench", "targets", "said"),
    few(
        [
            ("pioneer-plane", ["serial:/dev/none"], "/dev/none: there is no such port"),
            ("rover", ["serial:/dev/none"], "/dev/none: there is no such port"),
            (
                "vehicle-model",
                ["simulator=serial:/dev/none", "stack=serial:/dev/nil"],
                "/dev/none: there is no such port",
            ),
            ("rover-model", ["serial:/dev/none"], "/dev/none: there is no such port"),
        ],
        2,
        "the other benches",
    ),
)
def test_a_port_that_is_not_there_costs_one_line(bench, targets, said, capsys):
    words = [word for target in targets for word in ("--target", target)]
    assert main(["check", bench, *words]) == 3
    out, err = capsys.readouterr()
    assert out == ""
    assert said in err
    assert err.count("\n") == 1


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("brian", "--target brian=serial:/dev/none: no board 'brian' on this bench; did you mean 'brain'?"),
        ("brain.usart7", "no USART 'usart7' of brain can be reached"),
    ],
)
def test_what_is_at_the_port_has_to_be_there(own_bench, name, said, capsys):
    assert main(["check", str(own_bench), "--target", f"{name}=serial:/dev/none"]) == 2
    assert said in capsys.readouterr().err


@pytest.mark.parametrize("what", ["serial:/dev/none", "socket://localhost:1", "capture:x.pcap"])
def test_what_is_outside_cannot_be_run_here(what, capsys):
    assert main(["run", what]) == 2
    assert "cannot be run here; name a bench, or a board with an image" in capsys.readouterr().err
