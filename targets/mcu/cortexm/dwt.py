"""The data watchpoint and trace unit (DDI0403 section C1.8): the cycle counter; what watches and samples is absent.

While DEMCR.TRCENA is clear the unit has no clock: writes are lost, and every read gives 0x40000000, the value of
CTRL (reported for CYCCNT of an STM32F103C8 and an STM32F303 by the authors of stm32f1xx-hal and RTIC; that other
registers do the same is assumed). CYCCNT is a free-running count of HCLK; that it goes on during sleep is a choice
(the architecture counts sleeping cycles in, a chip may stop the clock; QEMU 7.2 has no such unit and cannot tell).

In a Cortex-M7 software has to write a key to LAR before it can write anything else: without it CYCCNT stays at 0 unless
a debugger has been there (DDI0489 section 12.3.2; DDI0403 section D1 of the CoreSight lock). Not so in an STM32H7: see
`kinds`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence

from targets.mcu.cortexm.ppb import DebugBlock, component_id
from targets.mcu.fidelity import Fidelity
from targets.mcu.registers import Count, Register
from targets.mcu.services import Services

__all__ = ["Dwt"]

_CTRL, _CYCCNT, _LAR, _LSR = 0x000, 0x004, 0xFB0, 0xFB4
_CYCCNTENA = 1 << 0
_FOUR_COMPARATORS = 0x4000_0000
_WORD = 0xFFFF_FFFF
_NEVER = 1 << 62
_KEY = 0xC5AC_CE55
_LOCK_PRESENT, _LOCKED = 1 << 0, 1 << 1


def _registers() -> Iterator[Register]:
    events = "events are not counted, sampled or traced"
    yield Register("CTRL", _CTRL, _FOUR_COMPARATORS, 0x007F_1FFF, 0x007F_1FFE, fidelity=Fidelity.PARTLY, note=events)
    yield Register("CYCCNT", _CYCCNT, 0, live=True)
    for index, name in enumerate(("CPICNT", "EXCCNT", "SLEEPCNT", "LSUCNT", "FOLDCNT")):
        yield Register(name, 0x008 + 4 * index, 0, 0xFF, fidelity=Fidelity.ABSENT, note=events)
    yield Register("PCSR", 0x01C, 0, 0, fidelity=Fidelity.ABSENT, note=events)
    for index in range(4):
        for place, (name, bits) in enumerate((("COMP", _WORD), ("MASK", 0xF), ("FUNCTION", 0xFEF))):
            yield Register(
                f"{name}{index}",
                0x020 + 16 * index + 4 * place,
                0,
                bits,
                fidelity=Fidelity.ABSENT,
                note="comparators never match",
            )


class Dwt(DebugBlock):
    """The cycle counter.

    Args:
        part: its identification, PID0 to PID3.
        lock: LSR after power-on, `kinds.LOCKED` or 0 for registers that lock nothing; None: there are none.
        trace_enabled: returns DEMCR.TRCENA.
    """

    def __init__(
        self,
        services: Services,
        privileged: Callable[[], bool],
        part: Sequence[int],
        trace_enabled: Callable[[], bool],
        *,
        lock: int | None = None,
    ) -> None:
        self._part = part
        self._lock = lock
        super().__init__("DWT", 0xE000_1000, services, privileged)
        self._trace_enabled = trace_enabled
        self._start: int | None = None  # the cycle at which the counter was 0, while it counts
        self._held = False

    def registers_of(self) -> Iterable[Register]:
        """Return the registers, with the core's own identification, and the lock if there is one."""
        lock = () if self._lock is None else (Register("LAR", _LAR), Register("LSR", _LSR, self._lock, 0))
        return (*_registers(), *lock, *component_id(self._part, 0xE))

    def power_on(self) -> None:
        """Go to the state after power-on."""
        super().power_on()
        self._start = None
        self._held = False

    def read(self, offset: int) -> int:
        """Read the word at `offset`; the counter without detours, for delay loops read nothing else."""
        if offset == _CYCCNT and self._start is not None and self._privileged():
            return self.time.now - self._start & _WORD
        return super().read(offset)

    def read_word(self, offset: int) -> int:
        """Read as somebody who may."""
        return super().read_word(offset) if self._trace_enabled() else _FOUR_COMPARATORS

    def write_word(self, offset: int, value: int) -> None:
        """Write as somebody who may."""
        if not self._trace_enabled():
            self.note("misuse", "TRCENA", "a write while DEMCR.TRCENA is clear is lost")
        elif self._lock and offset != _LAR and self[_LSR] & _LOCKED:
            self.note("misuse", "LAR", "a write without the key 0xC5ACCE55 in LAR before it is lost")
        else:
            super().write_word(offset, value)

    def is_live(self, offset: int) -> bool:
        """CYCCNT changes while it counts."""
        return offset == _CYCCNT and self._start is not None

    def count(self, offset: int) -> Count | None:
        """Return how CYCCNT counts."""
        if offset != _CYCCNT or self._start is None:
            return None
        return Count(0, self._start, 1, until=_NEVER)

    def write_LAR(self, value: int) -> None:
        """Take the key, or lock again."""
        if self._lock:
            self[_LSR] = _LOCK_PRESENT if value == _KEY else _LOCK_PRESENT | _LOCKED

    def read_LAR(self) -> int:
        """Return 0: it can only be written."""
        return 0

    def read_CYCCNT(self) -> int:
        """Return the counter."""
        return self[_CYCCNT] if self._start is None else self.time.now - self._start & _WORD

    def write_CYCCNT(self, value: int) -> None:
        """Set the counter."""
        self[_CYCCNT] = value
        if self._start is not None:
            self._start = self.time.now - value

    def write_CTRL(self, value: int) -> None:
        """Let the counter count or stop."""
        self[_CTRL] = value
        self.gate(self._trace_enabled())

    def hold(self, held: bool) -> None:
        """Let the clock stand still, as in Stop mode, or run again; the counter keeps its value."""
        self._held = held
        self.gate(self._trace_enabled())

    def gate(self, enabled: bool) -> None:
        """Take the new DEMCR.TRCENA: without it the counter stands still."""
        counting = enabled and bool(self[_CTRL] & _CYCCNTENA) and not self._held
        if counting and self._start is None:
            self._start = self.time.now - self[_CYCCNT]
        elif not counting and self._start is not None:
            self[_CYCCNT] = self.time.now - self._start & _WORD
            self._start = None
