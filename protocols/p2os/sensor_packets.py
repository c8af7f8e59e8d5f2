"""The packets a client asks for.

Encoders, inputs and outputs, serial ports, gyro, gripper, joystick, compass, arm, battery, sounds. They go out behind
the SIP of a cycle, which has priority (Pioneer 2 Operations Manual, extended packets).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from protocols.p2os.errors import LocalProtocolError, RemoteProtocolError
from protocols.p2os.fields import FieldReader, FieldWriter

__all__ = [
    "ArmInfoPacket",
    "ArmJoint",
    "ArmStatusPacket",
    "BatteryPacket",
    "BatteryReading",
    "EncoderPacket",
    "GripperPacket",
    "GyroPacket",
    "GyroReading",
    "IoPacket",
    "JoystickPacket",
    "PlaylistPacket",
    "SerAuxPacket",
    "Tcm2Packet",
]


@dataclass(frozen=True, slots=True, kw_only=True)
class EncoderPacket:
    """Reply to ENCODER: the wheel encoders, in ticks since power-on, signed (AriaCoda ArRobot.cpp)."""

    TYPE: ClassVar[int] = 0x90

    left_ticks: int
    right_ticks: int

    def encode(self) -> bytes:
        """The body of the packet; LocalProtocolError where a count exceeds 32 bits."""
        writer = FieldWriter(self.TYPE)
        writer.signed("left_ticks", self.left_ticks, 4)
        writer.signed("right_ticks", self.right_ticks, 4)
        return writer.body

    @classmethod
    def decode(cls, body: bytes) -> EncoderPacket:
        """Reads the body; RemoteProtocolError where it is too short."""
        reader = FieldReader(body)
        return cls(left_ticks=reader.signed(4), right_ticks=reader.signed(4))


@dataclass(frozen=True, slots=True, kw_only=True)
class IoPacket:
    """Reply to IOREQUEST: digital bytes as bit masks, analog values in converter counts (AriaCoda ArRobot.cpp)."""

    TYPE: ClassVar[int] = 0xF0

    digin: tuple[int, ...] = ()
    digout: tuple[int, ...] = ()
    analog: tuple[int, ...] = ()

    def encode(self) -> bytes:
        """The body of the packet; LocalProtocolError where a value does not fit."""
        writer = FieldWriter(self.TYPE)
        for name, values, size in (("digin", self.digin, 1), ("digout", self.digout, 1), ("analog", self.analog, 2)):
            writer.unsigned(f"number of {name}", len(values))
            for value in values:
                writer.unsigned(name, value, size)
        return writer.body

    @classmethod
    def decode(cls, body: bytes) -> IoPacket:
        """Reads the body; RemoteProtocolError where it is too short for its counts."""
        reader = FieldReader(body)
        digin, digout, analog = (tuple(reader.unsigned(n) for _ in range(reader.unsigned())) for n in (1, 1, 2))
        return cls(digin=digin, digout=digout, analog=analog)


@dataclass(frozen=True, slots=True, kw_only=True)
class SerAuxPacket:
    """Reply to GETAUX: bytes that came in at a serial port of the robot; `port` is 1 to 3 for AUX1 to AUX3."""

    TYPES: ClassVar[tuple[int, ...]] = (0xB0, 0xB8, 200)

    port: int = 1
    data: bytes

    def encode(self) -> bytes:
        """The body of the packet; LocalProtocolError where there is no such port."""
        if not 1 <= self.port <= len(self.TYPES):
            raise LocalProtocolError(f"there is no port AUX{self.port}")
        return bytes((self.TYPES[self.port - 1],)) + self.data

    @classmethod
    def decode(cls, body: bytes) -> SerAuxPacket:
        """Reads the body of a packet of one of the `TYPES`."""
        return cls(port=cls.TYPES.index(body[0]) + 1, data=body[1:])


@dataclass(frozen=True, slots=True, kw_only=True)
class GyroReading:
    """One gyro sample: rate 0..1023 with 512 for standing still, temperature 0..255, both raw."""

    rate_raw: int
    temperature_raw: int


@dataclass(frozen=True, slots=True, kw_only=True)
class GyroPacket:
    """Stream asked for with GYRO: the samples since the last packet (AriaCoda ArAnalogGyro.cpp)."""

    TYPE: ClassVar[int] = 0x98

    readings: tuple[GyroReading, ...] = ()

    def encode(self) -> bytes:
        """The body of the packet; LocalProtocolError where a value does not fit."""
        writer = FieldWriter(self.TYPE)
        writer.unsigned("number of readings", len(self.readings))
        for reading in self.readings:
            writer.unsigned("rate_raw", reading.rate_raw, 2)
            writer.unsigned("temperature_raw", reading.temperature_raw)
        return writer.body

    @classmethod
    def decode(cls, body: bytes) -> GyroPacket:
        """Reads the body; RemoteProtocolError where it is too short for its count."""
        reader = FieldReader(body)
        count = reader.unsigned()
        return cls(
            readings=tuple(
                GyroReading(rate_raw=reader.unsigned(2), temperature_raw=reader.unsigned()) for _ in range(count)
            )
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class GripperPacket:
    """Reply to GRIPREQUEST (AriaCoda ArGripper.cpp).

    Attributes:
        kind: 0 no gripper, 1 on the user I/O, 2 on the general I/O.
        state: bit 0 grip limit, 1 lift limit, 2 outer beam, 3 inner beam, 4 left paddle, 5 right paddle (0 active),
            6 lift moving, 7 grip moving. The manual has beams at 0 when obstructed, ARIA at 1.
        grasp_time_raw: in units of 20 ms.
    """

    TYPE: ClassVar[int] = 0xE0

    kind: int = 0
    state: int = 0
    grasp_time_raw: int = 0

    def encode(self) -> bytes:
        """The body of the packet; LocalProtocolError where a value does not fit."""
        writer = FieldWriter(self.TYPE)
        for name in ("kind", "state", "grasp_time_raw"):
            writer.unsigned(name, getattr(self, name))
        return writer.body

    @classmethod
    def decode(cls, body: bytes) -> GripperPacket:
        """Reads the body; RemoteProtocolError where it is too short."""
        reader = FieldReader(body)
        return cls(kind=reader.unsigned(), state=reader.unsigned(), grasp_time_raw=reader.unsigned())


@dataclass(frozen=True, slots=True, kw_only=True)
class JoystickPacket:
    """Reply to JOYINFO: buttons 0 or 1, axes and throttle 0..1023 with 512 in the centre (ArRobotJoyHandler.cpp)."""

    TYPE: ClassVar[int] = 0xF8

    button1: int = 0
    button2: int = 0
    x_raw: int = 512
    y_raw: int = 512
    throttle_raw: int = 512

    def encode(self) -> bytes:
        """The body of the packet; LocalProtocolError where a value does not fit."""
        writer = FieldWriter(self.TYPE)
        for name, size in (("button1", 1), ("button2", 1), ("x_raw", 2), ("y_raw", 2), ("throttle_raw", 2)):
            writer.unsigned(name, getattr(self, name), size)
        return writer.body

    @classmethod
    def decode(cls, body: bytes) -> JoystickPacket:
        """Reads the body; RemoteProtocolError where it is too short."""
        reader = FieldReader(body)
        button1, button2, x, y, throttle = (reader.unsigned(size) for size in (1, 1, 2, 2, 2))
        return cls(button1=button1, button2=button2, x_raw=x, y_raw=y, throttle_raw=throttle)


_TCM2_FIELDS = (
    *(("heading_ddeg", 2, True), ("pitch_ddeg", 2, True), ("roll_ddeg", 2, True)),
    *(("magnetic_x_cut", 2, True), ("magnetic_y_cut", 2, True), ("magnetic_z_cut", 2, True)),
    *(("temperature_dc", 2, True), ("error", 2, True)),
    *(("calibration_h", 1, True), ("calibration_v", 1, True), ("calibration_m_raw", 2, True)),
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Tcm2Packet:
    """Reply to TCM2: the compass module (AriaCoda attic/ArTCMCompassRobot.cpp).

    Attributes:
        heading_ddeg: heading in 0.1 degree.
        pitch_ddeg: pitch in 0.1 degree.
        roll_ddeg: roll in 0.1 degree.
        magnetic_x_cut: field along x in 0.01 microtesla; y and z, as above.
        magnetic_y_cut: see x.
        magnetic_z_cut: see x.
        temperature_dc: temperature in 0.1 degree Celsius.
        error: error bits of the module.
        calibration_h: horizontal calibration score.
        calibration_v: vertical calibration score.
        calibration_m_raw: magnetic calibration score, in 0.01.
    """

    TYPE: ClassVar[int] = 0xC0

    heading_ddeg: int = 0
    pitch_ddeg: int = 0
    roll_ddeg: int = 0
    magnetic_x_cut: int = 0
    magnetic_y_cut: int = 0
    magnetic_z_cut: int = 0
    temperature_dc: int = 0
    error: int = 0
    calibration_h: int = 0
    calibration_v: int = 0
    calibration_m_raw: int = 0

    def encode(self) -> bytes:
        """The body of the packet; LocalProtocolError where a value does not fit."""
        writer = FieldWriter(self.TYPE)
        for name, size, _ in _TCM2_FIELDS:
            writer.signed(name, getattr(self, name), size)
        return writer.body

    @classmethod
    def decode(cls, body: bytes) -> Tcm2Packet:
        """Reads the body; RemoteProtocolError where it is too short."""
        reader = FieldReader(body)
        return cls(**{name: reader.signed(size) for name, size, _ in _TCM2_FIELDS})


@dataclass(frozen=True, slots=True, kw_only=True)
class ArmStatusPacket:
    """Reply to ARM_STATUS (AriaCoda attic/ArP2Arm.cpp).

    Attributes:
        status: bit 0 powered, bit 1 connected.
        moving: one bit for each joint that moves.
        positions_raw: six joint positions, 0..255.
    """

    TYPE: ClassVar[int] = 0xA0
    JOINTS: ClassVar[int] = 6

    status: int = 0
    moving: int = 0
    positions_raw: tuple[int, ...] = (0, 0, 0, 0, 0, 0)

    def encode(self) -> bytes:
        """The body of the packet; LocalProtocolError where a value does not fit or there are not six positions."""
        if len(self.positions_raw) != self.JOINTS:
            raise LocalProtocolError(f"an arm has {self.JOINTS} joints, not {len(self.positions_raw)}")
        writer = FieldWriter(self.TYPE)
        writer.unsigned("status", self.status)
        writer.unsigned("moving", self.moving)
        for position in self.positions_raw:
            writer.unsigned("positions_raw", position)
        return writer.body

    @classmethod
    def decode(cls, body: bytes) -> ArmStatusPacket:
        """Reads the body; RemoteProtocolError where it is too short."""
        reader = FieldReader(body)
        return cls(status=reader.unsigned(), moving=reader.unsigned(), positions_raw=tuple(reader.raw(cls.JOINTS)))


@dataclass(frozen=True, slots=True, kw_only=True)
class ArmJoint:
    """One joint as ARM_INFO describes it: all in servo ticks, 0..255; the last is ticks in 90 degrees."""

    speed: int = 0
    home: int = 0
    minimum: int = 0
    centre: int = 0
    maximum: int = 0
    ticks_per_90_deg: int = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class ArmInfoPacket:
    """Reply to ARM_INFO: the version of the arm's controller and its joints (AriaCoda attic/ArP2Arm.cpp)."""

    TYPE: ClassVar[int] = 0xA1

    version: str = ""
    joints: tuple[ArmJoint, ...] = ()

    def encode(self) -> bytes:
        """The body of the packet; LocalProtocolError where a value does not fit."""
        writer = FieldWriter(self.TYPE)
        writer.text("version", self.version)
        writer.unsigned("number of joints", len(self.joints))
        for joint in self.joints:
            for name in ("speed", "home", "minimum", "centre", "maximum", "ticks_per_90_deg"):
                writer.unsigned(name, getattr(joint, name))
        return writer.body

    @classmethod
    def decode(cls, body: bytes) -> ArmInfoPacket:
        """Reads the body; RemoteProtocolError where it is too short for its joints."""
        reader = FieldReader(body)
        version, count = reader.text(), reader.unsigned()
        return cls(version=version, joints=tuple(cls._joint(reader.raw(6)) for _ in range(count)))

    @staticmethod
    def _joint(data: bytes) -> ArmJoint:
        speed, home, minimum, centre, maximum, ticks = data
        return ArmJoint(speed=speed, home=home, minimum=minimum, centre=centre, maximum=maximum, ticks_per_90_deg=ticks)


@dataclass(frozen=True, slots=True, kw_only=True)
class BatteryReading:
    """One battery: three flag bytes, then relative and absolute charge in per cent.

    Attributes:
        flags: the three flag bytes.
        relative_percent: charge of what the battery can hold now, in per cent.
        absolute_percent: charge of what it could hold when new, in per cent.
        more: what a longer record holds besides.
    """

    flags: tuple[int, int, int] = (0, 0, 0)
    relative_percent: int = 0
    absolute_percent: int = 0
    more: bytes = b""


@dataclass(frozen=True, slots=True, kw_only=True)
class BatteryPacket:
    """Reply to BATTERYINFO (AriaCoda ArRobotBatteryPacketReader.cpp)."""

    TYPE: ClassVar[int] = 0xFA
    RECORD: ClassVar[int] = 5
    """Bytes of one battery's record, at least."""

    batteries: tuple[BatteryReading, ...] = ()

    def encode(self) -> bytes:
        """The body of the packet; LocalProtocolError where a value does not fit or records differ in length."""
        sizes = {self.RECORD + len(battery.more) for battery in self.batteries} or {self.RECORD}
        if len(sizes) > 1:
            raise LocalProtocolError("all batteries of a packet have records of one length")
        writer = FieldWriter(self.TYPE)
        writer.unsigned("number of batteries", len(self.batteries))
        writer.unsigned("bytes of a battery", sizes.pop())
        for battery in self.batteries:
            for value in (*battery.flags, battery.relative_percent, battery.absolute_percent):
                writer.unsigned("battery", value)
            writer.raw(battery.more)
        return writer.body

    @classmethod
    def decode(cls, body: bytes) -> BatteryPacket:
        """Reads the body; RemoteProtocolError where it is too short for its batteries."""
        reader = FieldReader(body)
        count, size = reader.unsigned(), reader.unsigned()
        if count and size < cls.RECORD:
            raise RemoteProtocolError(f"a battery record of {size} bytes is shorter than {cls.RECORD}")
        return cls(batteries=tuple(cls._reading(reader.raw(size)) for _ in range(count)))

    @classmethod
    def _reading(cls, record: bytes) -> BatteryReading:
        return BatteryReading(
            flags=(record[0], record[1], record[2]),
            relative_percent=record[3],
            absolute_percent=record[4],
            more=record[cls.RECORD :],
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class PlaylistPacket:
    """Reply to PLAYLIST: the name of a sound, as it stands. P2OS, which has none, sends 25 NULs (its manual)."""

    TYPE: ClassVar[int] = 0xD0
    NONE: ClassVar[bytes] = bytes(25)

    text: bytes = NONE

    @property
    def name(self) -> str:
        """The text up to its first NUL."""
        return self.text.partition(b"\0")[0].decode("latin-1")

    def encode(self) -> bytes:
        """The body of the packet."""
        return bytes((self.TYPE,)) + self.text

    @classmethod
    def decode(cls, body: bytes) -> PlaylistPacket:
        """Reads the body."""
        return cls(text=body[1:])
