"""A door for programs that speak over TCP: the same byte stream as on the serial line, one client at a time."""

from __future__ import annotations

import contextlib
import fcntl
import select
import socket
import struct
import termios

from hilbench.clock import Scheduler
from hilbench.errors import UnavailableError, UsageError
from hilbench.links.door import READ_BYTES, Door, Input
from hilbench.links.port import Line
from hilbench.links.uart import Timeline

LOCAL_HOST = "127.0.0.1"
# What a client may leave unread, beyond what its own kernel takes in, before output is lost. The kernel would keep
# megabytes: minutes of a slow line, which would then be read as if they were fresh. A small send buffer is no way to
# say so: it counts memory, and a byte that was sent by itself takes more than a kilobyte until it is acknowledged.
_UNREAD_BYTES = 16 * 1024
_INT = struct.Struct("i")


def parse_tcp_address(text: str) -> tuple[str, int]:
    """Return host and port of `[HOST:]PORT`; the host is 127.0.0.1 by default and an IPv6 host stands in brackets.

    Raises:
        UsageError: `text` is something else.
    """
    host, _, port = text.rpartition(":")
    if not (port.isascii() and port.isdigit() and int(port) < 65536):
        raise UsageError(f"not a TCP address: {text!r}", hint="write PORT or HOST:PORT, such as 8101 or 0.0.0.0:8101")
    return host.removeprefix("[").removesuffix("]") or LOCAL_HOST, int(port)


class TcpDoor(Door):
    """A listening TCP socket; the line is up while a client is connected.

    A second client is turned away and counted. A client that closes its end has hung up. What a client does not read is
    lost and counted.

    Args:
        scheduler: Owner of bench time, locked to the host's clock before it runs.
        address: `[HOST:]PORT`; port 0 takes a free one.
        line: Baud rate of the wire behind the door, 0 for no pace.
        name: For the journal and for messages.
        chip_time: Time of the chip whose USART the door leads to; None if it leads to anything else.

    Raises:
        UsageError: the address is not one.
        UnavailableError: the port is in use, or the host is not this one.

    Attributes:
        host: Where it listens.
        port: Where it listens.
    """

    def __init__(
        self,
        scheduler: Scheduler,
        address: str,
        line: Line | None = None,
        *,
        name: str = "tcp",
        chip_time: Timeline | None = None,
    ) -> None:
        super().__init__(scheduler, name, line or Line(), chip_time)
        self._listener = _listen(address)
        self.host, self.port = self._listener.getsockname()[:2]
        self._client: socket.socket | None = None
        self._client_input: Input | None = None
        self._listening = Input(descriptor=self._listener.fileno(), read=self._accept)
        scheduler.add_source(self._listening)

    def _accept(self, at_ns: int) -> None:
        if self._client is not None and _has_hung_up(self._client):
            self._scheduler.remove_source(self._listening)  # it is leaving: who comes now waits until it is gone
            return
        try:
            client, _ = self._listener.accept()
        except OSError:
            return  # gone again
        if self._client is not None:
            self.counters.refused += 1
            with contextlib.suppress(OSError):
                client.shutdown(socket.SHUT_RDWR)
            client.close()
            self.on_turned_away()
            return
        client.setblocking(False)
        client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._client = client
        self._client_input = Input(descriptor=client.fileno(), read=self._read)
        self._scheduler.add_source(self._client_input)
        self._in_order(at_ns, self._client_came)
        self._greet()

    def _read(self, at_ns: int) -> None:
        if self._client is None or self._client_input is None:
            return
        try:
            data = self._client.recv(READ_BYTES)
        except BlockingIOError:
            return
        except OSError:
            data = b""
        if data:
            self._take(self._client_input, data, at_ns)
            return
        # The session ends when its last bytes are through the wire; who connects meanwhile waits to be accepted.
        self._scheduler.remove_source(self._client_input)
        self._scheduler.remove_source(self._listening)
        self._in_order(at_ns, self._client_left)

    def _greet(self) -> None:
        """Say what a client is told when it has connected: nothing."""

    def _take(self, source: Input, data: bytes, at_ns: int) -> None:
        """Take what a client has sent: all of it is for the line."""
        self._came_in(source, data, at_ns)

    def _put(self, data: bytes, _at_ns: int) -> None:
        self.counters.lost += len(data) - self._send(data[: self._room()])

    def _room(self) -> int:
        """Return how many bytes the client may still leave unread."""
        return 0 if self._client is None else _UNREAD_BYTES - _unread_bytes(self._client)

    def _send(self, data: bytes) -> int:
        """Give bytes to the client; return how many were taken."""
        if self._client is not None and data:
            with contextlib.suppress(OSError):
                return self._client.send(data)
        return 0

    def _client_gone(self) -> None:
        self._drop_client()
        self._scheduler.add_source(self._listening)

    def _drop_client(self) -> None:
        if self._client is not None and self._client_input is not None:
            self._scheduler.remove_source(self._client_input)
            self._client.close()
            self._client = self._client_input = None

    def _release(self) -> None:
        self._drop_client()
        self._scheduler.remove_source(self._listening)
        self._listener.close()


def _has_hung_up(client: socket.socket) -> bool:
    """Say whether the far end has closed, even if bytes of it are still to be read."""
    poll = select.poll()
    poll.register(client, select.POLLRDHUP)
    return bool(poll.poll(0))


def _unread_bytes(client: socket.socket) -> int:
    """Return how many bytes the far end has not acknowledged (tcp(7), SIOCOUTQ)."""
    (unread,) = _INT.unpack(fcntl.ioctl(client, termios.TIOCOUTQ, bytes(_INT.size)))
    return min(int(unread), _UNREAD_BYTES)


def _listen(address: str) -> socket.socket:
    host, port = parse_tcp_address(address)
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    listener = socket.socket(family, socket.SOCK_STREAM)
    try:
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.bind((host, port))
        listener.listen(4)
        listener.setblocking(False)
    except OSError as error:
        listener.close()
        reason = error.strerror or str(error)
        hint = "choose another port, or 0 for any"
        raise UnavailableError(f"cannot listen: {reason}", where=f"{host}:{port}", hint=hint) from error
    return listener
