"""SPI1 to SPI3 of the STM32F103 (RM0008 section 25), which are in C: ``spi_f1.c``, ``spi_words.c``.

Here are registers, pins and what is outside. A master is connected to `SpiBus`, where the slaves are. A slave is
clocked a word at a time through `Spi.exchange`, by whoever is its master in a test.

Not modelled: I2S; a slave that is clocked by the edges at its pins, which is noted.
"""

from __future__ import annotations

import ctypes
import enum
import functools
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from typing import Any, ClassVar

from targets.mcu.block import BlockInC, PeripheralInC
from targets.mcu.core.library import structure, with_lock_held
from targets.mcu.fidelity import Fidelity
from targets.mcu.registers import Register
from targets.mcu.services import Services, Watch, drive_in_c
from targets.mcu.spi_bus import SpiBus
from targets.mcu.stm32.spi_base import (
    CR1,
    CR2,
    CRCERR,
    CRCPR,
    DR,
    I2SCFGR,
    I2SMOD,
    I2SPR,
    NO_CLOCK,
    NO_I2S,
    RXCRCR,
    SR,
    TXCRCR,
    TXE,
)
from targets.mcu.stm32.spi_wire import SpiWire, UnderWay, Word

__all__ = ["Spi"]

_NOT_THERE = "devices of medium density have no I2S"
_NOTES: tuple[tuple[str, str, str], ...] = (
    ("misuse", "DR", "a word was written while TXE was 0: the one before is lost"),
    ("misuse", "CR1", "DFF and CRCEN may be changed only while SPE is 0"),
    ("unmodelled", "CR1.MSTR", f"{NO_CLOCK}: no word ever arrives"),
    ("misuse", "CR1.CRCNEXT", "set while no word is under way: the CRC follows the next one"),
)
"""By ``enum hil_spi_note``."""

_ASK = ctypes.PYFUNCTYPE(ctypes.c_uint32, ctypes.c_uint32, ctypes.c_uint32)
_SILENCE = 0xFFFF_FFFF
_NO_SLAVE = (1 << 64) - 1
_MOST_PROMISED = 4096


class _Question(enum.IntEnum):
    """``enum hil_spi_question``."""

    CLOCK = 0
    LISTENS = 1
    NSS = 2
    IDLES = 3
    RELEASES = 4
    SENDS = 5
    EDGE = 6
    PUTS = 7
    LEVEL = 8
    EXCHANGES = 9
    LEFT = 10
    REQUESTS_TX = 11
    REQUESTS_RX = 12
    DRIVES = 13
    NOTES = 14


class _InC(BlockInC):
    """The part in C.

    Args:
        services: what the chip offers.
        base: address of CR1.
        registers: by offset.
        answer: called with what C asks, and a value.

    Attributes:
        wires: ``struct hil_spi_wires``.
    """

    def __init__(
        self,
        services: Services,
        base: int,
        registers: Mapping[int, Register],
        answer: Callable[[int, int], int],
    ) -> None:
        library = _library()
        self._answer = answer
        self._asked = _ASK(self._ask)
        block = library.hil_spi_new(services.time.queue, self._asked)
        super().__init__(services.time, block, library.hil_spi_free, base=base, registers=registers)
        self.wires: Any = structure("hil_spi_wires").from_address(library.hil_spi_wires_of(self.block))
        self.reset: Callable[[], None] = functools.partial(library.hil_spi_reset, self.block)
        self.over: Callable[[int], None] = functools.partial(library.hil_spi_over, self.block)
        self.let_go: Callable[[], None] = functools.partial(library.hil_spi_let_go, self.block)
        self.deselected: Callable[[], None] = functools.partial(library.hil_spi_deselected, self.block)
        self.interrupts: Callable[[ctypes.c_void_p, int], None]
        self.interrupts = functools.partial(library.hil_spi_interrupts, self.block)
        self.transfers: Callable[[ctypes.c_void_p, int, int], None]
        self.transfers = functools.partial(library.hil_spi_transfers, self.block)
        self.promise: Callable[[bytes, int], None] = functools.partial(library.hil_spi_promise, self.block)
        self._take: Callable[[Any], None] = functools.partial(library.hil_spi_take, self.block)
        self._exchange: Callable[[int], int] = functools.partial(library.hil_spi_exchange, self.block)

    def exchange(self, bits: int) -> int | None:
        """Have a slave clocked through a word."""
        sent = self._exchange(bits)
        self._time.raise_kept()
        return None if sent == _NO_SLAVE else sent

    def take(self) -> bytes:
        """End a promise of slaves; return what was sent since then."""
        heard = ctypes.create_string_buffer(self.wires.heard)
        self._take(heard)
        return heard.raw

    def _ask(self, question: int, value: int) -> int:
        try:
            return self._answer(question, value)
        except BaseException as trouble:  # noqa: BLE001 - ctypes would swallow it
            self.keep(trouble)
        return 0


class _Wire(SpiWire):
    """The wires, while C carries the words that nobody looks at.

    Args:
        name: ``SPI1``.
        services: what the chip offers.
        bus: the slaves.
        in_c: the part in C.
    """

    def __init__(self, name: str, services: Services, bus: SpiBus, in_c: _InC) -> None:
        self._in_c, self._wires = in_c, in_c.wires
        self._tells = False
        super().__init__(name, services, bus)
        self._miso.on_reach = self._forget_miso
        bus.take_heard = self.take_heard
        self._see()

    @property
    def under_way(self) -> bool:
        """Whether a word is."""
        return bool(self._wires.going) or super().under_way

    def idle(self, cpol: bool) -> None:
        """Be a master that waits."""
        if self._wires.going:
            self._so_far()
        super().idle(cpol)

    def release(self) -> None:
        """Drive nothing."""
        self._tell()
        self._in_c.let_go()
        super().release()

    def level(self) -> bool:
        """Return what stands where bits come in; C remembers what stays."""
        wires = self._wires
        level = (self._back if wires.one_wire else self._miso).level()
        if not wires.one_wire:
            wires.known, wires.miso = self._miso.holds(self._forget_miso), level
        return level

    def exchange(self) -> int | None:
        """Have the slaves take the word that C has carried, and return what they say; C remembers what they promise."""
        wires = self._wires
        count, mode = wires.count, self._cpol << 1 | wires.cpha
        sent = wires.bits if wires.drives else (1 << count) - 1
        answer = self._bus.exchange(sent, count, mode, self._time.ns(self._time.now))
        promised = self._bus.promise(mode, _MOST_PROMISED)
        if promised is not None:
            self._in_c.promise(promised, len(promised))
        return answer

    def take_heard(self) -> tuple[bytes, int]:
        """End the promise; return what C has sent since then, and the end of that."""
        if not self._wires.promised:
            return b"", 0
        return self._in_c.take(), self._time.ns(self._wires.heard_at)

    def begin(self) -> bool:
        """Let the word that C has begun go over the wires; True: C is to do so, as MOSI leads to MISO alone."""
        self._catch_up()
        word, wires = self._word(), self._wires
        if word.drives and not word.one_wire and self._mosi.watch() is Watch.LIVE and self._may_be_late():
            wires.looped = wires.late = True
        else:
            self.send(word, self._in_c.over)
        return bool(wires.looped)

    def edge(self) -> bool:
        """Tell of the edge that is due of a word that C carries; return what stands at MISO."""
        self._tell()
        return self._miso.level()

    def put(self) -> None:
        """Bring the wires to the end of the word that C has carried."""
        self._catch_up()
        self._wires.going = 0
        self._to_end(self._word(), looked=self._under_way is not None)
        self._wires.late = self._may_be_late()

    def _may_be_late(self) -> bool:
        return self._sck.tell_late(self._so_far) and self._mosi.tell_late(self._so_far, self._miso)

    def _catch_up(self) -> None:
        """Tell MOSI how the last word that C has carried has ended; the next ones are told again as they end."""
        wires = self._wires
        wires.late = wires.looped = 0
        if wires.behind:
            wires.behind = 0
            if not (wires.going and wires.edges):  # what the next one has done since is told instead
                self._put_mosi(bool(wires.last))

    def _put_mosi(self, level: bool) -> None:
        told, self._tells = self._tells, True
        try:
            super()._put_mosi(level)
        finally:
            self._tells = told

    def _so_far(self) -> None:
        """Tell what has been so far: CPOL may change, or another signal begins to drive a pad."""
        self._catch_up()
        if self._wires.going and self._wires.edges:
            self._take_word()

    def _take_word(self) -> None:
        """Tell of the edges of the word that C carries from now on; of those that have been, what came of them."""
        wires = self._wires
        if self._under_way is None:
            going = self._under_way = UnderWay(self._word(), wires.begun, self._in_c.over)
            if wires.edges:
                going.told = wires.halves
                self._put_mosi(going.word.bit(wires.halves - 1))
                self._sck.set(self._sck_level(going.word, wires.halves - 1))

    def _word(self) -> Word:
        wires = self._wires
        return Word(
            bits=wires.bits,
            count=wires.count,
            half_cycles=wires.half_cycles,
            cpha=bool(wires.cpha),
            drives=bool(wires.drives),
            one_wire=bool(wires.one_wire),
        )

    def _forget_miso(self) -> None:
        self._wires.known = 0

    def _see(self) -> None:
        """Find out who looks."""
        self._wires.plain = self._sck.watch() is self._mosi.watch() is Watch.NOBODY

    def _watched(self) -> None:
        self._see()
        self._tell()
        if self._wires.going and self._wires.edges and self._under_way is not None:
            self._under_way.resume(self._wires.sampled, self._wires.halves // 2)
        self._in_c.let_go()
        super()._watched()

    def _tell(self) -> None:
        """Bring levels up to the present cycle."""
        if self._tells:
            return  # the wire back asks for what is just being told
        self._tells = True
        try:
            self._catch_up()
            if self._wires.going:
                self._take_word()
            super()._tell()
        finally:
            self._tells = False


class Spi(PeripheralInC):
    """One of them.

    Args:
        name: ``SPI1``.
        base: address of CR1.
        services: what the chip offers. Used: the interrupt, requests ``SPI1_RX`` and ``SPI1_TX``, the pins' signals.
        bus: whose clock it is.
        irq: its interrupt.
        has_i2s: whether there are I2S registers; I2S is not modelled.
        tx_left: returns how many words DMA has still to bring, for the CRC that follows them.

    Attributes:
        bus: the slaves outside.
    """

    REGISTERS: ClassVar[tuple[Register, ...]] = (
        Register("CR1", CR1, 0, 0xFFFF, fidelity=Fidelity.PARTLY, note=NO_CLOCK),
        Register("CR2", CR2, 0, 0xE7),
        Register("SR", SR, TXE, CRCERR),
        Register("DR", DR, 0, 0xFFFF),
        Register("CRCPR", CRCPR, 0x07, 0xFFFF),
        Register("RXCRCR", RXCRCR, 0, 0),
        Register("TXCRCR", TXCRCR, 0, 0),
        Register("I2SCFGR", I2SCFGR, 0, 0, I2SMOD, fidelity=Fidelity.PARTLY, note=_NOT_THERE),
        Register("I2SPR", I2SPR, 0, 0, fidelity=Fidelity.ABSENT, note=_NOT_THERE),
    )

    in_c: _InC

    def __init__(
        self,
        name: str,
        base: int,
        services: Services,
        *,
        bus: str,
        irq: int,
        has_i2s: bool = False,
        tx_left: Callable[[], int] = lambda: 1,
    ) -> None:
        self._has_i2s = has_i2s
        registers = {register.offset: register for register in self.registers_of()}
        self.in_c = _InC(services, base, registers, self._answer)
        super().__init__(name, base, services)
        self._values = self.in_c.values
        super().reset()
        self.bus = SpiBus()
        self.bus.on_attach = self._attached
        self._bus_clock = bus
        self._tx_left = tx_left
        self._wire = _Wire(name, services, self.bus, self.in_c)
        self._nss_in, self._nss_out = services.input(f"{name}_NSS"), services.output(f"{name}_NSS")
        self._irq = services.irq(irq)
        core = drive_in_c([self._irq])
        if core is not None:
            self.in_c.interrupts(core, irq)
        self._requests = services.dma(f"{name}_TX"), services.dma(f"{name}_RX")
        to_send, received = (request.in_c for request in self._requests)
        if to_send is not None and received is not None:
            self.in_c.transfers(to_send.controller, to_send.number, received.number)

    def registers_of(self) -> Iterable[Register]:
        """Return the registers, those of I2S as this device has them."""
        for register in self.REGISTERS:
            if register.offset == I2SCFGR and self._has_i2s:
                yield replace(register, writable=0x0FBF, note=NO_I2S)
            elif register.offset == I2SPR and self._has_i2s:
                yield replace(register, reset=2, writable=0x03FF, note=NO_I2S)
            else:
                yield register

    def reset(self) -> None:
        """Go to the state after reset; a word under way is lost."""
        super().reset()
        self.in_c.reset()

    def before_clock_change(self) -> None:
        """Tell slaves of what was sent in the present epoch."""
        self.bus.settle()

    def after_clock_change(self) -> None:
        """Go on at the new rate with the next word."""
        self.in_c.wires.clock_cycles = 0

    def exchange(self, bits: int) -> int | None:
        """Be clocked through a word by a master, now.

        Args:
            bits: those of a word on MOSI, the first one as the highest.

        Returns:
            What stood on MISO; None if it is no slave that is switched on and selected.
        """
        return self.in_c.exchange(bits)

    def _attached(self) -> None:
        self.in_c.wires.asks = 1

    # --- what C asks

    def _answer(self, question: int, value: int) -> int:
        if question == _Question.EXCHANGES:
            answer = self._wire.exchange()
            return _SILENCE if answer is None else answer
        if question == _Question.LEVEL:
            return self._wire.level()
        if question in (_Question.REQUESTS_TX, _Question.REQUESTS_RX):
            self._requests[question - _Question.REQUESTS_TX].set(bool(value))
        elif question == _Question.SENDS:
            return self._wire.begin()
        elif question == _Question.EDGE:
            return self._wire.edge()
        elif question == _Question.PUTS:
            self._wire.put()
        elif question == _Question.DRIVES:
            self._irq.set(bool(value))
        elif question == _Question.LEFT:
            return self._tx_left()
        elif question == _Question.NOTES:
            self.note(*_NOTES[value])
        else:
            return self._answer_of_pins(question, value)
        return 0

    def _answer_of_pins(self, question: int, value: int) -> int:
        if question == _Question.CLOCK:
            return max(self.services.clocks.pclk(self._bus_clock), 1)
        if question == _Question.LISTENS:
            self._nss_in.on_change = self._nss_changed if value else None
        elif question == _Question.NSS:
            return self._nss_in.level()
        elif question == _Question.IDLES:
            self._wire.idle(bool(value & 1))
            self._nss_out.set(False if value & 2 else None)
        else:
            self._wire.release()
            self._nss_out.set(None)
        return 0

    def _nss_changed(self, level: bool) -> None:
        if not level:
            self.in_c.deselected()


@functools.cache
def _library() -> Any:
    """Return the library, with the functions of these interfaces declared, called with Python's lock held."""
    library: Any = with_lock_held()
    pointer, word = ctypes.c_void_p, ctypes.c_uint32
    library.hil_spi_new.argtypes, library.hil_spi_new.restype = (pointer, _ASK), pointer
    library.hil_spi_wires_of.argtypes, library.hil_spi_wires_of.restype = (pointer,), pointer
    library.hil_spi_exchange.argtypes, library.hil_spi_exchange.restype = (pointer, word), ctypes.c_uint64
    takes: dict[str, tuple[Any, ...]] = {
        "hil_spi_free": (),
        "hil_spi_reset": (),
        "hil_spi_over": (word,),
        "hil_spi_let_go": (),
        "hil_spi_deselected": (),
        "hil_spi_promise": (ctypes.c_char_p, word),
        "hil_spi_take": (pointer,),
        "hil_spi_interrupts": (pointer, word),
        "hil_spi_transfers": (pointer, word, word),
    }
    for name, others in takes.items():
        function = getattr(library, name)
        function.argtypes, function.restype = (pointer, *others), None
    return library
