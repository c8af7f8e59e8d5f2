"""The request lines from peripherals to the DMA streams of a chip, by the names that the peripherals have for them.

The lines are in C: ``requests.c``.
"""

from __future__ import annotations

import ctypes
import functools
import weakref
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Protocol

from targets.mcu.core.library import with_lock_held
from targets.mcu.errors import EngineError
from targets.mcu.services import RequestInC

__all__ = ["Channels", "Request", "Requests", "Sources"]

_MOST_LINES = 256


class Request:
    """One line; see `targets.mcu.services.DmaRequest`. It may lead to several streams, and to none.

    Args:
        owner: all lines of the chip.
        number: of the line.

    Attributes:
        number: as given.
        in_c: the line in C.
    """

    __slots__ = ("_block", "_on_last", "_owner", "in_c", "number", "pulse", "set")

    def __init__(self, owner: Requests, number: int) -> None:
        library, block = _library(), owner.block
        self._owner = owner  # which frees what is in C
        self.number = number
        self.in_c = RequestInC(block, number)
        self.set: Callable[[bool], None] = functools.partial(library.hil_lines_drive, block, number)
        self.pulse: Callable[[], None] = functools.partial(library.hil_lines_pulse, block, number)
        self._block = block
        self._on_last: Callable[[], None] | None = None

    @property
    def level(self) -> bool:
        """As last set."""
        return bool(_library().hil_lines_level(self._block, self.number))

    @property
    def on_last(self) -> Callable[[], None] | None:
        """Called after the last transfer of the count that a stream was given; the peripheral's."""
        return self._on_last

    @on_last.setter
    def on_last(self, listener: Callable[[], None] | None) -> None:
        self._on_last = listener
        _library().hil_lines_tell_last(self._block, self.number)

    def left(self) -> int:
        """Return how many accesses the streams that listen have still to make; one that is being made counts."""
        return int(_library().hil_lines_left(self._block, self.number))

    def end(self) -> None:
        """Say that the last transfer was made, where the peripheral is the flow controller."""
        _library().hil_lines_end(self._block, self.number)


class Requests:
    """All lines of a chip; `line` is what it hands out as `targets.mcu.services.Services.dma`.

    Attributes:
        block: ``struct hil_request_lines *``; it must last as long as the peripherals.

    Raises:
        EngineError: there is no memory.
    """

    def __init__(self) -> None:
        block = _library().hil_lines_new()
        if not block:
            raise EngineError("there is no memory for the requests of a chip")
        self.block = ctypes.c_void_p(block)
        weakref.finalize(self, _library().hil_lines_free, self.block).atexit = False
        self._lines: dict[str, Request] = {}
        self._by_number: list[Request] = []

    def line(self, name: str) -> Request:
        """Return the line of that name."""
        if name not in self._lines:
            assert len(self._by_number) < _MOST_LINES, "no chip has that many"
            self._lines[name] = Request(self, len(self._by_number))
            self._by_number.append(self._lines[name])
        return self._lines[name]

    def save(self) -> Callable[[], object]:
        """Return what makes the lines in C what they are now."""
        kept = ctypes.string_at(self.block, _library().hil_lines_size())
        return functools.partial(ctypes.memmove, self.block, kept, len(kept))

    def tell_last(self, number: int) -> None:
        """Tell the peripheral of a line that the last transfer of a count was made."""
        listener = self._by_number[number].on_last
        if listener is not None:
            listener()


class Sources(Protocol):
    """What leads to the streams of a controller."""

    @property
    def requests(self) -> Requests:
        """All lines of the chip."""

    def connect(self, stream: int, on_change: Callable[[], None]) -> None:
        """Call `on_change` when a stream is to listen to other requests than it was enabled with."""

    def selected(self, stream: int, channel: int) -> Sequence[Request]:
        """Return what a stream listens to that is enabled with that value of CHSEL."""


class Channels:
    """Requests that have their places at streams and channels, as in the STM32F2, F4 and F7.

    Args:
        requests: all lines of the chip.
        names: of the requests by stream and channel.

    Attributes:
        requests: as given.
    """

    def __init__(self, requests: Requests, names: Mapping[tuple[int, int], Sequence[str]]) -> None:
        self.requests = requests
        self._lines = {place: tuple(requests.line(name) for name in at_place) for place, at_place in names.items()}

    def connect(self, stream: int, on_change: Callable[[], None]) -> None:
        """Nothing: what a stream listens to is chosen when it is enabled."""

    def selected(self, stream: int, channel: int) -> Sequence[Request]:
        """Return the requests at that place."""
        return self._lines.get((stream, channel), ())


@functools.cache
def _library() -> Any:
    """Return the library, with the functions of request lines declared, called with Python's lock held."""
    library: Any = with_lock_held()
    pointer, word = ctypes.c_void_p, ctypes.c_uint32
    library.hil_lines_size.argtypes, library.hil_lines_size.restype = (), ctypes.c_uint32
    library.hil_lines_new.argtypes, library.hil_lines_new.restype = (), pointer
    library.hil_lines_free.argtypes, library.hil_lines_free.restype = (pointer,), None
    library.hil_lines_drive.argtypes, library.hil_lines_drive.restype = (pointer, word, ctypes.c_bool), None
    for function in (library.hil_lines_pulse, library.hil_lines_end, library.hil_lines_tell_last):
        function.argtypes, function.restype = (pointer, word), None
    library.hil_lines_left.argtypes, library.hil_lines_left.restype = (pointer, word), word
    library.hil_lines_level.argtypes, library.hil_lines_level.restype = (pointer, word), ctypes.c_bool
    return library
