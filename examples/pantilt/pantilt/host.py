"""A host that sweeps the room with the camera; who speaks in the dashboard."""

from enum import Enum

from pantilt.frames import GAP_NS, IDS, Goal, Read, Torque, encode, look
from protocols.common.device import Step, TableDevice
from protocols.common.framing import Dropped, ScanningReader

EVERY_S = 0.1
TURNS = 25  # of so long each before the next place
PLACES_DEG = ((60, 20), (0, 0), (-60, 20), (0, -30))  # pan, tilt
State = Enum("State", {"SWEEPING": "looks from place to place"})
Trigger = Enum("Trigger", {"DUE": "time for the next turn"})
Timer = Enum("Timer", {"TURN": "until the next turn"})
TABLE = {(State.SWEEPING, Trigger.DUE): Step(State.SWEEPING, (Trigger.DUE,))}


class Host(TableDevice):
    """Asks both servos ten times a second, and sends them to another place now and then."""

    def __init__(self, settings):
        timers = {Timer.TURN: (Trigger.DUE, State)}
        super().__init__(ScanningReader(look, GAP_NS), Dropped, TABLE, State.SWEEPING, timers)
        self.turn = 0
        self.start(Timer.TURN, EVERY_S)

    def take(self, found):
        """Nothing: people look at the answers."""

    def act(self, action, trigger):
        """Ask, or move; then wait."""
        place = PLACES_DEG[self.turn // TURNS % len(PLACES_DEG)]
        for servo, degrees in zip(IDS.values(), place, strict=True):
            if self.turn == 0:
                self.transmit(encode(Torque(servo, True)))
            self.transmit(encode(Read(servo) if self.turn % TURNS else Goal(servo, 100 * degrees)))
        self.turn += 1
        self.start(Timer.TURN, EVERY_S)
