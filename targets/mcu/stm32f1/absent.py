"""What an STM32F103 has and this model lacks: registers with their reset values; whoever uses them is told.

Values are kept as written. Flags that hardware would set stay clear, but for those whose absence would hang a driver
before it has begun: CAN enters and leaves its initialisation and sleep modes at once, on a bus on which nobody else
answers.

Where the FSMC has a bank on, as for a display, nothing is attached: reads give 0 (choice), writes are lost.

Registers: RM0008 sections 21 (FSMC), 23 (USB), 24 (bxCAN).
"""

from __future__ import annotations

from targets.mcu.fidelity import Fidelity
from targets.mcu.registers import Peripheral, Register
from targets.mcu.services import Services
from targets.mcu.stm32.absent import Absent, Can, registers
from targets.mcu.stm32f1.densities import MEDIUM, Density

__all__ = ["Fsmc", "absent_peripherals"]

HALF = 0xFFFF


class Fsmc(Absent):
    """The controller of external memory: no memory answers where it would be."""

    MISSING = "no external memory is there"
    REGISTERS = registers(
        "BCR1=30DB BTR1=FFFFFFF BCR2=30D2 BTR2=FFFFFFF BCR3=30D2 BTR3=FFFFFFF BCR4=30D2 BTR4=FFFFFFF "
        "@60 PCR2=18 SR2=40 PMEM2=FCFCFCFC PATT2=FCFCFCFC @74 ECCR2: "
        "@80 PCR3=18 SR3=40 PMEM3=FCFCFCFC PATT3=FCFCFCFC @94 ECCR3: "
        "@A0 PCR4=18 SR4=40 PMEM4=FCFCFCFC PATT4=FCFCFCFC PIO4=FCFCFCFC "
        "@104 BWTR1=FFFFFFF @10C BWTR2=FFFFFFF @114 BWTR3=FFFFFFF @11C BWTR4=FFFFFFF"
    )
    MEMORY = 0x6000_0000, 0x4000_0000
    MBKEN, FACCEN, MTYP, NOR, PBKEN = 1 << 0, 1 << 6, 3 << 2, 2 << 2, 1 << 2

    def answers(self, address: int) -> bool:
        """Say whether the bank of an address in `MEMORY` is on; else an access is an AHB error (RM0008 21.3).

        Without its clock none answers (choice).
        """
        on = self.clocked and self._is_on(address)
        if on:
            bank = address & ~0x03FF_FFFF if address < 0x7000_0000 else address & ~0x0FFF_FFFF
            self.note("unmodelled", f"0x{bank:08X}", "no external memory is there: reads give 0, writes are lost")
        return on

    def _is_on(self, address: int) -> bool:
        bank = (address >> 28) - 5
        if bank > 1:
            return bool(self[0x20 + 0x20 * bank] & self.PBKEN)
        control = self[8 * (address >> 26 & 3)]
        readable = control & self.FACCEN or control & self.MTYP != self.NOR
        return bool(control & self.MBKEN and readable)


class ValueLineFsmc(Fsmc):
    """That of the STM32F100, which has no banks for NAND flash and PC cards (RM0041 section 20.2)."""

    REGISTERS = tuple(one for one in Fsmc.REGISTERS if one.name.startswith("B"))

    def _is_on(self, address: int) -> bool:
        return address < 0x7000_0000 and super()._is_on(address)


class Cec(Absent):
    """The HDMI-CEC controller of the value line (RM0041 section 24): nothing is sent, nothing arrives."""

    MISSING = "nothing is sent, nothing arrives"
    REGISTERS = registers("CFGR OAR PRES ESR: CSR TXD RXD:")


class Usb(Absent):
    """The USB device interface with no host at the other end: no reset, no frame, no packet."""

    MISSING = "no host is at the other end"
    REGISTERS = (
        *(Register(f"EP{number}R", 4 * number, 0, HALF) for number in range(8)),
        Register("CNTR", 0x40, 0x3, 0xFF1F),
        Register("ISTR", 0x44, 0, 0x7F00),
        Register("FNR", 0x48, 0, 0),
        Register("DADDR", 0x4C, 0, 0xFF),
        Register("BTABLE", 0x50, 0, 0xFFF8),
    )
    CLEARED_BY_ZERO, TOGGLED, PLAIN = 0x8080, 0x7070, 0x070F

    def write(self, offset: int, value: int) -> None:
        """As of every peripheral; an endpoint register has bits that toggle and bits that 0 clears (RM0008 23.5.2)."""
        if offset >= 0x20 or offset & 3:
            super().write(offset, value)
            return
        self._note_absent(offset)
        old = self[offset]
        self[offset] = (old & value & self.CLEARED_BY_ZERO) | ((old ^ value) & self.TOGGLED) | (value & self.PLAIN)

    def write_ISTR(self, value: int) -> None:
        """The flags never rise."""


class UsbMemory(Peripheral):
    """The 512 bytes of packet memory that USB and CAN share, as half-words at every fourth address."""

    REGISTERS = (Register("PMA", 0, 0, HALF, fidelity=Fidelity.ABSENT, note="only the CPU reads and writes packets"),)

    def __init__(self, name: str, base: int, services: Services) -> None:
        super().__init__(name, base, services)
        self._words = [0] * 256

    def read(self, offset: int) -> int:
        """Return a half-word of the memory."""
        return self._words[offset >> 2]

    def write(self, offset: int, value: int) -> None:
        """Keep a half-word."""
        self._words[offset >> 2] = value & HALF


def absent_peripherals(services: Services, density: Density = MEDIUM) -> list[Peripheral]:
    """Return everything of a device of a density that is not modelled, at its address (RM0008 table 3)."""
    everything = (
        Usb("USB", 0x4000_5C00, services),
        UsbMemory("USB_SRAM", 0x4000_6000, services),
        Can("CAN", 0x4000_6400, services),
        Cec("CEC", 0x4000_7800, services),
        (ValueLineFsmc if density.value_line else Fsmc)("FSMC", 0xA000_0000, services),
    )
    gated_by = {"USB_SRAM": "USB"}
    return [part for part in everything if gated_by.get(part.name, part.name) in density.gates]
