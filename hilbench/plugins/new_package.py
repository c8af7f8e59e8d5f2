"""`hilbench init --protocol NAME` of a protocol that is not there yet: a package for it, which works as it is."""

from __future__ import annotations

import keyword
import shutil
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path

from hilbench.errors import UnavailableError, UsageError
from hilbench.files import check_writable
from hilbench.files.new_files import Written

__all__ = ["new_package"]

_TEMPLATES = Path(__file__).parent.parent / "data" / "new_protocol"

_FILES = {
    "pyproject.toml": "pyproject.toml",
    "README.md": "README.md",
    "{name}.toml": "bench.toml",
    "{name}/__init__.py": "init.py",
    "{name}/frames.py": "frames.py",
    "{name}/node.py": "node.py",
    "{name}/plugin.py": "plugin.py",
    "{name}/{name}_suite.py": "suite.py",
    "tests/test_{name}_frames.py": "test.py",
}
"""What is written, and of which template."""


def new_package(name: str, folder: Path) -> Written:
    """Write a package with a protocol: decoder, both roles as models, five rules with a suite, a bench, tests.

    Args:
        name: of the protocol and of its package.
        folder: where the package's folder is to be; it must exist.

    Raises:
        UsageError: the name cannot be that of a package, or its folder is there already. Then nothing is written.
        UnavailableError: it cannot be written; nothing is left behind.
    """
    where = f"--protocol {name}"
    if not name.isidentifier() or not name.isascii() or not name.islower() or keyword.iskeyword(name):
        hint = "write small letters, digits and _, such as my_bus"
        raise UsageError("cannot be the name of a new protocol's package", where=where, hint=hint)
    if name in sys.stdlib_module_names or name in {"hilbench", "protocols", "targets", "worlds", "tests"}:
        raise UsageError("is the name of another package", where=where, hint="choose another one")
    home = folder / name
    if home.exists() or home.is_symlink():
        raise UsageError("is there already", where=str(home), hint="remove it, or choose another folder with --dir")
    check_writable(home, "--dir")
    files = {file.format(name=name): _text(template, name) for file, template in _FILES.items()}
    _write(home, files)
    notes = (f"there is no protocol '{name}' yet: this is a package for it, which works as it is",)
    return Written(files=tuple(home / file for file in files), notes=notes)


def _write(home: Path, files: Mapping[str, str]) -> None:
    """Write a folder whole or not at all."""
    beside = Path(tempfile.mkdtemp(prefix=f".{home.name}-", dir=home.parent))
    try:
        for file, text in files.items():
            beside.joinpath(file).parent.mkdir(exist_ok=True)
            beside.joinpath(file).write_text(text, encoding="utf-8")
        beside.chmod(0o755)
        beside.rename(home)
    except OSError as error:
        shutil.rmtree(beside, ignore_errors=True)
        raise UnavailableError(f"cannot be written: {error.strerror}", where=str(home)) from error


def _text(template: str, name: str) -> str:
    text = _TEMPLATES.joinpath(f"{template}.txt").read_text(encoding="utf-8")
    return text.replace("@name@", name).replace("@ID@", name.upper().replace("_", ""))
