"""An emulated microcontroller on its board: the run loop that ties CPU, events, interrupts and bench time together.

Up to the limit the engine executes, takes exceptions, sleeps, and lets each event happen at its own cycle. Where
something else may have to be done, time is halted, and the loop looks:

1. everything that is due by now happens;
2. a reset that was asked for is carried out;
3. a CPU that waits for the flash, sleeps deeply or has locked up lets time pass up to the next event;
4. otherwise the engine goes on.

A slice of instructions is cut short when an access to a register makes an earlier event or changes the clock.
So nothing depends on how a run is cut into calls of `run_to`, and an outside event may be entered at any time that the
machine has not reached.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from functools import partial
from typing import TYPE_CHECKING

from targets.mcu.bus import ALIAS_SIZE, Bus
from targets.mcu.chip import DeepSleep
from targets.mcu.chip_limits import limits_of, past_end
from targets.mcu.chips import chip_of
from targets.mcu.cortexm.core import Core
from targets.mcu.cortexm.faults import Fault
from targets.mcu.cortexm.frame import EXC_RETURNS, return_address
from targets.mcu.cortexm.semihosting import Exit, Semihosting
from targets.mcu.ended import Ended, EndKind
from targets.mcu.engine.api import Access, Reg, Stop, StopKind
from targets.mcu.engine.core_engine import CoreEngine, Loop
from targets.mcu.engine.hooks import Hit, HitKind, Watchpoint
from targets.mcu.engine.idle import IdleSkipper
from targets.mcu.engine.timing import make_timing
from targets.mcu.fault_watch import FaultWatch
from targets.mcu.fidelity import Notes
from targets.mcu.image import Image
from targets.mcu.timebase import Timebase

if TYPE_CHECKING:
    from targets.boards import Board
    from targets.boards.board import Straps

__all__ = ["Machine"]

_OUTSIDE = 1  # order of events from outside: after those of the chip, which are of order 0
_PAGE = 0x400  # memory smaller than that is none to execute from: it answers as registers do
_SEMIHOSTING = 0xAB
_RESETS_IN_A_LOOP = 8
_FAULTS = range(3, 7)  # exception numbers of HardFault, MemManage, BusFault, UsageFault


class Machine:
    """A chip on a board, with an image in its flash, as it is when power comes on.

    Args:
        board: chip, crystals, straps.
        image: what is flashed.
        timing: the timing model: ``flat`` or ``table``; see `targets.mcu.engine.timing`.
        skip_idle: pass over loops that change nothing; no trace depends on it.
        straps: the boot pins, if they differ from the board's.

    Attributes:
        board: as given.
        image: as given.
        chip: the peripherals by name, `chip.pins`, `chip.usarts`.
        time: cycles and events.
        notes: what the firmware touched that is not modelled, or got wrong.
        ended: why nothing more will happen, or None.
        hit: the breakpoint or watchpoint of ``engine.hooks`` at which the last `run_to` has stopped, or None.
        on_console: called with what the program writes by ``semihosting`` or ``itm``, and which of the two.
        on_reset: called with the cause, as RCC_CSR names it, when the chip is reset.
        on_fault: called with every fault.

    Raises:
        EngineError: the library that executes is missing and cannot be made.
    """

    def __init__(
        self,
        board: Board,
        image: Image,
        *,
        timing: str = "flat",
        skip_idle: bool = True,
        straps: Straps | None = None,
    ) -> None:
        self.board = board
        self.image = image
        self.timing = timing
        self.ended: Ended | None = None
        self.hit: Hit | None = None
        self._ends_at_hit = False
        self.on_console: Callable[[bytes, str], None] = lambda _text, _channel: None
        self.on_reset: Callable[[str], None] = lambda _cause: None
        self.on_fault: Callable[[Fault], None] = lambda _fault: None
        self._straps = straps or board.straps
        chip_class = chip_of(board.variant)
        self.engine = CoreEngine(make_timing(timing, chip_class.CORE), chip_class.CORE)
        self.time = Timebase(chip_class.START_HZ)
        self.notes = Notes(self._moment, self._pc_in_flight)
        self.bus = Bus(self.notes)
        make_core = partial(Core, self.engine, kind=chip_class.CORE)
        self.chip = chip_class(board, self._straps, self.time, self.notes, self.bus, make_core, self._ask_reset)
        self.core = self.chip.core
        self.ram = self.chip.ram
        self.semihosting = Semihosting(self.engine, self.bus, self.time, self.notes, image.path.name)
        self._idle = IdleSkipper(self.engine, self.bus, self.time, self.ram)
        self._skips = skip_idle
        self._watch = FaultWatch(self.time, self._ask_for_look)
        self._look_at_fault = False
        self._look_began: int | None = None
        self._horizon_ns = 0
        self._reset_cause: str | None = "POR"
        self._resets: list[tuple[str, int]] = []
        self._stalled_until = 0
        self._deep: DeepSleep | None = None
        self._hangs = False
        self._is_usual = False
        self._line = bytearray()
        self._map()
        self._connect()
        for segment in image.segments:
            self._load(segment.address, segment.data)

    # --- time

    @property
    def now_ns(self) -> int:
        """Bench time that the machine has reached, in nanoseconds."""
        return self.time.ns(self.time.now)

    @property
    def cycle(self) -> int:
        """HCLK cycles since power-on."""
        return self.time.now

    def run_to(self, limit_ns: int) -> None:
        """Execute until bench time `limit_ns`, or until `ended` or `hit` is set, or `horizon` was called with less."""
        self._horizon_ns = limit_ns
        time, engine = self.time, self.engine
        if self.hit is not None:
            self._go_on()
        while self.ended is None and self.hit is None:
            limit = max(time.cycle_at_ns(self._horizon_ns), time.now)
            if engine.cycle < limit:
                self._look_anew()
                while not time.halted and engine.read_cycle() < limit:
                    self._step(limit)
                continue
            # Time stands at the limit, even if the last instruction has gone beyond it: what comes from outside may
            # still happen in between.
            time.run_due(limit)
            if engine.cycle >= time.cycle_at_ns(self._horizon_ns):
                return

    def horizon(self, ns: int) -> None:
        """End the present `run_to` at bench time `ns` already; the past means at once. For output callbacks."""
        if ns < self._horizon_ns:
            self._horizon_ns = ns
            self.engine.stop_by(self.time.cycle_at_ns(ns))
            self._halt()

    def at_ns(self, ns: int, action: Callable[[], None]) -> None:
        """Have `action` happen at the first cycle that does not fall before bench time `ns`, or now if that passed.

        Whatever the chip does by itself at that cycle comes first.
        """
        self.time.at_ns(ns, action, order=_OUTSIDE)

    def reset(self, cause: str = "PIN") -> None:
        """Reset the chip at the next instruction boundary: ``PIN`` (the button), ``POR`` (power off and on)."""
        self._ask_reset(cause)

    def hang(self) -> None:
        """Have the program do nothing until a reset, as in an endless loop with interrupts off; the rest goes on."""
        self._hangs = True
        self._cut()

    # --- for people

    def cover(self) -> None:
        """Remember from now on what is executed.

        Raises:
            MemoryError: there is no memory for it.
        """
        self.engine.cover()

    def executed(self) -> Iterator[int]:
        """Return the addresses of all instructions executed since `cover`; see `CoreEngine.executed`."""
        return self.engine.executed()

    def stop_at(self, addresses: Iterable[int], written: Iterable[tuple[int, int]]) -> None:
        """End before an instruction at one of these addresses, or one that writes to these: address and size in bytes.

        Raises:
            ValueError: there are too many.
        """
        self.engine.hooks.breakpoints = addresses
        self.engine.hooks.watchpoints = [Watchpoint(address, size) for address, size in written]
        self._ends_at_hit = True

    def function(self, pc: int) -> str:
        """Return the name of the function at an address, or the address."""
        return self.image.function_at(pc) or f"0x{pc:08X}"

    def place(self, pc: int) -> str:
        """Return ``function (file.c:42)`` for an address, as far as the image tells; otherwise the address."""
        function, line = self.image.function_at(pc), self.image.line_at(pc)
        if function is None:
            return line or f"0x{pc:08X}"
        return f"{function} ({line})" if line else function

    @property
    def waits_in(self) -> Loop | None:
        """The loop that changes nothing in which the program is at present, or None."""
        return self._idle.found

    @property
    def pc(self) -> int:
        """Address of the instruction that is executed next; during a return from an exception, of that gone back to."""
        pc = self.engine.get(Reg.PC)
        back = None if pc < EXC_RETURNS else return_address(self.engine, self.bus, pc | 1)
        return pc if back is None else back

    @property
    def writes(self) -> int:
        """How many writes to registers of peripherals there have been."""
        return self.bus.block_writes + self.engine.block_writes

    @property
    def asleep(self) -> tuple[str, int] | None:
        """How the CPU sleeps at present, ``Sleep``, ``Stop`` or ``Standby``, and since which instruction; or None."""
        if not self.core.sleeping:
            return None
        deep = self._deep
        mode = "Sleep" if deep is None else "Standby" if deep.is_standby else "Stop"
        return mode, self.engine.get(Reg.PC) - 2  # both WFI and WFE, but for their wide forms

    # --- the loop

    def _look_anew(self) -> None:
        """Find out what there is to do besides running; whatever may change that, or the limit, has time halted."""
        self.time.halted = False
        stalled = self._stalled_until > self.engine.cycle
        self._is_usual = not (
            stalled
            or self._hangs
            or self._reset_cause is not None
            or self.core.locked_up is not None
            or self._watch.hopeless is not None
            or self._look_at_fault
            or self._deep is not None
        )
        self.core.go_by_steps(stalled or self._look_at_fault)

    def _step(self, limit: int) -> None:
        """Do what there is to do before cycle `limit`, at least the next thing."""
        if self._is_usual or not (self.time.run_due(self.engine.read_cycle()) or self._did_unusual(limit)):
            self._execute(limit)

    def _did_unusual(self, limit: int) -> bool:
        """Do what is there besides running, if anything is."""
        if self._reset_cause is not None:
            self._reset()
        elif self._hangs:
            self._pass_to(limit, limit)
        elif self.core.locked_up is not None:
            self._locked_up(limit)
        elif self._watch.hopeless is not None and not self.chip.watchdog_runs():
            self._hopeless(self._watch.hopeless)
        elif self._stalled_until > self.engine.cycle and self._runs_from_flash():
            self._pass_to(limit, self._stalled_until)
        elif self._deep is not None:
            self._sleep_deeply(limit, self._deep)
        elif self._look_at_fault and self.core.sleeping and not self.core.wakes() and self._sleeps_for_ever():
            pass
        else:
            if self._watch.hopeless is None and self._stalled_until <= self.engine.cycle:
                self._halt()  # that is over
            return False
        return True

    def _execute(self, limit: int) -> None:
        if self._look_at_fault and not self.core.can_take():
            stop = self._look(limit)
        elif self._skips:
            stop = self._idle.run(limit)
        else:
            stop = self.engine.go(limit)
        if stop.kind is not StopKind.LIMIT:
            self._handle(stop)

    def _go_on(self) -> None:
        """Go on from where it was stopped; the rest of an IT block comes before anything else may."""
        self.hit = None
        if self.engine.hooks.in_block:
            stop = self.engine.go(self.engine.cycle)
            if stop.kind is not StopKind.LIMIT:
                self._handle(stop)

    def _handle(self, stop: Stop) -> None:
        self._halt()
        if stop.kind is StopKind.HIT:
            self.hit = self.engine.hooks.hit
            if self._ends_at_hit and self.hit is not None:
                self._end("stop", _cause_of(self.hit), self.hit.pc, status=0)
        elif stop.kind is StopKind.BREAKPOINT and stop.value == _SEMIHOSTING:
            self.semihosting.call()
        elif stop.kind is StopKind.WFI:
            self._enter_deep_sleep()
        else:
            self.core.handle(stop)

    def _sleep_deeply(self, limit: int, deep: DeepSleep) -> None:
        """Wait for what ends Stop or Standby; the chip's clocks stand still meanwhile."""
        if not deep.is_standby and self.core.wakes():
            self._leave_deep_sleep(deep)
            self.core.wake()
        elif not (self._look_at_fault and self._sleeps_for_ever()):
            self._pass_to(limit, limit)

    def _enter_deep_sleep(self) -> None:
        chip, mode = self.chip, self.chip.deep_sleep()
        if chip.sleep_resets(mode):
            self._ask_reset("LPWR")
            return
        if mode.is_standby and not chip.enter_standby():
            self.core.wake()
            return
        self._deep = mode
        self.core.hold_clocks(True)
        chip.stop_clocks()

    def _leave_deep_sleep(self, deep: DeepSleep) -> None:
        """Wake from Stop; Standby is left by a reset alone."""
        self.engine.add_cycles(int(deep.wakeup_s * self.time.hclk_hz))
        self.time.hold(self.engine.cycle)
        self.chip.restart_clocks()
        self.core.hold_clocks(False)
        self._deep = None
        self._halt()

    def _pass_to(self, limit: int, end: int) -> None:
        """Let time pass without instructions, up to the next event, `end` or `limit`."""
        due = self.time.next_cycle()
        target = min(limit, end) if due is None else min(limit, end, due)
        self.engine.add_cycles(max(0, target - self.engine.cycle))

    def _runs_from_flash(self) -> bool:
        pc = self.engine.get(Reg.PC)
        return not any(memory.writable and memory.holds(pc) for memory in self.chip.memories)

    # --- resets and ends

    def _reset(self) -> None:
        cause, self._reset_cause = self._reset_cause or "PIN", None
        pc = self.engine.get(Reg.PC)
        self._stalled_until = 0
        self._deep = None
        self._hangs = False
        self._halt()
        if cause == "POR":
            self._clear_ram()
        self.chip.reset(cause)
        self.core.reset(self._boot_table(), power_on=cause == "POR")
        self._idle.restart()
        self._watch.reset()
        self.on_reset(cause)
        self._count_reset(cause, pc)

    def _clear_ram(self) -> None:
        """The supply has risen: RAM is zero, a choice (silicon comes up with anything), but for what the image has."""
        for memory in self.chip.memories:
            if memory.writable:
                memory.data[:] = bytes(len(memory.data))
                self.engine.forget(memory.base, len(memory.data))
        for segment in self.image.segments:
            self._load_ram(segment.address, segment.data)

    def _boot_table(self) -> int:
        boot = self.chip.boot(self.image.table)
        if boot.refusal:
            self._end("no-boot", boot.refusal)
        return boot.table

    def _count_reset(self, cause: str, pc: int) -> None:
        if self._resets and self._resets[-1][0] != cause:
            self._resets.clear()
        self._resets.append((cause, pc))
        if cause not in ("PIN", "POR", "LPWR", "STANDBY") and len(self._resets) >= _RESETS_IN_A_LOOP:
            names = {"IWDG": "the independent watchdog", "WWDG": "the window watchdog", "SFT": "the program itself"}
            self._end("reset-loop", f"{len(self._resets)} resets in a row by {names.get(cause, cause)}", pc)

    def forget_resets(self) -> None:
        """Count resets anew: something from outside happened, so what follows is not the same again."""
        self._resets.clear()

    def _locked_up(self, limit: int) -> None:
        lockup = self.core.locked_up
        assert lockup is not None
        if self.chip.watchdog_runs():
            self._pass_to(limit, limit)
            return
        chain = dict.fromkeys((lockup.cause, *(self._tell(fault) for fault in lockup.faults)))
        self._end("lockup", f"lockup: {'; '.join(chain)}", lockup.pc)

    def _ask_for_look(self) -> None:
        self._look_at_fault = self.core.running in _FAULTS and not self.chip.watchdog_runs()
        self._cut()

    def _look(self, target: int) -> Stop:
        """End the run if the handler of a fault waits for ever."""
        self._look_at_fault = False
        now = self.time.now if self._look_began is None else self._look_began
        fault = self.core.last_fault
        stop = self._idle.look(target)
        if stop.kind is StopKind.HIT:
            self._look_at_fault, self._look_began = True, now
            return stop
        self._look_began = None
        loop = self._idle.found
        if loop is None or fault is None:
            self._watch.look_again()
        elif self._watch.waits_for_ever(loop.instructions, self._effects()):
            self._end("fault-loop", f"a fault handler waits for ever: {self._tell(fault)}", fault.pc, cycle=now)
            return stop
        if fault is not None:
            self._note_open(fault)
        return stop

    def _effects(self) -> tuple[int, int, int, bytes]:
        """Return what differs if the program has had any effect."""
        return self.bus.writes, self.engine.core_writes, self.engine.block_writes, bytes(self.ram)

    def _sleeps_for_ever(self) -> bool:
        """End the run if the handler of a fault sleeps, and nothing can wake it but an NMI or a button."""
        self._look_at_fault = False
        fault, chip = self.core.last_fault, self.chip
        if fault is None:
            return False
        if self._deep is not None and self._deep.is_standby:
            may_wake = chip.standby_may_end()
        else:
            may_wake = self.core.may_wake(events=chip.sends_events())
        if not may_wake:
            self._end("fault-loop", f"a fault handler sleeps for ever: {self._tell(fault)}", fault.pc)
            return True
        self._watch.look_again()
        self._note_open(fault)
        return False

    def _note_open(self, fault: Fault) -> None:
        self.notes.add("misuse", self.place(fault.pc), f"{self._tell(fault)}; the handler has not returned")

    def _hopeless(self, fault: Fault) -> None:
        self._end("fault-loop", f"the same fault over and over: {self._tell(fault)}", fault.pc)

    def _tell(self, fault: Fault) -> str:
        """Return a fault in one line, and where it came from if its own address says nothing."""
        text = fault.describe() + self._explain(fault)
        if not self.image.function_at(fault.pc) and self.image.function_at(fault.lr & ~1):
            text += f"; LR points to {self.place(fault.lr & ~1)}"
        return text

    def _explain(self, fault: Fault) -> str:
        """Return what is known of an address that should not have been accessed or executed."""
        if self.chip.in_flash(fault.pc) and self.engine.half(fault.pc) == 0xFFFF:
            return "; the flash is erased there: a jump or call to code that was never programmed"
        address = fault.pc if fault.address is None else fault.address
        diagnosis = self.chip.diagnose(fault.pc) or past_end(limits_of(self.board.variant), address)
        return f"; {diagnosis}" if diagnosis else ""

    def _end(
        self, kind: EndKind, cause: str, pc: int | None = None, *, status: int = 1, cycle: int | None = None
    ) -> None:
        pc = self.engine.get(Reg.PC) if pc is None else pc
        now = self.time.now if cycle is None else cycle
        place = self.place(pc) if self.image.function_at(pc) or self.image.line_at(pc) else ""
        self.ended = Ended(kind=kind, status=status, cause=cause, pc=pc, place=place, cycle=now, ns=self.time.ns(now))
        self._halt()

    # --- what the parts call

    def _moment(self) -> tuple[int, int]:
        now = self.time.now
        return now, self.time.ns(now)

    def _pc_in_flight(self) -> int | None:
        return self.engine.get(Reg.PC) if self.engine.running else None

    def _cut(self) -> None:
        """Have `run_to` look anew at what there is to do: nothing more is executed, nor slept over, until then."""
        self.engine.stop_by(0)
        self._halt()

    def _halt(self) -> None:
        """Have `run_to` look anew at what there is to do; nothing more is slept over until then."""
        self.time.halted = True

    def _ask_reset(self, cause: str) -> None:
        self._reset_cause = cause
        self._cut()

    def _exit(self, ending: Exit) -> None:
        self._end("exit", "the program ended by semihosting", status=ending.status)

    def _fault(self, fault: Fault) -> None:
        self._watch.fault(fault)
        diagnosis = self.chip.diagnose(fault.pc)
        if diagnosis:
            self.notes.add("unmodelled", "system memory", diagnosis)
        self.on_fault(fault)

    def _stimulus(self, port: int, size: int, value: int) -> None:
        if port == 0:
            self.on_console(value.to_bytes(size, "little"), "itm")

    def _stall(self, cycle: int) -> None:
        self._stalled_until = cycle
        self._cut()

    def _latency(self, wait_states: int) -> None:
        self.engine.set_wait_states(wait_states)
        self._cut()

    # --- putting it together

    def _map(self) -> None:
        """Give the engine its memory and the bus its peripherals."""
        engine, bus, chip = self.engine, self.bus, self.chip
        for memory in chip.memories:
            bus.add_memory(memory.base, memory.data, writable=memory.writable)
            if len(memory.data) % _PAGE:
                engine.map_registers(memory.base, _PAGE, self._bus_access(memory.base))
            else:
                engine.map_memory(memory.base, memory.data, writable=memory.writable)
        for peripheral in self.core.peripherals:
            bus.add(peripheral)
        for peripheral in chip.peripherals.values():
            if peripheral.in_c is not None:
                engine.attach(peripheral.in_c)
        for base, size in chip.REGISTER_WINDOWS:
            engine.map_registers(base, size, bus.window(base))
        for alias, base in chip.BIT_BAND.items():
            engine.map_registers(alias, ALIAS_SIZE, self._bit_access(base))

    def _bus_access(self, base: int) -> Access:
        bus = self.bus
        return Access(
            lambda offset, size: bus.read(base + offset, size),
            lambda offset, size, value: bus.write(base + offset, size, value),
            lambda _offset: False,
        )

    def _bit_access(self, base: int) -> Access:
        bus = self.bus
        return Access(
            lambda offset, _size: bus.read_bit(base, offset),
            lambda offset, _size, value: bus.write_bit(base, offset, value),
            lambda offset: bus.is_live(base + (offset >> 5 & ~3)),
        )

    def _connect(self) -> None:
        """Tie the callbacks of the parts together."""
        self.engine.live_in(self.time)
        self.core.on_fault = self._fault
        self.core.itm.on_stimulus = self._stimulus
        self.core.trace_as_debugger()
        self.semihosting.on_output = lambda text: self.on_console(text, "semihosting")
        self.semihosting.on_exit = self._exit
        self.engine.on_flash_store = self.chip.flash.program
        self.bus.on_code_store = self.chip.flash.program
        self.chip.flash.on_code_changed = self.engine.forget
        self.chip.flash.on_latency = self._latency
        self.chip.flash.stall_until = self._stall
        self.chip.pins.deliver = self.at_ns

    def _load(self, address: int, data: bytes) -> None:
        if not self._load_ram(address, data):
            self.chip.flash.load(address, data)
            self.engine.forget(address, len(data))

    def _load_ram(self, address: int, data: bytes) -> bool:
        """Put bytes into RAM; False if none is there."""
        for memory in self.chip.memories:
            if memory.writable and memory.holds(address):
                offset = address - memory.base
                memory.data[offset : offset + len(data)] = data
                return True
        return False


def _cause_of(hit: Hit) -> str:
    if hit.kind is HitKind.BREAKPOINT:
        return "a breakpoint"
    return f"about to write 0x{hit.value or 0:0{2 * hit.size}X} to 0x{hit.address:08X}"
