"""Chooses a port by what is plugged into it: ``usb=0483:374b``, ``serial=0668FF303430``, ``location=1-1.2``.

Conditions are joined by commas, and all of them must hold: ``usb=0403:6010,interface=1``. It stands where a path may
stand, so ``serial:usb=0483:374b@115200`` is a target as ``serial:/dev/ttyACM0@115200`` is one. Exactly one port must be
meant: the bench guesses nothing.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from hilbench.errors import UnavailableError, UsageError
from hilbench.nearest import did_you_mean
from hilbench.ports.listing import PortInfo, UsbIdentity

__all__ = ["PortChoice", "choose_port", "in_a_word", "parse_port_choice", "tells_apart"]

_LOOKS_LIKE_ONE = re.compile(r"(?P<key>[a-z][a-z-]*)=.*", re.DOTALL | re.IGNORECASE)
# A serial number may hold commas; what follows one is a condition only if it begins like one.
_BETWEEN = re.compile(r",(?=[a-z][a-z-]*=)", re.IGNORECASE)

_VALUES: Mapping[str, tuple[re.Pattern[str], str]] = {
    "usb": (re.compile(r"[0-9a-f]{4}:[0-9a-f]{4}"), "two numbers of four hex digits, as in usb=0483:374b"),
    "serial": (re.compile(r".+", re.DOTALL), "a serial number, as in serial=0668FF303430"),
    "location": (re.compile(r"\d+-\d+(\.\d+)*"), "bus and ports, as in location=1-1.2"),
    "interface": (re.compile(r"\d+"), "a number, as in interface=1"),
}
_SHOWN: Mapping[str, Callable[[UsbIdentity], str | None]] = {
    "usb": lambda usb: usb.ids,
    "serial": lambda usb: usb.serial_number,
    "location": lambda usb: usb.location,
    "interface": lambda usb: str(usb.interface),
}
# What can stand in a target; bridges leave the factory with 0001.
_OF_ITS_OWN = re.compile(r"(?!0001$)[\w.:-]+")


@dataclass(frozen=True, slots=True)
class PortChoice:
    """What a port must be.

    Attributes:
        conditions: keys (``usb``, ``serial``, ``location``, ``interface``) and what they must be, in the order given.
    """

    conditions: tuple[tuple[str, str], ...]

    def __str__(self) -> str:
        return ",".join(f"{key}={value}" for key, value in self.conditions)

    def fits(self, port: PortInfo) -> bool:
        """Say whether a port is what is wanted; one without USB identity never is."""
        usb = port.usb
        return usb is not None and all(_SHOWN[key](usb) == value for key, value in self.conditions)


def parse_port_choice(text: str) -> PortChoice | None:
    """Return what a text chooses; None if it is a path or a URL.

    Raises:
        UsageError: it begins with ``KEY=`` and is wrong.
    """
    if not _LOOKS_LIKE_ONE.fullmatch(text):
        return None
    conditions = tuple(_condition(part) for part in _BETWEEN.split(text))
    keys = [key for key, _ in conditions]
    twice = next((key for key in keys if keys.count(key) > 1), None)
    if twice is not None:
        raise UsageError(f"'{twice}=' is given twice", where=text, hint="each condition once")
    return PortChoice(conditions)


def choose_port(choice: PortChoice, ports: Sequence[PortInfo]) -> PortInfo:
    """Return the one port that is meant.

    Raises:
        UnavailableError: none is, or several are; it says which ports there are.
    """
    fitting = [port for port in ports if choice.fits(port)]
    if len(fitting) == 1:
        return fitting[0]
    if fitting:
        hint = f"say which by serial=, location= or interface=: {_listed(fitting)}"
        raise UnavailableError(f"{len(fitting)} ports match", where=str(choice), hint=hint)
    with_usb = [port for port in ports if port.usb is not None]
    hint = (
        f"there are {_listed(with_usb)}" if with_usb else "no USB port is there; plug it in, then see 'hilbench ports'"
    )
    raise UnavailableError("no port matches", where=str(choice), hint=hint)


def tells_apart(serial_number: str | None) -> bool:
    """Say whether a serial number tells a device from others, and can be written where a port is chosen."""
    return serial_number is not None and _OF_ITS_OWN.fullmatch(serial_number) is not None


def in_a_word(port: PortInfo) -> str:
    """Return a port and what is plugged into it, for a list in a sentence."""
    usb = port.usb
    if usb is None:
        return port.device
    number = f"serial={usb.serial_number}, " if usb.serial_number else ""
    interface = f", interface={usb.interface}" if usb.interface else ""
    return f"{port.device} (usb={usb.ids}, {number}location={usb.location}{interface})"


def _listed(ports: Sequence[PortInfo]) -> str:
    return ", ".join(in_a_word(port) for port in ports)


def _condition(part: str) -> tuple[str, str]:
    key, _, value = part.partition("=")
    if key not in _VALUES:
        hint = did_you_mean(key, _VALUES, "a port is chosen by")
        raise UsageError(f"ports have no '{key}='", where=part, hint=hint)
    form, wanted = _VALUES[key]
    value = value.lower() if key == "usb" else value
    if not form.fullmatch(value):
        raise UsageError(f"'{key}=' takes {wanted}", where=part)
    return key, str(int(value)) if key == "interface" else value
