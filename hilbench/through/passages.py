"""The ways that bytes may be sent: a client at a door, with a proxy in between if that is asked for.

Each way is made of what the bench has in real time: the door that ``hilbench serve`` opens, the port by which
``hilbench check --target`` opens it, the relay of ``hilbench proxy``. Only their clocks differ; see
`hilbench.through.loop`.
"""

from __future__ import annotations

import contextlib
import tempfile
import weakref
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path

from hilbench.bench import Bench
from hilbench.errors import UnavailableError
from hilbench.journal import Journal
from hilbench.links import Line, Port, PtyDoor, ReconnectingPort, Rfc2217Door, SerialTarget, TcpDoor
from hilbench.links.door import Door
from hilbench.relay import Relay
from hilbench.through.loop import Loop, Stage, arrived, settle
from hilbench.through.port import Passage, ThroughPort

__all__ = ["Passages"]

_WORDS: Mapping[str, str] = {
    "pty": "pseudo-terminals",
    "tcp": "TCP sockets",
    "rfc2217": "RFC 2217",
    "proxy": "a proxy between two pseudo-terminals each",
}
"""The ways there are, and what a report says of them."""

_PIECE_BYTES = 1024  # a terminal keeps 4095 bytes that nobody has read (n_tty of Linux)
_BAUD = 115_200
"""What both ends say their rate is, where they have to say one; the door is not paced, and time stands still."""


class _Way:
    """A client at a door, and perhaps a relay between the two."""

    def __init__(self, kind: str, name: str, folder: Path) -> None:
        self._name = name
        self._came = bytearray()
        self._relays: list[Loop] = []
        self._relayed = 0
        with contextlib.ExitStack() as self._stack:
            self._near, self._far = self._loop(), self._loop()
            self._door, url = self._open_door(kind, self._far, folder / "board")
            self._door.on_receive = self._take
            entrance: Door = self._door
            if kind == "proxy":
                entrance, url = self._open_relay(url, folder / "client")
            self._port = self._open_port(self._near, url, [*self._relays, self._far], entrance)
            self._port.on_receive = self._take
            self._stack = self._stack.pop_all()

    def to_far_end(self, data: bytes) -> bytes:
        """See `Passage`."""
        return self._pass(self._port, [self._near, *self._relays, self._far], data)

    def to_near_end(self, data: bytes) -> bytes:
        """See `Passage`."""
        return self._pass(self._door, [self._far, *self._relays, self._near], data)

    def close(self) -> None:
        """Hang up, from the client to the door."""
        self._stack.close()

    def _pass(self, entrance: Port, loops: list[Loop], data: bytes) -> bytes:
        self._came.clear()
        for start in range(0, len(data), _PIECE_BYTES):
            piece = data[start : start + _PIECE_BYTES]
            wanted, self._relayed = len(self._came) + len(piece), 0
            entrance.write(piece)
            stages = [Stage(loop=loop, done=partial(self._has_relayed, len(piece))) for loop in loops[1:-1]]
            stages.append(Stage(loop=loops[-1], done=partial(self._has_come, wanted)))
            if not arrived(loops[0], stages):
                raise UnavailableError(
                    f"{len(self._came)} of {len(data)} bytes have passed, and no more come", where=self._name
                )
        return bytes(self._came)

    def _has_come(self, count: int) -> bool:
        return len(self._came) >= count

    def _has_relayed(self, count: int) -> bool:
        return self._relayed >= count

    def _take(self, data: bytes, _at_ns: int) -> None:
        self._came += data

    def _hear(self, _who: str, data: bytes, _at_ns: int) -> None:
        self._relayed += len(data)

    # --- opening

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
        """Open a door as its client; those at the other side run meanwhile, as the two have much to tell each other."""
        target = SerialTarget(url=url, baud=_BAUD)
        with ThreadPoolExecutor(1, "client") as client:
            opening = client.submit(ReconnectingPort, loop.scheduler, target)
            settled = settle(others, lambda: opening.done() and (opening.exception() is not None or door.line_is_up))
        port = opening.result()
        self._stack.callback(port.close)
        if not settled:
            raise UnavailableError("nobody has come in at the door", where=f"{self._name}: {url}")
        return port


class Passages:
    """A way for each line, kept for the whole run.

    Args:
        kind: one of `hilbench.options.THROUGH`.

    Attributes:
        folder: where its pseudo-terminals are.
        close: gives up all ways; a second call does nothing.
    """

    def __init__(self, kind: str) -> None:
        self._kind = kind
        self._passages: dict[str, Passage] = {}
        self._stack = contextlib.ExitStack()
        self.folder = Path(self._stack.enter_context(tempfile.TemporaryDirectory(prefix="hilbench-")))
        self.close = weakref.finalize(self, self._stack.close)

    @property
    def words(self) -> str:
        """What has passed where, for a report."""
        if not self._passages:
            return f"nothing has passed {_WORDS[self._kind]}: the checker has had no line"
        return f"through {_WORDS[self._kind]} of this machine"

    def __call__(self, port: Port) -> Port:
        """Return what stands for the port now.

        Raises:
            UnavailableError: there is no way, for want of pseudo-terminals or sockets.
        """
        if port.name not in self._passages:
            folder = self.folder / str(len(self._passages))
            folder.mkdir()
            way = _Way(self._kind, port.name, folder)
            self._stack.callback(way.close)
            self._passages[port.name] = way
        return ThroughPort(port, self._passages[port.name])
