"""The adapter as a part: pins of a Blue Pill on one side, the P2OS line of a robot on the other.

Two tasks run on it (pioneer_2DX-Interface code-esp32_d1 task_controller.cpp). The pin task takes a pass every
millisecond: it reads the motor wires five times in a burst and decodes the majority in the next pass; on p2dx_con it
has a verdict every 10 ms. A change of p2dx_con is acted on after one second of uptime: the robot's
session is opened or closed, and the echo follows the pin (not the robot). The other task has the robot, see `link.py`.

The reset line drives the enable input of the module through a transistor: high is reset. Nothing is driven then; all
is forgotten, also the session, which the robot has not: the next set-up finds it and closes it first.
"""

from __future__ import annotations

from collections.abc import Mapping

from protocols.p2os import PoseTracker, RobotParameters, Sip, read_sip
from targets.parts.gamepad import PAD_CONTROLS, PadMapping, PadState
from targets.parts.p2os_adapter.events import AdapterHeld, AdapterStarted
from targets.parts.p2os_adapter.link import RobotLink
from targets.parts.p2os_adapter.outputs import DistanceWires, EncoderWires
from targets.parts.p2os_adapter.pin_task import PinTask
from targets.parts.p2os_adapter.settings import P2osAdapterSettings
from targets.parts.p2os_adapter.velocity import STILL, Velocity
from targets.parts.part import Direction, Part, Ports, Terminal

__all__ = ["P2osAdapter"]

_MOTORS = tuple(f"m{motor}_comm{bit}" for motor in (1, 2) for bit in (1, 2, 3))
_LEFT, _RIGHT = (tuple(f"e{wheel}_s{bit}" for bit in (1, 2, 3)) for wheel in (1, 2))
_DISTANCES = tuple(f"dd{number}" for number in range(1, 9))

_SETTLE_NS = 200_000_000
"""SIPs so soon after SETO may still have the old pose: it takes 15 ms to the robot, and a SIP 40 back (choice)."""


def _terminals() -> tuple[Terminal, ...]:
    inputs = {
        **dict.fromkeys(_MOTORS[:3], "left motor"),
        **dict.fromkeys(_MOTORS[3:], "right motor"),
        "p2dx_con": "high: the robot is wanted",
        "rst": "high: reset",
        "mode": "high: Blue Pill, low: game pad; read at start",
    }
    outputs = {
        **dict.fromkeys(_DISTANCES, "high: obstacle"),
        **dict.fromkeys(_LEFT, "left encoder"),
        **dict.fromkeys(_RIGHT, "right encoder"),
        "echo": "high: p2dx_con was seen",
    }
    return (
        *(Terminal(name=name, direction=Direction.IN, text=text) for name, text in inputs.items()),
        *(Terminal(name=name, direction=Direction.OUT, text=text) for name, text in outputs.items()),
    )


class P2osAdapter(Part):
    """See the head of this file."""

    TERMINALS = _terminals()
    SERIAL = ("uart2",)
    CONTROLS = PAD_CONTROLS
    Settings = P2osAdapterSettings

    def __init__(self, settings: P2osAdapterSettings, ports: Ports, *, seed: int) -> None:  # noqa: ARG002
        self._settings = settings
        self._ports = ports
        self._reset_wire = ports.input("rst")
        self._mode_wire = ports.input("mode")
        self._pass_ns = round(settings.pass_ms * 1e6)
        self._due_ns: int | None = None
        self._last_pass_ns = 0
        self._running: _Program | None = None
        self._mapping = PadMapping(trigger_mm_s=settings.trigger_mm_s, stick_mrad_s=settings.stick_mrad_s)
        self._pad = PadState(self._mapping)

    def power_on(self, now_ns: int) -> None:
        """Begin to run, unless the reset line is high."""
        self._due_ns = now_ns
        self._last_pass_ns = now_ns
        if not self._reset_wire.level_at(now_ns):
            self._start(now_ns, "power")

    def next_deadline_ns(self) -> int | None:
        """The next pass of the program, or what its protocol waits for."""
        if self._due_ns is None or self._running is None:
            return self._due_ns
        protocol_ns = self._running.link.next_deadline_ns()
        return self._due_ns if protocol_ns is None else min(self._due_ns, protocol_ns)

    def advance(self, now_ns: int) -> None:
        """Take the passes that are due, and let timers of the protocol run out."""
        while (due_ns := self.next_deadline_ns()) is not None and due_ns <= now_ns:
            if due_ns == self._due_ns:
                self._due_ns = due_ns + self._pass_ns
                self._pass(due_ns)
            elif self._running is not None:
                self._running.link.advance(due_ns)

    def receive(self, data: bytes, now_ns: int) -> None:
        """Take bytes from the robot; in reset nobody hears them."""
        self.advance(now_ns)
        if self._running is not None:
            self._running.link.receive(data, now_ns)

    def set(self, values: Mapping[str, float], now_ns: int) -> None:  # noqa: ARG002
        """Move the game pad; raises ValueError as `Part.set` does. It drives in the mode ``gamepad`` only."""
        self._pad.set(values)

    def _pass(self, at_ns: int) -> None:
        since_ns, self._last_pass_ns = self._last_pass_ns, at_ns
        held = self._reset_wire.level_at(at_ns)
        if self._running is not None and (held or self._reset_wire.mean(since_ns, at_ns) > 0):
            self._hold(at_ns)
        if self._running is None and not held:
            self._start(at_ns, "reset line")
        if self._running is not None:
            self._running.take_pass(at_ns)

    def _hold(self, at_ns: int) -> None:
        self._running = None
        for terminal in self.TERMINALS:
            if terminal.direction is Direction.OUT:
                self._ports.output(terminal.name).set(None, at_ns)
        self._ports.tell(AdapterHeld())

    def _start(self, at_ns: int, cause: str) -> None:
        mode = self._settings.mode
        if mode == "pin":
            mode = "bluepill" if self._mode_wire.level_at(at_ns) else "gamepad"
        self._pad = PadState(self._mapping)
        self._running = _Program(self._settings, self._ports, self._pad if mode == "gamepad" else None, at_ns)
        self._ports.tell(AdapterStarted(mode=mode, cause=cause))


class _Program:
    """What runs on the adapter from one reset to the next.

    Args:
        settings: of the adapter.
        ports: what it is connected to.
        pad: who drives; None for the pins.
        now_ns: when it starts.
    """

    def __init__(self, settings: P2osAdapterSettings, ports: Ports, pad: PadState | None, now_ns: int) -> None:
        self._pad = pad
        self._pins = PinTask(settings, ports, _MOTORS, now_ns)
        self._distances = DistanceWires(settings, [ports.output(name) for name in _DISTANCES], ports.tell)
        left, right = ([ports.output(name) for name in names] for names in (_LEFT, _RIGHT))
        self._encoders = EncoderWires(settings, left, right, ports.tell)
        self._tracker: PoseTracker | None = None
        self._robot: RobotParameters | None = None
        self._settled_ns = 0
        self.link = RobotLink(
            settings,
            send=ports.serial,
            tell=ports.tell,
            on_session=self._begin_session,
            on_sip=self._take_sip,
            now_ns=now_ns,
        )
        self._distances.start(now_ns)
        self._encoders.start(now_ns)

    def take_pass(self, at_ns: int) -> None:
        wanted, velocity = self._follow_pins(at_ns) if self._pad is None else self._follow_pad(self._pad)
        self.link.want(wanted, at_ns)
        self.link.follow(velocity, at_ns)

    def _follow_pins(self, at_ns: int) -> tuple[bool, Velocity]:
        self._pins.take_pass(at_ns)
        return self._pins.connected, self._pins.velocity

    def _follow_pad(self, pad: PadState) -> tuple[bool, Velocity]:
        return pad.connected, Velocity(*pad.velocity) if pad.connected else STILL

    def _begin_session(self, robot: RobotParameters, now_ns: int) -> None:
        self._robot = robot
        self._tracker = PoseTracker(robot)
        self._encoders.restart()
        self._settled_ns = now_ns + _SETTLE_NS

    def _take_sip(self, sip: Sip, now_ns: int) -> None:
        if self._robot is None or self._tracker is None:
            return
        self._distances.update(read_sip(sip, self._robot).sonars_mm, now_ns)
        if now_ns >= self._settled_ns:
            self._encoders.update(self._tracker.update(sip), now_ns)
