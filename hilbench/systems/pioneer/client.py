"""A P2OS client on a bench: the protocol's client role, a port, and what it learned so far.

It is what our own programs use to drive a robot, and it is the client that the suite ``p2os-client`` tests when no
other is named.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from hilbench.bench import Bench
from hilbench.bench.devices import ClientDevice, DeviceActor
from hilbench.links import Port
from protocols.p2os import (
    BaudWanted,
    ClientOptions,
    ClientState,
    Command,
    CommandNumber,
    ConfigPacket,
    Connected,
    ConnectFailed,
    Connection,
    ConnectionLost,
    Event,
    Identification,
    PacketReceived,
    PoseTracker,
    RobotParameters,
    Role,
    ServerPacket,
    Sip,
    SipReading,
    Table,
    Transmit,
    read_sip,
    vel2,
)


class _RateChangingDevice(ClientDevice[Event]):
    """A device of the client role that changes the line's rate too.

    That is done at once: the bytes of the same call are meant for the new one.
    """

    def __init__(self, connection: Connection, port: Port) -> None:
        super().__init__(connection, Transmit)
        self._port = port

    def take(self, events: Sequence[Event]) -> bytes:
        for event in events:
            if isinstance(event, BaudWanted):
                self._port.baud = event.baud
        return super().take(events)


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
        robot: the parameters that go with it, or those fallen back on; None before that.
        config: the robot's configuration; None if it did not tell.
        failure: why connecting failed, or why the connection was lost; empty if neither happened.
        pose: where the robot is by its own odometry, unwrapped; None before the session.
        on_event: called after each event of the connection.
    """

    def __init__(
        self, bench: Bench, port: Port, options: ClientOptions | None = None, *, table: Table | None = None
    ) -> None:
        self._bench = bench
        self.connection = Connection(Role.CLIENT, options or ClientOptions(), table=table)
        self.packets: list[ServerPacket] = []
        self.identification: Identification | None = None
        self.robot: RobotParameters | None = None
        self.config: ConfigPacket | None = None
        self.failure = ""
        self.pose: PoseTracker | None = None
        self.on_event: Callable[[], None] = lambda: None
        self._device = _RateChangingDevice(self.connection, port)
        self._actor = DeviceActor(bench, self._device, port, name="client", on_event=self._take)

    # --- what it knows

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

    @property
    def reading(self) -> SipReading | None:
        """The newest SIP in physical units; None before the session."""
        sips = self.sips
        return read_sip(sips[-1], self.robot) if sips and self.robot is not None else None

    # --- the session

    def connect(self) -> None:
        """Begin to connect; time must pass for it to succeed.

        Raises:
            LocalProtocolError: it is connected, or connecting already.
        """
        data = self._device.take(self.connection.connect(self._bench.now_ns))
        self.packets.clear()
        self.identification = self.robot = self.config = self.pose = None
        self.failure = ""
        self._actor.transmit(data)

    def disconnect(self) -> None:
        """Begin to take leave of the robot; time must pass for it to be done.

        Raises:
            LocalProtocolError: it is neither connected nor connecting.
        """
        self._actor.transmit(self._device.take(self.connection.disconnect(self._bench.now_ns)))

    def send(self, number: int, argument: int | bytes | None = None) -> None:
        """Send a command.

        Raises:
            LocalProtocolError: there is no session, or the command cannot be encoded.
        """
        self._send(Command(number=number, argument=argument))

    # --- driving; each raises LocalProtocolError where there is no session

    def enable(self, *, motors: bool = True) -> None:
        """Give the motors power, or take it from them; without it the robot does not move."""
        self.send(CommandNumber.ENABLE, int(motors))

    def drive(self, speed_mm_s: float, turn_deg_s: float = 0.0) -> None:
        """Drive at a speed in mm/s (+ forward) while turning in degrees/s (+ counter-clockwise), both rounded."""
        self.send(CommandNumber.VEL, round(speed_mm_s))
        self.send(CommandNumber.RVEL, round(turn_deg_s))

    def drive_wheels(self, left_mm_s: float, right_mm_s: float) -> None:
        """Drive each wheel at a speed in mm/s, in steps of 20 up to 2540."""
        self._send(vel2(left_mm_s, right_mm_s))

    def stop(self) -> None:
        """Stop with normal deceleration; the motors stay enabled."""
        self.send(CommandNumber.STOP)

    def _send(self, command: Command) -> None:
        self._actor.transmit(self.connection.send(command, self._bench.now_ns))

    # --- what it learns

    def _take(self, event: object) -> None:
        match event:
            case PacketReceived(packet=packet):
                self._keep(packet)
            case Connected():
                self._begin(event)
            case ConnectFailed(reason=reason) | ConnectionLost(reason=reason):
                self.failure = str(reason)
        self.on_event()

    def _begin(self, connected: Connected) -> None:
        self.identification = connected.identification
        self.robot = connected.parameters
        self.config = connected.config
        self.pose = PoseTracker(connected.parameters)
        for sip in self.sips:  # they begin with OPEN, before the configuration is there
            self.pose.update(sip)

    def _keep(self, packet: ServerPacket) -> None:
        self.packets.append(packet)
        if isinstance(packet, ConfigPacket):
            self.config = packet
        if isinstance(packet, Sip) and self.pose is not None:
            self.pose.update(packet)
