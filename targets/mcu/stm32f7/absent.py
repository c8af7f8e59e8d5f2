"""What an STM32F767 has and this model lacks: registers with their reset values; whoever uses them is told.

Values are kept as written. Flags that hardware would set stay clear, but for those whose absence would hang a driver
before it has begun: CAN enters and leaves its modes at once, the core resets of USB and the software reset of the
Ethernet's DMA end at once, and so does an access to a PHY, which finds none.

Registers: RM0410, the register maps at the end of the sections.
"""

from __future__ import annotations

from typing import ClassVar

from targets.mcu.registers import Peripheral, Register
from targets.mcu.services import Services
from targets.mcu.stm32.absent import Absent, Can, registers

__all__ = ["absent_peripherals"]


class Spi(Absent):
    """An SPI or I2S interface: the transmit buffer is always empty, nothing arrives."""

    MISSING = "nothing is sent, nothing arrives"
    REGISTERS = registers("CR1 CR2=700 SR=2: DR CRCPR=7 RXCRCR: TXCRCR: I2SCFGR I2SPR=2")


class LowPowerTimer(Absent):
    """The low-power timer: it does not count."""

    MISSING = "it does not count"
    REGISTERS = registers("ISR: ICR IER CFGR CR CMP ARR=1 CNT:")


class Spdif(Absent):
    """The S/PDIF receiver: nothing arrives."""

    MISSING = "nothing arrives"
    REGISTERS = registers("CR IMR SR: IFCR DR: CSR: DIR:")


class Cec(Absent):
    """The HDMI-CEC controller: nothing is sent, nothing arrives."""

    MISSING = "nothing is sent, nothing arrives"
    REGISTERS = registers("CR CFGR TXDR RXDR: ISR: IER")


class Dac(Absent):
    """The converters to analog: the outputs stay at 0 V."""

    MISSING = "the outputs stay at 0 V"
    REGISTERS = registers(
        "CR SWTRIGR DHR12R1 DHR12L1 DHR8R1 DHR12R2 DHR12L2 DHR8R2 DHR12RD DHR12LD DHR8RD DOR1: DOR2: SR:"
    )


class Sdmmc(Absent):
    """The SD card interface: no card answers, and no timeout ends."""

    MISSING = "no card answers"
    REGISTERS = registers(
        "POWER CLKCR ARG CMD RESPCMD: RESP1: RESP2: RESP3: RESP4: DTIMER DLEN DCTRL DCOUNT: STA: ICR MASK "
        "@48 FIFOCNT: @80 FIFO"
    )


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


class Ethernet(Absent):
    """The Ethernet controller: no cable is plugged in, no PHY answers."""

    size = 0x1400
    MISSING = "no PHY answers, no frame is sent or arrives"
    DMABMR, SR = 0x1000, 1 << 0
    MACMIIAR, BUSY, WRITE, MACMIIDR = 0x10, 1 << 0, 1 << 1, 0x14
    REGISTERS = registers(
        "MACCR=8000 MACFFR MACHTHR MACHTLR MACMIIAR MACMIIDR MACFCR MACVLANTR @28 MACRWUFFR MACPMTCSR @34 MACDBGR: "
        "MACSR: MACIMR MACA0HR=8010FFFF MACA0LR=FFFFFFFF MACA1HR=FFFF MACA1LR=FFFFFFFF MACA2HR=FFFF MACA2LR=FFFFFFFF "
        "MACA3HR=FFFF MACA3LR=FFFFFFFF @100 MMCCR MMCRIR: MMCTIR: MMCRIMR MMCTIMR @14C MMCTGFSCCR: MMCTGFMSCCR: "
        "@168 MMCTGFCR: @194 MMCRFCECR: MMCRFAECR: @1C4 MMCRGUFCR: @700 PTPTSCR=2000 PTPSSIR PTPTSHR: PTPTSLR: "
        "PTPTSHUR PTPTSLUR PTPTSAR PTPTTHR PTPTTLR @728 PTPTSSR: PTPPPSCR @1000 DMABMR=20101 DMATPDR DMARPDR DMARDLAR "
        "DMATDLAR DMASR DMAOMR DMAIER DMAMFBOCR: DMARSWTR @1048 DMACHTDR: DMACHRDR: DMACHTBAR: DMACHRBAR:"
    )

    def write_DMABMR(self, value: int) -> None:
        """The software reset ends at once."""
        self[self.DMABMR] = value & ~self.SR

    def write_MACMIIAR(self, value: int) -> None:
        """An access to a PHY ends at once; a read finds the pull-up of MDIO."""
        self[self.MACMIIAR] = value & ~self.BUSY
        if value & self.BUSY and not value & self.WRITE:
            self[self.MACMIIDR] = 0xFFFF


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


class Can28(Can):
    """bxCAN with the filter banks of two controllers."""

    REGISTERS: ClassVar[tuple[Register, ...]] = (
        *Can.REGISTERS,
        *(Register(f"F{bank}R{half}", 0x23C + 8 * bank + 4 * half) for bank in range(14, 28) for half in (1, 2)),
    )


_WHERE: tuple[tuple[type[Absent], str, int], ...] = (
    (LowPowerTimer, "LPTIM1", 0x4000_2400),
    (Can, "CAN3", 0x4000_3400),
    (Spi, "SPI2", 0x4000_3800),
    (Spi, "SPI3", 0x4000_3C00),
    (Spdif, "SPDIFRX", 0x4000_4000),
    (Can28, "CAN1", 0x4000_6400),
    (Can28, "CAN2", 0x4000_6800),
    (Cec, "CEC", 0x4000_6C00),
    (Dac, "DAC", 0x4000_7400),
    (Sdmmc, "SDMMC2", 0x4001_1C00),
    (Sdmmc, "SDMMC1", 0x4001_2C00),
    (Spi, "SPI1", 0x4001_3000),
    (Spi, "SPI4", 0x4001_3400),
    (Spi, "SPI5", 0x4001_5000),
    (Spi, "SPI6", 0x4001_5400),
    (Sai, "SAI1", 0x4001_5800),
    (Sai, "SAI2", 0x4001_5C00),
    (Ltdc, "LTDC", 0x4001_6800),
    (Dfsdm, "DFSDM1", 0x4001_7400),
    (Mdios, "MDIOS", 0x4001_7800),
    (Ethernet, "ETH", 0x4002_8000),
    (Dma2d, "DMA2D", 0x4002_B000),
    (Otg, "USB_OTG_HS", 0x4004_0000),
    (Otg, "USB_OTG_FS", 0x5000_0000),
    (Dcmi, "DCMI", 0x5005_0000),
    (Jpeg, "JPEG", 0x5005_1000),
    (Fmc, "FMC", 0xA000_0000),
    (Quadspi, "QUADSPI", 0xA000_1000),
)


def absent_peripherals(services: Services) -> list[Peripheral]:
    """Return everything of the STM32F767 that is not modelled, at its address (RM0410 table 1)."""
    return [kind(name, base, services) for kind, name, base in _WHERE]
