// SPDX-License-Identifier: GPL-2.0-or-later
//
// First a script, one transfer each step, then half a second of readings at rest for the gyroscope's bias, then a reading
// each READ_TICKS. Each transfer has TRANSFER_TICKS; whatever fails ends in a pause, and then the script begins anew.

#include "rover/sensors/imu.h"

#include "rover/board/i2c.h"
#include "rover/board/time.h"
#include "rover/sensors/mpu9250.h"
#include "rover/sensors/readings.h"

#define READ_TICKS 10u    // 10 Hz (manual, table of tasks)
#define READ_BEFORE 1u    // ticks ahead, so that what is reported at a multiple of them is fresh
#define START_TICKS 10u   // 100 ms from power-up to the first register (PS-MPU-9250A-01, 3.4.2)
#define TRANSFER_TICKS 3u // 16 bytes take half a millisecond
#define RETRY_TICKS 100u
#define MISSES_ALLOWED 5u // readings in a row without new data

// --- the script

enum action { WRITE, EXPECT, EXPECT_OR_NO_FIELD, READ_SENSITIVITY };

static const struct step {
    enum action action;
    uint8_t device, reg, value;
    uint8_t wait_ticks; // behind it
} SCRIPT[] = {
    {EXPECT, MPU, MPU_WHO_AM_I, MPU_ID, 0},
    {WRITE, MPU, MPU_PWR_MGMT_1, MPU_RESET, START_TICKS},
    {WRITE, MPU, MPU_PWR_MGMT_1, MPU_CLOCK_PLL, 4},
    {WRITE, MPU, MPU_CONFIG, MPU_DLPF_41HZ, 0},
    {WRITE, MPU, MPU_SMPLRT_DIV, MPU_RATE_200HZ, 0},
    {WRITE, MPU, MPU_GYRO_CONFIG, MPU_250DPS, 0},
    {WRITE, MPU, MPU_ACCEL_CONFIG, MPU_2G, 0},
    {WRITE, MPU, MPU_ACCEL_CONFIG2, MPU_DLPF_41HZ, 0},
    {WRITE, MPU, MPU_INT_PIN_CFG, MPU_INT_LATCH_ANYRD_BYPASS, 0},
    {WRITE, MPU, MPU_INT_ENABLE, MPU_RAW_RDY, 0},
    {EXPECT_OR_NO_FIELD, AK, AK_WIA, AK_ID, 0},
    {WRITE, AK, AK_CNTL1, AK_POWER_DOWN, 1}, // 100 us at least between two modes
    {WRITE, AK, AK_CNTL1, AK_FUSE_ROM, 1},
    {READ_SENSITIVITY, AK, AK_ASAX, 3, 0},
    {WRITE, AK, AK_CNTL1, AK_POWER_DOWN, 1},
    {WRITE, AK, AK_CNTL1, AK_16BIT_100HZ, 1},
};

#define STEPS (sizeof SCRIPT / sizeof *SCRIPT)

static enum { PAUSED, IN_SCRIPT, CALIBRATING, RUNNING } phase;
static enum { NOTHING, A_STEP, THE_MPU, THE_AK } asked; // of the bus
static uint32_t step;
static uint32_t wait_ticks;         // until the next step, or the end of the pause
static uint32_t transfer_ticks;     // until a transfer is given up
static uint8_t bytes[MOTION_BYTES]; // that the transfer under way brings
static bool has_field;
static uint32_t misses;

struct imu imu;

static void ask_read(unsigned what, uint8_t device, uint8_t reg, uint8_t count)
{
    asked = what;
    transfer_ticks = TRANSFER_TICKS;
    i2c_read(device, reg, bytes, count);
}

static void fail(void)
{
    imu.valid = imu.field_valid = false;
    imu.failed = true;
    asked = NOTHING;
    phase = PAUSED;
    wait_ticks = RETRY_TICKS;
    misses = 0;
}

void imu_start(void)
{
    i2c_start();
    phase = IN_SCRIPT;
    asked = NOTHING;
    step = 0;
    wait_ticks = START_TICKS;
    has_field = true;
}

static void ask_step(void)
{
    const struct step *now = &SCRIPT[step];
    if (now->action == WRITE) {
        asked = A_STEP;
        transfer_ticks = TRANSFER_TICKS;
        i2c_write(now->device, now->reg, now->value);
    } else {
        ask_read(A_STEP, now->device, now->reg, now->action == READ_SENSITIVITY ? now->value : 1);
    }
}

static void end_script(void)
{
    step = 0;
    phase = CALIBRATING;
    readings_begin_calibration();
}

// The next step follows at once, unless the sensor needs time.
static void take_step(bool done)
{
    const struct step *now = &SCRIPT[step];
    bool right = done && (now->action == WRITE || now->action == READ_SENSITIVITY || bytes[0] == now->value);
    if (!right && now->action == EXPECT_OR_NO_FIELD) {
        has_field = false;
        end_script();
    } else if (!right) {
        fail();
    } else {
        if (now->action == READ_SENSITIVITY)
            readings_set_sensitivity(bytes);
        wait_ticks = now->wait_ticks;
        if (++step == STEPS)
            end_script();
        else if (wait_ticks == 0)
            ask_step();
    }
}

// --- readings

static void end_reading(void)
{
    asked = NOTHING;
    imu_read((float)READ_TICKS / TICK_HZ);
}

static void take_mpu(void)
{
    asked = NOTHING;
    if (!(bytes[0] & MPU_RAW_RDY)) {
        if (++misses > MISSES_ALLOWED)
            fail();
        return;
    }
    misses = 0;
    if (phase == CALIBRATING) {
        phase = readings_calibrate(bytes) ? RUNNING : CALIBRATING;
        return;
    }
    readings_take_motion(bytes);
    if (has_field)
        ask_read(THE_AK, AK, AK_ST1, FIELD_BYTES);
    else
        end_reading();
}

static void take(bool done)
{
    if (asked == A_STEP) {
        asked = NOTHING;
        take_step(done);
    } else if (!done) {
        fail();
    } else if (asked == THE_MPU) {
        take_mpu();
    } else {
        readings_take_field(bytes);
        end_reading();
    }
}

// --- when

static bool is_time_to_read(uint32_t tick)
{
    return phase == CALIBRATING || (phase == RUNNING && (tick + READ_BEFORE) % READ_TICKS == 0);
}

void imu_tick(uint32_t tick)
{
    if (asked != NOTHING) {
        if (--transfer_ticks == 0) {
            i2c_recover();
            fail();
        }
    } else if (wait_ticks) {
        --wait_ticks;
    } else if (phase == PAUSED) {
        phase = IN_SCRIPT;
        step = 0;
        has_field = true;
    } else if (phase == IN_SCRIPT) {
        ask_step();
    } else if (is_time_to_read(tick)) {
        ask_read(THE_MPU, MPU, MPU_INT_STATUS, MOTION_BYTES);
    }
}

void imu_poll(void)
{
    if (asked != NOTHING && i2c_state() != I2C_BUSY)
        take(i2c_state() == I2C_DONE);
}
