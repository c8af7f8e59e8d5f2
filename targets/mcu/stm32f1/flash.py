"""FLASH: wait states; programming and erasing of flash and option bytes at their real pace (PM0075).

The machine and this share `Flash.memory` and `Flash.options`; the CPU reads them without asking. Stores go to
`Flash.program`, which raises `BusFault` where silicon answers with a bus error.

While the flash is busy, silicon stalls whoever fetches or reads from it. Here the machine is asked, by
`Flash.stall_until`, to let no instruction in flash begin before the operation ends; code in RAM goes on and may poll
BSY. Reads of data by code in RAM are not stalled, and see the old contents until the operation ends.

Choices where the manual is silent: an operation that a reset cuts short has not happened; a store while the flash is
busy is carried out when it is not; a store with neither PG nor OPTPG set is a bus error.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from fractions import Fraction
from functools import partial
from types import MappingProxyType
from typing import ClassVar

from targets.mcu.errors import BusFault
from targets.mcu.fidelity import Fidelity
from targets.mcu.registers import Register
from targets.mcu.services import Services
from targets.mcu.stm32.flash import CR, FLASH_BASE, KEYR, OPTKEYR, SR, BasicFlash
from targets.mcu.stm32f1.clock_limits import needed_wait_states
from targets.mcu.stm32f1.clocks import ClockTree
from targets.mcu.stm32f1.densities import MEDIUM
from targets.mcu.stm32f1.options import FACTORY, OPTIONS_BASE, OPTIONS_SIZE, Options, decode

__all__ = ["Flash"]

PROTECTED = 0x1000  # bytes for each bit of WRPR, however long a page is (PM0075 section 2.4.2); the last has the rest

ACR, AR, OBR, WRPR = 0x00, 0x14, 0x1C, 0x20

LATENCY, HLFCYA, PRFTBE, PRFTBS = 0x7, 1 << 3, 1 << 4, 1 << 5
BSY, PGERR, WRPRTERR, EOP = 1 << 0, 1 << 2, 1 << 4, 1 << 5
PG, PER, MER, OPTPG, OPTER, STRT, LOCK, OPTWRE = 1 << 0, 1 << 1, 1 << 2, 1 << 4, 1 << 5, 1 << 6, 1 << 7, 1 << 9
ERRIE, EOPIE = 1 << 10, 1 << 12
KEYS = (0x4567_0123, 0xCDEF_89AB)

# DS5319, flash memory characteristics: programming 16 bits typically takes 52.5 us, erasing a page or all 20 to 40 ms
# with no typical value given; the lower limit is taken.
PROGRAM_S = Fraction(525, 10_000_000)
ERASE_S = Fraction(20, 1000)
HALF_CYCLE_HZ = 8_000_000  # PM0075 section 1.2: half-cycle access up to 8 MHz


class Flash(BasicFlash):
    """The flash interface with the memory behind it; see `BasicFlash`.

    Args:
        base: address of its first register.
        services: what the chip offers.
        tree: the clock tree, against which the wait states are checked.
        size: bytes of flash.
        page: bytes of a page.
        hsi_on: says whether the HSI runs, which programming needs.
        waits: it has wait states and a prefetch buffer. The STM32F100 at 24 MHz needs neither: of its ACR there is
            HLFCYA alone, 0 after a reset (PM0063, FLASH_ACR; from memory).

    Attributes:
        settings: what the option bytes said at the last reset.
    """

    REGISTERS: ClassVar[tuple[Register, ...]] = (
        Register("ACR", ACR, 0x30, LATENCY | HLFCYA | PRFTBE),
        Register("KEYR", KEYR, 0),
        Register("OPTKEYR", OPTKEYR, 0),
        Register("SR", SR, 0, PGERR | WRPRTERR | EOP),
        Register("CR", CR, LOCK, PG | PER | MER | OPTPG | OPTER | STRT | LOCK | OPTWRE | ERRIE | EOPIE),
        Register("AR", AR, 0),
        Register(
            "OBR", OBR, 0x03FF_FFFC, 0, fidelity=Fidelity.PARTLY, note="read protection: nobody reads from outside"
        ),
        Register("WRPR", WRPR, 0xFFFF_FFFF, 0),
    )

    KEYS = MappingProxyType({KEYR: KEYS, OPTKEYR: KEYS})
    ONE_WRONG_KEY_KILLS_ALL = True
    LOCK = LOCK
    BASES = (FLASH_BASE,)
    OPTIONS_BASE = OPTIONS_BASE

    def __init__(
        self,
        base: int,
        services: Services,
        tree: ClockTree,
        *,
        size: int,
        page: int = MEDIUM.page_bytes,
        hsi_on: Callable[[], bool] = lambda: True,
        waits: bool = True,
    ) -> None:
        self._waits = waits
        super().__init__(base, services, size=size, options=FACTORY)
        self.settings: Options = decode(self.options)
        self._tree = tree
        self._page = page
        self._hsi_on = hsi_on

    def registers_of(self) -> Iterable[Register]:
        """Return the registers as this device has them."""
        for register in self.REGISTERS:
            yield register if self._waits or register.offset != ACR else replace(register, reset=0, writable=HLFCYA)

    # --- what the machine calls

    def program(self, address: int, size: int, value: int) -> None:
        """A store to flash or option bytes: programs a half-word if the registers say so.

        Args:
            address: in flash, its alias at 0, or the option bytes.
            size: bytes stored.
            value: what was stored.

        Raises:
            BusFault: not a half-word, or programming is not enabled (PM0075 section 2.3).
        """
        address += FLASH_BASE if address < len(self.memory) else 0
        in_options = OPTIONS_BASE <= address < OPTIONS_BASE + OPTIONS_SIZE
        needed = OPTPG | OPTWRE if in_options else PG
        if self[CR] & needed != needed:
            self.note("misuse", "CR.PG", f"a store to 0x{address:08X} without programming enabled is a bus error")
            what, bits = ("option bytes take", "OPTPG and OPTWRE") if in_options else ("the flash takes", "PG")
            raise BusFault(address, f"{what} stores only with {bits} of FLASH_CR set")
        if size != 2 or address & 1:
            self.note("misuse", "CR.PG", "flash is programmed by half-words; any other store is a bus error")
            raise BusFault(address, "the flash takes half-words only")
        begin = self._program_option if in_options else self._program_flash
        self._when_free(partial(begin, address, value & 0xFFFF))

    # --- registers

    def write_ACR(self, value: int) -> None:
        """Wait states and prefetch; PRFTBS follows PRFTBE."""
        changed = (value ^ self[ACR]) & LATENCY
        self[ACR] = value | PRFTBS if value & PRFTBE else value & ~PRFTBS
        if changed:
            self.on_latency(value & LATENCY)
        self._check_access()

    def write_OPTKEYR(self, value: int) -> None:
        """Set OPTWRE by two keys in order, as KEYR."""
        if self[CR] & LOCK:
            self.note("misuse", "OPTKEYR", "FLASH_CR is locked; the option bytes are unlocked after it")
        elif not self[CR] & OPTWRE and self._turn_key(OPTKEYR, value):
            self[CR] |= OPTWRE

    def write_SR(self, value: int) -> None:
        """EOP, WRPRTERR and PGERR are cleared by writing 1."""
        self._set_status(clear=value & (EOP | WRPRTERR | PGERR))

    def write(self, offset: int, value: int) -> None:
        """As of every peripheral; the flags of SR keep their value where 0 is written."""
        if offset == SR:
            self.write_SR(value)
        else:
            super().write(offset, value)

    def write_CR(self, value: int) -> None:
        """Choose an operation and start it; not while locked or busy."""
        old = self[CR]
        if old & LOCK or self[SR] & BSY:
            if value != old:
                why = "locked" if old & LOCK else "busy"
                self.note("misuse", f"CR.{'LOCK' if old & LOCK else 'STRT'}", f"the flash is {why}; the write is lost")
            return
        if not old & OPTWRE:
            value &= ~OPTWRE  # set by the keys only
        self[CR] = value
        self._irq_follows()
        if value & LOCK:
            self[CR] &= ~OPTWRE
        elif value & STRT:
            self._start()

    def read_AR(self) -> int:
        """Write-only."""
        return 0

    def write_AR(self, value: int) -> None:
        """The page to erase; blocked while busy."""
        if not self[SR] & BSY:
            self[AR] = value

    # --- operations

    def _program_flash(self, address: int, value: int) -> None:
        offset = address - FLASH_BASE
        if self._is_protected(offset):
            self._set_status(set_=WRPRTERR)
        elif value and self.memory[offset : offset + 2] != b"\xff\xff":
            self._set_status(set_=PGERR)
        else:
            self._begin(PROGRAM_S, partial(self._change, FLASH_BASE, self.memory, offset, value.to_bytes(2, "little")))

    def _program_option(self, address: int, value: int) -> None:
        offset = address - OPTIONS_BASE
        if self.options[offset : offset + 2] != b"\xff\xff":
            self._set_status(set_=PGERR)
            return
        low = value & 0xFF  # the complement is computed by hardware (PM0075 section 2.4)
        pair = bytes((low, low ^ 0xFF))
        unprotects = offset == 0 and pair == FACTORY[:2] and self.settings.read_protected
        self._begin(ERASE_S if unprotects else PROGRAM_S, partial(self._finish_option, offset, pair, unprotects))

    def _finish_option(self, offset: int, pair: bytes, unprotects: bool) -> None:
        if unprotects:  # taking the read protection off erases the flash (PM0075 section 2.4.2)
            self._change(FLASH_BASE, self.memory, 0, b"\xff" * len(self.memory))
        self._change(OPTIONS_BASE, self.options, offset, pair)

    def _start(self) -> None:
        wanted = self[CR] & (PER | MER | OPTER)
        if wanted == OPTER and self[CR] & OPTWRE:
            self._begin(ERASE_S, partial(self._change, OPTIONS_BASE, self.options, 0, b"\xff" * OPTIONS_SIZE))
        elif wanted == MER:
            self._erase(0, len(self.memory))
        elif wanted == PER and 0 <= self[AR] - FLASH_BASE < len(self.memory):
            self._erase((self[AR] - FLASH_BASE) & -self._page, self._page)
        else:
            self[CR] &= ~STRT
            self.note("misuse", "CR.STRT", f"nothing to start with CR = 0x{self[CR]:X}, AR = 0x{self[AR]:08X}")

    def _erase(self, offset: int, size: int) -> None:
        if any(self._is_protected(page) for page in range(offset, offset + size, self._page)):
            self[CR] &= ~STRT
            self._set_status(set_=WRPRTERR)
        else:
            self._begin(ERASE_S, partial(self._change, FLASH_BASE, self.memory, offset, b"\xff" * size))

    def _is_protected(self, offset: int) -> bool:
        group = offset // PROTECTED
        return not self.settings.wrpr >> min(group, 31) & 1 or (self.settings.read_protected and group == 0)

    def _begin(self, seconds: Fraction, finish: Callable[[], None]) -> None:
        if not self._hsi_on():
            self.note("misuse", "CR.STRT", "the HSI is off; programming and erasing need it (RM0008 section 3.3.3)")
        self._set_status(set_=BSY)
        time = self.time
        self._ends = time.at_time(time.seconds(time.now) + seconds, partial(self._end, finish))
        self.stall_until(self._ends.cycle)

    def _end(self, finish: Callable[[], None]) -> None:
        finish()
        self[CR] &= ~STRT
        self._set_status(set_=EOP, clear=BSY)

    def _change(self, base: int, memory: bytearray, offset: int, data: bytes) -> None:
        memory[offset : offset + len(data)] = data
        self.on_code_changed(base + offset, len(data))

    # --- flags and checks

    def _irq_follows(self) -> None:
        status, control = self[SR], self[CR]
        done = status & EOP and control & EOPIE
        failed = status & (PGERR | WRPRTERR) and control & ERRIE
        self._irq.set(bool(done or failed))

    def _load_options(self) -> None:
        self.settings = decode(self.options)
        self[OBR] = self.settings.obr
        self[WRPR] = self.settings.wrpr

    def _check_access(self) -> None:
        rates = self._tree.rates
        needed = needed_wait_states(rates.sysclk)
        if self[ACR] & LATENCY < needed:
            mhz = f"{float(rates.sysclk / 1_000_000):g}"
            self.note("misuse", "ACR.LATENCY", f"{needed} wait states are needed at {mhz} MHz; silicon may misread")
        if self[ACR] & HLFCYA and rates.hclk > HALF_CYCLE_HZ:
            self.note("misuse", "ACR.HLFCYA", "half-cycle access works up to 8 MHz only")
