"""A door for programs that speak over TCP: the same byte stream as on the serial line."""

from __future__ import annotations

import contextlib
import fcntl
import select
import socket
import struct
import termios
from functools import partial

from hilbench.clock import Scheduler
from hilbench.errors import UnavailableError, UsageError
from hilbench.links.door import READ_BYTES, Door, Input
from hilbench.links.port import Line
from hilbench.links.uart import Timeline
from hilbench.terminal.options import Clients

LOCAL_HOST = "127.0.0.1"
# What a client may leave unread, beyond what its own kernel takes in, before output is lost. The kernel would keep
# megabytes: minutes of a slow line, which would then be read as if they were fresh. A small send buffer is no way to
# say so: it counts memory, and a byte that was sent by itself takes more than a kilobyte until it is acknowledged.
_UNREAD_BYTES = 16 * 1024
# Beyond so many clients (choice) the one that has been silent for longest is disconnected: what some program leaks at
# each of its attempts must neither keep it out nor use up our descriptors.
_MOST_CLIENTS = 16
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


class Client:
    """Somebody who is connected.

    Attributes:
        connection: the socket.
        input: what is watched of it.
        has_come: whether what is older than its coming has left the wire.
    """

    def __init__(self, connection: socket.socket, source: Input) -> None:
        self.connection = connection
        self.input = source
        self.has_come = False

    def send(self, data: bytes) -> int:
        """Give bytes to it; return how many were taken."""
        with contextlib.suppress(OSError):
            return self.connection.send(data) if data else 0
        return 0

    @property
    def room(self) -> int:
        """How many bytes it may still leave unread."""
        return _UNREAD_BYTES - _unread_bytes(self.connection)


class TcpDoor(Door):
    """A listening TCP socket; the line is up while a client is connected.

    A client that closes its end has hung up. Where several are served, their chunks are let through one behind the
    other as they come, and each gets what comes out. What no client reads is lost and counted.

    Args:
        scheduler: Owner of bench time, locked to the host's clock before it runs.
        address: `[HOST:]PORT`; port 0 takes a free one.
        line: Baud rate of the wire behind the door, 0 for no pace.
        clients: Who is served; a client that is turned away is counted.
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
        clients: Clients = Clients.FIRST,
        name: str = "tcp",
        chip_time: Timeline | None = None,
    ) -> None:
        super().__init__(scheduler, name, line or Line(), chip_time)
        self._listener = _listen(address)
        self.host, self.port = self._listener.getsockname()[:2]
        self._served = clients
        self._clients: list[Client] = []  # the one that has been silent for longest comes first
        self._is_leaving = False  # the last one has hung up, and its last bytes are under way
        self._listening = Input(descriptor=self._listener.fileno(), read=self._accept)
        scheduler.add_source(self._listening)

    def _accept(self, at_ns: int) -> None:
        there = len(self._clients)
        leaving = there > 0 and all(_has_hung_up(client.connection) for client in self._clients)
        if leaving and self._served is not Clients.NEWEST:
            self._scheduler.remove_source(self._listening)  # who comes now waits until the bytes before his are through
            if self._served is Clients.ALL:
                self.on_visit("another client waits until the bytes of the previous ones have been received")
            return
        try:
            connection, _ = self._listener.accept()
        except OSError:
            return  # gone again
        if there and self._served is Clients.FIRST:
            self._turn_away(connection)
            return
        connection.setblocking(False)
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        client = Client(connection, Input(descriptor=connection.fileno(), read=lambda at_ns: self._read(client, at_ns)))
        said = ""
        if there and self._served is Clients.NEWEST:
            # What one that has gone had still to say could keep the line for minutes.
            self._drop_all()
            self._is_leaving = False
            before = "had left, and what it had still to say is lost" if leaving else "was disconnected"
            self._in_order(at_ns, partial(self._take_over, before))
        elif there:
            said = f"another client came: {there + 1} are connected"
            if there == _MOST_CLIENTS:
                said = f"another client came; {there} were connected, and the one silent for longest was disconnected"
                self._drop(self._clients[0])
        self._clients.append(client)
        self._scheduler.add_source(client.input)
        self._in_order(at_ns, partial(self._has_come, client, said))
        self._greet(client)

    def _turn_away(self, connection: socket.socket) -> None:
        self.counters.refused += 1
        with contextlib.suppress(OSError):
            connection.shutdown(socket.SHUT_RDWR)
        connection.close()
        self.on_visit("a client was refused: another one is connected")

    def _take_over(self, before: str) -> None:
        self.on_visit(f"another client came and took over; the one before it {before}")
        self._hang_up_now()

    def _has_come(self, client: Client, said: str) -> None:
        if client not in self._clients:
            return
        client.has_come = True
        if said:
            self.on_visit(said)
        self._client_came()

    def _read(self, client: Client, at_ns: int) -> None:
        if client not in self._clients:
            return
        try:
            data = client.connection.recv(READ_BYTES)
        except BlockingIOError:
            return
        except OSError:
            data = b""
        if data:
            self._clients.append(self._clients.pop(self._clients.index(client)))
            self._take(client, data, at_ns)
        elif len(self._clients) > 1:
            self._drop(client)
            self._in_order(at_ns, partial(self.on_visit, f"one client left: {len(self._clients)} still connected"))
        else:
            # The session ends when its last bytes are through the wire; who connects meanwhile waits to be accepted, or
            # takes over.
            self._scheduler.remove_source(client.input)
            if self._served is Clients.FIRST:
                self._scheduler.remove_source(self._listening)
            self._in_order(at_ns, partial(self._has_left, client))

    def _has_left(self, client: Client) -> None:
        if client in self._clients:
            self._is_leaving = True
            self._client_left()

    def _greet(self, client: Client) -> None:
        """Say what a client is told when it has connected: nothing."""

    def _take(self, client: Client, data: bytes, at_ns: int) -> None:
        """Take what a client has sent: all of it is for the line."""
        self._came_in(client.input, data, at_ns)

    def _put(self, data: bytes, _at_ns: int) -> None:
        self._share_out(data)

    def _share_out(self, data: bytes) -> None:
        """Give what came off the line to each client; what none of them takes is lost."""
        taken = [self._give(client, data) for client in self._clients if client.has_come]
        self.counters.lost += len(data) - max(taken, default=0)

    def _give(self, client: Client, data: bytes) -> int:
        """Give what came off the line to a client; return how many bytes of it were taken."""
        return client.send(data[: client.room])

    def disconnect(self) -> None:
        """Hang up on whoever is there."""
        if self._clients:
            self._drop_all()
            self._hang_up_now()

    def _client_gone(self) -> None:
        if self._is_leaving:
            self._is_leaving = False
            self._drop_all()
        self._scheduler.remove_source(self._listening)  # it may be watched already
        self._scheduler.add_source(self._listening)

    def _drop(self, client: Client) -> None:
        """Let go of a client, at once."""
        self._clients.remove(client)
        self._scheduler.remove_source(client.input)
        if client.input in self._held:
            self._held.remove(client.input)
        client.connection.close()

    def _drop_all(self) -> None:
        for client in tuple(self._clients):
            self._drop(client)

    def _release(self) -> None:
        self._drop_all()
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
        listener.listen(_MOST_CLIENTS)
        listener.setblocking(False)
    except OSError as error:
        listener.close()
        reason = error.strerror or str(error)
        hint = "choose another port, or 0 for any"
        raise UnavailableError(f"cannot listen: {reason}", where=f"{host}:{port}", hint=hint) from error
    return listener
