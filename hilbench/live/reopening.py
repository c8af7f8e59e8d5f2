"""A serial port that may go and come again: what it leads to is opened anew until it is there."""

from __future__ import annotations

from hilbench.bench import Bench
from hilbench.clock import NS_PER_S
from hilbench.errors import UnavailableError
from hilbench.links import SerialPort, SerialTarget
from hilbench.links.port import PortBase

__all__ = ["REOPEN_EVERY_NS", "ReopeningPort"]

REOPEN_EVERY_NS = NS_PER_S
"""How often a port that has gone is looked for (choice)."""


class ReopeningPort(PortBase):
    """See the module. To its owner it is one port, whose line goes down and comes up.

    Args:
        bench: whose time and journal are used.
        target: what to open.

    Raises:
        UnavailableError: it cannot be opened the first time.
    """

    def __init__(self, bench: Bench, target: SerialTarget) -> None:
        super().__init__(target.url)
        self._bench = bench
        self._target = target
        self._baud = target.baud
        self._port: SerialPort | None = None
        self._open()

    @property
    def baud(self) -> int:
        """The rate of the port, bit/s."""
        return self._baud

    @baud.setter
    def baud(self, baud: int) -> None:
        self._baud = baud
        if self._port is not None:
            self._port.baud = baud

    @property
    def pending(self) -> int:
        """Bytes written that are not out yet."""
        return 0 if self._port is None else self._port.pending

    def write(self, data: bytes) -> None:
        """Hand bytes to the port; while it is gone they are lost."""
        self._take_to_send(data, self._bench.now_ns)
        if self._port is None:
            self.counters.lost += len(data)
        else:
            self._port.write(data)

    def withdraw(self, keep: int) -> None:
        """Take back what is not out yet, but for the next `keep` bytes."""
        if self._port is not None:
            self._port.withdraw(keep)

    def send_break(self, duration_ns: int) -> None:
        """Hold the line low for `duration_ns`."""
        if self._port is not None:
            self._port.send_break(duration_ns)

    def close(self) -> None:
        """Let go of the port."""
        self.closed = True
        self._drop()

    def _open(self) -> None:
        self._port = SerialPort(self._bench.scheduler, self._target)
        if self._baud != self._target.baud:
            self._port.baud = self._baud
        self._port.on_receive = self._deliver
        self._port.on_line = self._line_changed
        self._set_line(up=True, at_ns=self._bench.now_ns)

    def _line_changed(self, up: bool, at_ns: int) -> None:
        if up or self.closed:
            return
        self._drop()
        self._set_line(up=False, at_ns=at_ns)
        self._look_later()

    def _look_later(self) -> None:
        self._bench.scheduler.after(REOPEN_EVERY_NS, self._look, source=self.name)

    def _look(self) -> None:
        if self.closed:
            return
        try:
            self._open()
        except UnavailableError:
            self._look_later()

    def _drop(self) -> None:
        port, self._port = self._port, None
        if port is not None:
            self.counters.lost += port.counters.lost
            port.close()
