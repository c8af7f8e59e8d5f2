"""Runs an image in QEMU: a board with memory where the images expect it, ``mps2-an385`` (M3) or ``mps2-an500`` (M7)."""

from __future__ import annotations

import shutil
import subprocess
import tempfile
from pathlib import Path

PROGRAM = "qemu-system-arm"
_TIMEOUT_S = 120
_OPTIONS = (
    *("-display", "none", "-monitor", "none", "-serial", "none"),
    *("-semihosting-config", "enable=on,target=native"),
)


def missing() -> bool:
    return shutil.which(PROGRAM) is None


def output_of(image: bytes, machine: str = "mps2-an385") -> bytes:
    """Run it on that machine; return what it wrote."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "image.bin"
        path.write_bytes(image)
        command = [PROGRAM, "-M", machine, *_OPTIONS, "-kernel", str(path)]
        done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, timeout=_TIMEOUT_S)
    assert done.returncode == 0, done.stderr.decode(errors="replace")
    return done.stdout
