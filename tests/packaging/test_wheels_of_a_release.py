"""The wheels of `make wheels`: for their machine, and for a C library as old as their name promises."""

from __future__ import annotations

import importlib.util
import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest
from elftools.elf.elffile import ELFFile

from hilbench import __version__
from targets.mcu.core import build, sources

ROOT = Path(__file__).parents[2]
MACHINES = {"x86_64": "EM_X86_64", "aarch64": "EM_AARCH64"}
EMULATOR = {"x86_64": [], "aarch64": ["qemu-aarch64-static", "-L", "/usr/aarch64-linux-gnu"]}
LOADER = """\
#include <dlfcn.h>
#include <stdio.h>
int main(int count, char **arguments) {
    void *library = count > 1 ? dlopen(arguments[1], RTLD_NOW) : NULL;
    if (!library) return puts(dlerror()), 1;
    const char *(*digest)(void) = (const char *(*)(void))dlsym(library, "hil_sources_digest");
    return puts(digest()) < 0;
}
"""

pytestmark = [
    pytest.mark.exhaustive("ziglang has 400 MB; the gate makes the wheel of this machine"),
    pytest.mark.skipif(importlib.util.find_spec("ziglang") is None, reason="ziglang is not installed"),
]


@pytest.fixture(scope="module", params=[*MACHINES])
def machine(request):
    return request.param


@pytest.fixture(scope="module")
def wheel(machine, tmp_path_factory):
    folder = tmp_path_factory.mktemp("wheels")
    builder = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(folder)]
    env = {**os.environ, "HILBENCH_WHEEL_MACHINE": machine}
    subprocess.run(builder, cwd=ROOT, env=env, check=True, capture_output=True)
    (file,) = folder.glob("*.whl")
    return file


@pytest.fixture(scope="module")
def library(machine, wheel, tmp_path_factory):
    folder = tmp_path_factory.mktemp("unpacked")
    with zipfile.ZipFile(wheel) as archive:
        (name,) = (name for name in archive.namelist() if name.endswith(".so"))
        assert name == f"targets/mcu/core/{sources.file_name(machine)}"
        return Path(archive.extract(name, folder))


def test_its_name_says_where_it_runs(machine, wheel):
    platform = f"manylinux_2_17_{machine}.manylinux2014_{machine}"
    assert wheel.stem == f"hilbench-{__version__}-py3-none-{platform}"


def test_its_library_is_for_that_machine_and_needs_nothing_newer_than_it_says(machine, library):
    assert sources.is_of(library, sources.digest_of())
    with library.open("rb") as file:
        elf = ELFFile(file)
        assert elf["e_machine"] == MACHINES[machine]
        needed = elf.get_section_by_name(".gnu.version_r")
        wanted = [] if needed is None else [one.name for _, versions in needed.iter_versions() for one in versions]
        named = [section.name for section in elf.iter_sections()]
    assert all(tuple(map(int, name.removeprefix("GLIBC_").split("."))) <= (2, 17) for name in wanted)
    assert not [name for name in named if name.startswith(".debug")]


def test_its_library_is_loaded_on_that_machine(machine, library, tmp_path):
    emulator = EMULATOR[machine]
    if emulator and not (shutil.which(emulator[0]) and Path(emulator[-1]).exists()):
        pytest.skip("qemu-user-static or libc6-arm64-cross is not installed")
    loader = tmp_path / "loader"
    loader.with_suffix(".c").write_text(LOADER)
    zig = [word for word in build.zig_for(machine) if word != "-nostdlib"]
    subprocess.run([*zig, f"{loader}.c", "-o", str(loader), "-ldl"], check=True)
    said = subprocess.run([*emulator, str(loader), str(library)], check=True, capture_output=True, text=True).stdout
    assert said.strip() == sources.digest_of()
