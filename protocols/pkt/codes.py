"""The numbers of the protocol: what is asked, what is reported, what went wrong.

Sources: nhorro/ceai2020 at 6058e92, rover_firmware/tctm/cmd_def.h, tctm/report_def.h, tctm/tmy_def.h,
protocol/protocol.h (`error_code`); manual rover_firmware/doc/index.md, chapter "Referencia del protocolo de
comunicación".
"""

from __future__ import annotations

import enum

__all__ = ["BOTH_MOTORS", "ErrorCode", "MotorFlag", "Opcode", "ReportId", "StatusFlag"]


class Opcode(enum.IntEnum):
    """The first byte of a command's payload."""

    REQUEST_TMY = 0x00
    LED_ON = 0x01
    LED_OFF = 0x02
    UPDATE_MOTORS = 0x03
    """UPDATE_MOTOR_SPEEDS in the first schema, UPDATE_MOTOR_THROTTLES in the last."""
    UPDATE_MOTOR_SPEED_SETPOINTS = 0x04
    RESET_PID_CONTROLLER = 0x05


class ReportId(enum.IntEnum):
    """The first byte of a report's payload."""

    GENERAL = 0x80
    EXECUTION_STATUS = 0x81
    IMU = 0x82
    MOTION = 0x83
    GPS = 0x84
    PID = 0x85


class ErrorCode(enum.IntEnum):
    """What LAST_ERROR says."""

    SUCCESS = 0
    BAD_SYNC = 1
    INVALID_LENGTH = 2
    BAD_CRC = 3
    BAD_TERMINATOR = 4
    UNKNOWN_OPCODE = 5
    TIMEOUT = 6
    """In the enumeration of all firmwares; none raises it, and `set_error` would neither count nor keep it."""


class MotorFlag(enum.IntFlag):
    """Which motors a command is for; a motor whose bit is 0 keeps its state."""

    A = 0x01
    """The left pair."""
    B = 0x02
    """The right pair."""


BOTH_MOTORS = int(MotorFlag.A | MotorFlag.B)


class StatusFlag(enum.IntFlag):
    """The STATUS byte of the general report; only the Arduino firmware ever sets a bit (application.cpp, `setup`)."""

    AHRS_FAIL = 0x01
    GPS_FAIL = 0x02
