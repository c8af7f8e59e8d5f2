"""Turn indicators and hazard lights: what is commanded, what is reported, which lamps are lit when.

The messages are the driving stack's; that the board serves them at all is our choice (see `protocols.autoware`).
"""

from __future__ import annotations

from protocols.autoware import (
    HazardLights,
    HazardLightsCommand,
    HazardLightsReport,
    Time,
    TurnIndicators,
    TurnIndicatorsCommand,
    TurnIndicatorsReport,
)

__all__ = ["Lamps"]

_NS_PER_S = 1_000_000_000
_LEFT = frozenset({TurnIndicators.ENABLE_LEFT})
_RIGHT = frozenset({TurnIndicators.ENABLE_RIGHT})


class Lamps:
    """Both lamps. They begin with light, and are dark for the second half of each period.

    Args:
        blink_hz: how often they go on.
        epoch_ns: since when the periods count, in ns of bench time.

    Attributes:
        turn: what the turn indicators do.
        hazard: what the hazard lights do.
    """

    def __init__(self, blink_hz: float, epoch_ns: int) -> None:
        self._period_ns = round(_NS_PER_S / blink_hz)
        self._since_ns = epoch_ns
        self.turn = int(TurnIndicators.DISABLE)
        self.hazard = int(HazardLights.DISABLE)

    def take(self, command: TurnIndicatorsCommand | HazardLightsCommand, now_ns: int) -> None:
        """Obeys a command; what it does not know, and NO_COMMAND, changes nothing."""
        before = self.turn, self.hazard
        if isinstance(command, TurnIndicatorsCommand):
            if command.command in (TurnIndicators.DISABLE, *_LEFT, *_RIGHT):
                self.turn = command.command
        elif command.command in (HazardLights.DISABLE, HazardLights.ENABLE):
            self.hazard = command.command
        if (self.turn, self.hazard) != before:
            self._since_ns = now_ns

    def lit(self, now_ns: int) -> tuple[bool, bool]:
        """Whether the left and the right lamp are lit at a time."""
        light = (now_ns - self._since_ns) % self._period_ns < self._period_ns // 2
        both = self.hazard == HazardLights.ENABLE
        return light and (both or self.turn in _LEFT), light and (both or self.turn in _RIGHT)

    def reports(self, stamp: Time) -> tuple[TurnIndicatorsReport, HazardLightsReport]:
        """What the driving stack is told."""
        return TurnIndicatorsReport(stamp=stamp, report=self.turn), HazardLightsReport(stamp=stamp, report=self.hazard)
