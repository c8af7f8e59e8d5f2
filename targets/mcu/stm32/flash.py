"""What the flash interfaces of the families have in common: images, keys, one operation at a time.

KEYR and OPTKEYR take two keys in order (PM0075 section 2.3, RM0410 section 3.3, RM0433 section 4.5.1). Who stores
while the flash is busy is served when it is not.
"""

from __future__ import annotations

import abc
from collections.abc import Callable, Mapping
from functools import partial
from typing import ClassVar

from targets.mcu.errors import BusFault
from targets.mcu.registers import Peripheral
from targets.mcu.services import Services
from targets.mcu.timebase import Event

__all__ = ["CR", "FLASH_BASE", "KEYR", "OPTKEYR", "SR", "BasicFlash"]

IRQ = 4
FLASH_BASE = 0x0800_0000
KEYR, OPTKEYR, SR, CR = 0x04, 0x08, 0x0C, 0x10


class BasicFlash(Peripheral, abc.ABC):
    """A flash interface with the memory behind it; a family says how it is programmed and erased.

    Args:
        base: address of its first register.
        services: what the chip offers.
        size: bytes of flash.
        options: the option bytes as they come from the factory.

    Attributes:
        KEYS: the two keys of KEYR and of OPTKEYR.
        ONE_WRONG_KEY_KILLS_ALL: after a wrong key neither register takes one until the next reset; else only that one.
        LOCK: the bit of CR that KEYR clears.
        BASES: where the flash is seen.
        OPTIONS_BASE: where the option bytes are.
        memory: the flash, shared with the engine.
        options: the option bytes, shared with the engine.
        on_code_changed: called with address and size after the contents changed, for each place where they are seen.
        on_latency: called with the number of wait states when it changes.
        stall_until: called with a cycle before which no instruction in flash can begin.
    """

    KEYS: ClassVar[Mapping[int, tuple[int, int]]]
    ONE_WRONG_KEY_KILLS_ALL: ClassVar[bool]
    LOCK: ClassVar[int]
    BASES: ClassVar[tuple[int, ...]]
    OPTIONS_BASE: ClassVar[int]

    def __init__(self, base: int, services: Services, *, size: int, options: bytes) -> None:
        super().__init__("FLASH", base, services)
        self.memory = bytearray(b"\xff" * size)
        self.options = bytearray(options)
        self.on_code_changed: Callable[[int, int], None] = lambda _address, _size: None
        self.on_latency: Callable[[int], None] = lambda _wait_states: None
        self.stall_until: Callable[[int], None] = lambda _cycle: None
        self._irq = services.irq(IRQ)
        self._turned = dict.fromkeys(self.KEYS, 0)
        self._dead: set[int] = set()
        self._ends: Event | None = None

    # --- what a family says

    @abc.abstractmethod
    def _load_options(self) -> None:
        """Take over what the option bytes say."""

    @abc.abstractmethod
    def _check_access(self) -> None:
        """Note what is wrong with the wait states at the present rate."""

    @abc.abstractmethod
    def _irq_follows(self) -> None:
        """Drive the interrupt from flags and enables."""

    # --- what the machine calls

    def load(self, address: int, data: bytes) -> None:
        """Put an image into flash or option bytes, as a programmer does before power-on.

        Raises:
            BusFault: part of it lies outside of both.
        """
        for start, memory in (*((base, self.memory) for base in self.BASES), (self.OPTIONS_BASE, self.options)):
            if start <= address and address + len(data) <= start + len(memory):
                memory[address - start : address - start + len(data)] = data
                self._load_options()
                return
        raise BusFault(address)

    def reset(self) -> None:
        """Lock, forget an operation under way, and load the option bytes anew; the contents stay."""
        super().reset()
        self.time.cancel(self._ends)
        self._ends = None
        self._turned = dict.fromkeys(self.KEYS, 0)
        self._dead.clear()
        self._load_options()
        self._irq.set(False)
        self.on_latency(0)

    def after_clock_change(self) -> None:
        """Compare the wait states with the new rate."""
        self._check_access()

    # --- keys

    def read_KEYR(self) -> int:
        """Write-only."""
        return 0

    def write_KEYR(self, value: int) -> None:
        """Unlock CR by two keys in order; a wrong one is a bus error and locks it until the next reset."""
        if self[CR] & self.LOCK and self._turn_key(KEYR, value):
            self[CR] &= ~self.LOCK

    def read_OPTKEYR(self) -> int:
        """Write-only."""
        return 0

    def _turn_key(self, register: int, value: int) -> bool:
        """Take one key; return whether it was the second of the pair."""
        if register in self._dead or value != self.KEYS[register][self._turned[register]]:
            self._dead.update(self.KEYS if self.ONE_WRONG_KEY_KILLS_ALL else (register,))
            name = self.registers[register].name
            self.note("misuse", name, "wrong key: a bus error, and locked until the next reset")
            raise BusFault(self.base + register, f"FLASH_{name} got a wrong key, and takes none until the next reset")
        self._turned[register] ^= 1
        return not self._turned[register]

    # --- operations

    def _when_free(self, action: Callable[[], None]) -> None:
        if self._ends is not None and self._ends.pending:
            self.time.at(self._ends.cycle, partial(self._when_free, action))
        else:
            action()

    def _set_status(self, *, set_: int = 0, clear: int = 0) -> None:
        self[SR] = (self[SR] & ~clear) | set_
        self._irq_follows()
