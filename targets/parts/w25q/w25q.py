"""A W25Q32, W25Q64 or W25Q128 on an SPI bus, by the data sheet of the W25Q64JV (Winbond, revision K).

A command begins with the first byte after chip select has fallen, and is carried out when it rises. While the flash is
busy it hears nothing but reads of its status. Times are the typical ones of the data sheet (section 9.6, from memory).

Chip select is looked at when bytes come, and every 100 ms while a command is open, so that the moment at which it rose
is known exactly.

What is not modelled: `W25q.ABSENT`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

from targets.mcu.spi_bus import SpiSlave
from targets.parts.part import Direction, Part, Ports, Terminal
from targets.parts.settings import check_settings, setting
from targets.parts.w25q.array import SECTOR_BYTES, Array

__all__ = ["FlashChanged", "FlashIgnored", "W25q", "W25qSettings"]

BUSY, WEL = 1, 2
LOOK_NS = 100_000_000
MAKER, DEVICES = 0xEF, {32: 0x15, 64: 0x16, 128: 0x17}
KIND = 0x40  # JEDEC memory type of the W25QxxJV-IQ
_ADDRESS_BYTES = 3
_US, _MS = 1000, 1_000_000
_STATUS = {0x05: 0, 0x35: 1, 0x15: 2}
_WRITE_STATUS = {0x01: 0, 0x31: 1, 0x11: 2}
_WRITABLE = (0xFC, 0x43, 0x60)
_READS = {0x03: 4, 0x0B: 5}  # by command: the number of the first byte that is read
_WHOLE = (0xC7, 0x60)
_ERASES = {0x20: SECTOR_BYTES, 0x52: 8 * SECTOR_BYTES, 0xD8: 16 * SECTOR_BYTES}
_CHANGES = frozenset({0x02, *_WHOLE, *_ERASES})
_ABSENT = {
    0x3B: "dual output", 0xBB: "dual I/O", 0x6B: "quad output", 0xEB: "quad I/O", 0x32: "quad input", 0x5A: "SFDP",
    0x75: "suspend", 0x7A: "resume", 0x44: "security registers", 0x42: "security registers", 0x48: "security registers",
    0x36: "individual locks", 0x39: "individual locks", 0x7E: "individual locks", 0x98: "individual locks",
}  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class W25qSettings:
    """Which one it is, and how long it takes.

    Raises:
        ValueError: a value makes no flash.
    """

    megabits: Literal[32, 64, 128] = setting(64, "Mbit", "W25Q32JV, W25Q64JV, W25Q128JV")
    page_program_us: float = setting(400.0, "us", "W25Q64JV section 9.6: tPP, typical", least=0.0)
    sector_erase_ms: float = setting(45.0, "ms", "W25Q64JV section 9.6: tSE, typical", least=0.0)
    block_erase_ms: float = setting(
        150.0, "ms", "W25Q64JV section 9.6: tBE2, typical; half a block takes 4/5", least=0.0
    )
    chip_erase_s: float = setting(20.0, "s", "W25Q64JV section 9.6: tCE, typical", least=0.0)
    write_status_ms: float = setting(10.0, "ms", "W25Q64JV section 9.6: tW, typical", least=0.0)

    def __post_init__(self) -> None:
        check_settings(self)


@dataclass(frozen=True, slots=True, kw_only=True)
class FlashChanged:
    """Cells are programmed or erased from `at_ns` on: `what` is ``program``, ``erase`` or ``status``."""

    what: str
    address: int
    size: int
    at_ns: int


@dataclass(frozen=True, slots=True, kw_only=True)
class FlashIgnored:
    """A command had no effect, and why."""

    command: int
    why: str
    at_ns: int


class W25q(Part):
    """See the head of this file."""

    TERMINALS = (Terminal(name="cs", direction=Direction.IN, needed=True, text="chip select, active low"),)
    SPI_BUSES = ("spi",)
    ABSENT = (
        "dual and quad transfers",
        "SFDP",
        "suspend and resume",
        "security registers, individual locks, CMP and the lock bits of the status",
        "the pins WP and HOLD",
        "wear, and data damaged by a loss of supply",
    )
    Settings = W25qSettings

    def __init__(self, settings: W25qSettings, ports: Ports, *, seed: int) -> None:
        self._settings = settings
        self._cs = ports.input("cs")
        self._tell = ports.tell
        self._unique = seed.to_bytes(16, "little", signed=False)[:8]
        self.array = Array(settings.megabits << 17)
        self._status = bytearray(3)
        self._open = bytearray()
        self._answer: Callable[[int], int] = lambda _number: 0xFF
        self._looked_ns = 0
        self._busy_until_ns = 0
        self._asleep = self._reset_armed = False
        self._volatile = False
        self.releases = 0  # of chip select, so far
        self.broken: Callable[[], None] = lambda: None
        self._cs.before_change(self._before_select)

    def spi_slave(self, name: str) -> SpiSlave:
        """Return what answers on the bus; raises KeyError as `Part.spi_slave` does."""
        return {"spi": _Slave(self)}[name]

    def next_deadline_ns(self) -> int | None:
        """When chip select has to be looked at again, while a command is open."""
        return self._looked_ns + LOOK_NS if self._open else None

    def advance(self, now_ns: int) -> None:
        """Look whether chip select has risen."""
        self.look(now_ns)

    # --- the bus

    def _before_select(self) -> None:
        self.broken()

    def selected(self, now_ns: int) -> bool:
        """Say whether chip select is low."""
        self.look(now_ns)
        return not self._cs.level_at(now_ns)

    def look(self, now_ns: int) -> None:
        """Carry out a command that has ended since the last look."""
        rises = [ns for ns, level in self._cs.changes(self._looked_ns, now_ns) if level]
        self._looked_ns = max(self._looked_ns, now_ns)
        self.releases += len(rises)
        if self._open and (rises or self._cs.level_at(now_ns)):
            command, self._open = bytes(self._open), bytearray()
            self._end(command, rises[0] if rises else now_ns)

    def exchange(self, byte: int, now_ns: int) -> int:
        """Take a byte, and return the one that goes out meanwhile."""
        number = len(self._open)
        if not number:
            self._answer = self._begin(byte, now_ns)
            self._open.append(byte)
            return 0xFF
        answer = self.answer()
        self._open.append(byte)
        return answer

    def answer(self) -> int:
        """Return the byte that goes out while the next one comes in."""
        return self._answer(len(self._open)) if self._open else 0xFF

    def promise(self, most: int) -> bytes | None:
        """Return what goes out next where that does not depend on what comes in, nor on time."""
        if self._cs.level_at(self._looked_ns):
            return b""
        number, first = len(self._open), _READS.get(self._open[0], 0) if self._open else 0
        if number and self._answer is _nothing:
            return b"\xff" * most
        if not first or number < first or self._answer is _nothing:
            return None
        begin = (self._address(bytes(self._open[:4])) + number - first) % len(self.array.data)
        return bytes(self.array.data[begin : begin + most])

    def take(self, data: bytes, now_ns: int) -> None:
        """Take bytes that have come in meanwhile."""
        self.look(now_ns)
        self._open += data

    # --- commands

    def _begin(self, command: int, now_ns: int) -> Callable[[int], int]:
        """Return what is answered to byte 1, 2 and so on of a command."""
        busy = now_ns < self._busy_until_ns
        if command in _STATUS and not self._asleep:
            return lambda _number: self._status_now(_STATUS[command])
        if busy or (self._asleep and command != 0xAB):
            return _nothing
        return {
            **dict.fromkeys(_READS, lambda number: self._read(number, first=_READS[command])),
            0x9F: lambda number: (MAKER, KIND, DEVICES[self._settings.megabits] + 1)[(number - 1) % 3],
            0x90: lambda number: 0xFF if number < 4 else self._maker_and_device(number - 4),
            0xAB: lambda number: 0xFF if number < 4 else DEVICES[self._settings.megabits],
            0x4B: lambda number: 0xFF if number < 5 else self._unique[(number - 5) % 8],
        }.get(command, _nothing)

    def _end(self, command: bytes, now_ns: int) -> None:
        code = command[0]
        if code in _STATUS or self._refused(code, now_ns):
            return
        armed, self._reset_armed = self._reset_armed, code == 0x66
        volatile, self._volatile = self._volatile, code == 0x50
        if code in (0x06, 0x04):
            self._status[0] = self._status[0] & ~WEL | (WEL if code == 0x06 else 0)
        elif code in (0xB9, 0xAB):
            self._asleep = code == 0xB9
        elif code == 0x99 and armed:
            self._status[:] = bytes(3)
            self._busy_until_ns = now_ns + 30 * _US
        elif code in _WRITE_STATUS:
            self._write_status(_WRITE_STATUS[code], command[1:], now_ns, volatile=volatile)
        elif code in _CHANGES:
            self._end_change(code, command, now_ns)
        elif code in _ABSENT:
            self._ignore(code, f"{_ABSENT[code]} is not modelled", now_ns)

    def _end_change(self, code: int, command: bytes, now_ns: int) -> None:
        size = len(command)
        if code == 0x02 and size > 1 + _ADDRESS_BYTES:
            self._change("program", code, self._address(command), command[4:], now_ns)
        elif size == (1 if code in _WHOLE else 1 + _ADDRESS_BYTES) and code != 0x02:
            self._change("erase", code, 0 if code in _WHOLE else self._address(command), b"", now_ns)
        else:
            self._ignore(code, f"chip select rose after {size} bytes", now_ns)

    def _refused(self, code: int, now_ns: int) -> bool:
        if now_ns < self._busy_until_ns:
            self._ignore(code, "the flash is busy", now_ns)
            return True
        if self._asleep and code != 0xAB:
            self._ignore(code, "the flash is powered down", now_ns)
            return True
        return False

    def _change(self, what: str, code: int, address: int, data: bytes, now_ns: int) -> None:
        whole = len(self.array.data)
        size = len(data) if what == "program" else _ERASES.get(code, whole)
        begin = address if what == "program" else address - address % size
        if not self._status[0] & WEL:
            self._ignore(code, "WEL is 0: no 06 came before it", now_ns)
            return
        self._status[0] &= ~WEL
        if self.array.is_protected(begin, size, self._status[0]):
            self._ignore(code, "the place is protected by BP2 to BP0", now_ns)
            return
        if what == "program":
            self.array.program(address, data)
        else:
            self.array.erase(address, size)
        self._busy_until_ns = now_ns + self._takes_ns(code)
        self._tell(FlashChanged(what=what, address=begin, size=size, at_ns=now_ns))

    def _takes_ns(self, code: int) -> int:
        settings = self._settings
        of_code = {
            0x02: settings.page_program_us * _US,
            0x20: settings.sector_erase_ms * _MS,
            0x52: settings.block_erase_ms * _MS * 0.8,
            0xD8: settings.block_erase_ms * _MS,
        }
        return round(of_code.get(code, settings.chip_erase_s * 1000 * _MS))

    def _write_status(self, first: int, values: bytes, now_ns: int, *, volatile: bool) -> None:
        if not (self._status[0] & WEL or volatile):
            self._ignore(0x01, "WEL is 0: no 06 came before it", now_ns)
            return
        for register, value in enumerate(values[: 2 if first == 0 else 1], first):
            self._status[register] = self._status[register] & ~_WRITABLE[register] | value & _WRITABLE[register]
        self._status[0] &= ~WEL
        if not volatile:
            self._busy_until_ns = now_ns + round(self._settings.write_status_ms * _MS)
        self._tell(FlashChanged(what="status", address=first, size=len(values), at_ns=now_ns))

    # --- answers

    def _status_now(self, register: int) -> int:
        busy = BUSY if not register and self._looked_ns < self._busy_until_ns else 0
        return self._status[register] | busy

    def _address(self, command: bytes) -> int:
        return int.from_bytes(command[1:4], "big") % len(self.array.data)

    def _read(self, number: int, first: int) -> int:
        if number < first:
            return 0xFF
        return self.array.data[(self._address(bytes(self._open[:4])) + number - first) % len(self.array.data)]

    def _maker_and_device(self, number: int) -> int:
        return (MAKER, DEVICES[self._settings.megabits])[(number + self._open[3]) & 1]

    def _ignore(self, code: int, why: str, now_ns: int) -> None:
        self._tell(FlashIgnored(command=code, why=why, at_ns=now_ns))


class _Slave:
    """What answers on the bus, in modes 0 and 3 (section 6.1.1)."""

    modes = frozenset({0, 3})

    def __init__(self, flash: W25q) -> None:
        self._flash = flash
        self.selected, self.exchange, self.answer = flash.selected, flash.exchange, flash.answer
        self.promise, self.take = flash.promise, flash.take

    @property
    def broken(self) -> Callable[[], None]:
        return self._flash.broken

    @broken.setter
    def broken(self, settle: Callable[[], None]) -> None:
        self._flash.broken = settle

    @property
    def releases(self) -> int:
        return self._flash.releases


def _nothing(_number: int) -> int:
    return 0xFF
