"""A driving stack on a bench: publishes and subscribes to the messages of a vehicle-interface board through a port.

It is the agent's end of the stand-in link, or a micro-ROS agent with the stack beside it, and works on any link: a
virtual board's line, an emulated board's USART, a serial port, a pty, a socket.

    stack = DrivingStack(bench, port)
    stack.subscribe(VelocityReport, lambda report: print(report.longitudinal_velocity))
    stack.open()                                    # says that it is there, publishes the clock
    stack.request_mode(ControlMode.AUTONOMOUS)
    stack.drive_with(lambda: stack.command(speed=5.0))      # 30 times a second

While it is open it publishes the clock, which the board stamps its reports with. A board that falls silent is lost:
`failure` says so, requests for a mode that wait are given up, and commands go on, so that a board that comes back finds
them. Nothing repeats a message that the line swallowed; whoever needs an answer asks again.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeVar

from hilbench.bench import Bench
from hilbench.bench.devices import ClientDevice, DeviceActor
from hilbench.bench.feed import Feed
from hilbench.clock import Entry, EventClass
from hilbench.links import Port
from hilbench.systems.vehicle.micro_ros import MicroRosEnd
from protocols.autoware import (
    AckermannControlCommand,
    AgentOptions,
    AgentState,
    BoardFound,
    BoardLost,
    Clock,
    Connection,
    ControlModeReport,
    ControlModeRequest,
    ControlModeResponse,
    Event,
    Message,
    MessageReceived,
    Role,
    SteeringReport,
    Table,
    Time,
    Transmit,
    UnknownMessage,
    VelocityReport,
)
from protocols.xrce import Session

__all__ = ["CLOCK_HZ", "COMMAND_HZ", "DrivingStack", "Received"]

COMMAND_HZ = 30.0
"""How often Autoware's trajectory follower commands (its parameter ctrl_period is 0.03 s)."""
CLOCK_HZ = 20.0
"""How often the simulator tells its time (the Carla-Autoware bridge: fixed_delta_seconds 0.05)."""
ANSWER_WITHIN_NS = 1_000_000_000
"""How long an answer to a request for a mode is waited for. A choice."""

_SEQUENCES = 256

KindT = TypeVar("KindT")


@dataclass(frozen=True, slots=True, kw_only=True)
class Received:
    """The newest message of a kind.

    Attributes:
        ns: bench time at which it came.
        message: what it says.
    """

    ns: int
    message: Message | UnknownMessage


@dataclass(slots=True)
class _Request:
    """A request for a mode that waits for its answer."""

    answered: Callable[[bool | None], None]
    deadline: Entry


class DrivingStack:
    """Talks to a board through a port.

    Args:
        bench: whose time and journal are used.
        port: the stack's end of the line.
        options: of the agent role; its defaults if None.
        clock_hz: how often the clock is published while the line is open; None for never.
        name: the source name in the journal.
        table: state table of the agent role; only tests of the tests give another than the right one.
        connection: a micro-ROS agent; None for the stand-in link.

    Attributes:
        connection: its end of the link, with its counters.
        latest: the newest message of each kind.
        counts: how many of each kind have come.
        failure: why the board was lost; empty if it is heard, or was never heard.
        on_board: called with True when the board is found, with False when it is lost.
    """

    def __init__(
        self,
        bench: Bench,
        port: Port,
        *,
        options: AgentOptions | None = None,
        clock_hz: float | None = CLOCK_HZ,
        name: str = "stack",
        table: Table | None = None,
        connection: MicroRosEnd | None = None,
    ) -> None:
        self._bench = bench
        self._clock_hz = clock_hz
        self._name = name
        self.connection = connection or Connection(Role.AGENT, options, table=table)
        self.latest: dict[type[Any], Received] = {}
        self.counts: Counter[type[Any]] = Counter()
        self.failure = ""
        self.on_board: Callable[[bool], None] = lambda _found: None
        self._subscribers: dict[type[Any], list[Callable[[Any], None]]] = {}
        self._requests: dict[int, _Request] = {}
        self._sequence = 0
        self._source: Callable[[], AckermannControlCommand | None] = lambda: None
        self._clock = Feed(bench, self._tell_time, name=f"{name} clock")
        self._commands = Feed(bench, self._publish_command, name=f"{name} commands")
        self._device: ClientDevice[Event] = ClientDevice(self.connection, Transmit)
        self._actor = DeviceActor(bench, self._device, port, name=name, on_event=self._take)

    # --- what it knows

    @property
    def state(self) -> AgentState:
        """The state of its end of the link."""
        state = self.connection.state
        assert isinstance(state, AgentState)
        return state

    @property
    def observed(self) -> Connection | Session:
        """What a dashboard looks at."""
        return self.connection.session if isinstance(self.connection, MicroRosEnd) else self.connection

    @property
    def mode(self) -> int | None:
        """The mode that the board reported last, see `ControlMode`."""
        report = self.newest(ControlModeReport)
        return None if report is None else report.mode

    @property
    def velocity(self) -> VelocityReport | None:
        """How the vehicle moves, as reported last."""
        return self.newest(VelocityReport)

    @property
    def steering(self) -> SteeringReport | None:
        """How its wheels stand, as reported last."""
        return self.newest(SteeringReport)

    def newest(self, kind: type[KindT]) -> KindT | None:
        """The newest message of a kind; None if none has come."""
        received = self.latest.get(kind)
        return received.message if received is not None and isinstance(received.message, kind) else None

    # --- the link

    def open(self) -> None:
        """Say that the stack is there, and begin to publish the clock.

        Raises:
            LocalProtocolError: it is open.
        """
        data = self._device.take(self.connection.connect(self._bench.now_ns))
        self.failure = ""
        self._actor.transmit(data)
        if self._clock_hz is not None:
            self._clock.start(self._clock_hz)

    def close(self) -> None:
        """Fall silent: no commands, no clock, no answers to pings.

        Raises:
            LocalProtocolError: it is closed.
        """
        data = self._device.take(self.connection.disconnect(self._bench.now_ns))
        self._fall_silent()
        self._actor.transmit(data)

    # --- publish and subscribe

    @property
    def stamp(self) -> Time:
        """Bench time, as messages carry it."""
        return Time.from_ns(self._bench.now_ns)

    def publish(self, message: Message | UnknownMessage) -> None:
        """Send a message as it is.

        Raises:
            LocalProtocolError: it is one of the board's, or a number does not fit.
        """
        self._actor.transmit(self.connection.send(message, self._bench.now_ns))

    def subscribe(self, kind: type[KindT], callback: Callable[[KindT], None]) -> Callable[[], None]:
        """Have `callback` called with each message of a kind as it comes; return what ends that."""
        callbacks = self._subscribers.setdefault(kind, [])
        callbacks.append(callback)

        def unsubscribe() -> None:
            if callback in callbacks:
                callbacks.remove(callback)

        return unsubscribe

    # --- driving

    def command(
        self,
        *,
        speed: float,
        steering_tire_angle: float = 0.0,
        steering_tire_rotation_rate: float = 0.0,
        acceleration: float = 0.0,
        jerk: float = 0.0,
    ) -> AckermannControlCommand:
        """Return a command stamped with bench time; see `AckermannControlCommand` for units and signs."""
        return AckermannControlCommand(
            stamp=self.stamp,
            steering_tire_angle=steering_tire_angle,
            steering_tire_rotation_rate=steering_tire_rotation_rate,
            speed=speed,
            acceleration=acceleration,
            jerk=jerk,
        )

    def drive_with(self, source: Callable[[], AckermannControlCommand | None], rate_hz: float = COMMAND_HZ) -> None:
        """Ask `source` for a command and publish it, now and then at a rate; what it leaves out (None) is not sent."""
        self._source = source
        self._commands.start(rate_hz)

    def stop_driving(self) -> None:
        """Publish no more commands by itself."""
        self._commands.stop()

    def request_mode(self, mode: int, answered: Callable[[bool | None], None] = lambda _success: None) -> None:
        """Ask the board for a mode, see `ControlMode`.

        Args:
            mode: which.
            answered: called once, with what the board says, or with None if the line went down, the board was lost, or
                nothing came for a second.
        """
        self._sequence = (self._sequence + 1) % _SEQUENCES
        sequence = self._sequence
        self._answer(sequence, None)  # an older request of the same number will not be answered any more
        deadline = self._bench.scheduler.after(
            ANSWER_WITHIN_NS, lambda: self._answer(sequence, None), order=EventClass.TIMER, source=self._name
        )
        self._requests[sequence] = _Request(answered, deadline)
        self.publish(ControlModeRequest(sequence=sequence, stamp=self.stamp, mode=mode))

    # --- what happens

    def _tell_time(self) -> None:
        self.publish(Clock(clock=self.stamp))

    def _publish_command(self) -> None:
        command = self._source()
        if command is not None:
            self.publish(command)

    def _take(self, event: object) -> None:
        match event:
            case MessageReceived(message=message):
                self._keep(message)
            case BoardFound():
                self.failure = ""
                self.on_board(True)
            case BoardLost(reason=reason):
                self.failure = str(reason)
                if self.state is AgentState.CLOSED:
                    self._fall_silent()
                self._give_up_requests()
                self.on_board(False)

    def _keep(self, message: Message | UnknownMessage) -> None:
        kind = type(message)
        self.latest[kind] = Received(ns=self._bench.now_ns, message=message)
        self.counts[kind] += 1
        if isinstance(message, ControlModeResponse):
            self._answer(message.sequence, message.success)
        for callback in tuple(self._subscribers.get(kind, ())):
            callback(message)

    def _answer(self, sequence: int, success: bool | None) -> None:
        request = self._requests.pop(sequence, None)
        if request is not None:
            self._bench.scheduler.cancel(request.deadline)
            request.answered(success)

    def _give_up_requests(self) -> None:
        for sequence in tuple(self._requests):
            self._answer(sequence, None)

    def _fall_silent(self) -> None:
        self._clock.stop()
        self._commands.stop()
        self._give_up_requests()
