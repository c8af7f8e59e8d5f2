"""Executes Thumb-2 by the library of ``targets/mcu/core``: a `CpuEngine` whose state is a struct that both sides see.

The library never lets go of Python's lock: what it calls, it calls in the same thread, and another thread that holds
the lock for a while would cost more than the instructions.
"""

from __future__ import annotations

import ctypes
import enum
import sys
import weakref
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, Protocol

from targets.mcu.core.library import owner_of, structure, with_lock_held
from targets.mcu.cortexm.kinds import CORTEX_M3, CoreKind
from targets.mcu.engine.api import Access, FaultKind, FloatAccess, Reg, Stop, StopKind
from targets.mcu.engine.hooks import Hooks
from targets.mcu.engine.timing import Timing
from targets.mcu.errors import BusFault, EngineError
from targets.mcu.timebase import Timebase

__all__ = ["CoreEngine", "Loop", "Skip"]

_READ = ctypes.PYFUNCTYPE(ctypes.c_uint32, ctypes.c_uint32, ctypes.c_uint32, ctypes.c_uint32)
_WRITE = ctypes.PYFUNCTYPE(None, ctypes.c_uint32, ctypes.c_uint32, ctypes.c_uint32, ctypes.c_uint32)
_READ_ONLY = 0xFFFF_FFFF  # the window of stores into read-only memory

_AT_ONCE = 5_000_000  # instructions, so that Ctrl-C is answered soon
_STOPS = tuple(StopKind)
_FAULTS = tuple(FaultKind)
_NO_LIMIT = (1 << 64) - 1
_PAUSE = len(_STOPS)  # a run ended before its limit
_LIMIT = Stop(StopKind.LIMIT)
_PLAIN = (StopKind.LIMIT, StopKind.WFI, StopKind.WFE, StopKind.SEV, StopKind.STEP, StopKind.HIT)
_PLAIN_STOPS = tuple(Stop(kind) if kind in _PLAIN else None for kind in _STOPS)
# How many numbers functions of nvic.c and entry.c take: those that say whether, that return a trouble, and the others.
_SAY_WHETHER = {"hil_can_take": 0, "hil_wakes": 0, "hil_scs_write": 3}
_STEPS = {"hil_take": 0, "hil_stack": 0, "hil_act": 2, "hil_systick_lanes": 1}
_OTHERS = {
    **dict.fromkeys(("hil_pend", "hil_unpend", "hil_enable", "hil_disable", "hil_set_grouping"), 1),
    **dict.fromkeys(("hil_set_active", "hil_drive_line", "hil_set_priority"), 2),
    "hil_reset_exceptions": 0,
    "hil_set_up_exceptions": 2,
    "hil_wake": 0,
    "hil_pay": 0,
    "hil_settle_floats": 0,
    "hil_reset_systick": 0,
    "hil_hold_systick": 1,
    "hil_tick": 0,
}
_SP, _PC, _XPSR, _MSP, _PSP, _CONTROL = Reg.SP, Reg.PC, Reg.XPSR, Reg.MSP, Reg.PSP, Reg.CONTROL
_IPSR, _SPSEL = 0x1FF, 1 << 1
_XPSR_BITS, _GE = 0xFF00_FDFF, 0x000F_0000


class Skip(enum.IntEnum):
    """What becomes of loops that change nothing.

    NOTHING: they are executed.
    LOOPS: they are passed over, as many whole turns as end before the limit.
    LOOK_ONCE: the run ends after a look at what the program does.
    """

    NOTHING = 0
    LOOPS = 1
    LOOK_ONCE = 2


@dataclass(frozen=True, slots=True)
class Loop:
    """A loop that changes nothing.

    Attributes:
        pc: an instruction of it.
        instructions: in one period.
        polled: addresses of the registers that are read in it, in their order.
    """

    pc: int
    instructions: int
    polled: tuple[int, ...]


class Caller(Protocol):
    """Whose functions C calls."""

    def keep(self, trouble: BaseException) -> None:
        """Have an exception come out of whatever has called C."""


class InC(Caller, Protocol):
    """A block of registers in C."""

    @property
    def block(self) -> ctypes.c_void_p:
        """``struct hil_block``."""


FlashStore = Callable[[int, int, int], None]


class CoreEngine:
    """A `CpuEngine` (see `api`).

    Args:
        timing: how many cycles instructions take.
        kind: the core to be.

    Attributes:
        on_flash_store: called at the end of an instruction that stores into read-only memory, with address, size in
            bytes and value, for every part of the store in order; the memory is unchanged. A `BusFault` is a fault of
            the instruction.
        exceptions: what is kept of them; ``struct hil_exceptions`` (`exceptions.h`).
        systick: the timer; ``struct hil_systick``.
        hooks: breakpoints, watchpoints, edges, accesses to registers.

    Raises:
        EngineError: the library is missing and cannot be made.
    """

    def __init__(self, timing: Timing, kind: CoreKind = CORTEX_M3) -> None:
        library = _library()
        self._library = library
        self._callbacks = _READ(self._read), _WRITE(self._write)
        bits = 0xFF & ~((1 << 8 - kind.priority_bits) - 1)
        core = library.hil_new(kind.model == "M7", timing.name == "table", bits, *self._callbacks)
        if not core:
            raise EngineError("there is no memory for a core")
        self._core = ctypes.c_void_p(core)
        weakref.finalize(self, library.hil_free, self._core).atexit = False  # what runs at exit may still ask
        self._state = state = structure("hil_state").from_address(library.hil_state_of(self._core))
        self.exceptions: Any = structure("hil_exceptions").from_address(library.hil_exceptions_of(self._core))
        self.systick: Any = structure("hil_systick").from_address(library.hil_systick_of(self._core))
        self.hooks = Hooks(library, self._core)
        self._times = memoryview(state).cast("B")[:16].cast("Q")  # its first fields, `cycle` and `retired`
        self._registers = memoryview(state.reg).cast("B").cast("I")
        self._floats = memoryview(state.floats).cast("B").cast("I")
        self._has_floats = kind.fpu is not None
        self._xpsr_bits = _XPSR_BITS | (_GE if kind.fpu is not None else 0)
        self._windows: dict[int, tuple[int, Access]] = {}
        self._looked_at: dict[int, list[int]] = {}  # by the number of the lap
        self._memory: list[tuple[int, Any, bool]] = []
        self._kept: list[object] = []  # what C holds pointers to
        self._trouble: BaseException | None = None
        self._callers: list[Caller] = [self]
        self._raise_kept: Callable[[], None] = lambda: None
        self._others_hook = sys.unraisablehook
        self._refusal = 0, ""
        self._timing = timing
        timing.attach(state)
        self.on_flash_store: FlashStore = lambda _address, _size, _value: None

    # --- time

    @property
    def cycle(self) -> int:
        """The present HCLK cycle; within a register access, the one at which its instruction began."""
        return self._times[0]

    def read_cycle(self) -> int:
        """Return `cycle`; for those who ask often."""
        return self._times[0]

    @property
    def instructions(self) -> int:
        """Instructions retired so far; those that an IT block passes over do not count."""
        return self._times[1]

    @property
    def running(self) -> bool:
        """True while instructions execute, which is when registers are accessed."""
        return bool(self._state.running)

    @property
    def timing(self) -> Timing:
        """The timing model."""
        return self._timing

    def add_cycles(self, cycles: int) -> None:
        """Let cycles pass without an instruction."""
        self._timing.add(cycles)

    def skip_periods(self, cycle: int, instructions: int, cycles: int) -> None:
        """Account for loops that change nothing, as many whole ones as end before `cycle`, without executing them."""
        periods = self._timing.periods_until(cycle, instructions, cycles)
        if periods > 0:
            self._timing.skip(periods * instructions, periods * cycles)

    def set_wait_states(self, wait_states: int) -> None:
        """Change the flash wait states, from the instruction in flight on."""
        self._timing.set_wait_states(wait_states)
        self._state.changed = 1

    def live_in(self, time: Timebase) -> None:
        """Let this core live in the time of a chip: the events there end its runs, or happen in them."""
        time.keep_alive(self)
        self._callers.append(time)
        self._raise_kept = time.raise_kept
        self._library.hil_join(self._core, time.queue)

    @property
    def core(self) -> ctypes.c_void_p:
        """The core in C, for what drives its interrupts there; it lasts as long as this does."""
        return self._core

    def attach(self, block: InC) -> None:
        """Let C answer for a block of registers in a window, where it can."""
        self._callers.append(block)
        if not self._library.hil_attach(self._core, block.block):
            raise ValueError("too many blocks of registers in C")

    # --- the memory map

    def map_memory(self, base: int, data: bytearray, *, writable: bool) -> None:
        """Put memory at `base`; see `CpuEngine`."""
        window = (ctypes.c_uint8 * len(data)).from_buffer(data)
        self._kept.append(window)
        number = self._library.hil_map_memory(self._core, base, ctypes.addressof(window), len(data), writable)
        _check(number, base)
        self._memory.append((base, data, writable))

    def map_registers(self, base: int, size: int, access: Access) -> None:
        """Put registers at `base`; see `CpuEngine`.

        A `BusFault` in an access is a fault of its instruction. Any other exception ends the slice after it and comes
        out of `run`.
        """
        number = self._library.hil_map_registers(self._core, base, size)
        _check(number, base)
        self._windows[number] = base, access

    def forget(self, base: int, size: int) -> None:
        """Drop what was decoded from `size` bytes at `base`; see `CpuEngine`."""
        self._library.hil_forget(self._core, base, size)

    def half(self, address: int) -> int:
        """Return the half-word of memory at an even address; 0 where there is none."""
        for base, data, _ in self._memory:
            if base <= address < base + len(data):
                return int.from_bytes(data[address - base : address - base + 2], "little")
        return 0

    # --- what was executed

    def cover(self) -> None:
        """Remember from now on what is executed, also of memory that is written later.

        Raises:
            MemoryError: there is no memory for it.
        """
        if not self._library.hil_cover(self._core):
            raise MemoryError

    def executed(self) -> Iterator[int]:
        """Return the addresses of all instructions that were executed since `cover`, or faulted, in no order.

        Memory that lies at several addresses counts at each by itself.
        """
        for base, data, _ in self._memory:
            place = self._library.hil_executed(self._core, base)
            began = ctypes.string_at(place, len(data) // 2) if place else b""
            at = began.find(1)
            while at >= 0:
                yield base + 2 * at
                at = began.find(1, at + 1)

    # --- its state as a whole

    def save(self) -> bytes:
        """Return the state in C of the core, of the queue that it lives in and of the blocks, for its `restore`."""
        saved = ctypes.create_string_buffer(self._library.hil_saved_size(self._core))
        self._library.hil_save(self._core, saved)
        return saved.raw

    def restore(self, saved: bytes) -> None:
        """Put such a state back. Not while running."""
        self._library.hil_restore(self._core, saved)

    # --- registers

    def get(self, register: int) -> int:
        """Return a core register, 32 bits."""
        return self._registers[self._stack_in_use() if register == _SP else register]

    def set(self, register: int, value: int) -> None:
        """Set a core register."""
        if register == _SP:
            register = self._stack_in_use()
        elif register == _PC:
            value &= ~1
        elif register == _XPSR:
            value &= self._xpsr_bits
        self._registers[register] = value

    def get_many(self, registers: Sequence[int]) -> list[int]:
        """Return several core registers, without SP."""
        values = self._registers
        return [values[register] for register in registers]

    def set_many(self, registers: Sequence[int], new: Sequence[int]) -> None:
        """Set several of R0 to R12, LR and PC."""
        values = self._registers
        for register, value in zip(registers, new, strict=True):
            values[register] = value

    def pc(self) -> int:
        """Return PC, faster than `get` where nothing else is asked."""
        return self._registers[_PC]

    def fingerprint(self) -> bytes:
        """Return all registers, those of the core first, as bytes to compare."""
        self._registers[_SP] = self._registers[self._stack_in_use()]
        contents = self._registers.tobytes()
        return contents + self._floats.tobytes() if self._has_floats else contents

    def _stack_in_use(self) -> int:
        values = self._registers
        return _PSP if values[_CONTROL] & _SPSEL and not values[_XPSR] & _IPSR else _MSP

    def get_floats(self) -> list[int]:
        """Return S0 to S31 and FPSCR; see `CpuEngine`."""
        return self._floats.tolist()

    def set_floats(self, words: Sequence[int]) -> None:
        """Set S0 to S31 and FPSCR; see `CpuEngine`."""
        for place, word in enumerate(words):
            self._floats[place] = word

    # --- running

    def run(self, limit_cycle: int, limit_instructions: int | None = None, *, skip: Skip = Skip.NOTHING) -> Stop:
        """Execute up to `limit_cycle`, without taking exceptions; see `CpuEngine`.

        Args:
            limit_cycle: as there.
            limit_instructions: as there.
            skip: what becomes of loops that change nothing.
        """
        return self._call(self._library.hil_run, limit_cycle, limit_instructions, skip)

    def go(self, limit_cycle: int, *, skip: Skip = Skip.NOTHING) -> Stop:
        """Execute up to `limit_cycle`, take exceptions and return from them, sleep, and let happen what is due.

        Returns:
            LIMIT also where the time is halted. FAULT, BREAKPOINT and TROUBLE are for somebody else, WFI is a deep
            sleep, HIT is a stop of `hooks`, STEP comes if ``exceptions.by_steps`` asks for it; nothing else.
        """
        return self._call(self._library.hil_go, limit_cycle, None, skip)

    def _call(self, function: Any, limit_cycle: int, limit_instructions: int | None, skip: Skip) -> Stop:
        self._state.skip = skip
        limit = min(max(limit_cycle, 0), _NO_LIMIT)
        at_once = _AT_ONCE if limit_instructions is None else limit_instructions
        while True:
            self._others_hook, sys.unraisablehook = sys.unraisablehook, self._on_unraisable
            try:
                why = function(self._core, limit, at_once)
            finally:
                sys.unraisablehook = self._others_hook
            if self._trouble is not None:
                trouble, self._trouble = self._trouble, None
                raise trouble
            self._raise_kept()
            if why != _PAUSE:
                return _PLAIN_STOPS[why] or self._stop(_STOPS[why])
            if limit_instructions is not None or skip is Skip.LOOK_ONCE or self._was_cut():
                return _LIMIT
            limit = self._state.limit_cycle  # as lowered since

    def act(self, stop: Stop) -> int:
        """Do what an instruction has asked for by which `run` has ended; return what trouble there was."""
        return int(self._library.hil_act(self._core, _STOPS.index(stop.kind), stop.value))

    def ask(self, function: str, *arguments: int) -> int:
        """Call a function of the library that takes the core and some numbers."""
        return self.asking(function)(*arguments) or 0

    def asking(self, function: str) -> Callable[..., int]:
        """Return such a function."""
        return partial(getattr(self._library, function), self._core)

    def _was_cut(self) -> bool:
        """Say whether a run that ended before its limit did so for another reason than that Ctrl-C may be waiting."""
        state = self._state
        return (
            bool(state.counting or state.attention or min(state.alarm, state.due) <= state.cycle)
            or not state.limit_retired
        )

    def _stop(self, kind: StopKind) -> Stop:
        state = self._state
        if kind is not StopKind.FAULT:
            return Stop(kind, state.stop_value)
        fault = _FAULTS[state.fault]
        address, refusal = state.fault_address, ""
        if state.refused and fault in (FaultKind.READ, FaultKind.WRITE):
            (address, refusal), state.refused = self._refusal, 0
        return Stop(kind, fault=fault, address=address, refusal=refusal)

    @property
    def reached_limit(self) -> bool:
        """True if the last run has come to its `limit_cycle`, perhaps lowered: something else is to be done now.

        So it is if an exception wants to be taken, the SysTick timer has come to zero, or an event is due.
        """
        state = self._state
        return bool(state.cycle >= min(state.limit_cycle, state.alarm, state.due) or state.attention)

    @property
    def alarm(self) -> int:
        """The cycle at which the SysTick timer comes to zero next, if anybody could notice; else far away."""
        return self._state.alarm  # type: ignore[no-any-return]

    def ticks(self) -> tuple[int, int, int, int] | None:
        """Return how SysTick counts down: a value, cycles per step, the cycle of that value, how long so; or None."""
        value, divider = ctypes.c_uint32(), ctypes.c_uint32()
        origin, until = ctypes.c_uint64(), ctypes.c_uint64()
        places = (ctypes.byref(place) for place in (value, divider, origin, until))
        if not self._library.hil_systick_count(self._core, *places):
            return None
        return value.value, divider.value, origin.value, until.value

    @property
    def limit_cycle(self) -> int:
        """The `limit_cycle` of the last run, as lowered since."""
        return self._state.limit_cycle  # type: ignore[no-any-return]

    def stop_by(self, limit_cycle: int) -> None:
        """Lower the limit of the running slice; see `CpuEngine`."""
        state = self._state
        if state.running and limit_cycle < state.limit_cycle:
            state.limit_cycle = max(limit_cycle, 0)
            state.changed = 1

    def cut(self) -> None:
        """End the running slice after the instruction in flight, from within a register access; nothing is due."""
        self._state.limit_retired = 0
        self._state.changed = 1

    @property
    def until_unmasked(self) -> bool:
        """A slice ends after an instruction that may take an interrupt mask away."""
        return bool(self._state.until_unmasked)

    @until_unmasked.setter
    def until_unmasked(self, wanted: bool) -> None:
        self._state.until_unmasked = wanted

    @property
    def through_python(self) -> bool:
        """Every access to a register goes by `Access`, also to those of the core itself."""
        return bool(self._state.through_python)

    @through_python.setter
    def through_python(self, wanted: bool) -> None:
        self._state.through_python = wanted

    @property
    def core_writes(self) -> int:
        """How many registers of the core itself were written without `Access`."""
        return int(self._state.writes)

    @property
    def block_writes(self) -> int:
        """How many registers beside the core were written without `Access`."""
        return int(self._state.block_writes)

    # --- loops that change nothing

    @property
    def loop(self) -> Loop | None:
        """The loop in which the last look has found the program; None since `forget_loop`, or if it found none."""
        state = self._state
        if not state.loop_instructions:
            return None
        polled = self._looked_at.get(state.loop_lap, ())
        return Loop(state.loop_pc, state.loop_instructions, tuple(sorted(set(polled))))

    def forget_loop(self) -> None:
        """Something has happened, and the program may go elsewhere."""
        self._state.loop_instructions = 0

    @property
    def counting(self) -> bool:
        """True if the last run ended within a loop that reads what changes with time, and changes nothing else."""
        return bool(self._state.counting)

    def look_after(self, instructions: int) -> None:
        """Have a run that skips look for a loop after so many instructions, not before, and whenever it starts."""
        self._state.look_wait = instructions
        self._state.look_at = self._state.retired + instructions
        self._state.changed = 1

    @property
    def polls_wanted(self) -> int:
        """After how many reads of the same register in a row, and no write, a loop is looked for at once."""
        return int(self._state.polls_wanted)

    @polls_wanted.setter
    def polls_wanted(self, reads: int) -> None:
        self._state.polls_wanted = reads

    @property
    def polled_often(self) -> bool:
        """Whether there were so many, since this was last set to False."""
        return bool(self._state.polled_often)

    @polled_often.setter
    def polled_often(self, polled: bool) -> None:
        self._state.polled_often = polled

    # --- what the system control space decides

    def set_traps(self, *, division: bool, unaligned: bool) -> None:
        """Let divisions by zero and unaligned accesses be faults; see `CpuEngine`."""
        self._state.trap_division, self._state.trap_unaligned = division, unaligned
        self.cut()

    def set_float_access(self, access: FloatAccess) -> None:
        """Let floating-point instructions of others be undefined; see `CpuEngine`."""
        self._state.float_access = access
        self.cut()

    # --- what C calls

    def _read(self, window: int, offset: int, size: int) -> int:
        base, access = self._windows[window]
        try:
            if self._state.looking:
                self._look_at(base, offset, access)
            return access.read(offset, size)
        except BusFault as fault:
            self._refuse(fault)
        except BaseException as trouble:  # noqa: BLE001 - ctypes would swallow it
            self.keep(trouble)
        return 0

    def _write(self, window: int, offset: int, size: int, value: int) -> None:
        try:
            if window == _READ_ONLY:
                self.on_flash_store(offset, size, value)
            else:
                self._windows[window][1].write(offset, size, value)
        except BusFault as fault:
            self._refuse(fault)
        except BaseException as trouble:  # noqa: BLE001
            self.keep(trouble)

    def _look_at(self, base: int, offset: int, access: Access) -> None:
        lap, found = self._state.lap, self._state.loop_lap
        if lap not in self._looked_at:
            self._looked_at = {found: self._looked_at.get(found, []), lap: []}
        self._looked_at[lap].append(base + offset)
        if access.is_live(offset):
            self._state.live = 1

    def _on_unraisable(self, unraisable: Any) -> None:
        """Keep what a signal raises where a callback begins, before its ``try``: ctypes would ignore it."""
        owner = owner_of(unraisable)
        caller = next((one for one in self._callers if one is owner), None)
        if caller is not None and unraisable.exc_value is not None:
            caller.keep(unraisable.exc_value)
        else:
            self._others_hook(unraisable)

    def _refuse(self, fault: BusFault) -> None:
        self._refusal = fault.address, fault.refusal
        self._state.refused = 1

    def keep(self, trouble: BaseException) -> None:
        """End the run, and have it raise this."""
        if self._trouble is None:
            self._trouble = trouble
        self._state.limit_cycle = 0
        self.cut()


def _check(number: int, base: int) -> None:
    if number < 0:
        raise ValueError(f"0x{base:08X}: too many regions, or no multiple of 4 bytes")


def _library() -> Any:
    """Return the library, with its functions declared, called with Python's lock held."""
    library: Any = with_lock_held()
    pointer, word, double = ctypes.c_void_p, ctypes.c_uint32, ctypes.c_uint64
    library.hil_new.argtypes, library.hil_new.restype = (word, word, word, _READ, _WRITE), pointer
    library.hil_free.argtypes, library.hil_free.restype = (pointer,), None
    library.hil_attach.argtypes, library.hil_attach.restype = (pointer, pointer), ctypes.c_bool
    library.hil_join.argtypes, library.hil_join.restype = (pointer, pointer), None
    library.hil_state_of.argtypes, library.hil_state_of.restype = (pointer,), pointer
    library.hil_map_memory.argtypes = (pointer, word, pointer, word, word)
    library.hil_map_memory.restype = ctypes.c_int32
    library.hil_map_registers.argtypes, library.hil_map_registers.restype = (pointer, word, word), ctypes.c_int32
    library.hil_forget.argtypes, library.hil_forget.restype = (pointer, word, word), None
    library.hil_cover.argtypes, library.hil_cover.restype = (pointer,), ctypes.c_bool
    library.hil_executed.argtypes, library.hil_executed.restype = (pointer, word), pointer
    library.hil_saved_size.argtypes, library.hil_saved_size.restype = (pointer,), double
    for mover in (library.hil_save, library.hil_restore):
        mover.argtypes, mover.restype = (pointer, pointer), None
    library.hil_hit_of.argtypes, library.hil_hit_of.restype = (pointer,), pointer
    for setter in (library.hil_set_breakpoints, library.hil_set_watchpoints):
        setter.argtypes, setter.restype = (pointer, pointer, word), ctypes.c_bool
    for giver in (library.hil_map_edges, library.hil_log_accesses):
        giver.argtypes, giver.restype = (pointer, pointer, word), None
    library.hil_accesses_logged.argtypes, library.hil_accesses_logged.restype = (pointer,), word
    library.hil_exceptions_of.argtypes, library.hil_exceptions_of.restype = (pointer,), pointer
    for run in (library.hil_run, library.hil_go):
        run.argtypes, run.restype = (pointer, double, double), word
    library.hil_systick_of.argtypes, library.hil_systick_of.restype = (pointer,), pointer
    library.hil_systick_count.argtypes = (pointer,) * 5
    library.hil_systick_count.restype = ctypes.c_bool
    library.hil_scs_read.argtypes, library.hil_scs_read.restype = (pointer, word, word, pointer), ctypes.c_bool
    for result, functions in ((ctypes.c_bool, _SAY_WHETHER), (word, _STEPS), (None, _OTHERS)):
        for name, arguments in functions.items():
            function = getattr(library, name)
            function.argtypes, function.restype = (pointer, *(word,) * arguments), result
    return library
