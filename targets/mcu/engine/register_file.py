"""The core registers between two slices: fetched from Unicorn together when one is asked for, put back before the next.

A call into Unicorn costs more than what it does, and an exception needs a dozen registers; so all of them go at a time.

Special registers of a core in unprivileged Thread mode read as zero and ignore writes for us as for the program, so
privilege is taken for as long as that lasts, by way of Handler mode. SPSEL can be written in Thread mode alone, and the
flags that Unicorn derives from the mode, by which it knows an exception return, are made anew by a write to APSR alone:
hence the order in `_ALL`. A write to xPSR leaves the GE flags of a core with DSP instructions as they are; they are
set apart (`hidden_state`).
"""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from typing import Any

from targets.mcu.engine.api import Reg
from targets.mcu.engine.hidden_state import HiddenState, Word

__all__ = ["RegisterFile"]

_NPRIV, _SPSEL = 1 << 0, 1 << 1
_IPSR, _HARD_FAULT = 0x1FF, 3
_FLAGS, _THUMB = 0xF80F_0000, 1 << 24
_GE = 0x000F_0000
_SP, _PC, _XPSR, _MSP, _PSP, _CONTROL = Reg.SP, Reg.PC, Reg.XPSR, Reg.MSP, Reg.PSP, Reg.CONTROL

# Values of a register on the way to its last one, behind the registers themselves.
_XPSR_HANDLER, _CONTROL_PRIVILEGED, _XPSR_THREAD, _APSR = range(len(Reg), len(Reg) + 4)

_FETCHED = [register for register in Reg if register is not _SP]  # SP is one of MSP and PSP
_GENERAL = [*range(Reg.R12 + 1), Reg.LR]
_GENERAL_AND_MODE = [*_GENERAL, _MSP, _PSP, _XPSR, _APSR]
_TAKE_PRIVILEGE = [_XPSR_HANDLER, _CONTROL_PRIVILEGED, _XPSR_THREAD]
_OF_THE_PROGRAM = [*range(Reg.PC + 1), _XPSR]
_ALL = [
    *_GENERAL,
    *_TAKE_PRIVILEGE,
    *(_MSP, _PSP, Reg.PRIMASK, Reg.BASEPRI, Reg.FAULTMASK, _CONTROL),
    *(_XPSR, _APSR),
]


class RegisterFile:
    """Core registers of a Unicorn instance.

    Args:
        lib: Unicorn's library.
        handle: the instance in it.
        arm_const: Unicorn's names of registers.
        hidden: what cannot be set otherwise, of a core with DSP instructions.

    Attributes:
        running: the core executes; set from outside, after `release`.
    """

    def __init__(self, lib: Any, handle: Any, arm_const: Any, hidden: HiddenState | None = None) -> None:
        self.running = False
        self._hidden = hidden
        self._ge = 0
        self._lib = lib
        self._handle = handle
        self._values = (ctypes.c_uint32 * (_APSR + 1))()
        self._ids = _register_ids(arm_const)
        self._fetched = self._batch(_FETCHED)
        self._general = self._batch(_GENERAL)
        self._general_and_mode = self._batch(_GENERAL_AND_MODE)
        self._take_privilege = self._batch(_TAKE_PRIVILEGE)
        self._all = self._batch(_ALL)
        self._program_values = (ctypes.c_uint32 * len(_OF_THE_PROGRAM))()
        self._program = self._batch(_OF_THE_PROGRAM, self._program_values)
        self._one = ctypes.c_uint32()
        self._one_ref = ctypes.byref(self._one)
        self._pc_id = self._ids[_PC]
        self._stale = True  # the core has executed since the registers were fetched
        self._changed: tuple[Any, Any, int] | None = None  # what has to be put back

    def get(self, register: int) -> int:
        """Return a register. While the core executes without privilege, special registers read as zero."""
        if self._stale:
            if self.running:
                self._lib.uc_reg_read(self._handle, self._ids[register], self._one_ref)
                return self._one.value
            self._fetch()
        if register == _SP:
            register = self._stack_in_use()
        return self._values[register]

    def set(self, register: int, value: int) -> None:
        """Change a register."""
        if self._stale:
            self._fetch()
        if register == _SP:
            register = self._stack_in_use()
        elif register == _PC:
            value &= ~1
        self._values[register] = value
        if register < _PC:  # PC is handed over when the core begins to execute
            if self._changed is None:
                self._changed = self._general
        elif register > _PSP:
            self._changed = self._all
        elif register > _PC and self._changed is not self._all:
            self._changed = self._general_and_mode

    def get_many(self, registers: Sequence[int]) -> list[int]:
        """Return registers, without SP."""
        if self._stale:
            self._fetch()
        values = self._values
        return [values[register] for register in registers]

    def set_many(self, registers: Sequence[int], new: Sequence[int]) -> None:
        """Change some of R0 to R12, LR and PC."""
        if self._stale:
            self._fetch()
        values = self._values
        for register, value in zip(registers, new, strict=True):
            values[register] = value
        if self._changed is None:
            self._changed = self._general

    def pc(self) -> int:
        """Return where to go on."""
        if self._stale:
            self._lib.uc_reg_read(self._handle, self._pc_id, self._one_ref)
            return self._one.value
        return self._values[_PC]

    def contents(self) -> bytes:
        """Return all registers, as bytes to compare."""
        if self._stale:
            self._fetch()
        self._values[_SP] = self._values[self._stack_in_use()]
        return bytes(self._values)[: 4 * len(Reg)]

    def of_the_program(self) -> list[int]:
        """Return R0 to R15 and xPSR as they are before the instruction in flight, while the core executes."""
        ids, pointers, count = self._program
        self._lib.uc_reg_read_batch(self._handle, ids, pointers, count)
        return list(self._program_values)

    def roll_back(self, values: Sequence[int], it_state: int) -> None:
        """Set what `of_the_program` gave, with other bits for ITSTATE; not while the core executes."""
        *general, xpsr = values
        for number, value in enumerate(general):
            self.set(number, value)
        self.set(_XPSR, self.get(_XPSR) & _IPSR | xpsr & _FLAGS | _THUMB | it_state)

    def release(self) -> None:
        """Put back what has changed: the core is about to execute, from `pc` on."""
        batch, self._changed, self._stale = self._changed, None, True
        if batch is None:
            return
        values = self._values
        if self._hidden is not None and values[_XPSR] & _GE != self._ge:
            self._hidden.set(Word.GE, (values[_XPSR] & _GE) >> 16)
        if batch is not self._general:
            values[_APSR] = values[_XPSR] & 0xF800_0000
            if values[_CONTROL] & _NPRIV:
                batch = self._all
            if batch is self._all:
                self._plan_ways()
        self._write(batch)

    def _fetch(self) -> None:
        ids, pointers, count = self._fetched
        self._lib.uc_reg_read_batch(self._handle, ids, pointers, count)
        self._stale = False
        values = self._values
        self._ge = values[_XPSR] & _GE
        control = values[_CONTROL]
        if control & _NPRIV and not values[_XPSR] & _IPSR:
            self._plan_ways()
            self._write(self._take_privilege)
            self._lib.uc_reg_read_batch(self._handle, ids, pointers, count)
            values[_CONTROL] = control
            self._changed = self._all

    def _plan_ways(self) -> None:
        values = self._values
        values[_XPSR_THREAD] = values[_XPSR] & ~_IPSR
        values[_XPSR_HANDLER] = values[_XPSR_THREAD] | _HARD_FAULT
        values[_CONTROL_PRIVILEGED] = values[_CONTROL] & ~_NPRIV

    def _stack_in_use(self) -> int:
        values = self._values
        return _PSP if values[_CONTROL] & _SPSEL and not values[_XPSR] & _IPSR else _MSP

    def _batch(self, slots: Sequence[int], values: Any = None) -> tuple[Any, Any, int]:
        """Return what Unicorn wants to be told: each register goes to its slot, or to `values` one by one."""
        places = slots if values is None else range(len(slots))
        first = ctypes.addressof(self._values if values is None else values)
        ids = (ctypes.c_int * len(slots))(*(self._ids[slot] for slot in slots))
        pointers = (ctypes.c_void_p * len(slots))(*(first + 4 * place for place in places))
        return ids, pointers, len(slots)

    def _write(self, batch: tuple[Any, Any, int]) -> None:
        ids, pointers, count = batch
        self._lib.uc_reg_write_batch(self._handle, ids, pointers, count)


def _register_ids(arm_const: Any) -> list[int]:
    names = {Reg.SP: "SP", Reg.LR: "LR", Reg.PC: "PC"}
    ids = [getattr(arm_const, f"UC_ARM_REG_{names.get(register, register.name)}") for register in Reg]
    xpsr, control = ids[_XPSR], ids[_CONTROL]
    return [*ids, xpsr, control, xpsr, arm_const.UC_ARM_REG_APSR_NZCV]
