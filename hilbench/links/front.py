"""The part of a port that stands before another which is the same for all of them: it hands on."""

from __future__ import annotations

from hilbench.errors import UnavailableError
from hilbench.links.port import ModemLines, Port, PortBase, Refused, raise_it

__all__ = ["PortInFront"]


class PortInFront(PortBase):
    """A port that stands before another. What a subclass does not see to itself, the other port does.

    Args:
        port: the other; its callbacks belong to this one from now on.
        name: for the journal and for messages; the other's by default.

    Attributes:
        port: the port behind this one.
    """

    def __init__(self, port: Port, name: str = "") -> None:
        super().__init__(name or port.name)
        self._stand_before(port)

    def _stand_before(self, port: Port) -> None:
        """Belong to a port from now on."""
        self.port = port
        self.comes_back = port.comes_back
        self.line_is_up = port.line_is_up
        port.on_receive = self._received
        port.on_line = self._line_changed
        port.on_break = self._broke
        port.on_modem = self._modem_changed
        port.on_refused = self._rate_refused

    @property
    def baud(self) -> int:
        """The rate of the port behind, bit/s."""
        return self.port.baud

    @baud.setter
    def baud(self, baud: int) -> None:
        self.port.baud = baud

    def write(self, data: bytes) -> None:
        """Hand bytes to the port behind."""
        self.port.write(data)

    @property
    def pending(self) -> int:
        """Bytes written that are not out yet."""
        return self.port.pending

    def withdraw(self, keep: int) -> None:
        """Take back what is not out yet, but for the next `keep` bytes."""
        self.port.withdraw(keep)

    def send_break(self, duration_ns: int, refused: Refused = raise_it) -> None:
        """Hold the line low for `duration_ns`; see `Port.send_break`."""
        self.port.send_break(duration_ns, refused)

    @property
    def modem_lines(self) -> ModemLines | None:
        """Those of the port behind."""
        return self.port.modem_lines

    def set_lines(self, *, dtr: bool | None = None, rts: bool | None = None) -> None:
        """Set DTR and RTS of the port behind; see `Port.set_lines`."""
        self.port.set_lines(dtr=dtr, rts=rts)

    def close(self) -> None:
        """Close this port and the one behind; a second call does nothing."""
        if not self.closed:
            self.closed = True
            self.line_is_up = False
            self.port.close()

    # --- what the port behind says

    def _received(self, data: bytes, at_ns: int) -> None:
        self.on_receive(data, at_ns)

    def _line_changed(self, up: bool, at_ns: int) -> None:
        self._set_line(up, at_ns)

    def _broke(self, at_ns: int) -> None:
        self.break_ns = self.port.break_ns
        self.on_break(at_ns)

    def _modem_changed(self, lines: ModemLines, at_ns: int) -> None:
        self.on_modem(lines, at_ns)

    def _rate_refused(self, baud: int, error: UnavailableError) -> None:
        self.on_refused(baud, error)
