"""The frames of P2OS for people who look at a line: what a robot sends, or what a client sends to it."""

from __future__ import annotations

from protocols.common.checksum import Checksum
from protocols.common.decoding import Decoder, NoOptions, ReaderDecoder, Speaker, message_item
from protocols.common.items import Item, Kind
from protocols.common.layout import Body, Region, laid_out
from protocols.p2os.commands import command_name, decode_command
from protocols.p2os.errors import RemoteProtocolError
from protocols.p2os.framing import Dropped, Frame, FrameReader
from protocols.p2os.framing import checksum as body_checksum
from protocols.p2os.packets import ServerPacket, decode_packet

__all__ = ["checksum", "decoder", "regions"]


def decoder(options: NoOptions, speaker: Speaker) -> Decoder:
    """Return a decoder of what a host sends, or of what its far end does."""
    del options
    return ReaderDecoder(
        FrameReader(),
        rejected=Dropped,
        senseless=RemoteProtocolError,
        body="body",
        item=_command if speaker == "host" else _packet,
    )


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


def _command(frame: Frame) -> Item:
    command = decode_command(frame.body)
    fields = {} if command.argument is None else {"argument": command.argument}
    return Item(kind=Kind.FRAME, name=command_name(command.number), raw=frame.raw, fields=fields)


def _packet(frame: Frame) -> Item:
    return message_item(frame, _packet_in(frame.body))


def _packet_in(body: bytes) -> ServerPacket:
    return decode_packet(body, connected=False)
