"""The option bytes of the STM32F76x (RM0410 section 3.4): four half-words, each stored beside its complement.

The manual gives addresses on the AXI bus, 8 bytes apart; that the upper half-word of each word is the complement of the
lower one is a choice, for the manual calls what is there reserved.
"""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["FACTORY_OPTCR", "FACTORY_OPTCR1", "OPTIONS_BASE", "OPTIONS_SIZE", "Options", "decode", "encode"]

OPTIONS_BASE = 0x1FFF_0000
OPTIONS_SIZE = 32
READ_UNPROTECTED, FOR_GOOD = 0xAA, 0xCC

FACTORY_OPTCR = 0xFFFF_AAFD  # RM0410 section 3.7.6
FACTORY_OPTCR1 = 0x0040_0080  # RM0410 section 3.7.7
OPTION_BITS = 0xFFFF_FFFC


@dataclass(frozen=True, slots=True, kw_only=True)
class Options:
    """What the option bytes say.

    Attributes:
        optcr: bits 2 to 31 of FLASH_OPTCR.
        optcr1: FLASH_OPTCR1: the two boot addresses.
    """

    optcr: int
    optcr1: int

    @property
    def read_level(self) -> int:
        """Level of read protection, 0 to 2."""
        return {READ_UNPROTECTED: 0, FOR_GOOD: 2}.get(self.optcr >> 8 & 0xFF, 1)

    @property
    def hardware_watchdog(self) -> bool:
        """The independent watchdog starts by itself."""
        return not self.optcr & 1 << 5

    @property
    def hardware_window_watchdog(self) -> bool:
        """The window watchdog starts by itself."""
        return not self.optcr & 1 << 4

    @property
    def reset_on_stop(self) -> bool:
        """Entering Stop mode resets the chip instead."""
        return not self.optcr & 1 << 6

    @property
    def reset_on_standby(self) -> bool:
        """Entering Standby mode resets the chip instead."""
        return not self.optcr & 1 << 7

    @property
    def dual_bank(self) -> bool:
        """The flash is two banks of half its size."""
        return not self.optcr & 1 << 29

    @property
    def dual_boot(self) -> bool:
        """The chip boots by its boot loader from whichever bank has a program."""
        return not self.optcr & 1 << 28

    def protects(self, number: int) -> bool:
        """Say whether nWRP keeps sector `number` (from 0 to 11, or 0 to 23 with two banks) as it is.

        With two banks each bit stands for two sectors of a bank (RM0410 section 3.4.5).
        """
        return not self.optcr >> 16 + (number // 2 if self.dual_bank else number) & 1

    def boot_address(self, pin: int) -> int:
        """Return where the level of the BOOT pin has the chip boot from: the half-word is bits 29 to 14."""
        return (self.optcr1 >> 16 * pin & 0xFFFF) << 14


def encode(options: Options) -> bytes:
    """Return the 32 bytes that are stored."""
    low = options.optcr & 0xFFFF | 0x3
    halves = (low, options.optcr >> 16, options.optcr1 & 0xFFFF, options.optcr1 >> 16)
    return b"".join(half.to_bytes(2, "little") + (half ^ 0xFFFF).to_bytes(2, "little") + b"\xff" * 4 for half in halves)


def decode(stored: bytes | bytearray) -> Options:
    """Return what 32 stored bytes mean; a half-word that does not match its complement counts as 0xFFFF (choice)."""
    values = []
    for at in range(0, OPTIONS_SIZE, 8):
        half, complement = (int.from_bytes(stored[at + step : at + step + 2], "little") for step in (0, 2))
        values.append(half if half ^ complement == 0xFFFF else 0xFFFF)
    return Options(optcr=(values[1] << 16 | values[0]) & OPTION_BITS, optcr1=values[3] << 16 | values[2])
