"""Reads a stream for people: bytes in, items out, in order and without a gap.

A decoder starts nothing and judges nothing: what is on the line it shows, with the reason where it makes no sense.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Iterator, Sequence
from dataclasses import dataclass, fields
from enum import Enum
from typing import Any, Generic, Protocol, TypeVar, cast

from protocols.common.items import Item, Kind

__all__ = ["Decoder", "NoOptions", "Reader", "ReaderDecoder", "Speaker", "fields_of", "message_item"]

Speaker = str
"""Who sends a stream: ``host``, ``target``, or empty if that is not known."""

FoundT_co = TypeVar("FoundT_co", covariant=True)
FrameT = TypeVar("FrameT", bound="Found")
RejectedT = TypeVar("RejectedT", bound="Rejected")


@dataclass(frozen=True, slots=True)
class NoOptions:
    """How the frames of a protocol are read that has but one form."""


class Decoder(Protocol):
    """Reads one stream. Whoever looks at few of many frames finds them all, and reads those."""

    def find(self, data: bytes) -> Sequence[Any]:
        """Take bytes; return what they complete, not read yet."""

    def sort(self, found: Any) -> Hashable:
        """Return what distinguishes a frame from those of other messages; None of bytes that are no frame."""

    def read(self, found: Any) -> Item:
        """Read what was found."""

    def feed(self, data: bytes) -> Iterable[Item]:
        """Take bytes; return what they complete."""

    def finish(self) -> Iterable[Item]:
        """Return what is left when nothing more comes."""


class Found(Protocol):
    """A frame, or bytes that are none, as the reader of a protocol returns them."""

    @property
    def raw(self) -> bytes:
        """All of its bytes."""


class Rejected(Protocol):
    """Bytes that are no frame."""

    @property
    def data(self) -> bytes:
        """The bytes."""

    @property
    def reason(self) -> Enum:
        """Why they are none; its value says it in words."""


class Reader(Protocol[FoundT_co]):
    """Finds the frames of a protocol in a stream."""

    def receive(self, data: bytes, now_ns: int) -> Sequence[FoundT_co]:
        """Take bytes that came at a time, in ns; return the frames and the rejected bytes that they complete."""

    def reset(self) -> Sequence[FoundT_co]:
        """Return what is left when nothing more comes."""


class ReaderDecoder(Generic[FrameT, RejectedT]):
    """A decoder made of a protocol's own reader of frames.

    Args:
        reader: finds them.
        rejected: the class of bytes that are no frame.
        senseless: what `item` raises of a frame whose content makes no sense.
        body: the attribute with what a frame carries; its first byte says which message that is, if `sort` does
            not.
        item: reads a sound frame. A dashboard that goes back in a recording copies decoders with `pickle`: a function
            at the top level of its module, or a `functools.partial` of one.
        sort: likewise a function; returns what distinguishes a frame from those of other messages.
    """

    def __init__(
        self,
        reader: Reader[FrameT | RejectedT],
        *,
        rejected: type[RejectedT],
        senseless: type[Exception],
        body: str,
        item: Callable[[FrameT], Item],
        sort: Callable[[FrameT], Hashable] | None = None,
    ) -> None:
        self._reader = reader
        self._rejected = rejected
        self._senseless = senseless
        self._body = body
        self._item = item
        self._sort = sort

    def feed(self, data: bytes) -> Iterator[Item]:
        """See `Decoder`."""
        return map(self.read, self.find(data))

    def find(self, data: bytes) -> Sequence[FrameT | RejectedT]:
        """See `Decoder`."""
        return self._reader.receive(data, 0)

    def sort(self, found: FrameT | RejectedT) -> Hashable:
        """See `Decoder`."""
        if isinstance(found, self._rejected):
            return None
        frame = cast("FrameT", found)
        return bytes(getattr(frame, self._body)[:1]) if self._sort is None else self._sort(frame)

    def finish(self) -> Iterator[Item]:
        """See `Decoder`."""
        return map(self.read, self._reader.reset())

    def read(self, found: FrameT | RejectedT) -> Item:
        """See `Decoder`."""
        if isinstance(found, self._rejected):
            return Item(kind=Kind.DROPPED, name=str(found.reason.value), raw=found.data)
        frame = cast("FrameT", found)
        try:
            return self._item(frame)
        except self._senseless as error:
            return Item(kind=Kind.UNREADABLE, name=str(error), raw=frame.raw)


def message_item(frame: Found, message: Any) -> Item:
    """Return a frame as what its message says, a dataclass or named tuple: its class and its fields."""
    name = type(message).__name__
    return Item(kind=Kind.FRAME, name=name, raw=frame.raw, fields=fields_of(message), message=message)


def fields_of(message: Any) -> dict[str, object]:
    """Return the fields of a message, a dataclass or named tuple, by their names."""
    if isinstance(message, tuple):
        return dict(message._asdict())  # type: ignore[attr-defined]
    return {field.name: getattr(message, field.name) for field in fields(message)}
