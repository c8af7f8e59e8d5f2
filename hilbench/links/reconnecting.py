"""A real port that may be unplugged and come back: to its owner it is one port, whose line goes down and comes up.

What comes back is known by what it is (`hilbench.ports.listing.UsbIdentity`), not by its name: the kernel gives a name
to whoever comes first. A port without an identity, such as a pty or a socket, is looked for where it was. Both events
are recorded; what is written in between is lost and counted. A device that is there and cannot be opened yet, as long
as udev has not set its permissions, is tried again at the next poll.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

from hilbench.clock import NS_PER_MS, EventClass, Scheduler
from hilbench.errors import UnavailableError, UsageError
from hilbench.files.paths import real_path
from hilbench.links.attempt import Attempt
from hilbench.links.port import NO_LINE_ASSERTED, ModemLines, Port, PortBase, Refused, raise_it
from hilbench.links.serial_device import open_serial
from hilbench.links.serial_target import SerialTarget, located
from hilbench.links.serialport import WRITE_TIMEOUT_S, SerialPort
from hilbench.ports.listing import PortEnumerator, PortInfo, UsbIdentity, find_again, list_ports

__all__ = ["POLL_NS", "PortOpener", "ReconnectingPort", "Recorder"]

POLL_NS = 250 * NS_PER_MS
"""How often a port that has gone is looked for (choice)."""

PortOpener = Callable[..., Port]
"""Takes a scheduler, a `SerialTarget`, and ``opened``, a port that is open already; `SerialPort` is one."""
Recorder = Callable[..., None]
"""Takes the kind of an event, its source, and its fields; `hilbench.bench.Bench.record` is one."""


def _no_record(_kind: str, _source: str, **_fields: object) -> None:
    """Stand in for a recorder."""


class ReconnectingPort(PortBase):
    """See the module.

    Args:
        scheduler: Owner of bench time, locked to the host's clock before it runs.
        target: What to open.
        record: Takes the events ``port-lost`` (``device``, ``usb``, ``serial_number``), ``port-returned`` (as above,
            and ``was``, ``away_ns``) and ``port-refused`` (``device``, ``text``).
        ports: Says which ports there are now.
        open_port: Opens one.
        poll_ns: How often it is looked for while it is gone.

    Raises:
        UsageError: The target is not one.
        UnavailableError: It cannot be opened the first time.

    Attributes:
        device: Path or URL at which it is, or was last.
        identity: What is known of the USB device; None if it is none.
        losses: How often it has gone.
    """

    def __init__(
        self,
        scheduler: Scheduler,
        target: SerialTarget,
        *,
        record: Recorder = _no_record,
        ports: PortEnumerator = list_ports,
        open_port: PortOpener = SerialPort,
        poll_ns: int = POLL_NS,
    ) -> None:
        super().__init__(target.url)
        self.comes_back = True
        self._scheduler = scheduler
        self._target = located(target, ports)
        self._record = record
        self._ports = ports
        self._open_port = open_port
        self._poll_ns = poll_ns
        self._baud = self._had_baud = target.baud  # what is wished for, and what it was opened with
        self._port: Port | None = None
        self._lost_ns = 0
        self._refusal = ""
        self._lines_away: ModemLines | None = None
        self._attempt: tuple[Attempt, int, int] | None = None  # the rate it is opened with, and what was wished for
        self._far_refusal: UnavailableError | None = None  # why it could not be opened with the rate wished for
        self.device = self._target.url
        self.losses = 0
        self.identity = identity_of(self.device, ports()) if target.is_device else None
        self._open(self.device, self._baud)

    @property
    def baud(self) -> int:
        """The rate of the port, bit/s; kept while it is gone. One that it refuses is forgotten.

        Raises:
            UnavailableError: when set: the port cannot.
        """
        return self._baud

    @baud.setter
    def baud(self, baud: int) -> None:
        if self._port is not None:
            self._port.baud = baud
        self._baud = baud

    @property
    def pending(self) -> int:
        """Bytes written that are not out yet."""
        return 0 if self._port is None else self._port.pending

    def write(self, data: bytes) -> None:
        """Hand bytes to the port; while it is gone they are lost and counted."""
        if self._port is not None:
            self._port.write(data)
            return
        self._take_to_send(data, self._scheduler.now_ns)
        self.counters.lost += len(data)

    def withdraw(self, keep: int) -> None:
        """Take back what is not out yet, but for the next `keep` bytes."""
        if self._port is not None:
            self._port.withdraw(keep)

    def send_break(self, duration_ns: int, refused: Refused = raise_it) -> None:
        """Hold the line low for `duration_ns`."""
        if self._port is not None:
            self._port.send_break(duration_ns, refused)

    @property
    def modem_lines(self) -> ModemLines | None:
        """The levels of the lines beside the data; None on a port that has none. None is asserted while it is gone."""
        return self._lines_away if self._port is None else self._port.modem_lines

    def set_lines(self, *, dtr: bool | None = None, rts: bool | None = None) -> None:
        """Set DTR and RTS; see `SerialPort.set_lines`.

        Raises:
            UnavailableError: the port has no such lines, or is gone.
        """
        if self._port is None:
            raise UnavailableError("DTR and RTS cannot be set: the port is gone", where=self.device)
        self._port.set_lines(dtr=dtr, rts=rts)

    def close(self) -> None:
        """Let go of the port, and look for it no more; a second call does nothing."""
        self.closed = True
        self.line_is_up = False
        self._drop()
        attempt, self._attempt = self._attempt, None
        if attempt is not None:
            attempt[0].abandon()

    # --- there

    def _open(self, url: str, baud: int, **opened: object) -> None:
        port = self._open_port(self._scheduler, self._target_at(url, baud), **opened)
        self._baud = self._had_baud = baud
        port.counters = self.counters  # what it counts, it counts for its owner
        port.on_receive = self._received
        port.on_sent = self._sent
        port.on_break = self._broke
        port.on_line = self._line_changed
        port.on_modem = self._modem_changed
        port.on_refused = self._rate_refused
        was, self.device = self.device, url
        self._port, self._refusal = port, ""
        now_ns = self._scheduler.now_ns
        if self.losses:
            self._record("port-returned", self.name, **self._about(), was=was, away_ns=now_ns - self._lost_ns)
        self._set_line(True, now_ns)
        if (lines := port.modem_lines) is not None:
            self._lines_away = NO_LINE_ASSERTED
            if self.losses:
                self.on_modem(lines, now_ns)

    def _target_at(self, url: str, baud: int) -> SerialTarget:
        return replace(self._target, url=url, baud=baud)

    def _received(self, data: bytes, at_ns: int) -> None:
        if not self.closed:
            self.on_receive(data, at_ns)

    def _sent(self, data: bytes, at_ns: int) -> None:
        self.on_sent(data, at_ns)

    def _broke(self, at_ns: int) -> None:
        self.on_break(at_ns)

    def _rate_refused(self, baud: int, error: UnavailableError) -> None:
        if self._port is not None:
            self._baud = self._port.baud
        self.on_refused(baud, error)

    def _modem_changed(self, lines: ModemLines, at_ns: int) -> None:
        self._lines_away = NO_LINE_ASSERTED
        self.on_modem(lines, at_ns)

    def _line_changed(self, up: bool, at_ns: int) -> None:
        if up or self.closed:
            return
        self._drop()
        self.losses += 1
        self._lost_ns = at_ns
        self._record("port-lost", self.name, **self._about())
        self._set_line(False, at_ns)
        if self._lines_away is not None:
            self.on_modem(self._lines_away, at_ns)
        self._look_later()

    def _drop(self) -> None:
        port, self._port = self._port, None
        if port is not None:
            port.close()

    # --- gone

    def _look_later(self) -> None:
        self._scheduler.after(self._poll_ns, self._look, order=EventClass.INPUT, source=self.name)

    def _look(self) -> None:
        if self.closed:
            return
        url = self._whereabouts()
        if url is None:
            self._look_later()
            return
        try:
            refused = self._open_device(url) if self._target.is_device else self._open_far(url)
        except (UnavailableError, UsageError) as error:  # the latter: it went while its rate was set
            if str(error) != self._refusal:
                self._refusal = str(error)
                self._record("port-refused", self.name, device=url, text=self._refusal)
            self._look_later()
            return
        if refused is not None:
            self.on_refused(*refused)

    def _open_device(self, url: str) -> tuple[int, UnavailableError] | None:
        """Open it, with the rate that it had if that cannot be with one set meanwhile; return the latter, and why."""
        wanted_baud = self._baud
        try:
            self._open(url, wanted_baud)
        except (UnavailableError, UsageError) as error:
            if wanted_baud == self._had_baud:
                raise
            try:
                self._open(url, self._had_baud)
            except (UnavailableError, UsageError):
                raise error from None  # it is not for the rate
            return wanted_baud, UnavailableError(str(error))
        return None

    def _open_far(self, url: str) -> tuple[int, UnavailableError] | None:
        """Have a thread open it, and look again whether it has; else as `_open_device`."""
        if self._attempt is None:
            baud = self._baud if self._far_refusal is None else self._had_baud
            opening = partial(open_serial, self._target_at(url, baud), WRITE_TIMEOUT_S)
            self._attempt = Attempt(opening, f"open {url}"), baud, self._baud
        attempt, baud, wanted_baud = self._attempt
        if not attempt.over:
            self._look_later()
            return None
        self._attempt, refusal, self._far_refusal = None, self._far_refusal, None
        if wanted_baud != self._baud:  # it was changed meanwhile
            attempt.abandon()
            self._look_later()
            return None
        try:
            opened = attempt.result()
        except (UnavailableError, UsageError) as error:
            if (
                isinstance(error.__cause__, ValueError) and baud != self._had_baud
            ):  # as pyserial says that it is refused
                self._far_refusal = UnavailableError(str(error))
            raise
        self._open(url, baud, opened=opened)
        return None if refusal is None else (wanted_baud, refusal)

    def _whereabouts(self) -> str | None:
        """Return where it is now, as far as can be known without opening it; None if it is gone."""
        if self.identity is None:
            return self._target.url
        found = find_again(self.identity, self._ports())
        return None if found is None else found.device

    def _about(self) -> dict[str, object]:
        identity = self.identity
        return {
            "device": self.device,
            "usb": "" if identity is None else identity.ids,
            "serial_number": "" if identity is None else identity.serial_number or "",
        }


def identity_of(path: str, ports: Sequence[PortInfo]) -> UsbIdentity | None:
    """Return what is known of the USB device at a path, by whatever name it is called; None if it is none."""
    device = real_path(path)
    found = (port.usb for port in ports if path in (port.device, *port.links) or device == port.device)
    return next(found, None)
