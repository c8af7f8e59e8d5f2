"""Stimuli: the line that says one, and what it does to a board at its time."""

from __future__ import annotations

import contextlib
import os
import tomllib
from fractions import Fraction
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hilbench.benchfile.reader import open_bench
from hilbench.benchfile.stimulus import Hold, Ramp, Reset, Send, Square, Stick, parse_stimulus
from hilbench.benchfile.stimulus_options import with_stimuli
from hilbench.cli import main
from hilbench.commands.run import parser
from hilbench.errors import UnavailableError, UsageError
from hilbench.mcu.command_line import open_target
from hilbench.mcu.emulated import EmulatedBench
from hilbench.mcu.stimuli import Stimuli
from hilbench.mcu.stimulus_writer import StimulusWriter
from hilbench.mcu.under_test import boards_under_test
from targets.firmware import image_path
from targets.mcu.pins import PadMode
from tests.each import each

MS = 1_000_000


@pytest.fixture(scope="module")
def boards():
    return open_target(f"nucleo-f767zi:{image_path('f767-pins')}").boards


@pytest.fixture
def parse(boards, tmp_path):
    return lambda text: parse_stimulus(text, boards, tmp_path)


# --- the line


@pytest.mark.parametrize(
    ("value", "action"),
    [
        ("0", Hold(value=False)),
        ("1/50ms", Hold(value=True, for_ns=50 * MS)),
        ("z", Hold(value=None)),
        ("1.65V", Hold(value=1.65)),
        ("0V/2us", Hold(value=0.0, for_ns=2000)),
        ("0.5V..3V/1.5s", Ramp(from_volts=0.5, to_volts=3.0, in_ns=1_500 * MS)),
        ("1kHz", Square(hz=Fraction(1000))),
        ("2.5mHz/25%", Square(hz=Fraction(1, 400), duty=Fraction(1, 4))),
        ("1.5MHz/2s/12.5%", Square(hz=Fraction(1_500_000), duty=Fraction(1, 8), for_ns=2000 * MS)),
    ],
)
def test_what_a_pin_can_get(parse, value, action):
    stimulus = parse(f"PC6={value}")
    assert (stimulus.target, stimulus.action) == ("PC6", action)


@pytest.mark.parametrize(
    ("text", "target", "action"),
    [
        ("B1=press/5ms", "PC13", Hold(value=True, for_ns=5 * MS)),
        ("B1=release", "PC13", Hold(value=None)),
        ("reset=press", "reset", Reset()),
        ("i2c1=stuck/1ms", "i2c1", Stick(stuck=True, for_ns=MS)),
        ("I2C1=free", "i2c1", Stick(stuck=False)),
        ("nucleo-f767zi.D13=1", "PA5", Hold(value=True)),
        (r"USART3=a=b:\r\n\x00\\", "usart3", Send(data=b"a=b:\r\n\0\\")),
        ("usart3=", "usart3", Send(data=b"")),
        ("usart3=hex:00 ff", "usart3", Send(data=b"\0\xff")),
        ("usart3=\u00fc", "usart3", Send(data=b"\xc3\xbc")),
    ],
)
def test_what_else_can_get_something(parse, text, target, action):
    stimulus = parse(text)
    assert (stimulus.board, stimulus.target, stimulus.action) == ("nucleo-f767zi", target, action)


@pytest.mark.parametrize(
    ("time", "times"),
    [
        ("", (0, 0, 1)),
        ("0s:", (0, 0, 1)),
        ("1.5us:", (1500, 0, 1)),
        ("1s+100ms:", (1000 * MS, 100 * MS, 0)),
        ("0.0ms+2ms*7:", (0, 2 * MS, 7)),
    ],
)
def test_when_it_happens(parse, time, times):
    stimulus = parse(f"{time}PA5=1")
    assert (stimulus.at_ns, stimulus.every_ns, stimulus.times) == times
    assert stimulus.text == "PA5=1"


def test_bytes_of_a_file(parse, tmp_path):
    (tmp_path / "a.bin").write_bytes(b"\0hello")
    assert parse("usart3=@a.bin").action == Send(data=b"\0hello", file=tmp_path / "a.bin")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "is no stimulus"),
        ("PA5", "is no stimulus"),
        ("1s:2s:PA5=1", "is no stimulus"),
        ("1q:PA5=1", "'1q' is not a duration"),
        ("1s+:PA5=1", "is no time"),
        ("1s+1ms*0:PA5=1", "is no time"),
        ("1s+0s:PA5=1", "is not longer than zero"),
        ("PA55=1", "no pin 'PA55'"),
        ("x.PA5=1", "no board 'x'"),
        ("PA5=2", "nothing that a pin can get"),
        ("PA5=-1V", "nothing that a pin can get"),
        ("PA5=5.6V", "more than any pin bears"),
        ("PA5=1V..2V", "does not say how long"),
        ("PA5=0Hz", "more than 0 Hz"),
        ("PA5=11MHz", "10 MHz at most"),
        ("PA5=1Hz/0%", "above 0 %"),
        ("PA5=1Hz/100%", "below 100 %"),
        ("PA5=1Hz/25%/50%", "says twice which part of a period is high; say it once"),
        ("PA5=1Hz/1s/25%/2s", "says twice for how long; say it once"),
        ("PA5=1/x", "is not a duration"),
        ("B1=1", "'B1' is a button"),
        ("B2=press", "no button 'B2'"),
        ("reset=1", "write press"),
        ("i2c1=1", "write stuck, stuck/10ms or free"),
        ("usart33=x", "no 'usart33'"),
        ("usart3=@nowhere", "cannot be read"),
        ("usart3=@nul\0", "cannot be read"),
        ("usart3=hex:0", "no hexadecimal"),
        ("usart3=@/dev/zero", "more than the 64 MB"),
        ("usart3=\udcff", "no UTF-8"),
        (f"PA5={'9' * 5000}Hz", "nothing that a pin can get"),
        ("usart3=\\q", "is no escape"),
        ("usart3=\\x4", "is no escape"),
        ("usart3=\\", "is no escape"),
    ],
)
def test_what_is_wrong_is_said(parse, text, message):
    with pytest.raises(ValueError, match=message.replace("(", r"\(")):
        parse(text)


@given(text=st.text(max_size=40) | st.from_regex(r"([0-9.+*smu]+:)?(PA5|usart3|B1)=[0-9VHz/%.\\x@]*", fullmatch=True))
def test_no_line_raises_anything_else(boards, text):
    with contextlib.suppress(ValueError):
        parse_stimulus(text, boards, Path("/nowhere"))


@pytest.fixture
def options():
    """What a command line makes of its options."""

    def make(*arguments):
        bench_file = open_target(f"nucleo-f767zi:{image_path('f767-pins')}")
        return [one.action for one in with_stimuli(parser().parse_args(arguments), bench_file).stimuli]

    return make


def test_options_say_what_they_are_about(options):
    made = options("--volts", "PC6=1.5", "--volts", "1s:PC6=0V..1V/1s", "--send", "usart3=x", "--at", "PA5=1")
    assert made == [
        Hold(value=True),
        Hold(value=1.5),
        Ramp(from_volts=0.0, to_volts=1.0, in_ns=1000 * MS),
        Send(data=b"x"),
    ]


@each(
    ("option", "text", "message"),
    [
        ("--volts", "usart3=5", "no voltage at a pin"),
        ("--volts", "PC6=1/5ms", "no voltage at a pin"),
        ("--volts", "reset=press", "no voltage at a pin"),
        ("--send", "PC6=1", "nothing for a serial line"),
    ],
)
def test_an_option_refuses_what_is_not_its_own(options, option, text, message):
    with pytest.raises(UsageError, match=f"{option}: .*{message}"):
        options(option, text)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("stimuli = [1]", "must be a text"),
        ("stimuli = 1", "must be a list"),
        ("stimulus = ['PA5=1']", "unknown key 'stimulus'"),
        ("stimuli = ['PA5=9V']", "9 V is more"),
    ],
)
def test_a_file_that_is_wrong_is_named_with_its_place(options, tmp_path, text, message):
    file = tmp_path / "s.toml"
    file.write_text(text)
    with pytest.raises(UsageError, match=rf"s\.toml:1: .*{message}"):
        options("--stimuli", str(file))


def test_a_board_must_be_named_where_there_are_several(bench_file):
    with pytest.raises(ValueError, match=r"write brain\.PA0"):
        parse_stimulus("PA0=1", bench_file(boards=2).boards, Path())


def test_a_mistake_in_a_bench_file_is_named_with_its_line(tmp_path, image):
    del image
    file = tmp_path / "b.toml"
    file.write_text('version = 1\nstimuli = [\n  "PA0=1",\n  "PA0=9V",\n]\n[targets.b]\nboard = "bluepill"\n'
                    'firmware = "a.bin"\n')  # fmt: skip
    with pytest.raises(UsageError, match=r"b\.toml:4: 9 V is more"):
        open_bench(str(file))


# --- what it does


class Seen:
    """Every edge of a pin, with its bench time."""

    def __init__(self, emulated, pin="PA0", board="brain"):
        self.emulated = emulated
        self.pin = emulated.machines[board].chip.pins[pin]
        self.edges = []
        self.pin.on_edge(lambda _cycle, ns, level: self.edges.append((ns, level)))

    def after(self, seconds):
        self.emulated.bench.run_for(seconds)
        return self.edges


CYCLE_NS = 14
"""The chip takes what comes from outside at its next cycle."""


def about(edges, expected):
    assert [level for _, level in edges] == [level for _, level in expected]
    for (ns, _), (at_ns, _) in zip(edges, expected, strict=True):
        assert 0 <= ns - at_ns <= CYCLE_NS


def idle(_machine):
    pass


@pytest.fixture
def stimulated(emulate):
    """A board that does nothing, and these stimuli."""

    def make(*texts, more=""):
        emulated = emulate(idle, more=more)
        for text in texts:
            emulated.stimuli.add(parse_stimulus(text, emulated.bench_file.boards, Path()))
        return emulated

    return make


def test_levels_come_at_their_times(stimulated):
    seen = Seen(stimulated("1ms:PA0=1", "2.5ms:PA0=0/250us"))
    about(seen.after(0.01), [(MS, True), (2_500_000, False), (2_750_000, None)])


def test_a_level_is_there_from_the_start(stimulated):
    seen = Seen(stimulated("PA0=1"))
    about(seen.after(0.001), [(0, True)])


def test_it_is_repeated(stimulated):
    seen = Seen(stimulated("1ms+2ms*3:PA0=1/1ms"))
    about(seen.after(0.02), [(ms * MS, level) for ms, level in zip(range(1, 7), [True, None] * 3, strict=True)])


def test_a_square_wave_has_exact_edges(stimulated):
    seen = Seen(stimulated("1ms:PA0=3kHz/25%/1ms"))
    period = Fraction(10**9, 3000)
    rises = [(MS + int(period * n), True) for n in range(3)]
    falls = [(MS + int(period * n + period / 4), False) for n in range(3)]
    about(seen.after(0.01), [*sorted(rises + falls), (2 * MS, None)])


def test_the_next_one_for_the_same_pin_ends_a_wave(stimulated):
    seen = Seen(stimulated("PA0=1kHz", "1.25ms:PA0=1"))
    about(seen.after(0.01), [(0, True), (500_000, False), (MS, True)])


@given(
    ends=st.tuples(st.integers(0, 55), st.integers(0, 55)),
    in_us=st.integers(1, 400),
    look=st.fractions(0, 1),
)
def test_a_ramp_is_where_it_should_be(emulate_again, ends, in_us, look):
    first, last = (tenths / 10 for tenths in ends)
    emulated = emulate_again(f"1ms:PA0={first}V..{last}V/{in_us}us")
    emulated.bench.run_for(0.001 + float(look) * in_us * 1e-6)
    volts = emulated.machines["brain"].chip.pins["PA0"].volts
    elapsed = (emulated.bench.now_ns - MS) / (in_us * 1000)
    assert abs(volts - (first + (last - first) * elapsed)) <= 0.0001 + 2 * abs(last - first) * CYCLE_NS / in_us / 1000
    emulated.bench.run_for(0.001)
    assert emulated.machines["brain"].chip.pins["PA0"].volts == pytest.approx(last)


def test_a_ramp_changes_the_level_where_it_passes_the_thresholds(stimulated):
    """0.28 (VDD - 2 V) + 0.8 V and 0.41 (VDD - 2 V) + 1.3 V of 3.3 V (DS5319 section 5.3.14)."""
    seen = Seen(stimulated("PA0=0V", "1ms:PA0=0V..3.3V/1ms", "3ms:PA0=3.3V..0V/1ms"))
    up_ns, down_ns = (int(MS * part) for part in (1.833 / 3.3, 1 - 1.164 / 3.3))
    about([edge for edge in seen.after(0.01) if edge[0] > MS], [(MS + up_ns, True), (3 * MS + down_ns, False)])


@pytest.fixture(scope="module")
def emulate_again(tmp_path_factory):
    """The same as `stimulated`, for many in one test."""
    from tests.hilbench.mcu.conftest import IMAGE, ONE, FakeMachine

    folder = tmp_path_factory.mktemp("again")
    (folder / "a.bin").write_bytes(IMAGE)
    (folder / "b.toml").write_text(ONE)
    bench_file = open_bench(str(folder / "b.toml"))

    def make(text):
        emulated = EmulatedBench(bench_file, make_machine=lambda _board, _image: FakeMachine(idle))
        emulated.stimuli.add(parse_stimulus(text, bench_file.boards, Path()))
        return emulated

    return make


def test_bytes_come_at_their_time_and_at_the_rate_of_the_line(emulate):
    heard = []

    def program(machine):
        machine.usart("USART1", 9600, on_byte=lambda value: heard.append((machine.now_ns, value)))

    emulated = emulate(program)
    emulated.stimuli.add(parse_stimulus("5ms:usart1=ab", emulated.bench_file.boards, Path()))
    emulated.bench.run_for(0.02)
    assert [value for _, value in heard] == [*b"ab"]
    frame_ns = 10 * 10**9 // 9600
    for number, (ns, _) in enumerate(heard):  # a receiver is through at the middle of the stop bit
        assert 5 * MS + (number + 0.9) * frame_ns <= ns <= 5 * MS + (number + 1.01) * frame_ns


def test_what_happens_is_in_the_journal(stimulated):
    emulated = stimulated("1ms:PA0=1", "2ms:reset=press")
    emulated.bench.run_for(0.01)
    told = [event for event in emulated.bench.journal.recent if event["kind"] in {"stimulus", "reset"}]
    assert [(event["ns"], event["source"], event.get("text")) for event in told if event["kind"] == "stimulus"] == [
        (MS, "brain.PA0", "PA0=1"),
        (2 * MS, "brain.reset", "reset=press"),
    ]
    assert [event["reason"] for event in told if event["kind"] == "reset"] == ["PIN"]


def test_those_of_a_bench_file_happen(tmp_path, image):
    del image
    file = tmp_path / "with.toml"
    file.write_text('version = 1\nstimuli = ["1ms:PA0=1"]\n[targets.brain]\nboard = "bluepill"\nfirmware = "a.bin"\n')
    from tests.hilbench.mcu.conftest import FakeMachine

    seen = Seen(EmulatedBench(open_bench(str(file)), make_machine=lambda _board, _image: FakeMachine(idle)))
    about(seen.after(0.01), [(MS, True)])


def test_a_pin_that_something_drives_already_is_refused(stimulated):
    wire = '[[wires]]\nends = ["brain.PA0", "3v3"]\n'
    with pytest.raises(UsageError, match=r"PA0=1: 3v3 drives brain\.PA0 already"):
        stimulated("PA0=1", more=wire)


def test_a_pin_that_a_part_drives_is_refused(bench, bench_file):
    part = '[parts.eye]\nkind = "distance-switch"\npins = { out = "brain.PA0" }\nsignals = { range = "world.ray_1" }\n'
    read = bench_file(part)
    with pytest.raises(UsageError, match=r"eye\.out drives brain\.PA0 already"):
        Stimuli(bench, read, {}, {}).add(parse_stimulus("PA0=1", read.boards, Path()))


def test_a_line_that_has_another_end_is_refused(bench, bench_file):
    read = bench_file('[[links]]\nends = ["brain.usart1", "other.usart2"]\n', boards=2)
    with pytest.raises(UsageError, match=r"brain\.usart1 sends on the line of other\.usart2 already"):
        Stimuli(bench, read, {}, {}).add(parse_stimulus("other.usart2=x", read.boards, Path()))


def test_a_bus_that_is_not_there_is_refused(stimulated):
    with pytest.raises(UsageError, match="i2c9"):
        stimulated("i2c9=stuck")


def test_a_stuck_bus(tmp_path):
    emulated = EmulatedBench(open_target(f"nucleo-f767zi:{image_path('f767-demo')}"))
    board = boards_under_test(emulated)["nucleo-f767zi"]
    board.stimulate("1ms:i2c1=stuck/2ms")
    bus = board.i2c("I2C1")
    stuck = []
    for _ in range(4):
        board.run(0.00075)
        stuck.append(bus.stuck)
    assert stuck == [False, True, True, False]
    emulated.close()


def test_the_next_one_for_the_same_bus_counts(tmp_path):
    emulated = EmulatedBench(open_target(f"nucleo-f767zi:{image_path('f767-demo')}"))
    board = boards_under_test(emulated)["nucleo-f767zi"]
    board.stimulate("1ms:i2c1=stuck/2ms")
    board.stimulate("2ms:i2c1=stuck/3ms")
    stuck = []
    for _ in range(6):
        board.run(0.00099)
        stuck.append(board.i2c("I2C1").stuck)
    assert stuck == [False, True, True, True, True, False]
    emulated.close()


def test_in_a_test_the_time_is_counted_from_now(stimulated):
    emulated = stimulated("1ms:PA1=1")
    board = boards_under_test(emulated)["brain"]
    board.run(0.01)
    seen = Seen(emulated)
    board.stimulate("1ms:PA0=1")
    about(seen.after(0.01), [(11 * MS, True)])
    with pytest.raises(UsageError, match="stimulus: the board has no pin"):
        board.stimulate("PX0=1")


# --- what is written


def busy(machine):
    machine.usart("USART1")
    machine.send_all("USART1", b"@\\hi\r\n")
    machine.at_ns(20 * MS, lambda: machine.send_all("USART1", b"\0\xff"))
    machine.output("PC13")
    machine.at_ns(30 * MS, lambda: machine.chip.pins["PC13"].set_latch(True))
    machine.at_ns(40 * MS, lambda: machine.chip.pins["PC13"].configure(PadMode.INPUT, latch=False, pull=None))


def test_what_a_board_did_is_written_so_that_it_can_be_done(emulate, tmp_path, boards):
    file = tmp_path / "did.toml"
    emulated = emulate(busy)
    emulated.stimuli.add(parse_stimulus("35ms:PA3=1", emulated.bench_file.boards, Path()))
    writer = StimulusWriter(file, emulated)
    emulated.bench.run_for(0.1)
    assert tomllib.loads(file.read_text())  # whole at any time
    emulated.close()
    writer.close()
    lines = tomllib.loads(file.read_text())["stimuli"]
    assert "0.03s:PC13=1" in [line.replace("000013", "") for line in lines]
    assert any(line.endswith("s:PC13=z") for line in lines)
    sent = [parse_stimulus(line, emulated.bench_file.boards, Path()).action for line in lines if "usart1" in line]
    assert b"".join(action.data for action in sent) == b"@\\hi\r\n\0\xff"
    for line in lines:
        parse_stimulus(line, emulated.bench_file.boards, Path())


def test_a_fast_pin_is_written_as_a_square_wave(emulate, tmp_path):
    from tests.hilbench.mcu.test_pins import toggling

    file = tmp_path / "did.toml"
    emulated = emulate(toggling("PA8", 50_000, duty=0.3))
    writer = StimulusWriter(file, emulated)
    emulated.bench.run_for(0.25)
    emulated.close()
    writer.close()
    waves = [line for line in tomllib.loads(file.read_text())["stimuli"] if "Hz" in line]
    action = parse_stimulus(waves[0], emulated.bench_file.boards, Path()).action
    assert abs(action.hz - 20_000) < 10
    assert abs(action.duty - Fraction(3, 10)) < Fraction(1, 1000)


def test_a_square_wave_that_ends_is_written_to_its_end(emulate, tmp_path):
    def program(machine):
        machine.output("PA8")
        for edge in range(2001):
            level = not edge % 2
            machine.at_ns(edge * 25_000, lambda level=level: machine.chip.pins["PA8"].set_latch(level))

    file = tmp_path / "did.toml"
    writer = StimulusWriter(file, emulated := emulate(program))
    emulated.bench.run_for(0.35)
    emulated.close()
    writer.close()
    wave, end = tomllib.loads(file.read_text())["stimuli"][-2:]
    assert wave.startswith("0.1s:PA8=20000Hz")
    assert end == "0.2s:PA8=1"


def test_a_wave_of_a_clock_is_not_ended_by_the_level_it_begins_with(emulate, tmp_path):
    file = tmp_path / "did.toml"
    writer = StimulusWriter(file, emulated := emulate(idle))
    record = emulated.bench.record
    record("pwm", "brain.PA8", edges=0, in_ns=0, period_ns=125, high_ns=62, duty=0.5, level=False)
    record("pin", "brain.PA8", level=False)
    assert [line.partition("/")[0] for line in tomllib.loads(file.read_text())["stimuli"]] == ["0s:PA8=8000000Hz"]
    emulated.bench.run_for(0.001)
    record("pwm", "brain.PA8", edges=16_000, in_ns=MS, level=False)
    writer.close()
    assert tomllib.loads(file.read_text())["stimuli"][-1] == "0.001s:PA8=0"
    emulated.close()


def test_a_pin_that_is_too_fast_is_let_go(emulate, tmp_path):
    file = tmp_path / "did.toml"
    writer = StimulusWriter(file, emulated := emulate(idle))
    emulated.bench.record("pwm", "brain.PA8", period_ns=28, high_ns=14, duty=0.5)
    writer.close()
    assert "# 35714285.714286Hz/50%: faster than a stimulus may be" in file.read_text()
    assert tomllib.loads(file.read_text())["stimuli"] == ["0s:PA8=z"]
    emulated.close()


def test_a_short_pulse_has_its_duty(emulate, tmp_path):
    writer = StimulusWriter(tmp_path / "did.toml", emulated := emulate(idle))
    emulated.bench.record("pwm", "brain.PA8", period_ns=100 * MS, high_ns=14, duty=0.0)
    writer.close()
    (line,) = tomllib.loads((tmp_path / "did.toml").read_text())["stimuli"]
    assert parse_stimulus(line, emulated.bench_file.boards, Path()).action.duty == Fraction(14, 100 * MS)
    emulated.close()


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("pipe", "pipe: is not a regular file, and stimuli are written in place; name a file"),
        ("/dev/null", "/dev/null: is not a regular file"),
        ("/dev/stdout", "/dev/stdout: is "),
        ("folder", "folder: is a folder"),
        ("no/such/file", "/no/such; make it first"),
    ],
)
def test_what_cannot_hold_stimuli_is_refused_before_the_run(tmp_path, monkeypatch, capsys, name, words):
    monkeypatch.chdir(tmp_path)
    os.mkfifo("pipe")
    Path("folder").mkdir()
    code = main(["run", f"bluepill:{image_path('style-display')}", "--for", "1ms", "--write-stimuli", name])
    (line,) = capsys.readouterr().err.splitlines()
    assert code == 2
    assert words in line


def test_a_file_that_cannot_be_written_is_named(emulate, tmp_path):
    with pytest.raises(UnavailableError, match="stimuli cannot be written"):
        StimulusWriter(tmp_path / "no" / "file", emulate(idle))
