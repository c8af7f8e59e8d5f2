"""FLASH of the STM32H743 and H753: two banks, programmed by words of 256 bits; option bytes (RM0433 section 4).

The machine and this share `Flash.memory`; the CPU reads it without asking. Stores go to `Flash.program` and fill the
write buffer of their bank; when all 32 bytes of a flash word are there, or FW says so, they are programmed. While a
bank is busy, silicon stalls whoever fetches or reads from it. Here the machine is asked to let no instruction in flash
begin before the operation ends, if the program runs from that bank as it begins; a program in the other bank, or in
RAM, goes on. Reads of data are not stalled, and see the old contents until the operation ends.

Choices: an operation that a reset cuts short has not happened; stores and writes of CR and OPTCR while any bank is busy
are carried out when it is not; one operation at a time, whichever the bank; an error in a store empties the buffer;
both banks stay where they are, SWAP_BANK or not; option bytes hold when they are programmed, but for what is asked at a
reset only. There are no bit errors, so ECC finds none; protection against reading, and the CRC unit, are not modelled.
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from functools import partial
from types import MappingProxyType
from typing import ClassVar

from targets.mcu.fidelity import Fidelity
from targets.mcu.registers import Register
from targets.mcu.services import Services
from targets.mcu.stm32.flash import FLASH_BASE, BasicFlash
from targets.mcu.stm32h7 import options as opt
from targets.mcu.stm32h7.clock_limits import needed_wait_states
from targets.mcu.stm32h7.clocks import ClockTree
from targets.mcu.stm32h7.options import Options

__all__ = ["Flash"]

ACR, KEYR1, OPTKEYR, CR1, SR1, CCR1, OPTCR, OPTCCR = 0x00, 0x04, 0x08, 0x0C, 0x10, 0x14, 0x18, 0x24
BANK = 0x100  # from a register of bank 1 to that of bank 2
SHARED = (ACR, OPTKEYR, OPTCR, 0x1C, 0x20, OPTCCR, 0x40, 0x44)  # which are at both places

LATENCY, WRHIGHFREQ = 0xF, 3 << 4
LOCK, PG, SER, BER, PSIZE, FW, START, SNB = 1 << 0, 1 << 1, 1 << 2, 1 << 3, 3 << 4, 1 << 6, 1 << 7, 7 << 8
CRC_EN, ENABLES = 1 << 15, 0x0FEF_0000
BSY, WBNE, QW, EOP = 1 << 0, 1 << 1, 1 << 2, 1 << 16
WRPERR, PGSERR, STRBERR, INCERR = 1 << 17, 1 << 18, 1 << 19, 1 << 21
OPTLOCK, OPTSTART, MER, OPTCHANGEERRIE, SWAP_BANK = 1 << 0, 1 << 1, 1 << 4, 1 << 30, 1 << 31
OPT_BUSY = 1 << 0

KEYS = (0x4567_0123, 0xCDEF_89AB)
FLASH_WORD = 32  # bytes
SECTOR = 128 << 10
# DS12117, flash memory characteristics, typical, by PSIZE: 8, 16, 32 and 64 bits in parallel; from memory.
PROGRAM_S = tuple(Fraction(us, 1_000_000) for us in (290, 180, 130, 100))
SECTOR_ERASE_S = tuple(Fraction(ms, 1_000) for ms in (2_000, 1_800, 1_100, 1_000))
BANK_ERASE_S = tuple(Fraction(s) for s in (13, 8, 6, 5))
OPTIONS_S = Fraction(1, 100)  # assumed


def _of_bank(number: int) -> tuple[Register, ...]:
    base = BANK * (number - 1)
    partly = Fidelity.PARTLY
    return (
        Register(f"KEYR{number}", base + KEYR1, 0),
        Register(
            f"CR{number}",
            base + CR1,
            0x31,
            LOCK | PG | SER | BER | PSIZE | FW | START | SNB | CRC_EN | ENABLES,
            CRC_EN,
            fidelity=partly,
            note="the CRC unit computes nothing",
        ),
        Register(f"SR{number}", base + SR1, 0, 0),
        Register(f"CCR{number}", base + CCR1, 0, 0x0FEF_0000),
        *(
            Register(name, base + offset, 0, writable, fidelity=Fidelity.ABSENT, note="the CRC unit computes nothing")
            for name, offset, writable in (
                (f"CRCCR{number}", 0x50, 0x003B_07FF),
                (f"CRCSADD{number}R", 0x54, 0xFFFFF),
                (f"CRCEADD{number}R", 0x58, 0xFFFFF),
                (f"CRCDATAR{number}", 0x5C, 0),
            )
        ),
        Register(f"ECC_FA{number}R", base + 0x60, 0, 0, note="there are no bit errors"),
    )


def _of_options() -> tuple[Register, ...]:
    names = {
        opt.OPTSR_CUR: ("OPTSR_CUR", "OPTSR_PRG", 0xF41E_FFDC),
        opt.PRAR_CUR1: ("PRAR_CUR1", "PRAR_PRG1", 0x8FFF_0FFF),
        opt.SCAR_CUR1: ("SCAR_CUR1", "SCAR_PRG1", 0x8FFF_0FFF),
        opt.WPSN_CUR1: ("WPSN_CUR1R", "WPSN_PRG1R", 0xFF),
        opt.BOOT_CURR: ("BOOT_CURR", "BOOT_PRGR", 0xFFFF_FFFF),
        opt.PRAR_CUR2: ("PRAR_CUR2", "PRAR_PRG2", 0x8FFF_0FFF),
        opt.SCAR_CUR2: ("SCAR_CUR2", "SCAR_PRG2", 0x8FFF_0FFF),
        opt.WPSN_CUR2: ("WPSN_CUR2R", "WPSN_PRG2R", 0xFF),
    }
    found = []
    for offset, (current, programmed, writable) in names.items():
        absent = current[:4] in ("PRAR", "SCAR")
        fidelity = Fidelity.ABSENT if absent else Fidelity.PARTLY if offset == opt.OPTSR_CUR else Fidelity.MODELLED
        note = "areas are not protected" if absent else "banks are not swapped, reading is not protected"
        value = opt.FACTORY[offset]
        found.append(Register(current, offset, value, 0, fidelity=fidelity, note=note))
        found.append(Register(programmed, offset + 4, value, writable, fidelity=fidelity, note=note))
    return tuple(found)


class Flash(BasicFlash):
    """The flash interface with the memory behind it; see `BasicFlash`.

    Args:
        base: address of its first register.
        services: what the chip offers.
        tree: the clock tree, against which the wait states are checked.
        size: bytes of flash, in two banks.
        scale: returns the voltage scale, 0 to 3.
        pc: returns where the program is.

    Attributes:
        settings: what the option bytes say.
    """

    REGISTERS: ClassVar[tuple[Register, ...]] = (
        Register("ACR", ACR, 0x37, LATENCY | WRHIGHFREQ, fidelity=Fidelity.PARTLY, note="WRHIGHFREQ is remembered"),
        Register("OPTKEYR", OPTKEYR, 0),
        Register(
            "OPTCR",
            OPTCR,
            OPTLOCK,
            OPTLOCK | OPTSTART | MER | OPTCHANGEERRIE | SWAP_BANK,
            SWAP_BANK,
            fidelity=Fidelity.PARTLY,
            note="banks are not swapped",
        ),
        Register("OPTCCR", OPTCCR, 0, 1 << 30),
        *_of_options(),
        *_of_bank(1),
        *_of_bank(2),
    )

    KEYS = MappingProxyType({KEYR1: KEYS, KEYR1 + BANK: KEYS, OPTKEYR: (0x0819_2A3B, 0x4C5D_6E7F)})
    ONE_WRONG_KEY_KILLS_ALL = False
    LOCK = LOCK
    BASES = (FLASH_BASE,)
    OPTIONS_BASE = 0

    def __init__(
        self,
        base: int,
        services: Services,
        tree: ClockTree,
        *,
        size: int,
        scale: Callable[[], int],
        pc: Callable[[], int],
    ) -> None:
        self._tree = tree
        self._pc = pc
        self._scale = scale
        self._stored = dict(opt.FACTORY)
        self._buffers: list[dict[int, int]] = [{}, {}]  # offset and byte, of the flash word begun in each bank
        super().__init__(base, services, size=size, options=b"")
        self._load_options()

    # --- what the machine calls

    def reset(self) -> None:
        """Lock, forget what was under way, and load the option bytes anew; the contents stay."""
        self._buffers = [{}, {}]
        super().reset()
        self.on_latency(self[ACR] & LATENCY)

    def program(self, address: int, size: int, value: int) -> None:
        """A store to flash: fills the write buffer if the registers say so.

        Args:
            address: of the store.
            size: bytes stored.
            value: what was stored.
        """
        data = (value & (1 << 8 * size) - 1).to_bytes(size, "little")
        self._when_free(partial(self._store, address - FLASH_BASE, data))

    # --- registers

    def read(self, offset: int) -> int:
        """Read the word at `offset`; some registers are at a second place, among those of bank 2."""
        return super().read(_home(offset))

    def write(self, offset: int, value: int) -> None:
        """Write the word at `offset`; see `read`."""
        super().write(_home(offset), value)

    def write_ACR(self, value: int) -> None:
        """Wait states."""
        changed = (value ^ self[ACR]) & LATENCY
        self[ACR] = value
        if changed:
            self.on_latency(value & LATENCY)
        self._check_access()

    def write_KEYR1(self, value: int) -> None:
        """Unlock CR1 by two keys in order; a wrong one is a bus error and locks it until the next reset."""
        self._unlock(0, value)

    def write_KEYR2(self, value: int) -> None:
        """Unlock CR2."""
        self._unlock(1, value)

    def _unlock(self, bank: int, value: int) -> None:
        control = CR1 + BANK * bank
        if self[control] & LOCK and self._turn_key(KEYR1 + BANK * bank, value):
            self[control] &= ~LOCK

    def write_OPTKEYR(self, value: int) -> None:
        """Unlock OPTCR and the registers PRG."""
        if self[OPTCR] & OPTLOCK and self._turn_key(OPTKEYR, value):
            self[OPTCR] &= ~OPTLOCK

    def write_CR1(self, value: int) -> None:
        """Choose an operation of bank 1 and start it; not while locked."""
        self._write_control(0, value)

    def write_CR2(self, value: int) -> None:
        """Choose an operation of bank 2 and start it; not while locked."""
        self._write_control(1, value)

    def _write_control(self, bank: int, value: int) -> None:
        control = CR1 + BANK * bank
        if self[control] & LOCK:
            if value != self[control]:
                self.note("misuse", f"CR{bank + 1}.LOCK", "the bank is locked; the write is lost")
            return
        self._when_free(partial(self._take_control, bank, value))

    def _take_control(self, bank: int, value: int) -> None:
        self[CR1 + BANK * bank] = value & ~FW
        self._irq_follows()
        if value & LOCK:
            return
        if value & FW and self._buffers[bank]:
            self._program_buffer(bank)
        elif value & START:
            self._start(bank, value)

    def write_CCR1(self, value: int) -> None:
        """Clear flags of bank 1 by writing 1."""
        self._set_flags(0, clear=value)

    def write_CCR2(self, value: int) -> None:
        """Clear flags of bank 2 by writing 1."""
        self._set_flags(1, clear=value)

    def write_OPTCCR(self, _value: int) -> None:
        """Nothing ever goes wrong with a change of option bytes."""

    def write_OPTCR(self, value: int) -> None:
        """MER erases both banks, OPTSTART programs the option bytes; not while locked."""
        if self[OPTCR] & OPTLOCK:
            if value != self[OPTCR]:
                self.note("misuse", "OPTCR.OPTLOCK", "the option bytes are locked; the write is lost")
            return
        self._when_free(partial(self._take_option_control, value))

    def _take_option_control(self, value: int) -> None:
        self[OPTCR] = value & ~(OPTSTART | MER)
        if value & OPTLOCK:
            return
        if value & MER:
            self._erase(0, 0, len(self.memory), BANK_ERASE_S[self._parallel(0)] * 2)
        elif value & OPTSTART:
            self[opt.OPTSR_CUR] |= OPT_BUSY
            self._begin(0, OPTIONS_S, self._take_options)

    # --- storing

    def _bank_of(self, offset: int) -> int:
        return int(offset >= len(self.memory) // 2)

    def _parallel(self, bank: int) -> int:
        return self[CR1 + BANK * bank] >> 4 & 3

    def _store(self, offset: int, data: bytes) -> None:
        if not 0 <= offset < len(self.memory):
            self.note("misuse", "CR1.PG", f"a store to 0x{FLASH_BASE + offset:08X} is lost: only flash is programmed")
            return
        bank = self._bank_of(offset)
        buffer, control = self._buffers[bank], self[CR1 + BANK * bank]
        if not control & PG or control & LOCK:
            text = f"a store to 0x{FLASH_BASE + offset:08X} without programming enabled is lost"
            self.note("misuse", f"CR{bank + 1}.PG", text)
            self._fail(bank, PGSERR)
        elif buffer and next(iter(buffer)) // FLASH_WORD != offset // FLASH_WORD:
            self.note("misuse", f"CR{bank + 1}.PG", "a store to another flash word before the first was full")
            self._fail(bank, INCERR)
        elif any(offset + index in buffer for index in range(len(data))):
            self.note("misuse", f"CR{bank + 1}.PG", "a byte of a flash word was stored twice")
            self._fail(bank, STRBERR)
        else:
            buffer.update(enumerate(data, offset))
            if len(buffer) < FLASH_WORD:
                self._set_flags(bank, set_=WBNE)
            else:
                self._program_buffer(bank)

    def _program_buffer(self, bank: int) -> None:
        buffer = self._buffers[bank]
        start = next(iter(buffer)) // FLASH_WORD * FLASH_WORD
        if self._protected(start, FLASH_WORD):
            self._fail(bank, WRPERR)
            return
        old = self.memory[start : start + FLASH_WORD]
        wanted = bytes(buffer.get(start + index, 0xFF) for index in range(FLASH_WORD))
        buffer.clear()
        if old != b"\xff" * FLASH_WORD:
            text = f"the flash word at 0x{FLASH_BASE + start:08X} is not erased: silicon stores a wrong ECC with it"
            self.note("misuse", f"CR{bank + 1}.PG", text)
        data = bytes(one & other for one, other in zip(old, wanted, strict=True))
        self._set_flags(bank, clear=WBNE)
        self._begin(bank, PROGRAM_S[self._parallel(bank)], partial(self._change, start, data))

    # --- erasing

    def _start(self, bank: int, control: int) -> None:
        half = len(self.memory) // 2
        if control & BER:
            self._erase(bank, bank * half, half, BANK_ERASE_S[self._parallel(bank)])
        elif control & SER:
            offset = bank * half + (control >> 8 & 7) * SECTOR
            self._erase(bank, offset, SECTOR, SECTOR_ERASE_S[self._parallel(bank)])
        else:
            self[CR1 + BANK * bank] &= ~START
            self.note("misuse", f"CR{bank + 1}.START", f"nothing to start with CR{bank + 1} = 0x{control:X}")
            self._fail(bank, PGSERR)

    def _erase(self, bank: int, offset: int, size: int, seconds: Fraction) -> None:
        if self._protected(offset, size):
            self[CR1 + BANK * bank] &= ~START
            self._fail(bank, WRPERR)
        else:
            self._begin(bank, seconds, partial(self._change, offset, b"\xff" * size))

    def _protected(self, offset: int, size: int) -> bool:
        half = len(self.memory) // 2
        return any(
            self.settings.protects(at // half, at % half // SECTOR)
            for at in range(offset // SECTOR * SECTOR, offset + size, SECTOR)
        )

    # --- operations

    def _begin(self, bank: int, seconds: Fraction, finish: Callable[[], None]) -> None:
        self._set_flags(bank, set_=BSY | QW)
        time = self.time
        self._ends = time.at_time(time.seconds(time.now) + seconds, partial(self._end, bank, finish))
        if self._bank_of(self._pc() - FLASH_BASE) == bank:
            self.stall_until(self._ends.cycle)

    def _end(self, bank: int, finish: Callable[[], None]) -> None:
        finish()
        self[CR1 + BANK * bank] &= ~START
        self._set_flags(bank, set_=EOP, clear=BSY | QW)

    def _change(self, offset: int, data: bytes) -> None:
        self.memory[offset : offset + len(data)] = data
        self.on_code_changed(FLASH_BASE + offset, len(data))

    # --- option bytes

    def _take_options(self) -> None:
        self._stored = {offset: self[opt.PROGRAMMED[offset]] for offset in opt.CURRENT}
        if self._stored[opt.OPTSR_CUR] & SWAP_BANK:
            self.note("unmodelled", "OPTSR_PRG.SWAP_BANK_OPT", "the banks are not swapped")
        self._load_options()

    def _load_options(self) -> None:
        for offset, value in self._stored.items():
            self[offset] = value
            self[opt.PROGRAMMED[offset]] = value
        self.settings = Options(
            status=self[opt.OPTSR_CUR],
            boot=self[opt.BOOT_CURR],
            unprotected=(self[opt.WPSN_CUR1], self[opt.WPSN_CUR2]),
        )

    # --- flags and checks

    def _fail(self, bank: int, flag: int) -> None:
        self._buffers[bank].clear()
        self._set_flags(bank, set_=flag, clear=WBNE)

    def _set_flags(self, bank: int, *, set_: int = 0, clear: int = 0) -> None:
        status = SR1 + BANK * bank
        self[status] = (self[status] & ~clear) | set_
        self._irq_follows()

    def _irq_follows(self) -> None:
        self._irq.set(any(self[SR1 + at] & self[CR1 + at] & ENABLES for at in (0, BANK)))

    def _check_access(self) -> None:
        bus_hz = self._tree.rates.bus_hz
        needed = needed_wait_states(bus_hz, self._scale())
        if self[ACR] & LATENCY < needed:
            mhz = f"{float(bus_hz / 1_000_000):g}"
            self.note("misuse", "ACR.LATENCY", f"{needed} wait states are needed at {mhz} MHz; silicon may misread")


def _home(offset: int) -> int:
    """Return the offset of a register of which there is one, by either of its places."""
    return offset - BANK if offset - BANK in SHARED else offset
