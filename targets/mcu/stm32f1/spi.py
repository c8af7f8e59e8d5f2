"""SPI1 to SPI3 of the STM32F103 (RM0008 section 25): master and slave, 8 and 16 bits, one wire or two, CRC, DMA.

A master is tied to `SpiBus`, where the slaves outside are, and to its pins (`spi_wire`). A slave is clocked word by
word through `Spi.exchange`, by whoever is its master in a test.

Choices where the manual is silent:

* A word that is written while nothing is under way begins at once, so TXE stays set. RXNE rises at the end of its last
  clock, where the next word begins if there is one.
* SPE that is cleared in the middle of a word lets it end, as the manual's procedure for receive-only mode needs it; the
  pins are let go then. MSTR that is cleared, by a mode fault too, breaks the word off.
* NSS that is no pin's is low, as a floating pin reads.
* CRC in a receive-only mode: the word after CRCNEXT was set is taken as the CRC.

Not modelled: I2S; a slave that is clocked by the edges at its pins, which is noted.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import ClassVar

from targets.mcu.fidelity import Fidelity
from targets.mcu.registers import Peripheral, Register
from targets.mcu.services import Services
from targets.mcu.spi_bus import SpiBus
from targets.mcu.stm32f1.spi_crc import crc_of, reversed_bits
from targets.mcu.stm32f1.spi_wire import SpiWire, Word

__all__ = ["Spi"]

CR1, CR2, SR, DR, CRCPR, RXCRCR, TXCRCR, I2SCFGR, I2SPR = range(0x00, 0x24, 4)

CPHA, CPOL, MSTR, SPE, LSBFIRST, SSI, SSM, RXONLY, DFF, CRCNEXT, CRCEN, BIDIOE, BIDIMODE = (
    1 << bit for bit in (0, 1, 2, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15)
)
RXDMAEN, TXDMAEN, SSOE, ERRIE, RXNEIE, TXEIE = (1 << bit for bit in (0, 1, 2, 5, 6, 7))
RXNE, TXE, CRCERR, MODF, OVR, BSY = (1 << bit for bit in (0, 1, 4, 5, 6, 7))
I2SMOD = 1 << 11

_NO_I2S = "devices of medium density have no I2S"
_SLAVE = "a slave is not clocked by the edges at its pins"
_ABSENT_I2S = "I2S is not modelled: nothing is sent, nothing arrives"


class Spi(Peripheral):
    """One of them.

    Args:
        name: ``SPI1``.
        base: address of CR1.
        services: what the chip offers. Used: the interrupt, requests ``SPI1_RX`` and ``SPI1_TX``, the pins' signals.
        bus: whose clock it is.
        irq: its interrupt.
        has_i2s: whether there are I2S registers, which are declared absent.
        tx_left: returns how many words DMA has still to bring, for the CRC that follows them.

    Attributes:
        bus: the slaves outside.
    """

    REGISTERS: ClassVar[tuple[Register, ...]] = (
        Register("CR1", CR1, 0, 0xFFFF, fidelity=Fidelity.PARTLY, note=_SLAVE),
        Register("CR2", CR2, 0, 0xE7),
        Register("SR", SR, TXE, CRCERR),
        Register("DR", DR, 0, 0xFFFF),
        Register("CRCPR", CRCPR, 0x07, 0xFFFF),
        Register("RXCRCR", RXCRCR, 0, 0),
        Register("TXCRCR", TXCRCR, 0, 0),
        Register("I2SCFGR", I2SCFGR, 0, 0, fidelity=Fidelity.ABSENT, note=_NO_I2S),
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
        self._has_i2s = has_i2s
        self._tx_left = tx_left
        super().__init__(name, base, services)
        self.bus = SpiBus()
        self._bus_clock = bus
        self._irq = services.irq(irq)
        self._rx_request, self._tx_request = services.dma(f"{name}_RX"), services.dma(f"{name}_TX")
        self._wire = SpiWire(name, services, self.bus)
        self._nss_in, self._nss_out = services.input(f"{name}_NSS"), services.output(f"{name}_NSS")
        self._clear()

    def registers_of(self) -> Iterable[Register]:
        """Return the registers, those of I2S as this device has them."""
        for register in self.REGISTERS:
            if register.offset == I2SCFGR and self._has_i2s:
                yield replace(register, writable=0x0FBF, note=_ABSENT_I2S)
            elif register.offset == I2SPR and self._has_i2s:
                yield replace(register, reset=2, writable=0x03FF, note=_ABSENT_I2S)
            else:
                yield register

    def _clear(self) -> None:
        self._waiting: int | None = None  # the transmit buffer
        self._busy = False
        self._read_dr = self._saw_modf = False
        self._crc_next = self._crc_word = False

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
        if (value ^ before) & (DFF | CRCEN) and before & value & SPE:
            self.note("misuse", "CR1", "DFF and CRCEN may be changed only while SPE is 0")
        if value & ~before & SPE and not value & MSTR:
            self.note("unmodelled", "CR1.MSTR", f"{_SLAVE}: no word ever arrives")
        if value & ~before & CRCNEXT and value & CRCEN and self._master and not self._busy:
            self.note("misuse", "CR1.CRCNEXT", "set while no word is under way: the CRC follows the next one")
        self[CR1] = value
        if not value & before & CRCEN:
            self[RXCRCR] = self[TXCRCR] = 0
        self._crc_next = bool(value & CRCNEXT and (self._crc_next or not before & CRCNEXT))
        self._configure()
        self._proceed()
        self._update()

    def write_CR2(self, value: int) -> None:
        """Enable interrupts and requests, and NSS as an output."""
        self[CR2] = value
        self._configure()
        self._update()

    def read_SR(self) -> int:
        """Return the flags; a read after one of DR ends an overrun."""
        value = self[SR] | (BSY if self._busy and not self._one_wire_in else 0)
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

    def write_I2SCFGR(self, value: int) -> None:
        """Remember; I2S is not modelled."""
        self[I2SCFGR] = value
        if value & I2SMOD:
            self.note("unmodelled", "I2SCFGR.I2SMOD", _ABSENT_I2S)

    # --- what it is

    @property
    def _mask(self) -> int:
        return 0xFFFF if self[CR1] & DFF else 0xFF

    @property
    def _bits(self) -> int:
        return 16 if self[CR1] & DFF else 8

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
    def _one_wire_in(self) -> bool:
        """BSY stays low then (RM0008 section 25.3.7)."""
        return self[CR1] & (BIDIMODE | BIDIOE) == BIDIMODE

    def _configure(self) -> None:
        """Have the pins follow; and look whether another master has taken the bus."""
        control = self[CR1]
        by_pin = not control & SSM and not self[CR2] & SSOE
        self._nss_in.on_change = self._nss_changed if control & SPE and by_pin else None
        if self._master and self._selected(control):
            self._mode_fault()
        if self._master:
            self._wire.idle(bool(self[CR1] & CPOL))
            self._nss_out.set(False if self[CR2] & SSOE and not self[CR1] & SSM else None)
        elif not (self._busy and self[CR1] & MSTR):
            self._busy = False
            self._wire.release()
            self._nss_out.set(None)

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
        elif self._waiting is not None:
            word, self._waiting = self._waiting, None
            self[SR] |= TXE
            self._begin(word, drives=True)

    def _begin(self, word: int, *, drives: bool) -> None:
        control = self[CR1]
        half_cycles = max(self.services.clocks.pclk(self._bus_clock), 1) << (control >> 3 & 7)
        bits = reversed_bits(word, self._bits) if control & LSBFIRST else word
        self._busy = True
        self._wire.send(
            Word(
                bits=bits & self._mask,
                count=self._bits,
                half_cycles=half_cycles,
                cpha=bool(control & CPHA),
                drives=drives,
                one_wire=bool(control & BIDIMODE),
            ),
            lambda received: self._ended(word, received),
        )

    def _ended(self, word: int, received: int) -> None:
        self._busy = False
        if self[CR1] & LSBFIRST:
            received = reversed_bits(received, self._bits)
        self._word_over(word, received)
        if not self._master:
            self._configure()
        self._proceed()
        self._update()

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

    # --- words of a slave

    def exchange(self, bits: int) -> int | None:
        """Be clocked through a word by a master, now.

        Args:
            bits: 8 or 16 on MOSI, the first one as the highest.

        Returns:
            What stood on MISO; None if it is no slave that is switched on and selected.
        """
        control = self[CR1]
        if control & (SPE | MSTR) != SPE or self._i2s or not self._selected(control):
            return None
        word = self._waiting
        if word is not None:
            self._waiting = None
            self[SR] |= TXE
        sent = self[DR] if word is None else word
        received = reversed_bits(bits, self._bits) if control & LSBFIRST else bits & self._mask
        self._word_over(sent, received)
        self._update()
        if self._transmits_only or not control & (RXONLY | BIDIMODE):
            return reversed_bits(sent, self._bits) if control & LSBFIRST else sent
        return None

    # --- lines

    def _update(self) -> None:
        flags, enables = self[SR], self[CR2]
        self._irq.set(
            bool(
                (flags & TXE and enables & TXEIE)
                or (flags & RXNE and enables & RXNEIE)
                or (flags & (OVR | MODF | CRCERR) and enables & ERRIE)
            )
        )
        self._rx_request.set(bool(flags & RXNE and enables & RXDMAEN))
        self._tx_request.set(bool(flags & TXE and enables & TXDMAEN))
