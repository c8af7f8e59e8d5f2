"""The counter of a timer and its compare units, as arithmetic on ticks (RM0008 sections 14.3.1 to 14.3.11).

A tick is one period of the timer's clock. The counter does not run: `Counting.advance` brings it to a tick, in *legs*.
A leg goes from where the counter is to its next boundary, an overflow, an underflow or the wrap at 0xFFFF, and nothing
that the program wrote takes effect within it. Where nobody asked for edges, whole periods are skipped at once.

Where the manual leaves a choice:

* The counter compares for equality with ARR: above it, it counts up to 0xFFFF and wraps to 0 without an update event.
* A compare match is the arrival of the counter at CCRx by counting, which includes the reload at an overflow or
  underflow. Writing CNT or CCRx, UG and a reset by the trigger make none.
* At a boundary the preloaded values are loaded first and compared after; "CCRx is greater than ARR" (RM0008, CC1IF) is
  asked of the values before.
* In the centre-aligned modes 1 and 2 a match at the turning points, 0 and ARR, sets the flag in both (the figure of the
  centre-aligned waveforms shows it for CCRx = 0, ARR and above). OCxREF reacts to every match, whatever sets the flag.
* With ARR = 0 the counter is blocked, the prescaler is not. The repetition counter counts on while UDIS is set.
* In asymmetric PWM mode the direction is that which the counter has on arrival: at ARR it counts down already.
* In PWM mode OCxREF follows the comparison at once when the mode is entered from frozen or from the other PWM mode;
  entered from a forced or a compare mode, from the next change of the comparison on (RM0008, OC1M note 2).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

__all__ = [
    "ACTIVE",
    "ALONE",
    "BOTH",
    "BY_DIRECTION",
    "EITHER",
    "FORCE_ACTIVE",
    "FORCE_INACTIVE",
    "FROZEN",
    "INACTIVE",
    "LONG_AGO",
    "PWM1",
    "PWM2",
    "TOGGLE",
    "Compare",
    "Counting",
]

LONG_AGO = -(1 << 16)
"""A tick further back than any dead time is long."""
FROZEN, ACTIVE, INACTIVE, TOGGLE, FORCE_INACTIVE, FORCE_ACTIVE, PWM1, PWM2 = range(8)
ALONE, EITHER, BOTH, BY_DIRECTION = range(4)
"""How OCxREFC comes of OCxREF and that of the partner: not at all, OR, AND, or the partner's while counting down."""

_LEGS_TO_SEE_ALL = 4  # a wrap, then up, down and up again: whatever recurs has occurred once by then


class Compare:
    """A compare unit: what CCRx and OCxM make of the counter.

    Attributes:
        number: from 0 on, and
        bit: its bit in masks of units.
        output: whether the channel is an output; a capture channel compares nothing.
        mode: OCxM in effect.
        ccr: CCRx in effect, and
        ccr_preload: as written; they differ until the next update event if OCxPE is set.
        ref: OCxREF.
        combination: what becomes of it, with the OCxREF of
        partner: the other unit of the pair, and
        gate: a unit whose OCxREF must be high as well, or None.
        out: OCxREFC, which is OCxREF unless it is combined, and
        since: the tick of its last change.
        following: the PWM comparison as it was last; OCxREF changes when this does.
        cleared: OCxREF is held low by ETRF until an update event.
    """

    __slots__ = (
        "bit",
        "ccr",
        "ccr_preload",
        "cleared",
        "combination",
        "following",
        "gate",
        "mode",
        "number",
        "out",
        "output",
        "partner",
        "ref",
        "since",
    )

    def __init__(self, number: int) -> None:
        self.number = number
        self.bit = 1 << number
        self.partner = self
        self.reset()

    def reset(self) -> None:
        """Go to the state after reset."""
        self.output = True
        self.mode = FROZEN
        self.ccr = self.ccr_preload = 0
        self.ref = self.out = self.following = self.cleared = False
        self.combination = ALONE
        self.gate: Compare | None = None
        self.since = LONG_AGO

    def pwm(self, cnt: int, down: bool) -> bool:
        """Return the level that the PWM mode gives for a state of the counter."""
        active = cnt <= self.ccr if down else cnt < self.ccr
        return active is (self.mode == PWM1)

    def combined(self, down: bool) -> bool:
        """Return OCxREFC."""
        level = self.ref
        if self.combination == EITHER:
            level = level or self.partner.ref
        elif self.combination == BOTH:
            level = level and self.partner.ref
        elif self.combination == BY_DIRECTION and down:
            level = self.partner.ref
        return level and (self.gate is None or self.gate.ref)


class Counting:
    """Counter, prescaler, repetition counter and compare units.

    Attributes:
        tick: the tick that the state belongs to.
        running: whether the prescaler is clocked by ticks.
        cnt: the counter; call `moved` after changing it or `down`, `arr`, or a unit's `ccr` in effect.
        down: its direction.
        centre: 0, or the mode 1 to 3 of centre-aligned counting.
        arr: ARR in effect, and
        arr_preload: as written.
        psc: PSC in effect, and
        psc_preload: as written.
        psc_count: the prescaler's own counter.
        rep: the repetition counter, and
        rcr: what it is reloaded with.
        top: one more than the counter can hold.
        udis: no update events.
        combines: whether OCxREFC of any unit is more than its OCxREF.
        units: the compare units.
        edges_asked: returns a mask of units of whose OCxREFC somebody wants every edge; whole periods without one of
            those are left out.
        on_update: called at an update event by the counter, after the preloaded values were taken.
        on_match: called with a mask of units whose flags are to be set.
        before_ref: called with a unit and the tick before its OCxREFC changes, and
        on_ref: after.
    """

    __slots__ = (
        "_changed_at",
        "arr",
        "arr_preload",
        "before_ref",
        "centre",
        "cnt",
        "combines",
        "down",
        "edges_asked",
        "on_match",
        "on_ref",
        "on_update",
        "psc",
        "psc_count",
        "psc_preload",
        "rcr",
        "rep",
        "running",
        "tick",
        "top",
        "udis",
        "units",
    )

    def __init__(
        self,
        on_update: Callable[[], None],
        on_match: Callable[[int], None],
        before_ref: Callable[[Compare, int], None],
        on_ref: Callable[[Compare, int], None],
        edges_asked: Callable[[], int],
        *,
        bits: int = 16,
        units: int = 4,
    ) -> None:
        self.tick = 0
        self.top = 1 << bits
        self.units = tuple(Compare(number) for number in range(units))
        for unit in self.units:
            unit.partner = self.units[min(unit.number ^ 1, units - 1)]
        self.on_update = on_update
        self.on_match = on_match
        self.before_ref = before_ref
        self.on_ref = on_ref
        self.edges_asked = edges_asked
        self.reset()

    def reset(self) -> None:
        """Go to the state after reset, at the present tick."""
        self.running = self.down = self.udis = False
        self.cnt = self.centre = 0
        self.arr = self.arr_preload = self.top - 1
        self.psc = self.psc_preload = self.psc_count = 0
        self.rep = self.rcr = 0
        self.combines = False
        self._changed_at: int | None = None
        for unit in self.units:
            unit.reset()

    # --- time

    def advance(self, tick: int) -> None:
        """Bring the state to `tick`; an earlier one changes nothing."""
        legs, skips = 0, False
        while self.running and self.tick < tick:
            ahead = self.psc_count + tick - self.tick
            period = self.psc + 1
            steps, event = self._leg(self.cnt, self.down)
            possible = ahead // period
            if not steps or possible < steps:
                if steps:
                    self._move(possible, self.tick - self.psc_count, period)
                self.psc_count = ahead - possible * period
                self.tick = tick
                return
            self._move(steps - 1, self.tick - self.psc_count, period)
            self.tick += steps * period - self.psc_count
            self.psc_count = 0
            self._cross(event)
            legs += 1
            if legs == _LEGS_TO_SEE_ALL:
                asked = self.sources_of(self.edges_asked())
                skips = not any(asked & unit.bit and self._recurs(unit) for unit in self.units)
            if skips:
                self._skip(tick)
        self.tick = max(self.tick, tick)

    def count_at(self, tick: int) -> int | None:
        """Return the counter at `tick`, or None if that takes an `advance`."""
        if not self.running or tick <= self.tick:
            return self.cnt
        steps, _event = self._leg(self.cnt, self.down)
        possible = (self.psc_count + tick - self.tick) // (self.psc + 1)
        if not steps:
            return self.cnt
        if possible >= steps:
            return None
        return self.cnt - possible if self.down else self.cnt + possible

    def steps_left(self) -> int:
        """Return the steps from the counter as it stands to its next boundary; 0 for never."""
        return self._leg(self.cnt, self.down)[0]

    def pulse(self, tick: int) -> None:
        """Clock the prescaler once, at `tick`, from something else than the ticks."""
        self.tick = tick
        self.psc_count += 1
        if self.psc_count <= self.psc:
            return
        self.psc_count = 0
        steps, event = self._leg(self.cnt, self.down)
        if steps == 1:
            self._cross(event)
        elif steps:
            self._move(1, tick - 1, 1)

    # --- what software and triggers do

    def reinitialise(self) -> None:
        """Begin anew, as UG and the trigger's reset do; take the preloaded values unless UDIS is set."""
        self.psc_count = 0
        self.rep = self.rcr
        if not self.udis:
            self.load()
        self.cnt = self.arr if self.down and not self.centre else 0
        self.moved()

    def load(self) -> None:
        """Take the preloaded values, as an update event does; OCxREF is released from a clear."""
        self.arr, self.psc = self.arr_preload, self.psc_preload
        for unit in self.units:
            if unit.cleared:
                unit.cleared = False
                unit.following = unit.ref  # so that the next comparison decides
            if unit.output:
                unit.ccr = unit.ccr_preload

    def moved(self) -> None:
        """The state was changed from outside: turn round where the counter stands at an end, and compare anew."""
        if self.centre:
            if self.cnt == 0:
                self.down = False
            elif self.cnt == self.arr:
                self.down = True
        for unit in self.units:
            if unit.output and unit.mode >= PWM1:
                self._compare(unit, unit.pwm(self.cnt, self.down), self.tick)
        self.resolve()

    def set_mode(self, unit: Compare, mode: int) -> None:
        """Change OCxM."""
        old, unit.mode = unit.mode, mode
        if mode in (FORCE_INACTIVE, FORCE_ACTIVE):
            unit.cleared = False
            self._set_ref(unit, mode == FORCE_ACTIVE, self.tick)
        elif mode >= PWM1 and old != mode:
            unit.following = unit.pwm(self.cnt, self.down)
            if old in (FROZEN, PWM1, PWM2):
                self._set_ref(unit, unit.following, self.tick)
        self.resolve()

    def combine(self, unit: Compare, combination: int) -> None:
        """Change what OCxREFC is made of."""
        if unit.combination != combination:
            unit.combination = combination
            self._recombine()

    def group(self, gates: Sequence[bool]) -> None:
        """Let the first units be high only while the fifth is, where `gates` says so."""
        for unit, gated in zip(self.units, gates, strict=False):
            unit.gate = self.units[4] if gated else None
        self._recombine()

    def _recombine(self) -> None:
        self.combines = True
        self.resolve()
        self.combines = any(unit.combination or unit.gate for unit in self.units)

    def clear(self, unit: Compare) -> None:
        """ETRF is high: hold OCxREF low until the next update event."""
        if unit.output and unit.mode not in (FORCE_INACTIVE, FORCE_ACTIVE):
            self._set_ref(unit, False, self.tick)
            unit.cleared = True
            self.resolve()

    def trigger_fast(self, unit: Compare) -> None:
        """A trigger with OCxFE set acts like a match in PWM mode, whatever the comparison says."""
        if unit.output and unit.mode >= PWM1:
            self._set_ref(unit, self.down is (unit.mode == PWM1), self.tick)
            self.resolve()

    def resolve(self) -> None:
        """Bring OCxREFC up to date, after OCxREF of some unit or the direction has changed at the present tick."""
        if self.combines:
            self._changed_at = None
            self._resolve(self.tick)

    # --- what comes

    def sources_of(self, units: int) -> int:
        """Return the units on whose OCxREF the OCxREFC of these depend."""
        if self.combines:
            for unit in self.units:
                if units & unit.bit:
                    units |= (unit.partner.bit if unit.combination else 0) | (unit.gate.bit if unit.gate else 0)
        return units

    def next_event(self, *, update: bool, matches: int, edges: int) -> int | None:
        """Return the first tick at which something wanted may happen, or None if nothing will.

        Args:
            update: an update event is wanted,
            matches: flags of these units are,
            edges: changes of OCxREFC of these units are.
        """
        edges = self.sources_of(edges)
        if not self.running or not (update or matches or edges):
            return None
        update = (update or self._waits_to_load()) and not self.udis
        wanted = [unit for unit in self.units if unit.output and unit.bit & (matches | edges)]
        cnt, down, rep = self.cnt, self.down, self.rep
        start, period = self.tick - self.psc_count, self.psc + 1
        for _ in range(_LEGS_TO_SEE_ALL if wanted else 1):
            steps, event = self._leg(cnt, down)
            if not steps:
                return None
            first = self._first_within(wanted, matches, edges, cnt, down, steps)
            if first:
                return start + first * period
            start += steps * period
            if event and not rep and update:
                return start
            cnt, turned = self._beyond(down, event)
            if wanted and self._wanted_at_boundary(
                wanted, matches, edges, cnt, turned, event and not (self.centre and down)
            ):
                return start
            down = turned
            if event:
                rep = rep - 1 if rep else self.rcr
        if not update:
            return None
        if self._leg(cnt, down)[1]:
            return start + (rep + 1) * self._whole_leg() * period
        return start

    def will_load_after(self, tick: int) -> bool:
        """Say whether a preloaded value waits for an update event, and none has come by `tick`."""
        return self._waits_to_load() and self.count_at(tick) is not None

    def _waits_to_load(self) -> bool:
        return (
            self.arr != self.arr_preload
            or self.psc != self.psc_preload
            or any(unit.output and unit.ccr != unit.ccr_preload for unit in self.units)
        )

    def _first_within(self, wanted: list[Compare], matches: int, edges: int, cnt: int, down: bool, steps: int) -> int:
        first = 0
        flagged = matches if self._flags_within(down) else 0
        for unit in wanted:
            step = cnt - unit.ccr if down else unit.ccr - cnt
            if 0 < step < steps and (not first or step < first):
                bit = unit.bit
                if flagged & bit or (edges & bit and self._changes(unit, unit.ccr, down)):
                    first = step
        return first

    def _wanted_at_boundary(
        self, wanted: list[Compare], matches: int, edges: int, cnt: int, down: bool, over: bool
    ) -> bool:
        for unit in wanted:
            if matches & unit.bit and (unit.ccr == cnt or (over and unit.ccr > self.arr)):
                return True
            if edges & unit.bit and (self._changes(unit, cnt, down) or self._turns(unit)):
                return True
        return False

    def _changes(self, unit: Compare, cnt: int, down: bool) -> bool:
        if unit.mode >= PWM1:
            return unit.pwm(cnt, down) is not unit.following
        return unit.ccr == cnt and unit.mode in (ACTIVE, INACTIVE, TOGGLE)

    def _turns(self, unit: Compare) -> bool:
        """Say whether OCxREFC may change where the counter turns round."""
        return unit.combination == BY_DIRECTION and bool(self.centre)

    # --- legs

    def _leg(self, cnt: int, down: bool) -> tuple[int, bool]:
        """Return the steps to the next boundary, 0 for never, and whether it is an overflow or underflow."""
        arr = self.arr
        if not arr:
            return 0, False
        if down:
            return (cnt if self.centre else cnt + 1), True
        if cnt > arr:
            return self.top - cnt, False
        return (arr - cnt if self.centre else arr - cnt + 1), True

    def _whole_leg(self) -> int:
        return self.arr if self.centre else self.arr + 1

    def _beyond(self, down: bool, event: bool) -> tuple[int, bool]:
        """Return counter and direction on arrival at the boundary of a leg in direction `down`."""
        if not event:
            return 0, False
        if not self.centre:
            return (self.arr if down else 0), down
        return (0, False) if down or not self.arr else (self.arr, True)

    def _flags_within(self, down: bool) -> bool:
        return not self.centre or bool(self.centre & (1 if down else 2))

    def _move(self, steps: int, start: int, period: int) -> None:
        """Count `steps` within a leg; step number n of them is at tick `start` + n * `period`."""
        if not steps:
            return
        cnt, down = self.cnt, self.down
        self.cnt = cnt - steps if down else cnt + steps
        flags = 0
        units: Sequence[Compare] = self.units
        if self.combines:  # what is made of several has to hear of them in their order
            units = sorted(units, key=lambda unit: unit.ccr, reverse=down)
        for unit in units:
            step = cnt - unit.ccr if down else unit.ccr - cnt
            if 0 < step <= steps and unit.output:
                flags |= unit.bit
                self._matched(unit, unit.ccr, down, start + step * period)
        self._resolve_changes()
        if flags and self._flags_within(down):
            self.on_match(flags)

    def _cross(self, event: bool) -> None:
        """Take the step that crosses a boundary; `tick` is already that of the arrival."""
        flags = 0
        update = False
        if event:
            if not (self.centre and self.down):
                flags = sum(unit.bit for unit in self.units if unit.output and unit.ccr > self.arr)
            update = not self.rep and not self.udis
            self.rep = self.rep - 1 if self.rep else self.rcr
        if update:
            self.load()
        self.cnt, self.down = self._beyond(self.down, event)
        if update:
            self.on_update()
        cnt, down = self.cnt, self.down
        for unit in self.units:
            if unit.output:
                if unit.ccr == cnt:
                    flags |= unit.bit
                self._matched(unit, cnt, down, self.tick)
        self.resolve()
        if flags:
            self.on_match(flags)

    def _matched(self, unit: Compare, cnt: int, down: bool, tick: int) -> None:
        mode = unit.mode
        if mode >= PWM1:
            self._compare(unit, unit.pwm(cnt, down), tick)
        elif ACTIVE <= mode <= TOGGLE and unit.ccr == cnt and not unit.cleared:
            self._set_ref(unit, not unit.ref if mode == TOGGLE else mode == ACTIVE, tick)

    def _compare(self, unit: Compare, level: bool, tick: int) -> None:
        if level is not unit.following:
            unit.following = level
            if not unit.cleared:
                self._set_ref(unit, level, tick)

    def _set_ref(self, unit: Compare, level: bool, tick: int) -> None:
        if level is unit.ref:
            return
        if self.combines:
            if tick != self._changed_at:
                self._resolve_changes()
            self._changed_at = tick
            unit.ref = level
        else:
            self.before_ref(unit, tick)
            unit.ref = unit.out = level
            unit.since = tick
            self.on_ref(unit, tick)

    def _resolve_changes(self) -> None:
        """Let all that has changed at one tick take effect at once."""
        if self._changed_at is not None:
            tick, self._changed_at = self._changed_at, None
            self._resolve(tick)

    def _resolve(self, tick: int) -> None:
        for unit in self.units:
            level = unit.combined(self.down)
            if level is not unit.out:
                self.before_ref(unit, tick)
                unit.out = level
                unit.since = tick
                self.on_ref(unit, tick)

    # --- whole periods at once

    def _recurs(self, unit: Compare) -> bool:
        """Say whether OCxREF may change in every period, or OCxREFC with the direction."""
        if self._turns(unit):
            return True
        if not unit.output or unit.ccr > self.arr:
            return False
        if unit.mode == TOGGLE:
            return True
        first = 0 if self.down and not self.centre else 1
        last = self.arr - 1 if self.down or self.centre else self.arr
        return unit.mode >= PWM1 and first <= unit.ccr <= last

    def _skip(self, tick: int) -> None:
        """Leave out whole periods up to `tick`, from a boundary on; all that recurs has happened once before."""
        if self.cnt > self.arr or not self.arr or any(unit.cleared for unit in self.units):
            return
        if self._waits_to_load() and not self.udis:
            return
        legs = 2 if self.centre else 1
        period = legs * self._whole_leg() * (self.psc + 1)
        periods = (tick - self.tick) // period
        if periods <= 0:
            return
        for unit in self.units:
            if unit.since > self.tick - period:
                unit.since += periods * period
        self.tick += periods * period
        boundaries = legs * periods
        if boundaries <= self.rep:
            self.rep -= boundaries
        else:
            self.rep = self.rcr - (boundaries - self.rep - 1) % (self.rcr + 1)
            if not self.udis:
                self.on_update()
        self._skip_toggles(periods)

    def _skip_toggles(self, periods: int) -> None:
        for unit in self.units:
            if unit.output and unit.mode == TOGGLE and self._matches_in_period(unit) * periods % 2:
                unit.ref = unit.out = not unit.ref
        if self.combines:
            for unit in self.units:
                unit.out = unit.combined(self.down)

    def _matches_in_period(self, unit: Compare) -> int:
        if unit.ccr > self.arr:
            return 0
        return 2 if self.centre and 0 < unit.ccr < self.arr else 1
