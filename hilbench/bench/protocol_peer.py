"""The checker's end of a line of any protocol: frames are what the protocol's own decoder makes of the bytes."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, TypeVar

from hilbench.bench import Bench
from hilbench.bench.line_peer import LinePeer, Sound, Unsound
from hilbench.errors import UsageError
from hilbench.links import Port
from hilbench.plugins.protocol import API, ProtocolPlugin
from protocols.common.checksum import Checksum
from protocols.common.decoding import Decoder
from protocols.common.items import Item, Kind

__all__ = ["QUIET_WITHIN_S", "RAW", "ProtocolPeer", "peer_of"]

KindT = TypeVar("KindT")


QUIET_WITHIN_S = 1.0
"""How long a target that goes on speaking is waited for between two cases (choice)."""


class _Bytes:
    """The decoder of a line of which no protocol is known: bytes are bytes."""

    def __init__(self, options: object, speaker: str) -> None:
        """It needs neither."""

    def find(self, data: bytes) -> list[bytes]:
        """See `protocols.common.decoding.Decoder`."""
        return [data]

    def sort(self, found: bytes) -> None:
        """Nothing distinguishes them."""

    def read(self, found: bytes) -> Item:
        """See `protocols.common.decoding.Decoder`."""
        return Item(kind=Kind.FRAME, name="bytes", raw=found, message=found)

    def feed(self, data: bytes) -> list[Item]:
        """See `protocols.common.decoding.Decoder`."""
        return [self.read(data)]

    def finish(self) -> list[Item]:
        """See `protocols.common.decoding.Decoder`."""
        return []


RAW = ProtocolPlugin(api=API, name="raw", title="raw bytes", summary="bytes as they come", decoder=_Bytes)
"""What a line speaks of which no protocol is known."""


class ProtocolPeer(LinePeer[Any]):
    """See `LinePeer`. A packet is the message that the decoder made of a frame, or its `Item` where it made none.

    Args:
        bench: whose time passes while the peer waits.
        port: the line.
        protocol: what is spoken there.
    """

    def __init__(self, bench: Bench, port: Port, protocol: ProtocolPlugin) -> None:
        self.protocol = protocol
        self._options = protocol.options()
        super().__init__(bench, port)

    def _begin_reading(self) -> None:
        self._stream = self.protocol.decoder(self._options, "target")

    def _read(self, data: bytes, at_ns: int) -> Iterator[Sound[Any] | Unsound]:
        del at_ns
        for item in self._stream.feed(data):
            if item.kind is Kind.DROPPED:
                yield Unsound(reason=item.name, data=item.raw)
            else:
                message = item if item.message is None else item.message
                yield Sound(raw=item.raw, packet=message if item.kind is Kind.FRAME else None)

    def checksum(self) -> Checksum | None:
        """See `LinePeer`."""
        return None if self.protocol.checksum is None else self.protocol.checksum(self._options)

    def _decoder(self, sent: bool) -> Decoder:
        return self.protocol.decoder(self._options, "host" if sent else "target")

    def frame_of(self, message: Any) -> bytes:
        """Return the frame of a message.

        Raises:
            UsageError: the protocol brings no encoder.
        """
        if self.protocol.encode is None:
            hint = "give its record an 'encode', or write bytes with peer.write"
            raise UsageError("makes no frames", where=f"protocol '{self.protocol.name}'", hint=hint)
        return self.protocol.encode(message, self._options)

    def send(self, message: Any) -> None:
        """Put a message on the line."""
        self.write(self.frame_of(message))

    def ask(
        self,
        message: Any,
        kind: type[KindT],
        within_s: float | None = None,
        *,
        where: Callable[[KindT], bool] | None = None,
    ) -> KindT:
        """Send a message and wait for the answer; see `expect`."""
        mark = self.mark()
        self.send(message)
        return self.expect(kind, within_s, where=where, mark=mark)

    def settle(self) -> None:
        """Do what the protocol says, listen until it is quiet, and forget what came."""
        if self.protocol.settle is not None:
            self.protocol.settle(self)
        self.wait_quiet(within_s=QUIET_WITHIN_S)
        self.forget()


def peer_of(bench: Bench, port: Port, protocol: ProtocolPlugin, program: str = "") -> LinePeer[Any]:
    """Return the checker's end of a line: the protocol's own, if it brings one.

    Args:
        bench: whose time passes while the peer waits.
        port: the line.
        protocol: what is spoken there.
        program: which of several the board runs.
    """
    return ProtocolPeer(bench, port, protocol) if protocol.peer is None else protocol.peer(bench, port, program)
