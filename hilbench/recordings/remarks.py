"""What a person must know of a recording that is not all there, in the same words whoever reads it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

__all__ = ["remarks_on"]


def remarks_on(header: Mapping[str, Any], problem: str | None, done: str) -> Iterator[str]:
    """Say that it is a later part of a journal with a limit, and where it was cut or is damaged.

    Args:
        header: the header of the recording.
        problem: what ended its reading; None if nothing did.
        done: what was done with the rest, such as ``compared``.
    """
    if header.get("part"):
        yield "its beginning is in an older file"
    if problem is not None:
        yield f"{problem}: {done} up to there"
