"""A chip in a test tube: everything a peripheral asks for, recorded and driven by hand, to test one model alone.

Whoever writes a peripheral of their own tests it like this:

    chip = FakeChip(hclk_hz=72_000_000, dividers={"APB1": 2})
    timer = chip.add(Timer("TIM2", 0x4000_0000, chip.services))
    poke(timer, "ARR", 99)
    poke(timer, "CR1", 1)
    chip.advance(100)                       # events happen, each at its own cycle
    assert peek(timer, "SR") == 1
    assert chip.irq(28).level
    assert chip.output("TIM2_CH1").edges == [(50, True), (100, False)]

There is no CPU: between two calls of `FakeChip.advance` time stands still.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from typing import TypeVar

from targets.mcu.errors import BusFault
from targets.mcu.fidelity import Notes
from targets.mcu.registers import Peripheral
from targets.mcu.services import InputSignal, Services, Watch, Wave
from targets.mcu.timebase import Timebase

__all__ = ["FakeBus", "FakeChip", "FakeClocks", "FakeInput", "FakeLine", "FakeOutput", "peek", "poke"]

AnyPeripheral = TypeVar("AnyPeripheral", bound=Peripheral)


class FakeLine:
    """An interrupt line or a DMA request that records.

    Attributes:
        level: as last set; low at first.
        changes: every change so far, as (cycle, level).
        on_set: called after every `set`, changed or not; a test may play the DMA controller here.
        pulses: the cycles at which one transfer was asked for.
        on_pulse: called after every `pulse`.
    """

    core = None
    driven_in_c = False
    in_c = None

    def __init__(self, time: Timebase) -> None:
        self.level = False
        self.changes: list[tuple[int, bool]] = []
        self.on_set: Callable[[bool], None] = lambda _level: None
        self.pulses: list[int] = []
        self.on_pulse: Callable[[], None] = lambda: None
        self._time = time

    @property
    def rises(self) -> list[int]:
        """The cycles at which the line went high."""
        return [cycle for cycle, level in self.changes if level]

    def set(self, level: bool) -> None:
        """Drive the line."""
        if level is not self.level:
            self.level = level
            self.changes.append((self._time.now, level))
        self.on_set(level)

    def pulse(self) -> None:
        """Ask for one transfer."""
        self.pulses.append(self._time.now)
        self.on_pulse()


class FakeOutput:
    """An output signal that records.

    Attributes:
        level: as last set; None (released) at first.
        edges: every change so far, as (cycle, level).
        wave: as last set.
        only_low: what `open_drain` answers; True at first.
        refresh: what the peripheral offers.
        on_watch: what the peripheral listens with.
        pass_over: what it offers, if frames come from it.
    """

    def __init__(self, time: Timebase) -> None:
        self.level: bool | None = None
        self.edges: list[tuple[int, bool | None]] = []
        self.wave: Wave | None = None
        self.only_low = True
        self._connected = True
        self.refresh: Callable[[], None] | None = None
        self.on_watch: Callable[[], None] | None = None
        self.pass_over: Callable[[], bool] | None = None
        self._time = time
        self._watch = Watch.LIVE

    @property
    def connected(self) -> bool:
        """What `at_pin` answers; True at first."""
        return self._connected

    @connected.setter
    def connected(self, connected: bool) -> None:
        self._connected = connected
        if self.on_watch is not None:
            self.on_watch()

    def set(self, level: bool | None) -> None:
        """Drive or release the signal from now on."""
        if level is not self.level:
            self.level = level
            self.edges.append((self._time.now, level))

    def set_at(self, cycle: int, level: bool | None) -> None:
        """Drive or release the signal from `cycle` on."""
        assert cycle == self._time.now or (self._watch is not Watch.LIVE and cycle < self._time.now)
        if level is not self.level:
            assert not self.edges or self.edges[-1][0] <= cycle
            self.level = level
            self.edges.append((cycle, level))

    def set_wave(self, wave: Wave | None) -> None:
        """Say what the signal does instead of having edges."""
        self.wave = wave

    def watch(self) -> Watch:
        """Say who looks; LIVE at first."""
        return self._watch

    def set_watch(self, watch: Watch) -> None:
        """Change who looks."""
        self.look()
        self._watch = watch
        if self.on_watch is not None:
            self.on_watch()

    def look(self) -> None:
        """Bring level and edges up to the present cycle, as a reader of a pin does."""
        if self.refresh is not None:
            self.refresh()

    def tell_late(self, catch_up: Callable[[], None], back: InputSignal | None = None) -> bool:  # noqa: ARG002
        """Say that nobody else drives the pin, and no wire is at it."""
        return self._watch is Watch.NOBODY

    def at_pin(self) -> bool:
        """Say whether a pin carries the signal."""
        return self.connected

    def open_drain(self) -> bool:
        """Say whether that pin only pulls low."""
        return self.only_low


class FakeInput:
    """An input signal that a test drives; low at first.

    Attributes:
        on_change, on_reach: what the peripheral listens with.
    """

    def __init__(self) -> None:
        self.on_change: Callable[[bool], None] | None = None
        self.on_reach: Callable[[], None] | None = None
        self._connected = True
        self._level = False
        self._forgets: list[Callable[[], None]] = []

    @property
    def connected(self) -> bool:
        """What `at_pin` answers; True at first."""
        return self._connected

    @connected.setter
    def connected(self, connected: bool) -> None:
        self._connected = connected
        if self.on_reach is not None:
            self.on_reach()

    def level(self) -> bool:
        """Return the present level."""
        return self._level

    def holds(self, forget: Callable[[], None]) -> bool:
        """Say that the level stays until it is driven."""
        self._forgets.append(forget)
        return True

    def at_pin(self) -> bool:
        """Say whether what is outside of a pin can reach the signal."""
        return self._connected

    def drive(self, level: bool) -> None:
        """Set the level from the present cycle on; who listens is told of a change."""
        if level is not self._level:
            self._level = level
            forgets, self._forgets = self._forgets, []
            for forget in forgets:
                forget()
            if self.on_change is not None:
                self.on_change(level)


class FakeClocks:
    """Clock dividers that a test sets; change them through `FakeChip.change_clock`.

    Attributes:
        dividers: HCLK cycles per tick by bus; 0 stands still.
        kernels: HCLK cycles per tick by peripheral; 1 for those that are not in it.
    """

    def __init__(self, dividers: Mapping[str, int]) -> None:
        self.dividers = {"AHB": 1, "APB1": 1, "APB2": 1, **dividers}
        self.kernels: dict[str, Fraction] = {}

    def pclk(self, bus: str) -> int:
        """Return HCLK cycles per tick of the bus clock."""
        return self.dividers[bus]

    def timer(self, bus: str) -> int:
        """Return HCLK cycles per tick of the timers on that bus: the bus clock, doubled if it is divided."""
        divider = self.dividers[bus]
        return divider // 2 if divider > 1 else divider

    def kernel(self, peripheral: str) -> Fraction:
        """Return HCLK cycles per tick of the clock that a peripheral runs on."""
        return self.kernels.get(peripheral, Fraction(1))


class FakeBus:
    """Memory in a dict, byte by byte, and the registers of the peripherals that were attached.

    Attributes:
        memory: byte by address. What is neither here nor in a peripheral raises `BusFault`.
        accesses: every access so far, as ("read" or "write", address, size, value).
    """

    def __init__(self) -> None:
        self.memory: dict[int, int] = {}
        self.accesses: list[tuple[str, int, int, int]] = []
        self._peripherals: list[Peripheral] = []

    def attach(self, peripheral: Peripheral) -> None:
        """Let `peripheral` answer at its addresses."""
        self._peripherals.append(peripheral)

    def load(self, address: int, data: bytes) -> None:
        """Put `data` into memory, where there may have been none."""
        self.memory.update(enumerate(data, address))

    def dump(self, address: int, size: int) -> bytes:
        """Return memory. Raises `BusFault` where there is none."""
        return bytes(self._byte(address + index) for index in range(size))

    def read(self, address: int, size: int) -> int:
        """Read 1, 2 or 4 bytes. Raises `BusFault`."""
        peripheral = self._at(address)
        if peripheral is None:
            value = int.from_bytes(self.dump(address, size), "little")
        else:
            word = peripheral.read((address - peripheral.base) & ~3)
            value = (word >> 8 * (address & 3)) & ((1 << 8 * size) - 1)
        self.accesses.append(("read", address, size, value))
        return value

    def read_words(self, address: int, count: int) -> list[int]:
        """Read words. Raises `BusFault`."""
        return [self.read(address + 4 * index & 0xFFFF_FFFF, 4) for index in range(count)]

    def write_words(self, address: int, words: Sequence[int]) -> None:
        """Write words, up to the first that cannot be written. Raises `BusFault`."""
        for index, word in enumerate(words):
            self.write(address + 4 * index & 0xFFFF_FFFF, 4, word)

    def write(self, address: int, size: int, value: int) -> None:
        """Write 1, 2 or 4 bytes; a register gets a byte or halfword replicated, as over APB. Raises `BusFault`."""
        value &= (1 << 8 * size) - 1
        self.accesses.append(("write", address, size, value))
        peripheral = self._at(address)
        if peripheral is not None:
            replicated = int.from_bytes(value.to_bytes(size, "little") * (4 // size), "little")
            peripheral.write((address - peripheral.base) & ~3, replicated)
            return
        self.dump(address, size)
        self.load(address, value.to_bytes(size, "little"))

    def _byte(self, address: int) -> int:
        if address not in self.memory:
            raise BusFault(address)
        return self.memory[address]

    def _at(self, address: int) -> Peripheral | None:
        for peripheral in self._peripherals:
            if peripheral.base <= address < peripheral.base + peripheral.size:
                return peripheral
        return None


class FakeChip:
    """What a chip offers to its peripherals, and the hands to play the rest of it.

    Args:
        hclk_hz: rate of HCLK.
        dividers: HCLK cycles per tick of ``AHB``, ``APB1`` and ``APB2`` where it is not 1.

    Attributes:
        services: pass this to the peripheral under test.
        time: the cycles and events; real.
        notes: what was noted; real, without a program counter.
        clocks: the dividers.
        bus: the memory.
        resets: the causes of the resets that were asked for, in order.
    """

    def __init__(self, hclk_hz: int | Fraction = 8_000_000, dividers: Mapping[str, int] | None = None) -> None:
        self.time = Timebase(hclk_hz)
        self.notes = Notes(lambda: (self.time.now, self.time.ns(self.time.now)), lambda: None)
        self.clocks = FakeClocks(dividers or {})
        self.bus = FakeBus()
        self.resets: list[str] = []
        self._irqs: dict[int, FakeLine] = {}
        self._dmas: dict[str, FakeLine] = {}
        self._outputs: dict[str, FakeOutput] = {}
        self._inputs: dict[str, FakeInput] = {}
        self._peripherals: list[Peripheral] = []
        self.services = Services(
            time=self.time,
            clocks=self.clocks,
            notes=self.notes,
            irq=self.irq,
            dma=self.dma,
            output=self.output,
            input=self.input,
            bus=self.bus,
            chip_reset=self.resets.append,
        )

    def add(self, peripheral: AnyPeripheral) -> AnyPeripheral:
        """Make `peripheral` part of the chip: it is told of changes of the clock and answers on the bus."""
        self._peripherals.append(peripheral)
        self.bus.attach(peripheral)
        return peripheral

    def irq(self, number: int) -> FakeLine:
        """Return the interrupt line of that number."""
        return self._irqs.setdefault(number, FakeLine(self.time))

    def dma(self, name: str) -> FakeLine:
        """Return the DMA request of that name."""
        return self._dmas.setdefault(name, FakeLine(self.time))

    def output(self, name: str) -> FakeOutput:
        """Return the output signal of that name; at one inside the chip, as ``TIM2_CC1``, nobody looks at first."""
        signal = self._outputs.get(name)
        if signal is None:
            signal = self._outputs[name] = FakeOutput(self.time)
            if "_CC" in name:
                signal.set_watch(Watch.NOBODY)
        return signal

    def input(self, name: str) -> FakeInput:
        """Return the input signal of that name."""
        return self._inputs.setdefault(name, FakeInput())

    def noted(self, kind: str | None = None) -> list[str]:
        """Return where something was noted (such as ``USART1_CR3``), all of it or what is of one kind."""
        return [note.where for note in self.notes.all if kind is None or note.kind == kind]

    # --- time

    def advance(self, cycles: int) -> None:
        """Let cycles pass; every event happens at its own cycle."""
        self.advance_to(self.time.now + cycles)

    def advance_to(self, cycle: int | Fraction) -> None:
        """Let time pass until `cycle`; of one that is not whole, the last before it."""
        self.time.run_due(int(cycle))

    def advance_s(self, seconds: Fraction) -> None:
        """Let bench time pass, also while the rate of HCLK changes on the way; ends at the first cycle not before."""
        end_s = self.time.seconds(self.time.now) + seconds
        while (cycle := self.time.cycle_at(end_s)) > self.time.now:
            due = self.time.next_cycle()
            self.time.run_due(cycle if due is None else min(cycle, due))

    def change_clock(self, hclk_hz: int | Fraction | None = None, **dividers: int) -> None:
        """Change the rate of HCLK or of a bus, with the peripherals told before and after: ``change_clock(APB1=2)``."""
        for peripheral in self._peripherals:
            peripheral.before_clock_change()
        if hclk_hz is not None:
            self.time.set_hclk(Fraction(hclk_hz))
        self.clocks.dividers.update(dividers)
        for peripheral in self._peripherals:
            peripheral.after_clock_change()


def peek(peripheral: Peripheral, register: str) -> int:
    """Read a register by name, with its side effects; the clock gate is not asked."""
    return peripheral.read(_offset(peripheral, register))


def poke(peripheral: Peripheral, register: str, value: int) -> None:
    """Write a register by name, with its effects; the clock gate is not asked."""
    peripheral.write(_offset(peripheral, register), value)


def _offset(peripheral: Peripheral, name: str) -> int:
    for offset, register in peripheral.registers.items():
        if register.name == name:
            return offset
    raise KeyError(f"{peripheral.name} has no register {name}")
