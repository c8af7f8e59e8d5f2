// SPDX-License-Identifier: GPL-2.0-or-later
//
// The numbers of the protocol (G2 tctm/cmd_def.h, tctm/report_def.h, tctm/tmy_def.h, protocol/protocol.h).

#pragma once

enum opcode {
    REQUEST_TMY = 0x00,
    LED_ON = 0x01,
    LED_OFF = 0x02,
    UPDATE_MOTORS = 0x03,
    UPDATE_SETPOINTS = 0x04,
    RESET_PID = 0x05,
};

enum report {
    REPORT_GENERAL = 0x80,
    REPORT_EXECUTION = 0x81,
    REPORT_IMU = 0x82,
    REPORT_MOTION = 0x83,
    REPORT_GPS = 0x84,
    REPORT_PID = 0x85,
};

enum error {
    SUCCESS = 0,
    BAD_SYNC = 1,
    INVALID_LENGTH = 2,
    BAD_CRC = 3,
    BAD_TERMINATOR = 4,
    UNKNOWN_OPCODE = 5,
};

#define STATUS_AHRS_FAIL 0x01
#define STATUS_GPS_FAIL 0x02
