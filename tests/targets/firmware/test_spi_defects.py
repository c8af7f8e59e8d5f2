"""Each defect of SPI is found by the self-test of the chip that has it."""

from __future__ import annotations

import pytest

from targets.mcu.stm32.spi_base import BasicSpi
from targets.mcu.stm32.spi_fifo import FifoSpi
from targets.mcu.stm32.spi_packets import PacketSpi
from targets.mcu.stm32.spi_wire import SpiWire
from tests.targets.firmware.defect import Defect, finds_it, some

LIMIT_MS = 25

F7, H7 = "f767-spi", "h753-spi"
DEFECTS = [
    Defect("always eight bits", F7, FifoSpi, "_bits", "self[CR2] >> 8 & 0xF", "7 + 0"),
    Defect("words of three bits", F7, FifoSpi, "write_CR2", "if value >> 8 & 0xF < 3", "if False"),
    Defect("words take half as long", F7, BasicSpi, "_half_cycles", "<< (self[CR1] >> 3 & 7)", ">> 1"),
    Defect("an access is one word", F7, FifoSpi, "read_part", "self._read(size)", "self._read(1)"),
    Defect("16 bits send one word", F7, FifoSpi, "write_part", "self._write(value, size)", "self._write(value, 1)"),
    Defect("FRXTH is not looked at", F7, FifoSpi, "_flags", "1 if self[CR2] & FRXTH else 2", "1"),
    Defect("TXE until it is full", F7, FifoSpi, "_flags", "sent <= FIFO_BYTES // 2", "sent < FIFO_BYTES"),
    Defect("no FTLVL", F7, FifoSpi, "_flags", "min(sent, 3) << 11", "0"),
    Defect("no FRLVL", F7, FifoSpi, "_flags", "min(received, 3) << 9", "0"),
    Defect("two have room", F7, FifoSpi, "_received", "else FIFO_BYTES", "else FIFO_BYTES // 2"),
    Defect("no overrun", F7, FifoSpi, "_received", "self[SR] |= OVR", "pass"),
    Defect("SR alone ends an overrun", F7, BasicSpi, "read_SR", "and self._read_dr", ""),
    Defect("no mode fault", F7, BasicSpi, "_selected", "return not control & SSI", "return False"),
    Defect("MODF never ends", F7, BasicSpi, "write_CR1", "self[SR] &= ~MODF", "pass"),
    Defect("no pulse", F7, FifoSpi, "_pulses", "self[CR2] & NSSP and", "False and"),
    Defect("a pulse without a pause", F7, FifoSpi, "_proceed", "if self._pause is not None", "if False"),
    Defect("not busy in a pause", F7, FifoSpi, "_is_busy", "self._busy or (", "self._busy or False and ("),
    Defect("no TI mode", F7, FifoSpi, "_ti", "self[CR2] & FRF", "False"),
    Defect("TI mode obeys CPOL", F7, FifoSpi, "_cpol", "not self._ti and", ""),
    Defect("a word of TI mode comes unannounced", F7, FifoSpi, "_proceed", "if self._ti and", "if False and"),
    Defect("CRCL is not looked at", F7, FifoSpi, "_crc_width", "self[CR1] & CRCL", "False"),
    Defect("a CRC is one word", F7, FifoSpi, "_begin_crc", "max(self._crc_width // self._bits, 1)", "1"),
    Defect("no CRC is sent", F7, FifoSpi, "_count", "self._begin_crc()", "pass"),
    Defect("the CRC is not compared", F7, FifoSpi, "_crc_word_over", "self[SR] |= CRCERR", "pass"),
    Defect("LDMA_TX is not looked at", F7, FifoSpi, "_write", "self[CR2] & LDMA_TX", "False"),
    Defect("LDMA_RX is not looked at", F7, FifoSpi, "_wants_read", "self[CR2] & LDMA_RX", "False"),
    Defect("RXNEIE is not looked at", F7, BasicSpi, "_update", "flags & RXNE and enables & RXNEIE", "False"),
    Defect("receive-only stops", F7, BasicSpi, "_proceed", "if self._receives_only", "if False"),
    Defect("LSBFIRST is not looked at", F7, BasicSpi, "_begin", "if self._lsb_first", "if False"),
    Defect("SCK idles low", F7, SpiWire, "idle", "self._sck.set(cpol)", "self._sck.set(False)"),
    Defect("always eight bits", H7, PacketSpi, "_bits", "(self[CFG1] & 0x1F) + 1", "8"),
    Defect("MBR is not looked at", H7, PacketSpi, "_half_cycles", "(1 << (self[CFG1] >> 28 & 7))", "2"),
    Defect("no CSTART is needed", H7, PacketSpi, "_proceed", "& (SPE | CSTART) != SPE | CSTART", "& SPE != SPE"),
    Defect("no CTSIZE", H7, PacketSpi, "_flags", "self._left << 16", "0"),
    Defect("no TXTF", H7, PacketSpi, "_push", "self[SR] |= bits.TXTF", "pass"),
    Defect("TXTF leaves TXPIE", H7, PacketSpi, "_push", "self[IER] &= ~(bits.TXP | bits.DXP)", "pass"),
    Defect("no EOT", H7, PacketSpi, "_transfer_over", "self[SR] |= EOT", "pass"),
    Defect("CSTART stays", H7, PacketSpi, "_transfer_over", "self[CR1] &= ~CSTART", "pass"),
    Defect("TSER is not looked at", H7, PacketSpi, "_words_over", "self[CR2] >> 16", "0"),
    Defect("no TSERF", H7, PacketSpi, "_words_over", "self[SR] |= bits.TSERF", "pass"),
    Defect("TXC without an end", H7, PacketSpi, "_flags", "if flags & EOT if self._size else", "if"),
    Defect("TXP is a word", H7, PacketSpi, "_flags", "len(self._tx) >= self._packet", "len(self._tx) >= 1"),
    Defect("RXP is a word", H7, PacketSpi, "_flags", "received >= self._packet", "received"),
    Defect("no RXPLVL", H7, PacketSpi, "_flags", "flags |= received % (4 // width) << 13", "pass"),
    Defect("no RXWNE", H7, PacketSpi, "_flags", "flags |= bits.RXWNE", "pass"),
    Defect("an access is one word", H7, PacketSpi, "_pull", "max(size // width, 1)", "1"),
    Defect("an access sends one word", H7, PacketSpi, "_push", "max(size // width, 1)", "1"),
    Defect("settings are open", H7, PacketSpi, "_write_locked", "if self[CR1] & SPE or", "if"),
    Defect("IFCR clears nothing", H7, PacketSpi, "write_IFCR", "self[SR] &= ~(value & bits.KEPT)", "pass"),
    Defect("suspended at once", H7, PacketSpi, "_suspend", "if not self._busy", "if True"),
    Defect("no SUSP", H7, PacketSpi, "_suspended", "self[SR] |= bits.SUSP", "pass"),
    Defect("MASRX is not looked at", H7, PacketSpi, "_proceed", "self[CR1] & bits.MASRX", "False"),
    Defect("MASRX waits for ever", H7, PacketSpi, "write_IFCR", "self._held = False", "pass"),
    Defect("no overrun", H7, PacketSpi, "_keep", "self[SR] |= bits.OVR", "pass"),
    Defect("no mode fault", H7, PacketSpi, "_mode_fault", "self[CR1] &= ~(SPE | CSTART | bits.IOLOCK)", "return"),
    Defect("MODF holds nothing", H7, PacketSpi, "write_CR1", "value &= ~(SPE | bits.IOLOCK)", "pass"),
    Defect("SS is always active", H7, PacketSpi, "_show_nss", "bool(self[CR1] & CSTART) and", "True and"),
    Defect("SSOM is not looked at", H7, PacketSpi, "_ended", "bool(self[CFG2] & bits.SSOM)", "False"),
    Defect("no MIDI", H7, PacketSpi, "_ended", "self[CFG2] >> 4 & 0xF", "0"),
    Defect("no MSSI", H7, PacketSpi, "_start", "lead = self[CFG2] & 0xF", "lead = 0"),
    Defect("SSIOP is not looked at", H7, PacketSpi, "_show_nss", "bool(self[CFG2] & bits.SSIOP)", "False"),
    Defect("AFCNTR is not looked at", H7, PacketSpi, "_configure", "self[CFG2] & bits.AFCNTR", "False"),
    Defect("transmitting receives", H7, PacketSpi, "_receives", "self._mode == FULL_DUPLEX or", "True or"),
    Defect("CRCSIZE is not looked at", H7, PacketSpi, "_crc_size", "self[CFG1] >> 16 & 0x1F", "7"),
    Defect("TCRCINI is not looked at", H7, PacketSpi, "_begin_transfer", "self[CR1] & bits.TCRCINI", "False"),
    Defect("no CRC is sent", H7, PacketSpi, "_words_over", "self._begin_crc()", "self._transfer_over()"),
    Defect("the CRC is not compared", H7, PacketSpi, "_crc_word_over", "self[SR] |= bits.CRCE", "pass"),
    Defect(
        "the CRC is kept",
        H7,
        PacketSpi,
        "_crc_word_over",
        "self._crc_left -= 1",
        "self._crc_left -= 1; self._keep(received)",
    ),
    Defect("LSBFRST is not looked at", H7, PacketSpi, "_begin", "if settings & bits.LSBFRST", "if False"),
    Defect("no interrupt", H7, PacketSpi, "_update", "self._irq.set(bool(wanted))", "pass"),
    Defect("the last words are not asked for", H7, PacketSpi, "_update", "self._rx_asked = len(self._rx)", "pass"),
]


@pytest.mark.parametrize("defect", some(DEFECTS, 1))
def test_it_is_found(start, put_in, defect):
    put_in(defect)
    assert finds_it(start(defect.test).to(LIMIT_MS)), "the self-test passes all the same"
