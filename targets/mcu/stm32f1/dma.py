"""DMA1 and DMA2 (RM0008 section 13), which are in C: ``dma_f1.c``. Here are registers, and who asks for transfers.

DMA2 of high-density devices has five channels; the last two share an interrupt (RM0008 table 63), of the value line
unless AFIO parts them.
"""

from __future__ import annotations

import ctypes
import enum
import functools
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any

from targets.mcu.block import BlockInC, PeripheralInC
from targets.mcu.core.library import with_lock_held
from targets.mcu.errors import BusFault
from targets.mcu.fidelity import Fidelity
from targets.mcu.registers import Register
from targets.mcu.services import RequestInC, Services, drive_in_c

__all__ = [
    "CONTROLLERS",
    "HIGH_VALUE_LINE_CONTROLLERS",
    "MOVED",
    "TRANSFER_CYCLES",
    "VALUE_LINE_CONTROLLERS",
    "Controller",
    "Dma",
    "Request",
]

TRANSFER_CYCLES = 5


@dataclass(frozen=True, slots=True, kw_only=True)
class Controller:
    """What tells one controller from the other.

    Attributes:
        irqs: the interrupts of the channels; those for which there is none have the last one.
        parted: how many interrupts there are when AFIO parts those that share one.
        requests: which requests are connected at which channel.
    """

    irqs: tuple[int, ...]
    parted: int = 0
    requests: Mapping[int, tuple[str, ...]]


CONTROLLERS: Mapping[str, Controller] = MappingProxyType(
    {
        # RM0008 table 78
        "DMA1": Controller(
            irqs=(11, 12, 13, 14, 15, 16, 17),
            requests=MappingProxyType(
                {
                    1: ("ADC1", "TIM2_CH3", "TIM4_CH1"),
                    2: ("SPI1_RX", "USART3_TX", "TIM1_CH1", "TIM2_UP", "TIM3_CH3"),
                    3: ("SPI1_TX", "USART3_RX", "TIM1_CH2", "TIM3_CH4", "TIM3_UP"),
                    4: ("SPI2_RX", "USART1_TX", "I2C2_TX", "TIM1_CH4", "TIM1_TRIG", "TIM1_COM", "TIM4_CH2"),
                    5: ("SPI2_TX", "USART1_RX", "I2C2_RX", "TIM1_UP", "TIM2_CH1", "TIM4_CH3"),
                    6: ("USART2_RX", "I2C1_TX", "TIM1_CH3", "TIM3_CH1", "TIM3_TRIG"),
                    7: ("USART2_TX", "I2C1_RX", "TIM2_CH2", "TIM2_CH4", "TIM4_UP"),
                }
            ),
        ),
        # RM0008 table 79
        "DMA2": Controller(
            irqs=(56, 57, 58, 59),
            requests=MappingProxyType(
                {
                    1: ("SPI3_RX", "TIM5_CH4", "TIM5_TRIG", "TIM8_CH3", "TIM8_UP"),
                    2: ("SPI3_TX", "TIM5_CH3", "TIM5_UP", "TIM8_CH4", "TIM8_TRIG", "TIM8_COM"),
                    3: ("UART4_RX", "TIM6_UP", "DAC_CH1", "TIM8_CH1"),
                    4: ("SDIO", "TIM5_CH2", "TIM7_UP", "DAC_CH2"),
                    5: ("ADC3", "UART4_TX", "TIM5_CH1", "TIM8_CH2"),
                }
            ),
        ),
    }
)
"""The controllers by name."""

MOVED = "_MOVED"
"""Behind the name of a request: where it goes when AFIO moves it."""


def _value_line(moved: str) -> Controller:
    """Return DMA1 of the value line (RM0041 section 9.3.7); `moved`: behind what those of the DAC are called there."""
    usual = CONTROLLERS["DMA1"]
    more = {
        3: (f"TIM6_UP{moved}", f"DAC_CH1{moved}"),
        4: (f"TIM7_UP{moved}", f"DAC_CH2{moved}"),
        5: ("TIM15_CH1", "TIM15_UP", "TIM15_TRIG", "TIM15_COM"),
        6: ("TIM16_CH1", "TIM16_UP", f"TIM1_CH1{MOVED}", f"TIM1_CH2{MOVED}"),
        7: ("TIM17_CH1", "TIM17_UP"),
    }
    requests = {number: (*names, *more.get(number, ())) for number, names in usual.requests.items()}
    return replace(usual, requests=MappingProxyType(requests))


VALUE_LINE_CONTROLLERS: Mapping[str, Controller] = MappingProxyType({"DMA1": _value_line("")})
"""Of the value line up to medium density, which has one."""
HIGH_VALUE_LINE_CONTROLLERS: Mapping[str, Controller] = MappingProxyType(
    {
        "DMA1": _value_line(MOVED),
        "DMA2": Controller(
            irqs=(56, 57, 58, 59),
            parted=5,
            requests=MappingProxyType(
                {
                    1: ("SPI3_RX", "TIM5_CH4", "TIM5_TRIG", "UART5_TX"),
                    2: ("SPI3_TX", "TIM5_CH3", "TIM5_UP"),
                    3: ("UART4_RX", "TIM6_UP", "DAC_CH1"),
                    4: ("TIM5_CH2", "TIM7_UP", "DAC_CH2", "UART5_RX"),
                    5: ("UART4_TX", "TIM5_CH1"),
                }
            ),
        ),
    }
)
"""Of the value line of high density (RM0041 section 9.3.7)."""

ISR, IFCR = 0x00, 0x04
_CCR, _CNDTR, _CPAR, _CMAR = range(0x08, 0x18, 4)
_CHANNEL_SIZE = 0x14

_ASK = ctypes.PYFUNCTYPE(ctypes.c_uint64, ctypes.c_uint32, ctypes.c_uint32, ctypes.c_uint32, ctypes.c_uint32)
_FAILS = (1 << 64) - 1
_REQUEST_BITS = 4
_NOBODY = 0  # a request to channel 0


class _Question(enum.IntEnum):
    """``enum hil_dma_question``."""

    READS = 0
    WRITES = 1
    DRIVES = 2
    NOTES = 3


class _Note(enum.IntEnum):
    """``enum hil_dma_note``."""

    PROTECTED = 0
    UNALIGNED = 1
    ROUND = 2


class Request:
    """One request line; see `targets.mcu.services.DmaRequest`.

    Attributes:
        in_c: the line in C.
    """

    __slots__ = ("_pulse", "_set", "in_c")

    def __init__(self, controller: ctypes.c_void_p, number: int) -> None:
        self.in_c = RequestInC(_library().hil_dma_requests(controller), number)
        self._set: Callable[[bool], None] = functools.partial(_library().hil_dma_request, controller, number)
        self._pulse: Callable[[], None] = functools.partial(_library().hil_dma_pulse, controller, number)

    def set(self, level: bool) -> None:
        """Drive the request."""
        self._set(level)

    def pulse(self) -> None:
        """Ask for one transfer; kept until one was made."""
        self._pulse()


class _Controller(BlockInC):
    """The part in C.

    Args:
        services: what the chip offers.
        base: address of ISR.
        registers: by offset.
        kind: which of the two.
        answer: called with what C asks; a `BusFault` is an answer, too.
    """

    def __init__(
        self,
        services: Services,
        base: int,
        registers: Mapping[int, Register],
        kind: Controller,
        answer: Callable[[int, int, int, int], int],
    ) -> None:
        library = _library()
        self._answer = answer
        self._asked = _ASK(self._ask)
        channels, irqs = len(kind.requests), kind.irqs
        block = library.hil_dma_new(services.time.queue, self._asked, channels, irqs[0], len(irqs))
        super().__init__(services.time, block, library.hil_dma_free, base=base, registers=registers)
        self.reset: Callable[[], None] = functools.partial(library.hil_dma_reset, self.block)
        self.share: Callable[[int], None] = functools.partial(library.hil_dma_share, self.block)
        self.join: Callable[[ctypes.c_void_p], None] = functools.partial(library.hil_dma_join, self.block)

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
        name: ``DMA1`` or ``DMA2``.
        base: address of ISR.
        services: what the chip offers. Used: interrupts 11 to 17, or 56 to 59; the bus.
        kind: its channels; those of `CONTROLLERS` if left out.
    """

    def __init__(self, name: str, base: int, services: Services, kind: Controller | None = None) -> None:
        self.kind = kind = kind or CONTROLLERS[name]
        registers = {register.offset: register for register in self.registers_of()}
        self._controller = self.in_c = _Controller(services, base, registers, kind, self._answer)
        super().__init__(name, base, services)
        self._values = self.in_c.values
        self._bus = services.bus
        first, most = kind.irqs[0], max(kind.parted, len(kind.irqs))
        self._irqs = [services.irq(number) for number in range(first, first + most)]
        core = drive_in_c(self._irqs)
        if core is not None:
            self._controller.join(core)
        self._requests = {
            name: Request(self.in_c.block, number << _REQUEST_BITS | index)
            for number, names in kind.requests.items()
            for index, name in enumerate(names)
        }

    def registers_of(self) -> Iterable[Register]:
        """Return ISR, IFCR and the registers of each channel."""
        yield Register("ISR", ISR, 0, 0)
        yield Register("IFCR", IFCR, 0, (1 << 4 * len(self.kind.requests)) - 1)
        timing = f"a transfer takes {TRANSFER_CYCLES} cycles, and does not slow down the CPU"
        for number in self.kind.requests:
            base = _CHANNEL_SIZE * (number - 1)
            yield Register(f"CCR{number}", base + _CCR, 0, 0x7FFF, fidelity=Fidelity.PARTLY, note=timing)
            yield Register(f"CNDTR{number}", base + _CNDTR, 0, 0xFFFF)
            yield Register(f"CPAR{number}", base + _CPAR)
            yield Register(f"CMAR{number}", base + _CMAR)

    def serves(self, name: str) -> bool:
        """Say whether a channel listens to the request of that name."""
        return any(name in names for names in self.kind.requests.values())

    def request(self, name: str) -> Request:
        """Return the request line of that name; one that no channel listens to goes nowhere."""
        return self._requests.setdefault(name, Request(self.in_c.block, _NOBODY))

    def left(self, name: str) -> int:
        """Return how many transfers the channel of a request has still to make."""
        channel = next(number for number, names in self.kind.requests.items() if name in names)
        return self[_CHANNEL_SIZE * (channel - 1) + _CNDTR]

    def part(self, apart: bool) -> None:
        """Give those channels that share an interrupt one each, or let them share it."""
        if self.kind.parted:
            self._controller.share(self.kind.parted if apart else len(self.kind.irqs))

    def reset(self) -> None:
        """Go to the state after reset."""
        self._controller.reset()

    # --- what C asks

    def _answer(self, question: int, address: int, size: int, value: int) -> int:
        """Answer C; raises BusFault if there is nothing at an address."""
        if question == _Question.READS:
            return self._bus.read(address, size)
        if question == _Question.WRITES:
            self._bus.write(address, size, value)
        elif question == _Question.DRIVES:
            self._irqs[address].set(bool(value))
        else:
            self._note(address, size, _Note(value))
        return 0

    def _note(self, channel: int, register: int, note: _Note) -> None:
        found = self.registers[_CCR + _CHANNEL_SIZE * channel + 4 * register]
        size = (1, 2, 4, 4)[self[_CCR + _CHANNEL_SIZE * channel] >> (8 if register == 2 else 10) & 3]
        text = {
            _Note.PROTECTED: f"written while channel {channel + 1} is enabled: it keeps its value",
            _Note.UNALIGNED: f"not a multiple of {size} bytes: the lowest bits are ignored",
            _Note.ROUND: "MEM2MEM and CIRC may not be set together: the channel stops at the end",
        }[note]
        self.note("misuse", found.name, text)


@functools.cache
def _library() -> Any:
    """Return the library, with the functions of the controller declared, called with Python's lock held."""
    library: Any = with_lock_held()
    pointer, word = ctypes.c_void_p, ctypes.c_uint32
    library.hil_dma_new.argtypes, library.hil_dma_new.restype = (pointer, _ASK, word, word, word), pointer
    library.hil_dma_requests.argtypes, library.hil_dma_requests.restype = (pointer,), pointer
    library.hil_dma_free.argtypes, library.hil_dma_free.restype = (pointer,), None
    library.hil_dma_share.argtypes, library.hil_dma_share.restype = (pointer, word), None
    library.hil_dma_reset.argtypes, library.hil_dma_reset.restype = (pointer,), None
    library.hil_dma_join.argtypes, library.hil_dma_join.restype = (pointer, pointer), None
    library.hil_dma_request.argtypes, library.hil_dma_request.restype = (pointer, word, ctypes.c_bool), None
    library.hil_dma_pulse.argtypes, library.hil_dma_pulse.restype = (pointer, word), None
    return library
