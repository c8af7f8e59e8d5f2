// SPDX-License-Identifier: GPL-2.0-or-later
//
// The client for a test on the host: what it sends and hears is put aside, and fetched.

#include <string.h>

#include "xrce/client.h"

#define ROOM (1u << 20)

static const struct xrce_endpoint ENDPOINTS[] = {
    {.kind = XRCE_WRITES, .topic = "rt/up", .type = "std_msgs::msg::dds_::Float32_"},
    {.kind = XRCE_READS, .topic = "rt/down", .type = "std_msgs::msg::dds_::Float32_"},
    {.kind = XRCE_WRITES, .best_effort = true, .topic = "rt/up_best", .type = "std_msgs::msg::dds_::Float32_"},
    {.kind = XRCE_READS, .best_effort = true, .topic = "rt/down_best", .type = "std_msgs::msg::dds_::Float32_"},
    {.kind = XRCE_SERVES,
     .topic = "rq/askRequest",
     .type = "std_srvs::srv::dds_::SetBool_Request_",
     .reply_topic = "rr/askReply",
     .reply_type = "std_srvs::srv::dds_::SetBool_Response_",
     .service = "ask"},
};

struct heard {
    uint32_t endpoint, count, big_endian;
    uint8_t data[XRCE_WHOLE];
};

static struct {
    struct xrce_client client;
    struct xrce_config config;
    uint8_t out[ROOM];
    uint32_t out_count;
    struct heard heard[256];
    uint32_t heard_count;
    uint32_t changes;
} here;

static void put(void *context, const uint8_t *frame, uint32_t count)
{
    (void)context;
    if (here.out_count + count > ROOM)
        return;
    memcpy(here.out + here.out_count, frame, count);
    here.out_count += count;
}

static void hear(void *context, uint32_t endpoint, struct cdr_reader *in)
{
    (void)context;
    struct heard *one = &here.heard[here.heard_count++ % 256];
    *one = (struct heard){.endpoint = endpoint, .count = in->count - in->at, .big_endian = in->big_endian};
    memcpy(one->data, in->begin + in->at, one->count);
}

static void change(void *context, enum xrce_state state)
{
    (void)context, (void)state;
    ++here.changes;
}

void begin(int domain, uint32_t lost, uint32_t now)
{
    memset(&here, 0, sizeof here);
    here.config = (struct xrce_config){.key = {0xC1, 2, 3, 4},
                                       .session_id = 0x81,
                                       .domain = (int16_t)domain,
                                       .times = {.ping = 200, .retry = 500, .quiet = 300, .lost = lost},
                                       .endpoints = ENDPOINTS,
                                       .endpoint_count = sizeof ENDPOINTS / sizeof *ENDPOINTS,
                                       .send = put,
                                       .heard = hear,
                                       .changed = change};
    xrce_begin(&here.client, &here.config, now);
}

int can_begin_with(uint32_t endpoint_count)
{
    static struct xrce_client client;
    static struct xrce_config config;
    config = (struct xrce_config){.endpoints = ENDPOINTS, .endpoint_count = endpoint_count, .send = put, .heard = hear};
    return xrce_begin(&client, &config, 0);
}

void receive(const uint8_t *data, uint32_t count, uint32_t now)
{
    for (uint32_t i = 0; i < count; ++i)
        xrce_receive(&here.client, data[i], now);
}

uint32_t advance(uint32_t now) { return xrce_advance(&here.client, now); }

int write_sample(uint32_t endpoint, const uint8_t *data, uint32_t count, uint32_t now)
{
    return xrce_write(&here.client, endpoint, data, count, now);
}

void end(uint32_t now) { xrce_end(&here.client, now); }

void number_from(uint32_t number)
{
    here.client.output.first = here.client.input.expected = (uint16_t)number;
    here.client.input.latest = (uint16_t)(number - 1);
}

int state(void) { return here.client.state; }

uint32_t unacknowledged(void) { return here.client.output.count; }

uint32_t take_out(uint8_t *to)
{
    uint32_t count = here.out_count;
    memcpy(to, here.out, count);
    here.out_count = 0;
    return count;
}

uint32_t take_heard(struct heard *to)
{
    uint32_t count = here.heard_count;
    memcpy(to, here.heard, sizeof here.heard);
    here.heard_count = 0;
    return count;
}
