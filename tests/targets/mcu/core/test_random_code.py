"""Random half-words as code, with sanitizers: no crash, no finding, no hang; and the same however a run is cut."""

from __future__ import annotations

import os
import shutil
import subprocess
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from targets.mcu.core.sources import SOURCES

PROGRAM = Path(__file__).parent / "random_code.c"
FLAGS = ("-std=c11", "-g1", "-fno-sanitize-recover=all", "-ffp-contract=off")
ALL = ("-O1", "-fsanitize=address,undefined")
QUICK = ("-O0", "-fsanitize=address,bounds,shift,signed-integer-overflow")  # compiles in a fifth of the time
HANGS_S = 3600
SEEDS = range(1, 11)
EACH = 10_000_000


@pytest.fixture(scope="module")
def compiled(tmp_path_factory):
    """The program, compiled file by file, as many at a time as there are processors."""
    if shutil.which("gcc") is None:
        pytest.skip("there is no gcc here")
    flags = [*FLAGS, *(ALL if os.environ.get("HILBENCH_EXHAUSTIVE") else QUICK)]
    folder = tmp_path_factory.mktemp("random-code")

    def compile_file(source):
        made = folder / f"{source.stem}.o"
        told = ('-DHIL_SOURCES_DIGEST="none"', f"-I{SOURCES}", "-c", str(source), "-o", str(made))
        subprocess.run(["gcc", *flags, *told], check=True, timeout=HANGS_S)
        return str(made)

    with ThreadPoolExecutor(os.cpu_count()) as threads:
        objects = list(threads.map(compile_file, [*SOURCES.glob("*.c"), PROGRAM]))
    program = folder / "random_code"
    subprocess.run(["gcc", *flags, *objects, "-o", str(program)], check=True, timeout=HANGS_S)
    return program


def execute(program, seed, instructions):
    done = subprocess.run([program, str(seed), str(instructions)], capture_output=True, text=True, timeout=HANGS_S)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.exhaustive("compiles the emulated CPU with sanitizers; the gate has random code beside Unicorn")
def test_random_code_finds_nothing(compiled):
    execute(compiled, 1, 200_000)


@pytest.mark.exhaustive("a hundred million instructions")
@pytest.mark.parametrize("seed", SEEDS)
def test_much_random_code_finds_nothing(compiled, seed):
    execute(compiled, seed, EACH)
