"""A host that asks a node again and again; who speaks in the dashboard."""

from enum import Enum

from protocols.common.device import Step, TableDevice
from protocols.common.framing import Dropped, ScanningReader
from tank.frames import GAP_NS, Read, SetValve, encode, look

ASK_EVERY_S = 0.2
VALVE_EVERY = 20  # so many questions, then the valve is moved
State = Enum("State", {"ASKING": "asks again and again"})
Trigger = Enum("Trigger", {"DUE": "time to ask"})
Timer = Enum("Timer", {"ASK": "until it asks again"})
TABLE = {(State.ASKING, Trigger.DUE): Step(State.ASKING, (Trigger.DUE,))}


class Host(TableDevice):
    """Asks for the level five times a second, and moves the valve now and then."""

    def __init__(self, settings):
        reader = ScanningReader(look, GAP_NS)
        super().__init__(reader, Dropped, TABLE, State.ASKING, {Timer.ASK: (Trigger.DUE, State)})
        self.asked = 0
        self.start(Timer.ASK, ASK_EVERY_S)

    def take(self, found):
        """Nothing: people look at the answers."""

    def act(self, action, trigger):
        """Ask, or move the valve; then wait."""
        self.asked += 1
        moves, turn = self.asked % VALVE_EVERY == 0, self.asked // VALVE_EVERY % 3
        self.transmit(encode(SetValve(50 * turn) if moves else Read()))
        self.start(Timer.ASK, ASK_EVERY_S)
