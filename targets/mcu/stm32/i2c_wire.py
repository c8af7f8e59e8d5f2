"""Conditions and bytes of an I2C master on its bus: one at a time, each as long as the timing says.

Between two of them SCL is low and nothing happens: that is how the master stretches the clock. A slave may hold SCL low
after a byte by itself (`I2cBus.stretch_ns`, `I2cBus.held`); the next condition or byte begins after that. Another
master that has made a START at the same cycle contends for the bus (`targets.mcu.i2c_contest`).

Choices: SDA that is held low from outside (`I2cBus.stick`) is noticed at the beginning of a condition or byte. A change
of the kernel clock stretches or shortens what is left of the present condition or byte.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial

from targets.mcu.i2c_bus import I2cBus
from targets.mcu.i2c_contest import Contest, Move
from targets.mcu.stm32.i2c_levels import I2cLevels
from targets.mcu.stm32.i2c_timing import Timing
from targets.mcu.timebase import Event, Timebase

__all__ = ["Wire"]


@dataclass(frozen=True, slots=True)
class _Action:
    """Something that a master does with SCL.

    Attributes:
        begin: called when SCL is let go, with how long everything takes.
        levels: of SDA, see `Move`.
        follow: called instead of what comes of `begin`, if another master has done the same and called the slaves.
    """

    begin: Callable[[Timing], None]
    levels: str
    follow: Callable[[int], None]


class Wire:
    """See the module. Each method begins something, and may be called when nothing is under way: see `busy`.

    Args:
        time: the chip's cycles and events.
        bus: where it happens.

    Attributes:
        timing: how long everything takes; None while the kernel clock stands still.
        on_start: called when SDA has fallen for a START.
        on_started: called when SCL has followed it.
        on_sent: called after the ninth clock of a byte that was sent, with whether it was acknowledged.
        on_byte: called after the eighth clock of a byte that was read.
        on_received: called after its ninth clock.
        on_stop: called when SDA has risen for a STOP.
        on_clock: called when SCL, which was low, is let go for the next condition or byte.
        levels: who draws what is done; None while nobody wants to see it.
        on_lost: called when SDA is low where it should be high; both lines were let go then.
    """

    def __init__(self, time: Timebase, bus: I2cBus) -> None:
        self.timing: Timing | None = None
        self.on_start: Callable[[], None] = lambda: None
        self.on_started: Callable[[], None] = lambda: None
        self.on_sent: Callable[[bool], None] = lambda _acknowledged: None
        self.on_byte: Callable[[int], None] = lambda _byte: None
        self.on_received: Callable[[], None] = lambda: None
        self.on_stop: Callable[[], None] = lambda: None
        self.on_clock: Callable[[], None] = lambda: None
        self.on_lost: Callable[[], None] = lambda: None
        self.levels: I2cLevels | None = None
        self._time = time
        self._bus = bus
        self._action: Callable[[], None] | None = None
        self._event: Event | None = None
        # Moments are HCLK cycles, and fractions of them where the kernel clock is no divisor of HCLK.
        self._due: Fraction | int = 0
        self._begun: Fraction | int = 0
        self._left_clocks: Fraction | int = 0
        self._chain: Fraction | int | None = None
        self._low_until: Fraction | int = 0
        self._free_from: Fraction | int = 0
        self._reads = False  # a byte comes in
        self._held_up: _Action | None = None  # what begins when an interface lets go of SCL, or another master does
        self._offers = False  # it is known to who contends
        bus.on_free.append(self._go_on)

    @property
    def busy(self) -> bool:
        """Whether something is under way."""
        return self._action is not None or self._held_up is not None

    @property
    def held(self) -> bool:
        """Whether a slave holds SCL low after the last byte."""
        return self._bus.held or self._present() < self._low_until

    @property
    def undrawn(self) -> Fraction | int | None:
        """When what is under way has begun, which is not drawn yet; None if nothing is."""
        return self._begun if self.busy else None

    # --- what can be done

    def start(self) -> None:
        """A START on a free bus, not before t_BUF has passed since the last STOP."""
        self._begun = max(self._present(), self._free_from)
        self._at(self._begun, self._start)

    def restart(self) -> None:
        """A repeated START."""
        begin = _Action(lambda timing: self._after(timing.restart, self._restart), Move.RESTART, self._restarted)
        self._when_released(begin)

    def send_address(self, byte: int) -> None:
        """The byte after a START: address and direction."""
        self._send(byte, lambda: self._bus.address(byte >> 1, bool(byte & 1), self._now_ns()))

    def send(self, byte: int) -> None:
        """A byte of data, or the second one of a 10-bit address."""
        self._send(byte, lambda: self._bus.write(byte, self._now_ns()))

    def receive(self) -> None:
        """Eight clocks, in which a byte comes in."""
        self._when_released(_Action(self._receive, Move.bits(0xFF, 8), self.on_byte))

    def acknowledge(self, acknowledge: bool) -> None:
        """The ninth clock after `receive`."""
        end = self._lose if self._bus.stuck and not acknowledge else partial(self._received, acknowledge)
        level = Move.bits(not acknowledge, 1)
        begin = _Action(lambda timing: self._after(timing.bit, end), level, lambda _result: self.on_received())
        self._when_released(begin)

    def wait_for_free(self) -> None:
        """There was a STOP, of whichever master: t_BUF passes before a START."""
        if self.timing is not None:
            self._free_from = self._present() + self.timing.free * self.timing.cycles

    def stop(self) -> None:
        """A STOP."""
        end = self._lose if self._bus.stuck else self._stop
        self._when_released(_Action(lambda timing: self._after(timing.bit, end), Move.STOP, self._has_stopped))

    def cancel(self) -> None:
        """Do not go on with what is under way; SCL stays low."""
        self._time.cancel(self._event)
        self._action = self._held_up = None
        self._reads = self._offers = False

    def release(self) -> None:
        """Let go of both lines, whatever is under way."""
        clock = self._clock_of_byte() if self.busy else 0
        self.cancel()
        self._low_until = 0
        if self._bus.contest is not None:
            self._bus.contest.leave(self._bus)
        self._let_go(clock)

    def meets(self, other: I2cBus) -> bool:
        """Another master has made a START: return whether this one does so at the same cycle, and contends with it."""
        if self._action != self._start or math.ceil(self._due) > self._time.now:
            return False
        contest = other.contest or Contest(other)
        contest.join(self._bus)
        return True

    # --- clock

    def set_timing(self, timing: Timing | None) -> None:
        """Go on at another rate of the kernel clock, or with other settings; without a clock, wait for one."""
        now = self._time.now
        if self._action is not None and self.timing is not None:
            self._left_clocks = Fraction(max(0, self._due - now)) / self.timing.cycles
            self._time.cancel(self._event)
        self.timing = timing
        if self._action is not None and timing is not None:
            self._at(now + self._left_clocks * timing.cycles, self._action)

    def _at(self, due: Fraction | int, action: Callable[[], None]) -> None:
        self._due, self._action = due, action
        if self.timing is None:
            self._left_clocks = 0
        else:
            self._event = self._time.at(math.ceil(due), self._fire)

    def _after(self, clocks: int, action: Callable[[], None]) -> None:
        assert self.timing is not None
        self._at(self._present() + clocks * self.timing.cycles, action)

    def _fire(self) -> None:
        action, self._action = self._action, None
        assert action is not None
        # What follows at once begins at the exact moment, and not at the cycle after it.
        self._chain = self._due
        action()
        self._chain = None

    def _present(self) -> Fraction | int:
        return self._time.now if self._chain is None else self._chain

    def _now_ns(self) -> int:
        return self._time.ns(self._time.now)

    def _when_released(self, action: _Action) -> None:
        """Begin something when nobody else holds SCL low any more."""
        if self._bus.held:
            self._begun = self._present()
            self._held_up = action
        elif self.timing is None or self.held:
            self._begun = max(self._present(), self._low_until)
            self._at(self._begun, partial(self._when_released, action))
        elif self._bus.contest is not None:
            self._offer(self._bus.contest, action, self.timing)
        else:
            self._begin(action, self.timing)

    def _go_on(self) -> None:
        if self._held_up is not None and not self._offers:
            action, self._held_up = self._held_up, None
            self._when_released(action)

    def _begin(self, action: _Action, timing: Timing) -> None:
        self._begun = self._present()
        self.on_clock()
        action.begin(timing)

    def _offer(self, contest: Contest, action: _Action, timing: Timing) -> None:
        def no_more() -> None:
            self._held_up, self._offers = None, False

        def lead(low: Fraction | int, high: Fraction | int) -> None:
            no_more()
            clocks = (math.ceil(low / timing.cycles), math.ceil(high / timing.cycles))
            self._begin(action, replace(timing, low=clocks[0], high=clocks[1]))

        def follow(result: int) -> None:
            no_more()
            self.on_clock()
            action.follow(result)

        def lose(cycles: Fraction | int) -> None:
            no_more()
            self._at(self._present() + cycles, self._lose)

        self._begun = self._present()
        self._held_up, self._offers = action, True
        low, high = timing.low * timing.cycles, timing.high * timing.cycles
        contest.offer(self._bus, Move(action.levels, low, high, lead, follow, lose))

    def _tell(self, result: int) -> None:
        """Let those who have done the same know what has come of it."""
        if self._bus.contest is not None:
            self._bus.contest.over(self._bus, result)

    # --- inside

    def _restart(self) -> None:
        if self.levels is not None and self.timing is not None:
            self.levels.restart(self._begun, self.timing)
        self._start()
        self._tell(0)

    def _start(self) -> None:
        if self._bus.contest is None or self._bus.contest.leads(self._bus):
            self._bus.start(self._now_ns())
        self._restarted(0)

    def _restarted(self, _result: int) -> None:
        if self.levels is not None:
            self.levels.start(self._present())
        self.on_start()
        assert self.timing is not None
        self._after(self.timing.hold, self._started)

    def _started(self) -> None:
        if self.levels is not None:
            self.levels.clock_low(self._present())
        self.on_started()

    def _draw(self, word: int, count: int) -> None:
        if self.levels is not None and self.timing is not None:
            self.levels.bits(self._begun, self.timing, word, count)

    def _send(self, byte: int, pass_on: Callable[[], bool]) -> None:
        def begin(timing: Timing) -> None:
            if self._bus.stuck and byte:
                self._after((8 - byte.bit_length()) * timing.bit + timing.low, self._lose)
            else:
                self._after(9 * timing.bit, end)

        def end() -> None:
            acknowledged = pass_on()
            self._draw(byte << 1 | (not acknowledged), 9)
            self._stretch()
            self._tell(acknowledged)
            self.on_sent(acknowledged)

        self._when_released(_Action(begin, Move.bits(byte, 8), lambda result: self.on_sent(bool(result))))

    def _receive(self, timing: Timing) -> None:
        byte = self._bus.read(self._now_ns())
        self._reads = True
        self._after(8 * timing.bit, partial(self._byte_in, byte))

    def _byte_in(self, byte: int) -> None:
        self._reads = False
        self._draw(byte, 8)
        self._tell(byte)
        self.on_byte(byte)

    def _received(self, acknowledged: bool) -> None:
        self._draw(not acknowledged, 1)
        self._bus.answer(acknowledged, self._now_ns())
        self._stretch()
        self._tell(0)
        self.on_received()

    def _stretch(self) -> None:
        held_ns = self._bus.stretched_ns
        if held_ns:
            self._low_until = self._time.cycle_at_ns(self._now_ns() + held_ns)

    def _stop(self) -> None:
        self._bus.stop(self._now_ns())
        if self.levels is not None and self.timing is not None:
            self.levels.stop(self._begun, self.timing)
        self._tell(0)
        self._has_stopped(0)

    def _has_stopped(self, _result: int) -> None:
        self._bus.contest = None
        self.wait_for_free()
        self.on_stop()

    def _lose(self) -> None:
        self._let_go()
        self.on_lost()

    def _clock_of_byte(self) -> int:
        """Return which clock of a byte that comes in it is, 1 to 8; 0 if none does."""
        if not self._reads or self.timing is None:
            return 0
        return 1 + min(int((self._present() - self._begun) / (self.timing.bit * self.timing.cycles)), 7)

    def _let_go(self, clock: int = 0) -> None:
        if self.levels is not None:
            self.levels.release(self._present())
        self._bus.release(self._now_ns(), clock)
