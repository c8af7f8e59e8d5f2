"""The table of USB devices against the ids as they are published; where, is in `hilbench.ports.usb_devices`."""

from __future__ import annotations

from hilbench.ports.listing import UsbIdentity
from hilbench.ports.usb_devices import KINDS, chip_of, kind_of
from tests.each import each

PUBLISHED = {
    "60-openocd.rules, ST-LINK": (0x0483, "3744 3748 374b 374d 374e 374f 3752 3753 3754 3755 3757"),
    "usb.h of stlink-org": (0x0483, "3744 3748 374a 374b 374d 374e 374f 3752 3753 3754 3757"),
    "ftdi_sio_ids.h, original PIDs": (0x0403, "6001 6010 6011 6014 6015 6040 6041 6042 6043 6044 6045 6048"),
    "cp210x.c, factory defaults, and the CP2108 data sheet": (0x10C4, "ea60 ea61 ea70 ea71"),
    "ch341.c": (0x1A86, "5523 7522 7523"),
    "ch343.c of WCH": (0x1A86, "55d2 55d3 55d4 55d5 55d7 55d8 55df"),
    "pl2303.h": (0x067B, "2303 2304 23a3 23b3 23c3 23d3 23e3 23f3"),
}


@each("source", PUBLISHED)
def test_what_is_published_is_known(source):
    vendor, products = PUBLISHED[source]
    for product in products.split():
        assert kind_of(UsbIdentity(vendor_id=vendor, product_id=int(product, 16), location="1-1")), product


def test_nothing_else_is_in_the_table():
    published = {(vendor, int(product, 16)) for vendor, products in PUBLISHED.values() for product in products.split()}
    assert {(kind.vendor_id, product) for kind in KINDS for product in kind.products} == published


@each(
    ("vendor", "product", "chip", "has_port"),
    [
        (0x0483, 0x3753, "STLINK-V3 with two ports", True),  # ..._V3_2VCP_PID
        (0x0483, 0x3754, "STLINK-V3 without mass storage", True),  # ..._V3_NO_MSD_PID
        (0x0483, 0x374D, "STLINK-V3 loader", False),  # ..._V3_USBLOADER
        (0x0483, 0x3755, "STLINK-V3 loader", False),
        (0x067B, 0x23C3, "PL2303GT", True),
        (0x067B, 0x23D3, "PL2303GL", True),
        (0x1A86, 0x55D2, "CH342", True),
        (0x1A86, 0x55D8, "CH9101", True),
    ],
)
def test_chips_by_their_ids(vendor, product, chip, has_port):
    usb = UsbIdentity(vendor_id=vendor, product_id=product, location="1-1")
    assert (chip_of(usb), kind_of(usb).has_port) == (chip, has_port)
