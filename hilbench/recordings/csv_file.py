"""A recording as a table (RFC 4180): a line for each event, for spreadsheets and pandas.

Columns: time in the file in s, bench time in ns, kind, source, bytes in hex, and everything else as JSON. The first
line under the names is the header of the journal.
"""

from __future__ import annotations

import csv
import io
from typing import IO, Any

import msgspec

from hilbench.clock import NS_PER_S
from hilbench.journal import Recording
from hilbench.recordings.layout import BYTE_KINDS, Event, json_bytes, laid_out, without

__all__ = ["MAGIC", "read_csv_events", "write_csv"]

COLUMNS = ("time_s", "ns", "kind", "source", "data", "fields")
MAGIC = ",".join(COLUMNS).encode()
_HEADER = "journal"


def write_csv(recording: Recording, file: IO[bytes]) -> int:
    """Write a recording; return how many events were written, each as one line."""
    text = io.TextIOWrapper(file, encoding="utf-8", newline="", write_through=True)
    table = csv.writer(text, lineterminator="\n")
    table.writerow(COLUMNS)
    table.writerow(["0.000000000", 0, _HEADER, "", "", _rest(without(recording.header, "kind"))])
    for ns, event in laid_out(recording.events):
        has_bytes = event["kind"] in BYTE_KINDS and isinstance(event.get("data"), str)
        names = {name: str(event.get(name, "")) for name in ("kind", "source")}
        broken = {name: text for name, text in names.items() if _in_one_line(text) != text}
        rest = without(event, "ns", "kind", "source", *(["data"] if has_bytes else [])) | broken
        kind, source = map(_in_one_line, names.values())
        time = f"{ns // NS_PER_S}.{ns % NS_PER_S:09}"
        data = event["data"] if has_bytes else ""
        table.writerow([time, event.get("ns", 0), kind, source, data, _rest(rest)])
    text.flush()
    text.detach()
    return len(recording.events)


def _in_one_line(text: str) -> str:
    """A line of the file is an event, and the reader takes it for one by its end."""
    return text.replace("\n", " ").replace("\r", " ")


def _rest(fields: dict[str, Any]) -> str:
    return json_bytes(fields).decode() if fields else ""


def read_csv_events(data: bytes) -> Recording:
    """Read a table that `write_csv` has written; one that was cut is read up to there."""
    *lines, cut = data.split(b"\n")
    problem = f"cut in line {len(lines) + 1}" if cut else None if lines else "the file is empty"
    # The module's own limit, 128 KiB, is less than the hex of what a fast line brings in one piece.
    usual = csv.field_size_limit(max(csv.field_size_limit(), len(data)))
    try:
        return _read(lines, problem)
    finally:
        csv.field_size_limit(usual)


def _read(lines: list[bytes], problem: str | None) -> Recording:
    header: dict[str, Any] = {}
    events: list[Event] = []
    for number, line in enumerate(lines[1:], 2):
        try:
            event = _event(line.decode("utf-8"))
        except (ValueError, csv.Error, msgspec.DecodeError, RecursionError):
            problem = f"line {number} cannot be read"
            break
        if event["kind"] == _HEADER and number == 2:
            header = without(event, "ns", "source") | {"kind": "journal"}
        else:
            events.append(event)
    ended = bool(events) and events[-1]["kind"] == "host-end"
    return Recording(header=header, events=tuple(events), problem=problem, ended=ended)


def _event(line: str) -> dict[str, Any]:
    """Return the event of a line; ValueError if it is none."""
    (row,) = csv.reader([line])
    _, ns, kind, source, data, text = row
    fields = msgspec.json.decode(text, type=dict[str, Any]) if text else {}
    event: dict[str, Any] = {"ns": int(ns), "kind": kind, "source": source}
    if kind in BYTE_KINDS and (data or "data" not in fields):
        event["data"] = bytes.fromhex(data).hex()
    return event | fields
