"""How a real line is named on the command line: where it is, how fast it is, how it is opened."""

from __future__ import annotations

import re
from dataclasses import dataclass, field, replace
from typing import Any

from hilbench.errors import UsageError
from hilbench.ports.choice import choose_port, parse_port_choice
from hilbench.ports.listing import PortEnumerator, list_ports

__all__ = ["DEFAULT_BAUD", "LineSettings", "SerialTarget", "is_serial_target", "located", "parse_serial_target"]

DEFAULT_BAUD = 9600
_FORM = re.compile(r"(?P<url>.+)@(?P<baud>\d+)(?P<settings>(,[^,=]+=[^,]*)*)")
_HINT = "write serial:/dev/ttyUSB0@115200, serial:/dev/ttyUSB0@9600,dtr=off,parity=E, or a pyserial URL"


@dataclass(frozen=True, slots=True, kw_only=True)
class LineSettings:
    """How a port is opened.

    Attributes:
        dtr: the level that DTR shall have, True for asserted; None to leave it as opening does.
        rts: the same of RTS.
        parity: "N", "E" or "O".
        stop_bits: 1 or 2.
    """

    dtr: bool | None = None
    rts: bool | None = None
    parity: str = "N"
    stop_bits: int = 1


@dataclass(frozen=True, slots=True, kw_only=True)
class SerialTarget:
    """What to open: a device path, a choice of port or a pyserial URL; the baud rate in bit/s; and how."""

    url: str
    baud: int
    settings: LineSettings = field(default_factory=LineSettings)

    @property
    def is_device(self) -> bool:
        """True for a port of this machine, and not a URL."""
        return "://" not in self.url


def is_serial_target(text: str) -> bool:
    """Say whether a target is at a serial port or behind a pyserial URL, and not something of this machine's own."""
    return text.startswith("serial:") or "://" in text


def parse_serial_target(
    text: str, default_baud: int = DEFAULT_BAUD, settings: LineSettings | None = None
) -> SerialTarget:
    """Return what ``[serial:]PATH-OR-URL[@BAUD[,KEY=VALUE]...]`` names, such as ``serial:/dev/ttyUSB0@115200,dtr=off``.

    Instead of a path there may be a choice of port, such as ``usb=0483:374b`` (`hilbench.ports.choice`). Keys: ``dtr``
    and ``rts`` (on, off), ``parity`` (N, E, O) and ``stop`` (1, 2).

    Args:
        text: the target.
        default_baud: its rate in bit/s where it names none.
        settings: how it is opened where it does not say.

    Raises:
        UsageError: no path, a wrong choice of port, a baud rate of 0, or a key or value that is not known.
    """
    rest = text.removeprefix("serial:")
    match = _FORM.fullmatch(rest)
    url, baud = (match["url"], int(match["baud"])) if match else (rest, default_baud)
    if not url or url.startswith("@") or baud == 0:
        raise UsageError(f"not a serial port: {text!r}", hint=_HINT)
    parse_port_choice(url)
    wanted = settings or LineSettings()
    for word in match["settings"].split(",")[1:] if match else ():
        wanted = _with(wanted, word, text)
    return SerialTarget(url=url, baud=baud, settings=wanted)


def located(target: SerialTarget, ports: PortEnumerator = list_ports) -> SerialTarget:
    """Return a target by its path where it is a choice of port, and any other as it is.

    Raises:
        UnavailableError: no port matches, or several do.
    """
    choice = parse_port_choice(target.url)
    return target if choice is None else replace(target, url=choose_port(choice, ports()).device)


def _with(settings: LineSettings, word: str, text: str) -> LineSettings:
    key, _, value = word.partition("=")
    try:
        name, read = _KEYS[key]
        return replace(settings, **{name: read[value]})
    except KeyError:
        known = "; ".join(f"{key}={'|'.join(values)}" for key, (_, values) in _KEYS.items())
        raise UsageError(f"'{word}' is no setting of a port", where=text, hint=f"there are {known}") from None


_SWITCH = {"on": True, "off": False}
_KEYS: dict[str, tuple[str, dict[str, Any]]] = {
    "dtr": ("dtr", {**_SWITCH}),
    "rts": ("rts", {**_SWITCH}),
    "parity": ("parity", {parity: parity for parity in "NEO"}),
    "stop": ("stop_bits", {"1": 1, "2": 2}),
}
