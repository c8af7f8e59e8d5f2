"""A DMA controller with eight streams, as in the STM32F2, F4, F7 and H7 (RM0410 section 8).

What a stream does stands in `dma_stream`, who comes first in `dma_port`. Choices where the manual is silent:

* An access takes five AHB cycles at the peripheral port and four at the memory port, whatever is accessed, and one more
  for each further beat of a burst (AN4031 names the steps: arbitration, address, bus matrix, data). The CPU is not
  slowed down by it.
* A stream that is enabled while flags of it are set runs all the same; it is noted.
* A write of the protected bits of an enabled stream leaves them as they are, which is noted unless it clears EN too.
* A stream that is disabled ends an access under way without a trace, and then stores what is in its FIFO.
* Memory to memory in a controller that cannot is a transfer error. PSIZE and MSIZE of 3 are taken for 32 bits.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import partial

from targets.mcu.errors import BusFault
from targets.mcu.fidelity import Fidelity
from targets.mcu.registers import Peripheral, Register
from targets.mcu.services import BusMaster, Services
from targets.mcu.stm32.dma_port import Port
from targets.mcu.stm32.dma_requests import Sources
from targets.mcu.stm32.dma_shortcut import pass_unseen
from targets.mcu.stm32.dma_slot import (
    CR,
    ENABLES,
    FCR,
    FEIE,
    FEIF,
    M0AR,
    M1AR,
    NDTR,
    PAR,
    STREAM_SIZE,
    TCIF,
    TEIF,
    Slot,
)
from targets.mcu.stm32.dma_stream import Direction, Setting, Stream

__all__ = ["MEMORY_CYCLES", "PERIPHERAL_CYCLES", "Dma"]

PERIPHERAL_CYCLES = 5
MEMORY_CYCLES = 4
STREAMS = 8

LISR, HISR, LIFCR, HIFCR = range(0x00, 0x10, 4)
_SHIFTS = (0, 6, 16, 22)
_FLAGS = 0x3D
_ALL_FLAGS = 0x0F7D_0F7D

EN = 1 << 0
PFCTRL, CIRC = 1 << 5, 1 << 8
_PSIZE, _MSIZE, _PL, _CHSEL = 11, 13, 16, 25
DBM, CT = 1 << 18, 1 << 19
_BURSTS = 0xF << 21
DMDIS = 1 << 2


class Dma(Peripheral):
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
    ) -> None:
        self._control_bits = control_bits
        super().__init__(name, base, services)
        self._bus = services.bus if memory is None else memory
        self._sources = sources
        self._between_memories = between_memories
        self._slots = [Slot(number, self, services.irq(irqs[number])) for number in range(STREAMS)]
        self._peripheral_port = self._port(PERIPHERAL_CYCLES, self._serve_peripheral)
        self._memory_port = self._port(MEMORY_CYCLES, self._serve_memory)
        self._ports = (self._peripheral_port, self._memory_port)
        for slot in self._slots:
            self._connect(slot)

    def _port(self, cycles: int, serve: Callable[[int], int]) -> Port:
        return Port(self.time, partial(self.services.clocks.pclk, "AHB"), cycles, self._priority, serve)

    def _connect(self, slot: Slot) -> None:
        self._sources.connect(slot.number, slot)
        self._writers[slot.base] = partial(self._write_control, slot)
        self._readers[slot.base + 0x04] = partial(self._read_count, slot)
        self._writers[slot.base + 0x04] = partial(self._write_count, slot)
        for offset in (0x08, 0x0C, 0x10):
            self._writers[slot.base + offset] = partial(self._write_address, slot, offset)
        self._readers[slot.base + 0x14] = partial(self._read_fifo, slot)
        self._writers[slot.base + 0x14] = partial(self._write_fifo, slot)

    def registers_of(self) -> Iterable[Register]:
        """Return the flags and the registers of each stream."""
        yield Register("LISR", LISR, 0, 0)
        yield Register("HISR", HISR, 0, 0)
        yield Register("LIFCR", LIFCR, 0, _ALL_FLAGS)
        yield Register("HIFCR", HIFCR, 0, _ALL_FLAGS)
        timing = "the CPU is not slowed down, and no overrun or underrun of the FIFO is flagged"
        for number in range(STREAMS):
            base = STREAM_SIZE * number
            yield Register(f"S{number}CR", base + CR, 0, self._control_bits, fidelity=Fidelity.PARTLY, note=timing)
            yield Register(f"S{number}NDTR", base + NDTR, 0, 0xFFFF)
            yield Register(f"S{number}PAR", base + PAR)
            yield Register(f"S{number}M0AR", base + M0AR)
            yield Register(f"S{number}M1AR", base + M1AR)
            yield Register(f"S{number}FCR", base + FCR, 0x21, 0x87)

    def reset(self) -> None:
        """Go to the state after reset."""
        super().reset()
        self._peripheral_port.reset()
        self._memory_port.reset()
        for slot in self._slots:
            slot.clear()

    # --- flags

    def read_LISR(self) -> int:
        """Return the flags of streams 0 to 3."""
        return self._word_of_flags(0)

    def read_HISR(self) -> int:
        """Return the flags of streams 4 to 7."""
        return self._word_of_flags(4)

    def read_LIFCR(self) -> int:
        """Return 0: the register can only be written."""
        return 0

    def read_HIFCR(self) -> int:
        """Return 0: the register can only be written."""
        return 0

    def write_LIFCR(self, value: int) -> None:
        """Clear flags of streams 0 to 3."""
        self._clear_flags(0, value)

    def write_HIFCR(self, value: int) -> None:
        """Clear flags of streams 4 to 7."""
        self._clear_flags(4, value)

    def _word_of_flags(self, first: int) -> int:
        return sum(slot.flags << shift for slot, shift in zip(self._slots[first : first + 4], _SHIFTS, strict=True))

    def _clear_flags(self, first: int, value: int) -> None:
        for slot, shift in zip(self._slots[first : first + 4], _SHIFTS, strict=True):
            slot.flags &= ~(value >> shift)
            slot.drive_irq()

    # --- registers of a stream

    def _write_control(self, slot: Slot, value: int) -> None:
        before = self[slot.base]
        if not before & EN:
            self[slot.base] = value
            if value & EN:
                self._start(slot)
        else:
            protected = ~(ENABLES | EN)
            if (before ^ value) & protected & ~CT and value & EN:
                self._note_protected(slot, "CR")
            self[slot.base] = before & ~ENABLES | value & ENABLES
            if not value & EN:
                self.close(slot)
        slot.drive_irq()

    def _read_count(self, slot: Slot) -> int:
        return self[slot.base + 0x04] if slot.stream is None else slot.stream.left

    def _write_count(self, slot: Slot, value: int) -> None:
        if slot.control & EN:
            self._note_protected(slot, "NDTR")
        else:
            self[slot.base + 0x04] = slot.reload = value

    def _write_address(self, slot: Slot, offset: int, value: int) -> None:
        """PAR, M0AR and M1AR; in double-buffer mode that of the buffer that is not in use may change at any time."""
        control = slot.control
        if control & EN:
            in_use = 0x10 if control & CT else 0x0C
            if offset == 0x08 or not control & DBM:
                self._note_protected(slot, {0x08: "PAR", 0x0C: "M0AR", 0x10: "M1AR"}[offset])
                return
            if offset == in_use:
                self.fail(slot)
                return
        self[slot.base + offset] = value

    def _read_fifo(self, slot: Slot) -> int:
        level = 0 if slot.stream is None else slot.stream.level
        status = 4 if level == 0 else 5 if level == 16 else level // 4
        return slot.fcr & ~0x38 | status << 3

    def _write_fifo(self, slot: Slot, value: int) -> None:
        before = slot.fcr
        if slot.control & EN and (before ^ value) & (DMDIS | 3):
            self._note_protected(slot, "FCR")
            value = before & ~FEIE | value & FEIE
        self[slot.base + 0x14] = value
        slot.drive_irq()

    def _note_protected(self, slot: Slot, register: str) -> None:
        text = f"written while stream {slot.number} is enabled: what is protected keeps its value"
        self.note("misuse", f"S{slot.number}{register}", text)

    # --- from EN to the end

    def _start(self, slot: Slot) -> None:
        self[slot.base] = control = _forced(slot.control, slot.fcr)
        setting = Setting.of(control, slot.fcr)
        between = setting.direction is Direction.MEMORY_TO_MEMORY
        if between:
            self[slot.base + 0x14] |= DMDIS
        self._check(slot, setting)
        if not setting.burst_fits:
            self.fail(slot, FEIF)
        elif between and not self._between_memories:
            self.note("misuse", f"S{slot.number}CR.DIR", f"{self.name} cannot go from memory to memory")
            self.fail(slot)
        else:
            self._run(slot, setting)

    def _run(self, slot: Slot, setting: Setting) -> None:
        count = self[slot.base + 0x04] or slot.reload
        if count or setting.by_peripheral:
            slot.selected = self._sources.selected(slot.number, slot.control >> _CHSEL & 0xF)
            peripheral, memory = self[slot.base + 0x08], self._memory_of(slot)
            slot.stream = Stream(self._bus, setting, count=count, peripheral=peripheral, memory=memory)
            self.look(slot)

    def _check(self, slot: Slot, setting: Setting) -> None:
        if slot.flags:
            text = "flags of the stream are still set: clear them before EN"
            self.note("misuse", f"S{slot.number}CR.EN", text)
        sizes = {"PAR": setting.peripheral_size, "M0AR": setting.memory_size}
        for (register, size), offset in zip(sizes.items(), (0x08, 0x0C), strict=True):
            if self[slot.base + offset] & size - 1:
                text = f"not a multiple of {size} bytes: the lowest bits are ignored"
                self.note("misuse", f"S{slot.number}{register}", text)

    def _memory_of(self, slot: Slot) -> int:
        second = slot.control & DBM and slot.control & CT
        return self[slot.base + (0x10 if second else 0x0C)]

    def close(self, slot: Slot) -> None:
        """End a stream that is enabled: what is in its FIFO is stored first, if it comes from the peripheral."""
        if slot.stream is None:
            self[slot.base] &= ~EN
            return
        slot.stream.closing = True
        self._advance(slot)

    def fail(self, slot: Slot, flag: int = TEIF) -> None:
        """End a stream with an error."""
        self._stop(slot)
        slot.flag(flag)

    def _stop(self, slot: Slot) -> None:
        if slot.stream is not None:
            self[slot.base + 0x04] = slot.stream.left
            slot.stream = None
        self[slot.base] &= ~EN
        self.look(slot)

    # --- accesses

    def look(self, slot: Slot) -> None:
        """See what the stream wants, after anything has changed."""
        stream = slot.stream if self.clocked else None
        if stream is None:
            self._peripheral_port.ask(slot.number, False)
            self._memory_port.ask(slot.number, False)
            return
        asked = False
        for request in slot.selected:
            asked = asked or request.level or request.once
        if asked and self._pass_unseen(slot, stream):
            return
        self._peripheral_port.ask(slot.number, stream.wants_peripheral(asked))
        self._memory_port.ask(slot.number, stream.wants_memory())

    def _pass_unseen(self, slot: Slot, stream: Stream) -> bool:
        slot.in_access = True
        try:
            return pass_unseen(self.time, self._ports, slot.selected, stream, fail=slot.fail_access, look=slot.look)
        finally:
            slot.in_access = False

    def _priority(self, number: int) -> tuple[int, int]:
        return self._slots[number].control >> _PL & 3, -number

    def _serve_peripheral(self, number: int) -> int:
        slot = self._slots[number]
        stream, selected = slot.stream, slot.selected
        for request in selected:
            request.once = False
        last = stream is not None and stream.ends_with_next
        beats = self._serve(slot, memory=False)
        for request in selected if last else ():
            if request.on_last is not None:
                request.on_last()
        return beats

    def _serve_memory(self, number: int) -> int:
        return self._serve(self._slots[number], memory=True)

    def _serve(self, slot: Slot, *, memory: bool) -> int:
        stream = slot.stream
        assert stream is not None
        slot.in_access = True
        try:
            beats = stream.access_memory() if memory else stream.access_peripheral()
        except BusFault:
            self.fail(slot)
            return 1
        finally:
            slot.in_access = False
        self._advance(slot)
        return beats

    def _advance(self, slot: Slot) -> None:
        """Take over what the stream has done, and begin or end a round."""
        stream = slot.stream
        assert stream is not None
        flags, stream.flags = stream.flags, 0
        if stream.done:
            flags |= TCIF
            if stream.setting.circular and not stream.closing:
                self[slot.base] ^= CT if stream.setting.double else 0
                stream.restart(self[slot.base + 0x08], self._memory_of(slot))
            else:
                self._stop(slot)
        self.look(slot)
        if flags:
            slot.flag(flags)


def _forced(control: int, fcr: int) -> int:
    """Return CR as hardware sets it when EN is set (RM0410 section 8.5.5)."""
    between = control >> 6 & 3 >= 2
    if not fcr & DMDIS and not between:
        control = control & ~(_BURSTS | 3 << _MSIZE) | (control >> _PSIZE & 3) << _MSIZE
    if between:
        control &= ~(PFCTRL | CIRC)
    elif control & PFCTRL:
        control &= ~CIRC
    elif control & DBM:
        control |= CIRC
    return control
