"""How well the bench behind a port of this host keeps up with it, as far as it is one of ours and tells.

A port is known by its place: a pseudo-terminal by its device, a TCP port of this host by its number. Behind a place
stands a bench that `hilbench serve` runs, or `hilbench proxy`, which in turn has opened a port: then what is behind
that one counts too.
"""

from __future__ import annotations

import functools
import ipaddress
import os
import socket
import stat
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from urllib.parse import urlsplit

from hilbench.clock import NS_PER_S
from hilbench.pace.lateness import IN_TIME, Lateness
from hilbench.pace.notice import PaceReader, notices

__all__ = ["FarPace", "ends_of", "is_pseudo_terminal", "place_of"]

_PSEUDO = range(136, 144)
"""Major numbers of the slaves of pseudo-terminals (Linux, Documentation/admin-guide/devices.txt)."""
_NETWORK = ("socket", "rfc2217")
_LOOKED_AT_NS = NS_PER_S
"""So long it is believed that nobody else has come (choice)."""


def place_of(where: str) -> str | None:
    """Return the place of a port by its path, or its URL as pyserial has it; None if it is not on this host alone."""
    url = where.removeprefix("spy://")
    if "://" not in url:
        return _pseudo_terminal(url.partition("?")[0] if url != where else url)
    try:
        parts = urlsplit(url)
        local = parts.scheme.lower() in _NETWORK and parts.port is not None and is_local(parts.hostname or "")
        return tcp_place(parts.port or 0) if local else None
    except ValueError:  # no number, or no address
        return None


def is_pseudo_terminal(where: str) -> bool:
    """Say whether a port, by its path or URL, is a pseudo-terminal of this host."""
    return (place_of(where) or "").startswith("pty ")


def tcp_place(port: int) -> str:
    """Return the place of a TCP port of this host."""
    return f"tcp {port}"


@functools.cache
def is_local(host: str) -> bool:
    """Say whether an address or a name is one of this host: no other can be bound to. All of them together are none."""
    try:
        family, kind, number, _, address = socket.getaddrinfo(host, 0, type=socket.SOCK_DGRAM)[0]
        with socket.socket(family, kind, number) as probe:
            probe.bind(address)
    except OSError:
        return False
    return not ipaddress.ip_address(address[0]).is_unspecified


def ends_of(where: str) -> list[str]:
    """Return the paths and URLs to which a port leads at last: its own, unless one of our proxies is behind it."""
    behind = [end for reader in _chain(where, set()) for end in reader.behind]
    return [end for end in behind if not any(_chain(end, set()))] or [where]


class FarPace:
    """The benches behind a port, one behind the other; none, as long as nobody tells of any.

    Args:
        where: path or URL of the port.
        but_of: id of a process whose benches do not count, such as one that has itself opened the port.
    """

    def __init__(self, where: str, *, but_of: int = 0) -> None:
        self._where = where
        self._but_of = f"{but_of}-"
        self._found: list[PaceReader] = []
        self._again_ns = 0

    def lateness(self, since_ns: int, now_ns: int) -> Lateness:
        """Return how late they were between two moments of the host's monotonic time, of which the second is now."""
        return sum((reader.lateness(since_ns, now_ns) for reader in self._readers(now_ns)), IN_TIME)

    def due_between(self, after_ns: int, by_ns: int) -> tuple[int, int] | None:
        """Return when was due, at the earliest and at the latest, what was written at a moment between two.

        None where that is not known: nobody tells, or it was handed on by one after the other.
        """
        readers, place = self._readers(by_ns), place_of(self._where)
        if len(readers) != 1 or readers[0].behind or place not in readers[0].doors:
            return None
        return readers[0].due_between(place, after_ns, by_ns)

    def life_since(self, begin_ns: int) -> Callable[[int], int]:
        """Return what tells at a moment how much time has passed for all of them since now, which is `begin_ns`."""
        began = [(reader, reader.lived_ns(begin_ns)) for reader in self._readers(begin_ns)]

        def lived_ns(now_ns: int) -> int:
            lived = [reader.lived_ns(now_ns) - at_ns for reader, at_ns in began if not reader.has_ended(now_ns)]
            return min([now_ns - begin_ns, *lived])

        return lived_ns

    def _readers(self, now_ns: int) -> list[PaceReader]:
        """Return them; looked for again now and then, and at once where one was missing or has ended."""
        if now_ns >= self._again_ns or any(reader.has_ended(now_ns) for reader in self._found):
            self._found = [one for one in _chain(self._where, set()) if not one.name.startswith(self._but_of)]
            self._again_ns = now_ns + _LOOKED_AT_NS if _is_whole(self._found) else 0
        return self._found


def _chain(where: str, been: set[str]) -> Iterator[PaceReader]:
    """Return what tells of a bench at the far end of a port, and of those behind it."""
    place = place_of(where)
    if place is None or place in been:
        return
    been.add(place)
    for reader in notices():
        if reader.name not in been and (place in reader.doors or place in map(place_of, reader.behind)):
            been.add(reader.name)
            yield reader
            for behind in reader.behind:
                yield from _chain(behind, been)


def _is_whole(found: Sequence[PaceReader]) -> bool:
    """Say whether there are any, and one behind each end that they have opened on this host."""
    doors = {door for reader in found for door in reader.doors}
    return bool(found) and {place_of(end) for reader in found for end in reader.behind} <= {None, *doors}


def _pseudo_terminal(path: str) -> str | None:
    try:
        status = Path(path).stat()
    except (OSError, ValueError):  # a path with a NUL is none
        return None
    if not stat.S_ISCHR(status.st_mode) or os.major(status.st_rdev) not in _PSEUDO:
        return None
    return f"pty {status.st_dev} {status.st_rdev}"
