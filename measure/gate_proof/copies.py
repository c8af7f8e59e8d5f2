"""Copies of the tree, each with an environment of its own, so that nobody's checkout is touched.

A copy's environment finds the product in the copy, also in processes that a test starts with a clean environment, and
all else in the environment of whoever runs this.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import sysconfig
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]
PLUGINS = Path(__file__).parent / "plugins"
_START = 'import os; "GATE_PROOF_CONTEXT" in os.environ and __import__("gate_child")'
_SCRIPT = """#!{python}
import sys

from hilbench.__main__ import main

sys.exit(main())
"""


@dataclass(frozen=True, slots=True)
class Copy:
    """A tree at a commit.

    Attributes:
        tree: its root.
    """

    tree: Path

    @property
    def python(self) -> Path:
        """The interpreter that finds the product in the copy."""
        return self.tree / ".venv" / "bin" / "python"


def git(*words: str, at: Path = ROOT) -> str:
    """Return what git says."""
    return subprocess.run(["git", *words], cwd=at, check=True, capture_output=True, text=True).stdout.strip()


@contextmanager
def a_folder() -> Iterator[Path]:
    """Give a folder that goes when it is no longer needed."""
    folder = Path(tempfile.mkdtemp(prefix="gate-"))
    folder.chmod(0o755)  # some tests become a user who has to read the copy
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def checkout(commit: str, tree: Path) -> Path:
    """Make a copy of the tree as it is at a commit, to be read."""
    git("clone", "--quiet", "--shared", "--no-checkout", str(ROOT), str(tree))
    git("checkout", "--quiet", commit, at=tree)
    return tree


def copy_of(commit: str, tree: Path) -> Copy:
    """Make a copy of the tree as it is at a commit, to be run."""
    copy = Copy(checkout(commit, tree))
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", tree / ".venv"], check=True)
    _equip(copy)
    where = subprocess.run(
        [copy.python, "-c", "import hilbench; print(hilbench.__file__)"],
        cwd="/",
        check=True,
        capture_output=True,
        text=True,
    ).stdout
    assert Path(where).is_relative_to(tree), where
    return copy


def _equip(copy: Copy) -> None:
    """Point the environment of a copy to the copy, and to what is installed beside it."""
    version = f"python{sys.version_info.major}.{sys.version_info.minor}"
    packages = copy.tree / ".venv" / "lib" / version / "site-packages"
    lines = [str(copy.tree), sysconfig.get_path("purelib"), str(PLUGINS), _START]
    (packages / "copy.pth").write_text("\n".join(lines) + "\n", encoding="utf-8")
    programs = copy.python.parent
    for program in Path(sysconfig.get_path("scripts")).iterdir():
        if not (programs / program.name).exists() and program.is_file() and os.access(program, os.X_OK):
            (programs / program.name).symlink_to(program)
    script = programs / "hilbench"
    script.unlink(missing_ok=True)
    script.write_text(_SCRIPT.format(python=copy.python), encoding="utf-8")
    script.chmod(0o755)
