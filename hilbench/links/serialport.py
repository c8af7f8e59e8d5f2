"""The client side of a real line: whatever pyserial can open, by device path or URL.

Opening does not touch DTR and RTS. Linux asserts both when a port is opened, and pyserial's default leaves them so.
Boards with the automatic bootloader circuit of Espressif are reset when one of the two is asserted alone, as happens
on the way when they are switched off one after the other; both asserted is harmless (esptool documentation, "Boot Mode
Selection"). Boards of the Arduino Uno kind are reset when DTR becomes asserted: that cannot be helped the first time,
but with HUPCL cleared the lines stay asserted when the port is closed, and opening it again resets nothing.
"""

from __future__ import annotations

import contextlib
import errno
import grp
import io
import os
import re
import termios
import threading
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import Any

import serial

from hilbench.clock import NS_PER_MS, NS_PER_S, EventClass, Scheduler
from hilbench.errors import HilbenchError, UnavailableError, UsageError
from hilbench.links.door import READ_BYTES, Input
from hilbench.links.port import PortBase

DEFAULT_BAUD = 9600
WRITE_TIMEOUT_S = 1.0
# A port that has no descriptor is read by a thread, which looks this often whether it should end.
_THREAD_READ_S = 0.1
_RETRY_NS = 2 * NS_PER_MS
_WITH_BAUD = re.compile(r"(?P<url>.+)@(?P<baud>\d+)")


@dataclass(frozen=True, slots=True, kw_only=True)
class SerialTarget:
    """What to open: a device path or pyserial URL, and the baud rate in bit/s."""

    url: str
    baud: int


def is_serial_target(text: str) -> bool:
    """Say whether a target is at a serial port or behind a pyserial URL, and not something of this machine's own."""
    return text.startswith("serial:") or "://" in text


def parse_serial_target(text: str, default_baud: int = DEFAULT_BAUD) -> SerialTarget:
    """Return what `[serial:]PATH-OR-URL[@BAUD]` names, such as `serial:/dev/ttyUSB0@115200` or `socket://host:8101`.

    Raises:
        UsageError: no path, or a baud rate of 0.
    """
    rest = text.removeprefix("serial:")
    match = _WITH_BAUD.fullmatch(rest)
    url, baud = (match["url"], int(match["baud"])) if match else (rest, default_baud)
    if not url or url.startswith("@") or baud == 0:
        raise UsageError(f"not a serial port: {text!r}", hint="write serial:/dev/ttyUSB0@115200 or a pyserial URL")
    return SerialTarget(url=url, baud=baud)


class SerialPort(PortBase):
    """A port of this machine, or whatever a pyserial URL leads to.

    The line is up from the start; it goes down, for good, when the device disappears or the far end hangs up.

    Args:
        scheduler: Owner of bench time, locked to the host's clock before it runs.
        target: What to open, or its text; see `parse_serial_target`.
        name: For the journal and for messages; the target's URL by default.
        write_timeout_s: How long the line may take nothing, in bench seconds, before what waits is lost and counted.

    Raises:
        UsageError: the target is not one.
        UnavailableError: the port does not exist, is in use, or may not be opened.
    """

    def __init__(
        self,
        scheduler: Scheduler,
        target: SerialTarget | str,
        *,
        name: str | None = None,
        write_timeout_s: float = WRITE_TIMEOUT_S,
    ) -> None:
        self.target = parse_serial_target(target) if isinstance(target, str) else target
        super().__init__(name or self.target.url)
        self._scheduler = scheduler
        self._write_timeout_ns = round(write_timeout_s * NS_PER_S)
        self._serial = _open(self.target, write_timeout_s)
        self._baud = self.target.baud
        self._waiting = bytearray()
        self._taken_ns = 0
        self._writing = False
        self._reader: _ReaderThread | None = None
        try:
            descriptor = self._serial.fileno()
        except (AttributeError, io.UnsupportedOperation):
            self._serial.timeout = _THREAD_READ_S
            self._reader = _ReaderThread(self._serial)
            descriptor = self._reader.fileno()
        self._input = Input(descriptor=descriptor, read=self._read)
        self._native = hasattr(self._serial, "fd")
        self.line_is_up = True
        scheduler.add_source(self._input)

    @property
    def baud(self) -> int:
        """Bits per second of the port; setting it reconfigures the port at once."""
        return self._baud

    @baud.setter
    def baud(self, baud: int) -> None:
        try:
            self._serial.baudrate = baud
        except (OSError, ValueError) as error:
            raise UnavailableError(f"cannot be set to {baud} baud: {error}", where=self.name) from error
        self._baud = baud

    def write(self, data: bytes) -> None:
        """Queue bytes; they go to the system in the next entry, and wait if it takes no more."""
        self._take_to_send(data, self._scheduler.now_ns)
        if not self.line_is_up:
            self.counters.lost += len(data)
            return
        self._waiting += data
        if not self._writing:
            self._writing = True
            self._taken_ns = self._scheduler.now_ns
            self._scheduler.after(0, self._write_on, order=EventClass.BYTE, source=self.name)

    @property
    def pending(self) -> int:
        """Bytes written that the system has not taken, or, where it tells, has not sent."""
        try:
            return len(self._waiting) + (self._serial.out_waiting if self._native and not self.closed else 0)
        except OSError:
            return len(self._waiting)

    def send_break(self, duration_ns: int) -> None:
        """Hold the line low for `duration_ns`; nothing happens on ports that cannot."""
        self._take_to_send(b"", self._scheduler.now_ns)
        self._set_break(True)
        self._scheduler.after(duration_ns, partial(self._set_break, False), order=EventClass.BYTE, source=self.name)

    def close(self) -> None:
        """Give the port back; a second call does nothing."""
        if self.closed:
            return
        self.closed = True
        self.line_is_up = False
        # What was written goes out as far as the system takes it; this end does not wait for it.
        with contextlib.suppress(OSError):
            self._hand_over()
        self.counters.lost += len(self._waiting)
        self._waiting.clear()
        self._scheduler.remove_source(self._input)
        if self._reader is not None:
            self._reader.close()
        with contextlib.suppress(OSError):
            self._serial.close()

    # --- out

    def _write_on(self) -> None:
        self._writing = False
        if self.closed or not self._waiting:
            return
        now_ns = self._scheduler.now_ns
        try:
            if self._hand_over():
                self._taken_ns = now_ns
        except OSError:
            self._line_lost()
            return
        if now_ns - self._taken_ns > self._write_timeout_ns:
            self.counters.lost += len(self._waiting)
            self._waiting.clear()
        if self._waiting:
            self._writing = True
            self._scheduler.after(_RETRY_NS, self._write_on, order=EventClass.BYTE, source=self.name)

    def _hand_over(self) -> int:
        """Give the system as much as it takes without waiting; return how many bytes that were."""
        if not self._waiting:
            return 0
        if self._native:
            # Not pyserial's write: with a timeout it does not say how much it wrote, without one it can hang.
            try:
                taken = os.write(self._serial.fd, self._waiting)
            except BlockingIOError:
                return 0
        else:
            taken = len(self._waiting[:READ_BYTES])
            try:
                self._serial.write(bytes(self._waiting[:taken]))
            except serial.SerialTimeoutException:
                self.counters.lost += taken
        del self._waiting[:taken]
        return taken

    def _set_break(self, on: bool) -> None:
        with contextlib.suppress(OSError, termios.error, NotImplementedError):
            if not self.closed:
                self._serial.break_condition = on

    # --- in

    def _read(self, at_ns: int) -> None:
        try:
            data = self._reader.take() if self._reader is not None else self._serial.read(READ_BYTES)
        except (OSError, TypeError):  # pyserial raises TypeError when the port is closed under its hands
            self._scheduler.remove_source(self._input)
            self._in_order(at_ns, self._line_lost)
            return
        if data:
            self._in_order(at_ns, partial(self._deliver, data, at_ns))

    def _in_order(self, at_ns: int, action: Callable[[], None]) -> None:
        self._scheduler.at(at_ns, action, order=EventClass.INPUT, source=self.name)

    def _line_lost(self) -> None:
        self._scheduler.remove_source(self._input)
        self.counters.lost += len(self._waiting)
        self._waiting.clear()
        self._set_line(False, self._scheduler.now_ns)


class _ReaderThread:
    """Reads a port that has no descriptor, and has one itself: a pipe that is readable when there are bytes."""

    def __init__(self, port: Any) -> None:
        self._port = port
        self._queue: SimpleQueue[bytes | Exception] = SimpleQueue()
        self._wake_read, self._wake_write = os.pipe()
        self._ending = False
        self._thread = threading.Thread(target=self._run, name=f"read {port.port}", daemon=True)
        self._thread.start()

    def fileno(self) -> int:
        """Return the descriptor that is readable when `take` has something."""
        return self._wake_read

    def take(self) -> bytes:
        """Return the bytes read so far; raises what ended the reading, once they are taken."""
        os.read(self._wake_read, 1)
        data = self._queue.get()
        if isinstance(data, Exception):
            raise data
        return data

    def close(self) -> None:
        """End the thread and close the pipe."""
        self._ending = True
        cancel = getattr(self._port, "cancel_read", None)
        if cancel is not None:
            with contextlib.suppress(OSError, AttributeError):
                cancel()
        self._thread.join()
        with contextlib.suppress(Empty):
            while True:
                self._queue.get_nowait()
        os.close(self._wake_read)
        os.close(self._wake_write)

    def _run(self) -> None:
        while not self._ending:
            try:
                data = self._port.read(max(1, min(READ_BYTES, self._port.in_waiting)))
            except (OSError, TypeError) as error:
                self._tell(OSError(str(error)))
                return
            if data:
                self._tell(bytes(data))

    def _tell(self, item: bytes | Exception) -> None:
        self._queue.put(item)
        os.write(self._wake_write, b"!")


def _open(target: SerialTarget, write_timeout_s: float) -> Any:
    try:
        port = serial.serial_for_url(
            target.url, baudrate=target.baud, timeout=0, write_timeout=write_timeout_s, do_not_open=True
        )
        if Path(target.url).exists():
            port.exclusive = True
        port.open()
    except (OSError, ValueError) as error:
        raise _cannot_open(target, error) from error
    if hasattr(port, "fd"):
        with contextlib.suppress(termios.error):
            attributes = termios.tcgetattr(port.fd)
            attributes[2] &= ~termios.HUPCL
            termios.tcsetattr(port.fd, termios.TCSANOW, attributes)
    return port


def _cannot_open(target: SerialTarget, error: Exception) -> HilbenchError:
    where = target.url
    number = getattr(error, "errno", None)
    if number == errno.ENOENT:
        return UnavailableError(
            "there is no such port", where=where, hint="`ls /dev/serial/by-id /dev/tty*` lists what is there"
        )
    if number in (errno.EACCES, errno.EPERM):
        group = _group_of(where)
        hint = f"sudo usermod -aG {group} $USER, then log in again"
        return UnavailableError("permission denied", where=where, hint=hint)
    if number in (errno.EBUSY, errno.EAGAIN):
        return UnavailableError("another program uses the port", where=where, hint=f"`fuser {where}` names it")
    if isinstance(error, ValueError):
        return UsageError(f"pyserial does not know it: {error}", where=where)
    return UnavailableError(f"cannot be opened: {error}", where=where)


def _group_of(path: str) -> str:
    """Return the group that may use a device: `dialout` on Debian, `uucp` on Arch."""
    try:
        return grp.getgrgid(Path(path).stat().st_gid).gr_name
    except (OSError, KeyError):
        return "dialout"
