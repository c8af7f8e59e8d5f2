"""The head as a model: two servos on one bus, each with a state table, that drive the joints of a body in a world."""

import math
from dataclasses import dataclass
from enum import Enum

from pantilt.frames import GAP_NS, IDS, FrameError, Goal, Read, Refused, Status, Torque, Why, decode, encode, look
from protocols.common.device import Step, TableDevice
from protocols.common.framing import Dropped, ScanningReader

WATCHDOG_S = 1.0
LIMITS_DEG = {"pan": 90, "tilt": 60}  # to either side
GAIN_PER_S = 10.0  # speed for each radian that is missing
State = Enum("State", {"RELEASED": "no torque", "HOLDING": "goes to its goal", "TRIPPED": "let go by the watchdog"})
Trigger = Enum("Trigger", {"ON": "torque on", "OFF": "torque off", "SILENT": "no command for 1 s"})
Timer = Enum("Timer", {"WATCHDOG": "silence of the host"})

TABLE = {(state, Trigger.ON): Step(State.HOLDING) for state in State}
TABLE |= {(state, Trigger.OFF): Step(State.RELEASED) for state in State}
TABLE |= {(State.HOLDING, Trigger.SILENT): Step(State.TRIPPED)}


@dataclass(frozen=True)
class Settings:
    speed_deg_s: float = 60.0  # the fastest that a servo turns
    torque_nm: float = 0.6  # the most that it holds with


class Servo(TableDevice):
    """Answers each command that has its id; moves its joint while it has torque."""

    def __init__(self, joint, settings):
        reader, timers = ScanningReader(look, GAP_NS), {Timer.WATCHDOG: (Trigger.SILENT, {State.HOLDING})}
        super().__init__(reader, Dropped, TABLE, State.RELEASED, timers)
        self.joint, self.settings, self.goal_rad = joint, settings, 0.0

    def take(self, found):
        """Carry out a command, and answer it."""
        if found.raw[1] != IDS[self.joint]:
            return
        why = self.obey(found)
        self.start(Timer.WATCHDOG, WATCHDOG_S)
        self.transmit(encode(self.status() if why is None else Refused(IDS[self.joint], why.value)))

    def obey(self, found):
        """Do what a frame says; return why not."""
        try:
            command = decode(found)
        except FrameError:
            return Why.SENSELESS
        if isinstance(command, Torque):
            self.goal_rad = self.world.joint(self.joint).angle_rad
            self.fire(Trigger.ON if command.on else Trigger.OFF)
        elif isinstance(command, Goal):
            if abs(command.angle_cdeg) > 100 * LIMITS_DEG[self.joint]:
                return Why.OUT_OF_RANGE
            if self.state is not State.HOLDING:
                return Why.TORQUE_OFF
            self.goal_rad = math.radians(command.angle_cdeg / 100)
        elif not isinstance(command, Read):
            return Why.SENSELESS
        return None

    def status(self):
        """Return where the joint is, and its torque as a share of the most."""
        there, holds = self.world.joint(self.joint), self.state is State.HOLDING
        angle, load = round(100 * math.degrees(there.angle_rad)), round(100 * there.torque_nm / self.settings.torque_nm)
        return Status(IDS[self.joint], angle, load if holds else 0, holds, self.state is State.TRIPPED)

    def step(self):
        """Say how fast the joint turns until the next step, or let go of it."""
        if self.state is not State.HOLDING:
            return self.world.release(self.joint)
        wanted = GAIN_PER_S * (self.goal_rad - self.world.joint(self.joint).angle_rad)
        fastest = math.radians(self.settings.speed_deg_s)
        self.world.command(self.joint, max(-fastest, min(fastest, wanted)), self.settings.torque_nm)


class Head:
    """Two servos that hear the same bytes."""

    def __init__(self, settings):
        self.observed = {joint: Servo(joint, settings) for joint in IDS}
        self.servos = [*self.observed.values()]

    def enter(self, world):
        """Take the body, which is the world with its joints; see `hilbench.bench.placed_device.Embodied`."""
        for servo in self.servos:
            servo.world = world

    def step(self, now_ns):
        """Drive the joints from the next step on."""
        for servo in self.servos:
            servo.step()

    def look(self):
        """Return what the dashboard shows of it."""
        return {joint: math.degrees(one.world.joint(joint).angle_rad) for joint, one in self.observed.items()}

    def receive(self, data, now_ns):
        return b"".join(servo.receive(data, now_ns) for servo in self.servos)

    def advance(self, now_ns):
        return b"".join(servo.advance(now_ns) for servo in self.servos)

    def next_deadline_ns(self):
        return min((due for servo in self.servos if (due := servo.next_deadline_ns()) is not None), default=None)

    def line_down(self, now_ns):
        return b"".join(servo.line_down(now_ns) for servo in self.servos)

    def take_events(self):
        return [event for servo in self.servos for event in servo.take_events()]
