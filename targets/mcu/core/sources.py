"""What the library is compiled from, where it may lie, and whether one that lies there is of these sources."""

from __future__ import annotations

import hashlib
import os
import sys
from collections.abc import Iterable
from pathlib import Path

__all__ = ["COMPILE", "LINK", "SOURCES", "current", "digest_of", "file_name", "is_of", "places"]

SOURCES = Path(__file__).parent / "src"
"""Its C files and headers, flat."""

COMPILE = ("-std=c11", "-O2", "-g0", "-fPIC", "-Wall", "-Wextra", "-ffp-contract=off", "-fvisibility=hidden")
"""Flags for each file. No contraction: a * b + c rounds twice, on each processor. zig adds symbols unless told."""

LINK = ("-shared", "-Wl,-z,defs")
"""Flags for the library. What is not defined is an error now, not when it is loaded."""

_MARK = b"hilbench core sources "
"""Stands before the digest in the library (`about.c`)."""


def digest_of(sources: Path = SOURCES) -> str:
    """Return the SHA-256 of all sources and flags, in hexadecimal."""
    digest = hashlib.sha256("\0".join((*COMPILE, *LINK)).encode())
    for file in sorted(file for file in sources.iterdir() if file.suffix in {".c", ".h"}):
        text = file.read_bytes()
        digest.update(f"\0{file.name}\0{len(text)}\0".encode())
        digest.update(text)
    return digest.hexdigest()


def file_name(machine: str = "") -> str:
    """Return what the library for a machine, such as ``aarch64``, is called; without an argument, for this one."""
    return f"libhilmcu-{machine or os.uname().machine}-{sys.platform}.so"


def places(digest: str) -> tuple[Path, ...]:
    """Return where the library may lie, best first: beside this file, else in the user's cache folder.

    Where the folder of hilbench cannot be written, each state of the sources has a file of its own in
    ``$XDG_CACHE_HOME/hilbench``, else in ``~/.cache/hilbench`` (XDG Base Directory Specification).
    """
    beside = Path(__file__).parent / file_name()
    # where there is no home, Path.expanduser would raise
    cache = Path(os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache"))  # noqa: PTH111
    if not cache.is_absolute():
        return (beside,)
    return beside, cache / "hilbench" / f"{beside.stem}-{digest[:16]}.so"


def is_of(library: Path, digest: str) -> bool:
    """Return whether `library` can be read and was compiled from the sources with that digest."""
    try:
        return _MARK + digest.encode() in library.read_bytes()
    except OSError:
        return False


def current(digest: str, among: Iterable[Path]) -> Path | None:
    """Return the first library `among` these files that is of the sources with that digest."""
    return next((place for place in among if is_of(place, digest)), None)
