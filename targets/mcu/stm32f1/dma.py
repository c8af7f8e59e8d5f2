"""DMA1: seven channels between registers and memory (RM0008 section 13).

One transfer at a time. It begins when a channel asks and nothing is under way, and its read and its write happen at its
end. Among the channels that asked by the beginning, the highest priority wins, then the lowest number.

Choices where the manual is silent:

* A transfer takes five AHB cycles, whatever the widths: arbitration, address, read, write, acknowledge (section 13.3.1
  names these steps). The CPU is not slowed down by it.
* A channel that is enabled begins at CPAR and CMAR. If CNDTR was not written, it goes on with what is left of it, and
  circular mode reloads what was written last.
* HTIF is set when CNDTR reaches half of its initial value, rounded down.
* GIF is set while any other flag of the channel is.
* A transfer under way is dropped, without a trace, when its channel is disabled.
* CCR may be changed while the channel is enabled; CNDTR, CPAR and CMAR keep their value then, which is noted.
* PSIZE and MSIZE of 3 are reserved and taken for 32 bits.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial

from targets.mcu.errors import BusFault
from targets.mcu.fidelity import Fidelity
from targets.mcu.registers import Peripheral, Register
from targets.mcu.services import IrqLine, Services
from targets.mcu.timebase import Event

__all__ = ["REQUESTS", "TRANSFER_CYCLES", "Dma", "Request"]

TRANSFER_CYCLES = 5
FIRST_IRQ = 11

REQUESTS = {
    1: ("ADC1", "TIM2_CH3", "TIM4_CH1"),
    2: ("SPI1_RX", "USART3_TX", "TIM1_CH1", "TIM2_UP", "TIM3_CH3"),
    3: ("SPI1_TX", "USART3_RX", "TIM1_CH2", "TIM3_CH4", "TIM3_UP"),
    4: ("SPI2_RX", "USART1_TX", "I2C2_TX", "TIM1_CH4", "TIM1_TRIG", "TIM1_COM", "TIM4_CH2"),
    5: ("SPI2_TX", "USART1_RX", "I2C2_RX", "TIM1_UP", "TIM2_CH1", "TIM4_CH3"),
    6: ("USART2_RX", "I2C1_TX", "TIM1_CH3", "TIM3_CH1", "TIM3_TRIG"),
    7: ("USART2_TX", "I2C1_RX", "TIM2_CH2", "TIM2_CH4", "TIM4_UP"),
}
"""Which requests are tied together at which channel (RM0008 table 78)."""

ISR, IFCR = 0x00, 0x04
_CCR, _CNDTR, _CPAR, _CMAR = range(0x08, 0x18, 4)
_CHANNEL_SIZE = 0x14

EN, TCIE, HTIE, TEIE, DIR, CIRC, PINC, MINC = (1 << bit for bit in range(8))
_PSIZE, _MSIZE, _PL = 8, 10, 12
MEM2MEM = 1 << 14

GIF, TCIF, HTIF, TEIF = (1 << bit for bit in range(4))
_SIZES = (1, 2, 4, 4)


class Request:
    """One request line; see `targets.mcu.services.DmaRequest`.

    Args:
        channel: whom it asks; None if the chip does not connect it.
    """

    __slots__ = ("_channel", "level", "once", "private")

    def __init__(self, channel: _Channel | None) -> None:
        self.private = False
        self._channel = channel
        self.level = False
        self.once = False

    def set(self, level: bool) -> None:
        """Drive the request."""
        self.level = level
        self.once = self.once and level
        if self._channel is not None:
            self._channel.update()

    def pulse(self) -> None:
        """Ask for one transfer; kept until one was made."""
        self.once = True
        if self._channel is not None:
            self._channel.update()


class _Channel:
    """The part of a channel that is not a register.

    Attributes:
        number: 1 to 7.
        base: offset of its CCR.
        requests: what may ask.
        flags: TCIF, HTIF and TEIF, at the bits they have for channel 1.
        reload: CNDTR as it was written last.
        ready: it wants a transfer, and
        ready_since: from this cycle on.
        peripheral, memory: the addresses of the next transfer.
    """

    def __init__(self, number: int, controller: Dma, irq: IrqLine) -> None:
        self.number = number
        self.base = _CCR + _CHANNEL_SIZE * (number - 1)
        self.requests = {name: Request(self) for name in REQUESTS[number]}
        self._controller = controller
        self._irq = irq
        self._irq_level = False
        self.clear()

    def clear(self) -> None:
        """Go to the state after reset; requests are not ours."""
        self.flags = 0
        self.reload = 0
        self.ready = False
        self.ready_since = 0
        self.peripheral = 0
        self.memory = 0

    @property
    def control(self) -> int:
        """CCR."""
        return self._controller[self.base]

    @property
    def left(self) -> int:
        """CNDTR."""
        return self._controller[self.base + 4]

    def update(self) -> None:
        """See whether it wants a transfer, after registers or requests have changed."""
        ready = self._wants()
        if ready is self.ready:
            return
        self.ready = ready
        if ready:
            self.ready_since = self._controller.time.now
            self._controller.proceed()
        else:
            self._controller.reconsider()

    def _wants(self) -> bool:
        control = self.control
        if not control & EN or not self.left:
            return False
        return bool(control & MEM2MEM) or any(request.level or request.once for request in self.requests.values())

    def acknowledge(self) -> None:
        """Tell the requests that a transfer was made."""
        for request in self.requests.values():
            request.once = False

    def start(self) -> None:
        """Begin at the addresses in the registers."""
        self.peripheral = self._controller[self.base + 8]
        self.memory = self._controller[self.base + 12]

    def flag(self, flags: int) -> None:
        """Set flags."""
        self.flags |= flags
        self.drive_irq()

    def drive_irq(self) -> None:
        """Drive the interrupt from flags and enables: TCIE, HTIE and TEIE stand at the bits of their flags."""
        level = bool(self.flags & self.control & (TCIE | HTIE | TEIE))
        if level is not self._irq_level:
            self._irq_level = level
            self._irq.set(level)


class Dma(Peripheral):
    """A DMA controller.

    Args:
        name: ``DMA1``.
        base: address of ISR.
        services: what the chip offers. Used: interrupts 11 to 17, the bus.
    """

    def __init__(self, name: str, base: int, services: Services) -> None:
        super().__init__(name, base, services)
        self._bus = services.bus
        self._channels = [_Channel(number, self, services.irq(FIRST_IRQ + number - 1)) for number in REQUESTS]
        self._requests = {name: request for channel in self._channels for name, request in channel.requests.items()}
        self._event: Event | None = None
        self._begun = 0
        self._serving = False
        for channel in self._channels:
            self._writers[channel.base] = partial(self._write_control, channel)
            self._writers[channel.base + 4] = partial(self._write_count, channel)
            self._writers[channel.base + 8] = partial(self._write_address, channel, channel.base + 8)
            self._writers[channel.base + 12] = partial(self._write_address, channel, channel.base + 12)

    def registers_of(self) -> Iterable[Register]:
        """Return ISR, IFCR and the registers of each channel."""
        yield Register("ISR", ISR, 0, 0)
        yield Register("IFCR", IFCR, 0, 0x0FFF_FFFF)
        timing = f"a transfer takes {TRANSFER_CYCLES} cycles, and does not slow down the CPU"
        for number in REQUESTS:
            base = _CHANNEL_SIZE * (number - 1)
            yield Register(f"CCR{number}", base + _CCR, 0, 0x7FFF, fidelity=Fidelity.PARTLY, note=timing)
            yield Register(f"CNDTR{number}", base + _CNDTR, 0, 0xFFFF)
            yield Register(f"CPAR{number}", base + _CPAR)
            yield Register(f"CMAR{number}", base + _CMAR)

    def request(self, name: str) -> Request:
        """Return the request line of that name; one that no channel listens to goes nowhere."""
        return self._requests.setdefault(name, Request(None))

    def reset(self) -> None:
        """Go to the state after reset."""
        super().reset()
        self.time.cancel(self._event)
        self._event = None
        for channel in self._channels:
            channel.clear()
            channel.drive_irq()

    # --- registers

    def read_ISR(self) -> int:
        """Return the flags of all channels."""
        word = 0
        for channel in self._channels:
            if channel.flags:
                word |= (channel.flags | GIF) << 4 * (channel.number - 1)
        return word

    def read_IFCR(self) -> int:
        """Return 0: the register can only be written."""
        return 0

    def write_IFCR(self, value: int) -> None:
        """Clear flags; CGIF clears all of a channel."""
        for channel in self._channels:
            bits = value >> 4 * (channel.number - 1) & 0xF
            if bits:
                channel.flags &= 0 if bits & GIF else ~bits
                channel.drive_irq()

    def _write_control(self, channel: _Channel, value: int) -> None:
        starts = value & EN and not self[channel.base] & EN
        self[channel.base] = value
        if starts:
            self._check(channel, value)
            channel.start()
        channel.drive_irq()
        channel.update()

    def _write_count(self, channel: _Channel, value: int) -> None:
        if self._may_write(channel, f"CNDTR{channel.number}"):
            self[channel.base + 4] = channel.reload = value

    def _write_address(self, channel: _Channel, offset: int, value: int) -> None:
        if self._may_write(channel, self.registers[offset].name):
            self[offset] = value

    def _may_write(self, channel: _Channel, register: str) -> bool:
        if channel.control & EN:
            self.note("misuse", register, f"written while channel {channel.number} is enabled: it keeps its value")
            return False
        return True

    def _check(self, channel: _Channel, control: int) -> None:
        for offset, shift in ((8, _PSIZE), (12, _MSIZE)):
            size = _SIZES[control >> shift & 3]
            if self[channel.base + offset] & size - 1:
                name = self.registers[channel.base + offset].name
                self.note("misuse", name, f"not a multiple of {size} bytes: the lowest bits are ignored")
        if control & MEM2MEM and control & CIRC:
            name = f"CCR{channel.number}"
            self.note("misuse", name, "MEM2MEM and CIRC may not be set together: the channel stops at the end")

    # --- transfers

    def proceed(self) -> None:
        """Begin a transfer, if none is under way and a channel wants one."""
        if (
            self._event is None
            and not self._serving
            and self.clocked
            and any(channel.ready for channel in self._channels)
        ):
            self._begun = self.time.now
            self._event = self.time.after(TRANSFER_CYCLES, self._transfer)

    def reconsider(self) -> None:
        """Do not begin a transfer at this very cycle that nobody wants any more."""
        if self._begun == self.time.now and not any(channel.ready for channel in self._channels):
            self.time.cancel(self._event)
            self._event = None

    def _transfer(self) -> None:
        self._event = None
        if not self.clocked:
            return
        asking = [channel for channel in self._channels if channel.ready and channel.ready_since <= self._begun]
        if asking:
            # The first of equal priority is the one with the lowest number.
            channel = max(asking, key=lambda one: one.control >> _PL & 3)
            channel.ready = False
            self._serving = True
            self._serve(channel)
            self._serving = False
            channel.update()
        self.proceed()

    def _serve(self, channel: _Channel) -> None:
        control = channel.control
        peripheral_size, memory_size = _SIZES[control >> _PSIZE & 3], _SIZES[control >> _MSIZE & 3]
        peripheral, memory = channel.peripheral & -peripheral_size, channel.memory & -memory_size
        channel.acknowledge()
        try:
            if control & DIR:
                self._move(memory, memory_size, peripheral, peripheral_size)
            else:
                self._move(peripheral, peripheral_size, memory, memory_size)
        except BusFault:
            self[channel.base] = control & ~EN
            channel.flag(TEIF)
            return
        if control & PINC:
            channel.peripheral += peripheral_size
        if control & MINC:
            channel.memory += memory_size
        self._count(channel, control)

    def _move(self, source: int, source_size: int, target: int, target_size: int) -> None:
        """Copy one item: it is filled with zeros if the target is wider, cut if it is narrower (RM0008 table 77)."""
        value = self._bus.read(source, source_size)
        self._bus.write(target, target_size, value & (1 << 8 * target_size) - 1)

    def _count(self, channel: _Channel, control: int) -> None:
        left = channel.left - 1
        flags = HTIF if left == channel.reload >> 1 else 0
        if left == 0:
            flags |= TCIF
            if control & CIRC and not control & MEM2MEM:
                left = channel.reload
                channel.start()
        self[channel.base + 4] = left
        if flags:
            channel.flag(flags)
