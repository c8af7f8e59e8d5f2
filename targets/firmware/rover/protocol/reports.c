// SPDX-License-Identifier: GPL-2.0-or-later

#include "rover/protocol/reports.h"

#include "rover/control/drive.h"
#include "rover/control/tachometer.h"
#include "rover/options.h"
#include "rover/protocol/bytes.h"
#include "rover/protocol/codes.h"
#include "rover/protocol/encoder.h"
#include "rover/protocol/telemetry.h"
#include "rover/sensors/angles.h"
#include "rover/sensors/gps.h"
#include "rover/sensors/imu.h"

#define GRAVITY_M_S2 9.80665f
#define HEAD 4u // id, one byte of its own or 0, two zeros

static uint8_t payload[MAX_REPORT]; // kept from report to report

static uint8_t *begin(enum report report)
{
    payload[0] = (uint8_t)report;
    payload[1] = payload[2] = payload[3] = 0;
    return payload + HEAD;
}

static void send(const uint8_t *end) { encoder_send(payload, (uint32_t)(end - payload)); }

static uint8_t status(void)
{
    if (DEFECT_STATUS_ZERO)
        return 0;
    return (uint8_t)((imu.failed ? STATUS_AHRS_FAIL : 0) | (gps.failed ? STATUS_GPS_FAIL : 0));
}

void report_general(void)
{
    payload[0] = REPORT_GENERAL;
    payload[1] = telemetry.accepted;
    payload[2] = telemetry.rejected;
    payload[3] = telemetry.last_opcode;
    payload[4] = telemetry.last_error;
    payload[5] = status();
    send(payload + 5 + GENERAL_STATUS);
}

void report_execution(void)
{
    payload[0] = REPORT_EXECUTION;
    payload[1] = telemetry.last_opcode;
    payload[2] = telemetry.last_error;
    send(payload + 3);
}

static uint8_t *put_vector(uint8_t *at, struct vector v, float scale)
{
    at = put_float(at, v.x * scale);
    at = put_float(at, v.y * scale);
    return put_float(at, v.z * scale);
}

static uint8_t *put_quaternion(uint8_t *at, struct quaternion q)
{
    if (DEFECT_QUAT_WXYZ)
        at = put_float(at, q.w);
    at = put_vector(at, (struct vector){q.x, q.y, q.z}, 1.0f);
    return DEFECT_QUAT_WXYZ ? at : put_float(at, q.w);
}

void report_imu(void)
{
    uint8_t *at = begin(REPORT_IMU);
    payload[1] = (uint8_t)(imu.valid | imu.field_valid << 1);
    at = put_vector(at, imu.acceleration_g, DEFECT_ACCEL_G ? 1.0f : GRAVITY_M_S2);
    at = put_vector(at, imu.rate_deg_s, 1.0f);
    at = put_vector(at, imu.field_mgauss, 1.0f);
    at = put_float(at, imu.temperature_c);
    if (SCHEMA == SCHEMA_V1) {
        at = put_vector(at, angles.from_field_rad, 1.0f);
        at = put_vector(at, angles.from_rates_rad, 1.0f);
    } else {
        at = put_quaternion(at, attitude);
    }
    send(at);
}

static uint8_t *put_throttle(uint8_t *at, float throttle)
{
    if (SCHEMA == SCHEMA_V2)
        return put_float(at, throttle);
    int16_t speed = (int16_t)(throttle * 255.0f);
    return put_bytes(at, &speed, sizeof speed);
}

void report_motion(void)
{
    uint8_t *at = begin(REPORT_MOTION);
    for (unsigned wheel = 0; wheel < WHEELS; ++wheel)
        at = put_float(at, tachometer_rpm(wheel));
    for (unsigned wheel = 0; wheel < WHEELS; ++wheel)
        at = put_u32(at, tachometer_slots(wheel));
    for (unsigned side = LEFT; side < SIDES; ++side)
        at = put_throttle(at, drive_throttle_of(side));
    for (unsigned side = LEFT; side < SIDES; ++side)
        at = put_float(at, drive_setpoint_of(side));
    send(at);
}

void report_gps(void)
{
    uint8_t stale = payload[1];
    uint8_t *at = begin(REPORT_GPS);
    payload[1] = DEFECT_STALE_BYTE_84 ? stale : gps.position.valid;
    at = put_float(at, DEFECT_GPS_ORDER ? gps.position.longitude_deg : gps.position.latitude_deg);
    at = put_float(at, DEFECT_GPS_ORDER ? gps.position.latitude_deg : gps.position.longitude_deg);
    send(at);
}

void report_pid(void)
{
    const struct pid *pid = drive_pid_of(LEFT);
    uint8_t *at = begin(REPORT_PID);
    at = put_float(at, PID_MAX);
    at = put_float(at, PID_MIN);
    at = put_float(at, pid->kp);
    at = put_float(at, DEFECT_KD_KI_GETTERS ? pid->kp : pid->kd);
    at = put_float(at, DEFECT_KD_KI_GETTERS ? pid->kp : pid->ki);
    send(at);
}
