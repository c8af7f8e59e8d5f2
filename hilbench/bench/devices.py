"""Puts a sans-IO device on a port of the bench.

A device (a robot's controller, one side of a protocol) knows nothing of ports and clocks: it is given bytes and a time,
gives bytes back, and names the time at which it wants to be called again. The actor here does the calling.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from typing import Generic, Protocol, TypeVar

from hilbench.bench import Bench
from hilbench.clock import Entry, EventClass
from hilbench.errors import PluginError
from hilbench.links import Port

_MOST_TIMES = 10_000
"""How often a device may be due at one moment (choice)."""

EventT = TypeVar("EventT")
EventT_co = TypeVar("EventT_co", covariant=True)


class SerialDevice(Protocol):
    """Something that talks over a serial line, without I/O."""

    def receive(self, data: bytes, now_ns: int) -> bytes:
        """Take bytes off the line; return what to put on it."""

    def advance(self, now_ns: int) -> bytes:
        """Do what is due at ``now_ns``; return what to put on the line."""

    def next_deadline_ns(self) -> int | None:
        """Return the time at which `advance` must be called, or None."""

    def line_down(self, now_ns: int) -> bytes:
        """Take note that the line was hung up; return what to put on it."""

    def take_events(self) -> Iterable[object]:
        """Return what happened since the last call."""


class Talk(Protocol):
    """An event that is nothing but bytes for the line."""

    @property
    def data(self) -> bytes:
        """The bytes."""


class ClientRole(Protocol[EventT_co]):
    """The client role of a protocol: says what happened by events, the bytes for the line among them."""

    def receive(self, data: bytes, now_ns: int) -> Sequence[EventT_co]:
        """Take bytes off the line."""

    def advance(self, now_ns: int) -> Sequence[EventT_co]:
        """Do what is due at ``now_ns``."""

    def next_deadline_ns(self) -> int | None:
        """Return the time at which `advance` must be called, or None."""

    def line_down(self, now_ns: int) -> Sequence[EventT_co]:
        """Take note that the line was hung up."""


class ClientDevice(Generic[EventT]):
    """Makes a serial device of the client role: its events, less the bytes, are what it reports.

    Args:
        connection: the client role.
        talk: the kind of its events that are bytes for the line.
    """

    def __init__(self, connection: ClientRole[EventT], talk: type[Talk]) -> None:
        self._connection = connection
        self._talk = talk
        self._events: list[EventT] = []

    def receive(self, data: bytes, now_ns: int) -> bytes:
        """Take bytes off the line; return what to put on it."""
        return self.take(self._connection.receive(data, now_ns))

    def advance(self, now_ns: int) -> bytes:
        """Do what is due at ``now_ns``; return what to put on the line."""
        return self.take(self._connection.advance(now_ns))

    def next_deadline_ns(self) -> int | None:
        """Return the time at which `advance` must be called, or None."""
        return self._connection.next_deadline_ns()

    def line_down(self, now_ns: int) -> bytes:
        """Take note that the line was hung up; return what to put on it."""
        return self.take(self._connection.line_down(now_ns))

    def take_events(self) -> list[EventT]:
        """Return what happened since the last call."""
        events, self._events = self._events, []
        return events

    def take(self, events: Sequence[EventT]) -> bytes:
        """Keep events that were got from the role directly; return what to put on the line."""
        self._events += [event for event in events if not isinstance(event, self._talk)]
        return b"".join(event.data for event in events if isinstance(event, self._talk))


class LinesDevice(Protocol):
    """As `SerialDevice`, at several lines: what is to be put on them comes with their names."""

    def receive(self, line: str, data: bytes, now_ns: int) -> Iterable[tuple[str, bytes]]:
        """Take bytes off a line; return what to put on the lines."""

    def advance(self, now_ns: int) -> Iterable[tuple[str, bytes]]:
        """Do what is due at ``now_ns``; return what to put on the lines."""

    def next_deadline_ns(self) -> int | None:
        """Return the time at which `advance` must be called, or None."""

    def line_down(self, line: str, now_ns: int) -> Iterable[tuple[str, bytes]]:
        """Take note that a line was hung up; return what to put on the lines."""

    def take_events(self) -> Iterable[object]:
        """Return what happened since the last call."""


class _Reporting(Protocol):
    """What every device has."""

    def next_deadline_ns(self) -> int | None: ...

    def take_events(self) -> Iterable[object]: ...


class _Actor(ABC):
    """Records what a device reports, and calls it when it is due."""

    def __init__(
        self,
        bench: Bench,
        device: _Reporting,
        *,
        name: str,
        on_event: Callable[[object], None],
        after: Callable[[], None],
    ) -> None:
        self._bench = bench
        self._reporting = device
        self._name = name
        self._on_event = on_event
        self._after = after
        self._entry: Entry | None = None
        self._entry_ns: int | None = None
        self._due_ns = -1
        self._times = 0

    def settle(self) -> None:
        """Record what the device reports and book its next call; call this after touching the device directly."""
        for event in self._reporting.take_events():
            self._bench.record_event(self._name, event)
            self._on_event(event)
        self._after()
        self._book()
        if self._bench.on_settled is not None:
            self._bench.on_settled()

    @abstractmethod
    def _advance(self) -> None:
        """Let the device do what is due now."""

    def _write(self, port: Port, data: bytes, **about: object) -> None:
        if not isinstance(data, bytes):
            raise PluginError(f"returned {type(data).__name__}, not bytes", where=f"device '{self._name}'")
        if data:
            self._bench.record("tx", self._name, **about, data=data)
            port.write(data)

    def _due(self) -> None:
        self._entry = None
        again = self._bench.now_ns == self._due_ns
        self._due_ns, self._times = self._bench.now_ns, self._times + 1 if again else 0
        if self._times > _MOST_TIMES:
            message = f"is due at {self._due_ns} ns for ever: advance() does not move next_deadline_ns()"
            raise PluginError(message, where=f"device '{self._name}'")
        self._advance()

    def _book(self) -> None:
        deadline_ns = self._reporting.next_deadline_ns()
        if self._entry is not None and deadline_ns == self._entry_ns:
            return
        if self._entry is not None:
            self._bench.scheduler.cancel(self._entry)
            self._entry = None
        if deadline_ns is not None:
            when_ns = max(deadline_ns, self._bench.now_ns)
            self._entry = self._bench.scheduler.at(when_ns, self._due, order=EventClass.TIMER, source=self._name)
            self._entry_ns = deadline_ns


class DeviceActor(_Actor):
    """Calls a device when bytes arrive, when it is due, and when the line goes down.

    Args:
        bench: whose time and journal are used.
        device: what to call.
        port: the device's end of its link.
        name: the source name in the journal.
        on_event: called for each event the device reports, after it is recorded.
        after: called whenever the device has been called.
    """

    def __init__(
        self,
        bench: Bench,
        device: SerialDevice,
        port: Port,
        *,
        name: str,
        on_event: Callable[[object], None] = lambda _event: None,
        after: Callable[[], None] = lambda: None,
    ) -> None:
        super().__init__(bench, device, name=name, on_event=on_event, after=after)
        self._device = device
        self._port = port
        port.on_receive = self._received
        port.on_line = self._line_changed
        self.settle()

    def transmit(self, data: bytes) -> None:
        """Put bytes of the device on its line, and settle."""
        self._write(self._port, data)
        self.settle()

    def _received(self, data: bytes, at_ns: int) -> None:
        self.transmit(self._device.receive(data, at_ns))

    def _advance(self) -> None:
        self.transmit(self._device.advance(self._bench.now_ns))

    def _line_changed(self, up: bool, at_ns: int) -> None:
        self._bench.record("line", self._name, up=up)
        if not up:
            self.transmit(self._device.line_down(at_ns))


class LinesActor(_Actor):
    """As `DeviceActor`, for a device at several lines.

    Args:
        bench: whose time and journal are used.
        device: what to call.
        ports: the device's ends of its links, by the names that it has for them.
        name: the source name in the journal.
        on_event: called for each event the device reports, after it is recorded.
    """

    def __init__(
        self,
        bench: Bench,
        device: LinesDevice,
        ports: Mapping[str, Port],
        *,
        name: str,
        on_event: Callable[[object], None] = lambda _event: None,
    ) -> None:
        super().__init__(bench, device, name=name, on_event=on_event, after=lambda: None)
        self._device = device
        self._ports = ports
        for line, port in ports.items():
            port.on_receive = partial(self._received, line)
            port.on_line = partial(self._line_changed, line)
        self.settle()

    def transmit(self, sent: Iterable[tuple[str, bytes]]) -> None:
        """Put bytes of the device on its lines, and settle."""
        for line, data in sent:
            self._write(self._ports[line], data, line=line)
        self.settle()

    def _received(self, line: str, data: bytes, at_ns: int) -> None:
        self.transmit(self._device.receive(line, data, at_ns))

    def _advance(self) -> None:
        self.transmit(self._device.advance(self._bench.now_ns))

    def _line_changed(self, line: str, up: bool, at_ns: int) -> None:
        self._bench.record("line", self._name, line=line, up=up)
        if not up:
            self.transmit(self._device.line_down(line, at_ns))
