"""What is done to a serial device itself: opened without a reset of the board behind it, its lines set and read.

Linux asserts DTR and RTS when a port is opened, and pyserial's default asks for the same. Boards with the automatic
bootloader circuit of Espressif are reset when one of the two is asserted alone, as happens on the way when they are
switched off one after the other; both asserted is harmless (esptool documentation, "Boot Mode Selection"). So both are
left alone unless they are asked for, and then set by one call (TIOCMSET, ioctl_tty(2)). Boards of the Arduino Uno kind
are reset when DTR becomes asserted: that cannot be helped the first time, but with HUPCL cleared the lines stay as they
are when the port is closed (termios(3)), and opening it again resets nothing.
"""

from __future__ import annotations

import contextlib
import errno
import fcntl
import os
import struct
import termios
import warnings
from dataclasses import dataclass
from typing import Any
from urllib.parse import urlsplit

import serial
from serial import rfc2217

from hilbench.errors import HilbenchError, UnavailableError, UsageError
from hilbench.links.bench_url import parse_bench_url
from hilbench.links.port import ModemLines
from hilbench.links.serial_target import SerialTarget

__all__ = [
    "LineErrors",
    "close_serial",
    "error_number",
    "far_lines",
    "is_pseudo_terminal",
    "line_errors",
    "modem_lines",
    "open_serial",
    "set_modem_lines",
]

_URL_HANDLERS = "hilbench.urlhandler"
_INT = struct.Struct("i")
_ICOUNTER = struct.Struct("20i")
"""struct serial_icounter_struct of linux/serial.h: cts, dsr, rng, dcd, rx, tx, frame, overrun, parity, brk,
buf_overrun, and nine that are reserved."""
_TIOCGICOUNT = 0x545D
_PSEUDO = "/dev/pts/"
_THREAD_READ_S = 0.1
"""How long a thread that reads a port without a descriptor waits before it looks around (choice). It is set at once: a
client of RFC 2217 negotiates everything anew when it is changed."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LineErrors:
    """What a driver has counted since it began (TIOCGICOUNT).

    Attributes:
        framing: bytes without a stop bit where one was due.
        parity: bytes with the wrong parity.
        overrun: bytes lost in the UART, and in the driver's buffer behind it.
        breaks: break conditions.
    """

    framing: int
    parity: int
    overrun: int
    breaks: int


def open_serial(target: SerialTarget, write_timeout_s: float) -> Any:
    """Open a port for this program alone.

    Returns:
        An object of pyserial.

    Raises:
        UsageError: pyserial does not know such a URL.
        UnavailableError: the port does not exist, is in use, or may not be opened.
    """
    settings = target.settings
    _require_sense(target)
    if target.url.lower().startswith("hilbench:"):
        _let_open_benches()
    # pyserial's client of RFC 2217 refuses every write timeout; its socket has one of 5 s of its own.
    timeout_s = None if target.url.lower().startswith("rfc2217:") else write_timeout_s
    try:
        port = serial.serial_for_url(
            target.url,
            baudrate=target.baud,
            parity=settings.parity,
            stopbits=settings.stop_bits,
            timeout=_THREAD_READ_S,
            write_timeout=timeout_s,
            do_not_open=True,
        )
        if isinstance(port, serial.Serial):  # also behind spy:// and the like
            port.exclusive = True
        if not target.is_device:
            _ask_url(port, target)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)  # pyserial 3.5 starts threads in an outdated way
            port.open()
    except HilbenchError:
        raise
    except Exception as error:  # pyserial's readers of URLs raise whatever it is that they stumble over
        raise _cannot_open(target, error) from error
    if hasattr(port, "fd"):
        _keep_lines(port.fd, target)
    return port


def _require_sense(target: SerialTarget) -> None:
    """Refuse a URL that names no port of a host, or a bench that has a time of its own.

    Raises:
        UsageError: it is one.
    """
    scheme, _, _ = target.url.lower().partition("://")
    if scheme in {"socket", "rfc2217"}:
        _require_port_number(target.url)
    if scheme == "hilbench" and parse_bench_url(target.url).fast:
        hint = "leave 'fast' out; a bench that is named itself runs as fast as it can"
        raise UsageError("its clock would differ from that of this bench", where=target.url, hint=hint)


def _let_open_benches() -> None:
    """Tell pyserial of ``hilbench:`` URLs; it imports what opens them when one is there."""
    if _URL_HANDLERS not in serial.protocol_handler_packages:
        serial.protocol_handler_packages.append(_URL_HANDLERS)


def _require_port_number(url: str) -> None:
    try:
        parts = urlsplit(url)
    except ValueError as error:
        raise UsageError(f"is no URL: {error}", where=url) from error
    try:
        number = parts.port
    except ValueError as error:
        raise UsageError("the port of its host is no number from 1 to 65535", where=url) from error
    if not number:
        raise UsageError("names no port of its host", where=url, hint="write socket://HOST:PORT or rfc2217://HOST:PORT")


def _ask_url(port: Any, target: SerialTarget) -> None:
    """Have pyserial set the lines of a far port when it opens it."""
    if target.settings.dtr is not None:
        port.dtr = target.settings.dtr
    if target.settings.rts is not None:
        port.rts = target.settings.rts


def _keep_lines(descriptor: int, target: SerialTarget) -> None:
    with contextlib.suppress(termios.error):
        attributes = termios.tcgetattr(descriptor)
        attributes[2] &= ~termios.HUPCL
        attributes[0] &= ~termios.BRKINT  # a break would throw away what was not read yet (termios(3))
        termios.tcsetattr(descriptor, termios.TCSANOW, attributes)
    # flock, which pyserial uses, keeps out those who ask; this keeps out the others but root. A pseudo-terminal's own
    # server has to be able to open it.
    if not is_pseudo_terminal(descriptor):
        with contextlib.suppress(OSError):
            fcntl.ioctl(descriptor, termios.TIOCEXCL)
    with contextlib.suppress(OSError):
        set_modem_lines(descriptor, dtr=target.settings.dtr, rts=target.settings.rts)


def close_serial(port: Any) -> None:
    """Give a port back, gone or not."""
    if getattr(port, "fd", None) is not None:
        with contextlib.suppress(OSError):
            fcntl.ioctl(port.fd, termios.TIOCNXCL)
    with contextlib.suppress(OSError):
        port.close()


def set_modem_lines(descriptor: int, *, dtr: bool | None, rts: bool | None) -> None:
    """Set both lines at once; None leaves one as it is.

    Raises:
        OSError: the port has no such lines, or is gone.
    """
    if dtr is None and rts is None:
        return
    (bits,) = _INT.unpack(fcntl.ioctl(descriptor, termios.TIOCMGET, bytes(_INT.size)))
    for level, bit in ((dtr, termios.TIOCM_DTR), (rts, termios.TIOCM_RTS)):
        if level is not None:
            bits = bits | bit if level else bits & ~bit
    fcntl.ioctl(descriptor, termios.TIOCMSET, _INT.pack(bits))


def modem_lines(descriptor: int) -> ModemLines | None:
    """Return the levels of a port's lines; None where it has none, as a pseudo-terminal."""
    try:
        (bits,) = _INT.unpack(fcntl.ioctl(descriptor, termios.TIOCMGET, bytes(_INT.size)))
    except OSError:
        return None
    return ModemLines(
        dtr=bool(bits & termios.TIOCM_DTR),
        rts=bool(bits & termios.TIOCM_RTS),
        cts=bool(bits & termios.TIOCM_CTS),
        dsr=bool(bits & termios.TIOCM_DSR),
        ri=bool(bits & termios.TIOCM_RI),
        cd=bool(bits & termios.TIOCM_CD),
    )


def far_lines(port: Any) -> ModemLines | None:
    """Return the levels that a far port reported last to pyserial's client of RFC 2217; None of any other port."""
    if not isinstance(port, rfc2217.Serial):
        return None
    try:
        state = port.get_modem_state()
    except OSError:
        return None
    return ModemLines(
        dtr=port.dtr,
        rts=port.rts,
        cts=bool(state & rfc2217.MODEMSTATE_MASK_CTS),
        dsr=bool(state & rfc2217.MODEMSTATE_MASK_DSR),
        ri=bool(state & rfc2217.MODEMSTATE_MASK_RI),
        cd=bool(state & rfc2217.MODEMSTATE_MASK_CD),
    )


def is_pseudo_terminal(descriptor: int) -> bool:
    """Say whether a port is a pseudo-terminal's slave: Linux lets a break be set there, and does nothing (tty_io.c)."""
    try:
        return os.ttyname(descriptor).startswith(_PSEUDO)
    except OSError:
        return False


def line_errors(descriptor: int) -> LineErrors | None:
    """Return what the driver has counted; None where it does not count."""
    try:
        counts = _ICOUNTER.unpack(fcntl.ioctl(descriptor, _TIOCGICOUNT, bytes(_ICOUNTER.size)))
    except OSError:
        return None
    framing, overrun, parity, breaks, buffer_overrun = counts[6:11]
    return LineErrors(framing=framing, parity=parity, overrun=overrun + buffer_overrun, breaks=breaks)


def error_number(error: Exception) -> int | None:
    """Return the number of the system's error; None for one that is not the system's, as those of pyserial."""
    if isinstance(error, termios.error):  # has no errno of its own
        return int(error.args[0])
    return error.errno if isinstance(error, OSError) else None


def _cannot_open(target: SerialTarget, error: Exception) -> HilbenchError:
    if isinstance(error.__cause__, HilbenchError):
        return error.__cause__  # of a bench of ours behind a URL
    where = target.url
    number = error_number(error)
    if beside := getattr(error, "filename", None):
        return UnavailableError(f"{beside}: {os.strerror(number) if number else error}", where=where)
    if number == errno.ENOENT:
        return UnavailableError("there is no such port", where=where, hint="'hilbench ports' shows what is there")
    if number in (errno.EACCES, errno.EPERM):
        return UnavailableError("permission denied", where=where, hint=_how_to_get_access(where))
    if number in (errno.EBUSY, errno.EAGAIN):
        return UnavailableError("another program uses the port", where=where, hint=_who_to_stop(where))
    if number == errno.ENOTTY or "Inappropriate ioctl" in str(error):
        return UnavailableError("is no serial port", where=where, hint="'hilbench ports' shows what is there")
    if isinstance(error, ValueError) and "remote rejected" in str(error):
        return UnavailableError(f"the remote port refuses the settings: {error}", where=where)
    if not isinstance(error, (OSError, NotImplementedError, termios.error, OverflowError)):
        kind = "" if isinstance(error, ValueError) else f"{type(error).__name__}: "
        return UsageError(f"pyserial does not know it: {kind}{error}", where=where)
    what = f"cannot be opened: {os.strerror(number) if number else error}"
    return UnavailableError(what, where=where, hint=_how_to_be_heard(where, error))


def _how_to_get_access(path: str) -> str:
    from hilbench.files.host import this_host
    from hilbench.ports.listing import list_ports
    from hilbench.ports.states import advice_on_access, state_at

    host = this_host()
    return advice_on_access(host, state_at(host, path, list_ports())).fix


def _how_to_be_heard(url: str, error: Exception) -> str | None:
    """Say what helps where a server of RFC 2217 leaves DTR unanswered, as ser2net at a pseudo-terminal does."""
    if "waiting for option 'control'" not in str(error):
        return None
    joined = "&" if "?" in url else "?"
    return f"the far end does not answer for its control lines; if it has none: {url}{joined}ign_set_control"


def _who_to_stop(path: str) -> str:
    from hilbench.files.host import this_host
    from hilbench.ports.listing import list_ports
    from hilbench.ports.states import state_at

    programs = state_at(this_host(), path, list_ports()).holders.programs
    named = " and ".join(str(one) for one in programs)
    return f"stop {named}" if named else f"it is another user's; root sees whose: sudo fuser {path}"
