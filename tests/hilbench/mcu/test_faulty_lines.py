"""Faults of a bench file on the lines of emulated boards: each kind, each way, and whoever is at the far end."""

from __future__ import annotations

import json

import pytest

from hilbench.cli import main
from hilbench.links.port import PortBase
from hilbench.mcu.under_test import boards_under_test
from hilbench.serving.usart_doors import connect

LINE = '[[links]]\nends = ["peer", "brain.usart1"]\n'
OTHER_LINE = '[[links]]\nends = ["peer.other", "brain.usart2"]\n'


def fault(kind, **keys):
    return f'{LINE}{OTHER_LINE}[[faults]]\nkind = "{kind}"\n' + "".join(
        f"{key} = {value!r}\n" for key, value in keys.items()
    )


def echo(machine):
    machine.echo("USART1")
    machine.usart("USART2")


def echoed(emulated, data=b"0123"):
    """Return what the board heard and what came back of `data`, the same for who owns the far end and who looks on."""
    heard, came = [], []
    port = emulated.far_ends["brain.usart1"]
    line = boards_under_test(emulated)["brain"].usart("usart1")
    port.on_receive = lambda data, _at_ns: came.append(data)
    emulated.ports["brain.usart1"].heard_taps.append(lambda data, _at_ns: heard.append(data))
    emulated.bench.run_for(0.001)
    line.write(data)
    emulated.bench.run_for(0.01)
    assert line.data == b"".join(came)
    return b"".join(heard), line.data


@pytest.mark.parametrize(
    ("text", "heard", "came"),
    [
        (fault("flip", byte=1, bit=0, towards="brain.usart1"), b"0023", b"0023"),
        (fault("flip", byte=1, bit=0, towards="peer"), b"0123", b"0023"),
        (fault("drop", byte=2, **{"from": "peer"}), b"013", b"013"),
        (fault("duplicate", byte=0, towards="peer"), b"0123", b"00123"),
        (fault("disconnect", at_s=0, duration_s=1.0), b"", b""),
        (fault("disconnect", at_s=0.5, duration_s=1.0), b"0123", b"0123"),
        (fault("drop", byte=0, link=1, towards="brain.usart2"), b"0123", b"0123"),
    ],
)
def test_each_end_gets_what_the_fault_leaves(emulate, text, heard, came):
    assert echoed(emulate(echo, more=text)) == (heard, came)


BURST = bytes(range(40))
"""Written at 1 ms; at 115200 bit/s a byte takes 86.8 us."""


@pytest.mark.parametrize(
    ("text", "heard"),
    [
        (fault("drop", at_s=0.002, towards="brain.usart1"), BURST[:12] + BURST[13:]),
        (fault("truncate", at_s=0.002, towards="brain.usart1"), BURST[:12]),
        (fault("disconnect", at_s=0.002, duration_s=1.0), BURST[:12]),
    ],
)
def test_a_fault_strikes_what_is_on_the_line_by_then(emulate, text, heard):
    """And not what is written by then: a burst that is written at once takes its time."""
    assert echoed(emulate(echo, more=text), BURST)[0] == heard


def test_noise_ends_where_the_line_is_interrupted(emulate):
    interruption = '[[faults]]\nkind = "disconnect"\nat_s = 0.002\nduration_s = 1.0\n'
    noise = fault("noise", byte=1, count=100, towards="brain.usart1")
    emulated = emulate(echo, more=noise + interruption)
    heard, _ = echoed(emulated)
    assert (len(heard), heard[:1]) == (12, b"0")
    assert emulated.ports["brain.usart1"].counters.lost == 100 + 4 - 12


def test_the_time_of_a_byte_that_is_lost_passes(emulate):
    emulated = emulate(echo, more=fault("drop", byte=1, towards="brain.usart1"))
    starts_ns = []
    emulated.ports["brain.usart1"].heard_taps.append(lambda _data, at_ns: starts_ns.append(at_ns))
    echoed(emulated, b"0123")
    first_ns, second_ns, _ = starts_ns
    assert (second_ns - first_ns) * 115_200 // 1_000_000_000 == 20


def test_a_wrong_rate_garbles_what_the_board_hears(emulate):
    heard, _ = echoed(emulate(echo, more=fault("baud", at_s=0, duration_s=1.0, baud=57600, towards="brain.usart1")))
    assert heard
    assert heard != b"0123"


def test_noise_comes_beside_what_was_sent(emulate):
    heard, came = echoed(emulate(echo, more=fault("noise", byte=2, count=3, towards="brain.usart1")))
    assert (len(heard), heard[:2], heard[-2:]) == (7, b"01", b"23")
    assert came == heard


def test_a_break_reaches_the_board(emulate):
    frames = []

    def program(machine):
        echo(machine)
        usart = machine.chip.usarts["USART1"]
        usart.receive = lambda frame, receive=usart.receive: (frames.append(frame), receive(frame))

    emulated = emulate(program, more=fault("break", at_s=0.001, duration_s=0.002, towards="brain.usart1"))
    boards_under_test(emulated)
    emulated.bench.run_for(0.01)
    assert [(frame.bits, round(float(frame.bit_count * frame.bit_s), 3)) for frame in frames] == [(0, 0.002)]


def test_it_strikes_on_time_where_nobody_speaks(emulate):
    """Such as a break in `hilbench run` without --send; and not when somebody speaks for the first time."""
    emulated = emulate(echo, more=fault("break", at_s=0.001, duration_s=0.002, towards="brain.usart1"))
    emulated.bench.run_for(0.01)
    (struck,) = [event for event in emulated.bench.journal.recent if event["kind"] == "fault"]
    assert struck["ns"] == 1_000_000


def test_a_break_that_is_taken_back_leaves_the_next_one_as_it_is(emulate):
    frames = []

    def program(machine):
        echo(machine)
        usart = machine.chip.usarts["USART1"]
        usart.receive = lambda frame, receive=usart.receive: (frames.append(frame), receive(frame))

    emulated = emulate(program, more=LINE)
    port = emulated.ports["brain.usart1"]
    emulated.bench.run_for(0.001)
    port.write(b"01")
    port.send_break(5_000_000)
    port.withdraw(0)
    port.send_break(2_000_000)
    emulated.bench.run_for(0.02)
    assert [round(float(frame.bit_count * frame.bit_s), 3) for frame in frames if not frame.bits] == [0.002]


def test_what_strikes_is_in_the_journal_and_in_the_evidence(emulate):
    emulated = emulate(echo, more=fault("drop", byte=0, towards="peer"))
    echoed(emulated)
    (struck,) = [event for event in emulated.bench.journal.recent if event["kind"] == "fault"]
    assert (struck["number"], struck["fault"], struck["towards"]) == (0, "drop", "peer")
    (evidence,) = emulated.far_ends.faults.evidence()
    assert "fault drop" in evidence
    assert "struck (number 1)" in evidence


@pytest.mark.parametrize("reacts", [True, False])
@pytest.mark.parametrize(("towards", "us"), [("brain.usart1", 2041.68), ("peer", 2038.43)])
def test_it_is_in_the_journal_when_it_strikes(emulate, towards, us, reacts):
    """Even if the chip runs ahead of the bench, where nobody answers it."""
    emulated = emulate(echo, more=fault("drop", at_s=0.002, towards=towards))
    port = emulated.far_ends["brain.usart1"]
    emulated.bench.run_for(0.001)
    emulated.ports["brain.usart1"].reacts = reacts
    port.write(BURST)
    emulated.bench.run_for(0.02)
    (struck,) = [event for event in emulated.bench.journal.recent if event["kind"] == "fault"]
    assert struck["ns"] == pytest.approx(us * 1000, abs=50)


def test_a_client_of_a_served_board_gets_them(emulate):
    """A door hands on by the block what no fault decides on; with faults each byte is judged."""
    emulated = emulate(echo, more=fault("flip", byte=0, bit=0, towards="brain.usart1"))
    door, came = PortBase("door"), []
    door.baud, door.write = 115_200, came.append
    door.set_frame = lambda _baud, _bits: None
    connect(emulated, "brain.usart1", [door], lambda _text: None)
    emulated.bench.run_for(0.001)
    door.on_receive(b"0123", emulated.bench.now_ns)
    emulated.bench.run_for(0.01)
    assert b"".join(came) == b"1123"


@pytest.mark.slow("an emulated board in a whole check of a case")
def test_a_suite_on_the_real_board_fails_for_them_and_says_so(tmp_path, capsys):
    report = tmp_path / "report.json"
    faults = [f"--set=faults.0.{one}" for one in ("kind=drop", "probability=0.2", "towards=peer")]
    assert main(["check", "rover", "-k", "P02D", "-q", *faults, "--json", str(report)]) == 1
    found = json.loads(report.read_bytes())
    assert found["bench"]["faults"]
    assert "fault drop" in str(found["cases"])
    capsys.readouterr()
