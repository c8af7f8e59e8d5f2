"""Takes the files of a campaign to another host: a parcel of them, unpacked there once, by its digest.

There they stand as here, below a folder of their own, so the paths in bench files lead to them as long as they are
relative.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterable, Mapping
from pathlib import Path

import msgspec

from hilbench.campaign.digests import files_of, own_digest
from hilbench.campaign.point import Outcome, Point, run_point
from hilbench.errors import UnavailableError
from hilbench.exit_codes import ExitCode
from hilbench.files import write_atomically
from hilbench.strict.changes import change_text, parse_change

__all__ = ["Parcel", "pack", "run_shipped"]


class Parcel(msgspec.Struct, frozen=True):
    """Files by their absolute paths, and the digest of all of them."""

    digest: str
    files: dict[str, bytes]


def pack(points: Iterable[Point]) -> Parcel:
    """Return the parcel of what points are made of, as far as hilbench does not bring it itself.

    Raises:
        UnavailableError: a file cannot be read.
    """
    ours = Path(__file__).parents[1]
    found: dict[str, bytes] = {}
    for point in points:
        for file in files_of(point.bench, point.changes, point.suites):
            name = os.path.abspath(file)  # noqa: PTH100 - a link stays where it is
            if name not in found and not Path(name).is_relative_to(ours):
                found[name] = _read(file)
    digest = hashlib.sha256(msgspec.msgpack.encode(sorted(found.items()))).hexdigest()
    return Parcel(digest, found)


def run_shipped(point: Point, parcel: str, files: Mapping[str, bytes] | None, hilbench: str) -> Outcome | None:
    """Run a point on this host, which is not the one of the campaign.

    Args:
        point: with the paths of the host of the campaign.
        parcel: the digest of its parcel.
        files: that parcel; None if it may be here already.
        hilbench: the digest that hilbench must have here.

    Returns:
        The outcome; None if the parcel is not here.
    """
    if own_digest() != hilbench:
        cause = "the worker has another hilbench: install the same wheel there"
        return Outcome(verdict="error", exit_code=ExitCode.UNAVAILABLE, cause=cause)
    folder = _cache() / parcel
    if not (folder / "complete").is_file():
        if files is None:
            return None
        try:
            _unpack(folder, files)
        except (OSError, UnavailableError) as error:
            cause = f"the worker cannot keep the files of the campaign: {error}"
            return Outcome(verdict="error", exit_code=ExitCode.UNAVAILABLE, cause=cause)
    return run_point(_moved(point, folder))


def _moved(point: Point, folder: Path) -> Point:
    """Return a point whose paths lead into a folder, as far as they are there."""

    def there(text: str) -> str:
        path = Path(f"{folder}/files/{os.path.abspath(text)}")  # noqa: PTH100 - as above
        return str(path) if path.exists() else text

    changes = []
    for text in point.changes:
        change = parse_change(text)
        moved = there(change.value) if isinstance(change.value, str) and change.value.startswith("/") else change.value
        changes.append(text if moved == change.value else change_text(text.partition("=")[0], moved))
    return msgspec.structs.replace(
        point, bench=there(point.bench), suites=tuple(map(there, point.suites)), changes=tuple(changes)
    )


def _unpack(folder: Path, files: Mapping[str, bytes]) -> None:
    for name, data in files.items():
        path = Path(f"{folder}/files/{name}")
        path.parent.mkdir(parents=True, exist_ok=True)
        write_atomically(path, data)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "complete").touch()


def _cache() -> Path:
    home = os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")  # noqa: PTH111 - expanduser() may raise
    return Path(home) / "hilbench" / "campaign"


def _read(file: Path) -> bytes:
    try:
        return file.read_bytes()
    except OSError as error:
        raise UnavailableError(f"cannot be read: {error.strerror}", where=str(file)) from None
