"""The sources are clean by each compiler that is here, and each makes a library that works."""

from __future__ import annotations

import importlib.util
import os
import re
import shutil
from pathlib import Path

import pytest

from targets.mcu.core import build, library, sources

COMPILERS = {"gcc": ["gcc"], "clang": ["clang"], "zig": build.zig_for(os.uname().machine)}


WIDE_DIVISION = re.compile(rb"__u?(?:div|mod)\w*ti\d")
"""Of 128-bit integers: in a library of the compiler's that `zig_for` leaves out."""


def compiled(tmp_path, name, *flags):
    """Return the library that a compiler makes."""
    if shutil.which(name) is None and not (name == "zig" and importlib.util.find_spec("ziglang")):
        pytest.skip(f"there is no {name} here")
    made = tmp_path / sources.file_name()
    build.compile_library(made, COMPILERS[name], ["-Werror", *flags])
    return library.open_library(made, sources.digest_of())


@pytest.mark.parametrize(
    "name",
    [
        "gcc",
        pytest.param("clang", marks=pytest.mark.exhaustive("the gate takes gcc")),
        pytest.param("zig", marks=pytest.mark.exhaustive("the gate takes gcc")),
    ],
)
def test_a_compiler_has_nothing_to_say_and_its_library_works(tmp_path, name):
    made = compiled(tmp_path, name)
    assert made.hil_compiler().decode().startswith("gcc " if name == "gcc" else "clang ")
    assert made.hil_layout()[0].structure == b"hil_row"
    assert not WIDE_DIVISION.findall(Path(made._name).read_bytes())


@pytest.mark.exhaustive("the gate compiles as users do")
@pytest.mark.parametrize("name", [*COMPILERS])
def test_without_optimisation_it_is_clean_too(tmp_path, name):
    compiled(tmp_path, name, "-O0", "-Wconversion", "-Wno-sign-conversion", "-Wshadow")
