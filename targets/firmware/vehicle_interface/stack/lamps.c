// SPDX-License-Identifier: GPL-2.0-or-later

#include "vehicle_interface/stack/lamps.h"

#include <stdbool.h>

#include "vehicle_interface/board/lights.h"
#include "vehicle_interface/kernel/kernel.h"

#define EDGES_PER_S 3u // 1.5 flashes

static uint8_t turn = TURN_DISABLE, hazard = HAZARD_DISABLE;
static uint32_t since; // the last change: they begin to flash then

static bool left(void) { return hazard == HAZARD_ENABLE || turn == TURN_LEFT; }

static bool right(void) { return hazard == HAZARD_ENABLE || turn == TURN_RIGHT; }

void lamps_turn(uint8_t command, uint32_t tick)
{
    if (command < TURN_DISABLE || command > TURN_RIGHT || command == turn)
        return;
    turn = command;
    since = tick;
}

void lamps_hazard(uint8_t command, uint32_t tick)
{
    if ((command != HAZARD_DISABLE && command != HAZARD_ENABLE) || command == hazard)
        return;
    hazard = command;
    since = tick;
}

uint8_t lamps_turn_report(void) { return turn; }

uint8_t lamps_hazard_report(void) { return hazard; }

uint32_t lamps_update(uint32_t tick)
{
    if (!left() && !right()) {
        light_put(LAMP_LEFT, false);
        light_put(LAMP_RIGHT, false);
        return FOR_EVER;
    }
    uint32_t lit_for = tick - since, edges = lit_for * EDGES_PER_S / TICK_HZ;
    bool lit = edges % 2 == 0;
    light_put(LAMP_LEFT, lit && left());
    light_put(LAMP_RIGHT, lit && right());
    return ((edges + 1) * TICK_HZ + EDGES_PER_S - 1) / EDGES_PER_S - lit_for;
}
