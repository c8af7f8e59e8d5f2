"""What the udev rules do, in words, and what they make of the ports that are here."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from hilbench.errors import InternalError
from hilbench.ports.listing import PortInfo
from hilbench.ports.usb_devices import KINDS
from hilbench.udev.apply import Device, Outcome, apply_rules
from hilbench.udev.rules import parse_rules

__all__ = ["PARTS", "Part", "as_data", "as_text", "outcome_at"]

# Names by the place: ours, and that of udev's 60-serial.rules, which has the port's number behind it where a device has
# several. Newer ones are there a second time with the USB revision (usbv2), which is no part of ID_PATH.
_BY_PLACE = (re.compile(r"/dev/hilbench/at-(.+)"), re.compile(r"/dev/serial/by-path/((?!.*-usbv\d-).+?)(-port\d+)?"))


@dataclass(frozen=True, slots=True)
class Part:
    """One thing the rules do.

    Attributes:
        name: what it is about.
        does: what they do.
        why: what happens without.
    """

    name: str
    does: str
    why: str


PARTS = (
    Part(
        "access",
        'TAG+="uaccess" gives a port to the user logged in at the machine itself, GROUP to the members of a group, '
        "also over ssh; the ST-LINK as a device, too, for programs that flash a board",
        "'permission denied' until somebody is added to the group and logs in again",
    ),
    Part(
        "names",
        "/dev/hilbench/KIND-SERIALNUMBER-ifINTERFACE, and /dev/hilbench/at-PATH for the place it is plugged into",
        "/dev/ttyUSB0 is the device that was plugged in first",
    ),
    Part(
        "ModemManager",
        "ID_MM_DEVICE_IGNORE at the device and ID_MM_PORT_IGNORE at the port",
        "ModemManager sends AT commands into a new port and holds it for some seconds; a robot takes them for noise",
    ),
    Part(
        "brltty",
        "its rules do not know an FT232R, CP2102 or CH340 again; all of them do if there is a file "
        "/etc/hilbench/keep-brltty, for a braille display with such a chip",
        "brltty takes the chip for a braille display, and /dev/ttyUSB0 disappears a moment after it came",
    ),
    Part(
        "latency",
        "latency_timer of FTDI chips is 1 ms instead of 16 ms",
        "what comes in is up to 16 ms late, and every verdict about a time is as much less certain",
    ),
)


def outcome_at(text: str, port: PortInfo) -> Outcome | None:
    """Return what rules would make of a port; None if they leave it alone or it has no USB identity.

    What udev's own rules say of it by then is taken from its identity, and the place from the names it has already;
    without one, its name by the place is missing.
    """
    usb = port.usb
    if usb is None:
        return None
    name = port.device.removeprefix("/dev/")
    properties = {
        "ID_VENDOR_ID": f"{usb.vendor_id:04x}",
        "ID_MODEL_ID": f"{usb.product_id:04x}",
        "ID_SERIAL_SHORT": usb.serial_number or "",
        "ID_USB_INTERFACE_NUM": f"{usb.interface:02x}",
        "ID_PATH": _place(port),
    }
    try:
        outcome = apply_rules(parse_rules(text)[0], Device(subsystem="tty", kernel=name, properties=properties))
    except InternalError:  # a file of somebody else's making
        return None
    return outcome if outcome.tags else None


def as_data(text: str, ports: Sequence[PortInfo]) -> dict[str, object]:
    """Return it as plain data."""
    return {
        "parts": [{"name": part.name, "does": part.does, "without": part.why} for part in PARTS],
        "devices": [
            {"kind": kind.name, "usb": f"{kind.vendor_id:04x}:{number:04x}", "chip": chip}
            for kind in KINDS
            for number, chip in kind.products.items()
        ],
        "ports": [_port_data(port, outcome_at(text, port)) for port in ports if port.usb],
    }


def as_text(text: str, ports: Sequence[PortInfo]) -> str:
    """Return it as lines for a person."""
    lines = []
    for part in PARTS:
        lines += [f"{part.name}", f"  {part.does}", f"  without: {part.why}"]
    lines += ["devices"]
    for kind in KINDS:
        chips = ", ".join(f"{number:04x} {chip}" for number, chip in kind.products.items())
        lines.append(f"  {kind.name} ({kind.vendor_id:04x}): {chips}")
    lines += ["ports here"]
    seen = [port for port in ports if port.usb]
    lines += [f"  {port.device}: {_in_words(port, outcome_at(text, port))}" for port in seen]
    return "\n".join(lines if seen else [*lines, "  none with a USB identity"])


def _place(port: PortInfo) -> str:
    """Return what udev calls the place a port is plugged into (``ID_PATH``); empty where no name tells."""
    found = (form.fullmatch(link) for form in _BY_PLACE for link in port.links)
    return next((match[1] for match in found if match), "")


def _port_data(port: PortInfo, outcome: Outcome | None) -> dict[str, object]:
    return {"device": port.device, "left_alone": outcome is None, "names": _names(outcome)}


def _in_words(port: PortInfo, outcome: Outcome | None) -> str:
    if outcome is None:
        return "left alone"
    names = _names(outcome)
    if not _place(port):
        names.append(f"{'and one' if names else 'a name'} by the place it is plugged into")
    return ", ".join(names)


def _names(outcome: Outcome | None) -> list[str]:
    return [f"/dev/{link}" for link in outcome.links] if outcome else []
