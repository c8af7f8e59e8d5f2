"""The node at the tank as a model: its state table, and what it answers."""

from dataclasses import dataclass
from enum import Enum

from protocols.common.device import Step, TableDevice
from protocols.common.framing import Dropped, ScanningReader
from tank.frames import GAP_NS, FrameError, Level, Read, Refused, SetValve, decode, encode, look

WATCHDOG_S = 1.0
State = Enum("State", {"SHUT": "valve shut", "OPEN": "valve open", "TRIPPED": "valve shut by the watchdog"})
Trigger = Enum("Trigger", {"OPENED": "SetValve", "CLOSED": "SetValve 0 %", "SILENT": "no command for 1 s"})
Timer = Enum("Timer", {"WATCHDOG": "silence of the host"})

TABLE = {(state, Trigger.OPENED): Step(State.OPEN) for state in State}
TABLE |= {(state, Trigger.CLOSED): Step(State.SHUT) for state in State}
TABLE |= {(State.OPEN, Trigger.SILENT): Step(State.TRIPPED)}


@dataclass(frozen=True)
class Settings:
    level_mm: int = 1200  # how full the tank is


class Node(TableDevice):
    """Answers each command; shuts an open valve after a second without one."""

    def __init__(self, settings):
        reader, timers = ScanningReader(look, GAP_NS), {Timer.WATCHDOG: (Trigger.SILENT, {State.OPEN})}
        super().__init__(reader, Dropped, TABLE, State.SHUT, timers)
        self.settings, self.percent = settings, 0

    def take(self, found):
        """Carry out a command, and answer it."""
        try:
            command = decode(found.payload)
        except FrameError:
            command = None
        if isinstance(command, SetValve) and command.percent <= 100:
            self.percent = command.percent
            self.fire(Trigger.OPENED if command.percent else Trigger.CLOSED)
        elif not isinstance(command, Read):
            return self.transmit(encode(Refused(found.payload[0])))
        self.start(Timer.WATCHDOG, WATCHDOG_S)
        percent = self.percent if self.state is State.OPEN else 0
        self.transmit(encode(Level(self.settings.level_mm, percent, self.state is State.TRIPPED)))
