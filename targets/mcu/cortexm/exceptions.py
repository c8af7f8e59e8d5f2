"""Which exception is pending, enabled and active, and which of them wins: the state of the NVIC, without a CPU.

Sets of exceptions are integers with the bit of each exception number set; interrupt n is exception 16 + n. Priorities
follow the ARMv7-M Architecture Reference Manual (DDI0403), section B1.5.4: a lower value is more urgent, the group part
of it decides over preemption, the whole of it over who goes first, and the lower exception number if that is equal.
"""

from __future__ import annotations

import enum
from collections.abc import Callable

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


FIXED_PRIORITIES = {Number.RESET: -3, Number.NMI: -2, Number.HARD_FAULT: -1}
_ALWAYS_ENABLED = sum(
    1 << number for number in (Number.NMI, Number.HARD_FAULT, Number.SVCALL, Number.PENDSV, Number.SYSTICK)
)


class Line:
    """The level that a peripheral drives into one interrupt input of the NVIC (DDI0403 section B3.4.1).

    Attributes:
        level: as last driven.
    """

    __slots__ = ("_exceptions", "_number", "level")

    def __init__(self, exceptions: Exceptions, number: int) -> None:
        self._exceptions = exceptions
        self._number = number
        self.level = False

    def set(self, level: bool) -> None:
        """Drive the line. A rising edge makes the interrupt pending; a falling edge leaves it so."""
        if level == self.level:
            return
        self.level = level
        self._exceptions.line_changed(self._number, level)


class Exceptions:
    """The exceptions of one core.

    Args:
        irq_count: interrupt inputs.
        priority_bits: implemented bits of a priority; the upper ones of its byte.

    Attributes:
        count: exception numbers there are, 16 + `irq_count`.
        pending: set of pending exceptions.
        active: set of exceptions whose handlers have begun and not returned.
        enabled: set of exceptions that may be taken; the others stay pending.
        priorities: configured priority of each exception number.
        priority_mask: implemented bits of a priority.
        group_mask: bits of a priority that decide over preemption, from AIRCR.PRIGROUP.
        best: the pending and enabled exception that goes first, 0 if there is none.
        best_priority: its group priority, `IDLE_PRIORITY` if there is none.
        active_priority: the most urgent group priority of the active exceptions, `IDLE_PRIORITY` if there is none.
        event: the event register of WFE (DDI0403 section B1.5.18).
        event_on_pend: SCR.SEVONPEND: an interrupt that becomes pending, enabled or not, sets the event register.
        on_change: called after every change that could let an exception be taken, whatever the mask registers say, or
            wake a sleeping CPU.
    """

    def __init__(self, irq_count: int, priority_bits: int) -> None:
        self.count = Number.FIRST_IRQ + irq_count
        self.priority_mask = 0xFF << 8 - priority_bits & 0xFF
        self.lines = [Line(self, Number.FIRST_IRQ + irq) for irq in range(irq_count)]
        self._high = 0
        self.on_change: Callable[[], None] = lambda: None
        self.reset()

    def reset(self) -> None:
        """Go to the state after reset: nothing pending, whatever the lines are (their peripherals are reset too)."""
        self.pending = 0
        self.active = 0
        self.enabled = _ALWAYS_ENABLED
        self.priorities = [0] * self.count
        for number, priority in FIXED_PRIORITIES.items():
            self.priorities[number] = priority
        self.event = False
        self.event_on_pend = False
        self.best = 0
        self.best_priority = self.active_priority = IDLE_PRIORITY
        self.set_grouping(0)

    # --- priorities

    def set_grouping(self, prigroup: int) -> None:
        """Split priorities at bit `prigroup` (0 to 7): bits above it are the group (DDI0403 table B1-6)."""
        self.group_mask = -(2 << prigroup)
        self.refresh()

    def group_priority(self, priority: int) -> int:
        """Return the part of a priority that decides over preemption; negative priorities are not grouped."""
        return priority if priority < 0 else priority & self.group_mask

    def set_priority(self, number: int, priority: int) -> None:
        """Configure the priority of an exception, 0 to 255; bits that are not implemented read as zero."""
        self.priorities[number] = priority & self.priority_mask
        self.refresh()

    def boosted(self, primask: int, basepri: int, faultmask: int) -> int:
        """Return the priority to which the mask registers raise execution (DDI0403 ``ExecutionPriority``)."""
        if faultmask & 1:
            return -1
        if primask & 1:
            return 0
        basepri &= self.priority_mask
        return self.group_priority(basepri) if basepri else IDLE_PRIORITY

    def refresh(self) -> None:
        """Find the best pending and the most urgent active exception anew, and tell if something could be taken."""
        priorities = self.priorities
        best, best_priority = 0, IDLE_PRIORITY
        ready = self.pending & self.enabled
        while ready:
            lowest = ready & -ready
            ready ^= lowest
            number = lowest.bit_length() - 1
            if priorities[number] < best_priority:
                best, best_priority = number, priorities[number]
        running = IDLE_PRIORITY
        active = self.active
        while active:
            lowest = active & -active
            active ^= lowest
            priority = priorities[lowest.bit_length() - 1]
            if priority < running:
                running = priority
        mask = self.group_mask
        self.best = best
        self.best_priority = best_priority if best_priority < 0 else best_priority & mask
        self.active_priority = running if running < 0 else running & mask
        if self.best_priority < self.active_priority:
            self.on_change()

    # --- pending, enabled, active

    def pend(self, numbers: int) -> None:
        """Make a set of exceptions pending."""
        new = numbers & ~self.pending
        if not new:
            return
        self.pending |= new
        self.refresh()
        if self.event_on_pend:
            self.event = True
            self.on_change()

    def unpend(self, numbers: int) -> None:
        """Take back the pending state of a set; an inactive interrupt whose line is high stays pending."""
        self.pending &= ~numbers | self._high & ~self.active
        self.refresh()

    def enable(self, numbers: int) -> None:
        """Let a set of exceptions be taken."""
        self.enabled |= numbers
        self.refresh()

    def disable(self, numbers: int) -> None:
        """Keep a set of exceptions from being taken; what is active stays so."""
        self.enabled &= ~numbers
        self.refresh()

    def activate(self, number: int) -> None:
        """Begin the handler of an exception: active, no longer pending."""
        self.pending &= ~(1 << number)
        self.active |= 1 << number
        self.refresh()

    def deactivate(self, number: int) -> None:
        """End the handler of an exception; an interrupt whose line is still high becomes pending again."""
        bit = 1 << number
        self.active &= ~bit
        if self._high & ~self.pending & bit:
            self.pend(bit)
        else:
            self.refresh()

    def set_active(self, number: int, active: bool) -> None:
        """Set the active state as a write to SHCSR does, without its consequences."""
        self.active = self.active & ~(1 << number) | active << number
        self.refresh()

    def is_active(self, number: int) -> bool:
        """Say whether the handler of an exception has begun and not returned."""
        return bool(self.active >> number & 1)

    def is_pending(self, number: int) -> bool:
        """Say whether an exception is pending."""
        return bool(self.pending >> number & 1)

    def line_changed(self, number: int, level: bool) -> None:
        """Take the new level of an interrupt line."""
        if level:
            self._high |= 1 << number
            self.pend(1 << number)
        else:
            self._high &= ~(1 << number)
