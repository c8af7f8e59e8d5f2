"""The registers of a 16-bit ADC and their bits (RM0433 section 25.5)."""

from __future__ import annotations

from targets.mcu.fidelity import Fidelity
from targets.mcu.registers import Register

__all__ = ["REGISTERS"]

ISR, IER, CR, CFGR, CFGR2, SMPR1, SMPR2, PCSEL, LTR1, HTR1 = range(0x00, 0x28, 4)
SQR1, SQR2, SQR3, SQR4, DR, JSQR = 0x30, 0x34, 0x38, 0x3C, 0x40, 0x4C
OFR1, JDR1, AWD2CR, AWD3CR, LTR2, HTR2, LTR3, HTR3 = 0x60, 0x80, 0xA0, 0xA4, 0xB0, 0xB4, 0xB8, 0xBC
DIFSEL, CALFACT, CALFACT2 = 0xC0, 0xC4, 0xC8

ADRDY, EOSMP, EOC, EOS, OVR, JEOC, JEOS, AWD1, AWD2, AWD3, JQOVF = (1 << bit for bit in range(11))
LDORDY = 1 << 12
FLAGS = 0x7FF  # those that software clears, and that interrupt

ADEN, ADDIS, ADSTART, JADSTART, ADSTP, JADSTP = (1 << bit for bit in range(6))
BOOST, ADCALLIN, LINCALRDYW, ADVREGEN, DEEPPWD, ADCALDIF, ADCAL = (
    3 << 8,
    1 << 16,
    0x3F << 22,
    *(1 << bit for bit in range(28, 32)),
)
SET_ONLY = ADEN | ADDIS | ADSTART | JADSTART | ADSTP | JADSTP | ADCAL

DMNGT, OVRMOD, CONT, AUTDLY, DISCEN = 3, *(1 << bit for bit in (12, 13, 14, 16))
JDISCEN, JQM, AWD1SGL, AWD1EN, JAWD1EN, JAUTO, JQDIS = (1 << bit for bit in (20, 21, 22, 23, 24, 25, 31))
ROVSE, JOVSE, TROVS, ROVSM, RSHIFTS = 1 << 0, 1 << 1, 1 << 9, 1 << 10, 0xF << 11

THRESHOLD = 0x03FF_FFFF
SSATE = 1 << 31
CHANNELS = 0x000F_FFFF

_OVERSAMPLING = "injected conversions are not oversampled, and RSHIFT1 to RSHIFT4 are remembered without effect"
_QUEUE = "the queue of injected sequences (JQDIS clear, JQM) is not modelled: JSQR counts when it is written"
_FACTORS = "the converter is ideal: the factors are kept and change nothing"

REGISTERS = (
    Register("ISR", ISR, 0, FLAGS),
    Register("IER", IER, 0, FLAGS),
    Register("CR", CR, DEEPPWD, 0xFFC1_033F),
    Register("CFGR", CFGR, JQDIS, ignored=JQM, fidelity=Fidelity.PARTLY, note=_QUEUE),
    Register("CFGR2", CFGR2, 0, 0xF3FF_7FE3, ignored=JOVSE | RSHIFTS, fidelity=Fidelity.PARTLY, note=_OVERSAMPLING),
    Register("SMPR1", SMPR1, 0, 0x3FFF_FFFF),
    Register("SMPR2", SMPR2, 0, 0x3FFF_FFFF),
    Register("PCSEL", PCSEL, 0, CHANNELS),
    Register("LTR1", LTR1, 0, THRESHOLD),
    Register("HTR1", HTR1, THRESHOLD, THRESHOLD),
    Register("SQR1", SQR1, 0, 0x1F7D_F7CF),
    Register("SQR2", SQR2, 0, 0x1F7D_F7DF),
    Register("SQR3", SQR3, 0, 0x1F7D_F7DF),
    Register("SQR4", SQR4, 0, 0x07DF),
    Register("DR", DR, 0, 0),
    Register("JSQR", JSQR, 0, 0xFBEF_BFFF),
    *(Register(f"OFR{number + 1}", OFR1 + 4 * number) for number in range(4)),
    *(Register(f"JDR{number + 1}", JDR1 + 4 * number, 0, 0) for number in range(4)),
    Register("AWD2CR", AWD2CR, 0, CHANNELS),
    Register("AWD3CR", AWD3CR, 0, CHANNELS),
    Register("LTR2", LTR2, 0, THRESHOLD),
    Register("HTR2", HTR2, THRESHOLD, THRESHOLD),
    Register("LTR3", LTR3, 0, THRESHOLD),
    Register("HTR3", HTR3, THRESHOLD, THRESHOLD),
    Register(
        "DIFSEL",
        DIFSEL,
        0,
        CHANNELS,
        CHANNELS,
        fidelity=Fidelity.PARTLY,
        note="differential inputs are not modelled: the positive input alone counts",
    ),
    Register("CALFACT", CALFACT, 0, 0x07FF_07FF, fidelity=Fidelity.PARTLY, note=_FACTORS),
    Register("CALFACT2", CALFACT2, 0, 0x3FFF_FFFF, fidelity=Fidelity.PARTLY, note=_FACTORS),
)
