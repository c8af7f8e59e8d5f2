"""Which addresses an I2C interface of the STM32F1 answers to as a slave (RM0008 26.3.2, 26.3.6, 26.6.3, 26.6.4).

Choice: own address 0, as after reset, is none: address 0 is the general call, which ENGC has acknowledged.
"""

from __future__ import annotations

from targets.mcu.stm32f1.i2c_registers import (
    ADDMODE,
    ALERT,
    DUALF,
    ENARP,
    ENDUAL,
    ENGC,
    GENCALL,
    SMBDEFAULT,
    SMBHOST,
    SMBTYPE,
    SMBUS,
)

__all__ = ["ALERT_RESPONSE", "header_matches", "own_address", "second_byte"]

GENERAL_CALL, HOST, ALERT_RESPONSE, DEVICE_DEFAULT = 0x00, 0x08, 0x0C, 0x61
_HEADER = 0x78


def own_address(control: int, oar1: int, oar2: int, address: int, read: bool) -> int | None:
    """Return what SR2 says of an address that is the interface's own, 0 for that of OAR1; None for one that is not.

    Args:
        control: CR1.
        oar1: the own address, as in the register,
        oar2: and the second one.
        address: 7 bits, 0 to 127.
        read: whether the slave is to send.
    """
    if address == GENERAL_CALL:
        return GENCALL if control & ENGC and not read else None
    if not oar1 & ADDMODE and address == oar1 >> 1 & 0x7F:
        return 0
    if not oar1 & ADDMODE and oar2 & ENDUAL and address == oar2 >> 1 & 0x7F:
        return DUALF
    return _of_smbus(control, address, read) if control & SMBUS else None


def _of_smbus(control: int, address: int, read: bool) -> int | None:
    if address == ALERT_RESPONSE and read and control & ALERT:
        return 0
    if address == DEVICE_DEFAULT and control & ENARP and not control & SMBTYPE:
        return SMBDEFAULT
    if address == HOST and control & ENARP and control & SMBTYPE:
        return SMBHOST
    return None


def header_matches(oar1: int, address: int) -> bool:
    """Say whether 7 bits are the header of the 10-bit address in OAR1."""
    return bool(oar1 & ADDMODE) and address == _HEADER | oar1 >> 8 & 3


def second_byte(oar1: int) -> int:
    """Return the rest of that address."""
    return oar1 & 0xFF
