"""A Cortex-M around its instructions: takes exceptions, returns from them, escalates faults, sleeps, locks up.

After the ARMv7-M Architecture Reference Manual (DDI0403), section B1.5. An engine executes instructions and stops where
the core has to act (`handle`); between two instructions the machine asks whether something is to be taken (`can_take`)
and lets it be (`take`).

Time. Entry and return go in two steps, so that what happens within their cycles counts:

1. Entry: the frame is stacked and the entry's cycles pass. The machine then lets the events of these cycles happen and
   calls `take` again, which reads the vector of whatever is most urgent by then: the exception that began the entry or
   one that arrived late. The other stays pending. No cycles are paid twice.
2. Return: if an exception is pending that may be taken at the level returned to, it is tail-chained: nothing is
   unstacked or stacked. Otherwise the return's cycles pass; whatever became pending in them is then tail-chained too
   (the unstacking is abandoned), and only if there is nothing the registers come back.

While such a step is outstanding `can_take` is True, and no instruction may be executed.

Cycles (Cortex-M3 TRM, sections on exception latency; zero wait states): 12 for entry, 6 for tail-chaining. 12 for
return, and that a fault at return costs as much as tail-chaining, are choices; and that a Cortex-M7 takes the same.
QEMU counts no cycles and cannot tell.
Waking up takes no time of its own.

Not modelled: imprecise bus faults, the vector's flash wait states, faults that wait until a debugger looks. Divisions,
loads and stores of several words, which silicon abandons or interrupts, are completed before an exception is taken.
"""

from __future__ import annotations

import enum
from collections.abc import Callable

from targets.mcu.cortexm import frame
from targets.mcu.cortexm.caches import Caches
from targets.mcu.cortexm.debug import Fpb, RomTable, Tpiu
from targets.mcu.cortexm.dwt import Dwt
from targets.mcu.cortexm.exceptions import Exceptions, Line, Number
from targets.mcu.cortexm.faults import Cfsr, Fault, Hfsr, Lockup
from targets.mcu.cortexm.float_context import FloatContext
from targets.mcu.cortexm.fpu import FPCA, Fpu
from targets.mcu.cortexm.itm import Itm
from targets.mcu.cortexm.kinds import CORTEX_M3, CoreKind
from targets.mcu.cortexm.mpu import Mpu
from targets.mcu.cortexm.nvic import Nvic
from targets.mcu.cortexm.ppb import LaneBlock
from targets.mcu.cortexm.scb import Scb
from targets.mcu.cortexm.scs import SCS_BASE, Scs
from targets.mcu.cortexm.stepping import step_over
from targets.mcu.cortexm.systick import SysTick
from targets.mcu.engine.api import CpuEngine, FaultKind, Reg, Stop, StopKind
from targets.mcu.errors import BusFault
from targets.mcu.registers import Peripheral
from targets.mcu.services import IrqLine, Services

__all__ = ["ENTRY_CYCLES", "RETURN_CYCLES", "TAIL_CHAIN_CYCLES", "Core"]

ENTRY_CYCLES = 12
TAIL_CHAIN_CYCLES = 6
RETURN_CYCLES = 12

_T_BIT = 1 << 24
_APSR = 0xF80F_0000
_SPSEL, _NPRIV = 1 << 1, 1 << 0
_HARD_FAULT_PRIORITY = -1
_FLOATING_POINT = 0b101  # the upper three bits of the numbers of coprocessors 10 and 11
_USAGE = {
    FaultKind.STATE: Cfsr.INVSTATE,
    FaultKind.DIVISION: Cfsr.DIVBYZERO,
    FaultKind.UNALIGNED: Cfsr.UNALIGNED,
}
_EXCEPTION_RETURN = StopKind.EXCEPTION_RETURN
_EXECUTE_NEVER = frozenset({2, 5, 6, 7})  # eighths of the address space: peripherals, devices, system (table B3-1)


class _Step(enum.Enum):
    NONE = "none"
    ENTER = "enter"
    LEAVE = "leave"


_NO_STEP, _ENTER, _LEAVE = _Step


class Core:
    """Exceptions, faults, sleep and the private peripheral bus of one core.

    Args:
        cpu: executes instructions.
        services: what the chip offers; its `bus` is used for stacking and vectors, its `time` by timers.
        kind: what core it is.

    Attributes:
        kind: as given.
        peripherals: what the machine puts on the bus.
        blocks: the same with the parts of the system control space told apart, for the ledger.
        exceptions: what is pending, enabled and active.
        running: number of the exception that runs, 0 in Thread mode.
        sleeping: WFI, WFE or SLEEPONEXIT stopped the CPU; see `wakes`.
        locked_up: how the core came to stop for good, or None.
        last_fault: the last fault since the core was made, or None.
        on_running: called with `running` at every exception entry and return, when the next instruction may begin.
        on_fault: called with every fault, before its handler runs.
        on_change: called when something could have become takeable or woken the CPU: the running slice must end.
        on_monitor_clear: called where LDREX is forgotten: exception entry and return.
    """

    def __init__(self, cpu: CpuEngine, services: Services, kind: CoreKind = CORTEX_M3) -> None:
        self._cpu = cpu
        self._services = services
        self._bus = services.bus
        self._time = services.time
        self._notes = services.notes
        self.kind = kind
        self.exceptions = Exceptions(kind.irq_count, kind.priority_bits)
        self._nmi = Line(self.exceptions, Number.NMI)
        self._others: list[LaneBlock] = []
        self.systick = SysTick(SCS_BASE, services, self.exceptions, kind.systick_calibration)
        self.nvic = Nvic(SCS_BASE, services, self.exceptions)
        self.scb = Scb(SCS_BASE, services, self.exceptions, lambda: self.running, self._masks, kind)
        self._mpu = Mpu(SCS_BASE, services, kind.mpu_regions) if kind.mpu_regions else None
        self._caches = Caches(SCS_BASE, services, kind.ccsidr, kind.tcm) if kind.ccsidr else None
        self._others += [block for block in (self._mpu, self._caches) if block is not None]
        trace_enabled = lambda: self.scb.trace_enabled  # noqa: E731
        ids = kind.component_ids
        self.itm = Itm(services, self._privileged, ids["ITM"], trace_enabled)
        self.dwt = Dwt(services, self._privileged, ids["DWT"], trace_enabled, lock=kind.dwt_lock)
        self._floats = self._make_floats()
        scs = Scs(services, self._privileged, self.systick, self.nvic, self.scb, *self._others)
        fpb, tpiu = Fpb(services, self._privileged, ids["FPB"]), Tpiu(services, self._privileged, ids["TPIU"])
        rom = RomTable(services, self._privileged)
        self._debug = (self.itm, self.dwt, fpb, tpiu)
        self.peripherals: tuple[Peripheral, ...] = (self.itm, self.dwt, fpb, scs, tpiu, rom)
        self.blocks: tuple[Peripheral, ...] = (self.itm, self.dwt, fpb, *scs.parts, tpiu, rom)
        self.running = 0
        self.sleeping = False
        self.locked_up: Lockup | None = None
        self.last_fault: Fault | None = None
        self.on_running: Callable[[int], None] = lambda _number: None
        self.on_fault: Callable[[Fault], None] = lambda _fault: None
        self.on_change: Callable[[], None] = lambda: None
        self.on_monitor_clear: Callable[[], None] = lambda: None
        self.exceptions.on_change = self._changed
        self.scb.on_trace = self.dwt.gate
        self.scb.on_traps = lambda division, unaligned: cpu.set_traps(division=division, unaligned=unaligned)
        self._traced = False
        self._for_event = False  # asleep by WFE
        self._step = _NO_STEP
        self._exc_return = 0
        self._open_faults: dict[int, Fault] = {}
        self._acts: dict[StopKind, Callable[[Stop], None]] = {
            StopKind.SVC: self._supervisor_call,
            StopKind.FAULT: self._instruction_fault,
            StopKind.BREAKPOINT: self._breakpoint,
            StopKind.WFI: lambda _stop: self._sleep(for_event=False),
            StopKind.WFE: self._wait_for_event,
            StopKind.SEV: self._send_event,
        }

    def _make_floats(self) -> FloatContext | None:
        kind, cpu, services = self.kind.fpu, self._cpu, self._services
        if kind is None:
            return None
        fpu = Fpu(SCS_BASE, services, kind, lambda: cpu.get(Reg.CONTROL))
        self._others.append(fpu)
        floats = FloatContext(cpu, services.bus, fpu, lambda: self.scb.float_access)
        self.scb.on_coprocessors = floats.choose_access
        return floats

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
        self.exceptions.event = True
        self.on_change()

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
        self.running = 0
        self.sleeping = self._for_event = False
        self.locked_up = None
        self._step = _NO_STEP
        self.hold_clocks(False)
        self._open_faults.clear()
        cpu.set(Reg.XPSR, _T_BIT)
        for register in (Reg.CONTROL, Reg.PRIMASK, Reg.BASEPRI, Reg.FAULTMASK, Reg.PSP):
            cpu.set(register, 0)
        cpu.set(Reg.LR, 0xFFFF_FFFF)
        if self._floats is not None:
            self._floats.reset()
        try:
            stack, entry = (self._bus.read(vector_base + offset, 4) for offset in (0, 4))
        except BusFault:
            self._lock_up(f"the reset vector at 0x{vector_base:08X} cannot be read", None)
            return
        cpu.set(Reg.MSP, stack & ~3)
        self._begin_at(entry & ~1, thumb=bool(entry & 1), xpsr=0)

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

    # --- between two instructions

    def can_take(self) -> bool:
        """Say whether `take` has something to do: an exception to enter, or the second step of entry or return."""
        if self._step is not _NO_STEP:
            return True
        exceptions = self.exceptions
        if exceptions.best_priority >= exceptions.active_priority or self.locked_up is not None:
            return False
        return exceptions.best_priority < exceptions.boosted(*self._masks())

    def masked(self) -> bool:
        """Say whether PRIMASK, BASEPRI or FAULTMASK alone keep an exception from being taken."""
        exceptions = self.exceptions
        if exceptions.best_priority >= exceptions.active_priority or self.locked_up is not None:
            return False
        return self._step is _NO_STEP and exceptions.best_priority >= exceptions.boosted(*self._masks())

    def take(self) -> bool:
        """Do one step of exception entry or return; return whether there was one. Wakes a sleeping CPU."""
        if self._step is _ENTER:
            self._enter()
        elif self._step is _LEAVE:
            self._leave()
        elif self.can_take():
            self.wake()
            self._stack()
        else:
            return False
        return True

    def handle(self, stop: Stop) -> None:
        """Do what the engine stopped for. A BREAKPOINT of semihosting is not for here."""
        if stop.kind is _EXCEPTION_RETURN:
            self._exception_return(stop)
        elif (act := self._acts.get(stop.kind)) is not None:
            act(stop)

    # --- sleep

    @property
    def deep(self) -> bool:
        """SCR.SLEEPDEEP: sleeping is Stop or Standby."""
        return self.scb.sleep_deep

    def wakes(self) -> bool:
        """Say whether a sleeping CPU wakes (DDI0403 sections B1.5.18 and B1.5.19).

        From WFI: by an exception that may be taken, PRIMASK aside. From WFE: by one that may be taken, or the event
        register.
        """
        if not self.sleeping:
            return False
        exceptions = self.exceptions
        if self._for_event and exceptions.event:
            return True
        if exceptions.best_priority >= exceptions.active_priority:
            return False
        primask, basepri, faultmask = self._masks()
        boosted = exceptions.boosted(primask if self._for_event else 0, basepri, faultmask)
        return exceptions.best_priority < boosted

    def may_wake(self, *, events: bool) -> bool:
        """Say whether a sleeping CPU can still wake: by an exception that may yet come, but for an NMI, or an event.

        Args:
            events: the chip may send events besides its interrupts.
        """
        exceptions = self.exceptions
        if self._for_event and (events or exceptions.event_on_pend):
            return True
        primask, basepri, faultmask = self._masks()
        boosted = exceptions.boosted(primask if self._for_event else 0, basepri, faultmask)
        now = min(exceptions.active_priority, boosted)
        first = Number.SYSTICK if self.systick.interrupts() else Number.FIRST_IRQ
        return any(
            exceptions.enabled >> number & 1 and exceptions.group_priority(exceptions.priorities[number]) < now
            for number in range(first, exceptions.count)
        )

    def wake(self) -> None:
        """Stop sleeping; WFE consumes the event register."""
        if self.sleeping:
            self.sleeping = False
            if self._for_event:
                self.exceptions.event = False

    def hold_clocks(self, held: bool) -> None:
        """Let what counts in the core stand still, as in Stop mode, or go on."""
        self.systick.hold(held)
        self.dwt.hold(held)

    def _sleep(self, *, for_event: bool) -> None:
        self._for_event = for_event
        self.sleeping = True
        if self.wakes():
            self.wake()

    def _wait_for_event(self, _stop: Stop) -> None:
        if self.exceptions.event:
            self.exceptions.event = False
        else:
            self._sleep(for_event=True)

    def _send_event(self, _stop: Stop) -> None:
        self.exceptions.event = True

    # --- entry

    def _stack(self) -> None:
        """First step of entry: save what the exception interrupts."""
        floats, cycles = None if self._floats is None else self._floats.to_stack(), ENTRY_CYCLES
        self._exc_return, complete = frame.push(self._cpu, self._bus, align=self.scb.stack_align, floats=floats)
        if self._floats is not None and floats is not None:
            if self._floats.not_storable():
                self._fault(Number.USAGE_FAULT, cfsr=Cfsr.NOCP)
            cycles += self._floats.stacked(self._exc_return, self._ready())
        if not complete:
            self._fault(Number.BUS_FAULT, cfsr=Cfsr.STKERR)
        self._go_on(_ENTER, cycles)

    def _ready(self) -> int:
        """Return which exceptions could be taken now if a floating-point register could not be saved later."""
        exceptions, now = self.exceptions, self._execution_priority()
        ready = now > _HARD_FAULT_PRIORITY and 1 << 4
        for number, bit in ((Number.MEM_MANAGE, 5), (Number.BUS_FAULT, 6), (Number.DEBUG_MONITOR, 8)):
            urgent = exceptions.group_priority(exceptions.priorities[number]) < now
            ready |= (exceptions.enabled >> number & 1 and urgent) << bit
        return ready

    def _enter(self) -> None:
        """Second step of entry: begin the handler of what is most urgent by now."""
        number = self.exceptions.best
        try:
            vector = self._bus.read(self.scb.vector_table + 4 * number, 4)
        except BusFault:
            self._vector_fault(number)
            return
        cpu = self._cpu
        self._step = _NO_STEP
        self.exceptions.activate(number)
        self.exceptions.event = True
        self.running = number
        self.on_running(number)
        self.on_monitor_clear()
        # before XPSR: in handler mode SPSEL cannot be cleared
        control = cpu.get(Reg.CONTROL)
        if control & (_SPSEL | FPCA):
            cpu.set(Reg.CONTROL, control & ~(_SPSEL | FPCA))
        cpu.set(Reg.LR, self._exc_return)
        self._begin_at(vector & ~1, thumb=bool(vector & 1), xpsr=cpu.get(Reg.XPSR) & _APSR | number)

    def _vector_fault(self, number: int) -> None:
        """The vector could not be read: a HardFault takes over, unless it is its own vector."""
        if number <= Number.HARD_FAULT:
            self._lock_up("the vector table cannot be read", None)
            return
        self._fault(Number.HARD_FAULT, hfsr=Hfsr.VECTTBL)
        if self.locked_up is None:
            self._enter()

    def _begin_at(self, pc: int, *, thumb: bool, xpsr: int) -> None:
        """Go on at `pc`; what cannot be executed there faults at once, whatever an engine would make of it."""
        cpu = self._cpu
        cpu.set(Reg.PC, pc)
        cpu.set(Reg.XPSR, xpsr | _T_BIT if thumb else xpsr)
        self._check_executable(pc, thumb=thumb)

    def _check_executable(self, pc: int, *, thumb: bool) -> None:
        if not thumb:
            self._fault(Number.USAGE_FAULT, cfsr=Cfsr.INVSTATE)
            self._stack_unless_locked()
        elif pc >> 29 in _EXECUTE_NEVER:
            self._fault(Number.MEM_MANAGE, cfsr=Cfsr.IACCVIOL)
            self._stack_unless_locked()

    def _go_on(self, step: _Step, cycles: int) -> None:
        if self.locked_up is None:
            self._cpu.add_cycles(cycles)
            self._step = step

    def _stack_unless_locked(self) -> None:
        if self.locked_up is None:
            self._stack()

    # --- return

    def _exception_return(self, stop: Stop) -> None:
        """First step of return (DDI0403 section B1.5.8, ``ExceptionReturn``)."""
        number = self.running
        if not number:  # in Thread mode it is a jump like any other
            self._cpu.set(Reg.PC, stop.value & ~1)
            self._fault(Number.MEM_MANAGE, cfsr=Cfsr.IACCVIOL)
            self._stack_unless_locked()
            return
        exceptions = self.exceptions
        was_active = exceptions.is_active(number)
        alone = exceptions.active & ~(1 << number) == 0
        exceptions.deactivate(number)
        self._open_faults.pop(number, None)
        if number != Number.NMI:
            self._cpu.set(Reg.FAULTMASK, 0)
        self._exc_return = stop.value
        more = 0 if self._floats is None else self._floats.returning(stop.value)
        if not was_active or not self._is_legal(stop.value, alone=alone):
            self._bad_return(Number.USAGE_FAULT, Cfsr.INVPC)
        elif self._preempts():
            self._go_on(_ENTER, TAIL_CHAIN_CYCLES)
        else:
            self._go_on(_LEAVE, RETURN_CYCLES + more)

    def _is_legal(self, exc_return: int, *, alone: bool) -> bool:
        if self._floats is not None:
            exc_return |= frame.BASIC
        if exc_return == frame.TO_HANDLER:
            return not alone
        if exc_return in (frame.TO_THREAD_MSP, frame.TO_THREAD_PSP):
            return alone or self.scb.thread_from_any_level
        return False

    def _bad_return(self, origin: Number, cfsr: Cfsr) -> None:
        """A return that cannot be: its fault is tail-chained, the frame stays where it is."""
        self._fault(origin, cfsr=cfsr)
        self._go_on(_ENTER, TAIL_CHAIN_CYCLES)

    def _leave(self) -> None:
        """Second step of return: go back, unless something came in between."""
        if self._preempts():
            self._go_on(_ENTER, TAIL_CHAIN_CYCLES)
            return
        words = self._unstack()
        if words is None:
            return
        number = words[7] & 0x1FF
        frame.restore(self._cpu, words, self._exc_return, align=self.scb.stack_align)
        self._step = _NO_STEP
        self.running = number
        self.on_running(number)
        self.exceptions.event = True
        self.on_monitor_clear()
        if not number and self.scb.sleep_on_exit and not self.exceptions.active:
            self._sleep(for_event=False)
        self._check_executable(words[6] & ~1, thumb=bool(words[7] & _T_BIT))

    def _unstack(self) -> list[int] | None:
        """Return the words of the frame, and set the floating-point registers that it has; None after a fault."""
        floats, exc_return = self._floats, self._exc_return
        try:
            words = frame.pull(self._cpu, self._bus, exc_return)
            if (words[7] & 0x1FF != 0) != (exc_return | frame.BASIC == frame.TO_HANDLER):
                self._bad_return(Number.USAGE_FAULT, Cfsr.INVPC)
                return None
            if floats is not None:
                if floats.denied(exc_return):
                    self._bad_return(Number.USAGE_FAULT, Cfsr.NOCP)
                    return None
                floats.restore(exc_return)
        except BusFault:
            self._bad_return(Number.BUS_FAULT, Cfsr.UNSTKERR)
            return None
        return words

    # --- what instructions ask for

    def _supervisor_call(self, _stop: Stop) -> None:
        exceptions = self.exceptions
        if exceptions.group_priority(exceptions.priorities[Number.SVCALL]) < self._execution_priority():
            exceptions.pend(1 << Number.SVCALL)
        else:
            # What is escalated returns to where it would have by nature (DDI0403 section B1.5.4), which is behind the
            # instruction for SVCall (`ReturnAddress`). QEMU does so, and kernels look for the SVC before that address.
            behind = self._cpu.get(Reg.PC)
            self._cpu.set(Reg.PC, behind - 2)  # the record names the instruction
            self._fault(Number.SVCALL)
            if self.locked_up is None:
                self._cpu.set(Reg.PC, behind)
        self._stack_unless_locked()

    def _breakpoint(self, _stop: Stop) -> None:
        """BKPT without a debugger: DebugMonitor if that is enabled and urgent enough, else a HardFault."""
        exceptions, monitor = self.exceptions, Number.DEBUG_MONITOR
        self.scb.record_breakpoint()
        enabled = exceptions.enabled >> monitor & 1
        if enabled and exceptions.group_priority(exceptions.priorities[monitor]) < self._execution_priority():
            exceptions.pend(1 << monitor)
        else:
            self._fault(Number.HARD_FAULT, hfsr=Hfsr.DEBUGEVT)
        self._stack_unless_locked()

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
        self._stack_unless_locked()

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
        self._stack_unless_locked()

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
        return self._floats is None or second >> 9 & 7 != _FLOATING_POINT or not self._floats.allowed()

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
            self._open_faults[number] = fault
            self.exceptions.pend(1 << number)
        else:
            self._lock_up(fault.describe(), fault)

    def _escalated(self, origin: Number) -> int:
        """Return the exception that a fault becomes, 0 for lockup."""
        exceptions, now = self.exceptions, self._execution_priority()
        own = exceptions.group_priority(exceptions.priorities[origin])
        if exceptions.enabled >> origin & 1 and own < now:
            return origin
        return Number.HARD_FAULT if now > _HARD_FAULT_PRIORITY else 0

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
        faults = (*self._open_faults.values(), *(() if fault is None else (fault,)))
        self._step = _NO_STEP
        self.sleeping = False
        self.locked_up = Lockup(
            cause=cause, pc=cpu.get(Reg.PC), faults=faults, cycle=cpu.cycle, ns=self._time.ns(cpu.cycle)
        )

    # --- what the rest asks often

    def _changed(self) -> None:
        self.on_change()

    def _masks(self) -> tuple[int, int, int]:
        get = self._cpu.get
        return get(Reg.PRIMASK), get(Reg.BASEPRI), get(Reg.FAULTMASK)

    def _execution_priority(self) -> int:
        exceptions = self.exceptions
        return min(exceptions.active_priority, exceptions.boosted(*self._masks()))

    def _preempts(self) -> bool:
        exceptions = self.exceptions
        if exceptions.best_priority >= exceptions.active_priority:
            return False
        return exceptions.best_priority < exceptions.boosted(*self._masks())

    def _privileged(self) -> bool:
        return self.running != 0 or not self._cpu.get(Reg.CONTROL) & _NPRIV
