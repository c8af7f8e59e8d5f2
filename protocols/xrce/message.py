"""A message: its header, and submessages behind it.

    session id  stream id  sequence low  sequence high  client key (4 bytes, if the session id is below 80)  submessages

OMG DDS-XRCE 1.0, 8.3.2. The submessages begin at multiples of 4 from the header's end, which is one itself.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from protocols.xrce.codes import has_client_key
from protocols.xrce.errors import LocalProtocolError, RemoteProtocolError

__all__ = ["Header", "decode_header", "encode_message", "pack_submessages"]

_SHORT_HEADER_BYTES = 4
_KEY_BYTES = 4


@dataclass(frozen=True, slots=True, kw_only=True)
class Header:
    """What stands before the submessages.

    Attributes:
        session_id: 0 and 128 outside of any session; below 128 there is a client key.
        stream_id: 0 none, 1..127 best-effort, 128..255 reliable.
        sequence: 0..65535, of the stream; 0 without one.
        client_key: 4 bytes, or None.
    """

    session_id: int
    stream_id: int = 0
    sequence: int = 0
    client_key: bytes | None = None

    def __post_init__(self) -> None:
        """Checks the figures; LocalProtocolError names the wrong one."""
        for name, most in (("session_id", 0xFF), ("stream_id", 0xFF), ("sequence", 0xFFFF)):
            if not 0 <= getattr(self, name) <= most:
                raise LocalProtocolError(f"{name} {getattr(self, name)} is not 0..{most}")
        if has_client_key(self.session_id) is (self.client_key is None):
            raise LocalProtocolError(
                f"session {self.session_id:#04x} and client key {self.client_key!r} do not go together"
            )
        if self.client_key is not None and len(self.client_key) != _KEY_BYTES:
            raise LocalProtocolError(f"client key {self.client_key!r} is not {_KEY_BYTES} bytes")

    @property
    def size(self) -> int:
        """Bytes that it takes."""
        return _SHORT_HEADER_BYTES + len(self.client_key or b"")


def encode_message(header: Header, body: bytes) -> bytes:
    """A message: its header, and submessages as `pack_submessages` puts them together."""
    start = bytes((header.session_id, header.stream_id)) + header.sequence.to_bytes(2, "little")
    return start + (header.client_key or b"") + body


def pack_submessages(submessages: Iterable[bytes]) -> bytes:
    """Encoded submessages one behind the other, each at a multiple of 4."""
    packed = bytearray()
    for one in submessages:
        packed += bytes(-len(packed) % 4) + one
    return bytes(packed)


def decode_header(message: bytes) -> tuple[Header, bytes]:
    """The header of a message, and what stands behind it.

    Raises:
        RemoteProtocolError: the message is shorter than its header.
    """
    size = _SHORT_HEADER_BYTES + (_KEY_BYTES if message and has_client_key(message[0]) else 0)
    if len(message) < size:
        raise RemoteProtocolError(f"a message of {len(message)} bytes is shorter than its header")
    header = Header(
        session_id=message[0],
        stream_id=message[1],
        sequence=int.from_bytes(message[2:4], "little"),
        client_key=message[_SHORT_HEADER_BYTES:size] or None,
    )
    return header, message[size:]
