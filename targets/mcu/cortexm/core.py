"""A Cortex-M around its instructions: its peripheral bus, escalates faults, locks up.

After the ARMv7-M Architecture Reference Manual (DDI0403), section B1.5. The engine takes exceptions and returns from
them by itself (``entry.c``, which tells how long that takes) and stops where somebody has to act: `handle`.

Not modelled: imprecise bus faults, the vector's flash wait states, faults that wait until a debugger looks. Divisions,
loads and stores of several words, which silicon abandons or interrupts, are completed before an exception is taken.
"""

from __future__ import annotations

import enum
from collections.abc import Callable

from targets.mcu.cortexm.caches import Caches
from targets.mcu.cortexm.debug import Fpb, RomTable, Tpiu
from targets.mcu.cortexm.dwt import Dwt
from targets.mcu.cortexm.exceptions import Exceptions, Line, Number
from targets.mcu.cortexm.faults import Cfsr, Fault, Hfsr, Lockup
from targets.mcu.cortexm.fpu import Fpu
from targets.mcu.cortexm.itm import Itm
from targets.mcu.cortexm.kinds import CORTEX_M3, CoreKind
from targets.mcu.cortexm.mpu import Mpu
from targets.mcu.cortexm.nvic import Nvic
from targets.mcu.cortexm.ppb import LaneBlock
from targets.mcu.cortexm.scb import Scb
from targets.mcu.cortexm.scs import SCS_BASE, Scs
from targets.mcu.cortexm.stepping import step_over
from targets.mcu.cortexm.systick import SysTick
from targets.mcu.engine.api import FaultKind, FloatAccess, Reg, Stop, StopKind
from targets.mcu.engine.core_engine import CoreEngine
from targets.mcu.errors import BusFault
from targets.mcu.registers import Peripheral
from targets.mcu.services import IrqLine, Services

__all__ = ["Core"]

_T_BIT = 1 << 24
_IPSR, _NPRIV = 0x1FF, 1 << 0
_HARD_FAULT_PRIORITY = -1
_FLOATING_POINT = 0b101  # the upper three bits of the numbers of coprocessors 10 and 11
_USAGE = {
    FaultKind.STATE: Cfsr.INVSTATE,
    FaultKind.DIVISION: Cfsr.DIVBYZERO,
    FaultKind.UNALIGNED: Cfsr.UNALIGNED,
}
_EXECUTE_NEVER = frozenset({2, 5, 6, 7})  # eighths of the address space: peripherals, devices, system (table B3-1)


class _Trouble(enum.IntEnum):
    """``enum hil_trouble``; see there (`exceptions.h`). The first two may come together."""

    STACK_FLOATS = 1
    STACK = 2
    VECTOR = 4
    STATE = 5
    NEVER = 6
    RETURN = 7
    RETURN_FLOATS = 8
    UNSTACK = 9
    CALL = 10


_STACKS_ANEW = {
    _Trouble.STATE: (Number.USAGE_FAULT, Cfsr.INVSTATE),
    _Trouble.NEVER: (Number.MEM_MANAGE, Cfsr.IACCVIOL),
}
_TAKES_TIME = {
    _Trouble.RETURN: (Number.USAGE_FAULT, Cfsr.INVPC),
    _Trouble.RETURN_FLOATS: (Number.USAGE_FAULT, Cfsr.NOCP),
    _Trouble.UNSTACK: (Number.BUS_FAULT, Cfsr.UNSTKERR),
}


class Core:
    """Exceptions, faults, sleep and the private peripheral bus of one core.

    Args:
        cpu: executes instructions, and has what is used for stacking and vectors.
        services: what the chip offers; its `time` is used by timers.
        kind: what core it is.

    Attributes:
        kind: as given.
        peripherals: what the machine puts on the bus.
        blocks: the same with the parts of the system control space told apart, for the ledger.
        exceptions: what is pending, enabled and active.
        locked_up: how the core came to stop for good, or None.
        last_fault: the last fault since the core was made, or None.
        on_fault: called with every fault, before its handler runs.
    """

    def __init__(self, cpu: CoreEngine, services: Services, kind: CoreKind = CORTEX_M3) -> None:
        self._cpu = cpu
        self._services = services
        self._bus = services.bus
        self._time = services.time
        self._notes = services.notes
        self.kind = kind
        self.exceptions = Exceptions(cpu, kind.irq_count, kind.priority_bits)
        self._kept = self.exceptions.kept
        self._nmi = Line(self.exceptions, Number.NMI)
        self._others: list[LaneBlock] = []
        self.systick = SysTick(SCS_BASE, services, cpu, self.exceptions, kind.systick_calibration)
        self.nvic = Nvic(SCS_BASE, services, self.exceptions)
        self.scb = Scb(SCS_BASE, services, self.exceptions, kind)
        self._mpu = Mpu(SCS_BASE, services, kind.mpu_regions) if kind.mpu_regions else None
        self._caches = Caches(SCS_BASE, services, kind.ccsidr, kind.tcm) if kind.ccsidr else None
        self._others += [block for block in (self._mpu, self._caches) if block is not None]
        trace_enabled = lambda: self.scb.trace_enabled  # noqa: E731
        ids = kind.component_ids
        self.itm = Itm(services, self._privileged, ids["ITM"], trace_enabled)
        self.dwt = Dwt(services, self._privileged, ids["DWT"], trace_enabled, lock=kind.dwt_lock)
        if kind.fpu is not None:
            self._others.append(Fpu(SCS_BASE, services, kind.fpu, cpu))
            self.scb.on_coprocessors = self._choose_float_access
        scs = Scs(services, self._privileged, self.systick, self.nvic, self.scb, *self._others)
        fpb, tpiu = Fpb(services, self._privileged, ids["FPB"]), Tpiu(services, self._privileged, ids["TPIU"])
        rom = RomTable(services, self._privileged)
        self._debug = (self.itm, self.dwt, fpb, tpiu)
        self.peripherals: tuple[Peripheral, ...] = (self.itm, self.dwt, fpb, scs, tpiu, rom)
        self.blocks: tuple[Peripheral, ...] = (self.itm, self.dwt, fpb, *scs.parts, tpiu, rom)
        self.locked_up: Lockup | None = None
        self.last_fault: Fault | None = None
        self._on_running: Callable[[int], None] | None = None
        self.on_fault: Callable[[Fault], None] = lambda _fault: None
        self.scb.on_trace = self.dwt.gate
        self.scb.on_traps = lambda division, unaligned: cpu.set_traps(division=division, unaligned=unaligned)
        self._traced = False
        self._open_faults: dict[int, Fault] = {}  # by exception; of those in `hil_exceptions.open_faults`
        self.can_take = cpu.asking("hil_can_take")
        self.wakes = cpu.asking("hil_wakes")
        self.wake = cpu.asking("hil_wake")
        self._stack = cpu.asking("hil_stack")

    # --- from the chip

    def irq(self, number: int) -> IrqLine:
        """Return the interrupt input of that number.

        Raises:
            ValueError: the chip has no such interrupt.
        """
        if not 0 <= number < len(self.exceptions.lines):
            raise ValueError(f"there is no interrupt {number}")
        return self.exceptions.lines[number]

    @property
    def pc(self) -> int:
        """Where the program is: the instruction in flight, or the next."""
        return self._cpu.get(Reg.PC)

    def data_may_be_cached(self, address: int) -> bool:
        """Say whether the data cache is on and may hold an address, and the program has never cleaned or invalidated.

        Somebody else who looks there, as DMA does, and the program may see different things then, on silicon.
        """
        caches, mpu = self._caches, self._mpu
        if caches is None or mpu is None or caches.maintained or not self.scb.data_cache_on:
            return False
        return mpu.cached(address)

    def set_nmi(self, level: bool) -> None:
        """Drive the input of the non-maskable interrupt; while it is high, its handler runs again and again."""
        self._nmi.set(level)

    def receive_event(self) -> None:
        """Take a pulse of the event input (RXEV), which the chip has besides its interrupts: for WFE."""
        self._kept.event = True

    def reset(self, vector_base: int, *, power_on: bool = False) -> None:
        """Start anew: stack pointer and PC from the vector table.

        Args:
            vector_base: where the table is: 0, or where a boot loader would have left VTOR before jumping.
            power_on: what lasts over a system reset starts anew too: DWT, ITM, trace enable.
        """
        cpu = self._cpu
        self.exceptions.reset()
        for peripheral in self.blocks:
            peripheral.reset()
        if power_on:
            self._power_on()
        self.scb.move_vector_table(vector_base)
        self.locked_up = None
        self.hold_clocks(False)
        cpu.set(Reg.XPSR, _T_BIT)
        for register in (Reg.CONTROL, Reg.PRIMASK, Reg.BASEPRI, Reg.FAULTMASK, Reg.PSP):
            cpu.set(register, 0)
        cpu.set(Reg.LR, 0xFFFF_FFFF)
        try:
            stack, entry = (self._bus.read(vector_base + offset, 4) for offset in (0, 4))
        except BusFault:
            self._lock_up(f"the reset vector at 0x{vector_base:08X} cannot be read", None)
            return
        cpu.set(Reg.MSP, stack & ~3)
        cpu.set(Reg.PC, entry & ~1)
        cpu.set(Reg.XPSR, _T_BIT * (entry & 1))
        if not entry & 1:
            self._put_right(_Trouble.STATE)
        elif entry >> 29 in _EXECUTE_NEVER:
            self._put_right(_Trouble.NEVER)

    def trace_as_debugger(self) -> None:
        """Open the trace as a debugger does that listens to ITM, now and after every power-on."""
        self._traced = True
        self.scb.trace_as_debugger()
        self.itm.trace_as_debugger()

    def _power_on(self) -> None:
        self.scb.power_on()
        for block in self._debug:
            block.power_on()
        if self._traced:
            self.trace_as_debugger()

    # --- what runs

    @property
    def running(self) -> int:
        """Number of the exception that runs, 0 in Thread mode."""
        return self._cpu.get(Reg.XPSR) & _IPSR

    @property
    def sleeping(self) -> bool:
        """WFI, WFE or SLEEPONEXIT stopped the CPU; see `wakes`."""
        return bool(self._kept.sleeping)

    @property
    def on_running(self) -> Callable[[int], None] | None:
        """Called with `running` at every exception entry and return, when the next instruction may begin; or None."""
        return self._on_running

    @on_running.setter
    def on_running(self, listener: Callable[[int], None] | None) -> None:
        self._on_running = listener
        self._kept.began = False  # what began before is not for who listens from now on

    def go_by_steps(self, wanted: bool) -> None:
        """Have the engine stop after each step of an entry or return, or only if somebody listens to `on_running`."""
        self._kept.by_steps = wanted or self._on_running is not None

    # --- between two instructions

    def take(self) -> bool:
        """Do one step of exception entry or return; return whether there was one. Wakes a sleeping CPU."""
        if not self.can_take():
            return False
        self._put_right(self._cpu.ask("hil_take"))
        return True

    def handle(self, stop: Stop) -> None:
        """Do what the engine stopped for. A BREAKPOINT of semihosting is not for here."""
        if stop.kind is StopKind.TROUBLE:
            self._put_right(stop.value)
        elif stop.kind is StopKind.FAULT:
            self._instruction_fault(stop)
        elif stop.kind is StopKind.BREAKPOINT:
            self._breakpoint()
        else:
            self._put_right(self._cpu.act(stop))

    def _put_right(self, trouble: int) -> None:
        """Record the fault because of which a step of entry or return could not go on, and go on, up to the next."""
        self._tell_running()
        while trouble:
            trouble = self._after_fault(_Trouble(trouble)) if trouble >= _Trouble.VECTOR else self._not_stacked(trouble)
            self._tell_running()

    def _tell_running(self) -> None:
        if self._kept.began:
            self._kept.began = False
            if self._on_running is not None:
                self._on_running(self.running)

    def _not_stacked(self, trouble: int) -> int:
        if trouble & _Trouble.STACK_FLOATS:
            self._fault(Number.USAGE_FAULT, cfsr=Cfsr.NOCP)
        if trouble & _Trouble.STACK:
            self._fault(Number.BUS_FAULT, cfsr=Cfsr.STKERR)
        return self._let_time_pass()

    def _after_fault(self, trouble: _Trouble) -> int:
        if trouble is _Trouble.VECTOR:
            return self._vector_fault(self._kept.best)
        if trouble is _Trouble.CALL:
            return self._escalate_call()
        if trouble in _TAKES_TIME:
            origin, cfsr = _TAKES_TIME[trouble]
            self._fault(origin, cfsr=cfsr)
            return self._let_time_pass()
        origin, cfsr = _STACKS_ANEW[trouble]
        self._fault(origin, cfsr=cfsr)
        return self._stack_unless_locked()

    def _let_time_pass(self) -> int:
        if self.locked_up is None:
            self._cpu.ask("hil_pay")
        return 0

    def _vector_fault(self, number: int) -> int:
        """The vector could not be read: a HardFault takes over, unless it is its own vector."""
        if number <= Number.HARD_FAULT:
            self._lock_up("the vector table cannot be read", None)
            return 0
        self._fault(Number.HARD_FAULT, hfsr=Hfsr.VECTTBL)
        return self._cpu.ask("hil_take") if self.locked_up is None else 0

    def _escalate_call(self) -> int:
        """SVC where the priority does not allow one.

        What is escalated returns to where it would have by nature (DDI0403 section B1.5.4), which is behind the
        instruction for SVCall (`ReturnAddress`). QEMU does so, and kernels look for the SVC before that address.
        """
        behind = self._cpu.get(Reg.PC)
        self._cpu.set(Reg.PC, behind - 2)  # the record names the instruction
        self._fault(Number.SVCALL)
        if self.locked_up is None:
            self._cpu.set(Reg.PC, behind)
        return self._stack_unless_locked()

    def _stack_unless_locked(self) -> int:
        return self._stack() if self.locked_up is None else 0

    # --- sleep

    @property
    def deep(self) -> bool:
        """SCR.SLEEPDEEP: sleeping is Stop or Standby."""
        return self.scb.sleep_deep

    def may_wake(self, *, events: bool) -> bool:
        """Say whether a sleeping CPU can still wake: by an exception that may yet come, but for an NMI, or an event.

        Args:
            events: the chip may send events besides its interrupts.
        """
        exceptions, kept = self.exceptions, self._kept
        if kept.for_event and (events or kept.event_on_pend):
            return True
        primask, basepri, faultmask = self._masks()
        boosted = exceptions.boosted(primask if kept.for_event else 0, basepri, faultmask)
        now = min(kept.active_priority, boosted)
        first = Number.SYSTICK if self.systick.interrupts() else Number.FIRST_IRQ
        return any(
            exceptions.is_enabled(number) and exceptions.group_priority(exceptions.priorities[number]) < now
            for number in range(first, exceptions.count)
        )

    def hold_clocks(self, held: bool) -> None:
        """Let what counts in the core stand still, as in Stop mode, or go on."""
        self.systick.hold(held)
        self.dwt.hold(held)

    # --- what instructions ask for

    def _breakpoint(self) -> None:
        """BKPT without a debugger: DebugMonitor if that is enabled and urgent enough, else a HardFault."""
        exceptions, monitor = self.exceptions, Number.DEBUG_MONITOR
        self.scb.record_breakpoint()
        if (
            exceptions.is_enabled(monitor)
            and exceptions.group_priority(exceptions.priorities[monitor]) < self._execution_priority()
        ):
            exceptions.pend(monitor)
        else:
            self._fault(Number.HARD_FAULT, hfsr=Hfsr.DEBUGEVT)
        self._put_right(self._stack_unless_locked())

    def _instruction_fault(self, stop: Stop) -> None:
        if stop.fault in (FaultKind.READ, FaultKind.WRITE):
            self._data_fault(stop)
            return
        pc = self._cpu.get(Reg.PC)
        if stop.fault is FaultKind.FETCH:
            if pc >> 29 in _EXECUTE_NEVER:
                self._fault(Number.MEM_MANAGE, cfsr=Cfsr.IACCVIOL)
            else:
                self._fault(Number.BUS_FAULT, cfsr=Cfsr.IBUSERR)
        elif stop.fault in _USAGE:
            self._fault(Number.USAGE_FAULT, cfsr=_USAGE[stop.fault])
        else:
            self._fault(Number.USAGE_FAULT, cfsr=Cfsr.NOCP if self._lacks_coprocessor(pc) else Cfsr.UNDEFINSTR)
        self._put_right(self._stack_unless_locked())

    def _data_fault(self, stop: Stop) -> None:
        cfsr = Cfsr.PRECISERR | Cfsr.BFARVALID
        if stop.fault is FaultKind.WRITE:
            self._notes.add(
                "assumed",
                "SCB_CFSR.PRECISERR",
                "a store that fails is reported at its own instruction; silicon may report it later, as IMPRECISERR",
            )
        if self._execution_priority() < 0 and self.scb.ignores_bus_faults:
            self._pass_over(stop.address)
            return
        self._fault(Number.BUS_FAULT, cfsr=cfsr, address=stop.address, refusal=stop.refusal)
        self._put_right(self._stack_unless_locked())

    def _pass_over(self, address: int) -> None:
        """Ignore a load or store that failed in the handler of HardFault or NMI (CCR.BFHFNMIGN; QEMU locks up there).

        That the destination of a load keeps what it had is a choice, and noted.
        """
        self.scb.record_fault(Cfsr.PRECISERR | Cfsr.BFARVALID, 0, address)
        self._notes.add("assumed", "SCB_CCR.BFHFNMIGN", "a load that fails leaves its destination register unchanged")
        pc = self._cpu.get(Reg.PC)
        wide = self._bus.read(pc, 2) >> 11 in (0b11101, 0b11110, 0b11111)
        step_over(self._cpu, 4 if wide else 2)

    def _lacks_coprocessor(self, pc: int) -> bool:
        """Say whether the instruction at `pc` is a coprocessor's that is not there, or not for the code that runs.

        See DDI0403 section A5.3.18.
        """
        try:
            first, second = (self._bus.read(pc + offset & 0xFFFF_FFFF, 2) for offset in (0, 2))
        except BusFault:
            return False
        if first & 0xEC00 != 0xEC00 or first & 0xEF00 == 0xEF00:
            return False
        return self.kind.fpu is None or second >> 9 & 7 != _FLOATING_POINT or not self._may_use_floats()

    # --- faults

    def _fault(
        self, origin: Number, *, cfsr: int = 0, hfsr: int = 0, address: int | None = None, refusal: str = ""
    ) -> None:
        """Make a fault pending, escalated if need be (DDI0403 section B1.5.4), or lock up."""
        number = self._escalated(origin)
        if number == Number.HARD_FAULT != origin:
            hfsr |= Hfsr.FORCED
        self.scb.record_fault(cfsr, hfsr, address)
        fault = self._record(origin, number, cfsr, hfsr, address, refusal)
        self.last_fault = fault
        self.on_fault(fault)
        if number:
            if not self._kept.open_faults >> number & 1:
                self._open_faults.pop(number, None)
            self._open_faults[number] = fault
            self._kept.open_faults |= 1 << number
            self.exceptions.pend(number)
        else:
            self._lock_up(fault.describe(), fault)

    def _escalated(self, origin: Number) -> int:
        """Return the exception that a fault becomes, 0 for lockup."""
        if self._may_interrupt(origin):
            return origin
        return Number.HARD_FAULT if self._execution_priority() > _HARD_FAULT_PRIORITY else 0

    def _record(self, origin: Number, number: int, cfsr: int, hfsr: int, address: int | None, refusal: str) -> Fault:
        cpu, time = self._cpu, self._time
        causes = [bit.name or "" for bit in Cfsr(cfsr) if bit is not Cfsr.BFARVALID]
        causes += [bit.name or "" for bit in Hfsr(hfsr) if bit is not Hfsr.FORCED]
        return Fault(
            exception=number,
            origin=origin,
            causes=tuple(causes) or ("SVC",),
            address=address,
            refusal=refusal,
            pc=cpu.get(Reg.PC),
            lr=cpu.get(Reg.LR),
            sp=cpu.get(Reg.SP),
            xpsr=cpu.get(Reg.XPSR),
            running=self.running,
            cycle=cpu.cycle,
            ns=time.ns(cpu.cycle),
        )

    def _lock_up(self, cause: str, fault: Fault | None) -> None:
        cpu = self._cpu
        kept = self._kept
        still_open = [fault for number, fault in self._open_faults.items() if kept.open_faults >> number & 1]
        faults = (*still_open, *(() if fault is None else (fault,)))
        kept.locked_up, kept.step, kept.sleeping = True, 0, False
        self.locked_up = Lockup(
            cause=cause, pc=cpu.get(Reg.PC), faults=faults, cycle=cpu.cycle, ns=self._time.ns(cpu.cycle)
        )

    # --- what the rest asks often

    def _masks(self) -> tuple[int, int, int]:
        get = self._cpu.get
        return get(Reg.PRIMASK), get(Reg.BASEPRI), get(Reg.FAULTMASK)

    def _execution_priority(self) -> int:
        return min(int(self._kept.active_priority), self.exceptions.boosted(*self._masks()))

    def _may_interrupt(self, number: int) -> bool:
        """Say whether an exception is enabled and more urgent than what runs, masks included."""
        exceptions = self.exceptions
        own = exceptions.group_priority(exceptions.priorities[number])
        return exceptions.is_enabled(number) and own < self._execution_priority()

    def _choose_float_access(self) -> None:
        """Tell the CPU who may use floating point: 2, which is reserved, is nobody (choice; QEMU too)."""
        access = self.scb.float_access
        self._cpu.set_float_access(FloatAccess.NOBODY if access == 2 else FloatAccess(access))

    def _may_use_floats(self) -> bool:
        access = self.scb.float_access
        return access == FloatAccess.EVERYBODY or (access == FloatAccess.PRIVILEGED and self._privileged())

    def _privileged(self) -> bool:
        return self.running != 0 or not self._cpu.get(Reg.CONTROL) & _NPRIV
