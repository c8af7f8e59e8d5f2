"""Opens a recording by what is in it, and gives its signals the names of the bench."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from hilbench.diff.capture import Capture
from hilbench.diff.csv_file import read_csv
from hilbench.diff.journal_file import read_journal
from hilbench.diff.vcd_file import read_vcd
from hilbench.errors import UnavailableError, UsageError
from hilbench.nearest import did_you_mean
from hilbench.recordings.reading import FORMATS

__all__ = ["check_mapping", "named", "read_capture"]

_PIN = re.compile(r"P[A-K]\d{1,2}")


def read_capture(path: Path, case: str = "") -> Capture:
    """Read a journal, a value change dump or a table; `case` chooses one of a journal that has several.

    Raises:
        UnavailableError: it cannot be read, or is none of these.
        UsageError: the case is missing or wrong.
    """
    try:
        with path.open("rb") as file:
            begin = file.read(256)
    except OSError as error:
        raise UnavailableError(f"cannot be read: {error.strerror or error}", where=str(path)) from error
    if not path.is_file():
        raise UnavailableError("is not a regular file", where=str(path))
    if begin.startswith(tuple(magic for name, (magic, _) in FORMATS.items() if name != "journal")):
        hint = "compare its events with --events"
        raise UnavailableError("is neither waveforms nor a table of pins, but events", where=str(path), hint=hint)
    first = begin.removeprefix(b"\xef\xbb\xbf").lstrip()[:1]
    if first == b"{":
        return read_journal(path, case)
    return read_vcd(path) if first == b"$" else read_csv(path)


def named(capture: Capture, other: Capture, mapping: Mapping[str, str]) -> Capture:
    """Return a capture with the names of the bench: by the mapping, or where there is but one board, by the pin's name.

    Args:
        capture: the one to name; a journal is returned as it is.
        other: what it is to be compared with.
        mapping: from names in the capture to names of the bench. ``D0`` also stands for ``logic.D0``.

    Raises:
        UsageError: two signals get the same name.
    """
    if capture.boards:
        return capture
    tracks, unnamed = {}, []
    for name, track in capture.tracks.items():
        new = _name(name, other, mapping)
        if new is None:
            unnamed.append(name)
            new = name
        if new in tracks:
            raise UsageError(f"two signals of {capture.label} are to be '{new}'", where="--map")
        tracks[new] = replace(track, name=new)
    remark = (f"no net of the bench: {', '.join(unnamed)} (name it with --map)",) if unnamed else ()
    return replace(capture, tracks=tracks, remarks=(*capture.remarks, *remark))


def check_mapping(mapping: Mapping[str, str], *captures: Capture) -> None:
    """Make sure that every name of a mapping is in one of the captures that are no journals.

    Raises:
        UsageError: it is in none.
    """
    known = [name for capture in captures if not capture.boards for name in capture.tracks]
    for name in mapping:
        if name not in known and name not in {_last(one) for one in known}:
            hint = did_you_mean(name, known, "they have") or "only captures have columns to be named"
            raise UsageError(f"no column '{name}'", where=f"--map {name}={mapping[name]}", hint=hint)


def _name(name: str, other: Capture, mapping: Mapping[str, str]) -> str | None:
    mapped = mapping.get(name) or mapping.get(_last(name))
    if mapped:
        return mapped
    if name in other.tracks or name.partition(".")[0] in other.boards:
        return name
    boards = other.boards or {one.partition(".")[0] for one in other.tracks if "." in one}
    full = f"{next(iter(boards))}.{_last(name)}" if len(boards) == 1 else ""
    pin = full in other.tracks or (other.boards and _PIN.fullmatch(_last(name)))
    return full if full and pin else None


def _last(name: str) -> str:
    return name.rpartition(".")[2]
