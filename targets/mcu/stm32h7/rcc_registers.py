"""The registers of RCC of the STM32H743 and H753 with the bits that can be written (RM0433 section 8.7).

Offsets and bits agree with ST's header stm32h753xx.h. Reset values are the manual's; where its revisions differ, CR is
what a chip of revision V is after a reset.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from targets.mcu.fidelity import Fidelity
from targets.mcu.registers import Register
from targets.mcu.stm32.mco import FAST_CLOCKS
from targets.mcu.stm32.rcc import BDCR_BITS, LSION

__all__ = ["ALIAS", "ALIASED", "CAUSES", "ENABLE_OF", "REGISTERS", "RESET_FLAGS", "RESET_OF"]

CR, HSICFGR, CRRCR, CSICFGR, CFGR = 0x00, 0x04, 0x08, 0x0C, 0x10
D1CFGR, D2CFGR, D3CFGR, PLLCKSELR, PLLCFGR = 0x18, 0x1C, 0x20, 0x28, 0x2C
PLLDIVR, PLLFRACR = (0x30, 0x38, 0x40), (0x34, 0x3C, 0x44)
D1CCIPR, D2CCIP1R, D2CCIP2R, D3CCIPR = 0x4C, 0x50, 0x54, 0x58
CIER, CIFR, CICR, BDCR, CSR = 0x60, 0x64, 0x68, 0x70, 0x74
GCR, D3AMR, RSR = 0xA0, 0xA8, 0xD0

HSION, HSIKERON, HSIRDY, HSIDIV, HSIDIVF = 1 << 0, 1 << 1, 1 << 2, 3 << 3, 1 << 5
CSION, CSIRDY, CSIKERON, HSI48ON, HSI48RDY = 1 << 7, 1 << 8, 1 << 9, 1 << 12, 1 << 13
D1CKRDY, D2CKRDY = 1 << 14, 1 << 15
HSEON, HSERDY, HSEBYP, HSECSSON = 1 << 16, 1 << 17, 1 << 18, 1 << 19
PLLON, PLLRDY = (1 << 24, 1 << 26, 1 << 28), (1 << 25, 1 << 27, 1 << 29)
CR_BITS = (
    HSION | HSIKERON | HSIDIV | CSION | CSIKERON | HSI48ON | HSEON | HSEBYP | HSECSSON | PLLON[0] | PLLON[1] | PLLON[2]
)
SW, STOPWUCK, TIMPRE = 0x7, 1 << 6, 1 << 15
LSEDRV, LSECSSON = 3 << 3, 1 << 5
HSECSSF = 1 << 10
RMVF = 1 << 16

_BUSES = ("AHB3", "AHB1", "AHB2", "AHB4", "APB3", "APB1L", "APB1H", "APB2", "APB4")
RESET_OF: Mapping[int, str] = MappingProxyType({0x7C + 4 * index: bus for index, bus in enumerate(_BUSES)})
"""The bus of a reset register, by its offset."""
ENABLE_OF: Mapping[str, int] = MappingProxyType({bus: 0xD4 + 4 * index for index, bus in enumerate(_BUSES)})
"""Offset of the enable register of a bus."""
_LOW_POWER = {bus: 0xFC + 4 * index for index, bus in enumerate(_BUSES)}
CPU_RESET_AT, CPU_RESET = 0x7C, 1 << 31  # in AHB3RSTR
ALIAS, ALIASED = 0x60, range(0xD0, 0x120, 4)
"""Distance to the same register again for CPU 1, and which registers have that."""

_ENABLES = {
    "AHB3": 0x0001_5031,  # MDMA, DMA2D, JPEG, FMC, QUADSPI, SDMMC1
    "AHB1": 0x1E03_8023,  # DMA1-2, ADC1-2, Ethernet with its two lines, USB1 and USB2 with ULPI
    "AHB2": 0xE000_0271,  # DCMI, CRYP, HASH, RNG, SDMMC2, SRAM1-3
    "AHB4": 0x1328_07FF,  # GPIOA-K, CRC, BDMA, ADC3, HSEM, backup SRAM
    "APB3": 0x0000_0048,  # LTDC, WWDG1
    "APB1L": 0xE8FF_C3FF,  # TIM2-7, 12-14, LPTIM1, SPI2-3, SPDIFRX, USART2-3, UART4-5, I2C1-3, CEC, DAC, UART7-8
    "APB1H": 0x0000_0136,  # CRS, SWPMI, OPAMP, MDIOS, FDCAN
    "APB2": 0x31D7_3033,  # TIM1, 8, 15-17, USART1, 6, SPI1, 4, 5, SAI1-3, DFSDM1, HRTIM
    "APB4": 0x0021_DEAA,  # SYSCFG, LPUART1, SPI6, I2C4, LPTIM2-5, COMP, VREFBUF, RTC, SAI4
}
_RESETS = {  # no reset of lines, of memories, of the window watchdog and the RTC; one of the CPU
    **_ENABLES,
    "AHB3": _ENABLES["AHB3"] | CPU_RESET,
    "AHB1": 0x0A00_8023,
    "AHB2": 0x0000_0271,
    "AHB4": 0x0328_07FF,
    "APB3": 0x0000_0008,
    "APB4": 0x0020_DEAA,
}
_MORE_LOW_POWER = {"AHB3": 0xF000_0100, "AHB4": 1 << 29}  # flash, DTCM, ITCM, AXI SRAM; SRAM4
RTCAPBEN = 1 << 16

# RM0433 section 8.4.4, the table of what identifies a reset: with each reset of the system comes that of the CPU, and
# NRST is pulled low. What leaving Standby sets is a choice: both domains, and the CPU.
CPU, D1, D2, BOR, PIN, POR = 1 << 17, 1 << 19, 1 << 20, 1 << 21, 1 << 22, 1 << 23
CAUSES: Mapping[str, int] = MappingProxyType(
    {
        "PIN": PIN | CPU,
        "POR": POR | PIN | BOR | D2 | D1 | CPU,
        "STANDBY": D2 | D1 | CPU,
        "SFT": 1 << 24 | PIN | CPU,
        "IWDG": 1 << 26 | PIN | CPU,
        "WWDG": 1 << 28 | PIN | CPU,
        "LPWR": 1 << 30 | PIN | CPU,
    }
)
"""The flags of RSR that each cause sets."""
RESET_FLAGS = 0x55FA_0000

_PARTLY, _ABSENT = Fidelity.PARTLY, Fidelity.ABSENT


def _of_buses() -> tuple[Register, ...]:
    found = []
    for bus in _BUSES:
        enables, note = _ENABLES[bus], "gates of memories, of ULPI and Ethernet lines are remembered"
        fidelity = _PARTLY if bus.startswith("AHB") else Fidelity.MODELLED
        reset_at = next(offset for offset, name in RESET_OF.items() if name == bus)
        found.append(Register(f"{bus}RSTR", reset_at, 0, _RESETS[bus]))
        reset = RTCAPBEN if bus == "APB4" else 0
        found.append(Register(f"{bus}ENR", ENABLE_OF[bus], reset, enables, fidelity=fidelity, note=note))
        bits = enables | _MORE_LOW_POWER.get(bus, 0)
        text = "clocks run on in Sleep mode"
        found.append(Register(f"{bus}LPENR", _LOW_POWER[bus], bits, bits, fidelity=_ABSENT, note=text))
    return tuple(found)


def _of_plls() -> tuple[Register, ...]:
    return tuple(
        register
        for index in range(3)
        for register in (
            Register(f"PLL{index + 1}DIVR", PLLDIVR[index], 0x0101_0280, 0x7F7F_FFFF),
            Register(f"PLL{index + 1}FRACR", PLLFRACR[index], 0, 0xFFF8),
        )
    )


def _registers() -> tuple[Register, ...]:
    own = (
        Register(
            "CR",
            CR,
            HSION | HSIRDY | HSIDIVF | D1CKRDY | D2CKRDY,
            CR_BITS,
            fidelity=_PARTLY,
            note="the clocks of D1 and D2 are always ready; HSIKERON and CSIKERON are remembered",
        ),
        Register("HSICFGR", HSICFGR, 0x4000_0000, 0x7F00_0000, fidelity=_PARTLY, note="HSI stays at exactly 64 MHz"),
        Register("CRRCR", CRRCR, 0, 0, note="HSI48CAL reads 0 (choice)"),
        Register("CSICFGR", CSICFGR, 0x2000_0000, 0x3F00_0000, fidelity=_PARTLY, note="CSI stays at exactly 4 MHz"),
        Register("CFGR", CFGR, 0, 0xFFFC_FFC7, fidelity=_PARTLY, note=FAST_CLOCKS),
        Register("D1CFGR", D1CFGR, 0, 0xF7F),
        Register("D2CFGR", D2CFGR, 0, 0x770),
        Register("D3CFGR", D3CFGR, 0, 0x70),
        Register("PLLCKSELR", PLLCKSELR, 0x0202_0200, 0x03F3_F3F3),
        Register("PLLCFGR", PLLCFGR, 0x01FF_0000, 0x01FF_0FFF),
        *_of_plls(),
        Register("D1CCIPR", D1CCIPR, 0, 0x3001_0033),
        Register("D2CCIP1R", D2CCIP1R, 0, 0xB137_71C7),
        Register("D2CCIP2R", D2CCIP2R, 0, 0x70F0_333F),
        Register("D3CCIPR", D3CCIPR, 0, 0x77E3_FF07),
        Register("CIER", CIER, 0, 0x3FF),
        Register("CIFR", CIFR, 0, 0),
        Register("CICR", CICR, 0, 0x7FF),
        Register(
            "BDCR",
            BDCR,
            0,
            BDCR_BITS | LSEDRV | LSECSSON,
            LSECSSON,
            fidelity=_PARTLY,
            note="LSEDRV is remembered; nobody watches the LSE",
        ),
        Register("CSR", CSR, 0, LSION),
        Register("GCR", GCR, 0, 1, note="the window watchdog always resets the system"),
        Register("D3AMR", D3AMR, 0, 0x3129_DEA9, fidelity=_ABSENT, note="D3 never runs by itself"),
        Register("RSR", RSR, CAUSES["POR"], RMVF),
        *_of_buses(),
    )
    again = (
        Register(
            f"C1_{one.name}",
            one.offset + ALIAS,
            one.reset,
            one.writable,
            one.ignored,
            fidelity=one.fidelity,
            note=f"the same as {one.name}",
        )
        for one in own
        if one.offset in ALIASED
    )
    return (*own, *again)


REGISTERS = _registers()
"""All of them, those for CPU 1 too."""
