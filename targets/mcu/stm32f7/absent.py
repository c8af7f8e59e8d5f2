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
from targets.mcu.stm32.absent_blocks import (
    Cec,
    Dcmi,
    Dfsdm,
    Dma2d,
    Fmc,
    Jpeg,
    Ltdc,
    Mdios,
    Otg,
    Quadspi,
    Sai,
    Spdif,
)

__all__ = ["absent_peripherals"]


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


class Can28(Can):
    """bxCAN with the filter banks of two controllers."""

    REGISTERS: ClassVar[tuple[Register, ...]] = (
        *Can.REGISTERS,
        *(Register(f"F{bank}R{half}", 0x23C + 8 * bank + 4 * half) for bank in range(14, 28) for half in (1, 2)),
    )


_WHERE: tuple[tuple[type[Absent], str, int], ...] = (
    (Can, "CAN3", 0x4000_3400),
    (Spdif, "SPDIFRX", 0x4000_4000),
    (Can28, "CAN1", 0x4000_6400),
    (Can28, "CAN2", 0x4000_6800),
    (Cec, "CEC", 0x4000_6C00),
    (Dac, "DAC", 0x4000_7400),
    (Sdmmc, "SDMMC2", 0x4001_1C00),
    (Sdmmc, "SDMMC1", 0x4001_2C00),
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
