"""A DMA controller with eight streams (RM0410 section 8), which is in C: ``dma_stream.c``.

Here are its registers, what it reaches of memory and registers that C does not, and what a program gets wrong.
"""

from __future__ import annotations

import ctypes
import enum
import functools
from array import array
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

from targets.mcu.block import BlockInC, PeripheralInC
from targets.mcu.core.library import with_lock_held
from targets.mcu.errors import BusFault
from targets.mcu.fidelity import Fidelity
from targets.mcu.registers import Register
from targets.mcu.services import BusMaster, Services, drive_in_c
from targets.mcu.stm32.dma_requests import Requests, Sources

__all__ = ["Dma"]

STREAMS = 8

LISR, HISR, LIFCR, HIFCR = range(0x00, 0x10, 4)
_CR, _NDTR, _PAR, _M0AR, _M1AR, _FCR = range(0x10, 0x28, 4)
_STREAM_SIZE = 0x18
_ALL_FLAGS = 0x0F7D_0F7D
_NAMES = ("CR", "NDTR", "PAR", "M0AR", "M1AR", "FCR")

_ASK = ctypes.PYFUNCTYPE(ctypes.c_uint64, ctypes.c_uint32, ctypes.c_uint32, ctypes.c_uint32, ctypes.c_uint32)
_FAILS = (1 << 64) - 1


class _Question(enum.IntEnum):
    """``enum hil_streams_question``."""

    READS = 0
    WRITES = 1
    DRIVES = 2
    NOTES = 3
    SELECTS = 4
    LAST = 5


class _Note(enum.IntEnum):
    """``enum hil_streams_note``."""

    PROTECTED = 0
    FLAGGED = 1
    UNALIGNED = 2
    NO_WAY = 3


class _Controller(BlockInC):
    """The part in C.

    Args:
        services: what the chip offers.
        base: address of LISR.
        registers: by offset.
        requests: the lines of the chip.
        between_memories: see `Dma`.
        answer: called with what C asks; a `BusFault` is an answer, too.
    """

    def __init__(
        self,
        services: Services,
        base: int,
        registers: Mapping[int, Register],
        requests: Requests,
        answer: Callable[[int, int, int, int], int],
        *,
        between_memories: bool,
    ) -> None:
        library = _library()
        self._answer = answer
        self._asked = _ASK(self._ask)
        block = library.hil_streams_new(services.time.queue, self._asked, requests.block, between_memories)
        super().__init__(services.time, block, library.hil_streams_free, base=base, registers=registers)
        asking = functools.partial
        self.reset: Callable[[], None] = asking(library.hil_streams_reset, self.block)
        self.clock: Callable[[int], None] = asking(library.hil_streams_clock, self.block)
        self.bar: Callable[[int, int], bool] = asking(library.hil_streams_bar, self.block)
        self._join: Callable[[Any, Any], None] = asking(library.hil_streams_join, self.block)
        self._select: Callable[[int, Any, int], None] = asking(library.hil_streams_select, self.block)

    def join(self, core: ctypes.c_void_p, irqs: Sequence[int]) -> None:
        """Reach the memory of a core, and drive its interrupts of these numbers, one for each stream."""
        numbers = array("I", irqs)
        self._join(core, numbers.buffer_info()[0])

    def select(self, stream: int, lines: Sequence[int]) -> None:
        """Have a stream listen to the requests of these numbers alone."""
        numbers = array("I", lines)
        self._select(stream, numbers.buffer_info()[0], len(numbers))

    def _ask(self, question: int, address: int, size: int, value: int) -> int:
        try:
            return self._answer(question, address, size, value)
        except BusFault:
            return _FAILS
        except BaseException as trouble:  # noqa: BLE001 - ctypes would swallow it
            self.keep(trouble)
        return 0


class Dma(PeripheralInC):
    """A DMA controller.

    Args:
        name: ``DMA1``.
        base: address of LISR.
        services: what the chip offers. Used: interrupts, the bus.
        sources: which requests a stream listens to.
        irqs: numbers of the interrupts of streams 0 to 7.
        between_memories: whether the peripheral port reaches memory, so that memory to memory is possible.
        control_bits: the bits of SxCR that are there.
        memory: what it reads and writes, if that is not all that the CPU does.
        barred: address and size of what is not within reach, at most twice. Where there is any, `memory` also sees
            what may be in the data cache.
    """

    def __init__(
        self,
        name: str,
        base: int,
        services: Services,
        *,
        sources: Sources,
        irqs: Sequence[int],
        between_memories: bool,
        control_bits: int = 0x1FEF_FFFF,
        memory: BusMaster | None = None,
        barred: Sequence[tuple[int, int]] = (),
    ) -> None:
        self._control_bits = control_bits
        registers = {register.offset: register for register in self.registers_of()}
        self._controller = self.in_c = _Controller(
            services, base, registers, sources.requests, self._answer, between_memories=between_memories
        )
        super().__init__(name, base, services)
        self._values = self.in_c.values
        self._bus = services.bus if memory is None else memory
        self._sources = sources
        for place in barred:
            self._controller.bar(*place)
        self._irqs = [services.irq(number) for number in irqs]
        core = drive_in_c(self._irqs)
        if core is not None:
            self._controller.join(core, irqs)
        for stream in range(STREAMS):
            sources.connect(stream, functools.partial(self._listen, stream, 0))
        self.reset()

    def registers_of(self) -> Iterable[Register]:
        """Return the flags and the registers of each stream."""
        yield Register("LISR", LISR, 0, 0)
        yield Register("HISR", HISR, 0, 0)
        yield Register("LIFCR", LIFCR, 0, _ALL_FLAGS)
        yield Register("HIFCR", HIFCR, 0, _ALL_FLAGS)
        timing = "the CPU is not slowed down, and no overrun or underrun of the FIFO is flagged"
        for number in range(STREAMS):
            base = _STREAM_SIZE * number
            yield Register(f"S{number}CR", base + _CR, 0, self._control_bits, fidelity=Fidelity.PARTLY, note=timing)
            yield Register(f"S{number}NDTR", base + _NDTR, 0, 0xFFFF)
            yield Register(f"S{number}PAR", base + _PAR)
            yield Register(f"S{number}M0AR", base + _M0AR)
            yield Register(f"S{number}M1AR", base + _M1AR)
            yield Register(f"S{number}FCR", base + _FCR, 0x21, 0x87)

    def reset(self) -> None:
        """Go to the state after reset."""
        self._controller.reset()
        self.after_clock_change()

    def after_clock_change(self) -> None:
        """Take over rate and gate of the bus; in Stop mode, in which it stands still, its rate is that of the core."""
        self._controller.clock(self.services.clocks.pclk("AHB") or 1)

    # --- what C asks

    def _answer(self, question: int, address: int, size: int, value: int) -> int:
        """Answer C; raises BusFault if there is nothing at an address."""
        if question == _Question.READS:
            return self._bus.read(address, size)
        if question == _Question.WRITES:
            self._bus.write(address, size, value)
        elif question == _Question.DRIVES:
            self._irqs[address].set(bool(value))
        elif question == _Question.SELECTS:
            self._listen(address, value)
        elif question == _Question.LAST:
            self._sources.requests.tell_last(address)
        else:
            self._note(address, size, _Note(value))
        return 0

    def _listen(self, stream: int, channel: int) -> None:
        self._controller.select(stream, [line.number for line in self._sources.selected(stream, channel)])

    def _note(self, stream: int, register: int, note: _Note) -> None:
        where = f"S{stream}{_NAMES[register]}"
        if note is _Note.PROTECTED:
            text = f"written while stream {stream} is enabled: what is protected keeps its value"
        elif note is _Note.FLAGGED:
            where, text = f"{where}.EN", "flags of the stream are still set: clear them before EN"
        elif note is _Note.NO_WAY:
            where, text = f"{where}.DIR", f"{self.name} cannot go from memory to memory"
        else:
            control = self[_STREAM_SIZE * stream + _CR]
            size = (1, 2, 4, 4)[control >> (11 if register == _NAMES.index("PAR") else 13) & 3]
            text = f"not a multiple of {size} bytes: the lowest bits are ignored"
        self.note("misuse", where, text)


@functools.cache
def _library() -> Any:
    """Return the library, with the functions of the controller declared, called with Python's lock held."""
    library: Any = with_lock_held()
    pointer, word, flag = ctypes.c_void_p, ctypes.c_uint32, ctypes.c_bool
    library.hil_streams_new.argtypes, library.hil_streams_new.restype = (pointer, _ASK, pointer, flag), pointer
    library.hil_streams_free.argtypes, library.hil_streams_free.restype = (pointer,), None
    library.hil_streams_reset.argtypes, library.hil_streams_reset.restype = (pointer,), None
    library.hil_streams_clock.argtypes, library.hil_streams_clock.restype = (pointer, word), None
    library.hil_streams_join.argtypes, library.hil_streams_join.restype = (pointer, pointer, pointer), None
    library.hil_streams_bar.argtypes, library.hil_streams_bar.restype = (pointer, word, word), flag
    library.hil_streams_select.argtypes, library.hil_streams_select.restype = (pointer, word, pointer, word), None
    return library
