// SPDX-License-Identifier: GPL-2.0-or-later
//
// The known defects of the published rover firmwares, each of which an image can be built with: -DDEFECT_NAME=1.
//
// Each says what goes wrong, and behind the bar where that is to be seen (G0 to G2 as in options.h). Those marked [g2] are
// all in the image rover-g2. Not put back: the division by the number of samples in the sensor's FIFO at start-up
// (G2 mpu9250.cpp), which a Cortex-M answers with 0 unless DIV_0_TRP is set.

#pragma once

// --- decoder

// [g2] The byte that breaks a frame is used up, even if it is the P of the next | all, protocol.cpp
#ifndef DEFECT_NO_RESYNC
#define DEFECT_NO_RESYNC 0
#endif
// [g2] An unfinished frame waits for ever | G1b, G2: nothing calls check_timeouts
#ifndef DEFECT_NO_FRAME_TIMEOUT
#define DEFECT_NO_FRAME_TIMEOUT 0
#endif
// The time of a frame begins with the decoder's last reset, so that it is forgotten too early | G0, G1 protocol.cpp reset
#ifndef DEFECT_TIMER_SINCE_RESET
#define DEFECT_TIMER_SINCE_RESET 0
#endif
// [g2] Bytes are looked for at each tick only, 32 at most: 3200 bytes/s | G2 application.cpp read_telecommands
#ifndef DEFECT_POLLED
#define DEFECT_POLLED DEFECT_EAGAIN_11
#endif
// [g2] A look that yields exactly 11 bytes loses them: compared with EAGAIN, 11, not with -EAGAIN | the same
#ifndef DEFECT_EAGAIN_11
#define DEFECT_EAGAIN_11 0
#endif

// --- commands

// [g2] 0x81 is never sent: the flag tested is that of opcode 0 | G0, G1, G2 application.cpp handle_packet
#ifndef DEFECT_NO_0X81
#define DEFECT_NO_0X81 0
#endif
// 0x81 after LED_ON and LED_OFF alone, as the table of opcodes has it | G2 application.cpp, opcodes
#ifndef DEFECT_0X81_LEDS_ONLY
#define DEFECT_0X81_LEDS_ONLY 0
#endif
// [g2] Parameters that are missing are taken from what earlier frames left in the buffer | all, application.cpp
#ifndef DEFECT_NO_LEN_CHECK
#define DEFECT_NO_LEN_CHECK 0
#endif
// [g2] A throttle beyond -1..1, or NaN, is kept and reported | G2 application.cpp set_motor_throttles
#ifndef DEFECT_THROTTLE_UNCHECKED
#define DEFECT_THROTTLE_UNCHECKED 0
#endif
// [g2] The gains are read four bytes too late | G2 application.cpp config_pid_controller
#ifndef DEFECT_PID_OFFSETS
#define DEFECT_PID_OFFSETS 0
#endif
// [g2] The test LED blinks until the first packet and toggles with each one | G2 application.cpp handle_packet
#ifndef DEFECT_LED_SHARED
#define DEFECT_LED_SHARED 0
#endif

// --- lost connection

// [g2] The motors go on for ever | G2 application.cpp handle_connection_lost: commented out, and nothing calls it
#ifndef DEFECT_NO_LINK_TIMEOUT
#define DEFECT_NO_LINK_TIMEOUT 0
#endif
// The variables are zeroed, the motors go on | G1 at 4720b70, application.cpp handle_connection_lost
#ifndef DEFECT_LINK_STOPS_REPORT_ONLY
#define DEFECT_LINK_STOPS_REPORT_ONLY 0
#endif

// --- reports

// [g2] STATUS is 0, whatever fails | G2: nothing writes TMY_PARAM_STATUS
#ifndef DEFECT_STATUS_ZERO
#define DEFECT_STATUS_ZERO 0
#endif
// [g2] Acceleration in g, where the manual says m/s^2 | G2 mpu9250.cpp
#ifndef DEFECT_ACCEL_G
#define DEFECT_ACCEL_G 0
#endif
// [g2] The quaternion begins with its scalar, where the manual has it last | G2 madwick.cpp, application.cpp read_imu
#ifndef DEFECT_QUAT_WXYZ
#define DEFECT_QUAT_WXYZ 0
#endif
// The filter starts from zeros, and gives NaN for ever. Not [g2]: on hardware chance gave it something else | G2 madwick.h
#ifndef DEFECT_NAN_QUATERNION
#define DEFECT_NAN_QUATERNION 0
#endif
// [g2] Longitude before latitude | G2 application.cpp send_gps_report
#ifndef DEFECT_GPS_ORDER
#define DEFECT_GPS_ORDER 0
#endif
// [g2] The GPS receiver is never read | G2 application.cpp read_gps: commented out
#ifndef DEFECT_NO_GPS
#define DEFECT_NO_GPS 0
#endif
// [g2] Byte 1 of 0x84 is that of the report before | G2 application.cpp send_gps_report
#ifndef DEFECT_STALE_BYTE_84
#define DEFECT_STALE_BYTE_84 0
#endif
// [g2] 0x85 says kp for kd and ki too; to be seen with PID_REPORT_TICKS alone | G2 controllers/pid.h
#ifndef DEFECT_KD_KI_GETTERS
#define DEFECT_KD_KI_GETTERS 0
#endif
// [g2] Nothing is said in the first 955 ms | G2 mpu9250.cpp: sleeps before the first tick
#ifndef DEFECT_SLOW_START
#define DEFECT_SLOW_START 0
#endif

// --- wheels

// [g2] The median's window begins as 0, 1, 2: wheels at rest turn with 1 rpm at first | G2 median_filter.cpp
#ifndef DEFECT_FIRST_RPM_1
#define DEFECT_FIRST_RPM_1 0
#endif
// [g2] More than 150 rpm are shown, and controlled, as 0 | G2 application.cpp read_tachometers
#ifndef DEFECT_RPM_150
#define DEFECT_RPM_150 0
#endif
// [g2] A wheel that stops goes on being shown at its last speed for a second | G2 lm393_tachometer.cpp get_rpm
#ifndef DEFECT_RPM_HELD
#define DEFECT_RPM_HELD 0
#endif
// 32 slots are reckoned with on discs of 20 | G1 at de8cdae
#ifndef DEFECT_SLOTS_32
#define DEFECT_SLOTS_32 0
#endif
// [g2] The speed controllers go on from their old sums when their mode is entered anew | G2 l298n_motor_control.cpp
#ifndef DEFECT_PID_NO_RESET
#define DEFECT_PID_NO_RESET 0
#endif
// [g2] The sum goes on growing while the output is at its limit | G2 controllers/pid.cpp
#ifndef DEFECT_PID_WINDUP
#define DEFECT_PID_WINDUP 0
#endif
