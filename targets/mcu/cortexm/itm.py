"""The instrumentation trace macrocell (DDI0403 section C1.7): its stimulus ports are a console.

A port takes data while DEMCR.TRCENA, TCR.ITMENA and its bit of TER are set; it is then always ready (the speed of the
trace pin is not modelled). Otherwise it reads 0, so that a program which waits for it waits for ever, as it does on
silicon without a debugger. `trace_as_debugger` does what a debugger does to receive the output.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence

from targets.mcu.cortexm.ppb import DebugBlock, component_id
from targets.mcu.fidelity import Fidelity
from targets.mcu.registers import Register
from targets.mcu.services import Services

__all__ = ["Itm"]

_PORTS_END, _TER, _TPR, _TCR, _LAR, _LSR = 0x080, 0xE00, 0xE40, 0xE80, 0xFB0, 0xFB4
_ITMENA = 1 << 0
_KEY = 0xC5AC_CE55
_LOCK_PRESENT, _LOCKED = 1 << 0, 1 << 1
_WORD = 0xFFFF_FFFF


def _registers() -> Iterator[Register]:
    for port in range(32):
        yield Register(f"STIM{port}", 4 * port)
    yield Register("TER", _TER)
    yield Register("TPR", _TPR, 0, 0xF)
    yield Register(
        "TCR",
        _TCR,
        0,
        0x007F_031F,
        0x0000_031A,
        fidelity=Fidelity.PARTLY,
        note="only ITMENA acts: there are no time stamps and no packets of DWT",
    )
    yield Register("LAR", _LAR)
    yield Register("LSR", _LSR, _LOCK_PRESENT | _LOCKED, 0)


class Itm(DebugBlock):
    """Stimulus ports.

    Args:
        part: its identification, PID0 to PID3.
        trace_enabled: returns DEMCR.TRCENA.

    Attributes:
        on_stimulus: called with port, size in bytes and value of everything that a port takes.
    """

    def __init__(
        self,
        services: Services,
        privileged: Callable[[], bool],
        part: Sequence[int],
        trace_enabled: Callable[[], bool],
    ) -> None:
        self._part = part
        super().__init__("ITM", 0xE000_0000, services, privileged)
        self._trace_enabled = trace_enabled
        self.on_stimulus: Callable[[int, int, int], None] = lambda _port, _size, _value: None

    def registers_of(self) -> Iterable[Register]:
        """Return the registers, with the core's own identification."""
        return (*_registers(), *component_id(self._part, 0xE))

    def trace_as_debugger(self) -> None:
        """Open all ports. DEMCR.TRCENA is the core's to set."""
        self[_TER], self[_TCR] = _WORD, _ITMENA

    def read_word(self, offset: int) -> int:
        """Read as somebody who may."""
        if offset < _PORTS_END:
            return int(self._takes(offset >> 2))
        return super().read_word(offset) if self._trace_enabled() else 0

    def write_word(self, offset: int, value: int) -> None:
        """Write as somebody who may."""
        if offset < _PORTS_END:
            self._stimulate(offset >> 2, 4, value)
        elif not self._trace_enabled():
            self.note("misuse", "TRCENA", "a write while DEMCR.TRCENA is clear is lost")
        elif offset == _LAR:
            self[_LSR] = _LOCK_PRESENT if value == _KEY else _LOCK_PRESENT | _LOCKED
        elif self[_LSR] & _LOCKED:
            self.note("misuse", "LAR", "a write without the key 0xC5ACCE55 in LAR before it is lost")
        else:
            super().write_word(offset, value)

    def write_part(self, offset: int, size: int, value: int) -> None:
        """Write 1 or 2 bytes: a stimulus of that size. Raises `BusFault`."""
        if offset < _PORTS_END:
            self.check(offset & ~3)
            self._stimulate(offset >> 2, size, value & ((1 << 8 * size) - 1))
        else:
            super().write_part(offset, size, value)

    def open_to_all(self, offset: int) -> bool:
        """Say whether unprivileged software may touch the word at `offset`: ports, eight for each bit of TPR."""
        return offset < _PORTS_END and not self[_TPR] >> (offset >> 5) & 1

    def _stimulate(self, port: int, size: int, value: int) -> None:
        if self._takes(port):
            self.on_stimulus(port, size, value)

    def _takes(self, port: int) -> bool:
        return self._trace_enabled() and bool(self[_TCR] & _ITMENA) and bool(self[_TER] >> port & 1)
