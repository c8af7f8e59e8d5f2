"""FLASH of the STM32F76x: wait states; programming and erasing at their real pace; option bytes (RM0410 section 3).

The machine and this share `Flash.memory` and `Flash.options`; the CPU reads them without asking. Stores go to
`Flash.program`. While the flash is busy, silicon stalls whoever fetches or reads from it. Here the machine is asked, by
`Flash.stall_until`, to let no instruction in flash begin before the operation ends; code in RAM goes on and may poll
BSY. Reads of data by code in RAM are not stalled, and see the old contents until the operation ends.

Choices: an operation that a reset cuts short has not happened; a store while the flash is busy, and a write of CR or
OPTCR, are carried out when it is not; with two banks the other one is stalled as well, although silicon would read it
on; option bytes hold as soon as they are programmed, but for what is asked at a reset only; a store through the ITCM
interface, to system memory and to the option bytes themselves is a bus error. The ART accelerator and the prefetch
buffer are part of the timing model. Programming by 64 bits needs VPP, which the boards do not have: PGPERR.
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from functools import partial
from types import MappingProxyType
from typing import ClassVar

from targets.mcu.errors import BusFault
from targets.mcu.fidelity import Fidelity
from targets.mcu.registers import Register
from targets.mcu.services import Services
from targets.mcu.stm32.flash import CR, FLASH_BASE, KEYR, OPTKEYR, SR, BasicFlash
from targets.mcu.stm32f7.clock_limits import needed_wait_states
from targets.mcu.stm32f7.clocks import ClockTree
from targets.mcu.stm32f7.options import (
    FACTORY_OPTCR,
    FACTORY_OPTCR1,
    OPTION_BITS,
    OPTIONS_BASE,
    Options,
    decode,
    encode,
)
from targets.mcu.stm32f7.sectors import Sector, sectors_of

__all__ = ["ITCM_BASE", "Flash"]

ITCM_BASE = 0x0020_0000

ACR, OPTCR, OPTCR1 = 0x00, 0x14, 0x18

LATENCY, PRFTEN, ARTEN, ARTRST = 0xF, 1 << 8, 1 << 9, 1 << 11
EOP, OPERR, WRPERR, PGAERR, PGPERR, ERSERR, BSY = 1 << 0, 1 << 1, 1 << 4, 1 << 5, 1 << 6, 1 << 7, 1 << 16
FLAGS = EOP | OPERR | WRPERR | PGAERR | PGPERR | ERSERR
PG, SER, MER1, SNB, PSIZE, MER2, STRT = 1 << 0, 1 << 1, 1 << 2, 0xF8, 3 << 8, 1 << 15, 1 << 16
EOPIE, ERRIE, LOCK = 1 << 24, 1 << 25, 1 << 31
OPTLOCK, OPTSTRT = 1 << 0, 1 << 1
KEYS = {KEYR: (0x4567_0123, 0xCDEF_89AB), OPTKEYR: (0x0819_2A3B, 0x4C5D_6E7F)}
ROW = 32  # bytes of a row of the flash: 256 bits

# DS11532, flash memory programming: 16 us typical for a word. The others are assumed, after the typical values that ST
# gives for its flash of that time when it is programmed by words.
PROGRAM_S = Fraction(16, 1_000_000)
ERASE_S = {
    16 << 10: Fraction(1, 4),
    32 << 10: Fraction(1, 4),
    64 << 10: Fraction(11, 20),
    128 << 10: Fraction(1),
    256 << 10: Fraction(2),
}
MASS_ERASE_S_PER_MB = Fraction(8)


class Flash(BasicFlash):
    """The flash interface with the memory behind it; see `BasicFlash`.

    Args:
        base: address of its first register.
        services: what the chip offers.
        tree: the clock tree, against which the wait states are checked.
        size: bytes of flash.

    Attributes:
        settings: what the option bytes say.
    """

    REGISTERS: ClassVar[tuple[Register, ...]] = (
        Register(
            "ACR",
            ACR,
            0,
            LATENCY | PRFTEN | ARTEN | ARTRST,
            fidelity=Fidelity.PARTLY,
            note="prefetch and ART are part of the timing model, on or off",
        ),
        Register("KEYR", KEYR, 0),
        Register("OPTKEYR", OPTKEYR, 0),
        Register("SR", SR, 0, FLAGS),
        Register("CR", CR, LOCK, PG | SER | MER1 | SNB | PSIZE | MER2 | STRT | EOPIE | ERRIE | LOCK),
        Register(
            "OPTCR",
            OPTCR,
            FACTORY_OPTCR,
            fidelity=Fidelity.PARTLY,
            note="read protection: nobody reads from outside; the supply never falls as far as BOR; watchdogs run on "
            "in Stop and Standby",
        ),
        Register("OPTCR1", OPTCR1, FACTORY_OPTCR1),
    )

    KEYS = MappingProxyType(KEYS)
    ONE_WRONG_KEY_KILLS_ALL = False
    LOCK = LOCK
    BASES = (FLASH_BASE, ITCM_BASE)
    OPTIONS_BASE = OPTIONS_BASE

    def __init__(self, base: int, services: Services, tree: ClockTree, *, size: int) -> None:
        self.settings = Options(optcr=FACTORY_OPTCR & OPTION_BITS, optcr1=FACTORY_OPTCR1)
        super().__init__(base, services, size=size, options=encode(self.settings))
        self._tree = tree

    # --- what the machine calls

    def program(self, address: int, size: int, value: int) -> None:
        """A store to flash: programs what was stored if the registers say so.

        Args:
            address: of the store.
            size: bytes stored.
            value: what was stored.

        Raises:
            BusFault: not into the flash through the AXI interface.
        """
        offset = address - FLASH_BASE
        if not 0 <= offset < len(self.memory):
            self.note("misuse", "CR.PG", f"a store to 0x{address:08X}: flash is programmed from 0x08000000 on")
            raise BusFault(address, "flash is programmed through the AXI interface only")
        self._when_free(partial(self._program, offset, size, value & (1 << 8 * size) - 1))

    # --- registers

    def write_ACR(self, value: int) -> None:
        """Wait states; ARTRST has an effect only while ARTEN is 0, and nothing to reset here."""
        changed = (value ^ self[ACR]) & LATENCY
        self[ACR] = value
        if changed:
            self.on_latency(value & LATENCY)
        self._check_access()

    def write_OPTKEYR(self, value: int) -> None:
        """Unlock OPTCR by two keys in order, as KEYR."""
        if self[OPTCR] & OPTLOCK and self._turn_key(OPTKEYR, value):
            self[OPTCR] &= ~OPTLOCK

    def write(self, offset: int, value: int) -> None:
        """As of every peripheral; the flags of SR keep their value where 0 is written."""
        if offset == SR:
            self._set_status(clear=value & FLAGS)
        else:
            super().write(offset, value)

    def write_CR(self, value: int) -> None:
        """Choose an operation and start it; not while locked."""
        if self[CR] & LOCK:
            if value != self[CR]:
                self.note("misuse", "CR.LOCK", "the flash is locked; the write is lost")
            return
        self._when_free(partial(self._take_control, value))

    def _take_control(self, value: int) -> None:
        self[CR] = value
        self._irq_follows()
        if value & STRT and not value & LOCK:
            self._start()

    def write_OPTCR(self, value: int) -> None:
        """The option bytes, which OPTSTRT programs; not while locked."""
        if self[OPTCR] & OPTLOCK:
            if value != self[OPTCR]:
                self.note("misuse", "OPTCR.OPTLOCK", "the option bytes are locked; the write is lost")
            return
        self._when_free(partial(self._take_options, value))

    def _take_options(self, value: int) -> None:
        self[OPTCR] = value
        if value & OPTSTRT and not value & OPTLOCK:
            self._program_options()

    def write_OPTCR1(self, value: int) -> None:
        """The boot addresses; OPTSTRT programs them, too."""
        if self[OPTCR] & OPTLOCK:
            self.note("misuse", "OPTCR.OPTLOCK", "the option bytes are locked; the write is lost")
            return
        self[OPTCR1] = value

    # --- operations

    def _program(self, offset: int, size: int, value: int) -> None:
        wanted = 1 << (self[CR] >> 8 & 3)
        if not self[CR] & PG or self[CR] & LOCK:
            self.note("misuse", "CR.PG", f"a store to 0x{FLASH_BASE + offset:08X} without programming enabled is lost")
            self._fail(ERSERR)
        elif size != wanted:
            self.note("misuse", "CR.PSIZE", f"a store of {8 * size} bits while PSIZE says {8 * wanted} is lost")
            self._fail(PGPERR)
        elif offset % ROW + size > ROW:
            self._fail(PGAERR)
        elif self._protected(offset, size):
            self._fail(WRPERR)
        else:
            old = int.from_bytes(self.memory[offset : offset + size], "little")
            data = (old & value).to_bytes(size, "little")
            if old & value != value:
                text = f"0x{FLASH_BASE + offset:08X} is not erased: only bits that are 1 can become 0"
                self.note("misuse", "CR.PG", text)
            self._begin(PROGRAM_S, partial(self._change, offset, data))

    def _sectors(self) -> tuple[Sector, ...]:
        return sectors_of(len(self.memory), dual_bank=self.settings.dual_bank)

    def _protected(self, offset: int, size: int) -> bool:
        return any(
            self.settings.protects(sector.index)
            for sector in self._sectors()
            if sector.offset < offset + size and offset < sector.offset + sector.size
        )

    def _start(self) -> None:
        control = self[CR]
        if control & SER and not control & (MER1 | MER2):
            number = control >> 3 & 0x1F
            sector = next((one for one in self._sectors() if one.number == number), None)
            if sector is not None:
                self._erase(sector.offset, sector.size, ERASE_S[sector.size])
                return
        elif control & (MER1 | MER2) and not control & SER:
            self._erase_banks(control)
            return
        self[CR] &= ~STRT
        self.note("misuse", "CR.STRT", f"nothing to start with CR = 0x{control:X}")
        self._fail(ERSERR)

    def _erase_banks(self, control: int) -> None:
        half = len(self.memory) // 2
        first = 0 if control & MER1 or not self.settings.dual_bank else half
        end = len(self.memory) if control & MER2 or not self.settings.dual_bank else half
        self._erase(first, end - first, MASS_ERASE_S_PER_MB * (end - first) / (1 << 20))

    def _erase(self, offset: int, size: int, seconds: Fraction) -> None:
        if self._protected(offset, size):
            self[CR] &= ~STRT
            self._fail(WRPERR)
        else:
            self._begin(seconds, partial(self._change, offset, b"\xff" * size))

    def _begin(self, seconds: Fraction, finish: Callable[[], None]) -> None:
        self._set_status(set_=BSY)
        time = self.time
        self._ends = time.at_time(time.seconds(time.now) + seconds, partial(self._end, finish))
        self.stall_until(self._ends.cycle)

    def _end(self, finish: Callable[[], None]) -> None:
        finish()
        self[CR] &= ~STRT
        # EOP is set only if its interrupt is enabled (RM0410 section 3.7.4).
        self._set_status(set_=EOP if self[CR] & EOPIE else 0, clear=BSY)

    def _change(self, offset: int, data: bytes) -> None:
        self.memory[offset : offset + len(data)] = data
        for base in (FLASH_BASE, ITCM_BASE):
            self.on_code_changed(base + offset, len(data))

    # --- option bytes

    def _program_options(self) -> None:
        wanted = Options(optcr=self[OPTCR] & OPTION_BITS, optcr1=self[OPTCR1])
        old = self.settings
        if old.read_level == 2:
            self[OPTCR] &= ~OPTSTRT
            self.note("misuse", "OPTCR.RDP", "read protection of level 2 is for good: the option bytes stay")
            return
        unprotects = wanted.read_level < old.read_level
        seconds = PROGRAM_S * 8 + (MASS_ERASE_S_PER_MB * len(self.memory) / (1 << 20) if unprotects else 0)
        self._begin(seconds, partial(self._finish_options, wanted, unprotects))

    def _finish_options(self, wanted: Options, unprotects: bool) -> None:
        if unprotects:  # taking the read protection off erases the flash (RM0410 section 3.5.1)
            self._change(0, b"\xff" * len(self.memory))
        self.options[:] = encode(wanted)
        self.settings = wanted
        self[OPTCR] &= ~OPTSTRT

    def _load_options(self) -> None:
        self.settings = decode(self.options)
        self[OPTCR] = self.settings.optcr | self[OPTCR] & (OPTLOCK | OPTSTRT)
        self[OPTCR1] = self.settings.optcr1

    # --- flags and checks

    def _fail(self, flag: int) -> None:
        """Set the flag of an error; OPERR only with its interrupt enabled (RM0410 section 3.7.4)."""
        self._set_status(set_=flag | OPERR if self[CR] & ERRIE else flag)

    def _irq_follows(self) -> None:
        status, control = self[SR], self[CR]
        done = status & EOP and control & EOPIE
        failed = status & OPERR and control & ERRIE
        self._irq.set(bool(done or failed))

    def _check_access(self) -> None:
        hclk = self._tree.rates.hclk
        needed = needed_wait_states(hclk)
        if self[ACR] & LATENCY < needed:
            mhz = f"{float(hclk / 1_000_000):g}"
            self.note("misuse", "ACR.LATENCY", f"{needed} wait states are needed at {mhz} MHz; silicon may misread")
