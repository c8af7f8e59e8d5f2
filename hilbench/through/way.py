"""The way that bytes are sent: a client at a door, with a proxy in between if that is asked for.

It is made of what a bench has in real time: the door that ``hilbench serve`` opens, the port by which ``hilbench check
--target`` opens it, the relay of ``hilbench proxy``. Only their clocks differ; see `hilbench.through.loop`.
"""

from __future__ import annotations

import contextlib
import tempfile
from concurrent.futures import Future, ThreadPoolExecutor
from functools import partial
from pathlib import Path

from hilbench.bench import Bench
from hilbench.errors import InternalError, UnavailableError
from hilbench.journal import Journal
from hilbench.links import Line, Port, PtyDoor, ReconnectingPort, Rfc2217Door, SerialTarget, TcpDoor
from hilbench.links.door import Door
from hilbench.serving.relay import Relay
from hilbench.through.loop import Loop, Stage, arrived, settle

__all__ = ["Way"]

_PIECE_BYTES = 1024  # a terminal keeps 4095 bytes that nobody has read (n_tty of Linux)
_BAUD = 115_200
"""What both ends say their rate is, where they have to say one; the door is not paced, and time stands still."""
_ATTEMPTS = 3
"""How often a client tries to come in (choice): that of RFC 2217 gives up after 3 s of a host that stands still."""


class Way:
    """A client at a door, and perhaps a relay between the two. A `hilbench.through.port.Route`.

    Args:
        kind: one of `hilbench.terminal.options.THROUGH`.
        name: of the line, for messages.

    Attributes:
        passed: see `Route`; each byte has been compared, and where there is a relay that has had it.

    Raises:
        UnavailableError: it cannot be opened.
    """

    def __init__(self, kind: str, name: str) -> None:
        self._name = name
        self._relays: list[Loop] = []
        self._relayed = self.passed = 0
        self._at_far_end, self._at_near_end = bytearray(), bytearray()
        with contextlib.ExitStack() as self._stack:
            folder = self._folder() if kind in {"pty", "proxy"} else Path()
            self._near, self._far = self._loop(), self._loop()
            self._door, url = self._open_door(kind, self._far, folder / "board")
            entrance: Door = self._door
            if kind == "proxy":
                entrance, url = self._open_relay(url, folder / "client")
            self._port = self._open_port(self._near, url, [*self._relays, self._far], entrance)
            self._door.on_receive = partial(self._keep, self._at_far_end)
            self._port.on_receive = partial(self._keep, self._at_near_end)
            self._stack = self._stack.pop_all()

    def to_far_end(self, data: bytes) -> bytes:
        """See `Route`."""
        return self._pass(self._port, [self._near, *self._relays, self._far], data, self._at_far_end)

    def to_near_end(self, data: bytes) -> bytes:
        """See `Route`."""
        return self._pass(self._door, [self._far, *self._relays, self._near], data, self._at_near_end)

    def close(self) -> None:
        """Hang up, from the client to the door."""
        self._stack.close()

    def _pass(self, entrance: Port, loops: list[Loop], data: bytes, came: bytearray) -> bytes:
        for start in range(0, len(data), _PIECE_BYTES):
            piece = data[start : start + _PIECE_BYTES]
            self._relayed = 0
            entrance.write(piece)
            stages = [Stage(loop=loop, done=partial(self._has_relayed, len(piece))) for loop in loops[1:-1]]
            stages.append(Stage(loop=loops[-1], done=partial(_holds, came, start + len(piece))))
            if not arrived(loops[0], stages):
                raise UnavailableError(
                    f"{len(came)} of {len(data)} bytes have passed, and no more come", where=self._name
                )
        out = bytes(came)
        came.clear()
        if out != data or self._at_far_end or self._at_near_end:
            strange = bytes(self._at_far_end + self._at_near_end)
            raise InternalError(f"{self._name}: {data!r} has come out as {out!r}, and {strange!r} has come from nobody")
        self.passed += len(out)
        return out

    def _has_relayed(self, count: int) -> bool:
        return self._relayed >= count

    @staticmethod
    def _keep(came: bytearray, data: bytes, _at_ns: int) -> None:
        came += data

    def _hear(self, _who: str, data: bytes, _at_ns: int) -> None:
        self._relayed += len(data)

    # --- opening

    def _folder(self) -> Path:
        """Return a place for links to pseudo-terminals."""
        return Path(self._stack.enter_context(tempfile.TemporaryDirectory(prefix="hilbench-")))

    def _loop(self) -> Loop:
        loop = Loop()
        self._stack.callback(loop.close)
        return loop

    def _open_door(self, kind: str, loop: Loop, path: Path) -> tuple[Door, str]:
        """Open a door; return it, and where a client finds it."""
        line = Line(baud=0)
        door: PtyDoor | TcpDoor
        if kind == "tcp":
            door = TcpDoor(loop.scheduler, "0", line)
            url = f"socket://{door.host}:{door.port}"
        elif kind == "rfc2217":
            door = Rfc2217Door(loop.scheduler, "0", line, any_baud=True)
            url = f"rfc2217://{door.host}:{door.port}"
        else:
            door, url = PtyDoor(loop.scheduler, path, line, any_baud=True), str(path)
        self._stack.callback(door.close)
        return door, url

    def _open_relay(self, url: str, path: Path) -> tuple[Door, str]:
        """Put a relay before a door; return the door before the relay, and where a client finds it."""
        loop = self._loop()
        self._relays.append(loop)
        entrance, own_url = self._open_door("pty", loop, path)
        behind = self._open_port(loop, url, [self._far], self._door)
        Relay(Bench(loop.scheduler, Journal()), entrance, behind, record=False, heard=self._hear)
        return entrance, own_url

    def _open_port(self, loop: Loop, url: str, others: list[Loop], door: Door) -> Port:
        """Come in at a door as its client."""
        for _ in range(_ATTEMPTS - 1):
            with contextlib.suppress(UnavailableError):
                return self._try_to_open(loop, url, others, door)
        return self._try_to_open(loop, url, others, door)

    def _try_to_open(self, loop: Loop, url: str, others: list[Loop], door: Door) -> Port:
        """Come in, while those at the other side run: the two may have much to tell each other."""
        target = SerialTarget(url=url, baud=_BAUD)
        client = ThreadPoolExecutor(1, "client")
        opening: Future[Port] = client.submit(ReconnectingPort, loop.scheduler, target)
        client.shutdown(wait=False)
        try:
            came_in = settle(others, lambda: opening.done() and (opening.exception() is not None or door.line_is_up))
        except BaseException:
            opening.add_done_callback(_close_unused)
            raise
        if not came_in:
            opening.add_done_callback(_close_unused)
            raise UnavailableError("no client has connected to the endpoint", where=f"{self._name}: {url}")
        port = opening.result()
        self._stack.callback(port.close)
        return port


def _holds(came: bytearray, count: int) -> bool:
    return len(came) >= count


def _close_unused(opening: Future[Port]) -> None:
    if opening.exception() is None:
        opening.result().close()
