"""EXTI of the STM32H743 and H753: edges of configurable lines, and direct lines (RM0433 section 20).

Lines 0 to 15 listen to the inputs ``EXTI0`` to ``EXTI15``, which SYSCFG routes to pins, the others to signals inside
the chip, such as ``EXTI17`` (RTC alarm). An edge sets the pending bit of a configurable line only if CPUIMR unmasks
it, as in the other families. Direct lines have no edges to choose and no pending bit: their peripherals drive the NVIC
by themselves, and what unmasks them matters for waking up from Stop alone. D3 never runs by itself: its registers are
kept.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import ClassVar

from targets.mcu.fidelity import Fidelity
from targets.mcu.registers import Peripheral, Register
from targets.mcu.services import Services

__all__ = ["Exti"]

RTSR, FTSR, SWIER, IMR, EMR, PR = 0x00, 0x04, 0x08, 0x80, 0x84, 0x88
_GROUP, _CPU_GROUP = 0x20, 0x10  # from the registers of a group of 32 lines to those of the next
# RM0433 section 20.4, event inputs: 0 to 21 and 49, 51, 82, 84 to 86 are configurable; 45, 83 and 81 do not exist.
CONFIGURABLE = (0x003F_FFFF, 1 << 17 | 1 << 19, 1 << 18 | 1 << 20 | 1 << 21 | 1 << 22)
EXISTING = (0xFFFF_FFFF, 0xFFFF_DFFF, 0x01F5_FFFF)
_D3_LINES = (0x0238_FFFF, 0x003F_020C, 1 << 24)
# After a reset direct lines are unmasked (RM0433 section 20.6.19)
_IMR_RESET = (0xFFC0_0000, 0xFFF5_DFFF, 0x0185_FFFF)

# RM0433 section 19.1.2: interrupt and the lines that share it: pins; PVD and AVD, RTC alarm, tamper and time stamp with
# CSS of the LSE, RTC wake-up, both comparators.
_IRQS = (
    *((6 + line, 1 << line) for line in range(5)),
    (23, 0x03E0),
    (40, 0xFC00),
    (1, 1 << 16),
    (41, 1 << 17),
    (2, 1 << 18),
    (3, 1 << 19),
    (137, 3 << 20),
)


def _registers() -> tuple[Register, ...]:
    found = []
    note = "D3 never runs by itself"
    for group in range(3):
        base, cpu, suffix = _GROUP * group, _CPU_GROUP * group, group + 1
        lines = CONFIGURABLE[group]
        found += [
            Register(f"RTSR{suffix}", base + RTSR, 0, lines),
            Register(f"FTSR{suffix}", base + FTSR, 0, lines),
            Register(f"SWIER{suffix}", base + SWIER, 0, lines),
            Register(f"D3PMR{suffix}", base + 0x0C, 0, _D3_LINES[group], fidelity=Fidelity.ABSENT, note=note),
            Register(f"D3PCR{suffix}L", base + 0x10, 0, fidelity=Fidelity.ABSENT, note=note),
            Register(f"D3PCR{suffix}H", base + 0x14, 0, fidelity=Fidelity.ABSENT, note=note),
            Register(f"CPUIMR{suffix}", cpu + IMR, _IMR_RESET[group], EXISTING[group]),
            Register(f"CPUEMR{suffix}", cpu + EMR, 0, EXISTING[group]),
            Register(f"CPUPR{suffix}", cpu + PR, 0, lines, note="an edge sets no bit of a line that CPUIMR masks"),
        ]
    return tuple(found)


class Exti(Peripheral):
    """EXTI.

    Args:
        base: address.
        services: what the chip offers.

    Attributes:
        on_event: called at an edge of a line that CPUEMR unmasks; the core takes it as an event for WFE.
    """

    REGISTERS: ClassVar[tuple[Register, ...]] = _registers()

    def __init__(self, base: int, services: Services) -> None:
        super().__init__("EXTI", base, services)
        self.on_event: Callable[[], None] = lambda: None
        numbers = [32 * group + bit for group in range(3) for bit in range(32) if CONFIGURABLE[group] >> bit & 1]
        self._inputs = {line: services.input(f"EXTI{line}") for line in numbers}
        self._irqs = [(services.irq(number), lines) for number, lines in _IRQS]
        self._listeners = {line: self._listener(line) for line in numbers}

    def reset(self) -> None:
        """All configurable lines masked, nothing pending."""
        super().reset()
        self._listen()
        self._drive_irqs()

    def write(self, offset: int, value: int) -> None:
        """Write the word at `offset`."""
        group, which = divmod(offset, _GROUP) if offset < IMR else divmod(offset - IMR, _CPU_GROUP)
        if offset < IMR and which == SWIER and group < 3:
            self._trigger_by_software(group, value & CONFIGURABLE[group])
        elif offset >= IMR and which == PR - IMR and group < 3:
            self[offset] &= ~value
            self[_GROUP * group + SWIER] &= ~value
            self._drive_irqs()
        else:
            super().write(offset, value)
            self._listen()
            self._drive_irqs()

    def _trigger_by_software(self, group: int, value: int) -> None:
        """A bit that goes from 0 to 1 acts like an edge of its line; CPUPR clears it."""
        rising = value & ~self[_GROUP * group + SWIER]
        self[_GROUP * group + SWIER] |= rising
        unmasked = self[_CPU_GROUP * group + IMR] | self[_CPU_GROUP * group + EMR]
        if rising & ~unmasked:
            text = "set for a line that CPUIMR and CPUEMR mask: no bit of CPUPR, no interrupt"
            self.note("misuse", f"SWIER{group + 1}", text)
        self._triggered(group, rising)

    def sends_events(self) -> bool:
        """Say whether an edge from outside could be an event for WFE."""
        return any(
            self[_CPU_GROUP * group + EMR] & (self[_GROUP * group + RTSR] | self[_GROUP * group + FTSR])
            for group in range(3)
        )

    def unmasks(self, line: int) -> bool:
        """Say whether CPUIMR lets a direct line wake the CPU up."""
        return bool(self[_CPU_GROUP * (line // 32) + IMR] >> line % 32 & 1)

    def _listener(self, line: int) -> Callable[[bool], None]:
        group, bit = line // 32, 1 << line % 32

        def changed(level: bool) -> None:
            if self[_GROUP * group + (RTSR if level else FTSR)] & bit:
                self._triggered(group, bit)

        return changed

    def _listen(self) -> None:
        for line, signal in self._inputs.items():
            group = line // 32
            wanted = self[_GROUP * group + RTSR] | self[_GROUP * group + FTSR]
            listener = self._listeners[line] if wanted >> line % 32 & 1 else None
            if signal.on_change is not listener:
                signal.on_change = listener

    def _triggered(self, group: int, lines: int) -> None:
        unmasked = lines & self[_CPU_GROUP * group + IMR]
        if unmasked:
            self[_CPU_GROUP * group + PR] |= unmasked
            self._drive_irqs()
        if lines & self[_CPU_GROUP * group + EMR]:
            self.on_event()

    def _drive_irqs(self) -> None:
        requests = self[PR] & self[IMR]
        for line, lines in self._irqs:
            line.set(bool(requests & lines))
