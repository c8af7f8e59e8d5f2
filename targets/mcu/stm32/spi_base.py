"""What the SPI interfaces of the STM32F7 (RM0410 section 35) have of those of the STM32F1 (RM0008 section 25).

Those of the STM32F1 are in C (`targets.mcu.stm32f1.spi`). Here are CR1 but for bit 11, the lower half of CR2, NSS and
the mode fault, how words of a master follow each other, and how flags are cleared. A subclass says how wide its words
are, where they wait, and what a CRC is.

A master is connected to `SpiBus`, where the slaves outside are, and to its pins (`spi_wire`). A slave is clocked a word
at a time through `BasicSpi.exchange`, by whoever is its master in a test.

Choices where the manuals are silent:

* A word that is written while nothing is under way begins at once.
* SPE that is cleared in the middle of a word lets it end, as the manual's procedure for receive-only mode needs it; the
  pins are let go then. MSTR that is cleared, by a mode fault too, breaks the word off.
* NSS that is no pin's is low, as a floating pin reads.
* CRC in a receive-only mode: the word after CRCNEXT was set is taken as the CRC.
"""

from __future__ import annotations

import abc
from typing import ClassVar

from targets.mcu.registers import Peripheral
from targets.mcu.services import Services
from targets.mcu.spi_bus import SpiBus
from targets.mcu.stm32.spi_crc import reversed_bits
from targets.mcu.stm32.spi_wire import SpiWire, Word

__all__ = [
    "BIDIMODE",
    "BIDIOE",
    "CPHA",
    "CR1",
    "CR2",
    "CRCEN",
    "CRCERR",
    "CRCNEXT",
    "CRCPR",
    "DR",
    "FRE",
    "I2SCFGR",
    "I2SMOD",
    "I2SPR",
    "LSBFIRST",
    "MODF",
    "MSTR",
    "NO_CLOCK",
    "NO_I2S",
    "OVR",
    "RXCRCR",
    "RXDMAEN",
    "RXNE",
    "RXONLY",
    "SPE",
    "SR",
    "TXCRCR",
    "TXDMAEN",
    "TXE",
    "BasicSpi",
]

CR1, CR2, SR, DR, CRCPR, RXCRCR, TXCRCR, I2SCFGR, I2SPR = range(0x00, 0x24, 4)

CPHA, CPOL, MSTR, SPE, LSBFIRST, SSI, SSM, RXONLY, LENGTH, CRCNEXT, CRCEN, BIDIOE, BIDIMODE = (
    1 << bit for bit in (0, 1, 2, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15)
)
RXDMAEN, TXDMAEN, SSOE, ERRIE, RXNEIE, TXEIE = (1 << bit for bit in (0, 1, 2, 5, 6, 7))
RXNE, TXE, CRCERR, MODF, OVR, BSY, FRE = (1 << bit for bit in (0, 1, 4, 5, 6, 7, 8))  # FRE: not of the STM32F1
I2SMOD = 1 << 11

NO_CLOCK = "a slave is not clocked by the edges at its pins"
NO_I2S = "I2S is not modelled: nothing is sent, nothing arrives"


class BasicSpi(Peripheral):
    """An SPI interface with CR1, CR2, SR and DR.

    Args:
        name: ``SPI1``.
        base: address of CR1.
        services: what the chip offers. Used: the interrupt, requests ``SPI1_RX`` and ``SPI1_TX``, the pins' signals.
        bus: whose clock it is.
        irq: its interrupt.
        has_i2s: whether there are I2S registers; I2S is not modelled.

    Attributes:
        LENGTH_BIT: the name of bit 11 of CR1.
        bus: the slaves outside.
    """

    LENGTH_BIT: ClassVar[str]

    def __init__(self, name: str, base: int, services: Services, *, bus: str, irq: int, has_i2s: bool) -> None:
        self._has_i2s = has_i2s
        super().__init__(name, base, services)
        self.bus = SpiBus()
        self._bus_clock = bus
        self._irq = services.irq(irq)
        self._rx_request, self._tx_request = services.dma(f"{name}_RX"), services.dma(f"{name}_TX")
        self._wire = SpiWire(name, services, self.bus)
        self._nss_in, self._nss_out = services.input(f"{name}_NSS"), services.output(f"{name}_NSS")
        self._clear()

    def _clear(self) -> None:
        self._busy = False
        self._read_dr = self._saw_modf = False
        self._crc_next = False

    # --- what a family says

    @property
    @abc.abstractmethod
    def _bits(self) -> int:
        """How many a word has."""

    @abc.abstractmethod
    def _take_next(self) -> int | None:
        """Return the word that waits to be sent, and make room; None if there is none."""

    @abc.abstractmethod
    def _word_over(self, word: int, received: int) -> None:
        """A word was sent, and another received meanwhile."""

    @abc.abstractmethod
    def _sent_by_slave(self, word: int | None) -> int:
        """Return what a slave sends that had a word waiting, or none."""

    def _flags(self) -> int:
        """Return SR but for BSY."""
        return self[SR]

    def _wants_read(self) -> bool:
        """Say whether DMA is to read DR."""
        return bool(self._flags() & RXNE)

    # --- what the chip calls

    def reset(self) -> None:
        """Go to the state after reset; a word under way is lost."""
        super().reset()
        self._clear()
        self._wire.release()
        self._nss_out.set(None)
        self._nss_in.on_change = None
        self._update()

    # --- registers

    def write_CR1(self, value: int) -> None:
        """Switch on and off, be master or slave, begin a CRC anew."""
        before = self[CR1]
        if self[SR] & MODF:
            if self._saw_modf:
                self[SR] &= ~MODF
            else:
                value &= ~(SPE | MSTR)
        self._saw_modf = False
        if (value ^ before) & (LENGTH | CRCEN) and before & value & SPE:
            self.note("misuse", "CR1", f"{self.LENGTH_BIT} and CRCEN may be changed only while SPE is 0")
        if value & ~before & SPE and not value & MSTR:
            self.note("unmodelled", "CR1.MSTR", f"{NO_CLOCK}: no word ever arrives")
        if value & ~before & CRCNEXT and value & CRCEN and self._master and not self._busy:
            self.note("misuse", "CR1.CRCNEXT", "set while no word is under way: the CRC follows the next one")
        self[CR1] = value
        if not value & before & CRCEN:
            self._new_crc()
        self._crc_next = bool(value & CRCNEXT and (self._crc_next or not before & CRCNEXT))
        self._configure()
        self._proceed()
        self._update()

    def _new_crc(self) -> None:
        self[RXCRCR] = self[TXCRCR] = 0

    def write_CR2(self, value: int) -> None:
        """Enable interrupts and requests, and NSS as an output."""
        self[CR2] = value
        self._configure()
        self._update()

    def read_SR(self) -> int:
        """Return the flags; a read after one of DR ends an overrun."""
        value = self._flags() | (BSY if self._is_busy() else 0)
        if self[SR] & OVR and self._read_dr:
            self[SR] &= ~OVR
            self._update()
        self._read_dr = False
        self._saw_modf = self._saw_modf or bool(value & MODF)
        return value

    def write_SR(self, value: int) -> None:
        """Clear CRCERR by writing 0; a write counts as an access for MODF, too."""
        self[SR] &= value | ~CRCERR
        self._saw_modf = self._saw_modf or bool(self[SR] & MODF)
        self._update()

    # --- what it is

    def _is_busy(self) -> bool:
        return self._busy

    @property
    def _mask(self) -> int:
        return (1 << self._bits) - 1

    @property
    def _master(self) -> bool:
        return self[CR1] & (SPE | MSTR) == SPE | MSTR and not self._i2s

    @property
    def _i2s(self) -> bool:
        return bool(self._has_i2s and self[I2SCFGR] & I2SMOD)

    @property
    def _receives_only(self) -> bool:
        control = self[CR1]
        return bool(control & RXONLY) if not control & BIDIMODE else not control & BIDIOE

    @property
    def _transmits_only(self) -> bool:
        return self[CR1] & (BIDIMODE | BIDIOE) == BIDIMODE | BIDIOE

    @property
    def _half_cycles(self) -> int:
        """HCLK cycles of half a clock."""
        return max(self.services.clocks.pclk(self._bus_clock), 1) << (self[CR1] >> 3 & 7)

    @property
    def _drives_nss(self) -> bool:
        return bool(self[CR2] & SSOE and not self[CR1] & SSM)

    @property
    def _cpol(self) -> bool:
        return bool(self[CR1] & CPOL)

    @property
    def _cpha(self) -> bool:
        return bool(self[CR1] & CPHA)

    @property
    def _lsb_first(self) -> bool:
        return bool(self[CR1] & LSBFIRST)

    def _configure(self) -> None:
        """Have the pins follow; and look whether another master has taken the bus."""
        control = self[CR1]
        by_pin = not control & SSM and not self._drives_nss
        self._nss_in.on_change = self._nss_changed if control & SPE and by_pin else None
        if self._master and self._selected(control):
            self._mode_fault()
        if self._master:
            self._wire.idle(self._cpol)
            self._nss_out.set(self._nss_level() if self._drives_nss else None)
        elif not (self._busy and self[CR1] & MSTR):
            self._busy = False
            self._wire.release()
            self._nss_out.set(None)

    def _nss_level(self) -> bool:
        """Return what a master drives."""
        return False

    def _selected(self, control: int) -> bool:
        """Say whether NSS is low, by the pin or by software."""
        if control & SSM:
            return not control & SSI
        return not self[CR2] & SSOE and not self._nss_in.level()

    def _nss_changed(self, level: bool) -> None:
        if self._master and not level:
            self._mode_fault()
            self._configure()
            self._update()

    def _mode_fault(self) -> None:
        self[SR] |= MODF
        self[CR1] &= ~(SPE | MSTR)

    # --- words of a master

    def _proceed(self) -> None:
        """Begin the next word, if there is one and none is under way."""
        if self._busy or not self._master:
            return
        if self._receives_only:
            self._begin(0, drives=False)
        elif (word := self._take_next()) is not None:
            self._begin(word, drives=True)

    def _begin(self, word: int, *, drives: bool) -> None:
        control = self[CR1]
        bits = reversed_bits(word, self._bits) if self._lsb_first else word
        self._busy = True
        self._wire.send(
            Word(
                bits=bits & self._mask,
                count=self._bits,
                half_cycles=self._half_cycles,
                cpha=self._cpha,
                drives=drives,
                one_wire=bool(control & BIDIMODE),
            ),
            lambda received: self._ended(word, received),
        )

    def _ended(self, word: int, received: int) -> None:
        self._busy = False
        if self._lsb_first:
            received = reversed_bits(received, self._bits)
        self._word_over(word, received & self._mask)  # which may be shorter than it was
        if not self._master:
            self._configure()
        self._proceed()
        self._update()

    # --- words of a slave

    def exchange(self, bits: int) -> int | None:
        """Be clocked through a word by a master, now.

        Args:
            bits: those of a word on MOSI, the first one as the highest.

        Returns:
            What stood on MISO; None if it is no slave that is switched on and selected.
        """
        control = self[CR1]
        if control & (SPE | MSTR) != SPE or self._i2s or not self._selected(control):
            return None
        sent = self._sent_by_slave(self._take_next())
        received = reversed_bits(bits, self._bits) if self._lsb_first else bits & self._mask
        self._word_over(sent, received)
        self._update()
        if self._transmits_only or not control & (RXONLY | BIDIMODE):
            return reversed_bits(sent, self._bits) if self._lsb_first else sent
        return None

    # --- lines

    def _update(self) -> None:
        flags, enables = self._flags(), self[CR2]
        self._irq.set(
            bool(
                (flags & TXE and enables & TXEIE)
                or (flags & RXNE and enables & RXNEIE)
                or (flags & (OVR | MODF | CRCERR | FRE) and enables & ERRIE)
            )
        )
        self._rx_request.set(bool(enables & RXDMAEN and self._wants_read()))
        self._tx_request.set(bool(flags & TXE and enables & TXDMAEN))
