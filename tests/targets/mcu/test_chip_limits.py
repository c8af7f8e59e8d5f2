"""Which chip has room for what does not fit, and what is said of an address just behind a memory."""

from __future__ import annotations

from targets.mcu.chip_limits import fitting, limits_for, past_end
from tests.each import each

KB = 1024


@each(
    ("chip", "flash_kb", "ram_kb", "found"),
    [
        ("STM32F103C8", 65, 0, "STM32F103CB"),
        ("stm32f103c4t6", 20, 8, "STM32F103C6"),
        ("STM32F103RB", 129, 20, "STM32F103RC"),
        ("STM32F103CB", 129, 20, "STM32F103RC"),  # no chip in its package has more
        ("STM32F103V8", 64, 50, "STM32F103VD"),
        ("STM32F103ZE", 513, 0, "STM32F767VG"),
        ("STM32H753ZI", 2049, 0, None),
    ],
)
def test_the_nearest_chip_that_has_room(chip, flash_kb, ram_kb, found):
    fits = fitting(limits_for(chip), flash_kb * KB, ram_kb * KB)
    assert (fits and fits.name) == found


@each(
    ("chip", "address", "said"),
    [
        ("STM32F103C8", 0x0800_FFFF, None),
        (
            "STM32F103C8",
            0x0801_0000,
            "past the end of the flash of the STM32F103C8, 64 KB from 0x08000000 on; the STM32F103CB has 128 KB",
        ),
        (
            "STM32F103RB",
            0x2000_5000,
            "past the end of the RAM of the STM32F103RB, 20 KB from 0x20000000 on; the STM32F103RC has 48 KB",
        ),
        ("STM32F103RE", 0x2001_0FFF, "past the end of the RAM of the STM32F103RE, 64 KB from 0x20000000 on"),
        ("STM32F103RE", 0x2001_1000, None),
        ("STM32F103C8", 0x0820_0000, None),
        ("STM32F103C8", 0x4000_0000, None),
        ("STM32F103C8", 0, None),
        (
            "STM32F767ZG",
            0x0810_0000,
            "past the end of the flash of the STM32F767ZG, 1024 KB from 0x08000000 on; the STM32F767ZI has 2048 KB",
        ),
    ],
)
def test_an_address_just_past_the_end(chip, address, said):
    assert past_end(limits_for(chip), address) == said
