"""How much memory a chip has and where, as far as an image has to know, by part number."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from targets.mcu.variants import VARIANTS, Variant

__all__ = ["FLASH_BASE", "RAM_BASE", "ChipLimits", "fitting", "limits_for", "limits_of", "past_end"]

KB = 1024
FLASH_BASE, RAM_BASE = 0x0800_0000, 0x2000_0000
_NEAR = 4 * KB  # so far behind the end of a memory is by a mistake of it (choice)
FLASH_SPACE = 16 * KB * KB  # what the memory map sets aside is more; none of these chips fills it


@dataclass(frozen=True, slots=True, kw_only=True)
class _Series:
    """What part numbers that begin alike have in common.

    Attributes:
        sizes_kb: kilobytes of flash and of RAM by the letter of the part number.
        cpu: what a compiler calls its core.
        irq_count: interrupts in the vector table.
        itcm_size: bytes of RAM from 0 on.
        more_ram: first address and bytes of other RAM.
        flash_alias: where else the flash is.
        options: first address and size of the option bytes; none where they have no address.
        boot_loaders: sizes of boot loaders in use, or of what they may fill.
    """

    sizes_kb: Mapping[str, tuple[int, int]]
    cpu: str
    irq_count: int
    options: tuple[int, int]
    boot_loaders: tuple[int, ...]
    itcm_size: int = 0
    more_ram: tuple[tuple[int, int], ...] = ()
    flash_alias: int | None = None


# DS12110 and DS12117, ordering information; boot loaders end where a sector does (RM0433 section 4.3.4)
_STM32H7 = _Series(
    sizes_kb=MappingProxyType({"I": (2048, 128)}),
    cpu="cortex-m7",
    irq_count=150,
    options=(0, 0),
    boot_loaders=(128, 256, 384, 512, 640, 768, 896, 1024),
    itcm_size=64 * KB,
    more_ram=((0x2400_0000, 512 * KB), (0x3000_0000, 288 * KB), (0x3800_0000, 64 * KB)),
)

_SERIES = MappingProxyType(
    {
        # DS6087, DS5319 and DS5792, ordering information; table: up to medium density (RM0008, table 63), the rest of a
        # longer one says nothing new
        "STM32F103": _Series(
            sizes_kb=MappingProxyType(
                {
                    "4": (16, 6),
                    "6": (32, 10),
                    "8": (64, 20),
                    "B": (128, 20),
                    "C": (256, 48),
                    "D": (384, 64),
                    "E": (512, 64),
                }
            ),
            cpu="cortex-m3",
            irq_count=43,
            options=(0x1FFF_F800, 16),
            boot_loaders=(4, 8, 10, 12, 16, 20, 24, 28, 32, 48, 64),
        ),
        # DS5944, ordering information; RM0041 table 50
        "STM32F100": _Series(
            sizes_kb=MappingProxyType(
                {
                    "4": (16, 4),
                    "6": (32, 4),
                    "8": (64, 8),
                    "B": (128, 8),
                    "C": (256, 24),
                    "D": (384, 32),
                    "E": (512, 32),
                }
            ),
            cpu="cortex-m3",
            irq_count=56,
            options=(0x1FFF_F800, 16),
            boot_loaders=(4, 8, 10, 12, 16, 20, 24, 28, 32, 48, 64),
        ),
        # DS11532, ordering information; boot loaders end where a sector does (RM0410 section 3.3.1)
        "STM32F767": _Series(
            sizes_kb=MappingProxyType({"G": (1024, 512), "I": (2048, 512)}),
            cpu="cortex-m7",
            irq_count=110,
            options=(0x1FFF_0000, 32),
            boot_loaders=(16, 32, 48, 64, 96, 128, 256, 512, 1024),
            itcm_size=16 * KB,
            flash_alias=0x0020_0000,
        ),
        "STM32H743": _STM32H7,
        "STM32H753": _STM32H7,
    }
)


@dataclass(frozen=True, slots=True, kw_only=True)
class ChipLimits:
    """How much memory a chip has.

    Attributes:
        name: part number.
        flash_size: bytes from 0x08000000.
        ram_size: bytes from 0x20000000.
    """

    name: str
    flash_size: int
    ram_size: int

    @property
    def series(self) -> str:
        """What its part number begins with, such as ``STM32F103``."""
        return next((name for name in _SERIES if self.name.startswith(name)), next(iter(_SERIES)))

    @property
    def cpu(self) -> str:
        """What a compiler calls its core."""
        return _SERIES[self.series].cpu

    @property
    def table_words(self) -> int:
        """Words of a whole vector table."""
        return 16 + _SERIES[self.series].irq_count

    @property
    def boot_loader_sizes(self) -> tuple[int, ...]:
        """Bytes that a boot loader may take, which an image behind it leaves out."""
        return tuple(size * KB for size in _SERIES[self.series].boot_loaders)

    @property
    def itcm_size(self) -> int:
        """Bytes of RAM from 0 on."""
        return _SERIES[self.series].itcm_size

    @property
    def more_ram(self) -> tuple[tuple[int, int], ...]:
        """First address and bytes of RAM elsewhere."""
        return _SERIES[self.series].more_ram

    def ram_at(self, address: int) -> tuple[int, int] | None:
        """Return first address and bytes of the RAM elsewhere in which an address lies."""
        return next((part for part in self.more_ram if part[0] <= address < part[0] + part[1]), None)

    @property
    def flash_bases(self) -> tuple[int, ...]:
        """Where a program may be linked to run from flash."""
        alias = _SERIES[self.series].flash_alias
        return (FLASH_BASE,) if alias is None else (FLASH_BASE, alias)

    @property
    def flash_end(self) -> int:
        """First address behind the flash."""
        return FLASH_BASE + self.flash_size

    @property
    def ram_end(self) -> int:
        """First address behind the RAM."""
        return RAM_BASE + self.ram_size

    def home(self, address: int) -> int:
        """Return the address from 0x08000000 on of a byte of flash; any other address as it is."""
        for base in self.flash_bases[1:]:
            if base <= address < base + self.flash_size:
                return address - base + FLASH_BASE
        return address

    def in_flash(self, address: int) -> bool:
        """Say whether an address means flash, even if there is less of it."""
        return FLASH_BASE <= self.home(address) < FLASH_BASE + FLASH_SPACE

    def in_ram(self, address: int) -> bool:
        """Say whether an address means RAM, even if there is less of it."""
        return address >= RAM_BASE or address < self.itcm_size

    def in_options(self, start: int, end: int) -> bool:
        """Say whether bytes belong to the option bytes."""
        base, size = _SERIES[self.series].options
        return base <= start and end <= base + size


def limits_for(part: str) -> ChipLimits:
    """Return the limits of a chip by its part number, such as ``STM32F103C8``, ``stm32f103cbt6`` or ``STM32F767ZI``.

    Raises:
        KeyError: no such part.
    """
    for name, series in _SERIES.items():
        match = re.fullmatch(rf"{name}[A-Z]([{''.join(series.sizes_kb)}]).*", part.upper())
        if match is not None:
            flash_kb, ram_kb = series.sizes_kb[match[1]]
            return ChipLimits(name=part.upper(), flash_size=flash_kb * KB, ram_size=ram_kb * KB)
    raise KeyError(part)


def limits_of(variant: Variant) -> ChipLimits:
    """Return the limits of a chip that can be emulated."""
    return ChipLimits(name=variant.name, flash_size=variant.flash_bytes, ram_size=variant.ram_bytes)


def fitting(chip: ChipLimits, flash: int, ram: int) -> Variant | None:
    """Return the chip that can be emulated and has that many bytes of flash and RAM; None for none.

    The nearest one: of the same series if possible, in the same package if possible, and no larger than needed.
    """
    fits = [one for one in VARIANTS.values() if flash <= one.flash_bytes and ram <= one.ram_bytes]

    def distance(one: Variant) -> tuple[bool, bool, int, int]:
        return (
            not one.name.startswith(chip.series),
            not chip.name.startswith(one.name[:-1]),
            one.flash_bytes,
            one.ram_bytes,
        )

    return min(fits, key=distance, default=None)


def past_end(chip: ChipLimits, address: int) -> str | None:
    """Say that an address lies behind the end of flash or RAM, and which chip of the series has more.

    None where that explains nothing: neither has a chip of the series memory there, nor is the end near.
    """
    for what, base, size in (("flash", FLASH_BASE, chip.flash_size), ("RAM", RAM_BASE, chip.ram_size)):
        needed = address + 1 - base
        if needed <= size:
            continue
        larger = fitting(chip, needed, 0) if what == "flash" else fitting(chip, 0, needed)
        if larger is not None and not larger.name.startswith(chip.series):
            larger = None
        if larger is None and needed > size + _NEAR:
            continue
        text = f"past the end of the {what} of the {chip.name}, {size // KB} KB from 0x{base:08X} on"
        if larger is None:
            return text
        has = larger.flash_bytes if what == "flash" else larger.ram_bytes
        return f"{text}; the {larger.name} has {has // KB} KB"
    return None
