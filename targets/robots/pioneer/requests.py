"""Packets a client asks for: once, as a stream, or not at all.

A request is a flag, not a counter: asked twice within one SIP cycle, a packet is sent once (choice). Packets go out
after the SIP of the cycle, in the order of `Extra`, as far as the line has room in it: at 9600 bit/s a SIP with sixteen
sonar readings takes 84 of the 100 ms. The others stay due, once each.
"""

from __future__ import annotations

import enum


class Extra(enum.Enum):
    """Packets besides the SIP, in sending order."""

    CONFIG = "CONFIG"
    ENCODER = "ENCODER"
    IO = "IO"
    GRIPPER = "GRIPPER"
    GYRO = "GYRO"
    JOYSTICK = "JOYSTICK"
    TCM2 = "TCM2"
    PLAYLIST = "PLAYLIST"
    BATTERY = "BATTERY"


class RequestBook:
    """Who asked for what."""

    def __init__(self) -> None:
        self._once: set[Extra] = set()
        self._streams: set[Extra] = set()

    def ask(self, extra: Extra, argument: int) -> None:
        """0 stops the stream, 1 asks once (and leaves a stream running), 2 or more starts a stream.

        Source: Pioneer 2 / PeopleBot Operations Manual, ENCODER, IOREQUEST and GRIPREQUEST.
        """
        if argument <= 0:
            self._once.discard(extra)
            self._streams.discard(extra)
        elif argument == 1:
            self._once.add(extra)
        else:
            self._streams.add(extra)

    def due(self) -> tuple[Extra, ...]:
        """Return what the present cycle should send."""
        return tuple(extra for extra in Extra if extra in self._once or extra in self._streams)

    def sent(self, extra: Extra) -> None:
        """Take note that a packet was sent; a single request is then done."""
        self._once.discard(extra)

    def clear(self) -> None:
        """Cancel everything (end of a session)."""
        self._once.clear()
        self._streams.clear()
