"""The system control block (DDI0403 section B3.2, PM0056 section 4.4) with the debug registers that software can see.

The core is a Cortex-M3 r1p1 (CPUID 0x411FC231), as in every STM32F103. Of that revision STKALIGN resets to 0 (ARM ABI
advisory 1, IHI0046; r2p0 changed it to 1), VTOR has bits 29 to 7 (Cortex-M3 TRM r1p1), and there is no MPU.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import ClassVar

from targets.mcu.cortexm.exceptions import Exceptions, Number
from targets.mcu.cortexm.ppb import LaneBlock, component_id
from targets.mcu.fidelity import Fidelity
from targets.mcu.registers import Register
from targets.mcu.services import Services

__all__ = ["Scb"]

_ICSR, _VTOR, _AIRCR, _SCR, _CCR = 0xD04, 0xD08, 0xD0C, 0xD10, 0xD14
_SHPR1, _SHCSR, _CFSR, _HFSR, _DFSR, _MMFAR, _BFAR = 0xD18, 0xD24, 0xD28, 0xD2C, 0xD30, 0xD34, 0xD38
_DHCSR, _DEMCR = 0xDF0, 0xDFC

_NMIPENDSET, _PENDSVSET, _PENDSVCLR, _PENDSTSET, _PENDSTCLR = 1 << 31, 1 << 28, 1 << 27, 1 << 26, 1 << 25
_ISRPENDING, _RETTOBASE = 1 << 22, 1 << 11
_VTOR_BITS = 0x3FFF_FF80
_KEY, _KEY_READ = 0x05FA, 0xFA05
_PRIGROUP = 0x700
_VECTRESET, _VECTCLRACTIVE, _SYSRESETREQ = 1 << 0, 1 << 1, 1 << 2
_SLEEPONEXIT, _SLEEPDEEP, _SEVONPEND = 1 << 1, 1 << 2, 1 << 4
_NONBASETHRDENA, _USERSETMPEND, _UNALIGN_TRP, _DIV_0_TRP = 1 << 0, 1 << 1, 1 << 3, 1 << 4
_BFHFNMIGN, _STKALIGN = 1 << 8, 1 << 9
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

# Cortex-M3 TRM r1p1, table of the CPUID registers from 0xE000ED40 on
_IDENTITY = {
    "PFR0": 0x0000_0030,
    "PFR1": 0x0000_0200,
    "DFR0": 0x0010_0000,
    "AFR0": 0,
    "MMFR0": 0x0000_0030,
    "MMFR1": 0,
    "MMFR2": 0,
    "MMFR3": 0,
    "ISAR0": 0x0114_1110,
    "ISAR1": 0x0211_1000,
    "ISAR2": 0x2111_2231,
    "ISAR3": 0x0111_1110,
    "ISAR4": 0x0131_0102,
}
_MPU = ("TYPE", "CTRL", "RNR", "RBAR", "RASR", "RBAR_A1", "RASR_A1", "RBAR_A2", "RASR_A2", "RBAR_A3", "RASR_A3")


def _fixed_registers() -> list[Register]:
    fixed = [Register(name, 0xD40 + 4 * index, value, 0) for index, (name, value) in enumerate(_IDENTITY.items())]
    fixed += [Register(f"MPU_{name}", 0xD90 + 4 * index, 0, 0) for index, name in enumerate(_MPU)]
    fixed += component_id(0x04, 0, 0, 0, 0x00, 0xB0, 0x1B, 0x00, 0x0D, 0xE0, 0x05, 0xB1)
    return fixed


class Scb(LaneBlock):
    """System control and debug registers.

    Args:
        exceptions: the state that ICSR, SHCSR and SHPR show.
        running: returns the number of the exception that runs, 0 in Thread mode.
        masks: returns PRIMASK, BASEPRI and FAULTMASK.

    Attributes:
        on_core_reset: called when firmware asks for a reset of the core alone (AIRCR.VECTRESET); it must happen at
            the next instruction boundary.
        on_trace: called with the new DEMCR.TRCENA when it changes.
        on_traps: called with DIV_0_TRP and UNALIGN_TRP of CCR when one of them changes.
    """

    REGISTERS = (
        Register("ICTR", 0x004, 0, 0),
        Register("ACTLR", 0x008, 0, 0b111, note="changes timing that is not modelled"),
        Register("CPUID", 0xD00, 0x411F_C231, 0),
        Register("ICSR", _ICSR, 0),
        Register("VTOR", _VTOR, 0, _VTOR_BITS),
        Register("AIRCR", _AIRCR, _KEY_READ << 16),
        Register("SCR", _SCR, 0, _SLEEPONEXIT | _SLEEPDEEP | _SEVONPEND),
        Register(
            "CCR",
            _CCR,
            0,
            _NONBASETHRDENA | _USERSETMPEND | _UNALIGN_TRP | _DIV_0_TRP | _BFHFNMIGN | _STKALIGN,
            fidelity=Fidelity.PARTLY,
            note="DIV_0_TRP finds divisions in flash only; UNALIGN_TRP traps after the access has happened; "
            "without it an unaligned LDM, STM, LDRD or STRD is done, where silicon faults",
        ),
        Register("SHPR1", _SHPR1),
        Register("SHPR2", _SHPR1 + 4),
        Register("SHPR3", _SHPR1 + 8),
        Register("SHCSR", _SHCSR),
        Register(
            "CFSR",
            _CFSR,
            fidelity=Fidelity.PARTLY,
            note="bus faults are precise: IMPRECISERR is never set; UNALIGNED only with CCR.UNALIGN_TRP",
        ),
        Register("HFSR", _HFSR),
        Register("DFSR", _DFSR),
        Register("MMFAR", _MMFAR),
        Register("BFAR", _BFAR),
        Register("AFSR", 0xD3C, 0, 0),
        Register("CPACR", 0xD88, 0, 0),
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
        *_fixed_registers(),
    )
    ONES_ACT: ClassVar[frozenset[str]] = frozenset({"ICSR", "AIRCR", "CFSR", "HFSR", "DFSR", "DHCSR"})

    def __init__(
        self,
        base: int,
        services: Services,
        exceptions: Exceptions,
        running: Callable[[], int],
        masks: Callable[[], tuple[int, int, int]],
    ) -> None:
        self._exceptions = exceptions
        self._running = running
        self._masks = masks
        self.on_core_reset: Callable[[], None] = self._note_core_reset
        self.on_trace: Callable[[bool], None] = lambda _enabled: None
        self.on_traps: Callable[[bool, bool], None] = lambda _division, _unaligned: None
        super().__init__("SCB", base, services)
        self[0x004] = (exceptions.count - Number.FIRST_IRQ - 1) // 32
        self._reset_seen = True

    def reset(self) -> None:
        """Go to the state after a system reset; the trace enable and vector catch of DEMCR last until power-on."""
        kept = self[_DEMCR] & (_TRCENA | 0x7F1)
        lines = self[0x004]
        self.write_CCR(0)
        super().reset()
        self[0x004], self[_DEMCR] = lines, kept
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
    def vector_table(self) -> int:
        """Address of the vector table."""
        return self[_VTOR]

    @property
    def stack_align(self) -> bool:
        """CCR.STKALIGN: frames begin at multiples of eight."""
        return bool(self[_CCR] & _STKALIGN)

    @property
    def thread_from_any_level(self) -> bool:
        """CCR.NONBASETHRDENA."""
        return bool(self[_CCR] & _NONBASETHRDENA)

    @property
    def anybody_may_trigger(self) -> bool:
        """CCR.USERSETMPEND: STIR is open to unprivileged software."""
        return bool(self[_CCR] & _USERSETMPEND)

    @property
    def ignores_bus_faults(self) -> bool:
        """CCR.BFHFNMIGN: handlers of HardFault and NMI pass over loads and stores that fail."""
        return bool(self[_CCR] & _BFHFNMIGN)

    @property
    def sleep_on_exit(self) -> bool:
        """SCR.SLEEPONEXIT."""
        return bool(self[_SCR] & _SLEEPONEXIT)

    @property
    def sleep_deep(self) -> bool:
        """SCR.SLEEPDEEP."""
        return bool(self[_SCR] & _SLEEPDEEP)

    @property
    def trace_enabled(self) -> bool:
        """DEMCR.TRCENA."""
        return bool(self[_DEMCR] & _TRCENA)

    def move_vector_table(self, address: int) -> None:
        """Set VTOR as a boot loader would have left it."""
        self[_VTOR] = address & _VTOR_BITS

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
        exceptions, running = self._exceptions, self._running()
        value = running
        if running and exceptions.active & ~(1 << running) == 0:
            value |= _RETTOBASE
        _primask, basepri, faultmask = self._masks()
        if exceptions.best_priority < exceptions.boosted(0, basepri, faultmask):
            value |= exceptions.best << 12
        if exceptions.pending >> Number.FIRST_IRQ:
            value |= _ISRPENDING
        for number, bit in ((Number.NMI, _NMIPENDSET), (Number.PENDSV, _PENDSVSET), (Number.SYSTICK, _PENDSTSET)):
            if exceptions.is_pending(number):
                value |= bit
        return value

    def write_ICSR(self, value: int) -> None:
        """Make NMI, PendSV and SysTick pending or not. Of both at once, setting wins (choice)."""
        if value & _PENDSVCLR:
            self._exceptions.unpend(1 << Number.PENDSV)
        if value & _PENDSTCLR:
            self._exceptions.unpend(1 << Number.SYSTICK)
        for number, bit in ((Number.NMI, _NMIPENDSET), (Number.PENDSV, _PENDSVSET), (Number.SYSTICK, _PENDSTSET)):
            if value & bit:
                self._exceptions.pend(1 << number)

    def write_VTOR(self, value: int) -> None:
        """Move the vector table; it must be aligned to its size, rounded up to a power of two."""
        size = 1 << (4 * self._exceptions.count - 1).bit_length()
        if value & size - 1:
            self.note("misuse", "VTOR", f"0x{value:08X} is not a multiple of {size}, the size of the vector table")
        self[_VTOR] = value

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

    def write_SCR(self, value: int) -> None:
        """Choose how to sleep."""
        self[_SCR] = value
        self._exceptions.event_on_pend = bool(value & _SEVONPEND)

    def write_CCR(self, value: int) -> None:
        """Choose what traps, how frames are aligned, and who may do what."""
        changed = self[_CCR] ^ value
        self[_CCR] = value
        if changed & (_DIV_0_TRP | _UNALIGN_TRP):
            self.on_traps(bool(value & _DIV_0_TRP), bool(value & _UNALIGN_TRP))

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
        exceptions, value = self._exceptions, 0
        for table, numbers in (
            (_SHCSR_ACTIVE, exceptions.active),
            (_SHCSR_PENDED, exceptions.pending),
            (_SHCSR_ENABLED, exceptions.enabled),
        ):
            for number, bit in table.items():
                value |= (numbers >> number & 1) << bit
        return value

    def write_SHCSR(self, value: int) -> None:
        """Change which system handlers are active, pending and enabled: all as written."""
        exceptions = self._exceptions
        for number, bit in _SHCSR_ACTIVE.items():
            exceptions.set_active(number, bool(value >> bit & 1))
        for table, set_them, clear_them in (
            (_SHCSR_PENDED, exceptions.pend, exceptions.unpend),
            (_SHCSR_ENABLED, exceptions.enable, exceptions.disable),
        ):
            for number, bit in table.items():
                (set_them if value >> bit & 1 else clear_them)(1 << number)

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
        monitor = 1 << Number.DEBUG_MONITOR
        (exceptions.enable if value & _MON_EN else exceptions.disable)(monitor)
        (exceptions.pend if value & _MON_PEND else exceptions.unpend)(monitor)
        if (before ^ value) & _TRCENA:
            self.on_trace(bool(value & _TRCENA))

    def other_lanes(self, offset: int) -> int:
        """Return the word that a narrow write to `offset` is merged into."""
        if offset in (_SHCSR, _DEMCR):
            return self.read(offset)
        return super().other_lanes(offset)

    def _note_core_reset(self) -> None:
        self.note("unmodelled", "AIRCR.VECTRESET", "a reset of the core alone is not done here")
