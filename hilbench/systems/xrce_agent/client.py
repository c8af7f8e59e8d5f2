"""A board with micro-ROS as it is meant to be, as a model: it finds its agent again, whatever becomes of that."""

from __future__ import annotations

import struct
from collections.abc import Iterable

from hilbench.clock import NS_PER_MS, NS_PER_S
from hilbench.systems.xrce_agent.board import OBJECTS, READER, WRITER
from hilbench.systems.xrce_agent.settings import ClientSettings
from protocols import xrce
from protocols.state_machine import earliest

__all__ = ["ModelClient"]

_KEY = b"\x48\x42\x00\x03"
_EVERY_NS = 100 * NS_PER_MS
_MOST_WAITING = 8


class ModelClient:
    """See the module; a device at the agent's line. It writes a number each 100 ms, as long as these are acknowledged.

    Args:
        settings: how long it waits for what.
        key: of the client, 4 bytes.
    """

    def __init__(self, settings: ClientSettings, *, key: bytes = _KEY) -> None:
        self._settings = settings
        options = xrce.ClientOptions(client_key=key, attempts=1, retry_s=settings.retry_s)
        self._session = xrce.Session(xrce.Role.CLIENT, options)
        self._events: list[object] = []
        self._next_ns = self._heard_ns = self._asked_ns = 0
        self._written = 0

    @property
    def observed(self) -> xrce.Session:
        """What a dashboard looks at."""
        return self._session

    def receive(self, data: bytes, now_ns: int) -> bytes:
        """Take bytes off the line; return what to put on it."""
        frames = self._session.counters.frames_in
        events = self._session.receive(data, now_ns)
        if self._session.counters.frames_in > frames:
            self._heard_ns = now_ns
        return self._take(events, now_ns)

    def advance(self, now_ns: int) -> bytes:
        """Do what is due; return what to put on the line."""
        sent = self._take(self._session.advance(now_ns), now_ns)
        if self._session.state is xrce.ClientState.OPEN:
            sent += self._watch(now_ns)
        if now_ns < self._next_ns:
            return sent
        if self._session.state is xrce.ClientState.CLOSED:
            self._next_ns = now_ns + round(self._settings.retry_s * NS_PER_S)
            return sent + self._take(self._session.connect(now_ns), now_ns)
        self._next_ns = now_ns + _EVERY_NS
        return sent + self._write(now_ns)

    def next_deadline_ns(self) -> int | None:
        """Return when `advance` must be called, in ns."""
        return earliest(self._session.next_deadline_ns(), self._next_ns)

    def line_down(self, now_ns: int) -> bytes:
        """Take note that the line was hung up."""
        return self._lose(now_ns)

    def take_events(self) -> list[object]:
        """Return what happened since the last call."""
        events, self._events = self._events, []
        return events

    def leave(self, now_ns: int) -> bytes:
        """Say farewell; it asks for a session anew when that is answered."""
        return self._take(self._session.disconnect(now_ns), now_ns)

    def _watch(self, now_ns: int) -> bytes:
        """Ask a silent agent whether it has the session still; give up one that is silent for too long."""
        silence_s = (now_ns - self._heard_ns) / NS_PER_S
        if silence_s >= self._settings.lost_s:
            return self._lose(now_ns)
        if silence_s < self._settings.quiet_s or now_ns < self._asked_ns:
            return b""
        self._asked_ns = now_ns + round(self._settings.quiet_s * NS_PER_S)
        return self._session.ping(now_ns)

    def _lose(self, now_ns: int) -> bytes:
        self._next_ns = now_ns
        return self._take(self._session.line_down(now_ns), now_ns)

    def _write(self, now_ns: int) -> bytes:
        session = self._session
        if session.state is not xrce.ClientState.OPEN or session.unacknowledged >= _MOST_WAITING:
            return b""
        self._written += 1
        data = struct.pack("<f", self._written)
        return session.send(xrce.WriteData(request_id=session.new_request_id(), object_id=WRITER, data=data), now_ns)

    def _take(self, events: Iterable[xrce.Event], now_ns: int) -> bytes:
        sent = b""
        for event in events:
            match event:
                case xrce.Transmit():
                    sent += event.data
                    continue
                case xrce.SessionOpened():
                    self._heard_ns = now_ns
                    sent += self._begin(now_ns)
                case xrce.Pong(in_session=False) if self._session.state is xrce.ClientState.OPEN:
                    sent += self._lose(now_ns)
            self._events.append(event)
        return sent

    def _begin(self, now_ns: int) -> bytes:
        """Create everything, and ask for all samples."""
        session = self._session
        sent = [
            session.send(xrce.Create(request_id=session.new_request_id(), object_id=one, object=made), now_ns)
            for one, made in OBJECTS.items()
        ]
        specification = xrce.ReadSpecification(
            stream_id=xrce.BUILTIN_RELIABLE, delivery=xrce.DeliveryControl(max_samples=xrce.UNLIMITED)
        )
        asked = xrce.ReadData(request_id=session.new_request_id(), object_id=READER, specification=specification)
        return b"".join((*sent, session.send(asked, now_ns)))
