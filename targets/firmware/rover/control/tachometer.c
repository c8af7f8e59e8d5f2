// SPDX-License-Identifier: GPL-2.0-or-later

#include "rover/control/tachometer.h"

#include <stdbool.h>

#include "chip/cpu.h"
#include "rover/options.h"

#define SLOTS (DEFECT_SLOTS_32 ? 32u : 20u)
#define MAX_INTERVAL_US 1000000u
#define MAX_RPM 1000.0f
#define WINDOW 3u

static struct {
    // Written by the interrupt
    uint32_t edge_us;     // when the last slot passed
    uint32_t interval_us; // between the last two; 0 if there are no two within MAX_INTERVAL_US
    uint32_t slots;
    bool turning; // edge_us means something
    // Written by the update
    float window[WINDOW];
    float rpm;
} wheels[WHEELS];

static uint32_t updates;

void tachometer_start(void)
{
    for (unsigned wheel = 0; wheel < WHEELS; ++wheel)
        for (unsigned i = 0; i < WINDOW; ++i)
            wheels[wheel].window[i] = DEFECT_FIRST_RPM_1 ? (float)i : 0.0f;
}

void wheels_edge(enum wheel wheel, uint32_t now_us)
{
    uint32_t interval_us = now_us - wheels[wheel].edge_us;
    wheels[wheel].interval_us = wheels[wheel].turning && interval_us <= MAX_INTERVAL_US ? interval_us : 0;
    wheels[wheel].edge_us = now_us;
    wheels[wheel].turning = true;
    ++wheels[wheel].slots;
}

// Without an interrupt in between. That a wheel stands is remembered: the age of its last edge wraps some day. An edge that
// came after `now_us` was taken has a negative age. While the next edge is late, the wheel is as slow as that at least.
static uint32_t interval_of(enum wheel wheel, uint32_t now_us)
{
    irq_disable();
    int32_t age_us = (int32_t)(now_us - wheels[wheel].edge_us);
    if (age_us >= (int32_t)MAX_INTERVAL_US)
        wheels[wheel].turning = false;
    uint32_t interval_us = wheels[wheel].turning ? wheels[wheel].interval_us : 0;
    irq_enable();
    if (!DEFECT_RPM_HELD && interval_us && age_us > (int32_t)interval_us)
        return (uint32_t)age_us;
    return interval_us;
}

static float reading_of(enum wheel wheel, uint32_t now_us)
{
    uint32_t interval_us = interval_of(wheel, now_us);
    if (interval_us == 0)
        return 0.0f;
    float rpm = 60.0e6f / (float)(SLOTS * interval_us);
    return rpm > MAX_RPM ? 0.0f : rpm;
}

static float median(const float *of)
{
    float low = of[0] < of[1] ? of[0] : of[1], high = of[0] < of[1] ? of[1] : of[0];
    return of[2] < low ? low : of[2] > high ? high : of[2];
}

void tachometer_update(uint32_t now_us)
{
    for (unsigned wheel = 0; wheel < WHEELS; ++wheel) {
        wheels[wheel].window[updates % WINDOW] = reading_of(wheel, now_us);
        float rpm = median(wheels[wheel].window);
        wheels[wheel].rpm = DEFECT_RPM_150 && rpm > 150.0f ? 0.0f : rpm;
    }
    ++updates;
}

float tachometer_rpm(enum wheel wheel) { return wheels[wheel].rpm; }

uint32_t tachometer_slots(enum wheel wheel) { return wheels[wheel].slots; }

float tachometer_side_rpm(enum side side)
{
    float front = wheels[side == LEFT ? LEFT_FRONT : RIGHT_FRONT].rpm;
    float back = wheels[side == LEFT ? LEFT_BACK : RIGHT_BACK].rpm;
    return front < back ? front : back;
}
