"""Calling functions of committed images, without a chip around them.

The code runs on Unicorn's Cortex-M7, from the very bytes of the image. Where it would touch the board, a function can
be caught instead.
"""

from __future__ import annotations

import functools
import io
import struct

from elftools.elf.elffile import ELFFile

from targets.firmware import image_path

FLASH, FLASH_BYTES = 0x08000000, 0x20000
RAM_BYTES = 0x20000
SYSTEM, SYSTEM_BYTES = 0xE0000000, 0x100000
STOP = FLASH + FLASH_BYTES - 0x1000  # where calls return to
_STACK_TOP, _SCRATCH = RAM_BYTES - 0x8000, RAM_BYTES - 0x7000

FPU_ON = 1 << 30


@functools.cache
def elf_of(name):
    """The loadable segments and the symbols of an image."""
    elf = ELFFile(io.BytesIO(image_path(name).read_bytes()))
    loads = [segment for segment in elf.iter_segments() if segment["p_type"] == "PT_LOAD" and segment["p_filesz"]]
    segments = tuple((segment["p_paddr"], segment.data()) for segment in loads)
    table = elf.get_section_by_name(".symtab")
    return segments, {s.name: s["st_value"] for s in table.iter_symbols() if s.name}


def as_float(bits):
    return struct.unpack("<f", struct.pack("<I", bits))[0]


def as_bits(value):
    return struct.unpack("<I", struct.pack("<f", value))[0]


class Code:
    """An image in memory, whose functions can be called.

    Attributes:
        uc: the core.
        symbols: addresses by name.
    """

    def __init__(self, name):
        import unicorn
        from unicorn import arm_const

        self._unicorn, self._arm = unicorn, arm_const
        segments, self.symbols = elf_of(name)
        self._ram = self.symbols["ld_data_start"] & ~(RAM_BYTES - 1)
        self.uc = unicorn.Uc(unicorn.UC_ARCH_ARM, unicorn.UC_MODE_THUMB)
        self.uc.ctl_set_cpu_model(arm_const.UC_CPU_ARM_CORTEX_M7)
        for base, size in ((FLASH, FLASH_BYTES), (self._ram, RAM_BYTES), (SYSTEM, SYSTEM_BYTES)):
            self.uc.mem_map(base, size)
        for address, data in segments:
            self.uc.mem_write(address, data)
        start, end = self.symbols["ld_data_start"], self.symbols["ld_data_end"]
        self.uc.mem_write(start, bytes(self.uc.mem_read(self.symbols["ld_data_load"], end - start)))
        self.uc.reg_write(arm_const.UC_ARM_REG_FPEXC, FPU_ON)

    def catch(self, name, function):
        """Let `function(code)` stand in for one of the image's; what it returns is r0, unless it is None."""
        address = self.symbols[name] & ~1

        def hook(uc, _address, _size, _user):
            value = function(self)
            if value is not None:
                uc.reg_write(self._arm.UC_ARM_REG_R0, value)
            uc.reg_write(self._arm.UC_ARM_REG_PC, uc.reg_read(self._arm.UC_ARM_REG_LR))

        self.uc.hook_add(self._unicorn.UC_HOOK_CODE, hook, begin=address, end=address)

    def call(self, name, *arguments, floats=()):
        """Call a function; integers and floats have registers of their own. Return r0."""
        for number, value in enumerate(arguments):
            self.uc.reg_write(self._arm.UC_ARM_REG_R0 + number, value & 0xFFFFFFFF)
        for number, value in enumerate(floats):
            self.uc.reg_write(self._arm.UC_ARM_REG_S0 + number, as_bits(value))
        self.uc.reg_write(self._arm.UC_ARM_REG_SP, self._ram + _STACK_TOP)
        self.uc.reg_write(self._arm.UC_ARM_REG_LR, STOP | 1)
        self.uc.emu_start(self.symbols[name] | 1, STOP, count=5_000_000)
        assert self.uc.reg_read(self._arm.UC_ARM_REG_PC) & ~1 == STOP, f"{name} does not come back"
        return self.uc.reg_read(self._arm.UC_ARM_REG_R0)

    def argument(self, number):
        return self.uc.reg_read(self._arm.UC_ARM_REG_R0 + number)

    @property
    def float_argument(self):
        return as_float(self.uc.reg_read(self._arm.UC_ARM_REG_S0))

    @property
    def float_result(self):
        return self.float_argument

    def bytes_at(self, address, count):
        return bytes(self.uc.mem_read(address, count))

    def put(self, data, address=None):
        """Write bytes where nothing else is, or there, and return where."""
        address = self._ram + _SCRATCH if address is None else address
        self.uc.mem_write(address, data)
        return address
