// SPDX-License-Identifier: GPL-2.0-or-later

#include "xrce/objects.h"

// The last four bits of an id (7.7.1; requester and replier are eProsima's).
enum { PARTICIPANT = 1, TOPIC = 2, PUBLISHER = 3, SUBSCRIBER = 4, DATAWRITER = 5, DATAREADER = 6, REPLIER = 8 };

#define ID(number, kind) ((uint16_t)((number) << 4 | (kind)))
#define PARTICIPANT_ID ID(1, PARTICIPANT)
#define PUBLISHER_ID ID(1, PUBLISHER)
#define SUBSCRIBER_ID ID(1, SUBSCRIBER)
#define TOPIC_ID(endpoint) ID((endpoint) + 2, TOPIC)

#define COMMON 3u // places that are no endpoint's
#define IN_BINARY 3
#define QOS_RELIABLE 0x01u
#define QOS_KEEP_LAST 0x02u

static const uint8_t KINDS[] = {[XRCE_WRITES] = DATAWRITER, [XRCE_READS] = DATAREADER, [XRCE_SERVES] = REPLIER};

uint16_t xrce_endpoint_id(const struct xrce_endpoint *endpoints, uint32_t endpoint)
{
    return ID(endpoint + 2, KINDS[endpoints[endpoint].kind]);
}

uint16_t xrce_object_id(const struct xrce_endpoint *endpoints, uint32_t place)
{
    static const uint16_t COMMON_IDS[COMMON] = {PARTICIPANT_ID, PUBLISHER_ID, SUBSCRIBER_ID};
    if (place < COMMON)
        return COMMON_IDS[place];
    uint32_t endpoint = (place - COMMON) / 2;
    if ((place - COMMON) % 2)
        return xrce_endpoint_id(endpoints, endpoint);
    return endpoints[endpoint].kind == XRCE_SERVES ? 0 : TOPIC_ID(endpoint);
}

static void put_maybe(struct cdr_writer *out, const char *text)
{
    cdr_put_u8(out, text != 0);
    if (text)
        cdr_put_text(out, text);
}

static void put_nothing(struct cdr_writer *out, uint32_t fields)
{
    while (fields--)
        cdr_put_u8(out, 0);
}

// Deadline, lifespan, user data, and what a writer (ownership strength) or a reader (time filter, content filter) has besides.
static void put_qos(struct cdr_writer *out, const struct xrce_endpoint *endpoint)
{
    cdr_put_u8(out, 1);
    cdr_put_u16(out, QOS_KEEP_LAST | (endpoint->best_effort ? 0 : QOS_RELIABLE));
    cdr_put_u8(out, 1);
    cdr_put_u16(out, 1);
    put_nothing(out, endpoint->kind == XRCE_WRITES ? 4 : 5);
}

static void put_binary(struct cdr_writer *out, const struct xrce_endpoint *endpoint, uint16_t id, uint16_t topic_id)
{
    switch (id & 0xF) {
    case TOPIC:
        cdr_put_text(out, endpoint->topic);
        put_maybe(out, 0);
        put_maybe(out, endpoint->type);
        break;
    case DATAWRITER:
    case DATAREADER:
        cdr_put_id(out, topic_id);
        put_qos(out, endpoint);
        break;
    case REPLIER:
        cdr_put_text(out, endpoint->service);
        cdr_put_text(out, endpoint->type);
        cdr_put_text(out, endpoint->reply_type);
        put_maybe(out, endpoint->topic);
        put_maybe(out, endpoint->reply_topic);
        break;
    default: // participant, publisher, subscriber: neither names nor qualities
        put_nothing(out, 2);
        break;
    }
}

static uint16_t parent_of(uint16_t id)
{
    switch (id & 0xF) {
    case DATAWRITER:
        return PUBLISHER_ID;
    case DATAREADER:
        return SUBSCRIBER_ID;
    default:
        return PARTICIPANT_ID;
    }
}

// The representation stands behind its length, and is aligned from its own begin.
void xrce_put_object(struct cdr_writer *out, const struct xrce_endpoint *endpoints, uint32_t place, int16_t domain)
{
    uint16_t id = xrce_object_id(endpoints, place);
    uint32_t endpoint = place < COMMON ? 0 : (place - COMMON) / 2;
    cdr_put_u8(out, id & 0xF);
    cdr_put_u8(out, IN_BINARY);
    cdr_put_u32(out, 0);
    struct cdr_writer binary = {.begin = out->begin + out->count, .most = out->most - out->count, .bad = out->bad};
    put_binary(&binary, endpoints + endpoint, id, TOPIC_ID(endpoint));
    struct cdr_writer length = {.begin = out->begin + out->count - 4, .most = 4, .bad = out->bad};
    cdr_put_u32(&length, binary.count);
    out->count += binary.count;
    out->bad |= binary.bad;
    if (id == PARTICIPANT_ID)
        cdr_put_u16(out, (uint16_t)domain);
    else
        cdr_put_id(out, parent_of(id));
}
