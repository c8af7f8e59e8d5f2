"""SPI interfaces that move packets of words, in transfers of a given size (RM0433 section 50, on the STM32H7).

A transfer begins with CSTART. With TSIZE it ends by itself after so many words, and the CRC after them, with EOT;
without, it goes on as long as there is something to send, or until CSUSP. FTHLV words are a packet: TXP says that one
has room, RXP that one is there. The words run on a clock of their own, which RCC chooses.

A master is connected to `SpiBus`, where the slaves outside are, and to its pins (`spi_wire`). A slave is clocked a word
at a time through `PacketSpi.exchange`, by whoever is its master in a test.

Choices where the manual is silent:

* The clock of the bus and that of the words need no time for each other: a word begins as soon as it can.
* CR1, CFG1, CFG2, CRCPOLY and UDRDR keep what may not be written now; it is noted if it would change something.
* A write to TXDR while SPE is 0, or that finds no room, is lost, which is noted; so is an access that is narrower than
  a word. A read finds zeros in place of words that are not there. Words of 17 to 24 bits take three bytes of a FIFO.
* CSTART may be set by the write that sets SPE.
* SPE that is cleared breaks a word off. While SPE is 0, TXP is set as after a reset, and asks for nothing.
* After an overrun, what comes is lost until OVR or SPE is cleared; SPE leaves the flag as it is. A master that MASRX
  has suspended keeps CSTART.
* DMA is asked once for each word of a packet, and after EOT for the words that make no whole packet.
* A transfer that is started anew without SPE being cleared has the same TSIZE.
* SS is active while CSTART is set, so not while CSUSP has suspended; SSOM lets it be inactive for all clocks of MIDI.
* CRC needs TSIZE. What comes in as CRC does not go to the FIFO. If it is shorter than the polynomial, it is the
  highest bits; TXCRC and RXCRC show all of them, until SPE changes or the next transfer begins.

Not modelled: I2S; TI mode; IOSWP; UDRDET, for a slave finds out when a word begins that it has nothing to send; a slave
that is clocked by the edges at its pins, which is noted.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace
from fractions import Fraction

from targets.mcu.registers import Peripheral, Register
from targets.mcu.services import Services
from targets.mcu.spi_bus import SpiBus
from targets.mcu.stm32 import spi_packet_registers as bits
from targets.mcu.stm32.spi_crc import crc_of, reversed_bits
from targets.mcu.stm32.spi_packet_registers import (
    CFG1,
    CFG2,
    CR1,
    CR2,
    CRCEN,
    CRCPOLY,
    CSTART,
    EOT,
    I2SCFGR,
    IER,
    MASTER,
    RXCRC,
    RXDR,
    SPE,
    SR,
    TXCRC,
    TXDR,
    UDRDR,
)
from targets.mcu.stm32.spi_wire import SpiWire, Word
from targets.mcu.timebase import Event

__all__ = ["PacketSpi"]

_REPEAT = {1: 0x0101_0101, 2: 0x0001_0001}
FULL_DUPLEX, TRANSMITS, RECEIVES, HALF_DUPLEX = range(4)


class PacketSpi(Peripheral):
    """One of them. It tells accesses of 8, 16 and 32 bits to TXDR and RXDR apart (`targets.mcu.bus.TakesParts`).

    Args:
        name: ``SPI1``, also of its clock.
        base: address of CR1.
        services: what the chip offers. Used: the interrupt, requests ``SPI1_RX`` and ``SPI1_TX``, the pins' signals,
            the clock of the words.
        irq: its interrupt.
        wide: FIFOs of 16 bytes, words of up to 32 bits, and I2S; else 8 bytes and 16 bits.

    Attributes:
        bus: the slaves outside.
    """

    REGISTERS = bits.REGISTERS

    def __init__(self, name: str, base: int, services: Services, *, irq: int, wide: bool) -> None:
        self._fifo_bytes, self._most_bits = (16, 32) if wide else (8, 16)
        super().__init__(name, base, services)
        self.bus = SpiBus()
        self._irq = services.irq(irq)
        self._rx_request, self._tx_request = services.dma(f"{name}_RX"), services.dma(f"{name}_TX")
        self._wire = SpiWire(name, services, self.bus)
        self._nss_in, self._nss_out = services.input(f"{name}_NSS"), services.output(f"{name}_NSS")
        self._pause: Event | None = None
        self._clear()

    def registers_of(self) -> Iterable[Register]:
        """Return the registers; where words have 16 bits at most, without what is for longer ones."""
        for register in self.REGISTERS:
            if register.offset == CFG1 and self._most_bits == 16:
                yield replace(register, writable=register.writable & ~(1 << 4 | 1 << 20))
            elif register.offset in (CRCPOLY, UDRDR) and self._most_bits == 16:
                yield replace(register, writable=0xFFFF)
            elif register.offset == I2SCFGR and self._most_bits == 16:
                yield replace(register, writable=0, note=f"{self.name} has no I2S")
            else:
                yield register

    def _clear(self) -> None:
        """Be as while SPE is 0."""
        self._tx: list[int] = []
        self._rx: list[int] = []
        self._tx_asked = self._rx_asked = 0  # words that DMA is still asked for
        self._sent_last = self._received_last = 0
        self._busy = self._suspends = self._held = self._pulse = self._overrun = False
        self.time.cancel(self._pause)
        self._pause = None
        self._begin_transfer()

    def _begin_transfer(self) -> None:
        self._left = self._size = self[CR2] & 0xFFFF  # words still to pass, and that may be pushed
        self._pushed = 0
        self._crc_out: list[int] = []
        self._crc_left = self._crc_in = 0
        self[TXCRC] = self._crc_mask if self[CR1] & bits.TCRCINI else 0
        self[RXCRC] = self._crc_mask if self[CR1] & bits.RCRCINI else 0

    # --- what the chip calls

    def reset(self) -> None:
        """Go to the state after reset; a word under way is lost."""
        super().reset()
        self._clear()
        self._wire.release()
        self._nss_out.set(None)
        self._nss_in.on_change = None
        self._update()

    def after_clock_change(self) -> None:
        """Go on, if the clock of the words stood still."""
        self._proceed()

    # --- registers

    def write_CR1(self, value: int) -> None:
        """Switch on and off, start and suspend."""
        before = self[CR1]
        starts = value & CSTART and not before & CSTART
        suspends = value & bits.CSUSP and before & CSTART
        value = value & ~(bits.CSUSP | CSTART) | before & CSTART
        if self[SR] & bits.MODF:
            value &= ~(SPE | bits.IOLOCK)
        if before & SPE:
            locked = bits.IOLOCK | bits.CRC33_17 | bits.RCRCINI | bits.TCRCINI
            value = value & ~locked | before & locked
        if not value & SPE:
            value &= ~CSTART
            if before & SPE:
                value &= ~bits.IOLOCK
        self[CR1] = value
        if (before ^ value) & SPE:
            self._clear()
            if value & SPE:
                self._switched_on()
        if suspends:
            self._suspend()
        if starts and not value & SPE:
            self.note("misuse", "CR1.CSTART", "set while SPE is 0: nothing starts")
        elif starts and self._is_master:
            self._start()
        self._configure()
        self._proceed()
        self._update()

    def _suspend(self) -> None:
        """Stop now, or when the word under way is over."""
        self._suspends = True
        if not self._busy:
            self._suspended()

    def _suspended(self) -> None:
        self._suspends = False
        self[CR1] &= ~CSTART
        self[SR] |= bits.SUSP

    def _switched_on(self) -> None:
        if not self[CFG2] & MASTER:
            self.note("unmodelled", "CFG2.MASTER", f"{bits.NO_SLAVE}: no word ever arrives")
        if self._packet * self._word_bytes > self._fifo_bytes // 2:
            self.note("misuse", "CFG1.FTHLV", "a packet is more than half of a FIFO")
        if self._bits < 4:
            self.note("misuse", "CFG1.DSIZE", f"there are no words of {self._bits} bits")
        if self[CFG1] & CRCEN:
            if not self._size:
                self.note("misuse", "CFG1.CRCEN", "without TSIZE no CRC follows")
            if self._crc_size % self._bits:
                what = f"{self._crc_size} bits are no multiple of a word of {self._bits}"
                self.note("misuse", "CFG1.CRCSIZE", f"{what}: what goes is no CRC")

    def _start(self) -> None:
        if not self._left:
            pushed = self._pushed
            self._begin_transfer()
            self._pushed = pushed
        self[CR1] |= CSTART
        if not self._half_cycles:
            self.note("misuse", "CR1.CSTART", "the clock that RCC has chosen for it stands still: no word ever ends")
        self._show_nss()
        lead = self[CFG2] & 0xF
        if lead and self._drives_nss:
            self._wait(lead)

    def write_CR2(self, value: int) -> None:
        """TSIZE while SPE is 0; TSER, what the transfer is extended by, while it is 0."""
        before = self[CR2]
        if self[CR1] & SPE:
            self._note_locked("CR2.TSIZE", before & 0xFFFF, value & 0xFFFF)
            value = value & 0xFFFF_0000 | before & 0xFFFF
        if before >> 16:
            value = before & 0xFFFF_0000 | value & 0xFFFF
        self[CR2] = value
        if value >> 16:
            self[SR] &= ~bits.TSERF
        if not self[CR1] & SPE:
            self._begin_transfer()
        self._update()

    def write_CFG1(self, value: int) -> None:
        """Lengths, thresholds, DMA, CRC and rate, while SPE is 0."""
        self._write_locked(CFG1, value)

    def write_CFG2(self, value: int) -> None:
        """Format, pins and directions, while SPE is 0 and IOLOCK clear."""
        self._write_locked(CFG2, value)
        self._configure()
        self._update()

    def write_CRCPOLY(self, value: int) -> None:
        """While SPE is 0."""
        self._write_locked(CRCPOLY, value)

    def write_UDRDR(self, value: int) -> None:
        """While SPE is 0."""
        self._write_locked(UDRDR, value)

    def _write_locked(self, offset: int, value: int) -> None:
        if self[CR1] & SPE or (offset == CFG2 and self[CR1] & bits.IOLOCK):
            self._note_locked(self.registers[offset].name, self[offset], value)
            return
        self[offset] = value
        self._begin_transfer()

    def _note_locked(self, where: str, before: int, value: int) -> None:
        if before != value:
            self.note("misuse", where, "it can be changed only while SPE is 0 (CFG2: and IOLOCK, too)")

    def write_IER(self, value: int) -> None:
        """Enable interrupts."""
        self[IER] = value
        self._update()

    def read_SR(self) -> int:
        """Return the flags, and how many words are left of the transfer."""
        return self._flags()

    def read_IFCR(self) -> int:
        """Return 0: the register can only be written."""
        return 0

    def write_IFCR(self, value: int) -> None:
        """Clear flags; without SUSP, a master that MASRX has suspended goes on."""
        self[SR] &= ~(value & bits.KEPT)
        if value & bits.SUSP:
            self._held = False
        if value & bits.OVR:
            self._overrun = False
        self._proceed()
        self._update()

    # --- data

    def read_RXDR(self) -> int:
        """Read as by 32 bits."""
        return self._pull(4)

    def read_TXDR(self) -> int:
        """Return 0: the register can only be written."""
        return 0

    def write_TXDR(self, value: int) -> None:
        """Write as by 32 bits."""
        self._push(value, 4)

    def read_part(self, offset: int, size: int) -> int:
        """Read 1 or 2 bytes; of RXDR as many words leave the FIFO as these hold."""
        if offset & ~3 == RXDR:
            return self._pull(size)
        return self.read(offset & ~3) >> 8 * (offset & 3) & (1 << 8 * size) - 1

    def write_part(self, offset: int, size: int, value: int) -> None:
        """Write 1 or 2 bytes; to TXDR as many words as these hold. Other registers get them repeated, as on any APB."""
        if offset & ~3 == TXDR:
            self._push(value, size)
        else:
            self.write(offset & ~3, value * _REPEAT[size])

    @property
    def _is_filled(self) -> bool:
        """Whether a transfer of a given size has all its words."""
        return self._pushed >= self._size + (self[CR2] >> 16)

    def _is_narrow(self, where: str, size: int) -> bool:
        narrow = 8 * size < self._bits
        if narrow:
            self.note("misuse", where, "an access is narrower than a word: it has no effect")
        return narrow

    def _pull(self, size: int) -> int:
        if self._is_narrow("RXDR", size):
            return 0
        width = self._word_bytes
        count = max(size // width, 1)
        value = sum(word << 8 * width * at for at, word in enumerate(self._rx[:count]))
        del self._rx[:count]
        self._rx_asked = max(self._rx_asked - count, 0)
        self._update()
        return value

    def _push(self, value: int, size: int) -> None:
        if self._is_narrow("TXDR", size):
            return
        if not self[CR1] & SPE:
            self.note("misuse", "TXDR", "written while SPE is 0: it is lost")
            return
        width = self._word_bytes
        for at in range(max(size // width, 1)):
            if len(self._tx) >= self._room:
                self.note("misuse", "TXDR", "there is no room in the FIFO: the word is lost")
                break
            self._tx.append(value >> 8 * width * at & self._mask)
            self._pushed += 1
            self._tx_asked = max(self._tx_asked - 1, 0)
        if self._size and self._transmits and self._is_filled:
            self[SR] |= bits.TXTF
            self[IER] &= ~(bits.TXP | bits.DXP)  # TXPIE and DXPIE
        self._proceed()
        self._update()

    # --- what it is

    @property
    def _bits(self) -> int:
        return (self[CFG1] & 0x1F) + 1

    @property
    def _mask(self) -> int:
        return (1 << self._bits) - 1

    @property
    def _word_bytes(self) -> int:
        return (self._bits + 7) // 8

    @property
    def _packet(self) -> int:
        return (self[CFG1] >> 5 & 0xF) + 1

    @property
    def _room(self) -> int:
        """Words that a FIFO holds."""
        return self._fifo_bytes // self._word_bytes

    @property
    def _is_master(self) -> bool:
        return bool(self[CFG2] & MASTER) and not self[I2SCFGR] & bits.I2SMOD

    @property
    def _mode(self) -> int:
        return self[CFG2] >> 17 & 3

    @property
    def _transmits(self) -> bool:
        mode = self._mode
        return mode in (FULL_DUPLEX, TRANSMITS) or (mode == HALF_DUPLEX and bool(self[CR1] & bits.HDDIR))

    @property
    def _receives(self) -> bool:
        return self._mode == FULL_DUPLEX or not self._transmits

    @property
    def _half_cycles(self) -> Fraction:
        """CPU cycles of half a clock; 0 while it stands still."""
        return self.services.clocks.kernel(self.name) * (1 << (self[CFG1] >> 28 & 7))

    def _flags(self) -> int:
        width, received = self._word_bytes, len(self._rx)
        flags = self[SR] & bits.KEPT | self._left << 16
        if self._room - len(self._tx) >= self._packet:
            flags |= bits.TXP
        if received >= self._packet:
            flags |= bits.RXP
        if flags & bits.TXP and flags & bits.RXP:
            flags |= bits.DXP
        if received * width >= 4:
            flags |= bits.RXWNE
        if width <= 2:
            flags |= received % (4 // width) << 13
        if flags & EOT if self._size else not (self._tx or self._busy):
            flags |= bits.TXC
        return flags

    # --- pins

    def _configure(self) -> None:
        """Have the pins follow; and look whether another master has taken the bus."""
        control, settings = self[CR1], self[CFG2]
        by_pin = not settings & bits.SSM and not settings & bits.SSOE
        self._nss_in.on_change = self._nss_changed if control & SPE and by_pin else None
        if control & SPE and self._is_master and self._selected:
            self._mode_fault()
        if self._is_master and (self[CR1] & SPE or self[CFG2] & bits.AFCNTR):
            if not self[CR1] & SPE and self._wire.under_way:
                self._wire.release()
            self._wire.idle(bool(settings & bits.CPOL))
        else:
            self._wire.release()
        self._show_nss()

    @property
    def _drives_nss(self) -> bool:
        settings = self[CFG2]
        return self._is_master and settings & (bits.SSOE | bits.SSM) == bits.SSOE

    def _show_nss(self) -> None:
        """SS is active from the start of a transfer to its end."""
        if self._drives_nss and (self[CR1] & SPE or self[CFG2] & bits.AFCNTR):
            active = bool(self[CR1] & CSTART) and not self._is_between
            self._nss_out.set(active is bool(self[CFG2] & bits.SSIOP))
        else:
            self._nss_out.set(None)

    @property
    def _is_between(self) -> bool:
        """Whether SS is inactive between two words."""
        return bool(self._pause is not None and self._pulse)

    @property
    def _selected(self) -> bool:
        """Whether SS is active, by the pin or by software."""
        settings = self[CFG2]
        if settings & bits.SSM:
            level = bool(self[CR1] & bits.SSI)
        elif settings & bits.SSOE and settings & MASTER:
            return False
        else:
            level = self._nss_in.level()
        return level is bool(settings & bits.SSIOP)

    def _nss_changed(self, _level: bool) -> None:
        self._configure()
        self._update()

    def _mode_fault(self) -> None:
        self[SR] |= bits.MODF
        self[CR1] &= ~(SPE | CSTART | bits.IOLOCK)
        self[CFG2] &= ~MASTER
        self._clear()

    # --- words of a master

    def _wait(self, clocks: int, *, pulse: bool = False) -> None:
        self._pulse = pulse
        self._pause = self.time.after(max(math.ceil(2 * clocks * self._half_cycles), 1), self._waited)
        self._show_nss()

    def _waited(self) -> None:
        self._pause = None
        self._show_nss()
        self._proceed()
        self._update()

    def _proceed(self) -> None:
        """Begin the next word, if there is one and none is under way."""
        if self._busy or self._held or self._pause is not None:
            return
        if self[CR1] & (SPE | CSTART) != SPE | CSTART or not self._half_cycles:
            return
        if self._receives and not self._crc_left and self[CR1] & bits.MASRX and len(self._rx) >= self._room:
            self._held = True
            self[SR] |= bits.SUSP
        elif self._crc_left:
            self._begin(self._crc_out.pop(0) if self._transmits else 0)
        elif not self._transmits:
            self._begin(0)
        elif self._tx:
            self._begin(self._tx.pop(0))

    def _begin(self, word: int) -> None:
        settings = self[CFG2]
        self._busy = True
        self._wire.send(
            Word(
                bits=reversed_bits(word, self._bits) if settings & bits.LSBFRST else word,
                count=self._bits,
                half_cycles=self._half_cycles,
                cpha=bool(settings & bits.CPHA),
                drives=self._transmits,
                one_wire=self._mode == HALF_DUPLEX,
            ),
            lambda received: self._ended(word, received),
        )

    def _ended(self, word: int, received: int) -> None:
        self._busy = False
        if self[CFG2] & bits.LSBFRST:
            received = reversed_bits(received, self._bits)
        self._word_over(word, received)
        if self._suspends:
            self._suspended()
        gap = self[CFG2] >> 4 & 0xF
        if gap and self[CR1] & CSTART:
            self._wait(gap, pulse=bool(self[CFG2] & bits.SSOM) and gap > 1)
        self._show_nss()
        self._proceed()
        self._update()

    def _word_over(self, word: int, received: int) -> None:
        if self._crc_left:
            self._crc_word_over(received)
            return
        self._sent_last, self._received_last = word, received
        if self[CFG1] & CRCEN:
            self[TXCRC] = self._crc_after(self[TXCRC], word)
            self[RXCRC] = self._crc_after(self[RXCRC], received)
        if self._receives:
            self._keep(received)
        if self._left:
            self._left -= 1
            if not self._left:
                self._words_over()

    def _keep(self, word: int) -> None:
        if self._overrun or len(self._rx) >= self._room:
            self._overrun = True
            self[SR] |= bits.OVR
        else:
            self._rx.append(word)

    def _words_over(self) -> None:
        """All words of TSIZE have passed: more follow by TSER, or the CRC, or it is the end."""
        more = self[CR2] >> 16
        if more:
            self[CR2] &= 0xFFFF
            self._left = more
            self._size += more
            self[SR] |= bits.TSERF
        elif self[CFG1] & CRCEN:
            self._begin_crc()
        else:
            self._transfer_over()

    def _transfer_over(self) -> None:
        self._pushed -= self._size
        self[SR] |= EOT
        self[CR1] &= ~CSTART
        self._suspends = False

    # --- CRC (RM0433 section 50.5.3)

    @property
    def _crc_width(self) -> int:
        return self._most_bits if self[CR1] & bits.CRC33_17 else max(self[CRCPOLY].bit_length() - 1, 1)

    @property
    def _crc_mask(self) -> int:
        return (1 << self._crc_width) - 1

    def _crc_after(self, crc: int, word: int) -> int:
        return crc_of(crc, word, self[CRCPOLY] & self._crc_mask, self._bits, self._crc_width)

    def _crc_sent(self, crc: int) -> int:
        """Return the bits of a CRC that go over the wires."""
        return crc >> max(self._crc_width - self._crc_size, 0)

    @property
    def _crc_size(self) -> int:
        return (self[CFG1] >> 16 & 0x1F) + 1

    def _begin_crc(self) -> None:
        self._crc_left, self._crc_in = max(self._crc_size // self._bits, 1), 0
        whole = self._crc_sent(self[TXCRC])
        self._crc_out = [whole >> self._bits * at & self._mask for at in range(self._crc_left - 1, -1, -1)]

    def _crc_word_over(self, received: int) -> None:
        self._crc_left -= 1
        self._crc_in = self._crc_in << self._bits | received
        if not self._crc_left:
            if self._receives and self._crc_in != self._crc_sent(self[RXCRC]):
                self[SR] |= bits.CRCE
            self._transfer_over()

    # --- words of a slave

    def exchange(self, on_mosi: int) -> int | None:
        """Be clocked through a word by a master, now.

        Args:
            on_mosi: the bits of a word, the first one as the highest.

        Returns:
            What stood on MISO; None if it is no slave that is switched on and selected, or sends nothing.
        """
        if not self[CR1] & SPE or self[CFG2] & MASTER or self[I2SCFGR] & bits.I2SMOD or not self._selected:
            return None
        turned = bool(self[CFG2] & bits.LSBFRST)
        sent = self._next_of_slave() if self._transmits else None
        received = reversed_bits(on_mosi, self._bits) if turned else on_mosi & self._mask
        self._word_over(sent or 0, received)
        self._update()
        return None if sent is None else reversed_bits(sent, self._bits) if turned else sent

    def _next_of_slave(self) -> int:
        if self._crc_left:
            return self._crc_out.pop(0)
        if self._tx:
            return self._tx.pop(0)
        self[SR] |= bits.UDR
        instead = self[CFG1] >> 9 & 3
        if instead == 1:
            return 0 if self._mode == TRANSMITS else self._received_last
        return self._sent_last if instead else self[UDRDR] & self._mask

    # --- lines

    def _update(self) -> None:
        flags, enables, on = self._flags(), self[IER], bool(self[CR1] & SPE)
        wanted = flags & enables if on else flags & enables & bits.KEPT
        if enables & EOT:  # EOTIE
            wanted |= flags & (bits.SUSP | (bits.TXC if on else 0))
        self._irq.set(bool(wanted))
        if not on:
            self._tx_asked = self._rx_asked = 0
        else:
            needs_more = not self._size or (self._left and not self._is_filled)
            if not self._tx_asked and flags & bits.TXP and needs_more:
                self._tx_asked = self._packet
            if not self._rx_asked and flags & bits.RXP:
                self._rx_asked = self._packet
            elif not self._rx_asked and self._size and not self._left:
                self._rx_asked = len(self._rx)
        self._tx_request.set(bool(self._tx_asked and self[CFG1] & bits.TXDMAEN))
        self._rx_request.set(bool(self._rx_asked and self[CFG1] & bits.RXDMAEN))
