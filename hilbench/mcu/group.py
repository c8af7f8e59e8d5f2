"""The emulated chips of a bench, run ahead of bench time by one actor.

An entry of the scheduler lets all chips run from its instant to that of the next entry of anybody else, but no further
than `step_ns`, nor than the bench is to run. What they put out comes back through callbacks and becomes entries at
their own times. What somebody will react to ends the run right there (a horizon), so that the reaction finds the chip
at that instant. So on a bench without anything real, whatever reaches a chip reaches it at its exact time. What comes
from outside in real time is taken when the chip's present has been reached already: at most one step late.

Several chips that wires or lines join advance in turns of `MachineGroup.turn_ns`: what one tells another arrives at its
exact time if the other has not been there yet, and else late, by less than a turn. A frame on a serial line is sampled
at its exact time all the same, if it arrives before its stop bit; so turns are shorter than the frames.

In real time a span may take the host longer than it lasts, as one with bursts of bytes at 921600 baud does. What the
chips have put out by then is not kept until they are through with it: the run ends there, too (`MachineGroup.breathe`).
"""

from __future__ import annotations

import heapq
import itertools
from collections.abc import Callable

from hilbench.bench import Bench
from hilbench.clock import NS_PER_MS, NS_PER_S, EventClass, Stopwatch
from hilbench.mcu.seams import Ending, Machine, first_ending

__all__ = ["FREE_STEP_NS", "LOCKED_STEP_NS", "ChipTime", "MachineGroup"]

LOCKED_STEP_NS = NS_PER_MS
"""How far the chips run ahead of the wall clock: what comes from outside is at most this late (choice)."""
FREE_STEP_NS = 10 * NS_PER_MS
"""How far they run at once where nothing is real; it changes nothing but how much is collected (choice)."""


class MachineGroup:
    """The chips of one bench.

    Args:
        bench: whose time they live in.
        machines: the chips by name; all stand at the bench's present.
        step_ns: how far they run at once.

    Attributes:
        turn_ns: how far one runs before the others follow; it may be changed at any time. Not beyond `step_ns` anyway.
        asleep_step_ns: how far they run at once where all programs sleep at the beginning of a round, and bench time
            follows no host; `step_ns` at first. Whoever watches for something between rounds sees it that much later.
        after_round: called after each round, with the bench time that all chips have reached.
        on_ended: called once, at the bench time of it, with name and ending of the first chip that does not run on.
    """

    def __init__(self, bench: Bench, machines: dict[str, Machine], *, step_ns: int) -> None:
        self.turn_ns = step_ns
        self.after_round: list[Callable[[int], None]] = []
        self.on_ended: Callable[[str, Ending], None] = lambda _name, _ending: None
        self.asleep_step_ns = step_ns
        self._bench = bench
        self._scheduler = bench.scheduler
        self._machines = machines
        self._step_ns = step_ns
        self._limit_ns = 0
        self._outputs: list[tuple[int, int, EventClass, str, Callable[[], None]]] = []
        self._sequence = itertools.count()
        self._stopped = False
        self._round_watch: Stopwatch | None = None  # of a round in real time
        self._book(bench.now_ns)

    @property
    def ended(self) -> bool:
        """True once a chip does not run on; then none of them does."""
        return self._stopped

    def output(
        self, ns: int, action: Callable[[], None], *, order: EventClass = EventClass.BYTE, source: str, reacts: bool
    ) -> None:
        """Have `action` happen at `ns`, something that a chip does; called while it runs.

        Args:
            ns: bench time in the chip's present or future.
            action: what it does to the bench.
            order: its class among entries of the same nanosecond.
            source: who does it.
            reacts: whether anybody may answer, so that no chip may run beyond `ns` before the action has happened.
        """
        if not reacts:
            heapq.heappush(self._outputs, (ns, next(self._sequence), order, source, action))
            return
        self._scheduler.at(max(ns, self._scheduler.now_ns), action, order=order, source=source)
        self.limit(ns)

    def limit(self, ns: int) -> None:
        """Let no chip run beyond `ns` before the bench has been there; called while one runs."""
        if ns < self._limit_ns:
            self._limit_ns = ns
            for machine in self._machines.values():
                machine.horizon(ns)

    def breathe(self, ns: int) -> bool:
        """End a round in real time at `ns` if it has taken the host longer than a step lasts; called while one runs.

        Args:
            ns: the chip's present, in ns of bench time.

        Returns:
            Whether it ends.
        """
        watch = self._round_watch
        ends = watch is not None and watch.elapsed_s() * NS_PER_S > self._step_ns
        if ends:
            self.limit(ns)
        return ends

    def stop(self) -> None:
        """Let no chip run any more."""
        self._stopped = True

    def _book(self, when_ns: int) -> None:
        # Last of its instant: what happens to a chip at an instant must happen before it runs on from there.
        self._scheduler.at(when_ns, self._round, order=EventClass.CHECK, source="~chips")

    def _round(self) -> None:
        if self._stopped:
            return
        now_ns = reached_ns = self._scheduler.now_ns
        self._round_watch = self._scheduler.stopwatch()
        far = self.asleep_step_ns > self._step_ns and self._all_asleep()
        self._limit_ns = now_ns + (self.asleep_step_ns if far else self._step_ns)
        for bound_ns in (self._scheduler.next_ns(), self._scheduler.deadline_ns):
            if bound_ns is not None:
                self._limit_ns = min(self._limit_ns, max(bound_ns, now_ns + 1))
        while reached_ns < self._limit_ns and not self._stopped:
            turn_ns = reached_ns + self.turn_ns if len(self._machines) > 1 else self._limit_ns
            for machine in self._machines.values():
                machine.run_to(min(turn_ns, self._limit_ns))
                self._stopped = self._stopped or machine.ended is not None
            reached_ns = min(turn_ns, self._limit_ns)
        self._end_round(max(reached_ns, now_ns))

    def _all_asleep(self) -> bool:
        """Say whether nothing will happen for long: nobody waits for the host's clock, and all programs sleep."""
        return not self._scheduler.locked and all(one.asleep is not None for one in self._machines.values())

    def _end_round(self, reached_ns: int) -> None:
        if self._stopped:
            reached_ns = self._tell_ending(reached_ns)
        for callback in self.after_round:
            callback(reached_ns)
        while self._outputs and self._outputs[0][0] <= reached_ns:
            ns, _, order, source, action = heapq.heappop(self._outputs)
            self._scheduler.at(max(ns, self._scheduler.now_ns), action, order=order, source=source)
        self._bench.journal.flush_step()
        if not self._stopped:
            self._book(reached_ns)

    def _tell_ending(self, reached_ns: int) -> int:
        """Book what is to be said of the end; return the bench time of it."""
        names = list(self._machines)
        first = first_ending(list(self._machines.values()))
        if first is None:
            return reached_ns
        number, ending = first
        when_ns = max(ending.ns, self._scheduler.now_ns)
        self._scheduler.at(
            when_ns, lambda: self.on_ended(names[number], ending), order=EventClass.CHECK, source="~chips"
        )
        return when_ns


class ChipTime:
    """The time of one chip, for transmitters that send to it; it may be ahead of the bench.

    Args:
        bench: the bench.
        machine: the chip.
    """

    def __init__(self, bench: Bench, machine: Machine) -> None:
        self._scheduler = bench.scheduler
        self._machine = machine

    @property
    def now_ns(self) -> int:
        """The present of whichever is ahead, in ns of bench time."""
        return max(self._scheduler.now_ns, self._machine.now_ns)

    def at(self, when_ns: int, action: Callable[[], None], *, order: EventClass, source: str) -> None:
        """Have `action` happen when the chip has reached `when_ns`."""
        del order, source  # a chip has an order of its own
        self._machine.at_ns(when_ns, action)
