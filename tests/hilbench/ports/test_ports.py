from __future__ import annotations

import os
from pathlib import Path
from types import SimpleNamespace

import pytest
from serial.tools import list_ports_linux

from hilbench.ports.listing import PortInfo, SysfsPorts, UsbIdentity, find_again, list_ports
from tests.each import each


def identity(**changes):
    return UsbIdentity(**{"vendor_id": 0x0403, "product_id": 0x6001, "location": "1-1"} | changes)


def port(device="/dev/ttyUSB0", **changes):
    return PortInfo(device=device, usb=identity(**changes))


def test_a_board_says_who_it_is(machine):
    machine.plug(
        "ttyACM0",
        location="1-1.2",
        interface=2,
        serial="0668FF",
        product="STM32 STLink",
        manufacturer="STMicroelectronics",
    )
    (found,) = SysfsPorts(machine.root)()
    assert found.device == "/dev/ttyACM0"
    assert found.driver == "cdc_acm"
    assert found.usb == UsbIdentity(
        vendor_id=0x0483,
        product_id=0x374B,
        serial_number="0668FF",
        location="1-1.2",
        interface=2,
        product="STM32 STLink",
        manufacturer="STMicroelectronics",
    )
    assert found.usb.ids == "0483:374b"


def test_an_adapter_has_a_folder_of_its_driver_in_between(machine):
    folder = machine.plug("ttyUSB0", ids="0403:6001", location="3-4.1.2", driver="ftdi_sio")
    (found,) = SysfsPorts(machine.root)()
    assert found.usb == identity(location="3-4.1.2")
    assert found.driver == "ftdi_sio"
    assert found.sysfs == str(folder)


def test_what_is_no_port_is_not_listed(machine):
    machine.virtual("tty0")
    machine.virtual("ptmx")
    machine.solder("ttyS0")
    machine.solder("ttyS1", chip=0)
    assert [(found.device, found.usb) for found in SysfsPorts(machine.root)()] == [("/dev/ttyS0", None)]


def test_ports_are_sorted_by_their_numbers(machine):
    for number in (10, 2, 0):
        machine.plug(f"ttyUSB{number}", location=f"1-{number}", driver="ch341")
    assert [found.device for found in SysfsPorts(machine.root)()] == ["/dev/ttyUSB0", "/dev/ttyUSB2", "/dev/ttyUSB10"]


def test_other_names_are_found_ours_first(machine):
    machine.plug("ttyUSB0", driver="ftdi_sio")
    machine.link("/dev/serial/by-path/pci-1", "ttyUSB0")
    machine.link("/dev/serial/by-id/usb-FTDI", "ttyUSB0")
    machine.link("/dev/hilbench/ftdi", "ttyUSB0")
    machine.link("/dev/hilbench/gone", "ttyUSB7")
    (found,) = SysfsPorts(machine.root)()
    assert found.links == ("/dev/hilbench/ftdi", "/dev/serial/by-id/usb-FTDI", "/dev/serial/by-path/pci-1")


def test_a_machine_without_ports_has_none(tmp_path):
    assert SysfsPorts(tmp_path)() == ()


def test_a_port_that_goes_while_it_is_read_is_left_out(machine):
    machine.plug("ttyUSB0")
    machine.plug("ttyUSB1", location="1-2")
    (machine.tty / "ttyUSB0/device").resolve().rename(machine.root / "elsewhere")
    assert [found.device for found in SysfsPorts(machine.root)()] == ["/dev/ttyUSB1"]


@pytest.fixture
def by_pyserial(machine, monkeypatch):
    """What pyserial finds in the tree of a machine."""

    def moved(path):
        return str(machine.root) + path if path.startswith("/sys/class/") else path

    same = {name: getattr(os.path, name) for name in ("islink", "join", "basename", "dirname")}
    paths = SimpleNamespace(
        **same,
        exists=lambda path: os.path.exists(moved(path)),
        realpath=lambda path: os.path.realpath(moved(path)),
    )
    nodes = SimpleNamespace(glob=lambda form: [f"/dev/{node.name}" for node in machine.root.glob(form[1:])])
    monkeypatch.setattr(list_ports_linux, "os", SimpleNamespace(path=paths))
    monkeypatch.setattr(list_ports_linux, "glob", nodes)
    return list_ports_linux.comports


def test_pyserial_finds_the_same_usb_ports_and_says_the_same_of_them(machine, by_pyserial):
    machine.plug("ttyACM0", location="1-1.2", interface=2, serial="0668FF", product="STM32 STLink", manufacturer="ST")
    machine.plug("ttyUSB0", ids="0403:6001", location="3-4.1.2", driver="ftdi_sio", serial="A50285BI")
    machine.plug("ttyUSB11", ids="1a86:7523", location="3-4.3", driver="ch341-uart", product="USB Serial")
    machine.solder("ttyS0")
    ours = {found.device: found.usb for found in SysfsPorts(machine.root)() if found.usb}
    theirs = {
        found.device: UsbIdentity(
            vendor_id=found.vid,
            product_id=found.pid,
            serial_number=found.serial_number,
            location=found.location.partition(":")[0],  # of a device with several interfaces it names the interface
            interface=ours[found.device].interface,
            manufacturer=found.manufacturer,
            product=found.product,
        )
        for found in by_pyserial()
    }
    assert ours == theirs
    assert len(ours) == 3


def test_the_ports_of_this_machine_are_looked_for_where_linux_has_them(monkeypatch):
    monkeypatch.setattr(SysfsPorts, "__call__", lambda looking: looking.root)
    assert list_ports() == Path("/")


@each(("there", "expected"), [
        ([], None),
        ([port("/dev/ttyUSB1", serial_number="A1", location="2-1")], "/dev/ttyUSB1"),
        ([port("/dev/ttyUSB1", serial_number="B1"), PortInfo(device="/dev/ttyS0")], None),
        ([port("/dev/ttyUSB1", serial_number="A1", interface=1)], None),
        ([port("/dev/ttyUSB1", serial_number="A1", product_id=0x6010)], None),
        ([port("/dev/ttyUSB0", serial_number="A1", location="2-1"), port("/dev/ttyUSB1", serial_number="A1")],
         "/dev/ttyUSB1"),
        ([port("/dev/ttyUSB0", serial_number="A1", location="2-1"),
          port("/dev/ttyUSB1", serial_number="A1", location="3-1")], None),
    ])  # fmt: skip
def test_a_device_is_found_again_by_its_serial_number(there, expected):
    found = find_again(identity(serial_number="A1"), there)
    assert (found.device if found else None) == expected


@each(
    ("there", "expected"),
    [
        ([port("/dev/ttyUSB3")], "/dev/ttyUSB3"),
        ([port("/dev/ttyUSB0", location="1-2")], None),
        ([port("/dev/ttyUSB0", location="1-2"), port("/dev/ttyUSB1")], "/dev/ttyUSB1"),
        ([port("/dev/ttyUSB0", serial_number="A1")], None),
    ],
)
def test_a_device_without_serial_number_is_found_at_its_place_only(there, expected):
    found = find_again(identity(), there)
    assert (found.device if found else None) == expected


def test_a_board_that_comes_back_under_another_name_is_found(machine):
    enumerate_ports = SysfsPorts(machine.root)
    machine.plug("ttyACM0", serial="0668FF", location="1-1")
    (before,) = enumerate_ports()
    machine.pull("ttyACM0")
    assert find_again(before.usb, enumerate_ports()) is None
    machine.plug("ttyACM1", serial="0668FF", location="1-3")
    assert find_again(before.usb, enumerate_ports()).device == "/dev/ttyACM1"
