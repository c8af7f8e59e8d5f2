"""The serial ports of this machine and what is plugged into them.

Linux keeps what it knows of a port in sysfs: under ``/sys/class/tty/NAME/device`` hangs the driver's port, above it the
interface of the USB device (``bInterfaceNumber``), above that the device itself (``idVendor``, ``idProduct``,
``serial``; Linux, Documentation/ABI/testing/sysfs-bus-usb). A name such as ``/dev/ttyUSB0`` is given to whoever comes
first; what a board keeps when it is unplugged and comes back is its `UsbIdentity`.

Whoever needs the ports takes a `PortEnumerator`, so that tests can hand in ports that do not exist.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from hilbench.files.names import printable

__all__ = ["LINK_FOLDERS", "PortEnumerator", "PortInfo", "SysfsPorts", "UsbIdentity", "find_again", "list_ports"]

LINK_FOLDERS = ("dev/hilbench", "dev/serial/by-id", "dev/serial/by-path")
"""Where other names of a port are, ours first; relative to the root."""

# A port whose driver found no chip: PORT_UNKNOWN of the kernel's serial_core.h. There are 4 to 32 of them on a PC.
_NO_CHIP = "0"


@dataclass(frozen=True, slots=True, kw_only=True)
class UsbIdentity:
    """What a USB device says of itself, and where it is plugged in.

    Attributes:
        vendor_id: 0 to 0xFFFF.
        product_id: 0 to 0xFFFF.
        serial_number: None where the device has none. Not always one of its own: many CP2102 say ``0001``.
        location: the way from the bus through the hubs, such as ``1-1.2``: bus 1, its port 1, port 2 of the hub there.
        interface: number of the interface, for devices that are several ports.
        manufacturer: as the device words it, or None.
        product: as the device words it, or None.
    """

    vendor_id: int
    product_id: int
    serial_number: str | None = None
    location: str
    interface: int = 0
    manufacturer: str | None = None
    product: str | None = None

    @property
    def ids(self) -> str:
        """Vendor and product id as ``lsusb`` prints them: ``0483:374b``."""
        return f"{self.vendor_id:04x}:{self.product_id:04x}"

    def is_same_kind(self, other: UsbIdentity) -> bool:
        """Say whether both are the same port of the same kind of device, with the same serial number or without."""
        return self._kind == other._kind

    @property
    def _kind(self) -> tuple[int, int, int, str | None]:
        return (self.vendor_id, self.product_id, self.interface, self.serial_number)


@dataclass(frozen=True, slots=True, kw_only=True)
class PortInfo:
    """A serial port.

    Attributes:
        device: its path, such as ``/dev/ttyACM0``.
        usb: the USB device it belongs to; None for a port that is soldered in.
        driver: the kernel driver, such as ``ftdi_sio``; None where it is not known.
        links: other paths that lead to it, those of hilbench first.
        sysfs: the folder with its attributes; None where there is none.
        latency_ms: how long the chip may keep what came in, where its driver tells: FTDI's ``latency_timer``.
    """

    device: str
    usb: UsbIdentity | None = None
    driver: str | None = None
    links: tuple[str, ...] = ()
    sysfs: str | None = None
    latency_ms: int | None = None


class PortEnumerator(Protocol):
    """Whatever can say which ports there are now."""

    def __call__(self) -> Sequence[PortInfo]:
        """Return the ports there are at this moment, by name. Never raises for a port that goes away meanwhile."""


def list_ports() -> Sequence[PortInfo]:
    """Return the serial ports of this machine, by name; pseudo-terminals are not among them.

    A port is listed as soon as the kernel has it. Its permissions are set by udev a moment later.
    """
    return SysfsPorts()()


def find_again(identity: UsbIdentity, ports: Iterable[PortInfo]) -> PortInfo | None:
    """Return the port at which a device is now, whatever it is called and wherever it is plugged in.

    The one that is of the same kind and has the same serial number is taken. Where several are alike (no serial number,
    or the same one in all of them), it is the one at the old place. Without a serial number another place is another
    device. None if it is not there, or cannot be told from others.
    """
    alike = [port for port in ports if port.usb is not None and port.usb.is_same_kind(identity)]
    at_place = [port for port in alike if port.usb is not None and port.usb.location == identity.location]
    if len(at_place) == 1:
        return at_place[0]
    return alike[0] if len(alike) == 1 and identity.serial_number is not None else None


@dataclass(frozen=True, slots=True)
class SysfsPorts:
    """The enumerator of Linux.

    Args:
        root: where ``sys`` and ``dev`` are.
    """

    root: Path = Path("/")

    def __call__(self) -> Sequence[PortInfo]:
        """Return the ports there are at this moment."""
        folder = self.root / "sys/class/tty"
        try:
            # Sixty consoles have no device; a bench that looks for a port must not be late by them.
            names = [name for name in os.listdir(folder) if os.path.exists(f"{folder}/{name}/device")]  # noqa: PTH110, PTH208
        except OSError:
            return ()
        links = self._links()
        found = (self._port(folder / name, links) for name in sorted(names, key=_by_number))
        return tuple(port for port in found if port is not None)

    def _port(self, entry: Path, links: dict[str, list[str]]) -> PortInfo | None:
        if _line(entry / "type") == _NO_CHIP:
            return None
        folder = _end_of(entry / "device")
        if not folder.exists():  # it has gone meanwhile
            return None
        path = f"/dev/{entry.name}"
        return PortInfo(
            device=path,
            usb=_usb_identity(folder),
            driver=_driver(folder),
            links=tuple(links.get(path, ())),
            sysfs=str(folder),
            latency_ms=_number(folder / "latency_timer"),
        )

    def _links(self) -> dict[str, list[str]]:
        """Return the other names of each port."""
        found: dict[str, list[str]] = {}
        for name in LINK_FOLDERS:
            folder = self.root / name
            try:
                entries = sorted(folder.iterdir())
            except OSError:
                continue
            for link in entries:
                if link.is_symlink():
                    found.setdefault(f"/dev/{_end_of(link).name}", []).append(f"/{name}/{link.name}")
        return found


def _usb_identity(folder: Path) -> UsbIdentity | None:
    """Read the device above a port's folder; None if there is none, it cannot be read, or goes while it is read."""
    interface: int | None = 0
    for place in (folder, *folder.parents):
        if (text := _line(place / "bInterfaceNumber")) is not None:
            interface = _hex(text, 2)
        vendor, product = (_hex(_line(place / name), 4) for name in ("idVendor", "idProduct"))
        if vendor is not None and product is not None and interface is not None:
            return UsbIdentity(
                vendor_id=vendor,
                product_id=product,
                serial_number=_line(place / "serial") or None,
                location=place.name,
                interface=interface,
                manufacturer=_line(place / "manufacturer") or None,
                product=_line(place / "product") or None,
            )
    return None


def _driver(folder: Path) -> str | None:
    """Return the driver of a port; one that is soldered in hangs below two places of the kernel's."""
    for place in (folder, *folder.parents):
        if _end_of(place / "subsystem").name != "serial-base":
            link = place / "driver"
            return _end_of(link).name if link.exists() else None
    return None


def _end_of(link: Path) -> Path:
    """Return where a link leads; itself if that is a circle."""
    return Path(os.path.realpath(link))


def _line(path: Path) -> str | None:
    """Return the first line of an attribute, without what would move a terminal; None if it cannot be read."""
    try:
        with path.open(encoding="utf-8", errors="replace") as file:
            return printable(file.readline().strip())
    except OSError:
        return None


def _hex(text: str | None, digits: int) -> int | None:
    """Return a number of so many hex digits, as the kernel writes ids; None if it is none."""
    return int(text, 16) if text is not None and re.fullmatch(f"[0-9a-fA-F]{{{digits}}}", text) else None


def _number(path: Path) -> int | None:
    text = _line(path)
    return int(text) if text is not None and re.fullmatch("[0-9]{1,9}", text) else None


def _by_number(name: str) -> tuple[str, int]:
    """Sort ttyUSB2 before ttyUSB10."""
    word = name.rstrip("0123456789")
    return word, int(name[len(word) :] or 0)
