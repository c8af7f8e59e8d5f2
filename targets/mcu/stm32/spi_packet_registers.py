"""Registers and bits of the SPI interfaces that move packets (RM0433 section 50.11; `spi_packets`)."""

from __future__ import annotations

from targets.mcu.fidelity import Fidelity
from targets.mcu.registers import Register

CR1, CR2, CFG1, CFG2, IER, SR, IFCR = range(0x00, 0x1C, 4)
TXDR, RXDR = 0x20, 0x30
CRCPOLY, TXCRC, RXCRC, UDRDR, I2SCFGR = range(0x40, 0x54, 4)

SPE, MASRX, CSTART, CSUSP, HDDIR, SSI, CRC33_17, RCRCINI, TCRCINI, IOLOCK = (
    1 << bit for bit in (0, 8, 9, 10, 11, 12, 13, 14, 15, 16)
)
UDRDET = 3 << 11  # of CFG1
RXDMAEN, TXDMAEN, CRCEN = 1 << 14, 1 << 15, 1 << 22  # of CFG1
IOSWP, SP, MASTER, LSBFRST, CPHA, CPOL, SSM, SSIOP, SSOE, SSOM, AFCNTR = (
    1 << 15, 7 << 19, 1 << 22, 1 << 23, 1 << 24, 1 << 25, 1 << 26, 1 << 28, 1 << 29, 1 << 30, 1 << 31,
)  # fmt: skip
RXP, TXP, DXP, EOT, TXTF, UDR, OVR, CRCE, MODF, TSERF, SUSP, TXC, RXWNE = (
    1 << bit for bit in (0, 1, 2, 3, 4, 5, 6, 7, 9, 10, 11, 12, 15)
)
CLEARED_BY_IFCR = 0xFF8
KEPT = EOT | TXTF | UDR | OVR | CRCE | MODF | TSERF | SUSP  # flags that stay until they are cleared
I2SMOD = 1 << 0

NO_SLAVE = "a slave is not clocked by the edges at its pins"
NO_FORMAT = "TI mode and swapped pins are not modelled (SP, IOSWP): words go by the Motorola format"
NO_CHOICE = "UDRDET is not looked at: a slave finds out when a word begins that it has nothing to send"
NO_I2S = "I2S is not modelled: nothing is sent, nothing arrives"

REGISTERS = (
    Register("CR1", CR1, 0, 0x1_FF01, fidelity=Fidelity.PARTLY, note=NO_SLAVE),
    Register("CR2", CR2, 0),
    Register("CFG1", CFG1, 0x0007_0007, 0x705F_DFFF, UDRDET, fidelity=Fidelity.PARTLY, note=NO_CHOICE),
    Register("CFG2", CFG2, 0, 0xF7FE_80FF, IOSWP | SP, fidelity=Fidelity.PARTLY, note=NO_FORMAT),
    Register("IER", IER, 0, 0x7FF),
    Register("SR", SR, TXP | TXC, 0, fidelity=Fidelity.PARTLY, note="TIFRE is never set: TI mode is not modelled"),
    Register("IFCR", IFCR, 0, CLEARED_BY_IFCR),
    Register("TXDR", TXDR),
    Register("RXDR", RXDR, 0, 0),
    Register("CRCPOLY", CRCPOLY, 0x107),
    Register("TXCRC", TXCRC, 0, 0),
    Register("RXCRC", RXCRC, 0, 0),
    Register("UDRDR", UDRDR),
    Register("I2SCFGR", I2SCFGR, 0, 0x03FF_7FBF, I2SMOD, fidelity=Fidelity.PARTLY, note=NO_I2S),
)
