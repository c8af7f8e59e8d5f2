"""Each defect of SPI is found by the self-test of the chip that has it."""

from __future__ import annotations

import pytest

from targets.mcu.stm32.spi_base import BasicSpi
from targets.mcu.stm32.spi_fifo import FifoSpi
from targets.mcu.stm32.spi_wire import SpiWire
from tests.targets.firmware.defect import Defect, finds_it, some

LIMIT_MS = 25

F7 = "f767-spi"
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
    Defect("a pulse without a pause", F7, FifoSpi, "_proceed", "if self._pause is None", "if True"),
    Defect("not busy in a pause", F7, FifoSpi, "_is_busy", "self._busy or (", "self._busy or False and ("),
    Defect("CRCL is not looked at", F7, FifoSpi, "_crc_width", "self[CR1] & CRCL", "False"),
    Defect("a CRC is one word", F7, FifoSpi, "_begin_crc", "max(self._crc_width // self._bits, 1)", "1"),
    Defect("no CRC is sent", F7, FifoSpi, "_count", "self._begin_crc()", "pass"),
    Defect("the CRC is not compared", F7, FifoSpi, "_crc_word_over", "self[SR] |= CRCERR", "pass"),
    Defect("LDMA_TX is not looked at", F7, FifoSpi, "_write", "self[CR2] & LDMA_TX", "False"),
    Defect("LDMA_RX is not looked at", F7, FifoSpi, "_wants_read", "self[CR2] & LDMA_RX", "False"),
    Defect("RXNEIE is not looked at", F7, BasicSpi, "_update", "flags & RXNE and enables & RXNEIE", "False"),
    Defect("receive-only stops", F7, BasicSpi, "_proceed", "if self._receives_only", "if False"),
    Defect("LSBFIRST is not looked at", F7, BasicSpi, "_begin", "if control & LSBFIRST", "if False"),
    Defect("SCK idles low", F7, SpiWire, "idle", "self._sck.set(cpol)", "self._sck.set(False)"),
]


@pytest.mark.parametrize("defect", some(DEFECTS, 1))
def test_it_is_found(start, put_in, defect):
    put_in(defect)
    assert finds_it(start(defect.test).to(LIMIT_MS)), "the self-test passes all the same"
