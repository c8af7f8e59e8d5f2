// SPDX-License-Identifier: GPL-2.0-or-later
//
// The simulator's status: # A float B float C float D float $, floats little-endian, and nothing else to tell a damaged frame by.

#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "vehicle_interface/exchange.h"

#define STATUS_FRAME_BYTES 22u

// Finds frames wherever they begin: every letter has to stand in its place; what fails is searched again for a #.
struct status_reader {
    uint8_t bytes[STATUS_FRAME_BYTES]; // of an unfinished frame, a # first
    uint32_t ticks[STATUS_FRAME_BYTES]; // when they came
    uint32_t count;
};

// Takes a byte; true if it completes a frame, which is then in `status`.
bool status_take(struct status_reader *reader, uint8_t byte, uint32_t tick, struct status *status);

// As the original reads a block, always from START on: letters in any order or none at all, each byte of a field written to
// `status` as it comes. True if a $ stood where a letter might.
bool status_take_block(const volatile uint8_t *block, struct status *status);

// Whether all numbers are finite, and none is beyond anything that a car does.
bool status_plausible(const struct status *status);
