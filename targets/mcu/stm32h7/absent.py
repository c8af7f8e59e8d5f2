"""What an STM32H743 or H753 has and this model lacks: registers with reset values; whoever uses them is told.

Values are kept as written. Flags that hardware would set stay clear, but for those whose absence would hang a driver
before it has begun: the core resets of USB and the software reset of the Ethernet's DMA end at once, so does an access
to a PHY, which finds none, and the reference buffer is ready at once. FDCAN goes to and leaves its initialisation mode
as written.

Registers: RM0433, the register maps at the end of the sections, as far as ST's header stm32h753xx.h has them.
"""

from __future__ import annotations

from targets.mcu.registers import Peripheral
from targets.mcu.services import Services
from targets.mcu.stm32.absent import Absent, registers
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
from targets.mcu.stm32h7.absent_ethernet import Ethernet
from targets.mcu.stm32h7.absent_timing import HighResolutionTimer

__all__ = ["absent_peripherals"]


def _each(count: int, base: int, step: int, text: str) -> str:
    """Return `text` for each of some equal groups, with their numbers for ``#``."""
    return " ".join(f"@{base + step * number:X} {text.replace('#', str(number))}" for number in range(count))


class Fdcan(Absent):
    """A CAN controller with flexible data rate, alone on its bus: nothing is sent, nothing arrives."""

    MISSING = "nothing is sent, nothing arrives"
    REGISTERS = registers(
        "CREL=32141218: ENDN=87654321: @C DBTP=A33 TEST RWD CCCR=1 NBTP=6000A03 TSCC TSCV TOCC=FFFF0000 TOCV=FFFF "
        "@40 ECR: PSR=707 TDCR @50 IR IE ILS ILE @80 GFC SIDFC XIDFC @90 XIDAM=1FFFFFFF HPMS: NDAT1 NDAT2 "
        "RXF0C RXF0S: RXF0A RXBC RXF1C RXF1S: RXF1A RXESC TXBC TXFQS: TXESC TXBRP: TXBAR TXBCR TXBTO: TXBCF: "
        "TXBTIE TXBCIE @F0 TXEFC TXEFS: TXEFA"
    )


class TimeTriggeredFdcan(Fdcan):
    """FDCAN1, which has time-triggered CAN as well."""

    REGISTERS = (
        *Fdcan.REGISTERS,
        *registers(
            "@100 TTTMC TTRMC TTOCF=10000 TTMLM TURCF=10000000 TTOCN TTGTP TTTMK TTIR TTIE TTILS TTOST: TURNA: TTLGT: "
            "TTCTC: TTCPT: TTCSM: @300 TTTS"
        ),
    )


class CanClock(Absent):
    """The clock calibration unit of the CAN controllers."""

    MISSING = "the clock is passed on as it is"
    REGISTERS = registers("CREL: CCFG=4 CSTAT: CWD IR IE")


class CanRam(Absent):
    """The 10 KB of message RAM: nothing is kept there."""

    size = 0x2800
    MISSING = "message RAM keeps nothing"
    REGISTERS = registers("RAM:")


class Swpmi(Absent):
    """The single wire interface: nothing is sent, nothing arrives."""

    MISSING = "nothing is sent, nothing arrives"
    REGISTERS = registers("CR BRR=1 @C ISR=2C2: ICR IER RFL: TDR RDR: OR")


class Crs(Absent):
    """The recovery of HSI48 from USB: it is exact already."""

    MISSING = "HSI48 is exact already"
    REGISTERS = registers("CR=2000 CFGR=2022BB7F ISR: ICR")


class Opamp(Absent):
    """The operational amplifiers: their outputs do nothing."""

    MISSING = "the outputs do nothing"
    REGISTERS = registers("OPAMP1_CSR OPAMP1_OTR OPAMP1_HSOTR OR @10 OPAMP2_CSR OPAMP2_OTR OPAMP2_HSOTR")


class Comp(Absent):
    """The comparators: the outputs stay low."""

    MISSING = "the outputs stay low"
    REGISTERS = registers("SR: ICFR OR CFGR1 CFGR2")


class Vrefbuf(Absent):
    """The reference buffer: the reference stays the supply."""

    MISSING = "the reference stays the supply"
    CSR, ENVR, VRR = 0x00, 1 << 0, 1 << 3
    REGISTERS = registers("CSR=2 CCR")

    def write_CSR(self, value: int) -> None:
        """VRR follows ENVR."""
        self[self.CSR] = value | self.VRR if value & self.ENVR else value & ~self.VRR


class Dac(Absent):
    """The converters to analog: the outputs stay at 0 V."""

    MISSING = "the outputs stay at 0 V"
    REGISTERS = registers(
        "CR SWTRGR DHR12R1 DHR12L1 DHR8R1 DHR12R2 DHR12L2 DHR8R2 DHR12RD DHR12LD DHR8RD DOR1: DOR2: SR: CCR MCR SHSR1 "
        "SHSR2 SHHR=10001 SHRR=10001"
    )


class Sdmmc(Absent):
    """The SD card interface: no card answers, and no timeout ends."""

    MISSING = "no card answers"
    REGISTERS = registers(
        "POWER CLKCR ARG CMD RESPCMD: RESP1: RESP2: RESP3: RESP4: DTIMER DLEN DCTRL DCOUNT: STA: ICR MASK ACKTIME "
        "@50 IDMACTRL IDMABSIZE IDMABASE0 IDMABASE1 @80 FIFO"
    )


class DelayBlock(Absent):
    """A delay block: clocks are not delayed."""

    MISSING = "clocks are not delayed"
    REGISTERS = registers("CR CFGR")


class SaiWithPdm(Sai):
    """The serial audio interface with one for microphones."""

    REGISTERS = (*Sai.REGISTERS, *registers("@44 PDMCR PDMDLY"))


class Mdma(Absent):
    """The master DMA controller: no transfer ever ends."""

    size = 0x1000
    MISSING = "no transfer ever ends"
    REGISTERS = registers(
        f"GISR0: {_each(16, 0x40, 0x40, 'C#ISR: C#IFCR C#ESR: C#CR C#TCR C#BNDTR C#SAR C#DAR C#BRUR C#LAR C#TBR')} "
        f"{_each(16, 0x70, 0x40, 'C#MAR C#MDR')}"
    )


class Bdma(Absent):
    """The DMA controller of domain D3: no transfer ever ends."""

    MISSING = "no transfer ever ends"
    REGISTERS = registers("ISR: IFCR " + _each(8, 0x08, 0x14, "CCR# CNDTR# CPAR# CM0AR# CM1AR#"))


class Dmamux2(Absent):
    """The multiplexer of requests for BDMA: it passes none on."""

    MISSING = "BDMA is not modelled"
    REGISTERS = registers(f"{_each(8, 0, 4, 'C#CR')} @80 CSR: CFR {_each(8, 0x100, 4, 'RG#CR')} @140 RGSR: RGCFR")


class Cryp(Absent):
    """The cryptographic processor: nothing is computed."""

    MISSING = "nothing is computed"
    REGISTERS = registers(
        "CR SR=3: DIN DOUT: DMACR IMSCR RISR=1: MISR: K0LR K0RR K1LR K1RR K2LR K2RR K3LR K3RR IV0LR IV0RR IV1LR IV1RR "
        f"{_each(8, 0x50, 4, 'CSGCMCCM#R')} {_each(8, 0x70, 4, 'CSGCM#R')}"
    )


class Hash(Absent):
    """The hash processor: nothing is computed."""

    MISSING = "nothing is computed"
    REGISTERS = registers(
        f"CR DIN STR HRA0: HRA1: HRA2: HRA3: HRA4: IMR SR=1 {_each(54, 0xF8, 4, 'CSR#')} {_each(8, 0x310, 4, 'HR#:')}"
    )


class Ramecc(Absent):
    """A monitor of the error correction of RAM: there are no errors."""

    MISSING = "there are no errors"
    REGISTERS = registers(f"IER {_each(5, 0x20, 0x20, 'M#CR M#SR M#FAR: M#FDRL: M#FDRH: M#FECR:')}")


class AxiInterconnect(Absent):
    """The interconnect: all masters are served alike. Ports are counted from 0 here, from 1 in the manual."""

    size = 0x10_0000
    MISSING = "all masters are served alike"
    REGISTERS = registers(
        "@1FD0 PERIPH_ID_4=4: @1FE0 PERIPH_ID_0: PERIPH_ID_1=B4: PERIPH_ID_2=2B: "
        f"{_each(7, 0x2008, 0x1000, 'TARG#_FN_MOD_ISS_BM')} {_each(7, 0x2024, 0x1000, 'TARG#_FN_MOD2')} "
        f"{_each(7, 0x202C, 0x1000, 'TARG#_FN_MOD_LB')} {_each(7, 0x2108, 0x1000, 'TARG#_FN_MOD')} "
        f"{_each(6, 0x42024, 0x1000, 'INI#_FN_MOD2 INI#_FN_MOD_AHB')} "
        f"{_each(6, 0x42100, 0x1000, 'INI#_READ_QOS=4 INI#_WRITE_QOS=4 INI#_FN_MOD')}"
    )


_WHERE: tuple[tuple[type[Absent], str, int], ...] = (
    (Spdif, "SPDIFRX", 0x4000_4000),
    (Cec, "CEC", 0x4000_6C00),
    (Dac, "DAC", 0x4000_7400),
    (Crs, "CRS", 0x4000_8400),
    (Swpmi, "SWPMI1", 0x4000_8800),
    (Opamp, "OPAMP", 0x4000_9000),
    (Mdios, "MDIOS", 0x4000_9400),
    (TimeTriggeredFdcan, "FDCAN1", 0x4000_A000),
    (Fdcan, "FDCAN2", 0x4000_A400),
    (CanClock, "CAN_CCU", 0x4000_A800),
    (CanRam, "SRAMCAN", 0x4000_AC00),
    (SaiWithPdm, "SAI1", 0x4001_5800),
    (Sai, "SAI2", 0x4001_5C00),
    (Sai, "SAI3", 0x4001_6000),
    (Dfsdm, "DFSDM1", 0x4001_7000),
    (HighResolutionTimer, "HRTIM", 0x4001_7400),
    (Ethernet, "ETH", 0x4002_8000),
    (Otg, "USB1_OTG_HS", 0x4004_0000),
    (Otg, "USB2_OTG_HS", 0x4008_0000),
    (Dcmi, "DCMI", 0x4802_0000),
    (Sdmmc, "SDMMC2", 0x4802_2400),
    (DelayBlock, "DLYB_SDMMC2", 0x4802_2800),
    (Ramecc, "RAMECC2", 0x4802_3000),
    (Ltdc, "LTDC", 0x5000_1000),
    (AxiInterconnect, "AXI", 0x5100_0000),
    (Mdma, "MDMA", 0x5200_0000),
    (Dma2d, "DMA2D", 0x5200_1000),
    (Jpeg, "JPEG", 0x5200_3000),
    (Fmc, "FMC", 0x5200_4000),
    (Quadspi, "QUADSPI", 0x5200_5000),
    (DelayBlock, "DLYB_QUADSPI", 0x5200_6000),
    (Sdmmc, "SDMMC1", 0x5200_7000),
    (DelayBlock, "DLYB_SDMMC1", 0x5200_8000),
    (Ramecc, "RAMECC1", 0x5200_9000),
    (Comp, "COMP", 0x5800_3800),
    (Vrefbuf, "VREFBUF", 0x5800_3C00),
    (SaiWithPdm, "SAI4", 0x5800_5400),
    (Bdma, "BDMA", 0x5802_5400),
    (Dmamux2, "DMAMUX2", 0x5802_5800),
    (Ramecc, "RAMECC3", 0x5802_7000),
)
_OF_H753: tuple[tuple[type[Absent], str, int], ...] = ((Cryp, "CRYP", 0x4802_1000), (Hash, "HASH", 0x4802_1400))


def absent_peripherals(services: Services, *, crypto: bool) -> list[Peripheral]:
    """Return everything that is not modelled, at its address (RM0433 section 2.3); `crypto`: of an STM32H753."""
    where = (*_WHERE, *_OF_H753) if crypto else _WHERE
    return [kind(name, base, services) for kind, name, base in where]
