// SPDX-License-Identifier: GPL-2.0-or-later

#include "vehicle_interface/control/inputs.h"

#include "vehicle_interface/board/joystick.h"
#include "vehicle_interface/board/simulator_line.h"
#include "vehicle_interface/options.h"
#include "vehicle_interface/simulator/status.h"

static struct status received; // in blocks it is written field by field
static struct status_reader reader;

struct status status_received(void) { return received; }

static void take(const struct status *status)
{
    if (!DEFECT_H1 && !status_plausible(status))
        return;
    received = *status;
    exchange.status_tick = kernel_tick();
    events_set(&board_events, BOARD_STATUS);
}

void simulator_line_received(const volatile uint8_t *bytes, uint32_t count)
{
    static struct status live;
    if (DEFECT_H2) {
        if (status_take_block(bytes, &live))
            take(&live);
        return;
    }
    for (uint32_t i = 0; i < count; ++i) {
        struct status status;
        if (status_take(&reader, bytes[i], kernel_tick(), &status))
            take(&status);
    }
}

// The switch bounces; and for the first second nothing is taken for a press, as 0 counts as the last one.
void joystick_released(void)
{
    static uint32_t last;
    uint32_t tick = kernel_tick();
    if (tick > last + DEBOUNCE_TICKS) {
        last = tick;
        events_set(&board_events, BOARD_SWITCH);
    }
}
