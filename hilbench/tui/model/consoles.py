"""What firmware says in words: by semihosting, by ITM, or on a UART that carries text."""

from __future__ import annotations

from collections import deque
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any

__all__ = ["ConsoleLine", "ConsoleModel", "plain"]

Event = Mapping[str, Any]
KEPT_LINES = 2000
_LONGEST = 400
_ENOUGH = 0.8
"""How much of a chunk of a UART is printable, if it is text (choice)."""


@dataclass(slots=True)
class ConsoleLine:
    """A line, or as much of it as has come.

    Attributes:
        ns: bench time at which it began.
        source: who said it, by board and channel.
        text: what; what is no letter stands there by its number.
        ended: whether its end has come.
    """

    ns: int
    source: str
    text: str
    ended: bool = False


class ConsoleModel:
    """The latest lines of all channels.

    Args:
        live: what the header of the journal says of the bench.
    """

    def __init__(self, live: Event) -> None:
        self.lines: deque[ConsoleLine] = deque(maxlen=KEPT_LINES)
        self._boards: Collection[str] = live.get("boards", {})
        self._open: dict[str, ConsoleLine] = {}
        self._no_text: set[str] = set()

    def take(self, event: Event) -> None:
        """Take what a console says, or what a board sends on a UART as long as that is text; nothing that is heard."""
        source = event["source"]
        if event["kind"] == "rx":
            return
        if event["kind"] == "tx" and source.partition(".")[0] not in self._boards:
            return
        data = bytes.fromhex(event["data"])
        if event["kind"] == "tx" and not self._is_text(source, data):
            return
        for number, piece in enumerate(data.decode("utf-8", errors="replace").replace("\r\n", "\n").split("\n")):
            if number and source in self._open:
                self._open.pop(source).ended = True
            if piece:
                self._add(source, event["ns"], plain(piece))

    def _add(self, source: str, ns: int, text: str) -> None:
        line = self._open.get(source)
        if line is None or len(line.text) > _LONGEST:
            line = self._open[source] = ConsoleLine(ns, source, "")
            self.lines.append(line)
        line.text += text

    def _is_text(self, source: str, data: bytes) -> bool:
        if source not in self._no_text and _printable(data) < _ENOUGH:
            self._no_text.add(source)
            kept = [line for line in self.lines if line.source != source]
            self.lines.clear()
            self.lines.extend(kept)
            self._open.pop(source, None)
        return source not in self._no_text


def plain(text: str) -> str:
    """Return a text without what a terminal would obey."""
    return "".join(one if one.isprintable() else "" if one == "\r" else f"\\x{ord(one):02x}" for one in text)


def _printable(data: bytes) -> float:
    return sum(32 <= value < 127 or value in {9, 10, 13} for value in data) / max(1, len(data))
