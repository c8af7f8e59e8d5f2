"""The output stages of a timer: from OCxREFC to the pins, with polarity, dead time and idle states.

RM0008 sections 14.3.11 and 14.3.12, and the table of output control bits for complementary channels (section 14.4.9).
The general-purpose timers have the polarity alone. An output that the timer does not drive is released (choice: the
manual says "output disabled, not driven by the timer").

Where somebody listens at a pin, each edge is put into a queue that the timer works off when its state is settled; where
edges are only recorded, they go to the pin with the tick they belong to; where nobody looks, they are left out, and
`OutputStage.show` gives the present level on demand.
"""

from __future__ import annotations

from collections.abc import Callable

from targets.mcu.services import OutputSignal, Watch
from targets.mcu.stm32.tim.counting import LONG_AGO, Compare

__all__ = ["Gate", "OutputStage"]


class Gate:
    """What the output stages of one timer share.

    Attributes:
        advanced: whether the timer has MOE, dead time and complementary outputs.
        main_enable: BDTR_MOE.
        idle_since: the tick at which it was cleared.
        off_state_run: BDTR_OSSR.
        off_state_idle: BDTR_OSSI.
        dead_ticks: the dead time.
        cycle_of: HCLK cycle of a tick.
        queue: changes of pins that somebody listens at.
    """

    __slots__ = (
        "advanced",
        "cycle_of",
        "dead_ticks",
        "idle_since",
        "main_enable",
        "off_state_idle",
        "off_state_run",
        "queue",
    )

    def __init__(
        self, *, advanced: bool, cycle_of: Callable[[int], int], queue: Callable[[OutputSignal, bool | None], None]
    ) -> None:
        self.advanced = advanced
        self.cycle_of = cycle_of
        self.queue = queue
        self.reset()

    def reset(self) -> None:
        """Go to the state after reset."""
        self.main_enable = self.off_state_run = self.off_state_idle = False
        self.dead_ticks = 0
        self.idle_since = LONG_AGO


class OutputStage:
    """The output stage of one channel.

    Args:
        unit: its compare unit.
        gate: what it shares with the others.
        signal: the output OCx.
        complement: the output OCxN, if it has one.
        event: OCx once more, inside the chip, whatever pin carries it: converters take it as a trigger.

    Attributes:
        bit: of the channel, in masks.
        watch: who looks at either output, as of the last `look_round`.
        enabled, inverted, idle: CCxE, CCxP, OISx.
        n_enabled, n_inverted, n_idle: CCxNE, CCxNP, OISxN.
    """

    __slots__ = (
        "_due",
        "_gate",
        "_offers",
        "_unit",
        "_watches",
        "bit",
        "complement",
        "enabled",
        "event",
        "idle",
        "inverted",
        "n_enabled",
        "n_idle",
        "n_inverted",
        "signal",
        "watch",
    )

    def __init__(
        self, unit: Compare, gate: Gate, signal: OutputSignal, complement: OutputSignal | None, event: OutputSignal
    ) -> None:
        self._unit = unit
        self._gate = gate
        self.bit = unit.bit
        self.signal = signal
        self.complement = complement
        self.event = event
        self._due: int | None = None
        self._offers = False
        self.look_round()
        self.reset()

    def reset(self) -> None:
        """Go to the state after reset."""
        self.enabled = self.inverted = self.idle = False
        self.n_enabled = self.n_inverted = self.n_idle = False
        self._due = None

    def look_round(self) -> None:
        """Find out anew who looks at the outputs."""
        self._watches = (self.signal.watch(), self.complement.watch() if self.complement is not None else Watch.NOBODY)
        self.watch = max(*self._watches, self.event.watch())

    def offer(self, refresh: Callable[[], None]) -> None:
        """Offer `refresh` while the outputs are driven, and may change by themselves; otherwise they are released."""
        gate = self._gate
        enabled = self._unit.output and (self.enabled or self.n_enabled)
        offers = enabled and (gate.main_enable or gate.off_state_idle or not gate.advanced)
        if offers is self._offers:
            return
        self._offers = offers
        for signal in (self.signal, self.complement):
            if signal is not None:
                signal.refresh = refresh if offers else None
                if not offers and signal.watch() is Watch.NOBODY:
                    signal.set(None)

    @property
    def follows(self) -> bool:
        """Whether OCxREFC decides the level of either output at present."""
        gate = self._gate
        return self._unit.output and (self.enabled or self.n_enabled) and (gate.main_enable or not gate.advanced)

    @property
    def due(self) -> int | None:
        """The tick at which a dead time ends, or None."""
        return self._due

    def changed(self, tick: int, cycle: int) -> None:
        """OCxREFC or a control bit has changed at `cycle`, in `tick`: tell the outputs, note when a dead time ends."""
        gate, unit = self._gate, self._unit
        self._tell(tick, cycle)
        self._due = None
        if not gate.dead_ticks:
            return
        if gate.main_enable:
            ends = unit.since + gate.dead_ticks if self.enabled and self.n_enabled else tick
        else:
            ends = gate.idle_since + gate.dead_ticks
        self._due = ends if ends > tick else None

    def reach(self, tick: int) -> None:
        """Let a dead time end that does so by `tick`."""
        if self._due is not None and self._due <= tick:
            due, self._due = self._due, None
            self._tell(due, self._gate.cycle_of(due))

    def show(self, tick: int) -> None:
        """Give the outputs that nobody looks at their present levels."""
        level, n_level = self.levels(tick)
        watch, n_watch = self._watches
        if watch is Watch.NOBODY:
            self.signal.set(level)
        if self.complement is not None and n_watch is Watch.NOBODY:
            self.complement.set(n_level)

    def _tell(self, tick: int, cycle: int) -> None:
        if self.watch is Watch.NOBODY:
            return
        level, n_level = self.levels(tick)
        watch, n_watch = self._watches
        self._tell_one(self.signal, watch, level, cycle)
        if self.complement is not None:
            self._tell_one(self.complement, n_watch, n_level, cycle)
        if self.event.watch() is Watch.LIVE:
            self._gate.queue(self.event, level)

    def _tell_one(self, signal: OutputSignal, watch: Watch, level: bool | None, cycle: int) -> None:
        if watch is Watch.LIVE:
            self._gate.queue(signal, level)
        elif watch is Watch.RECORD:
            signal.set_at(cycle, level)

    # --- the table of output control bits

    def levels(self, tick: int) -> tuple[bool | None, bool | None]:
        """Return the levels of OCx and OCxN at `tick`; None is released."""
        if not self._unit.output:
            return None, None
        gate = self._gate
        if not gate.advanced:
            return (self._unit.out is not self.inverted if self.enabled else None), None
        if not gate.main_enable:
            return self._idle_levels(tick)
        if self.enabled and self.n_enabled:
            return self._complementary_levels(tick)
        ref, off_state = self._unit.out, gate.off_state_run
        if self.enabled:
            return ref is not self.inverted, (self.n_inverted if off_state else None)
        if self.n_enabled:
            return (self.inverted if off_state else None), ref is not self.n_inverted
        return None, None

    def _complementary_levels(self, tick: int) -> tuple[bool, bool]:
        unit = self._unit
        settled = tick - unit.since >= self._gate.dead_ticks
        active, n_active = unit.out and settled, not unit.out and settled
        return active is not self.inverted, n_active is not self.n_inverted

    def _idle_levels(self, tick: int) -> tuple[bool | None, bool | None]:
        gate = self._gate
        if not gate.off_state_idle or not (self.enabled or self.n_enabled):
            return None, None
        both_active = self.idle is not self.inverted and self.n_idle is not self.n_inverted
        if tick - gate.idle_since < gate.dead_ticks or (both_active and self.complement is not None):
            return self.inverted, self.n_inverted
        return self.idle, self.n_idle
