"""Firmware behind a real pty, talked to by pyserial in real time: a megabyte each way, latency, a hundred clients.

Run by `make soak`; the figures are printed. MCU_SOAK_BYTES sets another amount. What is asserted is what does not
depend on the host: no byte lost, none out of order, nothing but one power-on reset.
"""

from __future__ import annotations

import contextlib
import json
import os
import random
import re
import signal
import statistics
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
import serial

IMAGES = Path(__file__).parents[2] / "targets/firmware/images"
BYTES = int(os.environ.get("MCU_SOAK_BYTES", "1_000_000"))
CHUNK = 4096
PATIENCE_S = 60
CLIENTS = 100
LINES = 5
COUNT_LINE = re.compile(rb"messages (\d+) wrong 0 sum \d+\r?\n")
ROUND_TRIPS = 500


class Served:
    """`hilbench serve` in a process of its own, with USART1 at ``./u1``."""

    def __init__(self, image, folder):
        self.folder = folder
        command = [sys.executable, "-m", "hilbench", "serve", f"bluepill:{IMAGES / image}.elf"]
        command += ["--pty", "./u1", "--journal", "journal.jsonl"]
        self.process = subprocess.Popen(command, cwd=folder, stderr=subprocess.PIPE, text=True)
        while "stop with Ctrl-C" not in self.process.stderr.readline():
            assert self.process.poll() is None, "it did not come up"
        self._lines = []
        self._reader = threading.Thread(target=lambda: self._lines.extend(self.process.stderr))
        self._reader.start()

    def open(self, baud, **options):
        return serial.Serial(str(self.folder / "u1"), baud, timeout=PATIENCE_S, **options)

    def stop(self):
        """End it; return what it said of bench time and lateness."""
        self.process.send_signal(signal.SIGINT)
        assert self.process.wait(PATIENCE_S) == 0
        self.close()
        return next(line.strip() for line in self._lines if line.startswith("stopped after"))

    def close(self):
        """See that it is gone, and take what it still said."""
        self.process.kill()
        self.process.wait()
        self._reader.join()
        self.process.stderr.close()

    def resets(self):
        """Return the reasons of all resets so far."""
        events = map(json.loads, (self.folder / "journal.jsonl").read_text().splitlines()[1:])
        return [event["reason"] for event in events if event["kind"] == "reset"]


@pytest.fixture
def serve(tmp_path):
    with contextlib.ExitStack() as stack:

        def start(image):
            served = Served(image, tmp_path)
            stack.callback(served.close)
            return served

        yield start


def wake(port):
    """Wait until the firmware answers: before it has set up its USART the line is deaf."""
    port.timeout = 0.1
    for _ in range(100):
        port.write(b"?")
        if port.read(1):
            break
    while port.read(100):
        pass
    port.timeout = PATIENCE_S


@pytest.mark.parametrize("image", ["echo-irq-921600", "echo-dma"])
def test_a_megabyte_comes_back_as_it_was(serve, say, image):
    served = serve(image)
    data = random.Random(1).randbytes(BYTES)
    with served.open(921_600) as port:
        wake(port)
        began_s = time.monotonic()
        writer = threading.Thread(target=lambda: [port.write(data[at : at + CHUNK]) for at in range(0, BYTES, CHUNK)])
        writer.start()
        got = bytearray()
        while len(got) < BYTES:
            more = port.read(min(CHUNK, BYTES - len(got)))
            assert more, f"nothing more after {len(got)} bytes"
            got += more
        took_s = time.monotonic() - began_s
        writer.join()
    assert bytes(got) == data
    line_s = BYTES * 10 / 921_600
    say(
        f"{image}: {len(got)} bytes out and back in {took_s:.1f} s, {len(got) / took_s / 1000:.1f} kB/s each way; "
        f"{line_s:.1f} s on a line at 921600, real-time factor {line_s / took_s:.3f}; {served.stop()}"
    )
    assert served.resets() == ["POR"]


def test_how_long_an_echo_takes(serve, say):
    served = serve("echo-irq")
    times_ms = []
    with served.open(115_200) as port:
        wake(port)
        for number in range(ROUND_TRIPS):
            time.sleep(0.001 + number % 17 * 0.0003)
            began_s = time.monotonic()
            port.write(bytes((number & 0xFF,)))
            assert port.read(1)[0] == number & 0xFF
            times_ms.append((time.monotonic() - began_s) * 1000)
    quantiles = statistics.quantiles(times_ms, n=100)
    say(
        f"echo at 115200 over a pty, {ROUND_TRIPS} bytes: min {min(times_ms):.2f}, "
        f"median {statistics.median(times_ms):.2f}, p99 {quantiles[98]:.2f}, max {max(times_ms):.2f} ms "
        f"(0.17 ms of it on the line); {served.stop()}"
    )


def count_said(port):
    """Return the count of the first whole line.

    The first may have begun before the client came. A busy host may notice a client so late that it still gets bytes of
    before, which are thrown away in the middle of a line.
    """
    for _ in range(LINES):
        if whole := COUNT_LINE.fullmatch(port.read_until(b"\n")):
            return int(whole[1])
    raise AssertionError(f"no whole line among {LINES}")


def test_a_hundred_clients_find_the_same_board(serve, say):
    """The kernel image counts its messages: the count goes on from client to client."""
    served = serve("style-kernel")
    counts = []
    for _ in range(CLIENTS):
        with served.open(115_200) as port:
            counts.append(count_said(port))
    assert counts == sorted(counts)
    say(f"{CLIENTS} clients one after the other, messages {counts[0]} to {counts[-1]}; {served.stop()}")
    assert served.resets() == ["POR"]
