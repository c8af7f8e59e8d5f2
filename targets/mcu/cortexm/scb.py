"""The system control block (DDI0403 section B3.2) with the debug registers that software can see.

What differs between cores is in `kinds`. Of a Cortex-M3 r1p1, as in every STM32F103, STKALIGN resets to 0 (ARM ABI
advisory 1, IHI0046; r2p0 changed it to 1), VTOR has bits 29 to 7 (Cortex-M3 TRM r1p1), and there is no MPU (PM0056).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import ClassVar

from targets.mcu.cortexm.exceptions import Exceptions, Number
from targets.mcu.cortexm.kinds import CoreKind
from targets.mcu.cortexm.ppb import LaneBlock, component_id
from targets.mcu.fidelity import Fidelity
from targets.mcu.registers import Register
from targets.mcu.services import Services

__all__ = ["Scb"]

_DC = 1 << 16
_ICSR, _VTOR, _AIRCR, _SCR, _CCR = 0xD04, 0xD08, 0xD0C, 0xD10, 0xD14
_SHPR1, _SHCSR, _CFSR, _HFSR, _DFSR, _MMFAR, _BFAR = 0xD18, 0xD24, 0xD28, 0xD2C, 0xD30, 0xD34, 0xD38
_CPACR, _DHCSR, _DEMCR = 0xD88, 0xDF0, 0xDFC

_KEY, _KEY_READ = 0x05FA, 0xFA05
_PRIGROUP = 0x700
_VECTRESET, _VECTCLRACTIVE, _SYSRESETREQ = 1 << 0, 1 << 1, 1 << 2
_SLEEPONEXIT, _SLEEPDEEP, _SEVONPEND = 1 << 1, 1 << 2, 1 << 4
_USERSETMPEND, _UNALIGN_TRP, _DIV_0_TRP, _BFHFNMIGN, _DC = 1 << 1, 1 << 3, 1 << 4, 1 << 8, 1 << 16
_CP10, _CP11 = 0b11 << 20, 0b11 << 22
_MON_EN, _MON_PEND, _MON_STEP, _MON_REQ, _TRCENA = 1 << 16, 1 << 17, 1 << 18, 1 << 19, 1 << 24
_S_REGRDY, _S_RETIRE_ST, _S_RESET_ST = 1 << 16, 1 << 24, 1 << 25
_DFSR_BKPT = 1 << 1

_SHCSR_ACTIVE = {
    Number.MEM_MANAGE: 0,
    Number.BUS_FAULT: 1,
    Number.USAGE_FAULT: 3,
    Number.SVCALL: 7,
    Number.DEBUG_MONITOR: 8,
    Number.PENDSV: 10,
    Number.SYSTICK: 11,
}
_SHCSR_PENDED = {Number.USAGE_FAULT: 12, Number.MEM_MANAGE: 13, Number.BUS_FAULT: 14, Number.SVCALL: 15}
_SHCSR_ENABLED = {Number.MEM_MANAGE: 16, Number.BUS_FAULT: 17, Number.USAGE_FAULT: 18}
_CONFIGURABLE = (4, 5, 6, 11, 12, 14, 15)

_IDENTITY = (
    *("PFR0", "PFR1", "DFR0", "AFR0", "MMFR0", "MMFR1", "MMFR2", "MMFR3"),
    *("ISAR0", "ISAR1", "ISAR2", "ISAR3", "ISAR4"),
)
_MPU = ("TYPE", "CTRL", "RNR", "RBAR", "RASR", "RBAR_A1", "RASR_A1", "RBAR_A2", "RASR_A2", "RBAR_A3", "RASR_A3")
_CACHES = "caches are not modelled: memory is always what was last written to it, and code too"


def _registers(kind: CoreKind) -> Iterator[Register]:
    yield Register("ICTR", 0x004, (kind.irq_count - 1) // 32, 0)
    yield Register("ACTLR", 0x008, 0, kind.actlr_writable, note="changes timing that is not modelled")
    yield Register("CPUID", 0xD00, kind.cpuid, 0)
    yield from _SAME_REGISTERS
    yield Register("VTOR", _VTOR, 0, kind.vtor_bits)
    yield Register(
        "CCR",
        _CCR,
        kind.ccr_reset,
        kind.ccr_writable,
        fidelity=Fidelity.PARTLY if kind.ccsidr else Fidelity.MODELLED,
        note=f"IC and DC: {_CACHES}" if kind.ccsidr else "",
    )
    yield Register("CPACR", _CPACR, 0, 0 if kind.fpu is None else _CP10 | _CP11)
    for index, (name, value) in enumerate(zip(_IDENTITY, kind.identity, strict=True)):
        yield Register(name, 0xD40 + 4 * index, value, 0)
    if not kind.mpu_regions:
        for index, name in enumerate(_MPU):
            yield Register(f"MPU_{name}", 0xD90 + 4 * index, 0, 0)
    yield from component_id(kind.component_ids["SCS"], 0xE)


_SAME_REGISTERS = (
    Register("ICSR", _ICSR, 0),
    Register("AIRCR", _AIRCR, _KEY_READ << 16),
    Register("SCR", _SCR, 0, _SLEEPONEXIT | _SLEEPDEEP | _SEVONPEND),
    Register("SHPR1", _SHPR1),
    Register("SHPR2", _SHPR1 + 4),
    Register("SHPR3", _SHPR1 + 8),
    Register("SHCSR", _SHCSR),
    Register(
        "CFSR",
        _CFSR,
        fidelity=Fidelity.PARTLY,
        note="bus faults are precise: IMPRECISERR is never set",
    ),
    Register("HFSR", _HFSR),
    Register("DFSR", _DFSR),
    Register("MMFAR", _MMFAR),
    Register("BFAR", _BFAR),
    Register("AFSR", 0xD3C, 0, 0),
    Register("DHCSR", _DHCSR, fidelity=Fidelity.PARTLY, note="there is no debugger: it cannot be enabled"),
    Register("DCRSR", 0xDF4, 0, 0, fidelity=Fidelity.ABSENT, note="there is no debugger"),
    Register("DCRDR", 0xDF8),
    Register(
        "DEMCR",
        _DEMCR,
        0,
        0x010F_07F1,
        _MON_STEP | 0x7F1,
        fidelity=Fidelity.PARTLY,
        note="there is no debugger to catch vectors, and the monitor does not step",
    ),
)


class Scb(LaneBlock):
    """System control and debug registers.

    Args:
        kind: the core.
        exceptions: the state that ICSR, SHCSR and SHPR show.

    Attributes:
        on_core_reset: called when firmware asks for a reset of the core alone (AIRCR.VECTRESET); it must happen at
            the next instruction boundary.
        on_trace: called with the new DEMCR.TRCENA when it changes.
        on_traps: called with DIV_0_TRP and UNALIGN_TRP of CCR when one of them changes.
        on_coprocessors: called when CPACR changes.
    """

    ONES_ACT: ClassVar[frozenset[str]] = frozenset({"ICSR", "AIRCR", "CFSR", "HFSR", "DFSR", "DHCSR"})

    def __init__(
        self,
        base: int,
        services: Services,
        exceptions: Exceptions,
        kind: CoreKind,
    ) -> None:
        self._kind = kind
        self._exceptions = exceptions
        self._kept = exceptions.kept
        self.on_core_reset: Callable[[], None] = self._note_core_reset
        self.on_trace: Callable[[bool], None] = lambda _enabled: None
        self.on_traps: Callable[[bool, bool], None] = lambda _division, _unaligned: None
        self.on_coprocessors: Callable[[], None] = lambda: None
        super().__init__("SCB", base, services)
        self._reset_seen = True

    def registers_of(self) -> Iterable[Register]:
        """Return the registers of this core."""
        return _registers(self._kind)

    def reset(self) -> None:
        """Go to the state after a system reset; the trace enable and vector catch of DEMCR last until power-on."""
        kept = self[_DEMCR] & (_TRCENA | 0x7F1)
        self.write_CCR(0)
        super().reset()
        self._kept.vtor, self._kept.ccr, self._kept.scr = 0, self._kind.ccr_reset, 0
        self[_DEMCR] = kept
        self.on_coprocessors()
        self._reset_seen = True

    def power_on(self) -> None:
        """Go to the state after power-on, beyond `reset`."""
        self[_DEMCR] = 0
        self.on_trace(False)

    def trace_as_debugger(self) -> None:
        """Set DEMCR.TRCENA."""
        self[_DEMCR] |= _TRCENA
        self.on_trace(True)

    # --- what the core asks

    @property
    def data_cache_on(self) -> bool:
        """CCR.DC."""
        return bool(self._kept.ccr & _DC)

    @property
    def float_access(self) -> int:
        """CPACR.CP10: 0 nobody may use floating point, 1 privileged software, 3 everybody."""
        return (self[_CPACR] & _CP10) >> 20

    @property
    def anybody_may_trigger(self) -> bool:
        """CCR.USERSETMPEND: STIR is open to unprivileged software."""
        return bool(self._kept.ccr & _USERSETMPEND)

    @property
    def ignores_bus_faults(self) -> bool:
        """CCR.BFHFNMIGN: handlers of HardFault and NMI pass over loads and stores that fail."""
        return bool(self._kept.ccr & _BFHFNMIGN)

    @property
    def sleep_deep(self) -> bool:
        """SCR.SLEEPDEEP."""
        return bool(self._kept.scr & _SLEEPDEEP)

    @property
    def trace_enabled(self) -> bool:
        """DEMCR.TRCENA."""
        return bool(self[_DEMCR] & _TRCENA)

    def move_vector_table(self, address: int) -> None:
        """Set VTOR as a boot loader would have left it."""
        self._kept.vtor = address & self._kind.vtor_bits

    def record_fault(self, cfsr: int, hfsr: int, address: int | None) -> None:
        """Set bits of CFSR and HFSR, and BFAR if there is an address."""
        self[_CFSR] |= cfsr
        self[_HFSR] |= hfsr
        if address is not None:
            self[_BFAR] = address

    def record_breakpoint(self) -> None:
        """Set DFSR.BKPT."""
        self[_DFSR] |= _DFSR_BKPT

    # --- registers

    def read_ICSR(self) -> int:
        """Return what is pending and active."""
        return self._exceptions.read_word(_ICSR)

    def write_ICSR(self, value: int) -> None:
        """Make NMI, PendSV and SysTick pending or not."""
        self._exceptions.write_word(_ICSR, value)

    def read_VTOR(self) -> int:
        """Return where the vector table is."""
        return int(self._kept.vtor)

    def write_VTOR(self, value: int) -> None:
        """Move the vector table; it must be aligned to its size, rounded up to a power of two."""
        size = 1 << (4 * self._exceptions.count - 1).bit_length()
        if value & size - 1:
            self.note("misuse", "VTOR", f"0x{value:08X} is not a multiple of {size}, the size of the vector table")
        self._kept.vtor = value

    def write_AIRCR(self, value: int) -> None:
        """Set the priority grouping, ask for resets; only with the key in the upper half."""
        if value >> 16 != _KEY:
            self.note("misuse", "AIRCR", "a write without the key 0x05FA in bits 31:16 has no effect")
            return
        self[_AIRCR] = _KEY_READ << 16 | value & _PRIGROUP
        self._exceptions.set_grouping((value & _PRIGROUP) >> 8)
        if value & _VECTCLRACTIVE:
            self.note("misuse", "AIRCR.VECTCLRACTIVE", "reserved for a debugger: has no effect")
        if value & _SYSRESETREQ:
            self.services.chip_reset("SFT")
        elif value & _VECTRESET:
            self.on_core_reset()

    def read_SCR(self) -> int:
        """Return how to sleep."""
        return int(self._kept.scr)

    def write_SCR(self, value: int) -> None:
        """Choose how to sleep."""
        self._kept.scr = value
        self._kept.event_on_pend = bool(value & _SEVONPEND)

    def read_CCR(self) -> int:
        """Return what `write_CCR` chose."""
        return int(self._kept.ccr)

    def write_CCR(self, value: int) -> None:
        """Choose what traps, how frames are aligned, and who may do what."""
        changed = self._kept.ccr ^ value
        self._kept.ccr = value
        if changed & (_DIV_0_TRP | _UNALIGN_TRP):
            self.on_traps(bool(value & _DIV_0_TRP), bool(value & _UNALIGN_TRP))
        if value & _DC:
            self.note(
                "unmodelled",
                "CCR.DC",
                f"{_CACHES}: what a program forgets to clean or invalidate around DMA is not found",
            )

    def write_CPACR(self, value: int) -> None:
        """Allow or deny floating point; both fields must be the same."""
        if (value & _CP11) >> 2 != value & _CP10:
            self.note("misuse", "CPACR", "CP10 and CP11 differ, which is UNPREDICTABLE; CP10 counts (choice; QEMU too)")
        self[_CPACR] = value
        self.on_coprocessors()

    def write_SHPR1(self, value: int) -> None:
        """Set the priorities of MemManage, BusFault and UsageFault."""
        self._set_priorities(4, value)

    def write_SHPR2(self, value: int) -> None:
        """Set the priority of SVCall."""
        self._set_priorities(8, value)

    def write_SHPR3(self, value: int) -> None:
        """Set the priorities of DebugMonitor, PendSV and SysTick."""
        self._set_priorities(12, value)

    def _set_priorities(self, first: int, value: int) -> None:
        kept = 0
        for number in _CONFIGURABLE:
            if first <= number < first + 4:
                self._exceptions.set_priority(number, value >> 8 * (number - first) & 0xFF)
                kept |= self._exceptions.priorities[number] << 8 * (number - first)
        self[_SHPR1 - 4 + first] = kept

    def read_SHCSR(self) -> int:
        """Return which system handlers are active, pending and enabled."""
        exceptions = self._exceptions
        return sum(
            is_so(number) << bit
            for table, is_so in (
                (_SHCSR_ACTIVE, exceptions.is_active),
                (_SHCSR_PENDED, exceptions.is_pending),
                (_SHCSR_ENABLED, exceptions.is_enabled),
            )
            for number, bit in table.items()
        )

    def write_SHCSR(self, value: int) -> None:
        """Change which system handlers are active, pending and enabled: all as written."""
        exceptions = self._exceptions
        for number, bit in _SHCSR_ACTIVE.items():
            exceptions.set_active(number, bool(value >> bit & 1))
        for table, set_it, clear_it in (
            (_SHCSR_PENDED, exceptions.pend, exceptions.unpend),
            (_SHCSR_ENABLED, exceptions.enable, exceptions.disable),
        ):
            for number, bit in table.items():
                (set_it if value >> bit & 1 else clear_it)(number)

    def write_CFSR(self, value: int) -> None:
        """Clear the bits that are written as one."""
        self[_CFSR] &= ~value

    def write_HFSR(self, value: int) -> None:
        """Clear the bits that are written as one."""
        self[_HFSR] &= ~value

    def write_DFSR(self, value: int) -> None:
        """Clear the bits that are written as one."""
        self[_DFSR] &= ~value

    def read_DHCSR(self) -> int:
        """Return what software sees without a debugger: instructions retire; the reset since the last read."""
        value = _S_REGRDY | _S_RETIRE_ST | (_S_RESET_ST if self._reset_seen else 0)
        self._reset_seen = False
        return value

    def write_DHCSR(self, _value: int) -> None:
        """Have no effect: only a debugger can enable debug."""

    def read_DEMCR(self) -> int:
        """Return trace and monitor enables; MON_PEND is the pending state of DebugMonitor."""
        pending = _MON_PEND if self._exceptions.is_pending(Number.DEBUG_MONITOR) else 0
        return self[_DEMCR] & ~_MON_PEND | pending

    def write_DEMCR(self, value: int) -> None:
        """Enable trace and the monitor, make the monitor pending."""
        before, exceptions = self[_DEMCR], self._exceptions
        self[_DEMCR] = value & ~_MON_PEND
        monitor = Number.DEBUG_MONITOR
        (exceptions.enable if value & _MON_EN else exceptions.disable)(monitor)
        (exceptions.pend if value & _MON_PEND else exceptions.unpend)(monitor)
        if (before ^ value) & _TRCENA:
            self.on_trace(bool(value & _TRCENA))

    def other_lanes(self, offset: int) -> int:
        """Return the word that a narrow write to `offset` is merged into."""
        if offset in (_SHCSR, _DEMCR, _VTOR, _CCR, _SCR):
            return self.read(offset)
        return super().other_lanes(offset)

    def _note_core_reset(self) -> None:
        self.note("unmodelled", "AIRCR.VECTRESET", "a reset of the core alone is not done here")
