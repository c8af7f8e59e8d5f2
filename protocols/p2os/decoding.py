"""The frames of P2OS for people who look at a line: what a robot sends, or what a client sends to it.

SYNC0, SYNC1 and SYNC2 of a handshake are the same bytes as PULSE, OPEN and CLOSE without an argument in a session. The
name of a client's frame depends on those before it in its stream; a stream is taken to begin outside a session.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass

from protocols.common.checksum import Checksum
from protocols.common.decoding import Decoder, NoOptions, ReaderDecoder, Speaker, message_item
from protocols.common.items import Item, Kind
from protocols.common.layout import Body, Region, laid_out
from protocols.p2os.command_table import CommandNumber
from protocols.p2os.commands import Command, command_name, decode_command, encode_command
from protocols.p2os.errors import RemoteProtocolError
from protocols.p2os.framing import Dropped, Frame, FrameReader
from protocols.p2os.framing import checksum as body_checksum
from protocols.p2os.packets import ServerPacket, decode_packet, encode_packet

__all__ = ["checksum", "decoder", "encode", "regions"]

_PULSE, _OPEN, _CLOSE = (bytes((number,)) for number in (CommandNumber.PULSE, CommandNumber.OPEN, CommandNumber.CLOSE))


def decoder(options: NoOptions, speaker: Speaker) -> Decoder:
    """Return a decoder of what a host sends, or of what its far end does."""
    del options
    if speaker == "host":
        return ReaderDecoder(
            _CommandReader(),
            rejected=Dropped,
            senseless=RemoteProtocolError,
            body="body",
            item=_command_item,
            sort=_sort_of_command,
        )
    return ReaderDecoder(FrameReader(), rejected=Dropped, senseless=RemoteProtocolError, body="body", item=_packet)


def encode(message: Command | ServerPacket, options: NoOptions) -> bytes:
    """Return the frame of a client's command, or of a robot's packet.

    Raises:
        LocalProtocolError: something does not fit its place.
    """
    del options
    return encode_command(message) if isinstance(message, Command) else encode_packet(message)


def regions(raw: bytes, options: NoOptions, *, sent: bool) -> list[Region]:
    """Return what the bytes of a sound frame are; `sent` by the host, or heard from its far end."""
    del options
    body = Body(raw[3:-2], decode_command if sent else _packet_in, RemoteProtocolError)
    middle = body.sizes("number" if sent else "type")
    return laid_out(raw, [("header", 2), ("count", 1), *middle, ("checksum", 2)])


def checksum(options: NoOptions) -> Checksum:
    """Return how a frame is checked: by a sum over its body."""
    del options
    return Checksum(value=_sum_from, begin=0, first=3, stop=-2, at=-2, size=2, order="big")


def _sum_from(body: bytes, begin: int) -> int:
    return body_checksum(body) + begin


@dataclass(frozen=True, slots=True)
class _Command:
    """A frame of a client, and the name of its SYNC; empty if it is none."""

    raw: bytes
    body: bytes
    sync: str


class _CommandReader:
    """Finds the frames of a client, and which of them are SYNCs."""

    def __init__(self) -> None:
        self._frames = FrameReader()
        self._last = b""
        self._sync = ""
        self._in_session = False

    def receive(self, data: bytes, now_ns: int) -> Sequence[_Command | Dropped]:
        """See `FrameReader.receive`."""
        return [self._named(found) for found in self._frames.receive(data, now_ns)]

    def reset(self) -> Sequence[_Command | Dropped]:
        """See `FrameReader.reset`."""
        return [self._named(found) for found in self._frames.reset()]

    def _named(self, found: Frame | Dropped) -> _Command | Dropped:
        if isinstance(found, Dropped):
            return found
        self._sync = self._sync_of(found.body)
        self._last = found.body
        self._in_session = not self._sync and found.body[:1] != _CLOSE
        return _Command(raw=found.raw, body=found.body, sync=self._sync)

    def _sync_of(self, body: bytes) -> str:
        """Return which SYNC a body is in its place; a client repeats each of them until it is answered.

        Behind a PULSE, OPEN without an argument is the SYNC1 of a client that begins anew: a session is opened once.
        """
        if body == _PULSE and not self._in_session:
            return "SYNC0"
        if body == _OPEN and (self._last == _PULSE or self._sync == "SYNC1"):
            return "SYNC1"
        if body == _CLOSE and self._sync in {"SYNC1", "SYNC2"}:
            return "SYNC2"
        return ""


def _sort_of_command(command: _Command) -> Hashable:
    return command.sync or command.body[:1]


def _command_item(command: _Command) -> Item:
    decoded = decode_command(command.body)
    fields = {} if decoded.argument is None else {"argument": decoded.argument}
    name = command.sync or command_name(decoded.number)
    return Item(kind=Kind.FRAME, name=name, raw=command.raw, fields=fields, message=decoded)


def _packet(frame: Frame) -> Item:
    return message_item(frame, _packet_in(frame.body))


def _packet_in(body: bytes) -> ServerPacket:
    return decode_packet(body, connected=False)
