"""Opens a recording by what it begins with: a journal, or what `hilbench export` makes of one."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

from hilbench.errors import UnavailableError, UsageError
from hilbench.journal import Journal, Recording
from hilbench.recordings import csv_file, mcap_file, pcapng
from hilbench.recordings.event_form import wrong_with

__all__ = ["FORMATS", "OLDER", "format_of", "parse_recording", "read_recording"]

FORMATS: Mapping[str, tuple[bytes, Callable[[bytes], Recording]]] = {
    "journal": (b'{"kind":"journal"', Journal.parse),
    "pcapng": (pcapng.MAGIC, pcapng.read_pcapng),
    "mcap": (mcap_file.MAGIC, mcap_file.read_mcap),
    "csv": (csv_file.MAGIC, csv_file.read_csv_events),
}
"""What a file begins with, and who reads it, by the name of its format."""

OLDER = (b"\xd4\xc3\xb2\xa1", b"\xa1\xb2\xc3\xd4", b"\x4d\x3c\xb2\xa1", b"\xa1\xb2\x3c\x4d")
"""What a capture file of libpcap begins with (draft-ietf-opsawg-pcap), in both byte orders; it has no directions."""


def format_of(data: bytes) -> str:
    """Return the format of what begins like this, also if it is cut within its first bytes; empty if it is none."""
    for name, (magic, _) in FORMATS.items():
        if data and (data.startswith(magic) or magic.startswith(data)):
            return name
    return "journal" if data.startswith(b'{"') else ""


def parse_recording(data: bytes, where: str) -> Recording:
    """Read the bytes of a file, up to where it was cut or is damaged.

    Raises:
        UnavailableError: they are no recording.
    """
    if not data:
        return Recording(header={}, events=(), problem="the file is empty", ended=False)
    name = format_of(data)
    if not name:
        hint = "a journal, pcapng, MCAP, or the table of 'hilbench export --csv'"
        if data.startswith(OLDER):
            hint = "it is an older pcap, which does not say who sent what: capture into pcapng"
        raise UnavailableError("is no recording", where=where, hint=hint)
    try:
        return _up_to_damage(FORMATS[name][1](data))
    except UsageError as error:
        raise UnavailableError(error.message, where=where, hint=error.hint) from error


def _up_to_damage(recording: Recording) -> Recording:
    """Return a recording up to the first event that its readers could not take."""
    for number, event in enumerate(recording.events):
        if wrong := wrong_with(event):
            problem = f"event {number + 1} is damaged: {wrong}"
            return replace(recording, events=recording.events[:number], problem=problem, ended=False)
    return recording


def read_recording(path: Path) -> Recording:
    """Read a file; see `parse_recording`.

    Raises:
        UnavailableError: it cannot be read, or is no recording.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        raise UnavailableError(f"cannot be read: {error.strerror or error}", where=str(path)) from error
    return parse_recording(data, str(path))
