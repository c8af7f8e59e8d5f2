"""A real port: who it is, that opening it disturbs nothing, what it carries, and that it comes back."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from hilbench.doctor.calibrate import calibrate
from hilbench.doctor.rules_explained import outcome_at
from hilbench.errors import UnavailableError
from hilbench.files.host import this_host
from hilbench.links.serial_target import located
from hilbench.ports.calibration import key_of
from hilbench.ports.choice import choose_port, parse_port_choice
from hilbench.ports.listing import list_ports
from hilbench.ports.usb_devices import kind_of
from hilbench.udev.installing import check_rules, rules_text

ECHOES = pytest.mark.attached("plug", "modem-plug", "echo")
SENTENCE = b"The quick brown fox jumps over the lazy dog 0123456789. "


def test_the_device_says_who_it_is_and_is_chosen_by_that(attached):
    assert attached.usb.vendor_id
    choice = parse_port_choice(attached.state.target.removeprefix("serial:"))
    assert choose_port(choice, list_ports()).device == attached.state.port.device


def test_the_rules_give_it_access_and_the_names_they_promise(attached):
    host = this_host()
    if attached.usb and kind_of(attached.usb) is None:
        pytest.skip("the rules do not know this device")
    if not check_rules(host).right:
        pytest.skip("the rules are not installed: hilbench udev --check")
    promised = [f"/dev/{link}" for link in outcome_at(rules_text(), attached.state.port).links]
    assert attached.state.permitted
    assert promised
    for link in promised:
        assert os.path.realpath(link) == attached.state.port.device
    assert any(link.startswith("/dev/hilbench/at-") for link in attached.state.port.links)


def test_an_ftdi_chip_hands_on_a_byte_after_a_millisecond(attached):
    latency_ms = attached.state.port.latency_ms if attached.usb else None
    if latency_ms is None:
        pytest.skip("no FTDI chip")
    assert latency_ms == 1


def test_a_second_program_is_refused_and_told_who_holds_it(attached):
    attached.open()
    program = "import sys; from hilbench.cli import main; sys.exit(main())"
    words = ["doctor", "--calibrate", f"{located(attached.target).url}@9600"]
    done = subprocess.run([sys.executable, "-c", program, *words], capture_output=True, text=True, timeout=60)
    assert done.returncode == 3
    assert "another program" in done.stderr
    if attached.state is not None:
        assert os.getpid() in [one.process for one in attached.state.holders.programs]


@ECHOES
def test_what_is_sent_comes_back(attached):
    port = attached.open()
    attached.run(None, 0.5)  # a board that was reset may greet
    port.got.clear()
    port.write(SENTENCE * 10)
    attached.run(lambda: len(port.got) >= 560, 60)
    assert bytes(port.got) == SENTENCE * 10
    errors = port.counters
    assert (errors.framing_errors, errors.lost, errors.breaks) == (0, 0, 0)


@ECHOES
def test_it_can_be_calibrated(attached, tmp_path, monkeypatch, tell):
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    url = located(attached.target).url
    done = calibrate(f"{url}@{attached.target.baud}")
    found = done.calibration
    tell(f"beyond the wire: {found.excess_p50_s * 1000:.2f} ms (half), {found.excess_max_s * 1000:.2f} ms (worst)")
    assert found.lost == 0
    assert (done.kept is not None) == (key_of(url, list_ports()) is not None)
    if attached.state is not None and attached.state.port.usb is not None:
        assert abs(found.pacing_error) < 0.05


@pytest.mark.attached("modem-plug")
def test_the_lines_beside_the_data_are_set_and_read(attached):
    port = attached.open()
    for dtr, rts in [(False, False), (True, False), (False, True), (True, True)]:
        port.set_lines(dtr=dtr, rts=rts)
        attached.run(None, 0.1)
        lines = port.modem_lines
        assert (lines.dtr, lines.rts, lines.dsr, lines.cts) == (dtr, rts, dtr, rts)


@pytest.mark.attached("plug", "modem-plug")
def test_a_break_is_heard_at_the_other_end(attached):
    port = attached.open()
    breaks = []
    port.on_break = breaks.append
    port.send_break(20_000_000)
    attached.run(lambda: bool(breaks), 2)
    assert breaks


@pytest.mark.attached("greeting")
def test_opening_it_again_does_not_reset_the_board(attached):
    """The first time may: Linux asserts DTR and RTS when a port is opened. From then on they stay."""
    port = attached.open()
    attached.run(None, 5)
    port.close()
    again = attached.open()
    attached.run(lambda: bool(again.got), 5)
    assert bytes(again.got) == b""


def test_after_a_kill_the_port_is_free(attached):
    program = (
        "import os, serial; p = serial.Serial(os.environ['PORT'], exclusive=True); print('open', flush=True); input()"
    )
    url = located(attached.target).url
    command, env = [sys.executable, "-c", program], {**os.environ, "PORT": url}
    with subprocess.Popen(command, env=env, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as holder:
        try:
            assert holder.stdout.readline() == b"open\n"
            with pytest.raises(UnavailableError, match="another program"):
                attached.open()
        finally:
            holder.kill()
    attached.open()


@pytest.mark.attached("person")
def test_it_comes_back_when_it_is_plugged_in_again_wherever(attached, reconnecting, tell):
    port = attached.open(reconnecting)
    before = attached.usb
    tell(f"pull {port.device} within 30 s")
    assert attached.run(lambda: not port.line_is_up, 30)
    tell("plug it in again within 60 s, at another socket if it has a serial number")
    assert attached.run(lambda: port.line_is_up, 60)
    tell(f"back at {port.device}")
    assert attached.state_at(port.device).port.usb.is_same_kind(before)
    assert port.losses == 1


@pytest.mark.attached("person")
@ECHOES
def test_after_it_came_back_it_carries_bytes(attached, reconnecting, tell):
    port = attached.open(reconnecting)
    tell(f"pull {port.device} within 30 s, and plug it in again within 60 s")
    assert attached.run(lambda: not port.line_is_up, 30)
    assert attached.run(lambda: port.line_is_up, 60)
    attached.run(None, 0.5)
    port.got.clear()
    port.write(SENTENCE)
    attached.run(lambda: len(port.got) >= len(SENTENCE), 5)
    assert bytes(port.got) == SENTENCE
