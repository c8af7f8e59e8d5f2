"""Where Unicorn keeps its instruction counter, found by trial, and whether this is the Unicorn that was tried.

Unicorn counts instructions when `emu_start` is given a count, in two consecutive 64-bit words of its otherwise opaque
engine object: `emu_counter`, the instruction in flight (from 1), and `emu_count`, where the run ends. Reading the first
within a register access gives the exact time of the access; lowering the second ends the slice after the instruction in
flight, which `emu_stop` does not do (within an access it takes the instruction back and executes it twice).

Their place is no promise of Unicorn's, so the version is pinned and the place is searched for, with runs of known
lengths, when the first engine is made.
"""

from __future__ import annotations

import ctypes
import functools
import struct
from typing import Any

from targets.mcu.errors import EngineError

__all__ = ["UNICORN_VERSION", "counter_words", "install_hint", "open_unicorn"]

UNICORN_VERSION = (2, 1, 4)

_WORDS_SEARCHED = 512
_TRIAL_COUNTS = (1009, 2027, 313)
_ADDRESS = 0x0800_0000
_LOOP = struct.pack("<3H", 0x3001, 0x3101, 0xE7FC)  # adds r0, #1; adds r1, #1; b .-4


def open_unicorn(model: str = "M3") -> Any:
    """Return a bare core with no memory.

    `UC_MODE_MCLASS` is not passed: it would make a Cortex-M33 of it, whatever model is asked for.

    Args:
        model: ``M3`` or ``M7``, as `CoreKind.model`.

    Raises:
        EngineError: Unicorn is missing or of another version.
    """
    try:
        import unicorn
        from unicorn import arm_const
    except ImportError as missing:
        raise EngineError("Unicorn is not installed", hint=install_hint()) from missing
    combined = unicorn.uc_version()[2]  # of the library itself: major, minor, patch, extra, a byte each
    found = combined >> 24, combined >> 16 & 0xFF, combined >> 8 & 0xFF
    if found != UNICORN_VERSION:
        version = ".".join(map(str, found))
        raise EngineError(f"Unicorn {version} is not the one this was written for", hint=install_hint())
    core = unicorn.Uc(unicorn.UC_ARCH_ARM, unicorn.UC_MODE_THUMB)
    core.ctl_set_cpu_model(getattr(arm_const, f"UC_CPU_ARM_CORTEX_{model}"))
    return core


def counter_words(core: Any) -> ctypes.Array[ctypes.c_uint64]:
    """Return (emu_counter, emu_count) of `core`, as memory that can be read and written."""
    # Made by the core's own address: the array is a window and dies with it.
    words = ctypes.c_uint64 * 2
    return words.from_address(core._uch.value + 8 * _counter_index())  # noqa: SLF001


@functools.cache
def _counter_index() -> int:
    """Return the index of `emu_counter` among the 64-bit words of an engine object."""
    core = open_unicorn()
    core.mem_map(_ADDRESS, 0x400)
    core.mem_write(_ADDRESS, _LOOP)
    window = (ctypes.c_uint64 * _WORDS_SEARCHED).from_address(core._uch.value)  # noqa: SLF001
    places = set(range(_WORDS_SEARCHED - 1))
    for count in _TRIAL_COUNTS:
        core.emu_start(_ADDRESS | 1, 0, count=count)
        words = list(window)
        places = {at for at in places if words[at] == count + 1 and words[at + 1] == count}
    if len(places) != 1:
        raise EngineError("Unicorn's instruction counter is not where it is kept", hint=install_hint())
    return places.pop()


def install_hint() -> str:
    """Return how to get the Unicorn that this was written for."""
    return f"pip install unicorn=={'.'.join(map(str, UNICORN_VERSION))}"
