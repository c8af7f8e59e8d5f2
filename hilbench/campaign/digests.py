"""What the points of a campaign are made of, as digests: the same point of the same things is not run again."""

from __future__ import annotations

import hashlib
from functools import cache
from importlib.util import find_spec
from pathlib import Path

from hilbench.benchfile.inputs import inputs_of
from hilbench.benchfile.reader import open_bench
from hilbench.benchfile.suites import find_suites, is_shipped
from hilbench.campaign.point import Point
from hilbench.errors import UnavailableError
from hilbench.strict.changes import parse_change

__all__ = ["files_of", "inputs_of_point", "own_digest"]

_PACKAGES = ("hilbench", "protocols", "targets", "worlds")
_OURS = (".py", ".toml", ".j2", ".so", ".json")


@cache
def own_digest() -> str:
    """Return the digest of hilbench as it is installed: its code, its data and its library in C."""
    digest = hashlib.sha256()
    for package in _PACKAGES:
        spec = find_spec(package)
        for folder in sorted(spec.submodule_search_locations or []) if spec is not None else []:
            for file in sorted(Path(folder).rglob("*")):
                if file.suffix in _OURS and "__pycache__" not in file.parts:
                    digest.update(f"{package}/{file.relative_to(folder)}".encode())
                    digest.update(file.read_bytes())
    return digest.hexdigest()


@cache
def files_of(bench: str, changes: tuple[str, ...], suites: tuple[str, ...]) -> tuple[Path, ...]:
    """Return the files that a point is made of, as far as they are not hilbench's own.

    Args:
        bench: of the point.
        changes: of the point.
        suites: of the point.

    Raises:
        UsageError: the bench is wrong, or there is no such suite.
    """
    opened = open_bench(bench, changes=tuple(map(parse_change, changes)))
    files = [file for _, file in inputs_of(opened) if file is not None and file.is_file()]
    for suite in find_suites(suites) if suites else []:
        if not is_shipped(suite):  # those are hilbench's own; what lies beside another one it may import
            files += [suite, *sorted(suite.parent.glob("*.py"))]
    return tuple(dict.fromkeys(files))


def inputs_of_point(point: Point) -> list[str]:
    """Return the digests of what a point is made of; see `hilbench.campaign.point.key_of`.

    Raises:
        UsageError: the point's bench is wrong.
        UnavailableError: a file cannot be read.
    """
    return [own_digest(), *map(_digest, files_of(point.bench, point.changes, point.suites))]


_KNOWN: dict[tuple[Path, int, int], str] = {}


def _digest(file: Path) -> str:
    try:
        state = file.stat()
        known = file, state.st_size, state.st_mtime_ns
        if known not in _KNOWN:
            _KNOWN[known] = hashlib.sha256(file.read_bytes()).hexdigest()
    except OSError as error:
        raise UnavailableError(f"cannot be read: {error.strerror}", where=str(file)) from None
    return _KNOWN[known]
