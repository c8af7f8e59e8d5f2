"""The terminal of a dashboard, which may be gone at any moment.

Textual's own driver writes in a thread that ends with the first write that fails; its queue then fills, and whoever
writes waits for ever. It also reads a terminal that was hung up again and again.
"""

from __future__ import annotations

import asyncio
import select
import signal
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TextIO, cast

from textual.driver import Driver
from textual.drivers.linux_driver import LinuxDriver

if TYPE_CHECKING:
    from textual.app import App

__all__ = ["END_SIGNALS", "Terminal", "end_by_signals", "terminal_driver"]

END_SIGNALS = (signal.SIGTERM, signal.SIGHUP)
_PATIENCE_S = 5
"""How long a dashboard that was told to end may take, say for a terminal that nobody reads from (choice)."""


class _Screen:
    """What a terminal shows; what is written after it is gone goes nowhere.

    Args:
        file: where to.

    Attributes:
        lost: whether it is gone.
    """

    def __init__(self, file: TextIO) -> None:
        self.lost = False
        self._file = file

    def write(self, text: str) -> None:
        """Write."""
        self._do(lambda: self._file.write(text))

    def flush(self) -> None:
        """Write what waits to be written."""
        self._do(self._file.flush)

    def fileno(self) -> int:
        """Return the descriptor."""
        return self._file.fileno()

    def _do(self, act: Callable[[], object]) -> None:
        if self.lost:
            return
        try:
            act()
        except OSError:
            self.lost = True


class Terminal(LinuxDriver):
    """See the module. The arguments are those of Textual's driver."""

    def __init__(self, app: App[Any], **more: Any) -> None:
        super().__init__(app, **more)
        self._screen = _Screen(cast("TextIO", self._file))
        self._file = cast("Any", self._screen)
        self._poll = select.poll()
        self._poll.register(self.fileno, 0)

    @property
    def is_lost(self) -> bool:
        """Whether nobody is there any more, as far as one can tell without reading or writing."""
        gone = select.POLLHUP | select.POLLERR | select.POLLNVAL
        return self._screen.lost or any(event & gone for _, event in self._poll.poll(0))

    def _run_input_thread(self) -> None:
        try:
            self.run_input_thread()
        except OSError:
            self._screen.lost = True


def terminal_driver(chosen: type[Driver]) -> type[Driver]:
    """Return what drives a terminal in the place of what Textual has chosen; that of a browser is as it was."""
    return Terminal if chosen is LinuxDriver else chosen


def end_by_signals(leave: Callable[[], None]) -> None:
    """Let the signals that end a process do so in good order; if that is not done in some seconds, at once.

    Args:
        leave: begins the end, in the loop that runs now. The main thread may be waiting for a lock when the signal
            comes, so the loop alone could not take care of that.
    """
    loop = asyncio.get_running_loop()

    def handle(_number: int, _frame: object) -> None:
        signal.alarm(_PATIENCE_S)
        loop.call_soon_threadsafe(leave)

    for number in END_SIGNALS:
        signal.signal(number, handle)
