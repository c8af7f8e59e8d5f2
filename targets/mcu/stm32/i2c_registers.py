"""The registers of an I2C interface with TIMINGR (RM0410 section 33.7)."""

from __future__ import annotations

from targets.mcu.fidelity import Fidelity
from targets.mcu.registers import Register

CR1, CR2, OAR1, OAR2, TIMINGR, TIMEOUTR, ISR, ICR, PECR, RXDR, TXDR = range(0, 0x2C, 4)

PE, TXIE, RXIE, ADDRIE, NACKIE, STOPIE, TCIE, ERRIE = (1 << bit for bit in range(8))
TXDMAEN, RXDMAEN = 1 << 14, 1 << 15
PECEN = 1 << 23
FILTERS = 0x1F00
OAEN = 1 << 15
OA1, OA1_10, OA2 = 0x00FE, 0x03FF, 0x07FE  # with the mask of OA2: a masked address 0 answers to others
OA1MODE = 1 << 10
_SLAVE_CR1 = 0x007B_0008  # ADDRIE, SBC, NOSTRETCH, GCEN, SMBHEN, SMBDEN, ALERTEN

RD_WRN, ADD10, HEAD10R, START, STOP, NACK = (1 << bit for bit in range(10, 16))
RELOAD, AUTOEND, PECBYTE = 1 << 24, 1 << 25, 1 << 26
ONLY_SET = START | STOP | NACK | PECBYTE

TXE, TXIS, RXNE, ADDR, NACKF, STOPF, TC, TCR, BERR, ARLO, OVR, PECERR, TIMEOUT, ALERT = (1 << bit for bit in range(14))
BUSY = 1 << 15
CLEARED_BY_ICR = ADDR | NACKF | STOPF | BERR | ARLO | OVR | PECERR | TIMEOUT | ALERT
ERRORS = BERR | ARLO | OVR | PECERR | TIMEOUT | ALERT

SAME_BIT = TXIE | RXIE | ADDRIE | NACKIE | STOPIE | TCIE
"""Interrupt enables of CR1 that stand at the bit of their flag in ISR."""

SLAVE_NOTE = "the slave mode is not modelled"
_OWN_NOTE = f"is kept and has no effect: {SLAVE_NOTE}"

REGISTERS = (
    Register(
        "CR1",
        CR1,
        0,
        0x00FB_DFFF,
        _SLAVE_CR1 & ~ADDRIE,
        fidelity=Fidelity.PARTLY,
        note=f"master only: {SLAVE_NOTE}; the levels of SCL and SDA do not move",
    ),
    Register("CR2", CR2, 0, 0x07FF_FFFF),
    Register("OAR1", OAR1, 0, 0x87FF, fidelity=Fidelity.PARTLY, note=f"{_OWN_NOTE}; own address 0 is not noted"),
    Register("OAR2", OAR2, 0, 0x87FE, fidelity=Fidelity.PARTLY, note=_OWN_NOTE),
    Register("TIMINGR", TIMINGR, 0, 0xF0FF_FFFF),
    Register(
        "TIMEOUTR",
        TIMEOUTR,
        0,
        0x8FFF_9FFF,
        0x8000_1000,
        fidelity=Fidelity.PARTLY,
        note="TIDLE and TEXTEN have no effect: SCL low for too long is the only timeout",
    ),
    Register("ISR", ISR, TXE, TXE | TXIS),
    Register("ICR", ICR, 0, CLEARED_BY_ICR),
    Register("PECR", PECR, 0, 0),
    Register("RXDR", RXDR, 0, 0),
    Register("TXDR", TXDR, 0, 0xFF),
)
