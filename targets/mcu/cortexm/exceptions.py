"""Which exception is pending, enabled and active: the state of the NVIC as Python sees it; it is kept in ``nvic.c``."""

from __future__ import annotations

import ctypes
import enum
from collections.abc import Callable

from targets.mcu.engine.core_engine import CoreEngine

__all__ = ["IDLE_PRIORITY", "Exceptions", "Line", "Number"]

IDLE_PRIORITY = 256
"""Priority of a CPU that runs no exception: every exception may interrupt it."""


class Number(enum.IntEnum):
    """Exception numbers (DDI0403 table B1-4); interrupts follow from FIRST_IRQ on."""

    RESET = 1
    NMI = 2
    HARD_FAULT = 3
    MEM_MANAGE = 4
    BUS_FAULT = 5
    USAGE_FAULT = 6
    SVCALL = 11
    DEBUG_MONITOR = 12
    PENDSV = 14
    SYSTICK = 15
    FIRST_IRQ = 16


class Line:
    """The level that a peripheral drives into one interrupt input of the NVIC (DDI0403 section B3.4.1).

    Attributes:
        level: as last driven from here.
        core, driven_in_c: see `targets.mcu.services.IrqLine`.
    """

    __slots__ = ("_exceptions", "_number", "core", "driven_in_c", "level")

    def __init__(self, exceptions: Exceptions, number: int) -> None:
        self._exceptions = exceptions
        self._number = number
        self.core = exceptions.core
        self.level = self.driven_in_c = False

    def set(self, level: bool) -> None:
        """Drive the line. A rising edge makes the interrupt pending; a falling edge leaves it so."""
        if level == self.level:
            return
        self.level = level
        self._exceptions.line_changed(self._number, level)


class Exceptions:
    """The exceptions of one core.

    Args:
        engine: keeps them.
        irq_count: interrupt inputs.
        priority_bits: implemented bits of a priority; the upper ones of its byte.

    Attributes:
        count: exception numbers there are, 16 + `irq_count`.
        lines: the interrupt inputs.
        kept: ``struct hil_exceptions``.
        priorities: configured priority of each exception number.
    """

    def __init__(self, engine: CoreEngine, irq_count: int, priority_bits: int) -> None:
        self.count = Number.FIRST_IRQ + irq_count
        self.core = engine.core
        self.lines = [Line(self, Number.FIRST_IRQ + irq) for irq in range(irq_count)]
        self.kept = engine.exceptions
        self.priorities = self.kept.priorities
        self.reset = engine.asking("hil_reset_exceptions")
        self._pend = engine.asking("hil_pend")
        self._drive = engine.asking("hil_drive_line")
        self._read_word: Callable[..., int] = engine.asking("hil_scs_read")
        self._ask = engine.ask
        engine.ask("hil_set_up_exceptions", irq_count, priority_bits)

    # --- priorities

    def set_grouping(self, prigroup: int) -> None:
        """Split priorities at bit `prigroup` (0 to 7): bits above it are the group (DDI0403 table B1-6)."""
        self._ask("hil_set_grouping", prigroup)

    def group_priority(self, priority: int) -> int:
        """Return the part of a priority that decides over preemption; negative priorities are not grouped."""
        return priority if priority < 0 else priority & int(self.kept.group_mask)

    def set_priority(self, number: int, priority: int) -> None:
        """Configure the priority of an exception, 0 to 255; bits that are not implemented read as zero."""
        self._ask("hil_set_priority", number, priority)

    def boosted(self, primask: int, basepri: int, faultmask: int) -> int:
        """Return the priority to which the mask registers raise execution (DDI0403 ``ExecutionPriority``)."""
        if faultmask & 1:
            return -1
        if primask & 1:
            return 0
        basepri &= self.kept.priority_mask
        return self.group_priority(basepri) if basepri else IDLE_PRIORITY

    # --- pending, enabled, active

    @property
    def active(self) -> int:
        """The set of exceptions whose handlers have begun and not returned, as bits."""
        return int.from_bytes(self.kept.active, "little")

    @property
    def pending(self) -> int:
        """The set of those that are pending."""
        return int.from_bytes(self.kept.pending, "little")

    def pend(self, number: int) -> None:
        """Make an exception pending."""
        self._pend(number)

    def unpend(self, number: int) -> None:
        """Take back the pending state; an inactive interrupt whose line is high stays pending."""
        self._ask("hil_unpend", number)

    def enable(self, number: int) -> None:
        """Let an exception be taken."""
        self._ask("hil_enable", number)

    def disable(self, number: int) -> None:
        """Keep an exception from being taken; if it is active it stays so."""
        self._ask("hil_disable", number)

    def set_active(self, number: int, active: bool) -> None:
        """Set the active state as a write to SHCSR does, without its consequences."""
        self._ask("hil_set_active", number, active)

    def is_active(self, number: int) -> bool:
        """Say whether the handler of an exception has begun and not returned."""
        return _is_in(self.kept.active, number)

    def is_pending(self, number: int) -> bool:
        """Say whether an exception is pending."""
        return _is_in(self.kept.pending, number)

    def is_enabled(self, number: int) -> bool:
        """Say whether an exception may be taken; otherwise it stays pending."""
        return _is_in(self.kept.enabled, number)

    def line_changed(self, number: int, level: bool) -> None:
        """Take the new level of an interrupt line."""
        self._drive(number, level)

    # --- as registers

    def read_word(self, offset: int) -> int:
        """Read one of the registers of the system control space that show this; 0 if it is none, or STIR."""
        value = ctypes.c_uint32()
        self._read_word(offset, 4, ctypes.byref(value))
        return value.value

    def write_word(self, offset: int, value: int) -> bool:
        """Write one; return False if it is none, or STIR with the number of no interrupt."""
        return bool(self._ask("hil_scs_write", offset, 4, value))


def _is_in(numbers: object, number: int) -> bool:
    return bool(numbers[number >> 5] >> (number & 31) & 1)  # type: ignore[index]
