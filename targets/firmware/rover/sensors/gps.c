// SPDX-License-Identifier: GPL-2.0-or-later

#include "rover/sensors/gps.h"

#include "rover/board/gps_line.h"

#define SILENCE_US 3000000u // the receiver speaks each second, with or without a fix (choice)

struct gps gps;

static uint32_t heard_us;

void gps_start(void) { gps_line_start(); }

void gps_poll(uint32_t now_us)
{
    uint8_t byte;
    while (gps_line_get(&byte)) {
        if (nmea_take(byte, &gps.position)) {
            heard_us = now_us;
            gps.failed = false;
        }
    }
}

void gps_tick(uint32_t now_us)
{
    if (gps.failed || now_us - heard_us < SILENCE_US)
        return;
    gps.failed = true;
    gps.position.valid = false;
}
