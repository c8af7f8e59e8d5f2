"""The relay: what the checker has of a line, so that a right peer at its far end becomes a wrong one."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Protocol

from hilbench.clock import NS_PER_S, Scheduler
from hilbench.links import Port
from hilbench.links.front import PortInFront
from measure.mutants.derived.fields import Reading
from measure.mutants.derived.mutant import Piece
from protocols.common.items import Item

__all__ = ["Lane", "Listener", "Relay"]

Listener = Callable[[Sequence[Item]], None]
"""Told what passes, read."""


class Lane(Protocol):
    """What is done to one direction."""

    def take(self, items: Sequence[Item], now_ns: int) -> list[Piece]:
        """Take what came in a row; return what goes on."""


class Relay(PortInFront):
    """See the module.

    What the peer says is read as a stream: a frame goes on with its last byte. What the checker says goes on as it was
    written: a frame that it says in pieces is handed on in pieces, as it is, so that nothing of its timing is lost.

    Args:
        scheduler: whose time it lives in.
        port: the checker's end of the line.
        said: how what the peer says is read.
        heard: how what the checker says is read.
        on_said: what is done to the one; None lets it through.
        on_heard: the same to the other.
        tell_said: told what the peer says.
        tell_heard: told what the checker says, by the piece.
    """

    def __init__(
        self,
        scheduler: Scheduler,
        port: Port,
        said: Reading,
        heard: Reading,
        *,
        on_said: Lane | None = None,
        on_heard: Lane | None = None,
        tell_said: Listener | None = None,
        tell_heard: Listener | None = None,
    ) -> None:
        super().__init__(port)
        self.counters = port.counters
        port.on_sent = self._handed_over
        self._scheduler = scheduler
        self._heard = heard
        self._read_said = said.stream()
        self._on_said, self._on_heard = on_said, on_heard
        self._tell_said, self._tell_heard = tell_said, tell_heard

    def write(self, data: bytes) -> None:
        """Take what the checker says."""
        if self._on_heard is None and self._tell_heard is None:
            self.port.write(data)
            return
        items = self._heard.whole(data)
        if b"".join(item.raw for item in items) != data:
            self.port.write(data)
            return
        if self._tell_heard is not None:
            self._tell_heard(items)
        if self._on_heard is None:
            self.port.write(data)
        else:
            self._hand_on(self._on_heard.take(items, self._scheduler.now_ns), self._to_peer)

    def _received(self, data: bytes, at_ns: int) -> None:
        if self._on_said is None and self._tell_said is None:
            self.on_receive(data, at_ns)
            return
        items = self._read_said(data)
        if self._tell_said is not None and items:
            self._tell_said(items)
        if self._on_said is None:
            self.on_receive(data, at_ns)
        elif items:
            self._hand_on(self._on_said.take(items, at_ns), self._to_checker)

    def _hand_on(self, pieces: Sequence[Piece], hand: Callable[[bytes], None]) -> None:
        now = b"".join(piece.data for piece in pieces if not piece.late_s)
        if now:
            hand(now)
        for piece in pieces:
            if piece.late_s and piece.data:
                self._scheduler.after(round(piece.late_s * NS_PER_S), partial(hand, piece.data), source="relay")

    def _to_peer(self, data: bytes) -> None:
        if not self.closed:
            self.port.write(data)

    def _to_checker(self, data: bytes) -> None:
        if not self.closed:
            self.on_receive(data, self._scheduler.now_ns)

    def _handed_over(self, data: bytes, at_ns: int) -> None:
        self.on_sent(data, at_ns)
