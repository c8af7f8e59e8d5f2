"""Masters that have made a START on one I2C bus at the same cycle (UM10204 sections 3.1.7 and 3.1.8).

SCL is low as long as one of them holds it, so a move (the bits of a byte, an acknowledge, a condition) begins when all
are ready; its clocks have the longest low and the shortest high. One that lets SDA go where another pulls it low has
lost, and leaves. Those that do the same go on together: the first of them leads, and its bus calls the slaves for all.

A STOP against data, or a repeated START, is not allowed there (section 3.1.8). It goes as the wires have it: whoever
has SDA high at the first clock loses to one that has it low, and data 1 loses to a condition, a STOP to data 0.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from targets.mcu.i2c_bus import I2cBus

__all__ = ["Contest", "Move"]

_DATA_0, _STOP, _RESTART, _DATA_1 = "0123"  # whichever is less wins


@dataclass(frozen=True, slots=True)
class Move:
    """What one master is about to do.

    Attributes:
        levels: of SDA, clock by clock; see `bits`.
        low: how long it has SCL low, in cycles of HCLK,
        high: and high.
        lead: called to do it, for all who do the same, with what of low and high has come of it.
        follow: called when who leads has done it, with the byte that was read, or whether one was acknowledged.
        lose: called with how many cycles later it loses.
    """

    levels: str
    low: Fraction | int
    high: Fraction | int
    lead: Callable[[Fraction | int, Fraction | int], None]
    follow: Callable[[int], None]
    lose: Callable[[Fraction | int], None]

    @staticmethod
    def bits(word: int, count: int) -> str:
        """Return the levels of so many bits, the highest first."""
        return "".join(_DATA_1 if word >> count - 1 - index & 1 else _DATA_0 for index in range(count))

    STOP = _STOP
    RESTART = _RESTART


class Contest:
    """See the module.

    Args:
        leader: the bus of the master whose START was heard first.
    """

    def __init__(self, leader: I2cBus) -> None:
        self._buses: list[I2cBus] = []
        self._offered: dict[I2cBus, Move] = {}
        self._current: dict[I2cBus, Move] = {}
        self.join(leader)

    def join(self, bus: I2cBus) -> None:
        """Take part from now on."""
        self._buses.append(bus)
        bus.contest = self

    def leads(self, bus: I2cBus) -> bool:
        """Say whether this is the bus that calls the slaves."""
        return self._buses[0] is bus

    def offer(self, bus: I2cBus, move: Move) -> None:
        """Be ready for a move."""
        self._offered[bus] = move
        self._begin()

    def over(self, bus: I2cBus, result: int) -> None:
        """The move that this bus has led is over."""
        moves, self._current = self._current, {}
        for other, move in moves.items():
            if other is not bus:
                move.follow(result)

    def leave(self, bus: I2cBus) -> None:
        """Let go of both lines in the middle. What this one has led begins anew (choice)."""
        led = self.leads(bus) and bus in self._current
        self._offered.pop(bus, None)
        self._current.pop(bus, None)
        self._remove(bus)
        if led:
            self._offered, self._current = self._current, {}
        self._begin()

    def _begin(self) -> None:
        moves = self._offered
        if len(moves) < len(self._buses) or not moves:
            return
        self._offered = {}
        low, high = max(move.low for move in moves.values()), min(move.high for move in moves.values())
        best = min(move.levels for move in moves.values())
        for bus, move in tuple(moves.items()):
            if move.levels != best:
                clocks = next(clock for clock, level in enumerate(best) if move.levels[clock] != level)
                del moves[bus]
                self._remove(bus)
                move.lose(clocks * (low + high) + low)
        self._current = moves
        moves[self._buses[0]].lead(low, high)

    def _remove(self, bus: I2cBus) -> None:
        led = self.leads(bus)
        self._buses.remove(bus)
        bus.contest = None
        if led:
            bus.hand_over(self._buses[0])
        if len(self._buses) == 1:
            self._buses[0].contest = None
