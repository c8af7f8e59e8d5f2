"""Words of the state of a Unicorn core that its interface does not let one set, found by trial.

Unicorn copies the state of a core into a context and back, which it calls opaque. That is used here to change a word of
it: what decides over floating-point contexts (FPCCR, FPDSCR, which are registers of the system control space and so
ours), and the GE flags, which a write to xPSR leaves as they are. The places are no promise of Unicorn's, so they are
searched for when the first such core is made, as the instruction counter is (`calibration`).
"""

from __future__ import annotations

import ctypes
import enum
import functools
from typing import Any

from targets.mcu.engine.calibration import install_hint, open_unicorn
from targets.mcu.errors import EngineError

__all__ = ["HiddenState", "Word"]

_FPCCR_RESET = 1 << 31, 1 << 31 | 1 << 30 | 1 << 2  # of the core, and of a secure state that it does not have
_BASEPRI_TO_FPCCR = 34  # words
_FPDSCR = 2  # words behind FPCCR
_TRIALS = (0xA0, 0x50)
_THUMB = 1 << 5  # in CPSR, by which alone the interface sets GE


class Word(enum.Enum):
    """What can be read and changed.

    FPCCR: its bit 31, ASPEN: the first floating-point instruction begins a context.
    FPDSCR: FPSCR in a context that begins.
    GE: the flags that SEL goes by, xPSR bits 19 to 16.
    """

    FPCCR = "fpccr"
    FPDSCR = "fpdscr"
    GE = "ge"


class HiddenState:
    """The words of one core.

    Args:
        core: a Unicorn instance with floating point.
        lib: Unicorn's library.

    Raises:
        EngineError: a word is not where it is kept.
    """

    def __init__(self, core: Any, lib: Any) -> None:
        self._places = _places()
        self._lib, self._handle = lib, core._uch  # noqa: SLF001 - the binding's own call costs as much as the C call
        self._context, self._words = _copy(core)

    def get(self, word: Word) -> int:
        """Return a word; not while the core executes."""
        self._lib.uc_context_save(self._handle, self._context._context)  # noqa: SLF001
        return self._words[self._places[word]]

    def set(self, word: Word, value: int) -> None:
        """Change a word; not while the core executes."""
        self._lib.uc_context_save(self._handle, self._context._context)  # noqa: SLF001
        self._words[self._places[word]] = value
        self._lib.uc_context_restore(self._handle, self._context._context)  # noqa: SLF001


def _copy(core: Any) -> tuple[Any, ctypes.Array[ctypes.c_uint32]]:
    """Return a context with the present state of `core`, and its words; they live as long as the context does."""
    context = core.context_save()
    words = ctypes.c_uint32 * (context.size // 4)
    return context, words.from_address(context._context.value)  # noqa: SLF001


@functools.cache
def _places() -> dict[Word, int]:
    """Return where the words are, as indices."""
    from unicorn import arm_const

    core = open_unicorn("M7")
    basepri = _place(core, arm_const.UC_ARM_REG_BASEPRI, {value: value for value in _TRIALS})
    fpccr = basepri + _BASEPRI_TO_FPCCR
    _context, words = _copy(core)
    if tuple(words[fpccr : fpccr + 2]) != _FPCCR_RESET or words[fpccr + _FPDSCR]:
        raise _not_found()
    ge = _place(core, arm_const.UC_ARM_REG_CPSR, {_THUMB | value >> 4 << 16: value >> 4 for value in _TRIALS})
    return {Word.FPCCR: fpccr, Word.FPDSCR: fpccr + _FPDSCR, Word.GE: ge}


def _place(core: Any, register: int, trials: dict[int, int]) -> int:
    """Return the only word that becomes each of the values when the register is set to its key."""
    places: set[int] | None = None
    for written, kept in trials.items():
        core.reg_write(register, written)
        _context, words = _copy(core)
        found = {at for at, word in enumerate(words) if word == kept}
        places = found if places is None else places & found
    if places is None or len(places) != 1:
        raise _not_found()
    return places.pop()


def _not_found() -> EngineError:
    return EngineError("Unicorn's floating-point state is not where it is kept", hint=install_hint())
