"""Decodes a stream for people: bytes in, items out, in order, every byte in one item.

A decoder sends nothing and judges nothing. It shows what is on the line; for bytes that make no sense, it gives the
reason.
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
    """The options of a protocol whose frames can be read in one way only."""


class Decoder(Protocol):
    """Decodes one stream. `find` splits it into frames, `read` decodes one of them; `feed` does both."""

    def find(self, data: bytes) -> Sequence[Any]:
        """Take bytes; return the frames and rejected bytes that they complete, not decoded yet."""

    def sort(self, found: Any) -> Hashable:
        """Return a key that frames of the same message share; None for bytes that are no frame."""

    def read(self, found: Any) -> Item:
        """Decode what `find` has returned."""

    def feed(self, data: bytes) -> Iterable[Item]:
        """Take bytes; return the items that they complete."""

    def finish(self) -> Iterable[Item]:
        """Return the items that are left at the end of the stream."""


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
        reader: finds the frames.
        rejected: the class of rejected bytes.
        senseless: the exception that `item` raises for a frame whose content makes no sense.
        body: the name of the attribute with the payload of a frame. Its first byte is the key of the message, unless
            there is a `sort`.
        item: makes the item of a valid frame. The dashboard copies decoders with `pickle`, so it is a function at the
            top level of a module, or a `functools.partial` of one.
        sort: returns a key that frames of the same message share; a function like `item`.
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
