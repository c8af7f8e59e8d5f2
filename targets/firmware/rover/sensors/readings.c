// SPDX-License-Identifier: GPL-2.0-or-later

#include "rover/sensors/readings.h"

#include "rover/sensors/imu.h"
#include "rover/sensors/mpu9250.h"

#define CALIBRATION_READINGS 50u
#define STILL_LSB 262 // 2 deg/s: what moves more while it is calibrated keeps a bias of 0 (choice)

#define ACCELERATION_G (2.0f / 32768.0f)
#define RATE_DEG_S (250.0f / 32768.0f)
#define FIELD_MGAUSS 1.5f // 0.15 uT (MS1356-E, 8.3.4)

#define ACCELERATION_AT 1u
#define TEMPERATURE_AT 7u
#define RATE_AT 9u

static uint32_t calibrated; // readings
static int32_t rate_sum[3];
static int16_t rate_low[3], rate_high[3];
static float bias_deg_s[3];
static float sensitivity_mgauss[3];

static int16_t big_endian(const uint8_t *at) { return (int16_t)(at[0] << 8 | at[1]); }

static int16_t little_endian(const uint8_t *at) { return (int16_t)(at[1] << 8 | at[0]); }

void readings_begin_calibration(void)
{
    calibrated = 0;
    for (unsigned axis = 0; axis < 3; ++axis) {
        rate_sum[axis] = 0;
        rate_low[axis] = INT16_MAX;
        rate_high[axis] = INT16_MIN;
    }
}

static void end_calibration(void)
{
    for (unsigned axis = 0; axis < 3; ++axis) {
        bool still = rate_high[axis] - rate_low[axis] < STILL_LSB;
        bias_deg_s[axis] = still ? (float)rate_sum[axis] / (float)CALIBRATION_READINGS * RATE_DEG_S : 0.0f;
    }
}

bool readings_calibrate(const uint8_t *bytes)
{
    for (unsigned axis = 0; axis < 3; ++axis) {
        int16_t rate = big_endian(bytes + RATE_AT + 2 * axis);
        rate_sum[axis] += rate;
        if (rate < rate_low[axis])
            rate_low[axis] = rate;
        if (rate > rate_high[axis])
            rate_high[axis] = rate;
    }
    if (++calibrated < CALIBRATION_READINGS)
        return false;
    end_calibration();
    return true;
}

// 128 stands for a factor of 1 (MS1356-E, 8.3.11).
void readings_set_sensitivity(const uint8_t *bytes)
{
    for (unsigned axis = 0; axis < 3; ++axis)
        sensitivity_mgauss[axis] = FIELD_MGAUSS * ((float)(bytes[axis] - 128) / 256.0f + 1.0f);
}

void readings_take_motion(const uint8_t *bytes)
{
    float acceleration_g[3], rate_deg_s[3];
    for (unsigned axis = 0; axis < 3; ++axis) {
        acceleration_g[axis] = (float)big_endian(bytes + ACCELERATION_AT + 2 * axis) * ACCELERATION_G;
        rate_deg_s[axis] = (float)big_endian(bytes + RATE_AT + 2 * axis) * RATE_DEG_S - bias_deg_s[axis];
    }
    imu.acceleration_g = (struct vector){acceleration_g[0], acceleration_g[1], acceleration_g[2]};
    imu.rate_deg_s = (struct vector){rate_deg_s[0], rate_deg_s[1], rate_deg_s[2]};
    imu.temperature_c = (float)big_endian(bytes + TEMPERATURE_AT) / 333.87f + 21.0f;
    imu.valid = true;
    imu.failed = false;
}

// The AK8963's X is the other sensors' Y, its Y their X, its Z points the other way (PS-MPU-9250A-01, section 9.1).
void readings_take_field(const uint8_t *bytes)
{
    if (!(bytes[0] & AK_DRDY))
        return;
    imu.field_valid = !(bytes[7] & AK_HOFL);
    imu.field_mgauss = (struct vector){
        (float)little_endian(bytes + 3) * sensitivity_mgauss[1],
        (float)little_endian(bytes + 1) * sensitivity_mgauss[0],
        -(float)little_endian(bytes + 5) * sensitivity_mgauss[2],
    };
}
