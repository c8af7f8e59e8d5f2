"""Codecs of single values in CDR, out of which others are put together."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any

from protocols.xrce.cdr.stream import CdrReader, CdrWriter

__all__ = ["TEXT", "Codec", "Number"]


class Codec(ABC):
    """Writes values of one kind, and reads them."""

    @abstractmethod
    def write(self, out: CdrWriter, value: Any) -> None:
        """Writes one; LocalProtocolError if it does not fit."""

    @abstractmethod
    def read(self, data: CdrReader) -> Any:
        """Reads one; RemoteProtocolError if there is none."""


class Number(Codec):
    """A number, with its code in `struct`."""

    def __init__(self, code: str) -> None:
        self._code = code

    def write(self, out: CdrWriter, value: Any) -> None:
        """See `Codec`."""
        out.number(self._code, value)

    def read(self, data: CdrReader) -> Any:
        """See `Codec`."""
        return data.number(self._code)


class _Text(Codec):
    """A string."""

    def write(self, out: CdrWriter, value: Any) -> None:
        """See `Codec`."""
        out.text(value)

    def read(self, data: CdrReader) -> Any:
        """See `Codec`."""
        return data.text()


TEXT = _Text()
