// SPDX-License-Identifier: GPL-2.0-or-later

#include "rover/protocol/decoder.h"

#include <stdbool.h>

#include "rover/options.h"
#include "rover/protocol/body.h"

#define TIMEOUT_US 1000000u // G2 config.h, PACKET_TIMEOUT_IN_MS
#define SYNC_BYTES 4u

static const uint8_t SYNC[SYNC_BYTES] = {'P', 'K', 'T', '!'};

static uint32_t found;    // bytes of the sync word
static uint32_t since_us; // when the frame began; with DEFECT_TIMER_SINCE_RESET, when the last one ended

static void begin(uint32_t now_us)
{
    found = 1;
    if (!DEFECT_TIMER_SINCE_RESET)
        since_us = now_us;
}

static void end(uint32_t now_us)
{
    found = 0;
    if (DEFECT_TIMER_SINCE_RESET)
        since_us = now_us;
}

static void fail(enum error error, uint32_t now_us)
{
    end(now_us);
    packet_rejected(error);
}

// A byte that should have been another: if it is a P, the next frame may begin with it.
static void fail_at(uint8_t byte, enum error error, uint32_t now_us)
{
    fail(error, now_us);
    if (!DEFECT_NO_RESYNC && byte == SYNC[0])
        begin(now_us);
}

static void take_sync(uint8_t byte, uint32_t now_us)
{
    if (byte != SYNC[found])
        fail_at(byte, BAD_SYNC, now_us);
    else if (++found == SYNC_BYTES)
        body_begin();
}

static void take_body(uint8_t byte, uint32_t now_us)
{
    switch (body_take(byte)) {
    case BODY_MORE:
        break;
    case BODY_SOUND:
        end(now_us);
        packet_received(body_payload(), body_count(), now_us);
        break;
    case BODY_BAD_LENGTH:
        fail(INVALID_LENGTH, now_us);
        break;
    case BODY_BAD_CRC:
        fail(BAD_CRC, now_us);
        break;
    case BODY_BAD_TERMINATOR:
        fail_at(byte, BAD_TERMINATOR, now_us);
        break;
    }
}

void decoder_take(uint8_t byte, uint32_t now_us)
{
    decoder_tick(now_us);
    if (found == SYNC_BYTES)
        take_body(byte, now_us);
    else if (found)
        take_sync(byte, now_us);
    else if (byte == SYNC[0]) // what else comes between frames is not even counted
        begin(now_us);
}

void decoder_tick(uint32_t now_us)
{
    if (DEFECT_NO_FRAME_TIMEOUT)
        return;
    if (DEFECT_TIMER_SINCE_RESET) {
        for (; now_us - since_us >= TIMEOUT_US; since_us += TIMEOUT_US)
            found = 0;
    } else if (found && now_us - since_us >= TIMEOUT_US) {
        found = 0;
    }
}
