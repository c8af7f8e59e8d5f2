"""SPI1 to SPI3 of the STM32F103 (RM0008 section 25): master and slave, 8 and 16 bits, one wire or two, CRC, DMA.

What it shares with those of other families, and most choices: `spi_base`. A word that is written while nothing is under
way begins at once, so TXE stays set. RXNE rises at the end of its last clock, where the next word begins if there is
one.

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
    BIDIMODE,
    BIDIOE,
    CR1,
    CR2,
    CRCEN,
    CRCERR,
    CRCNEXT,
    CRCPR,
    DR,
    I2SCFGR,
    I2SMOD,
    I2SPR,
    NO_CLOCK,
    NO_I2S,
    OVR,
    RXCRCR,
    RXNE,
    SR,
    TXCRCR,
    TXDMAEN,
    TXE,
    BasicSpi,
)
from targets.mcu.stm32.spi_crc import crc_of

__all__ = ["Spi"]

DFF = 1 << 11

_NO_I2S = "devices of medium density have no I2S"


class Spi(BasicSpi):
    """One of them; see `BasicSpi`.

    Args:
        name: ``SPI1``.
        base: address of CR1.
        services: as there.
        bus: whose clock it is.
        irq: its interrupt.
        has_i2s: whether there are I2S registers, which are declared absent.
        tx_left: returns how many words DMA has still to bring, for the CRC that follows them.
    """

    LENGTH_BIT = "DFF"
    REGISTERS: ClassVar[tuple[Register, ...]] = (
        Register("CR1", CR1, 0, 0xFFFF, fidelity=Fidelity.PARTLY, note=NO_CLOCK),
        Register("CR2", CR2, 0, 0xE7),
        Register("SR", SR, TXE, CRCERR),
        Register("DR", DR, 0, 0xFFFF),
        Register("CRCPR", CRCPR, 0x07, 0xFFFF),
        Register("RXCRCR", RXCRCR, 0, 0),
        Register("TXCRCR", TXCRCR, 0, 0),
        Register("I2SCFGR", I2SCFGR, 0, 0, I2SMOD, fidelity=Fidelity.PARTLY, note=_NO_I2S),
        Register("I2SPR", I2SPR, 0, 0, fidelity=Fidelity.ABSENT, note=_NO_I2S),
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
        tx_left: Callable[[], int] = lambda: 1,
    ) -> None:
        self._tx_left = tx_left
        super().__init__(name, base, services, bus=bus, irq=irq, has_i2s=has_i2s)

    def registers_of(self) -> Iterable[Register]:
        """Return the registers, those of I2S as this device has them."""
        for register in self.REGISTERS:
            if register.offset == I2SCFGR and self._has_i2s:
                yield replace(register, writable=0x0FBF, note=NO_I2S)
            elif register.offset == I2SPR and self._has_i2s:
                yield replace(register, reset=2, writable=0x03FF, note=NO_I2S)
            else:
                yield register

    def _clear(self) -> None:
        super()._clear()
        self._waiting: int | None = None  # the transmit buffer
        self._crc_word = False

    # --- registers

    def read_DR(self) -> int:
        """Return what was received last."""
        self[SR] &= ~RXNE
        self._read_dr = True
        self._update()
        return self[DR]

    def write_DR(self, value: int) -> None:
        """Put a word into the transmit buffer."""
        if self._waiting is not None:
            self.note("misuse", "DR", "a word was written while TXE was 0: the one before is lost")
        self._waiting = value & self._mask
        self[SR] &= ~TXE
        self._proceed()
        self._update()

    # --- what differs from others

    def _is_busy(self) -> bool:
        """BSY stays low while one wire receives (RM0008 section 25.3.7)."""
        return self._busy and self[CR1] & (BIDIMODE | BIDIOE) != BIDIMODE

    @property
    def _bits(self) -> int:
        return 16 if self[CR1] & DFF else 8

    def _take_next(self) -> int | None:
        word, self._waiting = self._waiting, None
        if word is not None:
            self[SR] |= TXE
        return word

    def _sent_by_slave(self, word: int | None) -> int:
        return self[DR] if word is None else word

    def _word_over(self, word: int, received: int) -> None:
        if self[CR1] & CRCEN and self._crc_word:
            self._crc_word = False
            if not self._transmits_only and received != self[RXCRCR]:
                self[SR] |= CRCERR
        elif self[CR1] & CRCEN:
            self[TXCRCR] = crc_of(self[TXCRCR], word, self[CRCPR], self._bits)
            self[RXCRCR] = crc_of(self[RXCRCR], received, self[CRCPR], self._bits)
            if self._waiting is None and (self._crc_next or self._last_of_dma):
                self._crc_next, self._crc_word = False, True
                self[CR1] &= ~CRCNEXT
                if not self._receives_only:
                    self._waiting = self[TXCRCR]
        if not self._transmits_only:
            self._received(received)

    @property
    def _last_of_dma(self) -> bool:
        """Whether DMA has nothing more to send: then the CRC follows by itself (RM0008 section 25.3.7)."""
        return bool(self[CR2] & TXDMAEN) and self._tx_left() == 0

    def _received(self, word: int) -> None:
        if self[SR] & RXNE:
            self[SR] |= OVR
            self._read_dr = False
        else:
            self[DR] = word
            self[SR] |= RXNE
