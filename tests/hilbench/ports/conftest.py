from __future__ import annotations

import shutil
from pathlib import Path

import pytest


class Machine:
    """A tree like that of Linux, with ports that are plugged in and pulled out."""

    def __init__(self, root: Path):
        self.root = root
        self.tty = root / "sys/class/tty"
        self.tty.mkdir(parents=True)
        (root / "dev").mkdir()
        self.devices = root / "sys/devices/pci0000:00/0000:00:14.0/usb1"

    def plug(self, name, *, ids="0483:374b", location="1-1", interface=0, driver="cdc_acm", **texts):
        """Plug a USB device in whose port gets `name`; usb-serial drivers have a folder of their own below."""
        device = self.devices / location
        inside = device / f"{location}:1.{interface}"
        port = inside if driver == "cdc_acm" else inside / name
        port.mkdir(parents=True)
        vendor, product = ids.split(":")
        about = {"idVendor": vendor, "idProduct": product, "bNumInterfaces": interface + 1}
        for attribute, text in (about | texts).items():
            (device / attribute).write_text(f"{text}\n")
        (inside / "bInterfaceNumber").write_text(f"{interface:02x}\n")
        self._driver(port, driver)
        self._port(name, port)
        return port

    def solder(self, name, *, chip=4):
        """Have a port that is soldered in; chip 0 is none."""
        port = self.root / f"sys/devices/platform/serial8250/{name}"
        port.mkdir(parents=True)
        self._driver(port, "serial8250")
        self._port(name, port)
        (self.tty / name).joinpath("type").write_text(f"{chip}\n")

    def pull(self, name):
        port = (self.tty / name / "device").resolve()
        shutil.rmtree(self.tty / name)
        shutil.rmtree(port)
        (self.root / "dev" / name).unlink()

    def link(self, path, name):
        """Give a port another name, as udev does."""
        link = self.root / path.removeprefix("/")
        link.parent.mkdir(parents=True, exist_ok=True)
        link.symlink_to(self.root / "dev" / name)

    def virtual(self, name):
        (self.tty / name).mkdir()

    def _driver(self, port, driver):
        folder = self.root / "sys/bus/drivers" / driver
        folder.mkdir(parents=True, exist_ok=True)
        (port / "driver").symlink_to(folder)
        subsystem = "usb" if driver == "cdc_acm" else "usb-serial"
        (port / "subsystem").symlink_to(self.root / "sys/bus" / ("platform" if driver == "serial8250" else subsystem))

    def _port(self, name, port):
        entry = self.tty / name
        entry.mkdir()
        (entry / "device").symlink_to(port)
        node = self.root / "dev" / name
        node.touch()
        node.chmod(0o644)


@pytest.fixture
def machine(tmp_path):
    return Machine(tmp_path / "machine")
