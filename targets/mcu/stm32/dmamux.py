"""The multiplexer between requests and DMA streams (RM0433 section 17, on the STM32H7; G0, G4 and L4+ have the like).

Each channel leads one request to one stream; which one, it says in DMAREQ_ID. Synchronization (SE) and the request
generators are not modelled: a synchronized channel lets requests through at once, and a generator never asks.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial

from targets.mcu.fidelity import Fidelity
from targets.mcu.registers import Peripheral, Register
from targets.mcu.services import Services
from targets.mcu.stm32.dma_requests import Request, Requests

__all__ = ["DmaMux", "Outlets"]

GENERATORS = 8
CSR, CFR, RG0CR, RGSR, RGCFR = 0x80, 0x84, 0x100, 0x140, 0x144
REQUEST_ID = 0x7F
SOIE, EGE, SE = 1 << 8, 1 << 9, 1 << 16
_GENERATOR_IDS = range(1, 1 + GENERATORS)
_SYNCHRONIZED = "requests pass at once: synchronization and the events of channels (SE, EGE, SOIE) are not modelled"
_GENERATED = "the request generators are not modelled: they never ask"


class DmaMux(Peripheral):
    """A multiplexer.

    Args:
        name: ``DMAMUX1``.
        base: address of C0CR.
        services: what the chip offers.
        requests: all request lines of the chip.
        names: the request by DMAREQ_ID.
        channels: how many channels there are.

    Attributes:
        requests: as given.
    """

    def __init__(
        self,
        name: str,
        base: int,
        services: Services,
        *,
        requests: Requests,
        names: Mapping[int, str],
        channels: int,
    ) -> None:
        self._count = channels
        super().__init__(name, base, services)
        self.requests = requests
        self._lines = {number: requests.line(of_number) for number, of_number in names.items()}
        self._outlets: list[Sequence[Request]] = [()] * channels
        self._listeners: list[Callable[[], None]] = [lambda: None] * channels
        for channel in range(channels):
            self._writers[4 * channel] = partial(self._write_control, channel)

    def registers_of(self) -> Iterable[Register]:
        """Return a register for each channel and generator, and the flags, which are never set."""
        for channel in range(self._count):
            yield Register(
                f"C{channel}CR",
                4 * channel,
                writable=0x07FF_037F,
                ignored=SOIE | EGE | SE,
                fidelity=Fidelity.PARTLY,
                note=_SYNCHRONIZED,
            )
        yield Register("CSR", CSR, 0, 0, fidelity=Fidelity.PARTLY, note=_SYNCHRONIZED)
        yield Register("CFR", CFR, 0, (1 << self._count) - 1)
        generators = [(f"RG{number}CR", RG0CR + 4 * number, 0x00FF_0107) for number in range(GENERATORS)]
        for name, offset, writable in (*generators, ("RGSR", RGSR, 0), ("RGCFR", RGCFR, (1 << GENERATORS) - 1)):
            yield Register(name, offset, writable=writable, fidelity=Fidelity.ABSENT, note=_GENERATED)

    def reset(self) -> None:
        """Go to the state after reset: nothing leads anywhere."""
        super().reset()
        for channel in range(self._count):
            self._lead(channel, 0)

    def read_CFR(self) -> int:
        """Return 0: the register can only be written."""
        return 0

    def write_CFR(self, _value: int) -> None:
        """Clear flags, of which none is ever set."""

    def _write_control(self, channel: int, value: int) -> None:
        changed = (value ^ self[4 * channel]) & REQUEST_ID
        self[4 * channel] = value
        if not changed:
            return
        number = value & REQUEST_ID
        if number in _GENERATOR_IDS:
            self.note("unmodelled", f"C{channel}CR.DMAREQ_ID", _GENERATED)
        elif number and number not in self._lines:
            self.note("reserved", f"C{channel}CR.DMAREQ_ID", f"no request has the number {number}: nothing ever asks")
        self._lead(channel, number)

    # --- between requests and streams

    def connect(self, channel: int, on_change: Callable[[], None]) -> None:
        """Call `on_change` when a channel leads another request to its stream."""
        self._listeners[channel] = on_change

    def outlet(self, channel: int) -> Sequence[Request]:
        """Return what a channel leads on: one request or none."""
        return self._outlets[channel]

    def _lead(self, channel: int, number: int) -> None:
        line = self._lines.get(number)
        self._outlets[channel] = () if line is None else (line,)
        self._listeners[channel]()


class Outlets:
    """The channels that lead to the streams of one controller; see `dma_requests.Sources`.

    Args:
        mux: the multiplexer.
        first: the channel that leads to stream 0.
    """

    def __init__(self, mux: DmaMux, first: int) -> None:
        self._mux = mux
        self._first = first

    @property
    def requests(self) -> Requests:
        """All lines of the chip."""
        return self._mux.requests

    def connect(self, stream: int, on_change: Callable[[], None]) -> None:
        """Call `on_change` when another request leads to a stream."""
        self._mux.connect(self._first + stream, on_change)

    def selected(self, stream: int, _channel: int) -> Sequence[Request]:
        """Return what leads to the stream; there is no CHSEL."""
        return self._mux.outlet(self._first + stream)
