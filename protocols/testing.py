"""For tests: two ends of a line, with a latency and faults between them, and time that passes when told to."""

from __future__ import annotations

import heapq
import itertools
import random
from collections.abc import Callable, Iterable
from typing import Any, Protocol

__all__ = ["LATENCY_NS", "Damage", "End", "Pair", "lossy"]

LATENCY_NS = 5_000_000
"""How long each write is under way, in ns."""

Damage = Callable[[bytes], bytes]
"""What becomes of the bytes of one write."""

_NEVER_NS = 1 << 62


class End(Protocol):
    """A connection of any protocol, in either role."""

    def receive(self, data: bytes, now_ns: int) -> Iterable[Any]:
        """Takes bytes; returns events."""

    def advance(self, now_ns: int) -> Iterable[Any]:
        """Lets happen what is due; returns events."""

    def next_deadline_ns(self) -> int | None:
        """When something is due, in ns."""

    def send(self, message: Any, now_ns: int) -> bytes:
        """Returns the bytes of a message."""

    def connect(self, now_ns: int) -> Iterable[Any]:
        """Begins; returns events."""

    def disconnect(self, now_ns: int) -> Iterable[Any]:
        """Ends; returns events."""

    def line_down(self, now_ns: int) -> Iterable[Any]:
        """The line is gone; returns events."""


def unchanged(data: bytes) -> bytes:
    """A line without faults."""
    return data


class Pair:
    """A client, a server and the line between them.

    Args:
        client: one end.
        server: the other.
        transmit: the kind of event whose ``data`` is to be written.
        damage: what the line does to each write, in either direction.

    Attributes:
        now_ns: the time.
        seen: every other event: time, "client" or "server", event.
    """

    def __init__(self, client: End, server: End, *, transmit: type[Any], damage: Damage = unchanged) -> None:
        self.client = client
        self.server = server
        self.now_ns = 0
        self.damage = damage
        self.seen: list[tuple[int, str, Any]] = []
        self._transmit = transmit
        self._order = itertools.count()
        self._flying: list[tuple[int, int, str, bytes]] = []

    # --- what a protocol has besides

    def answer(self, end: str, event: Any) -> None:
        """What the program at an end does about an event."""

    def moment(self) -> None:
        """What the programs do when the bytes and timers of a moment are done."""

    def next_moment_ns(self) -> int | None:
        """When they do something next, in ns."""
        return None

    # --- what a user does

    def connect(self) -> None:
        """The client begins."""
        self._take("client", self.client.connect(self.now_ns))

    def disconnect(self) -> None:
        """The client ends."""
        self._take("client", self.client.disconnect(self.now_ns))

    def send(self, end: str, message: Any) -> None:
        """The program at an end sends a message."""
        self.write(end, self._end(end).send(message, self.now_ns))

    def write(self, end: str, data: bytes) -> None:
        """Bytes leave an end."""
        other = "server" if end == "client" else "client"
        data = self.damage(data)
        if data:
            heapq.heappush(self._flying, (self.now_ns + LATENCY_NS, next(self._order), other, data))

    def line_down(self) -> None:
        """The line goes down, at both ends."""
        self._flying.clear()
        for end in ("client", "server"):
            self._take(end, self._end(end).line_down(self.now_ns))

    def run(self, duration_ns: int) -> None:
        """Lets time pass, moment by moment."""
        end_ns = self.now_ns + duration_ns
        while (next_ns := self._next_ns()) <= end_ns:
            self.now_ns = next_ns
            self._moment()
        self.now_ns = end_ns

    # --- what was seen

    def of(self, kind: Any) -> list[Any]:
        """The events of a kind, at both ends."""
        return [event for _, _, event in self.seen if isinstance(event, kind)]

    def _end(self, end: str) -> End:
        return self.client if end == "client" else self.server

    def _next_ns(self) -> int:
        times = [self.client.next_deadline_ns(), self.server.next_deadline_ns(), self.next_moment_ns()]
        times += [self._flying[0][0]] if self._flying else []
        return min((time for time in times if time is not None), default=_NEVER_NS)

    def _moment(self) -> None:
        while self._flying and self._flying[0][0] <= self.now_ns:
            _, _, end, data = heapq.heappop(self._flying)
            self._take(end, self._end(end).receive(data, self.now_ns))
        for end in ("client", "server"):
            self._take(end, self._end(end).advance(self.now_ns))
        self.moment()

    def _take(self, end: str, events: Iterable[Any]) -> None:
        for event in events:
            if isinstance(event, self._transmit):
                self.write(end, event.data)
            else:
                self.seen.append((self.now_ns, end, event))
                self.answer(end, event)


def lossy(seed: int, *, drop: float = 0.0, flip: float = 0.0, repeat: float = 0.0, noise: float = 0.0) -> Damage:
    """Damage to each write, each with its probability: cut short, a bit turned, the whole twice, noise before it."""
    chance = random.Random(seed)

    def damage(data: bytes) -> bytes:
        if chance.random() < drop:
            data = data[: chance.randrange(len(data) + 1)]
        if data and chance.random() < flip:
            at = chance.randrange(len(data))
            data = data[:at] + bytes((data[at] ^ 1 << chance.randrange(8),)) + data[at + 1 :]
        if chance.random() < repeat:
            data += data
        if chance.random() < noise:
            data = chance.randbytes(chance.randrange(8)) + data
        return data

    return damage
