"""The request lines from peripherals to the DMA streams of a chip, by the names that the peripherals have for them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

__all__ = ["Listener", "Request", "Requests"]


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
    """

    __slots__ = ("_listeners", "level", "on_last", "once")

    def __init__(self) -> None:
        self.level = False
        self.once = False
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
