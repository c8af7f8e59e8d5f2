from __future__ import annotations

import json
import os
import pty
import threading
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hilbench.cli import main
from hilbench.clock import NS_PER_MS, NS_PER_S, Scheduler
from hilbench.doctor.calibrate import Calibrated, _quantile, calibrate, measure
from hilbench.doctor.calibrated import as_text
from hilbench.errors import UnavailableError
from hilbench.ports.calibration import Calibration, calibration_of, keep, key_of, port_at, state_folder, stored
from hilbench.ports.listing import PortInfo, UsbIdentity
from hilbench.testing import FakeHostClock, link_pair
from tests.each import each

WIRE_S = 10 / 9600


@pytest.fixture(autouse=True)
def state(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    return tmp_path / "state/hilbench"


class Line:
    """A line on a fake clock, with something at its far end."""

    def __init__(self):
        self.clock, self.scheduler = FakeHostClock(), Scheduler()
        self.near, self.far = link_pair(self.scheduler, baud=9600)
        self.scheduler.lock(self.clock)

    def echo(self, delays_ns=(0,), change=lambda data: data):
        delays = iter([])
        sent = []

        def answer(data, _at_ns):
            nonlocal delays
            delay = next(delays, None)
            if delay is None:
                delays = iter(delays_ns)
                delay = next(delays)
            sent.append(data)
            self.scheduler.after(delay, lambda: self.far.write(change(data)))

        self.far.on_receive = answer
        return sent

    def measure(self, trips=20):
        return measure(self.scheduler, self.clock, self.near, key="k", latency_ms=None, trips=trips)


@pytest.fixture
def line():
    made = Line()
    yield made
    made.scheduler.unlock()


def made(**changes):
    return Calibration(
        **{
            "key": "/dev/ttyS0", "target": "/dev/ttyS0", "measured_at": "2026-01-01T00:00:00+00:00", "baud": 9600,
            "round_trips": 200, "lost": 0, "wire_s": WIRE_S, "excess_p50_s": 0.001, "excess_p99_s": 0.002,
            "excess_max_s": 0.003, "jitter_s": 0.0025, "paced_bytes": 240, "paced_returned": 240,
            "paced_expected_s": 0.25,
            "paced_measured_s": 0.26,
        } | changes
    )  # fmt: skip


def test_an_echo_is_measured_to_the_nanosecond(line):
    """Firmware that echoes has a byte on the wire a second time, and that stays in the figure."""
    line.echo(delays_ns=[3 * NS_PER_MS] * 19 + [8 * NS_PER_MS])
    found = line.measure(trips=40)
    assert (found.round_trips, found.lost) == (40, 0)
    assert found.wire_s == pytest.approx(WIRE_S, abs=1e-9)
    assert found.excess_p50_s == pytest.approx(0.003 + WIRE_S, abs=1e-9)
    assert found.excess_p99_s == found.excess_max_s == pytest.approx(0.008 + WIRE_S, abs=1e-9)
    assert found.jitter_s == pytest.approx(0.005, abs=1e-9)
    assert found.uncertainty_s == found.excess_max_s


def test_a_block_at_the_pace_of_the_line_has_no_pacing_error(line):
    line.echo()
    found = line.measure()
    assert (found.baud, found.paced_bytes) == (9600, 240)
    assert found.paced_expected_s == pytest.approx(239 * WIRE_S, abs=1e-9)
    assert found.paced_returned == 240
    assert found.pacing_error == pytest.approx(0, abs=1e-6)


def test_a_block_that_comes_back_in_part_has_no_pace_and_it_is_said_how_far_it_was_right(line):
    count = 0

    def change(data):
        nonlocal count
        count += 1
        return b"?" if count == 100 else data

    line.echo(change=change)
    found = line.measure()
    assert (found.paced_measured_s, found.pacing_error, found.paced_returned) == (None, None, 99 - 1 - 20)


def test_a_line_that_is_too_slow_has_one(line):
    line.echo()
    line.near.wire_baud = 9500
    line.far.baud = 9600
    found = line.measure()
    assert found.pacing_error == pytest.approx(9600 / 9500 - 1, rel=1e-3)


def test_an_adapter_that_hands_on_several_bytes_at_a_time_keeps_its_pace(line):
    """As USB bridges do: what counts is what came behind the first piece."""
    held = bytearray()

    def hold(data, _at_ns):
        held.extend(data)
        if len(held) == len(data):
            line.scheduler.after(16 * NS_PER_MS, hand_on)

    def hand_on():
        deliver(bytes(held), line.scheduler.now_ns)
        held.clear()

    line.echo()
    deliver, line.near._deliver = line.near._deliver, hold
    found = line.measure()
    assert found.wire_s == pytest.approx(WIRE_S, abs=1e-9)
    assert found.excess_max_s == pytest.approx(0.016 + WIRE_S, abs=1e-9)
    assert abs(found.pacing_error) < 0.08


def test_where_nothing_comes_back_it_says_what_to_attach(line):
    with pytest.raises(UnavailableError, match="nothing comes back at 9600 baud; attach a plug that joins TX and RX"):
        line.measure()


@pytest.mark.parametrize("change", [lambda data: b"?" * len(data), lambda data: data + b"\r\n"], ids=["other", "more"])
def test_what_is_no_echo_is_told_apart(line, change):
    line.echo(change=change)
    with pytest.raises(UnavailableError, match=r"what comes back is not what was sent: .*is 9600 baud right"):
        line.measure()


def test_a_board_that_greets_is_let_finish(line):
    def greet(left=5):
        line.far.write(b"hello\r\n")
        if left:
            line.scheduler.after(60 * NS_PER_MS, lambda: greet(left - 1))

    line.echo()
    greet()
    assert line.measure().lost == 0


def test_a_board_that_never_stops_talking_is_not_waited_for_for_ever(line):
    def talk():
        line.far.write(b"x")
        line.scheduler.after(50 * NS_PER_MS, talk)

    talk()
    with pytest.raises(UnavailableError, match="is not what was sent"):
        line.measure()
    assert line.scheduler.now_ns < 10 * NS_PER_S


def test_bytes_that_are_lost_are_counted_and_not_taken_for_later_ones(line):
    line.echo(delays_ns=[0, 0, 0, NS_PER_S])
    found = line.measure(trips=16)
    assert found.lost > 0
    assert found.round_trips + found.lost == 16
    assert found.excess_max_s < 0.25


@given(st.lists(st.integers(0, 1000), min_size=1), st.floats(0.01, 1))
def test_a_quantile_is_not_exceeded_by_its_share_and_is_the_least_such_value(values, share):
    ordered = sorted(values)
    found = _quantile(ordered, share)
    assert found in ordered
    assert sum(value <= found for value in ordered) >= share * len(ordered) - 1e-9
    assert sum(value < found for value in ordered) < share * len(ordered) + 1e-9


# --- what is kept


def test_what_is_kept_is_found_again(state):
    path = keep(made())
    assert path.parent == state / "calibrations"
    assert stored("/dev/ttyS0") == made()
    keep(made(baud=115200))
    assert stored("/dev/ttyS0").baud == 115200
    assert len(list(path.parent.iterdir())) == 1


@pytest.mark.parametrize("text", ["", "{}", '{"format": 1, "key": 3}', "\0"])
def test_a_file_that_is_none_counts_for_nothing(state, text):
    keep(made()).write_text(text)
    assert stored("/dev/ttyS0") is None


def test_another_format_counts_for_nothing(state):
    keep(made(format=99))
    assert stored("/dev/ttyS0") is None


def test_keys_that_look_alike_have_files_of_their_own(state):
    keep(made(key="/dev/a b"))
    assert stored("/dev/a-b") is None


def test_where_nothing_can_be_kept_it_says_so(monkeypatch):
    monkeypatch.setenv("XDG_STATE_HOME", "/proc/nowhere")
    with pytest.raises(UnavailableError, match=r"cannot be written.*XDG_STATE_HOME"):
        keep(made())


@pytest.fixture
def homeless(monkeypatch):
    """Be a user whose number has no account, without HOME: a container that runs under any number."""

    def unknown(number):
        raise KeyError(number)

    monkeypatch.delenv("XDG_STATE_HOME")
    monkeypatch.delenv("HOME", raising=False)
    monkeypatch.setattr("pwd.getpwuid", unknown)


def test_without_a_home_nothing_is_kept_and_nothing_found(homeless):
    assert state_folder() is None
    assert stored("/dev/ttyS0") is None
    assert calibration_of("/dev/ttyS0", []) is None
    with pytest.raises(UnavailableError, match=r"there is no home directory to store it in; export XDG_STATE_HOME=DIR"):
        keep(made())


def test_what_was_measured_is_told_also_if_it_cannot_be_kept(monkeypatch, capsys):
    monkeypatch.setenv("XDG_STATE_HOME", "/proc/nowhere")
    monkeypatch.setattr("hilbench.doctor.calibrate._measure_at", lambda *_: made())
    assert main(["doctor", "--calibrate", "/dev/ttyS0@9600"]) == 0
    out = capsys.readouterr().out
    assert "beyond the wire  1.00 ms (half)" in out
    assert "kept             not kept: /proc/nowhere/hilbench/calibrations/" in out
    assert "cannot be written" in out
    assert main(["doctor", "--calibrate", "/dev/ttyS0@9600", "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert (data["round_trips"], data["kept"]) == (200, None)
    assert "cannot be written" in data["why_not_kept"]


def test_a_path_that_is_not_absolute_is_ignored(monkeypatch):
    monkeypatch.setenv("XDG_STATE_HOME", "here")
    monkeypatch.setenv("HOME", "/home/somebody")
    assert state_folder() == Path("/home/somebody/.local/state/hilbench")


USB = UsbIdentity(vendor_id=0x0403, product_id=0x6001, serial_number="A1", location="1-1", interface=1)
WITHOUT_NUMBER = UsbIdentity(vendor_id=0x1A86, product_id=0x7523, location="1-1.2")


@each(
    ("url", "usb", "key"),
    [
        ("/dev/ttyUSB0", USB, "usb=0403:6001,serial=A1,interface=1"),
        ("/dev/ttyUSB0", WITHOUT_NUMBER, "usb=1a86:7523,location=1-1.2,interface=0"),
        ("/dev/ttyUSB0", None, "/dev/ttyUSB0"),
        ("socket://host:8101", None, "socket://host:8101"),
        ("/dev/pts/3", None, None),
    ],
)
def test_a_port_is_known_by_what_lasts(url, usb, key):
    assert key_of(url, [PortInfo(device="/dev/ttyUSB0", usb=usb)]) == key


def test_a_link_to_a_port_is_the_port(tmp_path):
    device = tmp_path / "ttyUSB0"
    device.touch()
    (tmp_path / "link").symlink_to(device)
    ports = [PortInfo(device=str(device), usb=USB)]
    assert port_at(str(tmp_path / "link"), ports) is ports[0]
    assert key_of(str(tmp_path / "link"), ports) == key_of(str(device), ports)
    assert port_at(str(tmp_path / "other"), ports) is None


@pytest.mark.parametrize(("now_ms", "holds"), [(1, True), (16, False), (None, False)])
def test_a_calibration_holds_as_long_as_the_latency_timer_does(now_ms, holds):
    keep(made(key=key_of("/dev/ttyUSB0", [PortInfo(device="/dev/ttyUSB0", usb=USB)]), latency_ms=1))
    ports = [PortInfo(device="/dev/ttyUSB4", usb=USB, latency_ms=now_ms)]
    assert (calibration_of("/dev/ttyUSB4", ports) is not None) == holds
    assert calibration_of("/dev/ttyUSB4", []) is None


# --- the command


@pytest.fixture
def echoing_port(monkeypatch):
    """A pseudo-terminal whose far end sends back what it gets, and that passes for a USB adapter."""
    master, slave = pty.openpty()

    def echo():
        while True:
            try:
                os.write(master, os.read(master, 4096))
            except OSError:
                return

    thread = threading.Thread(target=echo)
    thread.start()
    yield os.ttyname(slave)
    os.close(slave)  # the last one: reading the master ends with an error, and with it the thread
    thread.join()
    os.close(master)


def test_a_port_is_measured_and_kept(echoing_port, monkeypatch, capsys, state):
    ports = [PortInfo(device=echoing_port, usb=USB, latency_ms=1)]
    monkeypatch.setattr("hilbench.doctor.calibrate.ROUND_TRIPS", 20)
    monkeypatch.setattr("hilbench.doctor.calibrate.list_ports", lambda: ports)
    assert main(["doctor", "--calibrate", "serial:serial=A1@115200", "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert (data["baud"], data["round_trips"] + data["lost"], data["latency_ms"]) == (115200, 20, 1)
    assert data["wire_s"] == 0  # a pseudo-terminal has none, and then nothing is taken off
    assert data["key"] == "usb=0403:6001,serial=A1,interface=1"
    assert data["uncertainty_s"] == data["excess_max_s"] >= data["excess_p99_s"] >= data["excess_p50_s"] >= 0
    assert Path(data["kept"]).parent == state / "calibrations"
    assert calibration_of(echoing_port, ports).uncertainty_s == data["uncertainty_s"]


def test_what_cannot_be_known_again_is_measured_and_not_kept(echoing_port, monkeypatch, capsys, state):
    monkeypatch.setattr("hilbench.doctor.calibrate.ROUND_TRIPS", 5)
    assert main(["doctor", "--calibrate", f"{echoing_port}@115200"]) == 0
    assert "not kept: a pseudo-terminal cannot be known again" in capsys.readouterr().out
    assert not state.exists()


def test_where_bytes_are_lost_nothing_is_kept(monkeypatch, state):
    """The worst round trip is not known then."""
    monkeypatch.setattr("hilbench.doctor.calibrate._measure_at", lambda *_: made(lost=2))
    done = calibrate("/dev/ttyS0@9600", list)
    assert (done.kept, state.exists()) == (None, False)
    assert "not kept: 2 bytes did not come back" in as_text(done)


@pytest.mark.parametrize(
    ("port", "code", "said"),
    [
        ("/dev/ttyNONE@9600", 3, "/dev/ttyNONE: there is no such port"),
        ("serial:serial=Z9", 3, "no "),
        ("x=1", 2, "'x='"),
    ],
)
def test_a_port_that_is_not_there_is_refused(port, code, said, capsys):
    assert main(["doctor", "--calibrate", port]) == code
    assert said in capsys.readouterr().err


def test_it_is_told_to_a_person():
    text = as_text(Calibrated(calibration=made(lost=3), kept=Path("/s/k.json")))
    assert text.splitlines() == [
        "port             /dev/ttyS0 at 9600 baud (/dev/ttyS0)",
        "came back        200 single bytes, 3 lost",
        "beyond the wire  1.00 ms (half), 2.00 ms (99 %), 3.00 ms (the worst)",
        "jitter           2.50 ms from the fastest to the slowest",
        "pacing           a block of 240 bytes came back in 260.00 ms, on a wire it needs 250.00 ms (+4.00%)",
        "verdicts         times at this port are uncertain by 3.00 ms more than the bench is late",
        "kept             /s/k.json",
    ]
    assert "no wire of that rate" in as_text(Calibrated(calibration=made(wire_s=0.0), kept=None))
    part = made(paced_measured_s=None, paced_returned=17)
    assert "of a block of 240 bytes the first 17 came back as they" in as_text(Calibrated(calibration=part, kept=None))
