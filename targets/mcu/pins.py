"""The pins of a chip: what the chip drives, what the outside drives, the level that results, and its edges.

A pin has at most one strong driver in the chip (a push-pull output, or an open-drain output that is low), perhaps a
pull resistor in the chip, and any number of sources outside: whoever calls `Pin.drive`, and the other pins of its nets.
A converter to analog that puts out a voltage there is one more source, and stands in the place of the pull; beside a
strong driver it does not count.

How the level comes about, in this order:

* Strong sources (below 1 kOhm) decide. Two that contradict each other are noted as contention; the pin then reads low
  (choice: the N-channel transistor is usually the stronger one).
* Otherwise the resistors form a divider, and the Schmitt trigger of the input decides (DS5319 section 5.3.14): below
  VIL low, above VIH high, in between the level stays as it was (low if there was none).
* Otherwise the pin floats: its level is None, and it reads as low (choice: repeatable, where silicon is not).

A peripheral that makes many edges by itself need not tell of each while nobody looks, see
`targets.mcu.services.OutputSignal`. Whoever reads a level or takes a record here gets it up to the present cycle.
"""

from __future__ import annotations

import enum
from collections.abc import Callable, Hashable, Iterable, Iterator
from typing import TYPE_CHECKING, NamedTuple

from targets.mcu.errors import BoardError
from targets.mcu.fidelity import Notes
from targets.mcu.services import Watch, Wave
from targets.mcu.timebase import Timebase

if TYPE_CHECKING:
    from targets.mcu.nets import Net
    from targets.mcu.signals import PinInput, PinOutput

__all__ = ["NEVER", "AnySource", "Bank", "Edge", "PadMode", "Pin", "Pins", "Source"]

PULL_OHMS = 40_000.0
"""Pull-up and pull-down in the chip: 30 to 50 kOhm, typically 40 (DS5319 section 5.3.14)."""
DRIVER_OHMS = 50.0
"""A push-pull output: VOL is at most 0.4 V at 8 mA (DS5319 section 5.3.14). It counts only against other sources."""
STRONG_BELOW_OHMS = 1_000.0
"""A source below this is a driver and not a pull (choice)."""


class PadMode(enum.Enum):
    """What the port has configured the pad as."""

    ANALOG = "analog"
    INPUT = "input"
    PUSH_PULL = "push-pull output"
    OPEN_DRAIN = "open-drain output"
    AF_PUSH_PULL = "push-pull alternate function"
    AF_OPEN_DRAIN = "open-drain alternate function"


_ALTERNATE = (PadMode.AF_PUSH_PULL, PadMode.AF_OPEN_DRAIN)
_PASSIVE = (PadMode.ANALOG, PadMode.INPUT)
NEVER = (1 << 64) - 1
"""A cycle, or a time, that does not come."""
_EARLY = 1 - 1e-9
"""How long a ramp is taken to stay within a step, of what it does: nothing that is rounded makes it leave before."""


class Source(NamedTuple):
    """A voltage behind a resistance."""

    volts: float
    ohms: float


class Ramp:
    """A voltage behind a resistance that goes evenly from one to another, and stays there.

    Args:
        time: of the chip at whose pin it is.
        from_volts: the first,
        to_volts: and the last voltage.
        begin_ns: when it begins, in ns of bench time.
        in_ns: how long it takes, in ns.
        ohms: the resistance.
    """

    __slots__ = ("_begin_ns", "_from_volts", "_in_ns", "_time", "_to_volts", "ohms")

    def __init__(
        self, time: Timebase, from_volts: float, to_volts: float, *, begin_ns: int, in_ns: int, ohms: float
    ) -> None:
        self._time = time
        self._from_volts, self._to_volts = from_volts, to_volts
        self._begin_ns, self._in_ns = begin_ns, in_ns
        self.ohms = ohms

    @property
    def volts(self) -> float:
        """The present voltage."""
        part = min(max((self._time.ns(self._time.now) - self._begin_ns) / self._in_ns, 0.0), 1.0)
        return self._from_volts * (1 - part) + self._to_volts * part

    def crosses_ns(self, volts: float) -> int | None:
        """Return the bench time at which it has just passed a voltage between its ends; None if it does not."""
        span_volts = self._to_volts - self._from_volts
        if not span_volts or not 0 < (part := (volts - self._from_volts) / span_volts) < 1:
            return None
        return self._begin_ns + int(part * self._in_ns) + 1

    def slope(self) -> tuple[float, int]:
        """Return by how many volts in a ns it goes at present, and the bench time until which it does."""
        end_ns = self._begin_ns + self._in_ns
        if self._time.ns(self._time.now) >= end_ns:
            return 0.0, NEVER
        return (self._to_volts - self._from_volts) / self._in_ns, end_ns


AnySource = Source | Ramp


class Edge(NamedTuple):
    """A change of level, with the HCLK cycle and the bench time of it; None is a pin that floats."""

    cycle: int
    ns: int
    level: bool | None


class Bank:
    """What a port reads of its pins, kept up to date by them.

    Attributes:
        word: input levels, one bit for each pin.
        lazy: pins whose level must be asked for before `word` is right.
    """

    def __init__(self) -> None:
        self.word = 0
        self.lazy: tuple[Pin, ...] = ()

    def read(self) -> int:
        """Return the word, up to the present cycle."""
        for pin in self.lazy:
            pin.refresh()
        return self.word

    def show(self, mask: int, high: bool) -> None:
        """Set the bit of a pin."""
        self.word = self.word | mask if high else self.word & ~mask

    def leave_alone(self, mask: int, *, alone: bool, noted: bool) -> None:
        """Say whether the latch of a pin may change without the pin being told at once.

        Args:
            mask: its bit.
            alone: nobody looks at the pin, and its level follows the latch.
            noted: its edges are written down, though.
        """

    def catch_up(self) -> None:
        """Tell pins of changes of their latches that they do not know of yet."""


class Pin:
    """A pin of a chip.

    Attributes:
        name: such as ``PA0``.
        bonded: False if the package has no such pin: the pad is there, but nothing outside can reach it.
        recording: True while edges are kept for the user of the pin; see `record`.
        following: True while edges are kept for the reader of all pins; see `follow`.
        passing: how many edges of the last serial frame are left out; see `pass_over`.
        nets: the wires that end here.
        outputs: signals that the pad carries while it is in an alternate function; the first that drives wins.
        inputs: signals that listen to the pad.
        bank: the word of the port that has the pin.
        mask: the bit of the pin in that word.
        alternate: True if the pad is configured to carry its alternate-function output.
        behind: called once before anybody looks, or anything changes here; see `leads_to`.
        lazy: True if a peripheral does not report each edge, so that level and record are computed when they are read.
        wave: the signal on the pad if it is too fast for edges; the level is then low.
        on_wave: called with `wave` at the cycle of every change of it.
    """

    __slots__ = (
        "_analog",
        "_claim",
        "_digital",
        "_edges",
        "_followed",
        "_forgets",
        "_heard_by",
        "_latch",
        "_level",
        "_listeners",
        "_mode",
        "_outside",
        "_passed",
        "_pins",
        "_pull",
        "_reads_high",
        "_sent",
        "_sources",
        "_strong",
        "_was_open",
        "alternate",
        "bank",
        "behind",
        "bonded",
        "following",
        "inputs",
        "lazy",
        "mask",
        "name",
        "nets",
        "on_wave",
        "outputs",
        "passing",
        "recording",
        "wave",
    )

    def __init__(self, name: str, pins: Pins, *, bonded: bool) -> None:
        self.name = name
        self.bonded = bonded
        self.recording = False
        self.following = False
        self.passing = 0
        self.nets: tuple[Net, ...] = ()
        self.outputs: tuple[PinOutput, ...] = ()
        self.inputs: tuple[PinInput, ...] = ()
        self._heard_by: tuple[PinInput, ...] = ()  # those of them that listen
        self.bank = Bank()
        self.mask = 1
        self.alternate = False
        self.lazy = False
        self.behind: Callable[[], None] | None = None
        self.wave: Wave | None = None
        self.on_wave: Callable[[Wave | None], None] = lambda _wave: None
        self._pins = pins
        self._mode = PadMode.INPUT
        self._digital = True
        self._latch = False
        self._pull: bool | None = None
        self._claim: _Claim | None = None
        self._strong: bool | None = None
        self._analog: Source | None = None
        self._was_open = True
        self._sources: dict[Hashable, AnySource] = {}
        self._outside: AnySource | None = None
        self._sent: Source | None = None
        self._level: bool | None = None
        self._reads_high = False
        self._forgets: list[Callable[[], None]] = []
        self._edges: list[Edge] = []
        self._followed: list[Edge] = []
        self._passed = 0
        self._listeners: list[Callable[[int, int, bool | None], None]] = []

    # --- for the outside

    @property
    def level(self) -> bool | None:
        """The present level; None if the pin floats."""
        self.refresh()
        return self._level

    @property
    def volts(self) -> float | None:
        """The present voltage; None if the pin floats."""
        self.refresh()
        return self._divided()

    def volts_for(self, step_volts: float, forget: Callable[[], None]) -> tuple[float | None, int]:
        """Return the present voltage, and the cycle from which on it may be another in a way that matters.

        Args:
            step_volts: voltages between the same two multiples of this are as good as equal.
            forget: called once if it may be another before that cycle. A change of the clock is for the caller to see.
        """
        volts = self.volts
        now, ramps = self._pins.time.now, [one for one in self._sources.values() if isinstance(one, Ramp)]
        if not self._is_passive or len(ramps) > 1:
            return volts, now
        self._remember(forget)
        if volts is None or not ramps:
            return volts, NEVER
        slope, end_ns = ramps[0].slope()
        if not slope:
            return volts, NEVER
        slope *= self._share(ramps[0])
        below = volts % step_volts
        left_ns = int((step_volts - below if slope > 0 else below) / abs(slope) * _EARLY) - 2
        return volts, max(self._pins.time.cycle_at_ns(min(self.now_ns() + left_ns, end_ns)), now)

    def drive(self, level: bool | None, *, ohms: float = DRIVER_OHMS) -> None:
        """Drive the pin from outside, or release it (None).

        Args:
            level: what to drive.
            ohms: resistance of the source; 1 kOhm and more is a pull.

        Raises:
            BoardError: the package has no such pin.
        """
        self._drive_outside(None if level is None else Source(self._pins.vdd_volts if level else 0.0, ohms))

    def drive_volts(self, volts: float | None, *, ohms: float = DRIVER_OHMS) -> None:
        """Drive the pin from outside with a voltage, or release it (None); see `drive`."""
        self._drive_outside(None if volts is None else Source(volts, ohms))

    def drive_ramp(self, from_volts: float, to_volts: float, *, in_ns: int, ohms: float = DRIVER_OHMS) -> None:
        """Drive the pin from outside with a voltage ramp that begins now; see `drive`.

        Args:
            from_volts: the first,
            to_volts: and the last voltage, which stays.
            in_ns: how long it takes, in ns.
            ohms: resistance of the source.
        """
        time = self._pins.time
        ramp = Ramp(time, from_volts, to_volts, begin_ns=time.ns(time.now), in_ns=in_ns, ohms=ohms)
        self._drive_outside(ramp)
        for threshold in (self._pins.vil_volts, self._pins.vih_volts):
            at_ns = ramp.crosses_ns(threshold)
            if at_ns is not None:
                time.at_ns(at_ns, lambda: self._drive_outside(ramp) if self._outside is ramp else None)

    def record(self, on: bool = True) -> None:
        """Start or stop recording the edges of the pin. Recorded edges cost memory until they are taken."""
        self.refresh()
        self.recording = on
        self.update_watch()

    @property
    def edges(self) -> list[Edge]:
        """The edges recorded since they were last taken."""
        self.refresh()
        return self._edges

    def take_edges(self) -> list[Edge]:
        """Return the edges recorded since the last call, and remove them."""
        self.refresh()
        taken, self._edges = self._edges, []
        return taken

    def follow(self, on: bool = True) -> None:
        """Begin or end to keep the edges for `Pins.take_followed`: those of `record` are another's, and stay."""
        self.refresh()
        self.following = on
        self.update_watch()

    def take_followed(self) -> list[Edge]:
        """Return the edges kept since they were last taken by `follow`, and forget them."""
        self.refresh()
        taken, self._followed = self._followed, []
        return taken

    def pass_over(self, edges: int) -> None:
        """Leave out the edges of a serial frame that has just begun, which whoever follows the pin does not want.

        They come all the same where somebody else has to see them, or asks for the level before the end of the frame.

        Args:
            edges: how many the frame has.
        """
        self._passed += self.passing
        self.passing = 0
        if self._mode is not PadMode.AF_PUSH_PULL or self._sources or self.recording:
            return
        driving = [output for output in self.outputs if output.level is not None]
        if len(driving) != 1 or len(driving[0].pins) != 1 or self.watch() is not Watch.RECORD:
            return
        pass_over = driving[0].pass_over
        if pass_over is not None and pass_over():
            self.passing = edges

    def take_passed(self) -> int:
        """Return how many edges were left out since this was called last; no more are of a frame that is under way."""
        self.refresh()
        passed, self._passed, self.passing = self._passed + self.passing, 0, 0
        return passed

    def on_edge(self, callback: Callable[[int, int, bool | None], None]) -> None:
        """Call `callback(cycle, ns, level)` at every edge from now on, while the chip is at the cycle of the edge."""
        self.refresh()
        self._listeners.append(callback)
        self.update_watch()

    def off_edge(self, callback: Callable[[int, int, bool | None], None]) -> None:
        """Undo `on_edge`."""
        self._listeners.remove(callback)
        self.update_watch()

    # --- for the port and the signals

    @property
    def open_drain(self) -> bool:
        """True if the pad carries its alternate-function output and only pulls low."""
        return self._claim is None and self._mode is PadMode.AF_OPEN_DRAIN

    @property
    def open_to_outside(self) -> bool:
        """True if an input in the chip sees what is outside: the pad is not analog, and the chip does not drive it."""
        return self._digital and self._strong is None

    @property
    def claimed_by(self) -> str | None:
        """Who has taken the pad from the port, or None."""
        return self._claim.owner if self._claim else None

    def holds(self, forget: Callable[[], None]) -> bool:
        """Say whether the level stays as it is until `forget` is called, once; False: nobody knows."""
        if not self._is_passive or any(isinstance(one, Ramp) for one in self._sources.values()):
            return False
        self._remember(forget)
        return True

    def is_alone(self, output: PinOutput) -> bool:
        """Say whether a signal that the pad carries drives it alone, in the chip and outside."""
        return not self._sources and all(other is output or other.level is None for other in self.outputs)

    def leads_to(self, other: Pin, behind: Callable[[], None]) -> bool:
        """Say whether a wire to another pin is all that matters here, and all that decides there.

        Nobody looks at either of them then, and `behind` is called once before somebody does, or anything changes.
        """
        wires = set(self.nets) | set(other.nets)
        if self._mode is not PadMode.AF_PUSH_PULL or len(wires) != 1 or set(wires.pop().pins) != {self, other}:
            return False
        if self._is_seen or other._is_seen or other._mode is not PadMode.INPUT:
            return False
        if self._claim is not None or other._claim is not None or self._strong is None:
            return False
        if len(other._sources) != 1 or other._analog is not None or other._forgets:
            return False
        for pin in (self, other):
            pin.behind = behind
            pin.update_laziness()
        return True

    @property
    def _is_seen(self) -> bool:
        return bool(self._listeners or self._heard_by or self.recording or self.following)

    @property
    def _is_passive(self) -> bool:
        return self._claim is None and self._mode in _PASSIVE

    def _remember(self, forget: Callable[[], None]) -> None:
        if forget not in self._forgets:
            self._forgets.append(forget)

    @property
    def reads_high(self) -> bool:
        """What a digital input in the chip sees."""
        self.refresh()
        return self._reads_high

    @property
    def latch(self) -> bool:
        """What the output latch of the port holds for the pin, whatever its mode."""
        self.bank.catch_up()
        return self._latch

    def configure(self, mode: PadMode, *, latch: bool, pull: bool | None) -> None:
        """Set the mode of the pad, the output latch and the pull resistor (True is up), which no analog pad has."""
        self.refresh()
        self._mode, self._latch, self._pull = mode, latch, pull
        self._reconfigured()

    def set_latch(self, level: bool, cycle: int | None = None) -> None:
        """Set the output latch, at present or, if nobody looks, at an earlier `cycle`."""
        self._latch = level
        self.update(cycle)

    def put_out(self, source: Source | None) -> None:
        """Have a converter to analog in the chip put out a voltage from the present cycle on, or nothing (None)."""
        if source != self._analog:
            self.refresh()
            self._analog = source
            self._voltage_changed()

    def claim(self, owner: str, *, pull: bool | None = None, analog: bool = False, carries: bool = False) -> None:
        """Take the pad from its port: the debug port or an oscillator has it, until `unclaim`.

        Args:
            owner: who, in words.
            pull: direction of its pull resistor, if it has one.
            analog: it is no digital input.
            carries: it puts out the signals that are routed to it, whatever the port says.
        """
        self.refresh()
        self._claim = _Claim(owner, pull, analog, carries)
        self._reconfigured()

    def unclaim(self) -> None:
        """Give the pad back to its port."""
        if self._claim is not None:
            self._claim = None
            self._reconfigured()

    def refresh(self) -> None:
        """Bring level and record up to the present cycle, if port or peripheral has not told of each edge."""
        if self.behind is not None:
            behind, self.behind = self.behind, None
            behind()
            self.update_laziness()
        self.bank.catch_up()
        if self.outputs and self.alternate:
            for output in self.outputs:
                if output.refresh is not None:
                    output.refresh()

    def attach(self, outputs: Iterable[PinOutput], inputs: Iterable[PinInput]) -> None:
        """Set which signals the pad carries and who listens to it."""
        self.refresh()
        self.outputs, self.inputs = tuple(outputs), tuple(inputs)
        self._pins.with_outputs.pop(self, None)
        if self.outputs:
            self._pins.with_outputs[self] = None
        self._reconfigured()

    def set_source(self, key: Hashable, source: AnySource | None) -> None:
        """Put a source outside in place of what `key` had there, or take it away (None)."""
        self.refresh()
        if source is None:
            self._sources.pop(key, None)
        else:
            self._sources[key] = source
        self._leave_alone()
        self._voltage_changed()

    def put(self, key: Hashable, source: AnySource | None) -> None:
        """Put a source outside as `set_source` does, and have the other ends of the wires here see it."""
        self.set_source(key, source)
        for net in self.nets:
            net.spread(self, key, source)

    @property
    def chip(self) -> Pins:
        """The pins of the chip that this one belongs to."""
        return self._pins

    def now_ns(self) -> int:
        """Return the present bench time of the chip."""
        return self._pins.time.ns(self._pins.time.now)

    def deliver(self, ns: int, action: Callable[[], None]) -> None:
        """Have `action` happen when the chip has reached `ns`."""
        self._pins.deliver(ns, action)

    def join(self, net: Net) -> None:
        """Become an end of `net`; it is told of what this pin contributes from now on."""
        self.refresh()
        self.nets = (*self.nets, net)
        self.update_watch()

    def contributions(self) -> tuple[Source | None, AnySource | None]:
        """Return what this pin puts on its nets: of the chip, and of whoever drives it."""
        self.refresh()
        return self._source_of_chip(), self._outside

    def watch(self) -> Watch:
        """Say who looks at the pin."""
        if self._listeners or self.nets:
            return Watch.LIVE
        if self._heard_by:
            return Watch.LIVE
        return Watch.RECORD if self.recording or self.following else Watch.NOBODY

    def update_watch(self) -> None:
        """Tell the signals that are carried who looks at them now."""
        self._heard_by = tuple(signal for signal in self.inputs if signal.on_change is not None)
        for output in self.outputs:
            output.update_watch()
        self.update_laziness()
        self.update_wave()
        self._leave_alone()

    def _leave_alone(self) -> None:
        """Say whether the port need not tell of each change of the latch."""
        watch = self.watch()
        follows = self._mode is PadMode.PUSH_PULL and self._claim is None and not self._sources
        alone = follows and watch is not Watch.LIVE
        self.bank.leave_alone(self.mask, alone=alone, noted=alone and watch is Watch.RECORD)

    def update_laziness(self) -> None:
        """Find out anew whether the level must be asked for before it is right."""
        lazy = any(output.refresh is not None and output.watch() is not Watch.LIVE for output in self.outputs)
        others = tuple(pin for pin in self.bank.lazy if pin is not self)
        self.lazy = (lazy and self.alternate) or self.behind is not None
        self.bank.lazy = (*others, self) if self.lazy else others

    def update_wave(self) -> None:
        """Find out anew whether the pad carries a wave, and note it if something listens for its edges."""
        wave = next((one.wave for one in self.outputs if one.wave is not None), None) if self.alternate else None
        if wave is not None and (self.nets or self._heard_by):
            text = f"carries {float(wave.hz) / 1e6:g} MHz, whose edges are not simulated: wires see none"
            self._pins.notes.add("unmodelled", self.name, text)
        if wave != self.wave:
            self.wave = wave
            self.on_wave(wave)

    def update(self, cycle: int | None = None) -> None:
        """Work out the level after something has changed, at present or (unwatched) at an earlier `cycle`."""
        self._strong = self._driven_by_chip()
        if self.inputs and self.open_to_outside is not self._was_open:
            self._was_open = self.open_to_outside
            for signal in self.inputs:
                if signal.on_reach is not None:
                    signal.on_reach()
        if self.nets:
            self._tell_nets()
        level = self._resolved()
        if level is not self._level:
            self._level = level
            if cycle is not None:
                self.passing = 0  # somebody has asked
            if self.following or self.recording or self._listeners:
                self._tell_edge(self._pins.time.now if cycle is None else cycle, level)
        if (self._level is True and self._digital) is not self._reads_high:
            self._input_changed()

    # --- inside

    def _drive_outside(self, source: AnySource | None) -> None:
        if not self.bonded:
            raise BoardError(f"{self.name} is not bonded in this package", hint="use a pin that the package has")
        self._outside = source
        self.put("outside", source)

    def _reconfigured(self) -> None:
        self.alternate = self._mode in _ALTERNATE if self._claim is None else self._claim.carries
        self._digital = not self._claim.analog if self._claim else self._mode is not PadMode.ANALOG
        self.refresh()
        self.update_watch()
        self._voltage_changed()

    def _voltage_changed(self) -> None:
        """Do as `update` does, and tell who knows the voltage of a pin that no driver of the chip's has."""
        forgets, self._forgets = self._forgets, []
        for forget in forgets:
            forget()
        self.update()

    def _driven_by_chip(self) -> bool | None:
        mode = self._mode
        if self._claim is not None:
            return self._driven_by_signals() if self._claim.carries else None
        if mode is PadMode.PUSH_PULL:
            return self._latch
        if mode is PadMode.OPEN_DRAIN:
            return None if self._latch else False
        if mode is PadMode.AF_PUSH_PULL:
            return self._driven_by_signals()
        if mode is PadMode.AF_OPEN_DRAIN:
            return False if self._driven_by_signals() is False else None
        return None

    def _driven_by_signals(self) -> bool | None:
        found: bool | None = None
        for output in self.outputs:
            level = output.level
            if level is None:
                continue
            if found is not None:
                return self._driven_by_several()
            found = level
        return found

    def _driven_by_several(self) -> bool:
        for output in self.outputs:
            catch_up, output.catch_up = output.catch_up, None
            if catch_up is not None:
                catch_up()
        driving = [output for output in self.outputs if output.level is not None]
        if len({output.level for output in driving}) > 1:
            names = ", ".join(output.name for output in driving)
            self._pins.notes.add("misuse", self.name, f"driven by several peripherals at once ({names})")
        return driving[0].level is True

    def _pull_of_chip(self) -> bool | None:
        if self._claim is not None:
            return self._claim.pull
        return None if self._mode is PadMode.ANALOG else self._pull

    def _source_of_chip(self) -> Source | None:
        level, ohms = self._strong, DRIVER_OHMS
        if level is None and self._analog is not None:
            return self._analog
        if level is None:
            level, ohms = self._pull_of_chip(), PULL_OHMS
        return None if level is None else Source(self._pins.vdd_volts if level else 0.0, ohms)

    def _resolved(self) -> bool | None:
        if self._analog is not None and self._strong is None:
            volts = self._divided()
            return None if volts is None else self._level_of(volts)
        if not self._sources:
            return self._pull_of_chip() if self._strong is None else self._strong
        strong = {self._level_of(source.volts) for source in self._sources.values() if source.ohms < STRONG_BELOW_OHMS}
        if self._strong is not None:
            strong.add(self._strong)
        if len(strong) > 1:
            self._pins.notes.add("misuse", self.name, "driven high and low at the same time: it reads low")
            return False
        if strong:
            return strong.pop()
        volts = self._divided()
        return None if volts is None else self._level_of(volts)

    def _divided(self) -> float | None:
        chip = self._source_of_chip()
        if not self._sources:
            return None if chip is None else chip.volts
        sources = list(self._sources.values())
        if chip is not None:
            sources.append(chip)
        return sum(source.volts / source.ohms for source in sources) / sum(1 / source.ohms for source in sources)

    def _share(self, source: AnySource) -> float:
        """Return how far the pin goes with a source, of what that goes itself."""
        chip = self._source_of_chip()
        ohms = [one.ohms for one in self._sources.values()] + ([] if chip is None else [chip.ohms])
        return 1 / source.ohms / sum(1 / one for one in ohms)

    def _level_of(self, volts: float) -> bool:
        if volts >= self._pins.vih_volts:
            return True
        if volts <= self._pins.vil_volts:
            return False
        return self._level is True

    def _tell_nets(self) -> None:
        source = self._source_of_chip()
        if source != self._sent:
            self._sent = source
            for net in self.nets:
                net.spread(self, "chip", source)

    def _tell_edge(self, cycle: int, level: bool | None) -> None:
        ns = self._pins.time.ns(cycle)
        if self.following or self.recording:
            self._keep_edge(Edge(cycle, ns, level))
        for callback in tuple(self._listeners):
            callback(cycle, ns, level)

    def _keep_edge(self, edge: Edge) -> None:
        if self.following:
            if not self._followed:
                self._pins.with_edges.append(self)
            self._followed.append(edge)
        if self.recording:
            self._edges.append(edge)

    def _input_changed(self) -> None:
        high = self._reads_high = not self._reads_high
        self.bank.show(self.mask, high)
        for signal in self._heard_by:
            if signal.on_change is not None:
                signal.on_change(high)


class _Claim(NamedTuple):
    owner: str
    pull: bool | None
    analog: bool
    carries: bool


class Pins:
    """All pins of a chip, by name: ``pins["PA0"]``.

    Args:
        names: the pads of the chip, in order.
        time: the cycles of the chip.
        notes: where contention is noted.
        bonded: the pins that the package has; None for all.
        vdd_volts: supply of the pads.
        thresholds: input thresholds, see below; those of the STM32F103 if left out.

    Attributes:
        vil_volts: an input below this reads low, and
        vih_volts: above this high; on the STM32F103 0.28 (VDD - 2 V) + 0.8 V and 0.41 (VDD - 2 V) + 1.3 V (DS5319
            section 5.3.14, standard pins).
        deliver: called with a bench time in ns and an action for it, when a wire brings something from another chip.
            The machine sets it; until then such an action happens at once.
        banks: the ports of the chip.
        with_outputs: the pins that carry signals of the chip, if they are set to.
        with_edges: the followed pins that had an edge when they had none; see `take_followed`.
    """

    def __init__(
        self,
        names: Iterable[str],
        time: Timebase,
        notes: Notes,
        *,
        bonded: Iterable[str] | None = None,
        vdd_volts: float = 3.3,
        thresholds: tuple[float, float] | None = None,
    ) -> None:
        self.time = time
        self.notes = notes
        self.vdd_volts = vdd_volts
        self.vil_volts, self.vih_volts = thresholds or (
            0.28 * (vdd_volts - 2.0) + 0.8,
            0.41 * (vdd_volts - 2.0) + 1.3,
        )
        self.deliver: Callable[[int, Callable[[], None]], None] = lambda _ns, action: action()
        self.banks: list[Bank] = []
        self.with_outputs: dict[Pin, None] = {}
        self.with_edges: list[Pin] = []
        there = None if bonded is None else frozenset(bonded)
        self._pins = {name: Pin(name, self, bonded=there is None or name in there) for name in names}

    def __getitem__(self, name: str) -> Pin:
        """Return a pin. Raises `BoardError` if the chip has none of that name."""
        pin = self._pins.get(name)
        if pin is None:
            raise BoardError(f"the chip has no pin {name}", hint="pins are named like PA0 or PC13")
        return pin

    def take_followed(self) -> list[tuple[Pin, list[Edge]]]:
        """Return the edges of all pins that are followed, and forget them; pins without any cost nothing.

        They come in no particular order, but in the same one whenever the same happens.
        """
        for bank in self.banks:
            bank.catch_up()
        for pin in self.with_outputs:
            if pin.lazy and pin.following and not pin.passing:
                pin.refresh()
        pins = [pin for pin in self.with_edges if pin.following]
        self.with_edges = [pin for pin in self.with_edges if not pin.following]
        return [(pin, edges) for pin in pins if (edges := pin.take_followed())]

    def __contains__(self, name: object) -> bool:
        return name in self._pins

    def __iter__(self) -> Iterator[Pin]:
        return iter(self._pins.values())

    def __len__(self) -> int:
        return len(self._pins)
