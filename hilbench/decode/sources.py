"""Where bytes come from: a file of bytes, a hex dump, or a journal, each read as it comes, or a capture of one.

All but a capture may never end.

A hex dump is pairs of hex digits, with or without spaces, as people and the programs xxd, hexdump -C and od -t x1 write
them: an offset before and letters behind are passed over, and so is what follows a ``#``.
"""

from __future__ import annotations

import json
import os
import re
from collections.abc import Callable, Iterator, Mapping
from typing import Any

from hilbench.errors import UnavailableError
from hilbench.recordings.chunks import Chunk, chunk_of
from hilbench.recordings.event_form import wrong_with
from hilbench.recordings.layout import BYTE_KINDS
from hilbench.recordings.remarks import remarks_on

__all__ = ["FORMS", "read_chunks"]

FORMS = ("auto", "raw", "hex", "journal", "capture")

_CAPTURES = (b"\n\r\r\n", b"\x89MCAP0\r\n", b"time_s,ns,kind,", b"\xd4\xc3\xb2\xa1", b"\xa1\xb2\xc3\xd4")
"""What pcapng, MCAP, the table of ``hilbench export`` and an older pcap begin with; the last is refused there."""
_READ_BYTES = 65536
_ENOUGH = 4
_TEXT = re.compile(rb"[\t\r -~]*")
"""So many bytes tell a hex dump from bytes as they are."""
_LONGEST_LINE = 16 * 1024 * 1024

_PLAIN = (re.compile(""), re.compile(r"$"))
_DUMPS = (
    (re.compile(r"[0-9A-Fa-f]{8}:(?:\s|$)"), re.compile(r"\s\s.*$")),  # xxd
    (re.compile(r"[0-9A-Fa-f]{8}(?:\s\s|$)"), re.compile(r"\s*\|.*$")),  # hexdump -C
    (re.compile(r"[0-7]{7}(?:\s|$)"), re.compile(r"\s*>.*$")),  # od -t x1, with z or without
)
"""What stands before the bytes of a line, and behind."""
_PAIRS = re.compile(r"^(?:[0-9A-Fa-f]{2}[\s,]*)*$")


Say = Callable[[str], None]
"""Takes what a person must know of a source: that it was cut, or where its beginning is."""


def read_chunks(descriptor: int, where: str, form: str, say: Say) -> Iterator[Chunk]:
    """Read a source piece by piece.

    Args:
        descriptor: an open file.
        where: its name, for messages.
        form: one of `FORMS`.
        say: takes remarks.

    Raises:
        UnavailableError: it cannot be read, or is not of this form; the line is named.
    """
    pieces = _pieces(descriptor, where)
    if form == "auto":
        form, pieces = _guess(pieces)
    if form == "raw":
        for piece in pieces:
            yield Chunk(data=piece)
    elif form == "hex":
        yield from _hex(pieces, where)
    elif form == "capture":
        yield from _capture(pieces, where, say)
    else:
        yield from _journal(pieces, where, say)


def _pieces(descriptor: int, where: str) -> Iterator[bytes]:
    while True:
        try:
            piece = os.read(descriptor, _READ_BYTES)
        except OSError as error:
            raise UnavailableError(f"cannot be read: {error.strerror}", where=where) from error
        if not piece:
            return
        yield piece


def _guess(pieces: Iterator[bytes]) -> tuple[str, Iterator[bytes]]:
    """Return what form it seems to have, and the pieces from the first one on."""
    head, form = b"", ""
    for piece in pieces:
        head += piece
        form = _form_of(head)
        if form or len(head) >= _READ_BYTES:
            break

    def again() -> Iterator[bytes]:
        if head:
            yield head
        yield from pieces

    return form or "raw", again()


def _form_of(head: bytes) -> str:
    """Return the form of what begins like this; empty while only blanks and comments of a hex dump have come.

    A comment alone proves no dump: frames may begin with its sign, too.
    """
    if head.startswith(_CAPTURES):
        return "capture"
    start = head.lstrip()
    if len(start) < _ENOUGH:
        return ""
    if start.startswith(b'{"'):
        return "journal"
    for line in start.split(b"\n"):
        if not _TEXT.fullmatch(line):
            return "raw"
        if line.strip() and not line.lstrip().startswith(b"#"):
            return _form_of_line(line.decode("ascii"))
    return ""


def _form_of_line(line: str) -> str:
    try:
        _HexDump().take(line)
    except ValueError:
        return "raw"
    return "hex"


def _lines(pieces: Iterator[bytes], where: str) -> Iterator[tuple[int, str, bool]]:
    """Yield number and text of each line, and whether it is whole."""
    rest, number = b"", 0
    for piece in pieces:
        *whole, rest = (rest + piece).split(b"\n")
        if len(rest) > _LONGEST_LINE:
            raise UnavailableError("a line that never ends", where=f"{where}:{number + 1}")
        for line in whole:
            number += 1
            yield number, line.decode("utf-8", "replace"), True
    if rest:
        yield number + 1, rest.decode("utf-8", "replace"), False


class _HexDump:
    """Takes the lines of one dump; the first with bytes says of which kind it is."""

    def __init__(self) -> None:
        self._kind: tuple[re.Pattern[str], re.Pattern[str]] | None = None

    def take(self, line: str) -> bytes:
        """Return the bytes of a line; ValueError if it is none of a dump."""
        text = line.strip() if self._kind in _DUMPS else line.partition("#")[0].strip()
        if not text:
            return b""
        if self._kind is None:
            self._kind = next((kind for kind in _DUMPS if " " in text and kind[0].match(text)), _PLAIN)
        before, behind = self._kind
        text = behind.sub("", before.sub("", text, count=1).lstrip(), count=1)
        if not _PAIRS.match(text):
            raise ValueError(text)
        return bytes.fromhex(re.sub(r"[\s,]", "", text))


def _hex(pieces: Iterator[bytes], where: str) -> Iterator[Chunk]:
    dump = _HexDump()
    for number, line, _ in _lines(pieces, where):
        try:
            data = dump.take(line)
        except ValueError:
            message = f"'{line.strip()[:40]}' is no line of a hex dump"
            raise UnavailableError(message, where=f"{where}:{number}", hint="--input raw for bytes") from None
        if data:
            yield Chunk(data=data)


def _journal(pieces: Iterator[bytes], where: str, say: Say) -> Iterator[Chunk]:
    header: Mapping[str, Any] = {}
    problem = None
    for number, line, whole in _lines(pieces, where):
        event = _event_in(line)
        if event is None and whole:
            raise UnavailableError("is no event of a journal", where=f"{where}:{number}")
        if event is None:
            problem = f"cut in line {number}"
        elif event["kind"] == "journal":
            header = header or event
        elif (chunk := chunk_of(event)) is not None:
            yield chunk
    for remark in remarks_on(header, problem, "decoded"):
        say(remark)


def _event_in(line: str) -> Mapping[str, Any] | None:
    """Return the event of a line; None if it is none, or has bytes that cannot be placed."""
    try:
        event = json.loads(line)
        damaged = event["kind"] in BYTE_KINDS and wrong_with(event)
    except (ValueError, TypeError, KeyError, RecursionError):
        return None
    return None if damaged else event


def _capture(pieces: Iterator[bytes], where: str, say: Say) -> Iterator[Chunk]:
    """Read a file whole, and tell its events like those of a journal."""
    from hilbench.recordings.reading import parse_recording

    recording = parse_recording(b"".join(pieces), where)
    for event in recording.events:
        chunk = chunk_of(event)
        if chunk is not None:
            yield chunk
    for remark in remarks_on(recording.header, recording.problem, "decoded"):
        say(remark)
