"""The option bytes of the STM32F103: eight bytes, each stored beside its complement (PM0075 section 1.2)."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["FACTORY", "OPTIONS_BASE", "OPTIONS_SIZE", "Options", "decode"]

OPTIONS_BASE = 0x1FFF_F800
OPTIONS_SIZE = 16
READ_UNPROTECTED = 0xA5

# RDP, USER, Data0, Data1, WRP0 to WRP3, each with its complement: unprotected, software watchdog, no reset on sleep.
FACTORY = bytes((READ_UNPROTECTED, 0x5A, *(0xFF, 0x00) * 7))


@dataclass(frozen=True, slots=True, kw_only=True)
class Options:
    """What the option bytes say, as FLASH_OBR and FLASH_WRPR show it after a reset.

    Attributes:
        obr: value of FLASH_OBR.
        wrpr: value of FLASH_WRPR; a bit that is 0 protects four pages.
        read_protected: the flash cannot be read from outside; its first four pages cannot be written.
        hardware_watchdog: the independent watchdog starts by itself.
        reset_on_stop: entering Stop mode resets the chip instead.
        reset_on_standby: entering Standby mode resets the chip instead.
    """

    obr: int
    wrpr: int
    read_protected: bool
    hardware_watchdog: bool
    reset_on_stop: bool
    reset_on_standby: bool


def decode(stored: bytes | bytearray) -> Options:
    """Return what sixteen stored bytes mean.

    A byte that does not match its complement counts as 0xFF and sets OPTERR, unless both are erased (PM0075, section
    on the option byte loader).
    """
    values, error = [], False
    for index in range(0, OPTIONS_SIZE, 2):
        value, complement = stored[index], stored[index + 1]
        matches = value ^ complement == 0xFF
        error |= not matches and not value == complement == 0xFF
        values.append(value if matches else 0xFF)
    rdp, user, data0, data1, *wrp = values
    protected = rdp != READ_UNPROTECTED
    return Options(
        obr=error | protected << 1 | user << 2 | data0 << 10 | data1 << 18,
        wrpr=int.from_bytes(bytes(wrp), "little"),
        read_protected=protected,
        hardware_watchdog=not user & 1,
        reset_on_stop=not user & 2,
        reset_on_standby=not user & 4,
    )
