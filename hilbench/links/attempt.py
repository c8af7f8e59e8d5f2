"""One attempt to open a far port, in a thread: whoever asks a host that does not answer waits for seconds."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable
from typing import Any

from hilbench.links.serial_device import close_serial

__all__ = ["Attempt"]


class Attempt:
    """Begins at once.

    Args:
        open_it: opens the port and returns it, or raises an error for people.
        name: of the thread.
    """

    def __init__(self, open_it: Callable[[], Any], name: str) -> None:
        self._open_it = open_it
        self._lock = threading.Lock()
        self._abandoned = False
        self._port: Any = None
        self._error: Exception | None = None
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)
        self._thread.start()

    @property
    def over(self) -> bool:
        """Whether it is known how it went."""
        return not self._thread.is_alive()

    def result(self) -> Any:
        """Return the port of an attempt that is over, or raise why there is none."""
        if self._error is not None:
            raise self._error
        return self._port

    def abandon(self) -> None:
        """Have the port closed if it is opened after all; nobody waits for that."""
        with self._lock:
            self._abandoned = True
            if self._port is not None:  # to hang up politely takes a far port a while, too
                name = f"{self._thread.name}: abandoned"
                threading.Thread(target=self._close, name=name, daemon=True).start()

    def _close(self) -> None:
        with contextlib.suppress(Exception):  # whatever pyserial stumbles over: nobody wants the port any more
            close_serial(self._port)

    def _run(self) -> None:
        try:
            port = self._open_it()
        except Exception as error:  # noqa: BLE001 - whatever it is, it is raised where the result is asked for
            self._error = error
            return
        with self._lock:
            self._port = port
            if self._abandoned:
                self._close()
