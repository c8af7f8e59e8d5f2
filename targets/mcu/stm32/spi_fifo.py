"""SPI interfaces with FIFOs of 32 bits (RM0410 section 35, on the STM32F7; F0, F3, G0, G4, L4 and WB have the like).

What they share with those of the STM32F1, and most choices: `spi_base`. DS gives 4 to 16 bits, a word takes one byte or
two of a FIFO, and an access of 16 bits to DR moves two words where they are not wider than a byte (section 35.5.9). An
access of 32 bits is one of 16.

Choices where the manual is silent:

* A write that finds TXE clear is lost, which is noted: the FIFO is considered as full then.
* FTLVL and FRLVL are the bytes in a FIFO, 3 standing for 3 and 4.
* A read finds zeros in place of bytes that are not there.
* What waits in a FIFO stays there while SPE is 0; a reset of the interface empties both.
* A slave that has nothing to send sends once more what it sent last, at first 0.
* The pulse of NSSP is high for one clock after each word, the last one too, whether NSS is put out or not.
* In TI mode (section 35.5.13) NSS is high for the clock before each word, and low otherwise; the CRC goes as a word.
* With CRCEN the receive FIFO holds two bytes, "a single 16-bit buffer" (section 35.5.14). A CRC of 16 bits after words
  of 8 is two words, the higher one first; one of 8 bits after words of 16 is the lower half of a word.
* The CRC follows by itself what DMA has written last; in a receive-only mode, the word that is under way when DMA reads
  the last one is the CRC.

Not modelled: I2S; a slave that is clocked by the edges at its pins, which is noted.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import ClassVar

from targets.mcu.fidelity import Fidelity
from targets.mcu.registers import Register
from targets.mcu.services import Services
from targets.mcu.stm32.spi_base import (
    CPHA,
    CR1,
    CR2,
    CRCEN,
    CRCERR,
    CRCNEXT,
    CRCPR,
    DR,
    FRE,
    I2SCFGR,
    I2SMOD,
    I2SPR,
    MODF,
    MSTR,
    NO_CLOCK,
    NO_I2S,
    OVR,
    RXCRCR,
    RXDMAEN,
    RXNE,
    SPE,
    SR,
    TXCRCR,
    TXDMAEN,
    TXE,
    BasicSpi,
)
from targets.mcu.stm32.spi_crc import crc_of
from targets.mcu.timebase import Event

__all__ = ["FifoSpi"]

CRCL = 1 << 11
NSSP, FRF, FRXTH, LDMA_RX, LDMA_TX = (1 << bit for bit in (3, 4, 12, 13, 14))
DS = 0xF << 8
FIFO_BYTES = 4
_REPEAT = {1: 0x0101_0101, 2: 0x0001_0001}

_NO_I2S = "SPI4 to SPI6 have no I2S"


class FifoSpi(BasicSpi):
    """One of them; see `BasicSpi`. It tells accesses of 8 and 16 bits to DR apart (`targets.mcu.bus.TakesParts`).

    Args:
        name: ``SPI1``.
        base: address of CR1.
        services: as there.
        bus: whose clock it is.
        irq: its interrupt.
        has_i2s: whether there are I2S registers; I2S is not modelled.
        tx_left: returns how many accesses DMA has still to make to send; while it makes the last one, 1.
        rx_left: the same of what it receives.
    """

    LENGTH_BIT = "CRCL"
    REGISTERS: ClassVar[tuple[Register, ...]] = (
        Register("CR1", CR1, 0, 0xFFFF, fidelity=Fidelity.PARTLY, note=NO_CLOCK),
        Register("CR2", CR2, 0x0700, 0x7FFF),
        Register("SR", SR, TXE, CRCERR, fidelity=Fidelity.PARTLY, note="UDR and CHSIDE of I2S are never set"),
        Register("DR", DR, 0, 0xFFFF),
        Register("CRCPR", CRCPR, 0x07, 0xFFFF),
        Register("RXCRCR", RXCRCR, 0, 0),
        Register("TXCRCR", TXCRCR, 0, 0),
        Register("I2SCFGR", I2SCFGR, 0, 0x1FBF, I2SMOD, fidelity=Fidelity.PARTLY, note=NO_I2S),
        Register("I2SPR", I2SPR, 2, 0x03FF, fidelity=Fidelity.ABSENT, note=NO_I2S),
    )

    def __init__(
        self,
        name: str,
        base: int,
        services: Services,
        *,
        bus: str,
        irq: int,
        has_i2s: bool = False,
        tx_left: Callable[[], int] = lambda: 0,
        rx_left: Callable[[], int] = lambda: 0,
    ) -> None:
        self._tx_left, self._rx_left = tx_left, rx_left
        self._looks: Event | None = None
        self._pause: Event | None = None
        super().__init__(name, base, services, bus=bus, irq=irq, has_i2s=has_i2s)

    def registers_of(self) -> Iterable[Register]:
        """Return the registers, those of I2S as this interface has them."""
        for register in self.REGISTERS:
            if register.offset in (I2SCFGR, I2SPR) and not self._has_i2s:
                yield replace(register, reset=0, writable=0, note=_NO_I2S)
            else:
                yield register

    def _clear(self) -> None:
        super()._clear()
        self._tx, self._rx = bytearray(), bytearray()
        self._sent_last = 0
        self._pulsed = False  # NSS has announced the next word of TI mode
        self._clear_crc()
        for event in (self._looks, self._pause):
            self.time.cancel(event)
        self._looks = self._pause = None

    def _clear_crc(self) -> None:
        self._crc_due = self._crc_over = False
        self._crc_left = self._crc_in = 0
        self._crc_out: list[int] = []

    def _new_crc(self) -> None:
        super()._new_crc()
        self._clear_crc()

    # --- registers

    def write_CR2(self, value: int) -> None:
        """Choose the word's length, the threshold, NSS, interrupts and requests."""
        if (value ^ self[CR2]) & (LDMA_RX | LDMA_TX) and self[CR1] & SPE:
            self.note("misuse", "CR2", "LDMA_RX and LDMA_TX may be changed only while SPE is 0")
        if (value ^ self[CR2]) & FRF and self[CR1] & SPE:
            self.note("misuse", "CR2.FRF", "it may be changed only while SPE is 0")
        if value >> 8 & 0xF < 3:
            value |= 0x0700  # lengths that are not used stand for 8 bits (section 35.9.2)
        if (value ^ self[CR2]) & DS and self._busy:
            self.note("misuse", "CR2.DS", "it was changed within a word")
        super().write_CR2(value)

    def read_SR(self) -> int:
        """Return the flags; FRE is cleared by it."""
        value = super().read_SR()
        if value & FRE:
            self[SR] &= ~FRE
            self._update()
        return value

    def read_DR(self) -> int:
        """Read as by 16 bits."""
        return self._read(2)

    def write_DR(self, value: int) -> None:
        """Write as by 16 bits."""
        self._write(value & 0xFFFF, 2)

    def read_part(self, offset: int, size: int) -> int:
        """Read 1 or 2 bytes: of DR that many leave the FIFO."""
        if offset & ~3 == DR:
            return self._read(size)
        return self.read(offset & ~3) >> 8 * (offset & 3) & (1 << 8 * size) - 1

    def write_part(self, offset: int, size: int, value: int) -> None:
        """Write 1 or 2 bytes: of DR that many go to the FIFO; other registers get them repeated, as on any APB."""
        if offset & ~3 == DR:
            self._write(value, size)
        else:
            self.write(offset & ~3, value * _REPEAT[size])

    def _read(self, size: int) -> int:
        if self[CR1] & CRCEN and self._receives_only and self._is_last(RXDMAEN, self._rx_left):
            self._begin_crc()
        value = int.from_bytes(self._rx[:size], "little")
        del self._rx[:size]
        self._read_dr = True
        self._update()
        if self[CR2] & LDMA_RX and self._rx:
            self.time.cancel(self._looks)
            self._looks = self.time.after(1, self._look)  # when DMA has counted this access
        return value

    def _look(self) -> None:
        self._looks = None
        self._update()

    def _write(self, value: int, size: int) -> None:
        if size < self._word_bytes:
            self.note("misuse", "DR", "a word of more than 8 bits takes an access of 16")
        if not self._flags() & TXE:
            self.note("misuse", "DR", "a word was written while TXE was 0: it is lost")
            return
        last = self._is_last(TXDMAEN, self._tx_left)
        if last and self[CR2] & LDMA_TX:
            size = self._word_bytes  # of an odd number, the last access has one word
        self._crc_due = self._crc_due or (last and bool(self[CR1] & CRCEN))
        self._tx += (value & (1 << 8 * size) - 1).to_bytes(size, "little")
        self._proceed()
        self._update()

    def _is_last(self, enable: int, left: Callable[[], int]) -> bool:
        """Say whether DMA makes the last access of its count."""
        return bool(self[CR2] & enable) and left() == 1

    # --- what differs from others

    @property
    def _bits(self) -> int:
        return (self[CR2] >> 8 & 0xF) + 1

    @property
    def _word_bytes(self) -> int:
        return 1 if self._bits <= 8 else 2

    def _flags(self) -> int:
        sent, received = len(self._tx), len(self._rx)
        flags = self[SR] & (MODF | OVR | CRCERR | FRE) | min(sent, 3) << 11 | min(received, 3) << 9
        if sent <= FIFO_BYTES // 2:
            flags |= TXE
        if received >= (1 if self[CR2] & FRXTH else 2):
            flags |= RXNE
        return flags

    def _wants_read(self) -> bool:
        odd = self[CR2] & LDMA_RX and self._word_bytes == len(self._rx) == 1 and self._rx_left() == 1
        return super()._wants_read() or bool(odd)

    def _is_busy(self) -> bool:
        return self._busy or (self._pause is not None and self._has_next)

    @property
    def _has_next(self) -> bool:
        """Whether a master has a word to begin."""
        return bool(self._crc_out or self._receives_only or len(self._tx) >= self._word_bytes)

    def _take_next(self) -> int | None:
        if self._crc_out:
            return self._crc_out.pop(0)
        if len(self._tx) < self._word_bytes:
            return None
        word = int.from_bytes(self._tx[: self._word_bytes], "little") & self._mask
        del self._tx[: self._word_bytes]
        self._sent_last = word
        return word

    def _sent_by_slave(self, word: int | None) -> int:
        return self._sent_last & self._mask if word is None else word

    def _word_over(self, word: int, received: int) -> None:
        if self[CR1] & CRCEN and self._crc_left:
            self._crc_word_over(received)
        elif self[CR1] & CRCEN:
            self._count(word, received)
        if not self._transmits_only:
            self._received(received)

    def _received(self, word: int) -> None:
        room = FIFO_BYTES // 2 if self[CR1] & CRCEN else FIFO_BYTES
        if self[SR] & OVR or len(self._rx) + self._word_bytes > room:
            self[SR] |= OVR
            self._read_dr = False
        else:
            self._rx += word.to_bytes(self._word_bytes, "little")

    # --- CRC (section 35.5.14)

    @property
    def _crc_width(self) -> int:
        return 16 if self[CR1] & CRCL else 8

    def _count(self, word: int, received: int) -> None:
        bits, width, polynomial = self._bits, self._crc_width, self[CRCPR]
        if bits not in (8, 16):
            self.note("misuse", "CR1.CRCEN", f"words of {bits} bits have no CRC, only those of 8 and 16")
            return
        if self._crc_over:
            self._crc_over = False
            super()._new_crc()
        self[TXCRCR] = crc_of(self[TXCRCR], word, polynomial, bits, width)
        self[RXCRCR] = crc_of(self[RXCRCR], received, polynomial, bits, width)
        if not self._tx and (self._crc_next or self._crc_due):
            self._crc_next = self._crc_due = False
            self[CR1] &= ~CRCNEXT
            self._begin_crc()

    def _begin_crc(self) -> None:
        self._crc_left, self._crc_in = max(self._crc_width // self._bits, 1), 0
        if not self._receives_only:
            crc = self[TXCRCR]
            self._crc_out = [crc >> 8, crc & 0xFF] if self._crc_left == 2 else [crc]

    def _crc_word_over(self, received: int) -> None:
        self._crc_left -= 1
        self._crc_in = self._crc_in << self._bits | received
        if not self._crc_left:
            self._crc_over = True
            if not self._transmits_only and self._crc_in & (1 << self._crc_width) - 1 != self[RXCRCR]:
                self[SR] |= CRCERR

    # --- the pulse of NSS between words (section 35.5.12)

    @property
    def _pulses(self) -> bool:
        return bool(self[CR2] & NSSP and not self[CR1] & CPHA and not self._ti)

    def _nss_level(self) -> bool:
        return self._pulsed or (self._pulses and not self._busy)

    def _begin(self, word: int, *, drives: bool) -> None:
        self._pulsed = False
        if self._drives_nss:
            self._nss_out.set(False)
        super()._begin(word, drives=drives)

    def _ended(self, word: int, received: int) -> None:
        if self._pulses and self._master:
            if self._drives_nss:
                self._nss_out.set(True)
            self._pause_for_a_clock()
        super()._ended(word, received)

    def _pause_for_a_clock(self) -> None:
        self._pause = self.time.after(2 * self._half_cycles, self._pause_over)

    def _pause_over(self) -> None:
        self._pause = None
        self._pulsed = self._pulsed and self._master
        self._proceed()
        self._update()

    def _proceed(self) -> None:
        if self._pause is not None:
            return
        if self._ti and self._master and not self._busy and not self._pulsed and self._has_next:
            self._pulsed = True
            self._nss_out.set(True)
            self._pause_for_a_clock()
        else:
            super()._proceed()

    # --- TI mode (section 35.5.13): CPOL, CPHA, LSBFIRST, SSM, SSI and SSOE do not matter

    @property
    def _ti(self) -> bool:
        return bool(self[CR2] & FRF)

    @property
    def _cpol(self) -> bool:
        return not self._ti and super()._cpol

    @property
    def _cpha(self) -> bool:
        return self._ti or super()._cpha

    @property
    def _lsb_first(self) -> bool:
        return not self._ti and super()._lsb_first

    @property
    def _drives_nss(self) -> bool:
        return self._ti or super()._drives_nss

    def _selected(self, control: int) -> bool:
        return not control & MSTR if self._ti else super()._selected(control)

    def exchange(self, bits: int, count: int | None = None) -> int | None:
        """As of every interface; in TI mode a pulse of NSS may come before the end of a word.

        Args:
            bits: those of a word on MOSI, the first one as the highest.
            count: how many clocks there were until that pulse; None for a whole word.

        Returns:
            As there; None for a word that was cut short, which is lost and sets FRE.
        """
        if self._ti and count is not None and count < self._bits:
            self[SR] |= FRE
            self._update()
            return None
        return super().exchange(bits)
