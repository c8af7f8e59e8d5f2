// SPDX-License-Identifier: GPL-2.0-or-later
//
// In each tick what is read comes first, then what is driven, then what is reported (G2 application.cpp, periodic_tasks).

#include "rover/rover.h"

#include "rover/board/leds.h"
#include "rover/board/link.h"
#include "rover/board/time.h"
#include "rover/control/drive.h"
#include "rover/control/tachometer.h"
#include "rover/options.h"
#include "rover/protocol/commands.h"
#include "rover/protocol/decoder.h"
#include "rover/protocol/reports.h"
#include "rover/protocol/telemetry.h"
#include "rover/sensors/angles.h"
#include "rover/sensors/gps.h"
#include "rover/sensors/imu.h"

#define RAD_PER_DEG 0.0174532925f
#define LOOK_BYTES 32u
#define EAGAIN 11u
#define ALIVE_TICKS TICK_HZ // the light changes each second

static const struct task {
    void (*report)(void);
    uint16_t every_ticks;
    uint16_t first_tick;
} TASKS[] = {
#if RATES == RATES_G2 // 3, 4, 1 and 1 Hz, rounded as G2 rounds them
    {report_general, 33, 0},
    {report_motion, 25, 0},
    {report_imu, 100, 0},
    {report_gps, 100, 0},
#elif RATES == RATES_G0
    {report_imu, 20, 20},
    {report_general, 100, 100},
#endif
#if PID_REPORT_TICKS
    {report_pid, PID_REPORT_TICKS, 0},
#endif
    {0},
};

void rover_start(void)
{
    tachometer_start();
    attitude_start();
    drive_start();
    imu_start();
    if (!DEFECT_NO_GPS)
        gps_start();
}

static void take_all(uint32_t now_us)
{
    uint8_t byte;
    while (link_get(&byte))
        decoder_take(byte, now_us);
}

// As G2 reads: what has come since the last tick, 32 bytes at most, the rest next time.
static void look(uint32_t now_us)
{
    uint32_t count = link_waiting();
    if (count > LOOK_BYTES)
        count = LOOK_BYTES;
    bool thrown_away = DEFECT_EAGAIN_11 && count == EAGAIN;
    uint8_t byte;
    for (; count && link_get(&byte); --count)
        if (!thrown_away)
            decoder_take(byte, now_us);
}

static void blink(uint32_t tick)
{
    if (tick % ALIVE_TICKS == 0 && telemetry.accepted == 0)
        led_toggle(DEFECT_LED_SHARED ? LED_TEST : LED_ALIVE);
}

static void report(uint32_t tick)
{
    for (const struct task *task = TASKS; task->report; ++task)
        if (tick >= task->first_tick && tick % task->every_ticks == 0)
            task->report();
}

void imu_read(float dt_s)
{
    struct vector rate_rad_s = {imu.rate_deg_s.x * RAD_PER_DEG, imu.rate_deg_s.y * RAD_PER_DEG,
                                imu.rate_deg_s.z * RAD_PER_DEG};
    if (SCHEMA == SCHEMA_V1)
        angles_update(rate_rad_s, imu.acceleration_g, imu.field_mgauss, dt_s);
    else
        attitude_update(rate_rad_s, imu.acceleration_g, imu.field_mgauss, imu.field_valid, dt_s);
}

void rover_poll(uint32_t now_us)
{
    if (!DEFECT_POLLED)
        take_all(now_us);
    if (!DEFECT_NO_GPS)
        gps_poll(now_us);
    imu_poll();
}

void rover_tick(uint32_t tick, uint32_t now_us)
{
    blink(tick);
    if (DEFECT_POLLED)
        look(now_us);
    decoder_tick(now_us);
    commands_tick(now_us);
    imu_tick(tick);
    if (!DEFECT_NO_GPS)
        gps_tick(now_us);
    if (tick % TACHOMETER_TICKS == 0)
        tachometer_update(now_us);
    if (tick % DRIVE_TICKS == 0)
        drive_update();
    report(tick);
}
