"""USB devices that boards and robots of this kind are reached through: what they are, and which board it probably is.

The same ids stand in ``udev/70-hilbench.rules``. Where they are published:

- ST-LINK: ``stlink_usb.c`` and ``contrib/60-openocd.rules`` of OpenOCD, ``usb.h`` of stlink-org/stlink (3744 to 3757),
  and ``49-stlinkv3.rules`` of STMicroelectronics, which calls 374d and 3755 a loader.
- FTDI: ``drivers/usb/serial/ftdi_sio_ids.h`` of Linux ("original" FTDI device PIDs).
- CP210x: ``cp210x.c`` beside it ("factory default"); EA71 is that of the CP2108 by its data sheet (section 10).
- CH340: ``ch341.c`` beside it. CH342 and CH343 to CH9104, which are of the CDC class and need no driver of their own:
  ``driver/ch343.c`` of WCHSoftGroup/ch343ser_linux.
- PL2303: ``pl2303.h`` of Linux.
- Which ST-LINK is on which Nucleo-144: UM1974 (STM32F767ZI) and UM2407 (STM32H753ZI) of STMicroelectronics.

A bridge says which chip it is and nothing of the board behind it, so the board is a guess.
"""

from __future__ import annotations

from dataclasses import dataclass

from hilbench.ports.listing import UsbIdentity

__all__ = ["KINDS", "UsbKind", "chip_of", "kind_of", "probable_board"]


@dataclass(frozen=True, slots=True, kw_only=True)
class UsbKind:
    """A family of USB devices.

    Attributes:
        name: as in the names below ``/dev/hilbench``.
        vendor_id: 0 to 0xFFFF.
        products: product ids and the chip or probe each is.
        board: what is probably behind it.
        boards: products of which more is known.
        has_port: False for a probe that has no serial port.
    """

    name: str
    vendor_id: int
    products: dict[int, str]
    board: str
    boards: dict[int, str]
    has_port: bool = True


_RS232 = "whatever its three wires lead to: a robot through RS-232, the USART of a bare board"

KINDS = (
    UsbKind(
        name="stlink",
        vendor_id=0x0483,
        products={
            0x374B: "ST-LINK/V2-1",
            0x3752: "ST-LINK/V2-1 without mass storage",
            0x374E: "STLINK-V3E",
            0x374F: "STLINK-V3S",
            0x3753: "STLINK-V3 with two ports",
            0x3754: "STLINK-V3 without mass storage",
            0x3757: "STLINK-V3PWR",
        },
        board="a Nucleo or Discovery board of STMicroelectronics",
        boards={
            0x374B: "a Nucleo board, such as the NUCLEO-F767ZI",
            0x374E: "a Nucleo board, such as the NUCLEO-H753ZI",
        },
    ),
    UsbKind(
        name="stlink-probe",
        vendor_id=0x0483,
        products={
            0x3744: "ST-LINK/V1",
            0x3748: "ST-LINK/V2",
            0x374A: "ST-LINK/V2 with audio",
            0x374D: "STLINK-V3 loader",
            0x3755: "STLINK-V3 loader",
        },
        board="a probe without a serial port",
        boards={},
        has_port=False,
    ),
    UsbKind(
        name="ftdi",
        vendor_id=0x0403,
        products={
            0x6001: "FT232R",
            0x6010: "FT2232",
            0x6011: "FT4232H",
            0x6014: "FT232H",
            0x6015: "FT230X or FT231X",
            0x6040: "FT2233HP",
            0x6041: "FT4233HP",
            0x6042: "FT2232HP",
            0x6043: "FT4232HP",
            0x6044: "FT233HP",
            0x6045: "FT232HP",
            0x6048: "FT4232HA",
        },
        board=_RS232,
        boards={0x6001: "a line of a board with 3.3 V signals, or a robot through RS-232"},
    ),
    UsbKind(
        name="cp210x",
        vendor_id=0x10C4,
        products={0xEA60: "CP2102", 0xEA61: "CP210x", 0xEA70: "CP2105", 0xEA71: "CP2108"},
        board="an ESP32 board, or " + _RS232,
        boards={},
    ),
    UsbKind(
        name="ch340",
        vendor_id=0x1A86,
        products={
            0x7523: "CH340",
            0x7522: "CH340K",
            0x5523: "CH341",
            0x55D2: "CH342",
            0x55D3: "CH343",
            0x55D4: "CH9102",
            0x55D5: "CH344",
            0x55D7: "CH9103",
            0x55D8: "CH9101",
            0x55DF: "CH9104",
        },
        board="an ESP32 or Arduino board, or " + _RS232,
        boards={},
    ),
    UsbKind(
        name="pl2303",
        vendor_id=0x067B,
        products={
            0x2303: "PL2303",
            0x2304: "PL2303TB",
            0x23A3: "PL2303GC",
            0x23B3: "PL2303GB",
            0x23C3: "PL2303GT",
            0x23D3: "PL2303GL",
            0x23E3: "PL2303GE",
            0x23F3: "PL2303GS",
        },
        board=_RS232,
        boards={},
    ),
)


def kind_of(usb: UsbIdentity) -> UsbKind | None:
    """Return the family a device belongs to; None for any other device."""
    return next((kind for kind in KINDS if kind.vendor_id == usb.vendor_id and usb.product_id in kind.products), None)


def chip_of(usb: UsbIdentity) -> str:
    """Return the chip or probe; what the device calls itself if it is not known, else its ids."""
    kind = kind_of(usb)
    return kind.products[usb.product_id] if kind else usb.product or usb.ids


def probable_board(usb: UsbIdentity) -> str:
    """Return what is probably behind a device, in words; empty for one that is not known."""
    kind = kind_of(usb)
    return kind.boards.get(usb.product_id, kind.board) if kind else ""
