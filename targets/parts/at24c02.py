"""A 24C02 EEPROM: 256 bytes on an I2C bus, by the data sheet of the AT24C02C (Microchip DS20006127).

It takes an address of one byte and up to eight bytes of a page, and writes them after the STOP; for as long as that
takes it acknowledges nothing (section 6.3). Reading goes on at the byte behind the last one, past the end at the
beginning (section 7). A page that is overfilled goes on at its own beginning (section 6.2). While WP is high nothing is
written, and the bytes are acknowledged all the same (section 6.4).
"""

from __future__ import annotations

from dataclasses import dataclass

from targets.mcu.i2c_bus import I2cSlave
from targets.parts.part import Direction, Part, Ports, Terminal
from targets.parts.settings import check_settings, setting

__all__ = ["At24c02", "At24c02Settings", "EepromWritten"]

SIZE, PAGE_BYTES = 256, 8
_MS = 1_000_000


@dataclass(frozen=True, slots=True, kw_only=True)
class At24c02Settings:
    """Where it answers, and how long it writes.

    Raises:
        ValueError: a value makes no EEPROM.
    """

    address_pins: int = setting(
        0, "of A2 to A0", "AT24C02C section 4.1: its address is 0x50 to 0x57", least=0, greatest=7
    )
    write_ms: float = setting(5.0, "ms", "AT24C02C section 3.5: tWR, at most", least=0.0)

    def __post_init__(self) -> None:
        check_settings(self)


@dataclass(frozen=True, slots=True, kw_only=True)
class EepromWritten:
    """Bytes are written from `at_ns` on; none while WP is high."""

    address: int
    data: bytes
    protected: bool
    at_ns: int


class At24c02(Part):
    """See the head of this file.

    Attributes:
        data: every byte.
    """

    TERMINALS = (Terminal(name="wp", direction=Direction.IN, text="high: nothing is written; open: low"),)
    BUSES = ("i2c",)
    ADDRESSED_BY = "address_pins"
    ABSENT = ("wear", "data damaged by a loss of supply")
    Settings = At24c02Settings

    def __init__(self, settings: At24c02Settings, ports: Ports, *, seed: int) -> None:  # noqa: ARG002
        self.data = bytearray(b"\xff" * SIZE)
        self._at = self.address_of(settings)
        self._write_ns = round(settings.write_ms * _MS)
        self._wp = ports.input("wp")
        self._tell = ports.tell
        self._place = 0
        self._placed = False
        self._page: list[int] = []
        self._busy_until_ns = 0

    @staticmethod
    def address_of(settings: At24c02Settings) -> int:
        """Return its address, by its address pins."""
        return 0x50 | settings.address_pins

    def slave(self, name: str) -> I2cSlave:
        """Return what answers on the bus; raises KeyError as `Part.slave` does."""
        return {"i2c": self}[name]

    def address(self, address: int, read: bool, now_ns: int) -> bool:
        """Acknowledge its own address, unless it writes."""
        if address != self._at or now_ns < self._busy_until_ns:
            return False
        self._placed = read
        self._page = []
        return True

    def write(self, byte: int, now_ns: int) -> bool:  # noqa: ARG002
        """Take the place, then bytes."""
        if self._placed:
            self._page.append(byte)
        else:
            self._place, self._placed = byte, True
        return True

    def read(self, now_ns: int) -> int:  # noqa: ARG002
        """Return the byte at the place, and go on."""
        byte, self._place = self.data[self._place], (self._place + 1) % SIZE
        return byte

    def end(self, now_ns: int) -> None:
        """Write what has come; a repeated START ends it as a STOP does (choice)."""
        page, self._page = self._page, []
        if not page:
            return
        base, protected = self._place & ~(PAGE_BYTES - 1), self._wp.level_at(now_ns)
        for number, byte in enumerate(page):
            if not protected:
                self.data[base | (self._place + number) % PAGE_BYTES] = byte
        self._tell(EepromWritten(address=self._place, data=bytes(page), protected=protected, at_ns=now_ns))
        self._place = base | (self._place + len(page)) % PAGE_BYTES
        if not protected:
            self._busy_until_ns = now_ns + self._write_ns
