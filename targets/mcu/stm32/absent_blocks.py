"""Peripherals of which several families have the same registers, and of which nothing but these is there.

Registers: RM0410 and RM0433, the register maps at the end of the sections. Values are kept as written; flags that
hardware would set stay clear, but the core resets of USB end at once, for a driver would hang before it has begun.
"""

from __future__ import annotations

from targets.mcu.stm32.absent import Absent, registers

__all__ = [
    "Cec",
    "Dcmi",
    "Dfsdm",
    "Dma2d",
    "Fmc",
    "Jpeg",
    "Ltdc",
    "Mdios",
    "Otg",
    "Quadspi",
    "Sai",
    "Spdif",
]


class Spdif(Absent):
    """The S/PDIF receiver: nothing arrives."""

    MISSING = "nothing arrives"
    REGISTERS = registers("CR IMR SR: IFCR DR: CSR: DIR:")


class Cec(Absent):
    """The HDMI-CEC controller: nothing is sent, nothing arrives."""

    MISSING = "nothing is sent, nothing arrives"
    REGISTERS = registers("CR CFGR TXDR RXDR: ISR: IER")


class Sai(Absent):
    """The serial audio interface: nothing is sent, nothing arrives."""

    MISSING = "nothing is sent, nothing arrives"
    REGISTERS = registers(
        "GCR ACR1=40 ACR2 AFRCR=7 ASLOTR AIM ASR=8: ACLRFR ADR BCR1=40 BCR2 BFRCR=7 BSLOTR BIM BSR=8: BCLRFR BDR"
    )


class Ltdc(Absent):
    """The display controller: no picture, no line."""

    MISSING = "no picture, no line"
    REGISTERS = registers(
        "@8 SSCR BPCR AWCR TWCR GCR=2220 @24 SRCR @2C BCCR @34 IER ISR: ICR LIPCR CPSR: CDSR=F: "
        "@84 L1CR L1WHPCR L1WVPCR L1CKCR L1PFCR L1CACR=FF L1DCCR L1BFCR=607 @AC L1CFBAR L1CFBLR L1CFBLNR @C4 L1CLUTWR "
        "@104 L2CR L2WHPCR L2WVPCR L2CKCR L2PFCR L2CACR=FF L2DCCR L2BFCR=607 @12C L2CFBAR L2CFBLR L2CFBLNR "
        "@144 L2CLUTWR"
    )


class Dfsdm(Absent):
    """The filters for sigma-delta modulators: no conversion ever ends."""

    MISSING = "no conversion ever ends"
    REGISTERS = (
        *(
            register
            for channel in range(8)
            for register in registers(
                f"@{0x20 * channel:X} CH{channel}CFGR1 CH{channel}CFGR2 CH{channel}AWSCDR CH{channel}WDATR: "
                f"CH{channel}DATINR"
            )
        ),
        *(
            register
            for number in range(4)
            for register in registers(
                f"@{0x100 + 0x80 * number:X} FLT{number}CR1 FLT{number}CR2 FLT{number}ISR=FF0000: FLT{number}ICR "
                f"FLT{number}JCHGR=1 FLT{number}FCR FLT{number}JDATAR: FLT{number}RDATAR: FLT{number}AWHTR "
                f"FLT{number}AWLTR FLT{number}AWSR: FLT{number}AWCFR FLT{number}EXMAX=80000000: "
                f"FLT{number}EXMIN=7FFFFF00: FLT{number}CNVTIMR:"
            )
        ),
    )


class Mdios(Absent):
    """The MDIO slave: nobody asks it."""

    MISSING = "nobody asks it"
    REGISTERS = registers(
        "CR WRFR: CWRFR RDFR: CRDFR SR: CLRFR "
        + " ".join(f"DINR{number}:" for number in range(32))
        + " "
        + " ".join(f"DOUTR{number}" for number in range(32))
    )


class Dma2d(Absent):
    """The graphics accelerator: no transfer ever ends."""

    size = 0xC00
    MISSING = "no transfer ever ends"
    REGISTERS = registers(
        "CR ISR: IFCR FGMAR FGOR BGMAR BGOR FGPFCCR FGCOLR BGPFCCR BGCOLR FGCMAR BGCMAR OPFCCR OCOLR OMAR OOR NLR LWR "
        "AMTCR"
    )


class Dcmi(Absent):
    """The camera interface: no picture arrives."""

    MISSING = "no picture arrives"
    REGISTERS = registers("CR SR: RISR: IER MISR: ICR ESCR ESUR CWSTRT CWSIZE DR:")


class Jpeg(Absent):
    """The JPEG codec: it does nothing. Its tables are left out."""

    size = 0x1000
    MISSING = "it does nothing"
    REGISTERS = registers("CONFR0 CONFR1 CONFR2 CONFR3 CONFR4 CONFR5 CONFR6 CONFR7 @30 CR SR=6: CFR @40 DIR DOR:")


class Fmc(Absent):
    """The controller of external memory: no memory answers where it would be."""

    MISSING = "no external memory is there"
    REGISTERS = registers(
        "BCR1=30DB BTR1=FFFFFFF BCR2=30D2 BTR2=FFFFFFF BCR3=30D2 BTR3=FFFFFFF BCR4=30D2 BTR4=FFFFFFF "
        "@80 PCR=18 SR=40 PMEM=FCFCFCFC PATT=FCFCFCFC @94 ECCR: "
        "@104 BWTR1=FFFFFFF @10C BWTR2=FFFFFFF @114 BWTR3=FFFFFFF @11C BWTR4=FFFFFFF "
        "@140 SDCR1=2D0 SDCR2=2D0 SDTR1=FFFFFFF SDTR2=FFFFFFF SDCMR SDRTR SDSR:"
    )


class Quadspi(Absent):
    """The interface of serial flash: no memory answers."""

    MISSING = "no memory answers"
    REGISTERS = registers("CR DCR SR: FCR DLR CCR AR ABR DR PSMKR PSMAR PIR LPTR")


class Otg(Absent):
    """A USB controller with nobody at the other end of its cable: no session, no frame, no packet.

    The registers of channels, endpoints and their FIFOs are left out.
    """

    size = 0x4_0000
    MISSING = "nobody is at the other end"
    GRSTCTL, IDLE, ENDS = 0x010, 1 << 31, 0x37
    REGISTERS = registers(
        "GOTGCTL=10000 GOTGINT GAHBCFG GUSBCFG=1440 GRSTCTL=80000000 GINTSTS=4000020 GINTMSK GRXSTSR: GRXSTSP: "
        "GRXFSIZ=200 HNPTXFSIZ=2000200 HNPTXSTS=80200: @38 GCCFG CID=2000: @54 GLPMCFG @100 HPTXFSIZ=2000600 "
        "DIEPTXF1=2000400 DIEPTXF2=2000400 DIEPTXF3=2000400 DIEPTXF4=2000400 DIEPTXF5=2000400 "
        "@400 HCFG HFIR=EA60 HFNUM=3FFF: @410 HPTXSTS=80100: HAINT: HAINTMSK @440 HPRT "
        "@800 DCFG=2200000 DCTL DSTS=10: @810 DIEPMSK DOEPMSK DAINT: DAINTMSK @834 DIEPEMPMSK @E00 PCGCCTL"
    )

    def write_GRSTCTL(self, value: int) -> None:
        """Every reset and flush ends at once, and the bus is idle."""
        self[self.GRSTCTL] = value & ~self.ENDS | self.IDLE
