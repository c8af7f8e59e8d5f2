"""What a machine does, as lines of text with the HCLK cycle of each: to compare runs, byte by byte.

A trace begins with its header, lines with ``#``: version of this format, board, image by its SHA-256, timing model.
Then comes what happens, in order, each line with cycle, bench time in ns and

* ``pin PA0 1``: a pin rises (1), falls (0) or begins to float (``z``);
* ``wave PA8 8000000 Hz, 1/2 of it high``: a pin carries what is too fast for edges, or no more (``wave PA8 edges``);
* ``USART1 tx 41``: the start bit of a frame that leaves the chip, with its data in hexadecimal, or ``tx break``;
  ``USART1 sends 8N1, 625 cycles a bit`` stands before the first frame for which that is so;
* ``USART1 rx 41``: a word was received, followed by the errors it set (``PE FE NE ORE``; with ORE it was lost);
* ``runs IRQ 37``: the handler of an exception begins, or is gone back to; ``runs Thread mode``;
* ``console itm 'ok'``: a line that the program wrote;
* ``reset IWDG``, ``fault``;
* ``note misuse GPIOA_CRL at 0x08000100``: kind and place of something that is not modelled, or that the firmware got
  wrong. Its words are for people and may change; they are no part of a trace;
* ``end``: the machine ended by itself, how, with which status, and where;
* ``stands``, the last line of all: instructions executed, those of loops passed over counted, and a hash over the
  registers of the CPU and its RAM.

Of one machine and one set of inputs there is one trace: however the run is cut, whether loops are passed over or
executed, on any host. What happens at one cycle stands in the order in which it happened, edges of pins last.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable
from functools import partial
from typing import TYPE_CHECKING

from targets.mcu.cortexm.faults import Fault, exception_name
from targets.mcu.fidelity import Note
from targets.mcu.pins import Pin
from targets.mcu.serial_line import SerialFrame
from targets.mcu.services import Wave
from targets.mcu.stm32.usart_base import UsartBase

if TYPE_CHECKING:
    from targets.mcu.machine import Machine

__all__ = ["TRACE_VERSION", "Trace"]

TRACE_VERSION = 2

_LEVELS = {None: "z", False: "0", True: "1"}
_ERRORS = {1 << 0: "PE", 1 << 1: "FE", 1 << 2: "NE", 1 << 3: "ORE"}  # by their bits in USART_SR
_EVENT, _EDGE = 0, 1  # in this order


class Trace:
    """Writes down what a machine does from now on.

    The callbacks of the machine and of its USARTs are taken over; who had them before is still called. Whoever takes
    them over later has to do the same.

    Args:
        machine: as it comes from its constructor, or later.
        pins: names of the pins to write down; all that the package has if left out.
    """

    def __init__(self, machine: Machine, *, pins: Iterable[str] | None = None) -> None:
        self._machine = machine
        self._pending: list[tuple[int, int, int, int, str]] = []  # cycle, event or edge, order, ns, text
        self._order = 0
        self._console: dict[str, bytearray] = {}
        self._settings: dict[str, str] = {}
        self._ended = False
        chosen = (
            [pin for pin in machine.chip.pins if pin.bonded]
            if pins is None
            else map(machine.chip.pins.__getitem__, pins)
        )
        self._pins = list(chosen)
        for pin in self._pins:
            pin.record()
            pin.on_wave = _after(pin.on_wave, partial(self._waves, pin))
        for note in machine.notes.all:
            self._note(note)
        machine.on_console = _after(machine.on_console, self._wrote)
        machine.on_reset = _after(machine.on_reset, self._reset)
        machine.on_fault = _after(machine.on_fault, self._fault)
        machine.core.on_running = _after(machine.core.on_running, self._runs)
        machine.notes.on_note = _after(machine.notes.on_note, self._note)
        for usart in machine.chip.usarts.values():
            usart.on_frame = _after(usart.on_frame, partial(self._sent, usart))
            usart.on_word = _after(usart.on_word, partial(self._received, usart))

    def header(self) -> list[str]:
        """Return the lines that say what was run."""
        machine = self._machine
        board = machine.board
        return [
            f"# trace {TRACE_VERSION}",
            f"# board {board.name}: {board.chip}, HSE {board.hse_hz} Hz, LSE {board.lse_hz} Hz",
            f"# image sha256 {machine.image.digest}",
            f"# timing {machine.timing}",
        ]

    def take(self) -> list[str]:
        """Return the lines since they were last taken: all that cannot change any more.

        What happened at the very cycle that the machine has reached comes with a later call, unless the machine ended.
        """
        machine = self._machine
        self._collect_edges()
        if machine.ended is not None and not self._ended:
            self._ended = True
            self._end()
        self._pending.sort()
        now = machine.time.now
        count = len(self._pending) if self._ended else sum(1 for entry in self._pending if entry[0] < now)
        ready, self._pending = self._pending[:count], self._pending[count:]
        return [f"{cycle} {ns} {text}" for cycle, _rank, _order, ns, text in ready]

    def close(self) -> list[str]:
        """Return the lines that were not taken, with what stands on the consoles without an end of line."""
        for channel in self._console:
            self._write_console(channel)
        lines = self.take()
        rest, self._pending = self._pending, []
        return lines + [f"{cycle} {ns} {text}" for cycle, _rank, _order, ns, text in rest] + [self._last_line()]

    def _last_line(self) -> str:
        engine, time = self._machine.engine, self._machine.time
        state = hashlib.sha256(engine.fingerprint() + self._machine.ram).hexdigest()[:16]
        cycle = engine.cycle  # the last instruction may have gone beyond the end of the run
        return f"{cycle} {time.ns(cycle)} stands after {engine.instructions} instructions, state {state}"

    # --- what happens

    def _add(self, text: str) -> None:
        time = self._machine.time
        now = time.now
        self._add_at(now, time.ns(now), text)

    def _add_at(self, cycle: int, ns: int, text: str) -> None:
        self._pending.append((cycle, _EVENT, self._order, ns, text))
        self._order += 1

    def _collect_edges(self) -> None:
        for pin in self._pins:
            for edge in pin.take_edges():
                text = f"pin {pin.name} {_LEVELS[edge.level]}"
                self._pending.append((edge.cycle, _EDGE, self._order, edge.ns, text))
                self._order += 1

    def _waves(self, pin: Pin, wave: Wave | None) -> None:
        what = "edges" if wave is None else f"{wave.hz} Hz, {wave.duty} of it high"
        self._add(f"wave {pin.name} {what}")

    def _runs(self, number: int) -> None:
        self._add(f"runs {exception_name(number)}")

    def _reset(self, cause: str) -> None:
        self._add(f"reset {cause}")

    def _wrote(self, text: bytes, channel: str) -> None:
        line = self._console.setdefault(channel, bytearray())
        for byte in text:
            if byte == 0x0A:
                self._write_console(channel, "")
            else:
                line.append(byte)

    def _write_console(self, channel: str, at_end: str = " (not ended)") -> None:
        line = self._console[channel]
        if line or not at_end:
            self._add(f"console {channel} {line.decode('ascii', 'backslashreplace')!r}{at_end}")
            line.clear()

    def _note(self, note: Note) -> None:
        pc = "" if note.pc is None else f" at 0x{note.pc:08X}"
        self._add_at(note.cycle, note.ns, f"note {note.kind} {note.where}{pc}")

    def _fault(self, fault: Fault) -> None:
        became = exception_name(fault.exception) if fault.exception else "lockup"
        where = "" if fault.address is None else f", accessed 0x{fault.address:08X}"
        text = f"fault {' '.join(fault.causes)} at 0x{fault.pc:08X} in {exception_name(fault.running)}{where}: {became}"
        self._add_at(fault.cycle, fault.ns, text)

    def _sent(self, usart: UsartBase, frame: SerialFrame) -> None:
        cycles = frame.bit_s * self._machine.time.hclk_hz
        setting = f"{usart.format}, {cycles} cycles a bit"
        if self._settings.get(usart.name) != setting:
            self._settings[usart.name] = setting
            self._add(f"{usart.name} sends {setting}")
        self._add(f"{usart.name} tx {'break' if frame.is_break else f'{usart.format.value(frame.bits):02X}'}")

    def _received(self, usart: UsartBase, data: int, errors: int) -> None:
        self._add(" ".join((f"{usart.name} rx {data:02X}", *(name for bit, name in _ERRORS.items() if errors & bit))))

    def _end(self) -> None:
        ended = self._machine.ended
        assert ended is not None
        for channel in self._console:
            self._write_console(channel)
        self._add_at(ended.cycle, ended.ns, f"end {ended.kind} status {ended.status} at 0x{ended.pc:08X}")


def _after(first: Callable[..., None] | None, then: Callable[..., None]) -> Callable[..., None]:
    """Return what calls `first`, if there is one, and `then`."""
    if first is None:
        return then

    def both(*arguments: object) -> None:
        first(*arguments)
        then(*arguments)

    return both
