"""The option bytes of the STM32H743 and H753 (RM0433 section 4.4): registers only, for they have no address.

Each comes twice: what holds now (CUR) and what will be programmed (PRG). Factory values as in RM0433 section 4.4.
"""

from __future__ import annotations

from dataclasses import dataclass
from types import MappingProxyType

__all__ = ["CURRENT", "FACTORY", "PROGRAMMED", "Options"]

OPTSR_CUR, PRAR_CUR1, SCAR_CUR1, WPSN_CUR1, BOOT_CURR = 0x1C, 0x28, 0x30, 0x38, 0x40
PRAR_CUR2, SCAR_CUR2, WPSN_CUR2 = 0x128, 0x130, 0x138
CURRENT = (OPTSR_CUR, PRAR_CUR1, SCAR_CUR1, WPSN_CUR1, BOOT_CURR, PRAR_CUR2, SCAR_CUR2, WPSN_CUR2)
"""Offsets of the registers with what holds."""
PROGRAMMED = MappingProxyType({offset: offset + 4 for offset in CURRENT})
"""Those with what will be programmed."""

# Read protection 0; both watchdogs are started by software and run on in Stop and Standby; no reset by Stop or Standby.
# No area is protected; BOOT0 low starts at 0x08000000, high at the boot loader.
FACTORY = MappingProxyType(
    {
        OPTSR_CUR: 0x0406_AAF0,
        PRAR_CUR1: 0x0000_00FF,
        SCAR_CUR1: 0x0000_00FF,
        WPSN_CUR1: 0xFF,
        BOOT_CURR: 0x1FF0_0800,
        PRAR_CUR2: 0x0000_00FF,
        SCAR_CUR2: 0x0000_00FF,
        WPSN_CUR2: 0xFF,
    }
)
"""What they are in a chip that nobody has changed."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Options:
    """What the option bytes say, as far as this model heeds them.

    Attributes:
        status: OPTSR_CUR.
        boot: BOOT_CURR: the upper halves of the two boot addresses.
        unprotected: WPSN_CUR of both banks: a bit for each sector, 0 protects it.
    """

    status: int
    boot: int
    unprotected: tuple[int, int]

    @property
    def hardware_watchdog(self) -> bool:
        """The independent watchdog starts by itself."""
        return not self.status & 1 << 4

    @property
    def reset_on_stop(self) -> bool:
        """Entering Stop mode resets the chip instead."""
        return not self.status & 1 << 6

    @property
    def reset_on_standby(self) -> bool:
        """Entering Standby mode resets the chip instead."""
        return not self.status & 1 << 7

    @property
    def swapped(self) -> bool:
        """The banks change places."""
        return bool(self.status & 1 << 31)

    def protects(self, bank: int, sector: int) -> bool:
        """Say whether a sector, 0 to 7, of bank 0 or 1 is write-protected."""
        return not self.unprotected[bank] >> sector & 1

    def boot_address(self, pin: int) -> int:
        """Return where the level of the BOOT0 pin has the chip boot from."""
        return (self.boot >> 16 * pin & 0xFFFF) << 16
