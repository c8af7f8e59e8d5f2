"""Atoms about the core itself: special registers, masks, barriers, hints."""

from __future__ import annotations

from tests.targets.mcu.differential.sequence import Sequence

_APSR, _IAPSR, _EAPSR, _XPSR, _IPSR, _EPSR, _IEPSR, _MSP, _PSP = 0, 1, 2, 3, 5, 6, 7, 8, 9
_PRIMASK, _BASEPRI, _BASEPRI_MAX, _FAULTMASK, _CONTROL = 16, 17, 18, 19, 20


def read_special(s: Sequence) -> bool:
    states = s.one_of(_APSR, _IAPSR, _EAPSR, _XPSR)
    other = s.one_of(_IPSR, _EPSR, _IEPSR, _MSP, _PSP, _PRIMASK, _BASEPRI, _BASEPRI_MAX, _FAULTMASK, _CONTROL)
    return s.emit(0xF3EF, 0x8000 | s.target() << 8 | s.one_of(states, other))


def write_flags(s: Sequence) -> bool:
    return s.emit(0xF380 | s.source(), 0x8800 | s.one_of(_APSR, _IAPSR, _EAPSR, _XPSR))


def write_mask(s: Sequence) -> bool:
    return s.emit(0xF380 | s.source(), 0x8800 | s.one_of(_PRIMASK, _FAULTMASK))


def write_base_priority(s: Sequence) -> bool:
    """BIC, then MSR BASEPRI or BASEPRI_MAX: QEMU's core has eight bits of priority, ours four."""
    if s.in_it:
        return False
    source, implemented = s.source(), s.target()
    register = s.one_of(_BASEPRI, _BASEPRI_MAX)
    return s.emit(0xF020 | source, implemented << 8 | 0xF, 0xF380 | implemented, 0x8800 | register)


def write_process_stack(s: Sequence) -> bool:
    return s.emit(0xF380 | s.source(), 0x8800 | _PSP)


def change_masks(s: Sequence) -> bool:
    """CPSIE and CPSID, which may not stand in an IT block."""
    return not s.in_it and s.emit(0xB660 | s.bits(1) << 4 | s.between(1, 3))


def barrier(s: Sequence) -> bool:
    """DSB, DMB, ISB."""
    return s.emit(0xF3BF, s.one_of(0x8F4F, 0x8F5F, 0x8F6F))


def clear_exclusive(s: Sequence) -> bool:
    return s.emit(0xF3BF, 0x8F2F)


def no_operation(s: Sequence) -> bool:
    return s.emit(*s.one_of((0xBF00,), (0xF3AF, 0x8000)))


ATOMS = (
    (3, read_special),
    (2, write_flags),
    (1, write_mask),
    (1, write_base_priority),
    (1, write_process_stack),
    (1, change_masks),
    (1, barrier),
    (1, clear_exclusive),
    (1, no_operation),
)
