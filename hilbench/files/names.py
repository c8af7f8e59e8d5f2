"""Names of files as text: a file system holds bytes, and they need not be UTF-8, nor a locale be able to say them.

Python hands such bytes on inside a `str` as lone surrogates (PEP 383), which neither UTF-8 nor JSON can hold.
"""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

from hilbench.errors import UsageError

__all__ = ["as_utf8", "escaped", "escaped_all", "file_name", "json_text", "printable"]


def escaped(text: str) -> str:
    """Return a text that UTF-8 can hold: bytes that came in as they were are UTF-8 again, or spelled as hex escapes."""
    if text.isascii():
        return text
    try:
        return text.encode("utf-8", "surrogateescape").decode("utf-8", "backslashreplace")
    except UnicodeEncodeError:  # a surrogate that is no byte of a name
        return text.encode("utf-8", "backslashreplace").decode()


def escaped_all(value: Any) -> Any:
    """Return plain data with all its texts `escaped`."""
    if isinstance(value, str):
        return escaped(value)
    if isinstance(value, dict):
        return {escaped(name): escaped_all(item) for name, item in value.items()}
    return [escaped_all(item) for item in value] if isinstance(value, list | tuple) else value


def printable(text: str) -> str:
    """Return a text of somebody else's, such as what a device calls itself, that cannot move a terminal."""
    return text if text.isprintable() else "".join(one if one.isprintable() else "\ufffd" for one in text)


def json_text(value: object) -> str:
    """Return plain data as indented JSON."""
    return json.dumps(escaped_all(value), indent=2)


def file_name(text: str) -> str:
    """Return what the file system calls a file that a UTF-8 text names, also where the locale has no such letters."""
    try:
        os.fsencode(text)
    except UnicodeEncodeError:
        return os.fsdecode(text.encode())
    return text


def as_utf8(path: str | Path) -> str:
    """Return how a UTF-8 text names a file; the inverse of `file_name`.

    Raises:
        UsageError: its name is not UTF-8.
    """
    try:
        return os.fsencode(path).decode("utf-8")
    except UnicodeDecodeError:
        raise UsageError(
            "its name is not UTF-8, so a bench file cannot contain it", where=str(path), hint="rename it"
        ) from None
