"""Executes Thumb-2 with Unicorn, used as a bare Cortex-M core; the reference engine.

What is worked around, each pinned by a test in tests/targets/mcu/engine:

- The counter of instructions is read and lowered directly (see `calibration`); `emu_stop` is never used inside a
  register access, `emu_start(timeout=)` never at all (it can hang for ever).
- RAM is always executable on M-profile, which makes Unicorn check every store for self-modifying code. The virtual TLB
  lets us say which pages really hold code: those that were ever fetched from ("sticky").
- WFE and YIELD arrive as invalid instructions, SEV not at all: its places are looked up in the image and hooked.
- Stores into flash reach the memory although it is read-only, after a hook; they are undone and handed on.
- Hooks for accesses that fail make those slow that do not, so they keep clear of memory.
- A slice cannot end within an IT block: Unicorn runs to the end of it.
- The first access to a page within an IT block would make what follows the block conditional, and so would a store
  into flash.
- After an ISB within an IT block the rest of it would be unconditional; those are looked up in the image, too.
- An access that fails does not stop its instruction, nor the rest of an IT block: all of that is undone (`rollback`).
- What registers need is in `register_file`, what floating point does in `float_gate` and `hidden_state`.
"""

from __future__ import annotations

import ctypes
import re
from collections.abc import Callable, Iterator, Sequence
from typing import Any

from targets.mcu.cortexm.kinds import CORTEX_M3, CoreKind
from targets.mcu.engine.api import Access, FaultKind, FloatAccess, Reg, Stop, StopKind
from targets.mcu.engine.calibration import counter_words, open_unicorn
from targets.mcu.engine.float_file import FloatFile
from targets.mcu.engine.float_gate import FloatGate
from targets.mcu.engine.hidden_state import HiddenState, Word
from targets.mcu.engine.it_state import advanced, it_state_at
from targets.mcu.engine.register_file import RegisterFile
from targets.mcu.engine.rollback import Before
from targets.mcu.engine.timing import Timing
from targets.mcu.engine.traps import Traps
from targets.mcu.engine.unmasking import LONGEST, unmasking_places
from targets.mcu.errors import BusFault

__all__ = ["UnicornEngine"]

_WFE, _YIELD, _SEV = 0xBF20, 0xBF10, 0xBF40
_WIDE_HINTS = {0xF3AF8002: _WFE, 0xF3AF8001: _YIELD, 0xF3AF8004: _SEV}
_T_BIT = 1 << 24
_EXC_RETURN = 0xFFFF_FFE0
_PAGE_BITS = 10  # M-profile pages are 1 KB
_LDREX = re.compile(rb"[\x50-\x5f]\xe8|[\xd0-\xdf]\xe8.[\x40-\x5f]", re.DOTALL)
_CLREX = b"\xbf\xf3\x2f\x8f"
_ISB = b"\xbf\xf3\x6f\x8f"
_ERASED = b"\xff" * 4096
_CLREX_PLACE = 0xF000_0000  # in the vendor's region, where no program executes

_READ_FN = ctypes.CFUNCTYPE(ctypes.c_uint64, ctypes.c_void_p, ctypes.c_uint64, ctypes.c_uint, ctypes.c_void_p)
_WRITE_FN = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_uint64, ctypes.c_uint, ctypes.c_uint64, ctypes.c_void_p)

_INTR_FN = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_uint32, ctypes.c_void_p)

_LIMIT, _WFI = Stop(StopKind.LIMIT), Stop(StopKind.WFI)
_RETURNS = {
    value & ~1: Stop(StopKind.EXCEPTION_RETURN, value)
    for value in (0xFFFF_FFF1, 0xFFFF_FFF9, 0xFFFF_FFFD, 0xFFFF_FFE1, 0xFFFF_FFE9, 0xFFFF_FFED)
}
_ASPEN, _NPRIV, _FPCA, _IPSR = 1 << 31, 1 << 0, 1 << 2, 0x1FF

FlashStore = Callable[[int, int, int], None]


class UnicornEngine:
    """A `CpuEngine` (see `api`) on Unicorn.

    Args:
        timing: how many cycles instructions take.
        kind: the core to be.

    Attributes:
        on_flash_store: called after the instruction that stored into read-only memory, with address, size in bytes and
            value, for every part of the store in order; the memory is unchanged. A `BusFault` is a fault of the
            instruction.
        fingerprint: returns all registers, those of the core first, as bytes to compare.
        pc: returns PC, faster than `get` where nothing else is asked.
        until_unmasked: a slice ends after an instruction that may take an interrupt mask away; only while
            `notices_unmasking`.

    Raises:
        EngineError: Unicorn is missing or not the one this was written for.
    """

    def __init__(self, timing: Timing, kind: CoreKind = CORTEX_M3) -> None:
        import unicorn
        from unicorn import arm_const
        from unicorn.unicorn_py3.unicorn import uclib

        self._uc = open_unicorn(kind.model)
        self._words = counter_words(self._uc)
        self._handle = self._uc._uch  # noqa: SLF001 - the binding's own call costs as much as the C call
        self._lib = uclib
        self._emu_start = uclib.uc_emu_start
        self._const = unicorn
        self._hidden = None if kind.fpu is None else HiddenState(self._uc, uclib)
        self._floats = None if kind.fpu is None else FloatFile(uclib, self._handle, arm_const)
        self._registers = registers = RegisterFile(uclib, self._handle, arm_const, self._hidden)
        self.get, self.get_many = registers.get, registers.get_many
        self.set, self.set_many = registers.set, registers.set_many
        self.fingerprint, self.pc = registers.contents, registers.pc
        if self._floats is not None:
            self.fingerprint = self._fingerprint_with_floats
        self._timing = timing
        self._cycle_after = timing.cycle
        self._now = 0
        self._retired = 0
        self._limit_cycle = 0
        self._running = False
        self._trouble: BaseException | None = None
        self._intr: int | None = None
        self._bad_address = 0
        self._refused: tuple[Stop, Before] | None = None
        self._event_sent = False
        self._no_conditions = ctypes.byref(ctypes.c_uint32(_T_BIT))
        self._flash_stores: list[tuple[int, int, int, bytes, Before]] = []
        self._memory: list[tuple[int, bytearray, bool]] = []
        self._code_pages: set[int] = set()
        self._kept: list[object] = []  # what C holds pointers to
        self._hint_hooks: dict[int, int] = {}
        self._isb_hooks: set[int] = set()
        self._hole_hooks: list[int] = []
        self._has_exclusives = False
        self.until_unmasked = False
        self._unmasking_hooks: set[int] | None = None
        self._code_in_ram = False
        self._traps = Traps(self._uc, self._core_register, self._on_division, self._on_unaligned)
        self._gate = FloatGate(self._uc, self.half, self._is_privileged, self._on_denied_float)
        self._access_wanted = FloatAccess.EVERYBODY
        self._context_wanted = self._context_set = (True, 0)
        self._traps_wanted = self._traps_set = (False, False)
        self.on_flash_store: FlashStore = lambda _address, _size, _value: None
        self._hook()
        timing.attach(self._uc, self._words, self.get, self.half)

    # --- time

    @property
    def cycle(self) -> int:
        """The present HCLK cycle; within a register access, the one at which its instruction began."""
        return self._cycle_after(self._retired + self._words[0] - 1) if self._running else self._now

    def read_cycle(self) -> int:
        """Return `cycle`; for those who ask often."""
        return self._cycle_after(self._retired + self._words[0] - 1) if self._running else self._now

    @property
    def instructions(self) -> int:
        """Instructions retired so far; an IT block whose condition fails counts for its IT alone."""
        return self._retired + self._words[0] - 1 if self._running else self._retired

    @property
    def running(self) -> bool:
        """True while instructions execute, which is when registers are accessed."""
        return self._running

    @property
    def timing(self) -> Timing:
        """The timing model."""
        return self._timing

    def add_cycles(self, cycles: int) -> None:
        """Let cycles pass without an instruction."""
        self._timing.add(cycles)
        self._now += cycles

    def skip_periods(self, cycle: int, instructions: int, cycles: int) -> None:
        """Account for loops that change nothing, as many whole ones as end before `cycle`, without executing them."""
        periods = self._timing.periods_until(cycle, self._retired, instructions, cycles)
        if periods > 0:
            self._retired += periods * instructions
            self._timing.skip(periods * instructions, periods * cycles)
            self._now = self._cycle_after(self._retired)

    def set_wait_states(self, wait_states: int) -> None:
        """Change the flash wait states, from the instruction in flight on."""
        self._timing.set_wait_states(wait_states, self.instructions)
        if not self._running:
            self._now = self._cycle_after(self._retired)

    # --- the memory map

    def map_memory(self, base: int, data: bytearray, *, writable: bool) -> None:
        """Put memory at `base`; see `CpuEngine`."""
        window = (ctypes.c_uint8 * len(data)).from_buffer(data)
        self._kept.append(window)
        rights = self._const.UC_PROT_ALL if writable else self._const.UC_PROT_READ | self._const.UC_PROT_EXEC
        self._uc.mem_map_ptr(base, len(data), rights, ctypes.addressof(window))
        self._memory.append((base, data, writable))
        if not writable:
            self._uc.hook_add(
                self._const.UC_HOOK_MEM_WRITE_PROT, self._on_flash_write, begin=base, end=base + len(data) - 1
            )
            self._note_code(base, data)
        self._watch_holes()

    def map_registers(self, base: int, size: int, access: Access) -> None:
        """Put registers at `base`; see `CpuEngine`.

        A `BusFault` in an access is a fault of its instruction. Any other exception ends the slice after it and comes
        out of `run`.
        """

        def read(_uc: object, offset: int, length: int, _data: object) -> int:
            if self._refused is not None:
                return 0
            try:
                return access.read(offset, length)
            except BusFault as fault:
                return self._refuse(FaultKind.READ, fault.address, fault.refusal)
            except BaseException as trouble:  # noqa: BLE001 - ctypes would swallow it
                return self._break_off(trouble)

        def write(_uc: object, offset: int, length: int, value: int, _data: object) -> None:
            if self._refused is not None:
                return
            try:
                access.write(offset, length, value)
            except BusFault as fault:
                self._refuse(FaultKind.WRITE, fault.address, fault.refusal)
            except BaseException as trouble:  # noqa: BLE001
                self._break_off(trouble)

        callbacks = _READ_FN(read), _WRITE_FN(write)
        self._kept.extend(callbacks)
        status = self._lib.uc_mmio_map(self._handle, base, size, callbacks[0], None, callbacks[1], None)
        if status != self._const.UC_ERR_OK:
            raise self._const.UcError(status)

    def forget(self, base: int, size: int) -> None:
        """Drop what was translated from `size` bytes at `base`; see `CpuEngine`."""
        self._drop_translations(base, size)
        self._timing.forget()
        for start, data, writable in self._memory:
            if not writable and start <= base < start + len(data):
                self._note_code(base, data[base - start : base - start + size])
                first = max(start, base - LONGEST)
                self._hook_unmasking(first, data[first - start : base - start + size + LONGEST])

    def _drop_translations(self, base: int, size: int) -> None:
        """Drop what was translated; also the answer of the TLB that Unicorn asks for on that occasion, as for code."""
        self._uc.ctl_remove_cache(base, base + size)
        self._lib.uc_ctl(self._handle, self._const.UC_CTL_TLB_FLUSH | self._const.UC_CTL_IO_WRITE << 30)

    def _watch_holes(self) -> None:
        """Hook accesses to where no memory is."""
        while self._hole_hooks:
            self._uc.hook_del(self._hole_hooks.pop())
        kinds = self._const.UC_HOOK_MEM_READ_UNMAPPED | self._const.UC_HOOK_MEM_WRITE_UNMAPPED
        places = sorted((base, base + len(data)) for base, data, _ in self._memory)
        starts, ends = [0, *(end for _, end in places)], [*(base for base, _ in places), 1 << 32]
        for start, end in zip(starts, ends, strict=True):
            if start < end:
                self._hole_hooks.append(self._uc.hook_add(kinds, self._on_unmapped, begin=start, end=end - 1))

    # --- running

    def run(self, limit_cycle: int, limit_instructions: int | None = None) -> Stop:
        """Execute up to `limit_cycle`; see `CpuEngine`."""
        if self._traps_wanted != self._traps_set:
            self._set_traps()
        if self._floats is not None:
            self._settle_floats()
        limit = None if limit_instructions is None else self._retired + limit_instructions
        self._limit_cycle = limit_cycle
        while True:
            stop = self._run_slice(limit)
            if stop is not None:
                return stop

    @property
    def reached_limit(self) -> bool:
        """True if the last run has come to its `limit_cycle`, perhaps lowered: something else is to be done now."""
        return self.cycle >= self._limit_cycle

    @property
    def limit_cycle(self) -> int:
        """The `limit_cycle` of the last run, as lowered since."""
        return self._limit_cycle

    def _run_slice(self, limit: int | None) -> Stop | None:
        """Execute; None when an instruction that Unicorn cannot take was passed over and there is time left."""
        timing, registers, words = self._timing, self._registers, self._words
        budget = timing.begin_slice(self._limit_cycle, self._retired)
        if limit is not None and limit - self._retired < budget:
            budget = limit - self._retired
        if budget < 1:
            budget = 1
        self._intr = None
        pc = registers.pc() | 1
        registers.release()
        self._running = registers.running = True
        status = self._emu_start(self._handle, pc, 0, 0, budget)
        self._running = registers.running = False
        counted = words[0]
        stop, retired = self._why(status, counted, counted > words[1])
        self._retired += retired
        timing.end_slice(self._retired)
        self._now = self._cycle_after(self._retired)
        if self._flash_stores:
            self._hand_on_flash_stores()
        if self._refused is not None:
            stop = self._roll_back()
        if self._trouble is not None:
            trouble, self._trouble = self._trouble, None
            raise trouble
        if stop is None and (budget <= retired or self._now >= self._limit_cycle):
            return _LIMIT
        return stop

    def stop_by(self, limit_cycle: int) -> None:
        """Lower the limit of the running slice; see `CpuEngine`."""
        if not self._running:
            return
        self._limit_cycle = min(self._limit_cycle, limit_cycle)
        words = self._words
        limit = self._timing.lower_limit(limit_cycle, self._retired)
        words[1] = min(words[1], max(words[0], limit))

    def cut(self) -> None:
        """End the running slice after the instruction in flight, from within a register access; nothing is due."""
        if self._running:
            self._words[1] = self._words[0]

    def _why(self, status: int, counted: int, at_limit: bool) -> tuple[Stop | None, int]:
        """Return why Unicorn came back, and how many instructions have retired."""
        if self._refused is not None:
            self._event_sent = False
            return None, counted - 1
        if self._intr is not None:
            return self._why_interrupt(self._intr, counted)
        if status:
            return self._why_error(status, counted)
        if self._event_sent:
            self._event_sent = False
            return Stop(StopKind.SEV), counted - 1 if at_limit else counted
        return (_LIMIT, counted - 1) if at_limit else (_WFI, counted)

    def _why_interrupt(self, number: int, counted: int) -> tuple[Stop, int]:
        pc = self._registers.pc()
        if number == 8 or (number == 3 and pc >= _EXC_RETURN):
            return _RETURNS.get(pc) or Stop(StopKind.EXCEPTION_RETURN, pc | 1), counted
        if number == 2:
            return Stop(StopKind.SVC, self.half(pc - 2) & 0xFF), counted
        if number == 7:
            return Stop(StopKind.BREAKPOINT, self.half(pc) & 0xFF), counted - 1
        return Stop(StopKind.FAULT, fault=FaultKind.UNDEFINED, address=pc), counted - 1

    def _why_error(self, status: int, counted: int) -> tuple[Stop | None, int]:
        const, pc = self._const, self.get(Reg.PC)
        if status == const.UC_ERR_INSN_INVALID:
            return self._why_invalid(pc, counted)
        if status in (const.UC_ERR_FETCH_UNMAPPED, const.UC_ERR_FETCH_PROT):
            return Stop(StopKind.FAULT, fault=FaultKind.FETCH, address=pc), counted
        if status in (const.UC_ERR_READ_UNMAPPED, const.UC_ERR_READ_PROT):
            return Stop(StopKind.FAULT, fault=FaultKind.READ, address=self._bad_address), counted - 1
        if status in (const.UC_ERR_WRITE_UNMAPPED, const.UC_ERR_WRITE_PROT):
            return Stop(StopKind.FAULT, fault=FaultKind.WRITE, address=self._bad_address), counted - 1
        return Stop(StopKind.FAULT, fault=FaultKind.UNDEFINED, address=pc), counted - 1

    def _why_invalid(self, pc: int, counted: int) -> tuple[Stop | None, int]:
        if not self.get(Reg.XPSR) & _T_BIT:
            return Stop(StopKind.FAULT, fault=FaultKind.STATE, address=pc), counted
        hint = self._hint_before(pc)
        if hint == _WFE:
            return Stop(StopKind.WFE), counted
        if hint == _YIELD:
            return None, counted
        return Stop(StopKind.FAULT, fault=FaultKind.UNDEFINED, address=pc), counted - 1

    def _hint_before(self, pc: int) -> int:
        """Return the hint instruction that ends at `pc`, as its 16-bit form."""
        short = self.half(pc - 2)
        if short in (_WFE, _YIELD):
            return short
        return _WIDE_HINTS.get(self.half(pc - 4) << 16 | short, 0)

    def notices_unmasking(self) -> bool:
        """Say whether `until_unmasked` has an effect: not while code may be in RAM, for it may change unseen."""
        return self._unmasking_hooks is not None and not self._code_in_ram

    def notice_unmasking(self) -> None:
        """Have `until_unmasked` obeyed from now on. Each of the instructions then costs a call into Python."""
        self._unmasking_hooks = set()
        for base, data, writable in self._memory:
            if not writable:
                self._hook_unmasking(base, data)
            self._drop_translations(base, len(data))

    def clear_exclusive(self) -> None:
        """Forget what LDREX has marked, as exception entry and return do.

        Unicorn does not tell its monitor, so a CLREX is executed outside of the program; only if the program has any
        LDREX at all, for that takes as long as some hundred instructions.
        """
        if not self._has_exclusives:
            return
        pc = self.get(Reg.PC)
        self._lib.uc_emu_start(self._handle, _CLREX_PLACE | 1, 0, 0, 1)
        self.set(Reg.PC, pc)

    def half(self, address: int) -> int:
        """Return the half-word of memory at an even address; 0 where there is none."""
        for base, data, _ in self._memory:
            if base <= address < base + len(data):
                return int.from_bytes(data[address - base : address - base + 2], "little")
        return 0

    def _refuse(self, kind: FaultKind, address: int, refusal: str = "") -> int:
        if self._refused is None:
            stop = Stop(StopKind.FAULT, fault=kind, address=address, refusal=refusal)
            self._refused = stop, self._remember()
        self._words[1] = self._words[0]
        return 0

    def _remember(self) -> Before:
        ram = [(base, bytes(data)) for base, data, writable in self._memory if writable]
        floats, context = ([], 0) if self._floats is None else (self._floats.get(), self.get(Reg.CONTROL) & _FPCA)
        return Before(
            registers=self._registers.of_the_program(),
            floats=floats,
            context=context,
            ram=ram,
            flash_stores=len(self._flash_stores),
            instructions=self.instructions,
            cycle=self.cycle,
        )

    def _roll_back(self) -> Stop:
        """Undo the instruction whose access failed, and what was executed after it."""
        assert self._refused is not None
        (stop, before), self._refused = self._refused, None
        for base, contents in before.ram:
            memory = next(data for start, data, _ in self._memory if start == base)
            if memory != contents:
                memory[:] = contents
                self._drop_translations(base, len(memory))
        pc = before.registers[Reg.PC]
        self._registers.roll_back(before.registers, it_state_at(self.half, pc))
        if self._floats is not None:
            self._floats.set(before.floats)
            if stop.fault is FaultKind.UNDEFINED:  # an access that fails begins a context all the same
                self.set(Reg.CONTROL, self.get(Reg.CONTROL) & ~_FPCA | before.context)
        self._retired, self._now = before.instructions, before.cycle
        self._timing.go_back(before.instructions, before.cycle)
        return stop

    def _break_off(self, trouble: BaseException) -> int:
        if self._trouble is None:
            self._trouble = trouble
        self._words[1] = self._words[0]
        return 0

    # --- traps

    def set_traps(self, *, division: bool, unaligned: bool) -> None:
        """Let divisions by zero and unaligned accesses be faults; see `CpuEngine`."""
        self._traps_wanted = division, unaligned
        if self._running:
            self._words[1] = self._words[0]

    def _set_traps(self) -> None:
        division, unaligned = self._traps_set = self._traps_wanted
        flash = [(base, bytes(data)) for base, data, writable in self._memory if not writable]
        self._traps.catch_divisions(flash if division else [])
        self._traps.catch_unaligned(unaligned)
        for base, data, _ in self._memory:
            self._drop_translations(base, len(data))

    def _core_register(self, number: int) -> int:
        return self.get(Reg(number))

    def _on_division(self) -> None:
        self._refuse(FaultKind.DIVISION, 0)

    def _on_unaligned(self, address: int) -> None:
        self._refuse(FaultKind.UNALIGNED, address)

    # --- floating point

    def get_floats(self) -> list[int]:
        """Return S0 to S31 and FPSCR; see `CpuEngine`."""
        assert self._floats is not None
        return self._floats.get()

    def set_floats(self, words: Sequence[int]) -> None:
        """Set S0 to S31 and FPSCR; see `CpuEngine`."""
        assert self._floats is not None
        self._floats.set(words)

    def set_float_access(self, access: FloatAccess) -> None:
        """Let floating-point instructions of others be undefined; see `CpuEngine`."""
        self._access_wanted = access
        self.cut()

    def set_float_context(self, *, automatic: bool, fpscr: int) -> None:
        """Say what the first floating-point instruction does; see `CpuEngine`."""
        self._context_wanted = automatic, fpscr
        self.cut()

    def _settle_floats(self) -> None:
        """Do what was asked for since the last slice."""
        if self._context_wanted != self._context_set:
            assert self._hidden is not None
            automatic, fpscr = self._context_set = self._context_wanted
            self._hidden.set(Word.FPCCR, _ASPEN if automatic else 0)
            self._hidden.set(Word.FPDSCR, fpscr)
        if self._access_wanted is not self._gate.access:
            self._gate.set(self._access_wanted, self._memory)
            for base, data, _ in self._memory:
                self._drop_translations(base, len(data))

    def _on_denied_float(self) -> None:
        self._refuse(FaultKind.UNDEFINED, 0)

    def _is_privileged(self) -> bool:
        return bool(self.get(Reg.XPSR) & _IPSR) or not self.get(Reg.CONTROL) & _NPRIV

    def _fingerprint_with_floats(self) -> bytes:
        assert self._floats is not None
        return self._registers.contents() + self._floats.contents()

    # --- hooks

    def _hook(self) -> None:
        const, uc = self._const, self._uc
        from unicorn import arm_const

        self._epsr = arm_const.UC_ARM_REG_EPSR
        uc.ctl_exits_enabled(True)
        uc.ctl_set_exits([])
        uc.mem_map(_CLREX_PLACE, 0x400, const.UC_PROT_READ | const.UC_PROT_EXEC)
        uc.mem_write(_CLREX_PLACE, _CLREX)
        uc.ctl_set_tlb_mode(const.UC_TLB_VIRTUAL)
        uc.hook_add(const.UC_HOOK_TLB_FILL, self._on_tlb_fill)
        on_intr = _INTR_FN(self._on_intr)
        self._kept.append(on_intr)
        self._lib.uc_hook_add(self._handle, ctypes.byref(ctypes.c_size_t()), const.UC_HOOK_INTR, on_intr, None, 1, 0)
        uc.hook_add(const.UC_HOOK_INSN_INVALID, lambda _uc, _data: False)

    def _on_tlb_fill(self, _uc: object, address: int, access: int, result: Any, _data: object) -> bool:
        const, page = self._const, address >> _PAGE_BITS
        if access == const.UC_MEM_FETCH:
            if self._running:  # otherwise translations are dropped
                self._code_pages.add(page)
                self._note_code_in_ram(address)
        else:
            self._drop_conditions()
        rights = const.UC_PROT_READ
        # Flash is answered as writable so that the store reaches the hook for read-only memory.
        if access == const.UC_MEM_WRITE or not self._read_only(address):
            rights |= const.UC_PROT_WRITE
        if access == const.UC_MEM_FETCH or page in self._code_pages:
            rights |= const.UC_PROT_EXEC
        result.paddr = page << _PAGE_BITS
        result.perms = rights
        return True

    def _drop_conditions(self) -> None:
        """Before these hooks Unicorn sets the IT state of the instruction in flight; what follows would be under it."""
        self._lib.uc_reg_write(self._handle, self._epsr, self._no_conditions)

    def _read_only(self, address: int) -> bool:
        return any(base <= address < base + len(data) and not writable for base, data, writable in self._memory)

    def _on_intr(self, _uc: object, number: int, _data: object) -> None:
        self._intr = number
        self._lib.uc_emu_stop(self._handle)

    def _on_unmapped(self, _uc: object, access: int, address: int, size: int, _value: int, _data: object) -> bool:
        self._bad_address = address
        if self._traps_set[1] and address & size - 1:
            self._on_unaligned(address)
        elif access == self._const.UC_MEM_WRITE_UNMAPPED:
            self._refuse(FaultKind.WRITE, address)
        return False

    def _on_flash_write(self, _uc: object, _access: int, address: int, size: int, value: int, _data: object) -> bool:
        for base, data, _ in self._memory:
            if base <= address < base + len(data):
                contents = bytes(data[address - base : address - base + size])
                value &= (1 << 8 * size) - 1
                self._flash_stores.append((address, size, value, contents, self._remember()))
        self._drop_conditions()
        self._words[1] = self._words[0]
        return True

    def _hand_on_flash_stores(self) -> None:
        self._limit_cycle = 0
        stores, self._flash_stores = self._flash_stores, []
        for address, size, _value, contents, _before in reversed(stores):
            for base, data, _ in self._memory:
                if base <= address < base + len(data):
                    data[address - base : address - base + size] = contents
            self._drop_translations(address, size)
        happened = len(stores) if self._refused is None else self._refused[1].flash_stores
        for address, size, value, _contents, before in stores[:happened]:
            try:
                self.on_flash_store(address, size, value)
            except BusFault as fault:
                stop = Stop(StopKind.FAULT, fault=FaultKind.WRITE, address=fault.address, refusal=fault.refusal)
                self._refused = stop, before
                return

    def _note_code(self, base: int, data: bytes | bytearray) -> None:
        """Have SEV and ISB noticed wherever their encodings stand; where it is data, the hook is never called."""
        data = bytes(data[: _erased_from(data) + 4])  # there may be megabytes of erased flash behind it
        if self._traps.catches_divisions:
            self._traps.note_divisions(base, data)
        self._gate.note(base, data)
        self._has_exclusives = self._has_exclusives or _LDREX.search(data) is not None
        for offset in _find_hints(data):
            address = base + offset
            if address not in self._hint_hooks:
                self._hint_hooks[address] = self._uc.hook_add(
                    self._const.UC_HOOK_CODE, self._on_sev, begin=address, end=address
                )
        for offset in _find(_ISB, data):
            address = base + offset
            if address not in self._isb_hooks and it_state_at(self.half, address):
                self._isb_hooks.add(address)
                self._uc.hook_add(self._const.UC_HOOK_CODE, self._on_isb, begin=address, end=address)

    def _on_isb(self, _uc: object, address: int, _size: int, _data: object) -> None:
        if self.half(address) != 0xF3BF or self.half(address + 2) != 0x8F6F:
            return
        conditions = advanced(_T_BIT | it_state_at(self.half, address))
        self._lib.uc_reg_write(self._handle, self._epsr, ctypes.byref(ctypes.c_uint32(conditions)))

    def _note_code_in_ram(self, address: int) -> None:
        if not self._code_in_ram and any(w and b <= address < b + len(data) for b, data, w in self._memory):
            self._code_in_ram = True
            self._on_unmasking()

    def _hook_unmasking(self, base: int, data: bytes | bytearray) -> None:
        hooks = self._unmasking_hooks
        if hooks is None:
            return
        for offset in unmasking_places(data[: _erased_from(data) + LONGEST]):
            if base + offset not in hooks:
                hooks.add(base + offset)
                self._uc.hook_add(self._const.UC_HOOK_CODE, self._on_unmasking, begin=base + offset, end=base + offset)

    def _on_unmasking(self, *_args: object) -> None:
        if self.until_unmasked:
            self._limit_cycle = 0
            self._words[1] = self._words[0]

    def _on_sev(self, _uc: object, address: int, _size: int, _data: object) -> None:
        if self.half(address) in (_SEV, 0xF3AF):
            self._event_sent = True
            self._words[1] = self._words[0]


def _erased_from(data: bytes | bytearray) -> int:
    """Return where, to a block, the erased end of flash begins."""
    at = len(data)
    while data[max(0, at - len(_ERASED)) : at] == _ERASED:
        at -= len(_ERASED)
    return at


def _find_hints(data: bytes | bytearray) -> Iterator[int]:
    for pattern in (_SEV.to_bytes(2, "little"), b"\xaf\xf3\x04\x80"):
        yield from _find(pattern, data)


def _find(pattern: bytes, data: bytes | bytearray) -> Iterator[int]:
    at = data.find(pattern)
    while at >= 0:
        if at % 2 == 0:
            yield at
        at = data.find(pattern, at + 1)
