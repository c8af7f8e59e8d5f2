"""The bench of ``--target capture:FILE``: a recording, to which cases listen that need nobody to answer."""

from __future__ import annotations

import contextlib
import hashlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from hilbench.benchfile.inputs import plugin_files
from hilbench.errors import UnavailableError, UsageError
from hilbench.files import refuse_overwriting
from hilbench.journal import Journal, Recording
from hilbench.judging.provider import RECORDING, CaseInfo
from hilbench.judging.verdicts import Inconclusive
from hilbench.plugins.discovery import PLUGINS
from hilbench.plugins.protocol import ProtocolPlugin, Recorded
from hilbench.recordings.frames import spoken
from hilbench.recordings.layout import laid_out
from hilbench.recordings.listening import Stretch, stretches
from hilbench.recordings.reading import parse_recording
from hilbench.recordings.remarks import remarks_on
from hilbench.terminal.options import CheckOptions

__all__ = ["CaptureCase", "CaptureProvider"]


@dataclass(frozen=True, slots=True)
class _Listened:
    recording: Recording
    stretches: Sequence[Stretch]
    sha256: str


class CaptureCase:
    """What a case on a recording has.

    Args:
        case: what is known of it.
        listened: the recording.
        journal: where its verdict goes.
    """

    def __init__(self, case: CaseInfo, listened: _Listened, journal: Journal) -> None:
        self.now_ns = 0
        self.journal = journal
        self._listened = listened
        self._hash = ""
        journal.begin_case(case.id)
        journal.record("recording", "checker", 0, sha256=listened.sha256)

    @property
    def stretches(self) -> Sequence[Stretch]:
        """What was heard.

        Raises:
            Inconclusive: nothing was.
        """
        if not self._listened.stretches:
            raise Inconclusive("no bytes of a line are in this recording")
        return self._listened.stretches

    def evidence(self) -> Sequence[str]:
        """Return nothing more than the verdict says."""
        return ()

    def finish(self, verdict: str, cause: str) -> None:
        """Take the verdict into the journal."""
        self.journal.record("verdict", "checker", 0, verdict=verdict, cause=cause)
        self._hash = self.journal.end_case()

    def case_hash(self) -> str:
        """Return the hash over recording and verdict."""
        return self._hash


class CaptureProvider:
    """Gives each case the recording.

    Args:
        options: what the command line says.
        path: the recording.

    Raises:
        UsageError: its protocol is unknown, or it would be overwritten.
        UnavailableError: it cannot be read.
    """

    def __init__(self, options: CheckOptions, path: Path) -> None:
        refuse_overwriting(options.outputs(), [("the recording", path), *plugin_files()])
        self._path = path
        self._data = _read(path)
        self._recording = parse_recording(self._data, str(path))
        self._protocol, self._recorded = _judged(self._recording, str(path))
        sha256 = hashlib.sha256(self._data).hexdigest()
        header = {"bench": self._bench, "seed": options.seed, "recording": str(path), "sha256": sha256}
        self._journal = Journal(options.journal, header, max_bytes=options.journal_max)

    @property
    def _bench(self) -> str:
        return str(self._recording.header.get("bench", "recording"))

    @property
    def capabilities(self) -> frozenset[str]:
        """That it is a recording, and whose clauses may be judged."""
        return self._recorded.capabilities | {self._protocol.title, RECORDING}

    @property
    def suites(self) -> Sequence[str]:
        """All that there is for its protocol: what cannot be judged by listening is not applicable, and says so."""
        return self._recorded.suites

    def describe(self) -> Mapping[str, str]:
        """Name the recording, and say what is not there of it."""
        about = {
            "bench": self._bench,
            "target": f"recording {self._path} ({self._protocol.name})",
            "physics": "none of ours",
        }
        remarks = "; ".join(remarks_on(self._recording.header, self._recording.problem, "judged"))
        return {**about, "recording": remarks} if remarks else about

    @contextlib.contextmanager
    def open_case(self, case: CaseInfo) -> Iterator[CaptureCase]:
        """Give a case the recording."""
        yield CaptureCase(case, self._listened, self._journal)

    @cached_property
    def _listened(self) -> _Listened:
        heard = stretches(self._recording, self._protocol)
        return _Listened(self._recording, heard, hashlib.sha256(self._data).hexdigest())

    def close(self) -> None:
        """Close the journal."""
        self._journal.close()


def _judged(recording: Recording, where: str) -> tuple[ProtocolPlugin, Recorded]:
    protocol = spoken(laid_out(recording.events), lambda one: one.recorded is not None)
    if protocol is not None and protocol.recorded is not None:
        return protocol, protocol.recorded
    wrong = "no protocol is known that makes frames of its bytes"
    if protocol is not None:
        wrong = f"{protocol.name} is spoken there, and cannot be judged by listening"
    names = ", ".join(one.name for one in PLUGINS.all() if one.recorded is not None)
    raise UsageError(wrong, where=where, hint=f"that can be judged: {names}")


def _read(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise UnavailableError(
            f"cannot be read: {error.strerror or error}", where=f"--target capture:{path}"
        ) from error
