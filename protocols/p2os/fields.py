"""Reading and writing the fields of a server packet; a read past the end is the peer's error, never an IndexError."""

from __future__ import annotations

from protocols.p2os.errors import LocalProtocolError, RemoteProtocolError

__all__ = ["FieldReader", "FieldWriter"]


class FieldReader:
    """Takes fields off the front of a body, starting behind the type byte. Integers are little-endian."""

    __slots__ = ("_at", "_body")

    def __init__(self, body: bytes, at: int = 1) -> None:
        self._body = body
        self._at = at

    @property
    def left(self) -> int:
        """How many bytes are not read yet."""
        return len(self._body) - self._at

    def raw(self, size: int) -> bytes:
        """The next `size` bytes.

        Raises:
            RemoteProtocolError: the body ends before.
        """
        end = self._at + size
        if end > len(self._body):
            raise RemoteProtocolError(f"packet {self._body[:1].hex()} ends {end - len(self._body)} bytes too early")
        data = self._body[self._at : end]
        self._at = end
        return data

    def rest(self) -> bytes:
        """All that is left."""
        return self.raw(self.left)

    def unsigned(self, size: int = 1) -> int:
        """An unsigned integer of `size` bytes."""
        return int.from_bytes(self.raw(size), "little")

    def signed(self, size: int = 1) -> int:
        """A two's complement integer of `size` bytes."""
        return int.from_bytes(self.raw(size), "little", signed=True)

    def text(self) -> str:
        """A string (Latin-1) up to its NUL.

        Raises:
            RemoteProtocolError: there is no NUL.
        """
        end = self._body.find(b"\0", self._at)
        if end < 0:
            raise RemoteProtocolError(f"packet {self._body[:1].hex()} has a string without its NUL")
        data = self.raw(end - self._at)
        self._at += 1
        return data.decode("latin-1")


class FieldWriter:
    """Builds a body, field by field, behind a type byte."""

    __slots__ = ("_body",)

    def __init__(self, packet_type: int) -> None:
        self._body = bytearray((packet_type,))

    @property
    def body(self) -> bytes:
        """The body so far."""
        return bytes(self._body)

    def raw(self, data: bytes) -> None:
        """Bytes as they are."""
        self._body += data

    def unsigned(self, name: str, value: int, size: int = 1) -> None:
        """An unsigned integer of `size` bytes.

        Raises:
            LocalProtocolError: it does not fit; the message has the name.
        """
        self._integer(name, value, size, signed=False)

    def signed(self, name: str, value: int, size: int = 1) -> None:
        """A two's complement integer of `size` bytes.

        Raises:
            LocalProtocolError: it does not fit; the message has the name.
        """
        self._integer(name, value, size, signed=True)

    def text(self, name: str, value: str) -> None:
        """A string and its NUL.

        Raises:
            LocalProtocolError: it holds a NUL or a character that is not Latin-1; the message has the name.
        """
        try:
            data = value.encode("latin-1")
        except UnicodeEncodeError:
            raise LocalProtocolError(f"{name}: {value!r} is not Latin-1") from None
        if b"\0" in data:
            raise LocalProtocolError(f"{name}: {value!r} holds a NUL")
        self._body += data + b"\0"

    def _integer(self, name: str, value: int, size: int, *, signed: bool) -> None:
        try:
            self._body += value.to_bytes(size, "little", signed=signed)
        except OverflowError:
            kind = "a signed" if signed else "an unsigned"
            raise LocalProtocolError(f"{name}: {value} does not fit in {kind} integer of {size} bytes") from None
