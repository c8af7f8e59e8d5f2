"""Recordings made by hand, in which each event can be told from the others."""

from __future__ import annotations

import io
from types import SimpleNamespace

import pytest

from hilbench.journal import Journal, Recording
from hilbench.judging.verdicts import Inconclusive, NotApplicable, Violation
from hilbench.plugins.discovery import PLUGINS
from hilbench.recordings.csv_file import read_csv_events, write_csv
from hilbench.recordings.listening import stretches
from hilbench.recordings.mcap_file import read_mcap, write_mcap
from hilbench.recordings.pcapng import read_pcapng, write_pcapng
from hilbench.suites import recorded_carla, recorded_p2os, recorded_pkt

MS = 1_000_000
SUITES = {"p2os": recorded_p2os, "pkt": recorded_pkt, "carla": recorded_carla}
HEADER = {"kind": "journal", "part": 0, "format": 1, "hilbench": "0", "bench": "test", "seed": 7, "faults": []}


def _journal(recording):
    import msgspec

    lines = [recording.header, *recording.events]
    return b"".join(msgspec.json.encode(line) + b"\n" for line in lines)


def _by(write):
    def written(recording):
        file = io.BytesIO()
        write(recording, file)
        return file.getvalue()

    return written


FORMATS = {
    "journal": (_journal, Journal.parse),
    "pcapng": (_by(write_pcapng), read_pcapng),
    "mcap": (_by(write_mcap), read_mcap),
    "csv": (_by(write_csv), read_csv_events),
}


@pytest.fixture(scope="session", params=FORMATS)
def form(request):
    """A format: what makes bytes of a recording, and what reads them."""
    return FORMATS[request.param]


@pytest.fixture
def recording_of():
    """Make a recording of events."""

    def made(events):
        return Recording(header=HEADER, events=tuple(events), problem=None, ended=False)

    return made


@pytest.fixture(scope="session")
def two_cases():
    """Two cases with bytes, a verdict, and everything that must survive."""
    return Recording(
        header=HEADER,
        events=(
            {"ns": 0, "kind": "case", "source": "journal", "case": "a/one"},
            {"ns": 1 * MS, "kind": "tx", "source": "checker", "data": "fafb03000000"},
            {"ns": 3 * MS, "kind": "rx", "source": "checker", "data": "fafb03000000", "packet": "SyncEcho"},
            {"ns": 3 * MS, "kind": "event", "source": "robot", "name": "StateChanged", "value": {"old": "A", "n": [1]}},
            {"ns": 4 * MS, "kind": "dropped", "source": "checker", "reason": "NOISE", "data": "00ff"},
            {"ns": 5 * MS, "kind": "verdict", "source": "checker", "verdict": "fail", "cause": 'a "quoted", cause'},
            {"ns": 5 * MS, "kind": "case-end", "source": "journal", "case": "a/one", "hash": "0" * 64},
            {"ns": 0, "kind": "case", "source": "journal", "case": "a/two"},
            {"ns": 12 * MS, "kind": "tx", "source": "brain.usart1", "data": "666f72", "from_ns": 2 * MS},
            {"ns": 12 * MS, "kind": "case-end", "source": "journal", "case": "a/two", "hash": "1" * 64},
            {"ns": 0, "kind": "host-end", "source": "journal"},
        ),
        problem=None,
        ended=True,
    )


@pytest.fixture
def wrong(recording_of):
    """Judge bytes (ns, way, bytes) of one end of a line by listening; return what was found wrong."""

    def judge(protocol, said, *, source="checker", case="", end_ns=0):
        events = [{"ns": 0, "kind": "case", "source": "journal", "case": case}] if case else []
        events += [{"ns": ns, "kind": way, "source": source, "data": data.hex()} for ns, way, data in said]
        events.append({"ns": max(end_ns, said[-1][0]), "kind": "note", "source": "desk", "text": "the end"})
        bench = SimpleNamespace(stretches=stretches(recording_of(events), PLUGINS.get(protocol, "a test")))
        tests = [test for name, test in vars(SUITES[protocol]).items() if name.startswith("test_")]
        return [str(error) for test in tests if (error := violation(test, bench)) is not None]

    return judge


def violation(test, bench):
    try:
        test(bench)
    except Violation as error:
        return error
    except (Inconclusive, NotApplicable):
        pass
    return None
