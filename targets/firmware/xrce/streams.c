// SPDX-License-Identifier: GPL-2.0-or-later

#include "xrce/streams.h"

#define BITS 16u
#define BEAT_MS 100u       // to the first HEARTBEAT (Micro-XRCE-DDS-Client: UCLIENT_MIN_HEARTBEAT_TIME_INTERVAL); it doubles
#define LONGEST_MS 1600u   // as long as nothing is acknowledged, up to this (choice)
#define AGAIN_MS 50u       // for so long nothing is sent again twice, whatever ACKNACKs say (choice)

_Static_assert(XRCE_WINDOW >= 1 && XRCE_WINDOW <= BITS, "an ACKNACK has 16 bits");
_Static_assert(0x10000 % XRCE_WINDOW == 0, "a message keeps its place when numbers begin anew");

static bool due(uint32_t when, uint32_t now) { return (int32_t)(now - when) >= 0; }

// Whether a number stands behind another one, on the circle of 65536 (8.3.2.3).
static bool is_newer(uint16_t number, uint16_t than) { return (int16_t)(uint16_t)(number - than) > 0; }

// --- What is sent

void xrce_output_begin(struct xrce_output *output)
{
    output->first = output->count = 0;
    output->pause = BEAT_MS;
}

static void restart(struct xrce_output *output, uint32_t now)
{
    output->pause = BEAT_MS;
    output->due = now + BEAT_MS;
    output->since = now;
}

static struct xrce_body *body_of(struct xrce_output *output, uint16_t number) { return &output->sent[number % XRCE_WINDOW]; }

struct xrce_body *xrce_output_room(struct xrce_output *output)
{
    return output->count < XRCE_WINDOW ? body_of(output, (uint16_t)(output->first + output->count)) : 0;
}

uint16_t xrce_output_push(struct xrce_output *output, uint32_t now)
{
    uint16_t number = (uint16_t)(output->first + output->count);
    body_of(output, number)->again = now;
    if (output->count++ == 0)
        restart(output, now);
    return number;
}

void xrce_output_acknowledged(struct xrce_output *output, uint16_t first, uint16_t nacks, uint32_t now, uint16_t *missing)
{
    uint16_t received = (uint16_t)(first - output->first);
    *missing = 0;
    if (received > output->count) // about others than those sent
        return;
    output->first = first;
    output->count = (uint16_t)(output->count - received);
    output->pause = BEAT_MS;
    output->due = now + BEAT_MS;
    if (received)
        output->since = now;
    for (uint16_t i = 0; i < output->count; ++i) {
        struct xrce_body *one = body_of(output, (uint16_t)(first + i));
        if (!(nacks >> i & 1) || !due(one->again, now))
            continue;
        one->again = now + AGAIN_MS;
        *missing = (uint16_t)(*missing | 1u << i);
    }
}

bool xrce_output_beat(struct xrce_output *output, uint32_t now)
{
    if (!output->count || !due(output->due, now))
        return false;
    output->pause = 2 * output->pause < LONGEST_MS ? 2 * output->pause : LONGEST_MS;
    output->due = now + output->pause;
    return true;
}

// --- What comes

void xrce_input_begin(struct xrce_input *input)
{
    input->expected = 0;
    input->latest = 0xFFFF;
    for (uint32_t i = 0; i < XRCE_WINDOW; ++i)
        input->early[i].here = false;
}

static void announce(struct xrce_input *input, uint16_t number)
{
    if (is_newer(number, input->latest))
        input->latest = number;
}

void xrce_input_take(struct xrce_input *input, uint16_t number, const uint8_t *body, uint32_t count)
{
    struct xrce_body *one = &input->early[number % XRCE_WINDOW];
    uint16_t ahead = (uint16_t)(number - input->expected);
    if (ahead < BITS)
        announce(input, number);
    if (ahead >= XRCE_WINDOW || one->here || count > XRCE_MTU)
        return;
    for (uint32_t i = 0; i < count; ++i)
        one->bytes[i] = body[i];
    one->count = count;
    one->here = true;
}

const struct xrce_body *xrce_input_next(struct xrce_input *input)
{
    struct xrce_body *one = &input->early[input->expected % XRCE_WINDOW];
    if (!one->here)
        return 0;
    one->here = false;
    ++input->expected;
    return one;
}

bool xrce_input_announced(struct xrce_input *input, uint16_t first, uint16_t last)
{
    announce(input, last);
    if (!is_newer(first, input->expected))
        return false;
    for (uint16_t i = 0; i < XRCE_WINDOW && (uint16_t)(input->expected + i) != first; ++i)
        input->early[(uint16_t)(input->expected + i) % XRCE_WINDOW].here = false;
    input->expected = first;
    announce(input, (uint16_t)(first - 1));
    return true;
}

uint16_t xrce_input_missing(const struct xrce_input *input)
{
    uint16_t missing = 0, sent = (uint16_t)(input->latest + 1 - input->expected);
    for (uint16_t i = 0; i < sent && i < XRCE_WINDOW; ++i)
        if (!input->early[(uint16_t)(input->expected + i) % XRCE_WINDOW].here)
            missing = (uint16_t)(missing | 1u << i);
    return missing;
}
