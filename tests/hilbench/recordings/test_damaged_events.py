"""Recordings that are whole, with events in them that are not as hilbench writes them."""

from __future__ import annotations

import io
import json
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hilbench.diff.events import EventOptions, as_text, compare_events
from hilbench.recordings.csv_file import write_csv
from hilbench.recordings.frames import spoken
from hilbench.recordings.layout import laid_out
from hilbench.recordings.listening import stretches, talks
from hilbench.recordings.mcap_file import write_mcap
from hilbench.recordings.pcapng import write_pcapng
from hilbench.recordings.piecewise import open_pieces
from hilbench.recordings.reading import parse_recording
from hilbench.recordings.vcd_file import write_vcd
from hilbench.systems.pioneer.protocol import P2OS
from tests.each import each
from tests.share import examples

_ODD = (None, True, -5, 2**62, 2**70, 1.5, "", "zz", "ff", [], {}, {"a": 1})


def _lines(header, events):
    return b"".join(json.dumps(line).encode() + b"\n" for line in (header, *events))


def _records(data):
    """Yield where the records of an MCAP file begin."""
    at = 8
    while at + 9 <= len(data):
        yield at
        at += 9 + int.from_bytes(data[at + 1 : at + 9], "little")


@each(
    ("event", "said"),
    [
        ({"kind": "tx", "source": "checker", "data": "55"}, "'ns' is missing"),
        ({"ns": -1, "kind": "tx", "source": "checker", "data": "55"}, "'ns' is no time of a bench"),
        ({"ns": 2**62, "kind": "tx", "source": "checker", "data": "55"}, "'ns' is no time of a bench"),
        (
            {"ns": 1, "kind": "event", "source": "p", "value": {"word": 1, "at_ns": 10**400}},
            "'at_ns' is no time of a bench",
        ),
        ({"ns": 1, "kind": "rx", "source": "checker", "data": "5"}, "'data' is no bytes in hex"),
        ({"ns": 1, "kind": "dropped", "source": "checker", "data": 5}, "'data' is no text"),
        ({"ns": 1, "kind": ["tx"], "source": "checker"}, "'kind' is no text"),
        ({"ns": 1, "kind": "tx", "data": "55"}, "'source' is missing"),
        ({"ns": 1, "kind": "pin", "source": "brain.PB7", "level": "high"}, "'level' is no level: true, false or null"),
        ({"ns": 1, "kind": "margins", "source": "robot", "points": []}, "'timer' is missing"),
        ({"ns": 1, "kind": "margins", "source": "robot", "timer": "W", "points": 3}, "'points' is no list"),
        (
            {"ns": 1, "kind": "margins", "source": "robot", "timer": "W", "points": [[1, -2, 3]]},
            "'points' is no list of three times each",
        ),
    ],
)
def test_one_that_is_damaged_ends_the_reading_and_is_named(two_cases, event, said):
    events = (*two_cases.events[:4], event, *two_cases.events[4:])
    found = parse_recording(_lines(two_cases.header, events), "it")
    assert found.events == two_cases.events[:4]
    assert found.problem == f"event 5 is damaged: {said}"
    assert not found.ended


@each("write", [write_csv, write_mcap, write_pcapng])
def test_in_any_format(write, two_cases):
    # A case without its name, which every reader of cases asks for.
    events = [
        {"cASE" if name == "case" and event["case"] == "a/two" else name: value for name, value in event.items()}
        for event in two_cases.events
    ]
    file = io.BytesIO()
    write(replace(two_cases, events=tuple(events)), file)
    found = parse_recording(file.getvalue(), "it")
    assert found.events == two_cases.events[:7]
    assert found.problem == "event 8 is damaged: 'case' is missing"


@pytest.mark.parametrize("form", ["journal", "csv", "mcap", "pcapng"])
def test_brackets_without_end_end_the_reading(two_cases, tmp_path, form):
    """In a journal, in the fields of a table, in a message, in a comment."""
    marked = replace(
        two_cases, events=(*two_cases.events[:4], {"ns": 1, "kind": "x", "source": "y", "v": "@" * 60_000})
    )
    if form == "journal":
        data = _lines(marked.header, marked.events)
    else:
        file = io.BytesIO()
        {"csv": write_csv, "mcap": write_mcap, "pcapng": write_pcapng}[form](marked, file)
        data = file.getvalue()
    if form == "mcap":
        (begin,) = (at for at in _records(data) if data[at] == 6)
        data = data[: begin + 33] + bytes(4) + data[begin + 37 :]  # without a CRC
    at = data.index(b"@" * 60_000)
    quotes = 2 if form == "csv" else 1
    path = tmp_path / "recording"
    path.write_bytes(data[: at - quotes] + b"[" * (60_000 + 2 * quotes) + data[at + 60_000 + quotes :])
    found = parse_recording(path.read_bytes(), "it")
    assert found.events == two_cases.events[:4]
    assert found.problem is not None
    pieces = open_pieces(path)
    assert len(pieces.read()) == 4
    assert pieces.problem is not None


@settings(max_examples=examples(80))
@given(at=st.integers(0, 10), field=st.sampled_from(["ns", "kind", "source", "data", "case", "from_ns"]), odd=st.data())
def test_whoever_reads_a_recording_gets_events_that_can_be_read(at, field, odd, two_cases, tmp_path_factory):
    events = [dict(event) for event in two_cases.events]
    events[at][field] = odd.draw(st.sampled_from(_ODD))
    if odd.draw(st.booleans()):
        del events[at][field]
    found = parse_recording(_lines(two_cases.header, events), "it")
    for write in (write_csv, write_mcap, write_pcapng):
        write(found, io.BytesIO())
    write_vcd(found, tmp_path_factory.getbasetemp() / "damaged.vcd")
    spoken(laid_out(found.events))
    stretches(found, P2OS)
    talks(found)
    as_text(compare_events(found, two_cases, EventOptions()), "a", "b")
