"""The tests for hardware can be run: here on a pseudo-terminal that sends back what it gets."""

from __future__ import annotations

import os
import pty
import re
import subprocess
import sys
import threading
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs/hardware-tests.md"


def run(port, attached):
    env = {**os.environ, "HILBENCH_HARDWARE_PORT": port, "HILBENCH_HARDWARE_WITH": attached}
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "tests/hardware"]
    return subprocess.run(command, cwd=ROOT, env=env, capture_output=True, text=True, timeout=120)


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


def test_they_hold_on_a_port_that_echoes(echoing_port):
    done = run(f"{echoing_port}@115200", "echo")
    assert done.returncode == 0, done.stdout + done.stderr
    assert re.search(r"\b4 passed, 8 skipped\b", done.stdout)
    assert "beyond the wire: " in done.stdout


def test_without_a_port_they_say_how_to_name_one():
    done = run("", "")
    assert done.returncode == 0
    assert "12 skipped" in done.stdout
    assert "see docs/hardware-tests.md" in done.stdout


def test_the_page_lists_each_of_them():
    tests = re.findall(r"^def (test_\w+)", (ROOT / "tests/hardware/test_port.py").read_text(), re.MULTILINE)
    listed = [name.rstrip("…") for name in re.findall(r"`(test_[\w…]+)`", PAGE.read_text())]
    assert [next(test for test in tests if test.startswith(name)) for name in listed] == tests
    words = set(re.findall(r"attached\((.*?)\)", (ROOT / "tests/hardware/test_port.py").read_text()))
    for word in re.findall(r'"([\w-]+)"', " ".join(words)):
        assert f"| `{word}` |" in PAGE.read_text()
