"""The part of a USART that is in C (``usart.c``): its registers as they are kept, its transmitter, the frames it hears.

What a frame does to the level of a pin, and frames that must be sampled, are in `usart_transmitter` and
`usart_receiver`.
"""

from __future__ import annotations

import ctypes
import enum
import functools
import weakref
from collections.abc import Callable, Mapping
from fractions import Fraction
from typing import Any

from targets.mcu.core.library import load, structure
from targets.mcu.errors import EngineError
from targets.mcu.registers import Register
from targets.mcu.serial_line import SerialFormat
from targets.mcu.stm32.bit_clock import BitClock
from targets.mcu.timebase import Timebase

__all__ = ["Ask", "Kept", "Kind", "News", "Sending", "Tell", "UsartLine"]

_TELL = ctypes.PYFUNCTYPE(None, ctypes.c_uint32, ctypes.c_uint32, ctypes.c_uint32)
_ASK = ctypes.PYFUNCTYPE(ctypes.c_uint64, ctypes.c_uint32, ctypes.c_uint32)
_PARITIES = {"N": 0, "E": 1, "O": 2}
_MOST = (1 << 63) - 1


class Kind(enum.IntEnum):
    """``enum hil_usart_kind``: whose registers C knows."""

    OF_PYTHON = 0
    F1 = 1


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
    LOADED = 4
    COMPLETE = 5
    BREAK_SENT = 6
    WORD = 7
    LINE_IDLE = 8
    DATA = 9
    DMA_TX = 10
    DMA_RX = 11
    IRQ = 12
    RTS = 13


class Ask(enum.IntEnum):
    """``enum hil_usart_question``."""

    SENT = 0
    READ = 1
    QUIET = 2
    IDLE_WANTED = 3


class Tell(enum.IntFlag):
    """Of which news somebody wants to know at once."""

    FRAMES = 1
    ENDS = 2
    DATA = 4


class Kept:
    """Registers by their offsets, in memory that C sees too."""

    __slots__ = ("_words",)

    def __init__(self, words: memoryview) -> None:
        self._words = words

    def __getitem__(self, offset: int) -> int:
        return self._words[offset >> 2]

    def __setitem__(self, offset: int, value: int) -> None:
        self._words[offset >> 2] = value


class UsartLine:
    """See the module.

    Args:
        time: the chip's cycles and events.
        base: address of the first register.
        registers: by offset.
        kind: whose registers C knows.

    Attributes:
        line: ``struct hil_line``; see ``usart.h``.
        block: the block of registers, for `CoreEngine.attach`.
        values: the registers.
        handlers: whom to call by the kind of the news, with its two numbers.
        wants_idle: asked after a word whether to tell of an idle line, where C does not know.

    Raises:
        EngineError: there is no memory.
    """

    def __init__(self, time: Timebase, base: int, registers: Mapping[int, Register], kind: Kind) -> None:
        self._time = time
        self._callbacks = _TELL(self._tell), _ASK(self._ask)
        library = _library()
        block = library.hil_usart_new(time.queue, kind, *self._callbacks)
        if not block:
            raise EngineError("there is no memory for a USART")
        self.block = ctypes.c_void_p(block)
        weakref.finalize(self, library.hil_usart_free, self.block).atexit = False
        time.keep_alive(self)
        self.line: Any = structure("hil_line").from_address(library.hil_line_of(self.block))
        self.registers: Any = structure("hil_registers").from_address(library.hil_registers_of(self.block))
        self.registers.base = base
        for offset, register in registers.items():
            self.registers.writable[offset >> 2] = register.writable
            self.registers.ignored[offset >> 2] = register.ignored
        self.values = Kept(memoryview(self.registers.values).cast("B").cast("I"))
        self.handlers: dict[int, Callable[[int, int], None]] = {}
        self.wants_idle: Callable[[], bool] = lambda: False
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
        self._store: Callable[[int, int], bool] = asking(library.hil_block_store, self.block)
        self._load: Callable[[int], int] = asking(library.hil_block_load, self.block)
        self._bend: Callable[[], None] = asking(library.hil_usart_bend, self.block)
        self._bend_quiet: Callable[[], None] = asking(library.hil_usart_bend_quiet, self.block)
        self._interrupts: Callable[[Any, int], None] = asking(library.hil_usart_interrupts, self.block)
        # of an F1
        self.update: Callable[[], None] = asking(library.hil_f1_update, self.block)
        self.take_word: Callable[[int, bool, bool], None] = asking(library.hil_f1_word, self.block)
        self.f1_wants_idle: Callable[[], bool] = asking(library.hil_f1_wants_idle, self.block)

    # --- registers

    def load(self, offset: int) -> int:
        """Read a register as a program does, with its effects."""
        value = self._load(offset >> 2)
        self._time.raise_kept()
        return value

    def store(self, offset: int, value: int) -> bool:
        """Write one; False: nothing was done, it is for Python."""
        done = self._store(offset >> 2, value)
        self._time.raise_kept()
        return done

    def interrupts(self, core: Any, number: int) -> None:
        """Drive the interrupt of that number of a core, without telling anybody here."""
        self._interrupts(core, number)

    # --- time

    @property
    def bit_cycles(self) -> int | Fraction:
        """How many cycles a bit lasts."""
        return self._bit_cycles

    def set_rate(self, bit_cycles: int | Fraction) -> bool:
        """Let a bit take so many cycles from now on; return whether that moves the end of what is being sent."""
        line, now, before = self.line, self._time.now, self._bit_cycles
        self._bit_cycles = bit_cycles
        sends = line.sending != Sending.NOTHING and bit_cycles != self._sent.rate(line.begun, before)
        if sends:
            self._sent.change(now, bit_cycles)
        else:
            self._sent.forget()
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
            if question == Ask.IDLE_WANTED:
                return self.wants_idle()
            clock, begun = (
                (self._read, self.line.heard_from) if question == Ask.READ else (self._quiet, self.line.quiet_from)
            )
            clock.rate(begun, self._bit_cycles)
            return clock.cycle(sixteenths)
        except BaseException as trouble:  # noqa: BLE001
            self.keep(trouble)
            return 0

    def keep(self, trouble: BaseException) -> None:
        """Have an exception come out of whatever lets time pass."""
        self._time.keep(trouble)


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
    library: Any = ctypes.PyDLL("", handle=load()._handle)  # noqa: SLF001
    pointer, word, cycle = ctypes.c_void_p, ctypes.c_uint32, ctypes.c_uint64
    library.hil_usart_new.argtypes, library.hil_usart_new.restype = (pointer, word, _TELL, _ASK), pointer
    for name in ("hil_line_of", "hil_registers_of"):
        function = getattr(library, name)
        function.argtypes, function.restype = (pointer,), pointer
    library.hil_block_load.argtypes, library.hil_block_load.restype = (pointer, word), word
    library.hil_block_store.argtypes, library.hil_block_store.restype = (pointer, word, word), ctypes.c_bool
    library.hil_f1_wants_idle.argtypes, library.hil_f1_wants_idle.restype = (pointer,), ctypes.c_bool
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
        "hil_usart_interrupts": (pointer, word),
        "hil_f1_update": (),
        "hil_f1_word": (word, word, word),
    }
    for name, arguments in takes.items():
        function = getattr(library, name)
        function.argtypes, function.restype = (pointer, *arguments), None
    return library
