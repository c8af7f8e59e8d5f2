"""The configuration packet, type 20 hex: what the robot is and what its FLASH memory holds.

The strings end with NULs, so the offsets float. The packet has grown with the firmware: P2OS ends after the gains,
AROS and ARCOS append more. A reader takes what is there and counts the rest as 0; `fields` tells how far a packet
reached, so that it can be written again as it was.
(Pioneer 2, Pioneer 2/3 H8 and Pioneer 3 Operations Manuals; AriaCoda ArRobotConfigPacketReader.cpp.)
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import ClassVar

from protocols.p2os.errors import LocalProtocolError, RemoteProtocolError
from protocols.p2os.fields import FieldReader, FieldWriter

__all__ = ["ConfigPacket"]


def _number(size: int, *, signed: bool = False) -> int:
    """A field of `size` bytes, 0 unless given."""
    value: int = dataclasses.field(default=0, metadata={"size": size, "signed": signed})
    return value


def _text() -> str:
    """A NUL-terminated string, empty unless given."""
    value: str = dataclasses.field(default="", metadata={"size": 0})
    return value


@dataclass(frozen=True, slots=True, kw_only=True)
class ConfigPacket:
    """One configuration packet; the fields stand in the order of the wire.

    Speeds are in mm/s and degrees/s, accelerations in mm/s^2 and degrees/s^2, times in ms, voltages in 0.1 V, unless
    the name says otherwise. "top" is the greatest value the robot can be set to, "max" the one it is set to; ARIA
    takes both as limits, so 0 would keep it from driving.

    Attributes:
        fields: how many fields, counted from `robot_type`, the packet holds: `P2OS_FIELDS`, `AROS_FIELDS`,
            `ARCOS_FIELDS`, or any other number of a packet that was cut.
        revcount: encoder ticks of a half-turn of the robot.
        p2mpacs: format of the motor packets.
        stall_pwm: PWM at which a wheel that stands still counts as stalled.
        stall_count_ms: how long a stalled wheel stays without power.
        auto_baud: 2 lets the client change the rate of the line.
    """

    TYPE: ClassVar[int] = 0x20
    P2OS_FIELDS: ClassVar[int] = 36
    AROS_FIELDS: ClassVar[int] = 42
    ARCOS_FIELDS: ClassVar[int] = 67

    fields: int = P2OS_FIELDS

    robot_type: str = _text()
    subtype: str = _text()
    serial: str = _text()
    four_motors: int = _number(1)
    rot_vel_top_deg_s: int = _number(2)
    trans_vel_top_mm_s: int = _number(2)
    rot_acc_top_deg_s2: int = _number(2)
    trans_acc_top_mm_s2: int = _number(2)
    pwm_max: int = _number(2)
    name: str = _text()
    sip_cycle_ms: int = _number(1)
    host_baud: int = _number(1)
    aux1_baud: int = _number(1)
    gripper: int = _number(2)
    front_sonar: int = _number(2)
    rear_sonar: int = _number(1)
    low_battery_dv: int = _number(2)
    revcount: int = _number(2)
    watchdog_ms: int = _number(2)
    p2mpacs: int = _number(1)
    stall_pwm: int = _number(2)
    stall_count_ms: int = _number(2)
    joy_vel_mm_s: int = _number(2)
    joy_rot_vel_deg_s: int = _number(2)
    rot_vel_max_deg_s: int = _number(2)
    trans_vel_max_mm_s: int = _number(2)
    rot_acc_deg_s2: int = _number(2)
    rot_decel_deg_s2: int = _number(2)
    rot_kp: int = _number(2)
    rot_kv: int = _number(2)
    rot_ki: int = _number(2)
    trans_acc_mm_s2: int = _number(2)
    trans_decel_mm_s2: int = _number(2)
    trans_kp: int = _number(2)
    trans_kv: int = _number(2)
    trans_ki: int = _number(2)
    # AROS
    front_bumps: int = _number(1)
    rear_bumps: int = _number(1)
    charger: int = _number(1)
    sonar_cycle_ms: int = _number(1)
    auto_baud: int = _number(1)
    has_gyro: int = _number(1)
    # ARCOS
    drift_factor: int = _number(2, signed=True)
    aux2_baud: int = _number(1)
    aux3_baud: int = _number(1)
    ticks_mm: int = _number(2)
    shutdown_voltage_dv: int = _number(2)
    firmware: str = _text()
    gyro_cw: int = _number(2)
    gyro_ccw: int = _number(2)
    kinematics_delay_ms: int = _number(1)
    lat_vel_top_mm_s: int = _number(2)
    lat_acc_top_mm_s2: int = _number(2)
    lat_vel_max_mm_s: int = _number(2)
    lat_acc_mm_s2: int = _number(2)
    lat_decel_mm_s2: int = _number(2)
    charge_threshold: int = _number(2)
    pdb_port: int = _number(1)
    gyro_rate_limit: int = _number(2)
    high_temperature_c: int = _number(1, signed=True)
    power_bits: int = _number(2)
    battery_type: int = _number(1)
    soc_low: int = _number(2)
    soc_shutdown: int = _number(2)
    bootloader: str = _text()
    config_flags: int = _number(4)
    gyro_firmware: int = _number(2, signed=True)

    def encode(self) -> bytes:
        """The body of the packet, of `fields` fields.

        Raises:
            LocalProtocolError: a value does not fit its field, or `fields` is more than there are.
        """
        if not 0 <= self.fields <= len(_WIRE):
            raise LocalProtocolError(f"a configuration has 0..{len(_WIRE)} fields, not {self.fields}")
        writer = FieldWriter(self.TYPE)
        for name, size, signed in _WIRE[: self.fields]:
            value = getattr(self, name)
            if not size:
                writer.text(name, value)
            elif signed:
                writer.signed(name, value, size)
            else:
                writer.unsigned(name, value, size)
        return writer.body

    @classmethod
    def decode(cls, body: bytes) -> ConfigPacket:
        """Reads the body as far as it goes; a field that is cut counts as absent."""
        reader = FieldReader(body)
        values: dict[str, int | str] = {}
        try:
            for name, size, signed in _WIRE:
                if not size:
                    values[name] = reader.text()
                elif signed:
                    values[name] = reader.signed(size)
                else:
                    values[name] = reader.unsigned(size)
        except RemoteProtocolError:
            pass  # the packet ends here, as every packet of an older firmware does
        return cls(fields=len(values), **values)  # type: ignore[arg-type]  # names and types come from the class itself


# name, size in bytes (0: a string), signed
_WIRE: tuple[tuple[str, int, bool], ...] = tuple(
    (field.name, field.metadata["size"], field.metadata.get("signed", False))
    for field in dataclasses.fields(ConfigPacket)
    if field.metadata
)
