"""A checkout of its own with the library's sources, and a compiler that does nothing: no test needs a real one."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import targets
from targets.mcu.core import sources

ROOT = Path(targets.__file__).parents[1]
PARTS = ("targets/__init__.py", "targets/mcu/__init__.py", "targets/mcu/errors.py", "targets/mcu/core")

COMPILER = """\
#!{python} -S
# Says that it was called. Objects hold the digest they are told; libraries are the real one with that digest.
import sys
from pathlib import Path

arguments = sys.argv[1:]
made = Path(arguments[arguments.index("-o") + 1])
with Path({log!r}).open("a") as log:
    log.write(f"{{made.name}}\\n")
if "-c" in arguments:
    told = next(word for word in arguments if word.startswith("-DHIL_SOURCES_DIGEST="))
    made.write_text(told.partition("=")[2].strip('"'))
elif not any(word.endswith("probe.c") for word in arguments):
    told = next(Path(word) for word in arguments if word.endswith(".o")).read_text()
    made.write_bytes(Path({library!r}).read_bytes().replace({digest!r}.encode(), told.encode()))
"""


@pytest.fixture
def compiler(tmp_path):
    """The command of a compiler that logs what it makes into the file ``compiled`` beside it."""
    from targets.mcu.core.library import about

    library = about()
    file = tmp_path / "compiler"
    told = {"log": str(tmp_path / "compiled"), "library": str(library.path), "digest": library.digest}
    file.write_text(COMPILER.format(python=sys.executable, **told))
    file.chmod(0o755)
    return file


class Checkout:
    """A folder with the library's sources.

    Attributes:
        core: the folder of the library.
        env: the surroundings of what runs in it.
    """

    def __init__(self, folder: Path, compiler: Path):
        for name in PARTS:
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            ignored = shutil.ignore_patterns("__pycache__", ".*")
            copy = shutil.copytree if (ROOT / name).is_dir() else shutil.copy
            copy(ROOT / name, folder / name, **({"ignore": ignored} if copy is shutil.copytree else {}))
        self.folder = folder
        self.core = folder / "targets/mcu/core"
        self.compiled = compiler.parent / "compiled"
        self.env = {**os.environ, "CC": str(compiler), "XDG_CACHE_HOME": str(folder / "cache")}
        self.library = self.core / sources.file_name()

    def change_a_source(self):
        with (self.core / "src/about.c").open("a") as file:
            file.write("/* changed */\n")
        return sources.digest_of(self.core / "src")

    def start(self, *arguments):
        command = [sys.executable, "-S", *arguments]
        return subprocess.Popen(
            command, cwd=self.folder, env=self.env, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )

    def run(self, *arguments):
        process = self.start(*arguments)
        out, err = process.communicate(timeout=120)
        return process.returncode, out, err


@pytest.fixture
def checkout(tmp_path, compiler):
    return Checkout(tmp_path / "checkout", compiler)
