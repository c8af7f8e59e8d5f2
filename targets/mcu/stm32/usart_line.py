"""The part of a USART that is in C (``usart.c``): its registers as they are kept, its transmitter, the frames it hears.

What a frame does to the level of a pin, and frames that must be sampled, are in `usart_transmitter` and
`usart_receiver`.
"""

from __future__ import annotations

import ctypes
import enum
import functools
from array import array
from collections.abc import Callable, Mapping
from fractions import Fraction
from typing import Any

from targets.mcu.block import BlockInC
from targets.mcu.core.library import structure, with_lock_held
from targets.mcu.registers import Register
from targets.mcu.serial_line import SerialFormat
from targets.mcu.stm32.bit_clock import BitClock
from targets.mcu.timebase import Timebase

__all__ = ["Ask", "Kind", "News", "Sending", "Tell", "UsartLine"]

_TELL = ctypes.PYFUNCTYPE(None, ctypes.c_uint32, ctypes.c_uint32, ctypes.c_uint32)
_ASK = ctypes.PYFUNCTYPE(ctypes.c_uint64, ctypes.c_uint32, ctypes.c_uint32)
_PARITIES = {"N": 0, "E": 1, "O": 2}
_MOST = (1 << 63) - 1


class Kind(enum.IntEnum):
    """``enum hil_usart_kind``: which registers."""

    F1 = 0
    ISR = 1


class Sending(enum.IntEnum):
    """``enum hil_sending``."""

    NOTHING = 0
    PREAMBLE = 1
    BREAK = 2
    BREAK_STOP = 3
    DATA = 4


class News(enum.IntEnum):
    """``enum hil_usart_news``; what each means stands there."""

    FRAME = 0
    END = 1
    IDLE_LEVEL = 2
    CUT = 3
    DATA = 4
    DMA_TX = 5
    DMA_RX = 6
    IRQ = 7
    RTS = 8
    ARRIVED = 9


class Ask(enum.IntEnum):
    """``enum hil_usart_question``."""

    SENT = 0
    READ = 1
    QUIET = 2


class Tell(enum.IntFlag):
    """Of which news somebody wants to know at once; WORDS of data are kept instead, until they are taken."""

    FRAMES = 1
    ENDS = 2
    DATA = 4
    WORDS = 8


class UsartLine(BlockInC):
    """See the module.

    Args:
        time: the chip's cycles and events.
        base: address of the first register.
        registers: by offset.
        kind: which registers.

    Attributes:
        line: ``struct hil_line``; see ``usart.h``.
        handlers: whom to call by the kind of the news, with its two numbers.

    Raises:
        EngineError: there is no memory.
    """

    def __init__(self, time: Timebase, base: int, registers: Mapping[int, Register], kind: Kind) -> None:
        self._callbacks = _TELL(self._tell), _ASK(self._ask)
        library = _library()
        block = library.hil_usart_new(time.queue, kind, *self._callbacks)
        super().__init__(time, block, library.hil_usart_free, base=base, registers=registers)
        self.line: Any = structure("hil_line").from_address(library.hil_line_of(self.block))
        self.handlers: dict[int, Callable[[int, int], None]] = {}
        self._sent, self._read, self._quiet = _Clock(), _Clock(), _Clock()
        self._bit_cycles: int | Fraction = 16
        asking = functools.partial
        self.put: Callable[[int], None] = asking(library.hil_usart_put, self.block)
        self.proceed: Callable[[], None] = asking(library.hil_usart_proceed, self.block)
        self.enable: Callable[[bool], None] = asking(library.hil_usart_enable, self.block)
        self.stop: Callable[[], None] = asking(library.hil_usart_stop, self.block)
        self.hear: Callable[[int, int], None] = asking(library.hil_usart_hear, self.block)
        self.unhear: Callable[[], None] = asking(library.hil_usart_unhear, self.block)
        self.await_quiet: Callable[[int], None] = asking(library.hil_usart_await_quiet, self.block)
        self.break_quiet: Callable[[int], None] = asking(library.hil_usart_break_quiet, self.block)
        self.forget_quiet: Callable[[], None] = asking(library.hil_usart_forget_quiet, self.block)
        self.expect_only: Callable[[int], None] = asking(library.hil_usart_expect_only, self.block)
        self._expect: Callable[[Any, Any, int], bool] = asking(library.hil_usart_expect, self.block)
        self._take_kept: Callable[[Any], None] = asking(library.hil_usart_take_kept, self.block)
        self._bend: Callable[[], None] = asking(library.hil_usart_bend, self.block)
        self._bend_quiet: Callable[[], None] = asking(library.hil_usart_bend_quiet, self.block)
        self._interrupts: Callable[[Any, int], None] = asking(library.hil_usart_interrupts, self.block)
        self._transfers: Callable[[Any, int, int], None] = asking(library.hil_usart_transfers, self.block)
        self.update: Callable[[], None] = asking(library.hil_usart_update, self.block)
        self.take_word: Callable[[int, bool, bool], None] = asking(library.hil_usart_take_word, self.block)
        self.wants_idle: Callable[[], bool] = asking(library.hil_usart_wants_idle, self.block)

    # --- lines

    def interrupts(self, core: Any, number: int) -> None:
        """Drive the interrupt of that number of a core, without telling anybody here."""
        self._interrupts(core, number)

    def transfers(self, controller: ctypes.c_void_p, to_send: int, received: int) -> None:
        """Ask a DMA controller in C, by requests of these numbers, without telling anybody here."""
        self._transfers(controller, to_send, received)

    # --- many frames at once

    def expect(self, cycles: array[int], bits: array[int]) -> None:
        """Have frames come in, each at its cycle, behind those that are expected already.

        Args:
            cycles: typecode ``Q``, ascending.
            bits: typecode ``Q``; with ``LOOK_AT_WORD`` where Python is to look at the frame.

        Raises:
            MemoryError: there is no memory left.
        """
        if not self._expect(cycles.buffer_info()[0], bits.buffer_info()[0], len(bits)):
            raise MemoryError("there is no memory for the frames that come in")

    def take_kept(self) -> array[int]:
        """Return the words that were sent and kept since they were last taken: cycle, bits, cycle, bits and so on."""
        words = array("Q", bytes(16 * self.line.kept))
        if words:
            self._take_kept(words.buffer_info()[0])
        return words

    # --- time

    @property
    def bit_cycles(self) -> int | Fraction:
        """How many cycles a bit lasts."""
        return self._bit_cycles

    def set_rate(self, bit_cycles: int | Fraction) -> bool:
        """Let a bit take so many cycles from now on; return whether that moves the end of what is being sent."""
        line, now, before = self.line, self._time.now, self._bit_cycles
        self._bit_cycles = bit_cycles
        sends = False
        if line.sending == Sending.NOTHING:
            self._sent.forget()
        elif sends := bit_cycles != self._sent.rate(line.begun, before):
            self._sent.change(now, bit_cycles)
        self._quiet.rate(line.quiet_from, before)
        self._quiet.change(now, bit_cycles)
        numerator, denominator = bit_cycles.numerator, bit_cycles.denominator
        line.odd = numerator > _MOST or 16 * denominator > _MOST
        if not line.odd:
            line.bit_cycles, line.bit_parts = numerator, denominator
        if sends:
            self._bend()
        self._bend_quiet()
        return sends

    def sent_at(self, sixteenths: int) -> int:
        """Return the cycle at which so many sixteenths of a bit of the present frame have been sent."""
        self._sent.rate(self.line.begun, self._bit_cycles)
        return self._sent.cycle(sixteenths)

    def frame(self, form: SerialFormat) -> None:
        """Set how words are framed."""
        line = self.line
        line.word_bits, line.data_bits = form.word_bits, form.data_bits
        line.parity, line.stop_half_bits = _PARITIES[form.parity], form.stop_half_bits

    # --- what C calls

    def _tell(self, news: int, value: int, more: int) -> None:
        try:
            self.handlers[news](value, more)
        except BaseException as trouble:  # noqa: BLE001 - ctypes would swallow it
            self.keep(trouble)

    def _ask(self, question: int, sixteenths: int) -> int:
        try:
            if question == Ask.SENT:
                return self.sent_at(sixteenths)
            clock, begun = (
                (self._read, self.line.heard_from) if question == Ask.READ else (self._quiet, self.line.quiet_from)
            )
            clock.rate(begun, self._bit_cycles)
            return clock.cycle(sixteenths)
        except BaseException as trouble:  # noqa: BLE001
            self.keep(trouble)
            return 0


class _Clock(BitClock):
    """Sixteenths of a bit since a cycle at which something began, and the length of a bit may have changed since."""

    __slots__ = ("_begun",)

    def __init__(self) -> None:
        super().__init__()
        self._begun = -1

    def forget(self) -> None:
        """Begin anew with whatever is asked for next."""
        self._begun = -1

    def rate(self, begun: int, bit_cycles: int | Fraction) -> int | Fraction:
        """Return the present length of a bit; it was `bit_cycles` when something new began at `begun`."""
        if begun != self._begun:
            self._begun = begun
            self.start(begun, bit_cycles)
        return self.bit_cycles


@functools.cache
def _library() -> Any:
    """Return the library, with the functions of USARTs declared, called with Python's lock held."""
    library: Any = with_lock_held()
    pointer, word, cycle = ctypes.c_void_p, ctypes.c_uint32, ctypes.c_uint64
    library.hil_usart_new.argtypes, library.hil_usart_new.restype = (pointer, word, _TELL, _ASK), pointer
    library.hil_line_of.argtypes, library.hil_line_of.restype = (pointer,), pointer
    library.hil_usart_expect.argtypes = (pointer, pointer, pointer, word)
    library.hil_usart_expect.restype = ctypes.c_bool
    library.hil_usart_wants_idle.argtypes, library.hil_usart_wants_idle.restype = (pointer,), ctypes.c_bool
    takes: dict[str, tuple[Any, ...]] = {
        "hil_usart_free": (),
        "hil_usart_put": (word,),
        "hil_usart_proceed": (),
        "hil_usart_enable": (word,),
        "hil_usart_stop": (),
        "hil_usart_bend": (),
        "hil_usart_hear": (cycle, word),
        "hil_usart_unhear": (),
        "hil_usart_await_quiet": (cycle,),
        "hil_usart_break_quiet": (cycle,),
        "hil_usart_bend_quiet": (),
        "hil_usart_forget_quiet": (),
        "hil_usart_expect_only": (word,),
        "hil_usart_take_kept": (pointer,),
        "hil_usart_interrupts": (pointer, word),
        "hil_usart_transfers": (pointer, word, word),
        "hil_usart_update": (),
        "hil_usart_take_word": (word, word, word),
    }
    for name, arguments in takes.items():
        function = getattr(library, name)
        function.argtypes, function.restype = (pointer, *arguments), None
    return library
