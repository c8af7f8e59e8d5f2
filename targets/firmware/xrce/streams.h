// SPDX-License-Identifier: GPL-2.0-or-later
//
// Both directions of a reliable stream (OMG DDS-XRCE 1.0, 8.4.14). What is sent is kept until it is acknowledged, a window of
// messages at most; HEARTBEAT says what that is, ACKNACK names what is missing of it. What comes too early waits, what comes again
// is dropped. Bodies are what stands behind the header of a message; times are in ms, and go round.

#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "xrce/sizes.h"

struct xrce_body {
    uint8_t bytes[XRCE_MTU];
    uint32_t count;
    uint32_t again; // sent: before this time it is not sent again
    bool here;      // come early
};

struct xrce_output {
    struct xrce_body sent[XRCE_WINDOW]; // message number n at n % XRCE_WINDOW
    uint16_t first, count;              // the number of the oldest that is unacknowledged, and how many there are
    uint32_t pause, due;                // until the next HEARTBEAT, and when that is
    uint32_t since;                     // when the oldest became the oldest
};

struct xrce_input {
    struct xrce_body early[XRCE_WINDOW];
    uint16_t expected, latest; // the number of the next one, and the newest that is known to have been sent
};

void xrce_output_begin(struct xrce_output *output);
void xrce_input_begin(struct xrce_input *input);

// Room for the body of one more message, to be filled and then taken up by `xrce_output_push`; 0 if the window is full.
struct xrce_body *xrce_output_room(struct xrce_output *output);

// Returns its number.
uint16_t xrce_output_push(struct xrce_output *output, uint32_t now);

// Drops what was received. `missing` is what is to be sent again now: bit i is message first + i.
void xrce_output_acknowledged(struct xrce_output *output, uint16_t first, uint16_t nacks, uint32_t now, uint16_t *missing);

// Whether it is time for a HEARTBEAT; then the next one is put off.
bool xrce_output_beat(struct xrce_output *output, uint32_t now);

// Takes a message that came, if it is one more that there is room for.
void xrce_input_take(struct xrce_input *input, uint16_t number, const uint8_t *body, uint32_t count);

// The next body in order, as long as nothing is taken; 0 if it has not come.
const struct xrce_body *xrce_input_next(struct xrce_input *input);

// HEARTBEAT. Returns whether messages are lost: the other end does not have them any more, and the stream goes on behind them.
bool xrce_input_announced(struct xrce_input *input, uint16_t first, uint16_t last);

// The bitmap of an ACKNACK: bit i says that message expected + i is missing, of those that there is room for.
uint16_t xrce_input_missing(const struct xrce_input *input);
