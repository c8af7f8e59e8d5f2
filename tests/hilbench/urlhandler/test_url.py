"""A bench in the same process behind a URL of pyserial."""

from __future__ import annotations

import threading
from pathlib import Path

import pytest
import serial

import hilbench.urlhandler  # noqa: F401 - what it is imported for
from hilbench.errors import UsageError
from hilbench.links.bench_url import BenchUrl, parse_bench_url
from hilbench.mcu.command_line import open_target
from hilbench.urlhandler.runner import FastRunner, RealTimeRunner
from protocols.pkt import PROFILES, RequestTelemetry, encode_command, encode_frame
from tests.each import each

IMAGES = Path(__file__).parents[3] / "targets/firmware/images"
REQUEST = encode_frame(encode_command(RequestTelemetry()), PROFILES["documented"].client.frames)


@pytest.fixture
def opened():
    ports = []

    def open_url(url, baud=115_200, timeout=60, **more):
        ports.append(serial.serial_for_url(url, baud, timeout=timeout, **more))
        return ports[-1]

    before = threading.active_count()
    yield open_url
    for port in ports:
        port.close()
        port.close()
    assert threading.active_count() == before


@each(
    ("url", "means"),
    [
        ("hilbench://pioneer", BenchUrl(what="pioneer")),
        ("hilbench://bluepill?image=/c++/f%20w.elf", BenchUrl(what="bluepill:/c++/f w.elf")),
        ("hilbench://bluepill?image=/a/fw.elf&line=usart2", BenchUrl(what="bluepill:/a/fw.elf", line="usart2")),
        ("hilbench:///dir/my%20bench.toml?seed=7&fast", BenchUrl(what="/dir/my bench.toml", seed=7, fast=True)),
        ("HILBENCH://rover-model?fast=0", BenchUrl(what="rover-model")),
        ("hilbench://./bench.toml?fast=1", BenchUrl(what="./bench.toml", fast=True)),
    ],
)
def test_urls(url, means):
    assert parse_bench_url(url) == means


def test_faults_of_a_bench_file_are_on_the_line(opened, tmp_path):
    file = tmp_path / "noisy.toml"
    file.write_text(
        'version = 1\n[targets.robot]\nmodel = "pioneer-2dx"\n[[links]]\nends = ["peer", "robot.host"]\n'
        '[[faults]]\nkind = "drop"\nbyte = 2\nfrom = "robot.host"\n'
    )
    port = opened(f"hilbench://{file}?fast", 9600, timeout=0.2)
    sync0 = bytes.fromhex("FAFB03000000")
    for answer in (sync0[:2] + sync0[3:], sync0):
        port.write(sync0)
        assert port.read(64) == answer


@each(
    "url",
    [
        "hilbench://",
        "socket://x",
        "hilbench://pioneer?sped=1",
        "hilbench://pioneer?seed=x",
        "hilbench://p?fast=2",
        "hilbench://[",
    ],
)
def test_wrong_urls(url):
    with pytest.raises(UsageError):
        parse_bench_url(url)


@pytest.mark.parametrize(
    ("url", "words"),
    [
        ("hilbench://piooner", "pioneer"),
        ("hilbench://bluepil?image=x.elf", "no board"),
        ("hilbench://bluepill?image=/nonexistent.elf&fast", "nonexistent"),
        ("hilbench://rover-model?line=usart9", "no such line"),
        ("hilbench://rover-model?line=usart9&fast", "no such line"),
    ],
)
def test_what_is_wrong_is_said_as_pyserial_says_it(opened, url, words):
    with pytest.raises(serial.SerialException, match=words):
        opened(url)


@pytest.mark.parametrize("how", ["", "?fast"])
def test_a_rover_answers(opened, how):
    port = opened(f"hilbench://rover-model{how}")
    port.write(REQUEST)
    assert port.read(4) == b"PKT!"
    assert (port.cts, port.dsr, port.cd, port.ri) == (True, True, True, False)
    port.flush()
    assert port.out_waiting == 0
    assert port.read(20)
    port.reset_output_buffer()
    port.reset_input_buffer()
    port.dtr = port.rts = False
    port.break_condition = True
    port.break_condition = False


def test_in_fast_mode_a_timeout_is_bench_time_and_runs_are_alike(opened):
    def heard():
        port = opened("hilbench://rover-model?fast&seed=3", timeout=60)
        port.write(REQUEST)
        return port.read(20_000)

    first = heard()
    assert len(first) > 1000
    assert heard() == first


def test_a_rate_that_is_not_the_lines_makes_garbage(opened):
    port = opened("hilbench://rover-model?fast", baud=57_600, timeout=2)
    assert b"PKT!" not in port.read(500)
    port.baudrate = 115_200
    assert b"PKT!" in port.read(500)


@pytest.mark.parametrize("how", ["", "&fast"])
def test_firmware_on_an_emulated_board(opened, how):
    port = opened(f"hilbench://bluepill?image={IMAGES / 'echo-irq.elf'}{how}", timeout=0.05)
    for _ in range(1200):  # before it has set up its USART the line is deaf
        port.write(b"?")
        if port.read(1):
            break
    port.timeout = 60
    port.write(b"hello")
    assert port.read_until(b"hello").endswith(b"hello")


def test_a_read_that_waits_can_be_cancelled_and_a_closed_port_says_so(opened):
    port = opened("hilbench://rover-model", timeout=None)
    got = []
    reader = threading.Thread(target=lambda: got.append(port.read(10**6)))
    reader.start()
    port.cancel_read()
    reader.join(60)
    assert not reader.is_alive()
    port.close()
    for action in (port.read, lambda: port.in_waiting, lambda: port.cts, lambda: port.ri, lambda: port.write(b"x")):
        with pytest.raises(serial.PortNotOpenError):
            action()


def test_a_read_is_cancelled_once():
    runner = RealTimeRunner(open_target("rover-model"), line="", baud=115_200, seed=0)
    runner.cancel()
    runner.read(10**6, 60)
    runner.write(REQUEST)
    assert len(runner.read(14, 60)) == 14  # the one before it was cancelled, and this one waits
    runner.close()


@pytest.mark.parametrize("how", [RealTimeRunner, FastRunner])
def test_what_came_before_the_end_is_read_before_the_end_is_told(opened, how):
    port = opened("hilbench://rover-model" if how is RealTimeRunner else "hilbench://rover-model?fast", timeout=60)
    port.write(REQUEST)
    assert isinstance(port._runner, how)
    port.read(1)
    port._runner._came[:] = b"last"
    port._runner.failure = "the firmware has ended"
    assert port.read(4) == b"last"
    with pytest.raises(serial.SerialException, match="the firmware has ended"):
        port.read(1)
    with pytest.raises(serial.SerialException, match="the firmware has ended"):
        port.write(b"x")


def test_an_open_port_is_not_opened_again(opened):
    port = opened("hilbench://rover-model?fast")
    with pytest.raises(serial.SerialException, match="already open"):
        port.open()


def test_our_own_commands_take_it_as_a_target():
    from hilbench.clock import MonotonicHostClock, Scheduler
    from hilbench.links import SerialPort

    scheduler, host = Scheduler(), MonotonicHostClock()
    scheduler.lock(host)
    port = SerialPort(scheduler, "hilbench://rover-model@115200")
    got = bytearray()
    port.on_receive = lambda data, at_ns: got.extend(data)
    port.write(REQUEST)
    assert scheduler.run_until(lambda: b"PKT!" in got, 60 * 10**9)
    port.close()
    host.close()
