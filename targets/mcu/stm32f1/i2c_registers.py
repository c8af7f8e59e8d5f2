"""The registers of the I2C interfaces of the STM32F1 (RM0008 section 26.6)."""

from __future__ import annotations

from targets.mcu.fidelity import Fidelity
from targets.mcu.registers import Register

CR1, CR2, OAR1, OAR2, DR, SR1, SR2, CCR, TRISE = range(0x00, 0x24, 4)

PE, SMBUS, SMBTYPE, ENARP, ENPEC, ENGC, NOSTRETCH = (1 << bit for bit in (0, 1, 3, 4, 5, 6, 7))
START, STOP, ACK, POS, PEC, ALERT, SWRST = (1 << bit for bit in (8, 9, 10, 11, 12, 13, 15))
CLEARED_WITHOUT_PE = START | STOP | ACK | POS | PEC | ALERT
FREQ = 0x3F
ITERREN, ITEVTEN, ITBUFEN, DMAEN, LAST = (1 << bit for bit in range(8, 13))
ADDMODE, ENDUAL, ADDRESS = 1 << 15, 1 << 0, 0x00FE
SB, ADDR, BTF, ADD10, STOPF, RXNE, TXE = (1 << bit for bit in (0, 1, 2, 3, 4, 6, 7))
BERR, ARLO, AF, OVR, PECERR, TIMEOUT, SMBALERT = (1 << bit for bit in (8, 9, 10, 11, 12, 14, 15))
ERRORS, EVENTS = 0xDF00, SB | ADDR | BTF | ADD10 | STOPF
MSL, BUSY, TRA, GENCALL, SMBDEFAULT, SMBHOST, DUALF = (1 << bit for bit in (0, 1, 2, 4, 5, 6, 7))
OF_A_MESSAGE = TRA | GENCALL | SMBDEFAULT | SMBHOST | DUALF
PEC_VALUE, PEC_SHIFT = 0xFF00, 8

_OWN_NOTE = "only another interface of the chip, wired to both pins, reaches the slave"

REGISTERS = (
    Register("CR1", CR1, 0, 0xBFFB),
    Register("CR2", CR2, 0, 0x1F3F),
    Register("OAR1", OAR1, 0, 0xC3FF, fidelity=Fidelity.PARTLY, note=_OWN_NOTE),
    Register("OAR2", OAR2, 0, 0xFF, fidelity=Fidelity.PARTLY, note=_OWN_NOTE),
    Register("DR", DR, 0, 0xFF),
    Register("SR1", SR1, 0, ERRORS),
    Register("SR2", SR2, 0, 0),
    Register("CCR", CCR, 0, 0xCFFF),
    Register("TRISE", TRISE, 0x02, 0x3F, note="edges take no time"),
)
