"""The line on which a client under test says what it understood, and hears what it is to do: JSON, one object a line.

A client that was written to be checked opens a second port for it, beside the one of its robot (``{report}`` in
``exec:COMMAND``). What the objects say is the business of a system.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from typing import Any

import msgspec

from hilbench.judging.verdicts import Violation
from hilbench.links import Port

__all__ = ["REPORT", "ClientReports", "ReportLine"]

REPORT = "report"
"""What stands in braces where a command wants the path of this line."""

LONGEST_BYTES = 1_000_000
"""A line that goes on for longer is none. A choice: a hundred times the longest object that is told."""


class ReportLine:
    """One end of it, the checker's or the client's.

    Args:
        port: of this line alone.
        take: called with each object that comes.

    Attributes:
        senseless: the first line that came and is no object, or has no end; empty if all were objects.
    """

    def __init__(self, port: Port, take: Callable[[Mapping[str, Any]], None]) -> None:
        self.senseless = ""
        self._port = port
        self._take = take
        self._rest = b""
        port.on_receive = self._hear

    def say(self, said: Mapping[str, object]) -> None:
        """Send an object; a float that is no number, or none that is finite, goes as Python's `json` writes it."""
        self._port.write(json.dumps(said).encode() + b"\n")

    def _hear(self, data: bytes, _at_ns: int) -> None:
        *lines, self._rest = (self._rest + data).split(b"\n")
        for line in lines:
            if line.strip():
                self._read(line)
        if len(self._rest) > LONGEST_BYTES:
            self._refuse(self._rest)
            self._rest = b""

    def _read(self, line: bytes) -> None:
        try:
            said = json.loads(line)
            json.dumps(said, ensure_ascii=False).encode()  # half a surrogate pair is no text
        except (ValueError, RecursionError):
            said = None
        if isinstance(said, dict):
            self._take(said)
        else:
            self._refuse(line)

    def _refuse(self, line: bytes) -> None:
        self.senseless = self.senseless or line[:80].decode("utf-8", "replace")


class ClientReports:
    """The checker's end of it, where what a client says may make no sense.

    Args:
        port: of this line alone.
        who: says it, for the verdict: ``the client``.
        understand: called with each object that comes; what `msgspec.ValidationError`, `KeyError` or `TypeError` it
            raises is held against the client.

    Attributes:
        say: sends an object, as that of `ReportLine`.
    """

    def __init__(self, port: Port, who: str, understand: Callable[[Mapping[str, Any]], None]) -> None:
        self._who = who
        self._understand = understand
        self._wrong = ""
        self._line = ReportLine(port, self._take)
        self.say = self._line.say

    def require_sense(self) -> None:
        """Hold the first thing that made no sense against the client.

        Raises:
            Violation: there was one.
        """
        if wrong := self._line.senseless or self._wrong:
            raise Violation(f"{self._who} reports what makes no sense: {wrong}")

    def _take(self, said: Mapping[str, Any]) -> None:
        try:
            self._understand(said)
        except msgspec.ValidationError as error:
            self._wrong = self._wrong or f"{error} in {dict(said)}"
        except (KeyError, TypeError):
            self._wrong = self._wrong or str(dict(said))
