"""Sockets of this machine alone, at paths of any length.

The address of such a socket has room for 107 bytes (unix(7), ``sun_path``), and a temporary folder may have a longer
path. Linux lets a folder that is open be named by its descriptor, which is short; elsewhere the path is taken as it is.
"""

from __future__ import annotations

import contextlib
import os
import socket
from collections.abc import Iterator
from pathlib import Path

__all__ = ["connect_to", "listen_at"]

_OPEN_FOLDERS = Path("/proc/self/fd")
_WAITING = 4


def listen_at(path: Path) -> socket.socket:
    """Return a socket that listens at a path and never blocks; only its owner may connect.

    Raises:
        OSError: it cannot be made.
    """
    listener = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM | socket.SOCK_NONBLOCK)
    mask = os.umask(0o177)
    try:
        with _address(path) as address:
            listener.bind(address)
        listener.listen(_WAITING)
    except OSError:
        listener.close()
        raise
    finally:
        os.umask(mask)
    return listener


def connect_to(path: Path) -> socket.socket:
    """Return a socket that is connected to the one at a path.

    Raises:
        OSError: nobody listens there.
    """
    client = socket.socket(socket.AF_UNIX)
    try:
        with _address(path) as address:
            client.connect(address)
    except OSError:
        client.close()
        raise
    return client


@contextlib.contextmanager
def _address(path: Path) -> Iterator[str]:
    if not _OPEN_FOLDERS.is_dir():
        yield str(path)
        return
    folder = os.open(path.parent, os.O_RDONLY | os.O_DIRECTORY)
    try:
        yield str(_OPEN_FOLDERS / str(folder) / path.name)
    finally:
        os.close(folder)
