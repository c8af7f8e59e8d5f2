"""A vehicle-interface board from power-on: bytes of both its lines, a joystick, three lights and two lamps.

It is a device at two lines: ``usart2`` leads to the simulator, ``usart3`` to the driving stack, as on the original's
NUCLEO-H753ZI. Computing takes no time, nor does a frame on its way into the transmit buffer.
"""

from __future__ import annotations

from collections.abc import Iterable

from protocols import autoware, carla
from protocols.autoware import (
    AckermannControlCommand,
    Clock,
    ControlModeReport,
    ControlModeRequest,
    ControlModeResponse,
    HazardLightsCommand,
    MessageReceived,
    SteeringReport,
    Time,
    TurnIndicatorsCommand,
    VelocityReport,
)
from protocols.carla import (
    ControlCommand,
    LampChanged,
    Mode,
    ModeAnswered,
    ModeReported,
    StatusReported,
)
from protocols.state_machine import earliest
from targets.robots.vehicle_interface.behaviour import BEHAVIOURS, Behaviour
from targets.robots.vehicle_interface.defects import DEFECTS
from targets.robots.vehicle_interface.events import LightsSwitched
from targets.robots.vehicle_interface.lamps import Lamps
from targets.robots.vehicle_interface.settings import SIMULATOR_LINE, STACK_LINE, VehicleSettings

__all__ = ["Sent", "VehicleInterface", "behaviour_of"]

Sent = list[tuple[str, bytes]]
"""What is to be put on the lines, in this order."""

_NS_PER_S = 1_000_000_000
_LIGHTS = {Mode.MANUAL: "green", Mode.AUTOWARE: "amber", Mode.EMERGENCY: "red"}


def behaviour_of(settings: VehicleSettings) -> Behaviour:
    """How a board behaves that is set to these: its profile, with the defects that are put into it."""
    behaviour = BEHAVIOURS[settings.profile]
    for name in settings.defects:
        behaviour = DEFECTS[name].put_into(behaviour)
    return behaviour


class VehicleInterface:
    """See the module.

    Args:
        settings: what it is set to.
        power_on_ns: when it is switched on, in ns of bench time.
        behaviour: another one than that of the settings.
        steps: another control task, for tests that must be able to fail.
        modes: another table of modes.

    Attributes:
        behaviour: how it behaves.
        simulator: its end of the simulator's line, with its modes and counters.
        stack: its end of the driving stack's line, with its counters.
        light: which light is on; empty before the first.
        lamps: turn indicators and hazard lights.
    """

    def __init__(
        self,
        settings: VehicleSettings,
        *,
        power_on_ns: int = 0,
        behaviour: Behaviour | None = None,
        steps: carla.Table | None = None,
        modes: carla.ModeTable | None = None,
    ) -> None:
        self._tables = steps, modes
        self.behaviour = behaviour or behaviour_of(settings)
        self._boot_s = self.behaviour.body.boot_s if settings.boot_s is None else settings.boot_s
        self._events: list[object] = []
        self._counts = (self.behaviour.board.x_axis.zero, self.behaviour.board.y_axis.zero)
        self._begin(power_on_ns)

    def _begin(self, now_ns: int) -> None:
        self._epoch_ns = now_ns + round(self._boot_s * _NS_PER_S)
        steps, modes = self._tables
        self.simulator = carla.Connection(
            carla.Role.BOARD, self.behaviour.board, epoch_ns=self._epoch_ns, steps=steps, modes=modes
        )
        self.stack = autoware.Connection(autoware.Role.BOARD, self.behaviour.stack, epoch_ns=self._epoch_ns)
        self.lamps = Lamps(self.behaviour.body.blink_hz, self._epoch_ns)
        self.light = ""
        self._stamp = Time()
        self._sequence = 0
        self._hung_ns: int | None = None
        self._from_simulator(self.simulator.joystick(*self._axes(), self._epoch_ns), self._epoch_ns)

    # --- somebody beside the board

    def set_joystick(self, x_count: int, y_count: int, now_ns: int) -> Sent:
        """Moves the joystick to where the converter reads these counts, 0..65535; returns what to put on the lines.

        Raises:
            LocalProtocolError: a count is out of range.
        """
        self._counts = (x_count, y_count)
        if self._hung_ns is not None:
            return []
        return self._from_simulator(self.simulator.joystick(*self._axes(), max(now_ns, self._epoch_ns)), now_ns)

    def hold(self, now_ns: int) -> Sent:
        """Closes the joystick's switch, which does nothing yet; returns what to put on the lines."""
        return self.advance(now_ns)

    def press(self, now_ns: int) -> Sent:
        """Lets go of the joystick's switch, which is when it acts; returns what to put on the lines."""
        if self._is_deaf(now_ns):
            return []
        return self._from_simulator(self.simulator.press(now_ns), now_ns)

    def line_error(self, now_ns: int) -> Sent:
        """An overrun or framing error on the simulator's line; returns what to put on the lines."""
        if self._hung_ns is not None:
            return []
        return self._from_simulator(self.simulator.line_error(max(now_ns, self._epoch_ns)), now_ns)

    def reset(self, now_ns: int) -> Sent:
        """Presses the reset button: all is forgotten, and begins anew; returns what to put on the lines."""
        self._begin(now_ns)
        return self.advance(now_ns)

    def hang(self, now_ns: int) -> Sent:
        """Does nothing more until a reset, by its watchdog if it has one; returns what to put on the lines."""
        sent = self.advance(now_ns)
        self._hung_ns = now_ns
        return sent

    def lit_lamps(self, now_ns: int) -> tuple[bool, bool]:
        """Whether the left and the right lamp are lit."""
        return self.lamps.lit(now_ns if self._hung_ns is None else self._hung_ns)

    def _is_deaf(self, now_ns: int) -> bool:
        """Whether it is still booting, or hangs: then nobody listens."""
        return now_ns < self._epoch_ns or self._hung_ns is not None

    # --- a device at two lines

    def receive(self, line: str, data: bytes, now_ns: int) -> Sent:
        """Takes bytes off a line; returns what to put on the lines."""
        sent = self.advance(now_ns)
        if self._is_deaf(now_ns):
            return sent
        if line == SIMULATOR_LINE:
            return sent + self._from_simulator(self.simulator.receive(data, now_ns), now_ns)
        before = self.stack.counters.frames_in
        sent += self._from_stack(self.stack.receive(data, now_ns), now_ns)
        if self.stack.counters.frames_in > before and self.stack.state is autoware.BoardState.ONLINE:
            sent += self._from_simulator(self.simulator.agent(now_ns), now_ns)
        return sent

    def advance(self, now_ns: int) -> Sent:
        """Does what is due at a time; returns what to put on the lines."""
        sent: Sent = []
        while (due_ns := self.next_deadline_ns()) is not None and due_ns <= now_ns:
            if self._hung_ns is not None:
                self._begin(due_ns)
                continue
            sent += self._from_stack(self.stack.advance(due_ns), due_ns)
            sent += self._from_simulator(self.simulator.advance(due_ns), due_ns)
        return sent

    def next_deadline_ns(self) -> int | None:
        """When `advance` has something to do."""
        if self._hung_ns is not None:
            watchdog_s = self.behaviour.body.watchdog_s
            return None if watchdog_s is None else self._hung_ns + round(watchdog_s * _NS_PER_S)
        return earliest(self.simulator.next_deadline_ns(), self.stack.next_deadline_ns())

    def line_down(self, line: str, now_ns: int) -> Sent:
        """A line is gone; a UART does not notice."""
        del line
        return self.advance(now_ns)

    def take_events(self) -> Iterable[object]:
        """What happened since the last call."""
        events, self._events = self._events, []
        return events

    # --- between the lines

    def _axes(self) -> tuple[int, int]:
        x_count, y_count = self._counts
        return (y_count, x_count) if self.behaviour.body.axes_swapped else (x_count, y_count)

    def _from_stack(self, events: Iterable[autoware.Event], now_ns: int) -> Sent:
        sent: Sent = []
        for event in events:
            if isinstance(event, autoware.Transmit):
                sent.append((STACK_LINE, event.data))
                continue
            self._events.append(event)
            if isinstance(event, autoware.AgentFound):
                sent += self._from_simulator(self.simulator.agent(now_ns), now_ns)
            elif isinstance(event, MessageReceived):
                sent += self._obey(event.message, now_ns)
        return sent

    def _obey(self, message: autoware.Message | autoware.UnknownMessage, now_ns: int) -> Sent:
        match message:
            case Clock(clock=clock):
                self._stamp = clock
            case AckermannControlCommand():
                return self._from_simulator(self.simulator.command(_control(message), now_ns), now_ns)
            case ControlModeRequest(sequence=sequence, mode=mode):
                self._sequence = sequence
                return self._from_simulator(self.simulator.request(mode, now_ns), now_ns)
            case TurnIndicatorsCommand() | HazardLightsCommand() if self.behaviour.body.lamps:
                self.lamps.take(message, now_ns)
        return []

    def _from_simulator(self, events: Iterable[carla.Event], now_ns: int) -> Sent:
        sent: Sent = []
        for event in events:
            if isinstance(event, carla.Transmit):
                padding = carla.COMMAND_LAYOUT.padding
                data = event.data if self.behaviour.body.padded else event.data.removesuffix(padding)
                sent.append((SIMULATOR_LINE, data))
                continue
            self._events.append(event)
            if isinstance(event, LampChanged):
                self.light = _LIGHTS[event.mode]
                self._events.append(LightsSwitched(lit=self.light))
            for message in self._reports(event):
                sent.append((STACK_LINE, self.stack.send(message, now_ns)))
        return sent

    def _reports(self, event: carla.Event) -> Iterable[autoware.Message]:
        """What is reported to the driving stack of an event."""
        match event:
            case ModeReported(mode=mode):
                yield ControlModeReport(stamp=self._stamp, mode=mode)
            case ModeAnswered(success=success):
                yield ControlModeResponse(sequence=self._sequence, success=success)
            case StatusReported(status=status):
                yield VelocityReport(
                    stamp=self._stamp,
                    longitudinal_velocity=status.lon_speed_m_s,
                    lateral_velocity=status.lat_speed_m_s,
                    heading_rate=status.heading_rate_rad_s,
                )
                yield SteeringReport(stamp=self._stamp, steering_tire_angle=status.steering_rad)
                if self.behaviour.body.lamps:
                    yield from self.lamps.reports(self._stamp)


def _control(command: AckermannControlCommand) -> ControlCommand:
    return ControlCommand(
        steering_rad=command.steering_tire_angle,
        steering_rate_rad_s=command.steering_tire_rotation_rate,
        speed_m_s=command.speed,
        acceleration_m_s2=command.acceleration,
        jerk_m_s3=command.jerk,
    )
