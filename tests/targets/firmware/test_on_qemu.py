"""A second opinion on the self-tests of the core: QEMU passes them too, the checks that our chip fails included."""

from __future__ import annotations

import shutil
import subprocess

import pytest

from targets.firmware import image_path

QEMU = "qemu-system-arm"
OPTIONS = ["-M", "netduinoplus2", "-nographic", "-monitor", "none", "-serial", "null", "-semihosting"]


@pytest.mark.skipif(shutil.which(QEMU) is None, reason=f"{QEMU} is not installed")
@pytest.mark.parametrize(("name", "checks"), [("cpu", 121), ("faults", 36), ("unaligned", 5)])
def test_every_check_holds(name, checks):
    image = image_path(f"selftest-{name}")
    done = subprocess.run([QEMU, *OPTIONS, "-kernel", image], capture_output=True, text=True, timeout=60)
    said = (done.stdout + done.stderr).splitlines()
    assert [line for line in said if line.startswith("FAIL")] == []
    assert f"done {checks} ok 0 failed" in said
    assert done.returncode == 0
