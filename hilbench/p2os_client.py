"""A P2OS client on a bench: the protocol's client role, a port, and what it learned so far.

It is what our own programs use to drive a robot, and it is the client that the suite ``p2os-client`` tests when no
other is named.
"""

from __future__ import annotations

from hilbench.bench import Bench
from hilbench.devices import DeviceActor
from hilbench.links import Port
from protocols.p2os import (
    BaudWanted,
    ClientOptions,
    ClientState,
    Command,
    Connected,
    ConnectFailed,
    Connection,
    ConnectionLost,
    Event,
    Identification,
    PacketReceived,
    PoseTracker,
    Role,
    ServerPacket,
    Sip,
    Table,
    Transmit,
    robot_parameters,
)


class _ClientDevice:
    """Makes a serial device of the client role: its events, less the bytes, are what it reports."""

    def __init__(self, connection: Connection) -> None:
        self.connection = connection
        self._events: list[Event] = []

    def receive(self, data: bytes, now_ns: int) -> bytes:
        return self.take(self.connection.receive(data, now_ns))

    def advance(self, now_ns: int) -> bytes:
        return self.take(self.connection.advance(now_ns))

    def next_deadline_ns(self) -> int | None:
        return self.connection.next_deadline_ns()

    def line_down(self, now_ns: int) -> bytes:
        return self.take(self.connection.line_down(now_ns))

    def take_events(self) -> list[Event]:
        events, self._events = self._events, []
        return events

    def take(self, events: list[Event]) -> bytes:
        self._events += [event for event in events if not isinstance(event, Transmit)]
        return b"".join(event.data for event in events if isinstance(event, Transmit))


class P2osClient:
    """Drives a robot through a port.

    Args:
        bench: whose time and journal are used.
        port: the client's end of the line.
        options: of the client role.
        table: state table of the client role; only tests of the tests give another than the right one.

    Attributes:
        packets: every packet received in a session, oldest first.
        identification: what the robot said it is; None before that.
        failure: why connecting failed, or why the connection was lost; empty if neither happened.
        pose: where the robot is by its own odometry, unwrapped; None before the first SIP.
    """

    def __init__(
        self, bench: Bench, port: Port, options: ClientOptions | None = None, *, table: Table | None = None
    ) -> None:
        self._bench = bench
        self._port = port
        self.connection = Connection(Role.CLIENT, options or ClientOptions(), table=table)
        self.packets: list[ServerPacket] = []
        self.identification: Identification | None = None
        self.failure = ""
        self.pose: PoseTracker | None = None
        self._device = _ClientDevice(self.connection)
        self._actor = DeviceActor(bench, self._device, port, name="client", on_event=self._take)

    @property
    def state(self) -> ClientState:
        """The state of the client's connection."""
        state = self.connection.state
        assert isinstance(state, ClientState)
        return state

    @property
    def sips(self) -> list[Sip]:
        """The SIPs received, oldest first."""
        return [packet for packet in self.packets if isinstance(packet, Sip)]

    def connect(self) -> None:
        """Begin to connect; time must pass for it to succeed."""
        self.failure = ""
        self._actor.transmit(self._device.take(self.connection.connect(self._bench.now_ns)))

    def disconnect(self) -> None:
        """Begin to take leave of the robot; time must pass for it to be done."""
        self._actor.transmit(self._device.take(self.connection.disconnect(self._bench.now_ns)))

    def send(self, number: int, argument: int | bytes | None = None) -> None:
        """Send a command.

        Raises:
            LocalProtocolError: there is no session, or the command cannot be encoded.
        """
        command = Command(number=number, argument=argument)
        self._actor.transmit(self.connection.send(command, self._bench.now_ns))

    def _take(self, event: object) -> None:
        match event:
            case PacketReceived(packet=packet):
                self._keep(packet)
            case Connected(identification=identification):
                self.identification = identification
                self.pose = PoseTracker(robot_parameters(identification.subclass))
            case ConnectFailed(reason=reason) | ConnectionLost(reason=reason):
                self.failure = str(reason)
            case BaudWanted(baud=baud):
                self._port.baud = baud

    def _keep(self, packet: ServerPacket) -> None:
        self.packets.append(packet)
        if isinstance(packet, Sip) and self.pose is not None:
            self.pose.update(packet)
