"""Semihosting: what firmware asks of a debugger with BKPT 0xAB (Arm, Semihosting for AArch32 and AArch64, 2.0).

The operation is in R0, its parameter or the address of its parameter block in R1; the result goes to R0. There is a
console to write to and an end of the program. The only file is the one that tells which extensions there are (section
"Feature reporting"): newlib hands on the status of `exit` only if it finds there that it may.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction

from targets.mcu.cortexm.stepping import step_over
from targets.mcu.engine.api import CpuEngine, Reg
from targets.mcu.errors import BusFault
from targets.mcu.fidelity import Notes
from targets.mcu.services import BusMaster
from targets.mcu.timebase import NS_PER_S, Timebase

__all__ = ["SEMIHOSTING_BREAKPOINT", "Exit", "Semihosting"]

SEMIHOSTING_BREAKPOINT = 0xAB

_FAILED = 0xFFFF_FFFF
_ENOENT, _EBADF, _ENOSYS = 2, 9, 38
_APPLICATION_EXIT = 0x20026
_FEATURES_NAME = b":semihosting-features"
_EXIT_EXTENDED, _STDOUT_STDERR = 1, 2
_FEATURES = b"SHFB" + bytes([_EXIT_EXTENDED | _STDOUT_STDERR])


@dataclass(frozen=True, slots=True)
class Exit:
    """The end of a program.

    Attributes:
        status: 0 for success.
        reason: why it stopped, by the numbers of the standard: 0x20026 is an ordinary end.
    """

    status: int
    reason: int


class Semihosting:
    """The debugger's side.

    Args:
        cpu: whose registers carry the calls.
        bus: where the parameter blocks are.
        time: what the clocks count: bench time (choice; a time of day would make runs differ).
        notes: where calls that are not answered are noted.
        command_line: what SYS_GET_CMDLINE gives.

    Attributes:
        on_output: called with what firmware writes to the console.
        on_exit: called when the program ends.
    """

    def __init__(self, cpu: CpuEngine, bus: BusMaster, time: Timebase, notes: Notes, command_line: str = "") -> None:
        self._cpu = cpu
        self._bus = bus
        self._time = time
        self._notes = notes
        self._command_line = command_line.encode(errors="surrogateescape")
        self._errno = 0
        self._consoles: set[int] = set()
        self._positions: dict[int, int] = {}  # in the file of features, by handle
        self._next_handle = 1
        self.on_output: Callable[[bytes], None] = lambda _text: None
        self.on_exit: Callable[[Exit], None] = lambda _exit: None
        self._calls: dict[int, tuple[str, Callable[[int], int]]] = {
            0x01: ("SYS_OPEN", self._open),
            0x02: ("SYS_CLOSE", self._close),
            0x03: ("SYS_WRITEC", self._write_character),
            0x04: ("SYS_WRITE0", self._write_text),
            0x05: ("SYS_WRITE", self._write),
            0x06: ("SYS_READ", self._read),
            0x07: ("SYS_READC", lambda _parameter: _FAILED),
            0x08: ("SYS_ISERROR", lambda block: self._word(block, 0) >> 31),
            0x09: ("SYS_ISTTY", self._is_console),
            0x0A: ("SYS_SEEK", self._seek),
            0x0C: ("SYS_FLEN", self._length),
            0x10: ("SYS_CLOCK", lambda _parameter: self._elapsed(100)),
            0x11: ("SYS_TIME", lambda _parameter: self._elapsed(1)),
            0x13: ("SYS_ERRNO", lambda _parameter: self._errno),
            0x15: ("SYS_GET_CMDLINE", self._get_command_line),
            0x16: ("SYS_HEAPINFO", self._heap_info),
            0x18: ("SYS_EXIT", self._exit),
            0x20: ("SYS_EXIT_EXTENDED", self._exit_extended),
        }

    def call(self) -> None:
        """Answer the BKPT 0xAB at PC, and go on after it (one cycle, a choice: time must not stand still)."""
        cpu = self._cpu
        operation, parameter = cpu.get(Reg.R0), cpu.get(Reg.R1)
        name, answer = self._calls.get(operation, (f"0x{operation:X}", self._unknown))
        if answer == self._unknown:
            self._notes.add("unmodelled", f"semihosting {name}", "this semihosting operation is not there: gives -1")
        try:
            result = answer(parameter)
        except BusFault as fault:
            self._notes.add("misuse", f"semihosting {name}", f"its parameters cannot be accessed: {fault}")
            result = _FAILED
        cpu.set(Reg.R0, result & 0xFFFF_FFFF)
        step_over(cpu, 2)

    # --- the console, and the file of features

    def _open(self, block: int) -> int:
        name = self._bytes(self._word(block, 0), self._word(block, 2))
        if name not in (b":tt", _FEATURES_NAME):
            return self._fail(_ENOENT)
        handle, self._next_handle = self._next_handle, self._next_handle + 1
        if name == _FEATURES_NAME:
            self._positions[handle] = 0
        else:
            self._consoles.add(handle)
        return handle

    def _close(self, block: int) -> int:
        handle = self._word(block, 0)
        if handle not in self._consoles and handle not in self._positions:
            return self._fail(_EBADF)
        self._consoles.discard(handle)
        self._positions.pop(handle, None)
        return 0

    def _write_character(self, address: int) -> int:
        self.on_output(self._bytes(address, 1))
        return 0

    def _write_text(self, address: int) -> int:
        text = bytearray()
        while byte := self._bus.read(address + len(text), 1):
            text.append(byte)
        self.on_output(bytes(text))
        return 0

    def _write(self, block: int) -> int:
        """Write to the console; returns how many bytes were not written."""
        handle, address, length = (self._word(block, index) for index in range(3))
        if handle not in self._consoles:
            self._errno = _EBADF
            return length
        self.on_output(self._bytes(address, length))
        return 0

    def _read(self, block: int) -> int:
        """Return how many bytes were not read: of the console all, which is the end of the file."""
        handle, address, length = (self._word(block, index) for index in range(3))
        position = self._positions.get(handle, len(_FEATURES))
        data = _FEATURES[position : position + length]
        for index, byte in enumerate(data):
            self._bus.write(address + index, 1, byte)
        if handle in self._positions:
            self._positions[handle] += len(data)
        return length - len(data)

    def _seek(self, block: int) -> int:
        handle, position = self._word(block, 0), self._word(block, 1)
        if handle not in self._positions or position > len(_FEATURES):
            return self._fail(_EBADF)
        self._positions[handle] = position
        return 0

    def _is_console(self, block: int) -> int:
        handle = self._word(block, 0)
        if handle in self._positions:
            return 0
        return 1 if handle in self._consoles else self._fail(_EBADF)

    def _length(self, block: int) -> int:
        handle = self._word(block, 0)
        if handle in self._positions:
            return len(_FEATURES)
        return 0 if handle in self._consoles else self._fail(_EBADF)

    # --- the rest

    def _elapsed(self, per_second: int) -> int:
        now = self._time.ns(self._time.now)
        return int(Fraction(now * per_second, NS_PER_S))

    def _get_command_line(self, block: int) -> int:
        address, room = self._word(block, 0), self._word(block, 1)
        if room < len(self._command_line) + 1:
            return _FAILED
        for index, byte in enumerate(self._command_line + b"\0"):
            self._bus.write(address + index, 1, byte)
        self._bus.write(block + 4, 4, len(self._command_line))
        return 0

    def _heap_info(self, block: int) -> int:
        """Say that heap and stack are not known: the program uses its own."""
        answer = self._word(block, 0)
        for index in range(4):
            self._bus.write(answer + 4 * index, 4, 0)
        return 0

    def _exit(self, reason: int) -> int:
        self.on_exit(Exit(status=0 if reason == _APPLICATION_EXIT else 1, reason=reason))
        return 0

    def _exit_extended(self, block: int) -> int:
        reason, status = self._word(block, 0), self._word(block, 1)
        self.on_exit(Exit(status=status if reason == _APPLICATION_EXIT else 1, reason=reason))
        return 0

    def _unknown(self, _parameter: int) -> int:
        return self._fail(_ENOSYS)

    def _fail(self, errno: int) -> int:
        self._errno = errno
        return _FAILED

    def _word(self, block: int, index: int) -> int:
        return self._bus.read(block + 4 * index, 4)

    def _bytes(self, address: int, length: int) -> bytes:
        return bytes(self._bus.read(address + index, 1) for index in range(length))
