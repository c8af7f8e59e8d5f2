"""The request lines from peripherals to the DMA streams of a chip, by the names that the peripherals have for them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Protocol

__all__ = ["Channels", "Listener", "Request", "Requests", "Sources"]


class Listener(Protocol):
    """What hears a request."""

    def request_changed(self) -> None:
        """The level has changed, or one transfer was asked for."""

    def request_ended(self) -> None:
        """The peripheral, as the flow controller, has said that nothing more will come."""


class Request:
    """One line; see `targets.mcu.services.DmaRequest`. It may lead to several streams; one that leads nowhere is kept.

    Attributes:
        level: as last set.
        once: one transfer was asked for, and not made yet.
        on_last: called after the last transfer of the count that a stream was given; the peripheral's.
        private: as the peripheral says.
    """

    __slots__ = ("_listeners", "level", "on_last", "once", "private")

    in_c = None

    def __init__(self) -> None:
        self.level = False
        self.once = False
        self.private = False
        self.on_last: Callable[[], None] | None = None
        self._listeners: list[Listener] = []

    def set(self, level: bool) -> None:
        """Drive the request."""
        self.level = level
        self.once = self.once and level
        self._tell()

    def pulse(self) -> None:
        """Ask for one transfer; kept until one was made."""
        self.once = True
        self._tell()

    def end(self) -> None:
        """Say that the last transfer was made, where the peripheral is the flow controller."""
        for listener in self._listeners:
            listener.request_ended()

    def listen(self, listener: Listener) -> None:
        """Have `listener` told of changes."""
        self._listeners.append(listener)

    def ignore(self, listener: Listener) -> None:
        """Undo `listen`."""
        self._listeners.remove(listener)

    def _tell(self) -> None:
        for listener in self._listeners:
            listener.request_changed()


class Requests:
    """All lines of a chip; `line` is what it hands out as `targets.mcu.services.Services.dma`."""

    def __init__(self) -> None:
        self._lines: dict[str, Request] = {}

    def line(self, name: str) -> Request:
        """Return the line of that name."""
        return self._lines.setdefault(name, Request())


class Sources(Protocol):
    """What leads to the streams of a controller."""

    def connect(self, stream: int, listener: Listener) -> None:
        """Have a stream told of changes of every request that it could listen to."""

    def selected(self, stream: int, channel: int) -> Sequence[Request]:
        """Return what a stream listens to when it is enabled with that value of CHSEL; it may change meanwhile."""


class Channels:
    """Requests that have their places at streams and channels, as in the STM32F2, F4 and F7.

    Args:
        requests: all lines of the chip.
        names: of the requests by stream and channel.
    """

    def __init__(self, requests: Requests, names: Mapping[tuple[int, int], Sequence[str]]) -> None:
        self._lines = {place: tuple(requests.line(name) for name in at_place) for place, at_place in names.items()}

    def connect(self, stream: int, listener: Listener) -> None:
        """Have a stream told of changes of the requests of all its channels."""
        for line in {line for (number, _), lines in self._lines.items() if number == stream for line in lines}:
            line.listen(listener)

    def selected(self, stream: int, channel: int) -> Sequence[Request]:
        """Return the requests at that place."""
        return self._lines.get((stream, channel), ())
