"""Serial lines of emulated boards: exact times, other rates, breaks, two boards, live input, a robot."""

from __future__ import annotations

from contextlib import closing, contextmanager
from types import SimpleNamespace

import pytest

from hilbench.journal import Journal
from hilbench.links import Line, Rfc2217Door
from hilbench.links.com_port import BreakSet, Bytes
from hilbench.serving.usart_doors import connect
from hilbench.testing import FakeHostClock

BYTE_NS = 625 * 10 * 10**9 // 72_000_000  # ten bits of 625 cycles: 115200 baud at 72 MHz


def listen(port):
    heard = []
    port.on_receive = lambda data, at_ns: heard.append((at_ns, data))
    return heard


def test_a_byte_arrives_when_its_stop_bit_ends(emulate):
    def program(machine):
        send = machine.usart("USART1")
        machine.at_ns(1_000_000, lambda: send(b"A"))

    emulated = emulate(program)
    heard = listen(emulated.ports["brain.usart1"])
    emulated.bench.run_for(0.01)
    start_ns = heard[0][0] - BYTE_NS
    # the transmitter starts with the next tick of its bit clock, and not before a preamble of one idle frame
    assert 1_000_000 <= start_ns <= 1_000_000 + 10_000
    assert heard[0][1] == b"A"


def test_a_reacting_bench_answers_on_the_very_nanosecond(emulate):
    """What is written at the end of a byte begins there, although the chip runs ahead of the bench."""
    frames = []

    def program(machine):
        machine.echo("USART1")
        usart = machine.chip.usarts["USART1"]
        usart.receive = lambda frame, receive=usart.receive: (frames.append(frame), receive(frame))

    emulated = emulate(program)
    port = emulated.ports["brain.usart1"]
    port.reacts = True
    turns = []

    def answer(data, at_ns):
        turns.append(at_ns)
        if len(turns) < 5:
            port.write(data)

    port.on_receive = answer
    emulated.bench.run_for(0.001)
    port.write(b"x")
    emulated.bench.run_for(0.01)
    starts = [int(frame.start_s * 10**9) for frame in frames]
    assert len(turns) == 5
    for at_ns, start_ns in zip(turns, starts[1:], strict=False):
        assert 0 <= start_ns - at_ns <= 14  # one cycle


def test_the_step_changes_nothing(emulate):
    def program(machine):
        machine.echo("USART1")
        machine.usart("USART2", 9600)
        machine.every(3_300_000, lambda: machine.send_all("USART2", b"tick"))
        machine.output("PC13")
        machine.every(5_000_000, lambda: machine.chip.pins["PC13"].set_latch(machine.chip.pins["PC13"].level is False))

    def trace(step_ns):
        emulated = emulate(program, step_ns=step_ns)
        emulated.bench.journal.begin_case("it", 0)
        emulated.bench.run_for(0.02)
        emulated.ports["brain.usart1"].write(b"hello")
        emulated.bench.run_for(0.04)
        return emulated.bench.journal.end_case(emulated.bench.now_ns)

    assert len({trace(step_ns) for step_ns in (1000, 100_000, 1_000_000, 7_777_777, 50_000_000)}) == 1


def test_a_receiver_at_another_rate_gets_garbage_as_on_a_wire(emulate):
    def program(machine):
        machine.usart("USART1", 9600)
        machine.send_all("USART1", b"UUUU\x00")

    emulated = emulate(program, more='[[links]]\nends = ["peer", "brain.usart1"]\nbaud = 19200\n')
    port = emulated.ports["brain.usart1"]
    heard = listen(port)
    emulated.bench.run_for(0.05)
    data = b"".join(data for _, data in heard)
    assert b"U" not in data
    assert data
    assert port.counters.framing_errors


def test_a_small_mismatch_is_no_mismatch(emulate):
    def program(machine):
        machine.usart("USART1", 113_000)
        machine.send_all("USART1", bytes(range(256)))

    emulated = emulate(program, more='[[links]]\nends = ["peer", "brain.usart1"]\nbaud = 115200\n')
    heard = listen(emulated.ports["brain.usart1"])
    emulated.bench.run_for(0.1)
    assert b"".join(data for _, data in heard) == bytes(range(256))


@pytest.mark.parametrize(
    ("baud", "usual"), [(115_384, 115_200), (9600, 9600), (12_345, 12_345), (2_250_000, 2_250_000)]
)
def test_an_end_without_a_rate_follows_the_usart(emulate, baud, usual):
    emulated = emulate(lambda machine: machine.usart("USART1", baud))
    port = emulated.ports["brain.usart1"]
    assert port.baud == 115_200
    emulated.bench.run_for(0.001)
    assert abs(port.baud - usual) <= 1


def test_parity_and_nine_bits_are_followed_too(emulate):
    even = 1 << 10 | 1 << 12

    def program(machine):
        machine.usart(
            "USART1", cr1=0x202C | even, on_byte=lambda value: machine.send_all("USART1", bytes([value & 0xFF]))
        )

    emulated = emulate(program)
    port = emulated.ports["brain.usart1"]
    heard = listen(port)
    emulated.bench.run_for(0.001)
    port.write(b"\x00\x01\x7f\xff")
    emulated.bench.run_for(0.01)
    assert b"".join(data for _, data in heard) == b"\x00\x01\x7f\xff"
    assert port.counters.framing_errors == 0


def test_a_break_each_way(emulate):
    got = []

    def program(machine):
        machine.usart("USART1", on_byte=got.append)
        usart = machine.chip.usarts["USART1"]
        machine.at_ns(2_000_000, lambda: usart.write(usart.REGISTERS[3].offset, 0x202D))  # SBK

    emulated = emulate(program)
    port = emulated.ports["brain.usart1"]
    breaks = []
    port.on_break = breaks.append
    emulated.bench.run_for(0.004)
    assert len(breaks) == port.counters.breaks == 1
    port.write(b"a")
    port.send_break(1_000_000)
    port.write(b"b")
    emulated.bench.run_for(0.01)
    assert got == [ord("a"), 0, ord("b")]


@contextmanager
def by_rfc2217(emulated, said):
    """Put a door of RFC 2217 at the far end of the line, in the time of a host in our hands."""
    port, scheduler = emulated.ports["brain.usart1"], emulated.bench.scheduler
    scheduler.lock(FakeHostClock())
    with closing(Rfc2217Door(scheduler, "127.0.0.1:0", Line(baud=port.baud), chip_time=port.chip_time)) as door:
        connect(emulated, "brain.usart1", [door], said.append)
        yield door
    scheduler.unlock()


def test_a_break_of_a_client_reaches_the_firmware_in_its_turn(emulate):
    got = []
    emulated = emulate(lambda machine: machine.usart("USART1", on_byte=got.append))
    emulated.bench.run_for(0.001)
    with by_rfc2217(emulated, []) as door:
        client, session = SimpleNamespace(input=None), SimpleNamespace(broken_ns=0)
        for event in (Bytes(b"abc"), BreakSet(True), BreakSet(False), Bytes(b"d")):
            door._obey(client, session, event, emulated.bench.now_ns)
        emulated.bench.run_for(0.02)
    assert bytes(got) == b"abc\0d"
    assert door.counters.breaks == 1


@pytest.mark.parametrize("knows_breaks", [True, False])
def test_a_break_of_the_firmware_reaches_a_client_or_is_said_not_to(emulate, knows_breaks, monkeypatch):
    monkeypatch.setattr(Rfc2217Door, "KNOWS_BREAKS", knows_breaks)

    def program(machine):
        machine.usart("USART1")
        usart = machine.chip.usarts["USART1"]
        for at_ns in (2_000_000, 4_000_000):
            machine.at_ns(at_ns, lambda: usart.write(usart.REGISTERS[3].offset, 0x202D))  # SBK

    emulated, said, told = emulate(program), [], []
    with by_rfc2217(emulated, said) as door:
        door._break_out = told.append
        door._outgoing._on_break = told.append
        emulated.bench.run_for(0.01)
    assert len(told) == (2 if knows_breaks else 0)
    assert len(said) == (0 if knows_breaks else 1)
    assert [event["kind"] for event in emulated.bench.journal.recent].count("break-refused") == len(said)


def test_what_is_taken_back_is_not_sent(emulate):
    got = []
    emulated = emulate(lambda machine: machine.usart("USART1", on_byte=got.append))
    port = emulated.ports["brain.usart1"]
    emulated.bench.run_for(0.001)
    port.write(b"0123456789")
    emulated.bench.run_for(BYTE_NS * 1.5 / 1e9)
    port.withdraw(1)
    emulated.bench.run_for(0.01)
    assert bytes(got) == b"01"
    assert port.counters.withdrawn == 8


def test_two_boards_on_one_line_lose_nothing_at_the_highest_rate(emulate):
    data = bytes(range(256))
    got = {"one": bytearray(), "other": bytearray()}

    def sender(name):
        def program(machine):
            machine.usart("USART1", 921_600, on_byte=got[name].append)
            machine.send_all("USART1", data)

        return program

    line = '[[links]]\nends = ["brain.usart1", "other.usart1"]\n'
    emulated = emulate(sender("one"), sender("other"), more=line)
    emulated.bench.run_for(0.01)
    assert got["one"] == got["other"] == data


def test_a_line_of_a_board_to_itself(emulate):
    got = []

    def program(machine):
        machine.usart("USART1")
        machine.usart("USART2", on_byte=got.append)
        machine.send_all("USART1", b"loop")

    emulated = emulate(program, more='[[links]]\nends = ["brain.usart1", "brain.usart2"]\n')
    emulated.bench.run_for(0.01)
    assert bytes(got) == b"loop"


def test_bytes_are_in_the_journal_by_the_chunk(emulate, tmp_path):
    def program(machine):
        machine.echo("USART1")

    emulated = emulate(program, journal=tmp_path / "j")
    emulated.bench.run_for(0.001)
    emulated.ports["brain.usart1"].write(b"hello")
    emulated.bench.run_for(0.1)
    emulated.close()
    recording = Journal.read(tmp_path / "j")
    assert recording.header["timing"] == {"brain": "flat"}
    assert set(recording.header["images"]["brain"]) == {"format", "sha256"}
    events = [
        (event["kind"], event["source"], bytes.fromhex(event["data"])) for event in recording.events if "data" in event
    ]
    assert sorted(events) == [("rx", "brain.usart1", b"hello"), ("tx", "brain.usart1", b"hello")]
    assert [event["ns"] for event in recording.events[:-1]] == sorted(event["ns"] for event in recording.events[:-1])


def test_a_board_talks_to_the_virtual_robot(emulate):
    """The firmware sends SYNC0 and gets its echo, 6 bytes at 9600 baud."""
    sync0 = bytes.fromhex("FAFB03000000")
    got = bytearray()

    def program(machine):
        machine.usart("USART2", 9600, on_byte=got.append)
        machine.at_ns(5_000_000, lambda: machine.send_all("USART2", sync0))

    emulated = emulate(
        program,
        more='[targets.robot]\nmodel = "pioneer-2dx"\n[world]\nphysics = "plane"\n'
        '[[links]]\nends = ["brain.usart2", "robot.host"]\n',
    )
    emulated.bench.run_for(0.1)
    assert bytes(got) == sync0
