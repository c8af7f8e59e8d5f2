"""The tests for hardware can be run: here on a pseudo-terminal that sends back what it gets."""

from __future__ import annotations

import functools
import importlib.util
import os
import pty
import re
import threading
from pathlib import Path

import pytest

from hilbench.clock import Scheduler
from hilbench.links import Line, MemoryLink, ReconnectingPort
from hilbench.ports.listing import PortInfo, UsbIdentity
from tests.hilbench.forked import ALREADY_IMPORTED, PATIENCE_S, PYTEST

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs/hardware-tests.md"


PATIENT = f"""\
import hilbench.doctor.calibrate as calibrate
calibrate._FIRST_NS = calibrate._LOST_NS = {PATIENCE_S} * 10**9
calibrate.ROUND_TRIPS = 20
{PYTEST}"""
"""A pytest for which no byte is lost because the host is late."""


@pytest.fixture
def run(forkable):
    def tests(port, attached):
        env = {"HILBENCH_HARDWARE_PORT": port, "HILBENCH_HARDWARE_WITH": attached}
        words = ("-q", "-p", "no:cacheprovider", *ALREADY_IMPORTED, "tests/hardware")
        return forkable.run(*words, program=PATIENT, cwd=ROOT, env=env)

    return tests


@pytest.fixture
def echoing_port():
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
    os.close(slave)
    thread.join()
    os.close(master)


@pytest.mark.exhaustive("calibrates a port, which doctor/test_calibrate does in the gate")
@pytest.mark.real_time("the tests of hardware, on a pseudo-terminal that echoes")
def test_they_hold_on_a_port_that_echoes(run, echoing_port):
    done = run(f"{echoing_port}@115200", "echo")
    assert done.returncode == 0, done.output + done.error
    assert re.search(r"\b4 passed, 8 skipped\b", done.output)
    assert "beyond the wire: " in done.output


def test_without_a_port_they_say_how_to_name_one(run):
    done = run("", "")
    assert done.returncode == 0
    assert "12 skipped" in done.output
    assert "see docs/hardware-tests.md" in done.output


def test_what_is_attached_is_a_word_that_is_known(run):
    done = run("/dev/ttyNONE", "plug, persn")
    assert done.returncode == pytest.ExitCode.USAGE_ERROR
    words = "echo, greeting, modem-plug, person, plug"
    assert f"HILBENCH_HARDWARE_WITH: nothing is called persn; there are {words}" in done.output + done.error


BOARD = UsbIdentity(vendor_id=0x0403, product_id=0x6001, serial_number="A50285BI", location="1-1.2")


@pytest.fixture
def desk(monkeypatch):
    """A desk without hardware, at which somebody pulls an adapter and plugs it in again when he is asked to."""
    monkeypatch.setenv("HILBENCH_HARDWARE_PORT", "/dev/ttyUSB7@115200")
    made = Desk(hardware_module("conftest"))
    monkeypatch.setattr(made.conftest, "list_ports", lambda: made.ports)
    return made


def hardware_module(name):
    spec = importlib.util.spec_from_file_location(f"of_hardware_{name}", ROOT / f"tests/hardware/{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


class Desk:
    def __init__(self, conftest):
        self.conftest = conftest
        self.ports = [PortInfo(device="/dev/ttyUSB7", usb=BOARD)]
        self.link = None
        self.attached = conftest.Attached(Scheduler())

    def open(self, scheduler, _target):
        self.link = MemoryLink(scheduler, Line(baud=115_200), name="usb")
        return self.link.a

    def tell(self, text):
        if text.startswith("pull"):
            self.ports = []
            self.link.hang_up()
        elif text.startswith("plug it in"):
            self.ports = [PortInfo(device="/dev/ttyUSB8", usb=BOARD)]


def test_an_adapter_that_comes_back_under_another_name_is_found_there(desk):
    reconnecting = functools.partial(ReconnectingPort, ports=lambda: desk.ports, open_port=desk.open)
    test = hardware_module("test_port").test_it_comes_back_when_it_is_plugged_in_again_wherever
    try:
        test(desk.attached, reconnecting, desk.tell)
    except pytest.skip.Exception as skipped:
        pytest.fail(f"left out: {skipped}")
    assert [port.device for port in desk.attached.opened] == ["/dev/ttyUSB8"]


def test_the_page_lists_each_of_them():
    tests = re.findall(r"^def (test_\w+)", (ROOT / "tests/hardware/test_port.py").read_text(), re.MULTILINE)
    listed = [name.rstrip("…") for name in re.findall(r"`(test_[\w…]+)`", PAGE.read_text())]
    assert [next(test for test in tests if test.startswith(name)) for name in listed] == tests
    assert set(re.findall(r"(?m)^\| `([\w-]+)` \|", PAGE.read_text())) == hardware_module("conftest").KNOWN
    words = set(re.findall(r"attached\((.*?)\)", (ROOT / "tests/hardware/test_port.py").read_text()))
    for word in re.findall(r'"([\w-]+)"', " ".join(words)):
        assert f"| `{word}` |" in PAGE.read_text()
