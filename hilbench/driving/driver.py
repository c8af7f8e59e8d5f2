"""Who drives on a live bench: the demo driver until somebody takes over, then that somebody as long as he holds on.

A terminal tells of keys that are pressed and repeated, never of keys that are let go. So whoever drives by hand has to
say so again and again; `DEAD_MAN_NS` after the last time the vehicle is stopped.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Protocol

from hilbench.bench import Bench
from hilbench.clock import NS_PER_MS, NS_PER_S, EventClass
from hilbench.driving.control import Request
from hilbench.driving.operators import Operator

__all__ = ["DEAD_MAN_NS", "DEMO", "Driver", "Drives"]

DEAD_MAN_NS = 700 * NS_PER_MS
"""Longer than the first delay of usual keyboards before a key repeats, 0.25 to 0.66 s (choice)."""
DEMO = "figure-of-eight"
"""The demo driver: in circles, one way and then the other; on the spot where something is near."""
_STEP_NS = 50 * NS_PER_MS
_CIRCLE_NS = 20 * NS_PER_S
_NEAR_M = 0.7
_ROUNDS = ((1, 1), (1, -1))
_BLIND_ROUNDS = ((1, 1), (-1, -1), (1, -1), (-1, 1))
"""The signs of forward and turn, circle after circle. Who sees nothing ahead goes back each way that he came."""
_CONNECT_AGAIN_NS = 3 * NS_PER_S
_TIDY_EVERY_NS = 5 * NS_PER_S


class Drives(Protocol):
    """Whoever drives, or has somebody drive."""

    demo: bool
    who: tuple[str, float, float]
    """Who drives, and with which shares, as reported last."""

    @property
    def by_hand(self) -> bool:
        """Whether somebody here may take over."""

    @property
    def commands(self) -> Mapping[str, Callable[[Request], None]]:
        """What else it can be asked for, by the names of actions."""

    def take(self, forward: float, turn: float, *, pad: bool = False) -> None:
        """Drive by hand: shares of -1 to 1, forward and counter-clockwise, for `DEAD_MAN_NS` from now.

        Args:
            forward: of what is usual.
            turn: as above.
            pad: of what is usual at a game pad.
        """

    def stop(self) -> None:
        """Stop at once, whoever drives; the demo driver does not go on by itself."""

    def begin_demo(self) -> None:
        """Let the demo driver go on."""


class Driver:
    """See the module.

    Args:
        bench: whose time passes.
        operator: who speaks to the target.
        demo: whether the demo driver begins.
    """

    by_hand = True

    def __init__(self, bench: Bench, operator: Operator, *, demo: bool) -> None:
        self._bench = bench
        self._operator = operator
        self._wanted = (0.0, 0.0)
        self._held_until_ns = 0
        self._stopped = True
        self._next_try_ns = 0
        self._next_tidy_ns = 0
        self.who = ("", 0.0, 0.0)
        self.demo = demo
        self._say(DEMO if demo else "nobody")
        self._step()

    @property
    def commands(self) -> Mapping[str, Callable[[Request], None]]:
        """See `Drives`."""
        return {"connect": lambda _: self._operator.connect(), "disconnect": lambda _: self._leave()}

    def take(self, forward: float, turn: float, *, pad: bool = False) -> None:
        """See `Drives`."""
        self.demo = False
        turn *= self._operator.pad_turn if pad else 1.0
        changed = (forward, turn) != self._wanted or self._stopped
        self._wanted = (forward, turn)
        self._held_until_ns = self._bench.now_ns + DEAD_MAN_NS
        self._stopped = False
        if changed:
            self._say("user")
            self._operator.drive(forward, turn)

    def stop(self) -> None:
        """Stop at once, whoever drives; the demo driver does not go on by itself."""
        self.demo = False
        self._release("nobody")

    def begin_demo(self) -> None:
        """Let the demo driver go on."""
        self.demo = True
        self._next_try_ns = self._bench.now_ns
        self._say(DEMO)

    def _step(self) -> None:
        now_ns = self._bench.now_ns
        if self.demo:
            self._demonstrate(now_ns)
        elif not self._stopped and now_ns >= self._held_until_ns:
            self._release("dead man")
        elif not self._stopped:
            self._operator.drive(*self._wanted)
        if now_ns >= self._next_tidy_ns:
            self._next_tidy_ns = now_ns + _TIDY_EVERY_NS
            self._operator.tidy()
        self._bench.scheduler.after(_STEP_NS, self._step, order=EventClass.CONTROL, source="~driver")

    def _demonstrate(self, now_ns: int) -> None:
        if self._operator.idle and now_ns >= self._next_try_ns:
            self._next_try_ns = now_ns + _CONNECT_AGAIN_NS
            self._operator.connect()
        room_m = self._operator.room_ahead_m
        rounds = _BLIND_ROUNDS if room_m is None else _ROUNDS
        ahead, way = rounds[now_ns // _CIRCLE_NS % len(rounds)]
        if room_m is not None and room_m < _NEAR_M:
            self._operator.drive(0.0, 0.6 * way)
        else:
            forward, turn = self._operator.circle
            self._operator.drive(forward * ahead, turn * way)

    def _leave(self) -> None:
        self.stop()
        self._operator.disconnect()

    def _release(self, who: str) -> None:
        self._stopped = True
        self._wanted = (0.0, 0.0)
        self._operator.drive(0.0, 0.0)
        self._say(who)

    def _say(self, who: str) -> None:
        forward, turn = self._wanted
        if (who, forward, turn) != self.who:
            self.who = (who, forward, turn)
            self._bench.record("driver", "drive", who=who, forward=forward, turn=turn)
