"""The program that both sides run is what its source says, where there is an assembler to ask."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import pytest

HERE = Path(__file__).parent


def test_the_program_is_the_source_assembled(tmp_path, sequencer):
    if shutil.which("arm-none-eabi-gcc") is None:
        assert not os.environ.get("HILBENCH_EXHAUSTIVE"), "a thorough run needs arm-none-eabi-gcc"
        pytest.skip("there is no arm-none-eabi-gcc")
    made, plain = tmp_path / "sequencer.o", tmp_path / "sequencer.bin"
    source = HERE / "sequencer.s"
    subprocess.run(["arm-none-eabi-gcc", "-c", "-mcpu=cortex-m3", "-mthumb", source, "-o", made], check=True)
    subprocess.run(["arm-none-eabi-objcopy", "-O", "binary", "-j", ".text", made, plain], check=True)
    assert plain.read_bytes() == sequencer["code"]
    names = subprocess.run(["arm-none-eabi-nm", made], check=True, capture_output=True, text=True).stdout
    places = {line.split()[2]: int(line.split()[0], 16) for line in names.splitlines()}
    assert (places["fault"], places["interrupt"]) == (sequencer["fault"], sequencer["interrupt"])
