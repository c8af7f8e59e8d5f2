"""Server packets other than SIP and CONFIG, and the choice of the class for a body.

Every packet has `encode()`, which gives the body of its frame, and `decode(body)`, which reads one; both are exact
inverses of one another. Integers are little-endian, strings end with a NUL.
(Pioneer 2 Operations Manual, extended packets; AriaCoda ArRobot*.cpp, ArGripper.cpp, ArAnalogGyro.cpp,
ArRobotJoyHandler.cpp, attic/ArTCMCompassRobot.cpp, attic/ArP2Arm.cpp; Player sip.cc.)
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from protocols.p2os.config_packet import ConfigPacket
from protocols.p2os.errors import LocalProtocolError, RemoteProtocolError
from protocols.p2os.fields import FieldReader, FieldWriter
from protocols.p2os.framing import MAX_COUNT, encode_frame
from protocols.p2os.sensor_packets import (
    ArmInfoPacket,
    ArmJoint,
    ArmStatusPacket,
    BatteryPacket,
    BatteryReading,
    EncoderPacket,
    GripperPacket,
    GyroPacket,
    GyroReading,
    IoPacket,
    JoystickPacket,
    PlaylistPacket,
    SerAuxPacket,
    Tcm2Packet,
)
from protocols.p2os.sip import LateSipFields, Sip, SonarReading

__all__ = [
    "ArmInfoPacket",
    "ArmJoint",
    "ArmStatusPacket",
    "BatteryPacket",
    "BatteryReading",
    "ConfigPacket",
    "ControllerReset",
    "EncoderPacket",
    "GripperPacket",
    "GyroPacket",
    "GyroReading",
    "Identification",
    "IoPacket",
    "JoystickPacket",
    "LateSipFields",
    "PlaylistPacket",
    "SerAuxPacket",
    "ServerPacket",
    "Sip",
    "SonarReading",
    "SyncEcho",
    "SyncError",
    "Tcm2Packet",
    "UnknownPacket",
    "decode_packet",
    "encode_packet",
]


@dataclass(frozen=True, slots=True, kw_only=True)
class SyncEcho:
    """The server's answer to SYNC0 or SYNC1: the same packet back. It has a meaning only before the session.

    Attributes:
        number: the number echoed, 0..2; 2 is bare only from a server that re-echoes the number it expects.
    """

    number: int

    def encode(self) -> bytes:
        """The body of the packet.

        Raises:
            LocalProtocolError: no SYNC has this number.
        """
        if self.number not in (0, 1, 2):
            raise LocalProtocolError(f"there is no SYNC{self.number}")
        return bytes((self.number,))

    @classmethod
    def decode(cls, body: bytes) -> SyncEcho:
        """Reads the body of an echo; whatever follows the number is ignored.

        Raises:
            RemoteProtocolError: it is none.
        """
        if body[:1] not in (b"\0", b"\1", b"\2"):
            raise RemoteProtocolError(f"{body.hex()} is no SYNC echo")
        return cls(number=body[0])


@dataclass(frozen=True, slots=True, kw_only=True)
class Identification:
    """The server's answer to SYNC2: who it is. The subclass selects the client's parameter table.

    Clients keep 19 characters of each (Player p2os driver); a name with "MobileSim" in it makes ARIA take the peer for
    a simulator.

    Attributes:
        name: the robot's own name.
        robot_class: "Pioneer" on all robots of the family.
        subclass: the model, for example "p2dx".
    """

    TYPE: ClassVar[int] = 0x02

    name: str
    robot_class: str = "Pioneer"
    subclass: str

    def encode(self) -> bytes:
        """The body of the packet.

        Raises:
            LocalProtocolError: a string holds a NUL or is not Latin-1.
        """
        writer = FieldWriter(self.TYPE)
        writer.text("name", self.name)
        writer.text("robot_class", self.robot_class)
        writer.text("subclass", self.subclass)
        return writer.body

    @classmethod
    def decode(cls, body: bytes) -> Identification:
        """Reads the body of an identification; what follows the third string is ignored.

        Raises:
            RemoteProtocolError: a string or its NUL is missing.
        """
        reader = FieldReader(body)
        return cls(name=reader.text(), robot_class=reader.text(), subclass=reader.text())


@dataclass(frozen=True, slots=True, kw_only=True)
class SyncError:
    """Before the session: "SYNC count error". ARIA drops what is pending and restarts at SYNC0 (ArRobot.cpp).

    Whether a real P2OS ever sends it is unknown; that ARIA handles it suggests that some firmware does.
    """

    TYPE: ClassVar[int] = 0xFF

    def encode(self) -> bytes:
        """The body of the packet."""
        return bytes((self.TYPE,))

    @classmethod
    def decode(cls, body: bytes) -> SyncError:
        """Reads the body; whatever follows the type is ignored."""
        del body
        return cls()


@dataclass(frozen=True, slots=True, kw_only=True)
class ControllerReset:
    """Type FF or FE hex in a session: the controller has restarted, the session is gone (AriaCoda ArRobot.cpp).

    Attributes:
        code: 0xFF or 0xFE.
    """

    CODES: ClassVar[frozenset[int]] = frozenset((0xFF, 0xFE))

    code: int = 0xFF

    def encode(self) -> bytes:
        """The body of the packet.

        Raises:
            LocalProtocolError: the code is neither FF nor FE hex.
        """
        if self.code not in self.CODES:
            raise LocalProtocolError(f"controller reset is FF or FE, not {self.code:02X}")
        return bytes((self.code,))

    @classmethod
    def decode(cls, body: bytes) -> ControllerReset:
        """Reads the body; whatever follows the type is ignored."""
        return cls(code=body[0])


@dataclass(frozen=True, slots=True, kw_only=True)
class UnknownPacket:
    """A packet of a type that no class here reads; clients ignore it, but it is traffic.

    Attributes:
        packet_type: the type byte.
        payload: what follows it.
    """

    packet_type: int
    payload: bytes = b""

    def encode(self) -> bytes:
        """The body of the packet."""
        return bytes((self.packet_type,)) + self.payload

    @classmethod
    def decode(cls, body: bytes) -> UnknownPacket:
        """Reads any body."""
        return cls(packet_type=body[0], payload=body[1:])


_Session = (
    Sip
    | ConfigPacket
    | EncoderPacket
    | IoPacket
    | SerAuxPacket
    | GyroPacket
    | GripperPacket
    | JoystickPacket
    | Tcm2Packet
    | ArmStatusPacket
    | ArmInfoPacket
    | BatteryPacket
    | PlaylistPacket
    | ControllerReset
)
ServerPacket = _Session | SyncEcho | Identification | SyncError | UnknownPacket

_IN_SESSION: dict[int, type[_Session]] = {
    Sip.STOPPED: Sip,
    Sip.MOVING: Sip,
    ConfigPacket.TYPE: ConfigPacket,
    EncoderPacket.TYPE: EncoderPacket,
    IoPacket.TYPE: IoPacket,
    **dict.fromkeys(SerAuxPacket.TYPES, SerAuxPacket),
    GyroPacket.TYPE: GyroPacket,
    GripperPacket.TYPE: GripperPacket,
    JoystickPacket.TYPE: JoystickPacket,
    Tcm2Packet.TYPE: Tcm2Packet,
    ArmStatusPacket.TYPE: ArmStatusPacket,
    ArmInfoPacket.TYPE: ArmInfoPacket,
    BatteryPacket.TYPE: BatteryPacket,
    PlaylistPacket.TYPE: PlaylistPacket,
}
_HANDSHAKE: dict[int, type[SyncEcho | Identification | SyncError]] = {
    0: SyncEcho,
    1: SyncEcho,
    Identification.TYPE: Identification,
    SyncError.TYPE: SyncError,
}


def decode_packet(body: bytes, *, connected: bool = True, wide_status: bool = False) -> ServerPacket:
    """The packet in a frame's body.

    Args:
        body: the body of a sound frame.
        connected: a session is open. The same bytes mean different things before it: 0 and 1 are SYNC echoes, 2 the
            identification, FF a SYNC error; in a session FF and FE are a controller reset, the others unknown.
        wide_status: take 30, 31 and 34 hex for a SIP too, as the Player, ROS and ESP32 clients do.

    Raises:
        RemoteProtocolError: the body is empty, or too short for what its type announces.
    """
    if not body:
        raise RemoteProtocolError("an empty body holds no packet type")
    packet_type = body[0]
    if not connected and packet_type in _HANDSHAKE:
        return _HANDSHAKE[packet_type].decode(body)
    if connected and packet_type in ControllerReset.CODES:
        return ControllerReset.decode(body)
    if wide_status and packet_type in Sip.WIDE_TYPES:
        return Sip.decode(body)
    return _IN_SESSION.get(packet_type, UnknownPacket).decode(body)


def encode_packet(packet: ServerPacket, *, max_count: int = MAX_COUNT) -> bytes:
    """The whole frame of a packet.

    A full AUX packet needs a count of 203: GETAUX asks for up to 200 bytes (Pioneer 2 Operations Manual), and the limit
    of 200 is that of client frames.

    Raises:
        LocalProtocolError: a field does not fit its place, or the frame is too long.
    """
    return encode_frame(packet.encode(), max_count=max_count)
