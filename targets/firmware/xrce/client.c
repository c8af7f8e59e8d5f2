// SPDX-License-Identifier: GPL-2.0-or-later

#include "xrce/client.h"

// 8.3.5, and dds_xrce_types.idl
enum submessage {
    CREATE_CLIENT = 0,
    CREATE = 1,
    GET_INFO = 2,
    DELETE = 3,
    STATUS_AGENT = 4,
    STATUS = 5,
    INFO = 6,
    WRITE_DATA = 7,
    READ_DATA = 8,
    DATA = 9,
    ACKNACK = 10,
    HEARTBEAT = 11,
    RESET = 12,
    FRAGMENT = 13,
};

#define LITTLE_ENDIAN_FLAG 0x01u
#define REPLACE_FLAG 0x04u // of CREATE
#define LAST_FLAG 0x02u    // of FRAGMENT
#define FORMAT_FLAGS 0x0Eu // of DATA: 0 is plain data

#define NO_SESSION 0x80u
#define NO_STREAM 0x00u
#define BEST_EFFORT 0x01u // the built-in streams (8.3.2.2)
#define RELIABLE 0x80u

#define OBJECT_AGENT 0xFFFDu
#define OBJECT_CLIENT 0xFFFEu
#define ACTIVITY 0x02u // of GET_INFO
#define ERRORS_FROM 0x80u
#define UNLIMITED 0xFFFFu

#define HEADER 4u // bytes of a message's and of a submessage's

// Ids of requests: those of micro-ROS for what concerns the session, and a place behind FIRST for an object.
#define PING_REQUEST 1u
#define END_REQUEST 2u
#define FIRST_REQUEST 10u
#define READ_REQUEST 0x100u // and the endpoint
#define WRITE_REQUEST 0x200u

#define TRIES 3u

static bool due(uint32_t when, uint32_t now) { return (int32_t)(now - when) >= 0; }

static uint32_t places_of(const struct xrce_config *config) { return XRCE_OBJECTS(config->endpoint_count); }

static bool in_session(const struct xrce_client *client) { return client->state >= XRCE_CREATING; }

static void enter(struct xrce_client *client, enum xrce_state state, uint32_t due)
{
    client->state = state;
    client->due = due;
    if (client->config->changed)
        client->config->changed(client->config->context, state);
}

// The agent is there. It is asked for the session once it has been silent.
static void note_heard(struct xrce_client *client, uint32_t now)
{
    client->heard = now;
    client->due = now + client->config->times.quiet;
}

// --- What goes

static void send(struct xrce_client *client, uint8_t session, uint8_t stream, uint16_t number, const uint8_t *body, uint32_t count)
{
    struct cdr_writer out = {.begin = client->message, .most = sizeof client->message};
    cdr_put_u8(&out, session);
    cdr_put_u8(&out, stream);
    cdr_put_u16(&out, number);
    cdr_put_octets(&out, body, count);
    if (!out.bad)
        client->config->send(client->config->context, client->frame, xrce_frame_make(client->frame, out.begin, out.count));
}

// A submessage is written to a body behind its header, which is filled in at last.
static struct cdr_writer payload_in(uint8_t *body, uint32_t most)
{
    return (struct cdr_writer){.begin = body + HEADER, .most = most - HEADER};
}

static uint32_t with_header(uint8_t *body, const struct cdr_writer *payload, enum submessage id, uint8_t flags)
{
    body[0] = (uint8_t)id;
    body[1] = flags | LITTLE_ENDIAN_FLAG;
    body[2] = (uint8_t)payload->count;
    body[3] = (uint8_t)(payload->count >> 8);
    return HEADER + payload->count;
}

#define SMALL 32u // bytes of those that go on no stream

static void send_small(struct xrce_client *client, uint8_t session, uint8_t *body, const struct cdr_writer *payload,
                       enum submessage id)
{
    send(client, session, NO_STREAM, 0, body, with_header(body, payload, id, 0));
}

static void send_ping(struct xrce_client *client, uint8_t session)
{
    uint8_t body[SMALL];
    struct cdr_writer out = payload_in(body, sizeof body);
    cdr_put_id(&out, PING_REQUEST);
    cdr_put_id(&out, OBJECT_AGENT);
    cdr_put_u32(&out, ACTIVITY);
    send_small(client, session, body, &out, GET_INFO);
}

// The version is 1.0; vendor and mtu are as micro-ROS says them (7.8.2.1; session_info.c).
static void send_create_client(struct xrce_client *client)
{
    static const uint8_t WHO[] = {'X', 'R', 'C', 'E', 1, 0, 0x01, 0x0F};
    uint8_t body[SMALL];
    struct cdr_writer out = payload_in(body, sizeof body);
    cdr_put_octets(&out, WHO, sizeof WHO);
    cdr_put_octets(&out, client->config->key, sizeof client->config->key);
    cdr_put_u8(&out, client->config->session_id);
    cdr_put_u8(&out, 0); // no properties
    cdr_put_u16(&out, XRCE_MTU);
    send_small(client, NO_SESSION, body, &out, CREATE_CLIENT);
}

static void send_delete_client(struct xrce_client *client)
{
    uint8_t body[SMALL];
    struct cdr_writer out = payload_in(body, sizeof body);
    cdr_put_id(&out, END_REQUEST);
    cdr_put_id(&out, OBJECT_CLIENT);
    send_small(client, client->config->session_id, body, &out, DELETE);
}

static void send_acknack(struct xrce_client *client)
{
    uint8_t body[SMALL];
    struct cdr_writer out = payload_in(body, sizeof body);
    cdr_put_u16(&out, client->input.expected);
    cdr_put_id(&out, xrce_input_missing(&client->input)); // octets, high one first
    cdr_put_u8(&out, RELIABLE);
    send_small(client, client->config->session_id, body, &out, ACKNACK);
}

static void send_heartbeat(struct xrce_client *client)
{
    const struct xrce_output *output = &client->output;
    uint8_t body[SMALL];
    struct cdr_writer out = payload_in(body, sizeof body);
    cdr_put_u16(&out, output->first);
    cdr_put_u16(&out, (uint16_t)(output->first + output->count - 1));
    cdr_put_u8(&out, RELIABLE);
    send_small(client, client->config->session_id, body, &out, HEARTBEAT);
}

static void send_reliable(struct xrce_client *client, uint16_t number)
{
    const struct xrce_body *one = &client->output.sent[number % XRCE_WINDOW];
    send(client, client->config->session_id, RELIABLE, number, one->bytes, one->count);
}

// --- Reliable requests

static struct cdr_writer request_in(struct xrce_body *room, uint16_t request, uint16_t object)
{
    struct cdr_writer out = payload_in(room->bytes, XRCE_MTU - HEADER);
    cdr_put_id(&out, request);
    cdr_put_id(&out, object);
    return out;
}

static bool send_request(struct xrce_client *client, struct xrce_body *room, const struct cdr_writer *payload,
                         enum submessage id, uint8_t flags, uint32_t now)
{
    if (payload->bad)
        return false;
    room->count = with_header(room->bytes, payload, id, flags);
    send_reliable(client, xrce_output_push(&client->output, now));
    return true;
}

#define MOST_CREATED ((XRCE_WINDOW + 1) / 2) // at once: they are the longest messages, and a line has little room

static bool create(struct xrce_client *client, uint32_t place, uint32_t now)
{
    struct xrce_body *room = xrce_output_room(&client->output);
    if (!room || client->output.count >= MOST_CREATED)
        return false;
    const struct xrce_config *config = client->config;
    uint16_t id = xrce_object_id(config->endpoints, place);
    struct cdr_writer out = request_in(room, (uint16_t)(FIRST_REQUEST + place), id);
    xrce_put_object(&out, config->endpoints, place, config->domain);
    return send_request(client, room, &out, CREATE, REPLACE_FLAG, now);
}

// Samples without an end (7.7.3, DataDeliveryControl).
static bool read(struct xrce_client *client, uint32_t endpoint, uint32_t now)
{
    struct xrce_body *room = xrce_output_room(&client->output);
    if (!room)
        return false;
    const struct xrce_endpoint *endpoints = client->config->endpoints;
    uint16_t id = xrce_endpoint_id(endpoints, endpoint);
    struct cdr_writer out = request_in(room, (uint16_t)(READ_REQUEST + endpoint), id);
    cdr_put_u8(&out, endpoints[endpoint].best_effort ? BEST_EFFORT : RELIABLE);
    cdr_put_u8(&out, 0); // plain data
    cdr_put_u8(&out, 0); // no filter
    cdr_put_u8(&out, 1);
    cdr_put_u16(&out, UNLIMITED);
    for (int limit = 0; limit < 3; ++limit) // time, rate, pace
        cdr_put_u16(&out, 0);
    return send_request(client, room, &out, READ_DATA, 0, now);
}

// Creates and reads as far as the window goes; what was confirmed last opens the session.
static void go_on(struct xrce_client *client, uint32_t now)
{
    const struct xrce_config *config = client->config;
    for (; client->state == XRCE_CREATING && client->next_place < places_of(config); ++client->next_place) {
        if (!xrce_object_id(config->endpoints, client->next_place))
            continue;
        if (!create(client, client->next_place, now))
            return;
        client->asked |= 1u << client->next_place;
    }
    if (client->state != XRCE_CREATING || client->confirmed != client->asked)
        return;
    for (; client->next_place < places_of(config) + config->endpoint_count; ++client->next_place) {
        uint32_t endpoint = client->next_place - places_of(config);
        if (config->endpoints[endpoint].kind != XRCE_WRITES && !read(client, endpoint, now))
            return;
    }
    enter(client, XRCE_OPEN, now + config->times.quiet);
}

bool xrce_write(struct xrce_client *client, uint32_t endpoint, const uint8_t *sample, uint32_t count, uint32_t now)
{
    const struct xrce_endpoint *endpoints = client->config->endpoints;
    struct xrce_body *room = xrce_output_room(&client->output), best_effort;
    bool reliable = !endpoints[endpoint].best_effort;
    if (client->state != XRCE_OPEN || (reliable && !room))
        return false;
    if (!reliable)
        room = &best_effort;
    struct cdr_writer out = request_in(room, WRITE_REQUEST, xrce_endpoint_id(endpoints, endpoint));
    cdr_put_octets(&out, sample, count);
    if (reliable)
        return send_request(client, room, &out, WRITE_DATA, 0, now);
    if (!out.bad)
        send(client, client->config->session_id, BEST_EFFORT, client->best_effort_out++, room->bytes,
             with_header(room->bytes, &out, WRITE_DATA, 0));
    return !out.bad;
}

// --- The session

static void seek(struct xrce_client *client, uint32_t now) { enter(client, XRCE_SEEKING, now); }

static void ask(struct xrce_client *client, uint32_t now)
{
    client->tries = 0;
    enter(client, XRCE_ASKING, now);
}

static void begin_streams(struct xrce_client *client)
{
    xrce_output_begin(&client->output);
    xrce_input_begin(&client->input);
    client->best_effort_out = 0;
    client->best_effort_in = 0xFFFF;
    client->owes_acknack = false;
    client->whole_count = 0;
    client->whole_bad = false;
}

static void begin_session(struct xrce_client *client, uint32_t now)
{
    begin_streams(client);
    client->asked = client->confirmed = client->next_place = 0;
    client->heard = client->progressed = now;
    enter(client, XRCE_CREATING, now + client->config->times.quiet);
    go_on(client, now);
}

// Whether an answer is about an object that was asked for.
static bool is_of_create(const struct xrce_client *client, uint32_t place, uint16_t id)
{
    return client->state == XRCE_CREATING && place < places_of(client->config) && client->asked >> place & 1 &&
           id == xrce_object_id(client->config->endpoints, place);
}

static bool is_of_read(const struct xrce_client *client, uint32_t endpoint, uint16_t id)
{
    const struct xrce_config *config = client->config;
    return endpoint < config->endpoint_count && config->endpoints[endpoint].kind != XRCE_WRITES &&
           id == xrce_endpoint_id(config->endpoints, endpoint);
}

// An object that cannot be created, or not be read, ends the session, so that it is tried again from the begin.
static void take_status(struct xrce_client *client, struct cdr_reader *in, uint32_t now)
{
    uint16_t request = cdr_get_id(in), id = cdr_get_id(in);
    bool refused = cdr_get_u8(in) >= ERRORS_FROM;
    uint32_t place = request - FIRST_REQUEST, endpoint = request - READ_REQUEST;
    bool of_create = is_of_create(client, place, id);
    if (in->bad || !(of_create || is_of_read(client, endpoint, id)))
        return;
    if (refused) {
        send_delete_client(client);
        enter(client, XRCE_SEEKING, now + client->config->times.retry);
    } else if (of_create && !(client->confirmed >> place & 1)) {
        client->confirmed |= 1u << place;
        client->progressed = now;
    }
}

static void take_status_agent(struct xrce_client *client, struct cdr_reader *in, uint32_t now)
{
    uint8_t status = cdr_get_u8(in);
    if (!in->bad && client->state == XRCE_ASKING && status < ERRORS_FROM)
        begin_session(client, now);
}

// The implementation's own status says whether there is a session at this line (Processor.cpp, process_get_info_packet).
static void take_info(struct xrce_client *client, uint8_t session, struct cdr_reader *in, uint32_t now)
{
    cdr_get_id(in);
    uint16_t object = cdr_get_id(in);
    cdr_get_u8(in);
    bool known = cdr_get_u8(in);
    if (in->bad || object != OBJECT_AGENT)
        return;
    if (client->state == XRCE_SEEKING)
        ask(client, now);
    else if (in_session(client) && session == client->config->session_id && known)
        note_heard(client, now);
    else if (in_session(client) && session == client->config->session_id)
        ask(client, now);
}

// --- What comes

// Pieces are put together on the reliable stream alone: on another one they would come between.
enum pieces { NO_PIECES, PIECES };

static void take_body(struct xrce_client *client, uint8_t session, const uint8_t *body, uint32_t count, enum pieces pieces,
                      uint32_t now);

static void take_data(struct xrce_client *client, struct cdr_reader *in)
{
    const struct xrce_config *config = client->config;
    cdr_get_id(in);
    uint16_t id = cdr_get_id(in);
    for (uint32_t endpoint = 0; endpoint < config->endpoint_count && !in->bad; ++endpoint)
        if (id == xrce_endpoint_id(config->endpoints, endpoint) && config->endpoints[endpoint].kind != XRCE_WRITES) {
            struct cdr_reader sample = {
                .begin = in->begin + in->at, .count = in->count - in->at, .big_endian = in->big_endian};
            config->heard(config->context, endpoint, &sample);
        }
}

static void take_acknack(struct xrce_client *client, struct cdr_reader *in, uint32_t now)
{
    uint16_t first = cdr_get_u16(in), nacks = cdr_get_id(in), missing;
    if (cdr_get_u8(in) != RELIABLE || in->bad)
        return;
    xrce_output_acknowledged(&client->output, first, nacks, now, &missing);
    for (uint16_t i = 0; i < XRCE_WINDOW; ++i)
        if (missing >> i & 1)
            send_reliable(client, (uint16_t)(first + i));
}

static void take_heartbeat(struct xrce_client *client, struct cdr_reader *in)
{
    uint16_t first = cdr_get_u16(in), last = cdr_get_u16(in);
    if (cdr_get_u8(in) != RELIABLE || in->bad)
        return;
    if (xrce_input_announced(&client->input, first, last))
        client->whole_count = client->whole_bad = 0;
    client->owes_acknack = true;
}

// Submessages in pieces (8.3.5.14); what is longer than there is room for is passed over up to its last piece.
static void take_fragment(struct xrce_client *client, uint8_t session, struct cdr_reader *in, bool last, uint32_t now)
{
    client->whole_bad |= client->whole_count + in->count > sizeof client->whole;
    for (uint32_t i = 0; i < in->count && !client->whole_bad; ++i)
        client->whole[client->whole_count++] = in->begin[i];
    if (!last)
        return;
    uint32_t count = client->whole_bad ? 0 : client->whole_count;
    client->whole_count = 0;
    client->whole_bad = false;
    take_body(client, session, client->whole, count, NO_PIECES, now);
}

static void take_submessage(struct xrce_client *client, uint8_t session, uint8_t id, uint8_t flags, struct cdr_reader *in,
                            enum pieces pieces, uint32_t now)
{
    in->big_endian = !(flags & LITTLE_ENDIAN_FLAG);
    if (id == STATUS_AGENT) {
        take_status_agent(client, in, now);
    } else if (id == INFO) {
        take_info(client, session, in, now);
    } else if (!in_session(client) || session != client->config->session_id) {
        return;
    } else if (id == STATUS) {
        take_status(client, in, now);
    } else if (id == DATA && !(flags & FORMAT_FLAGS)) {
        take_data(client, in);
    } else if (id == ACKNACK) {
        take_acknack(client, in, now);
    } else if (id == HEARTBEAT) {
        take_heartbeat(client, in);
    } else if (id == FRAGMENT && pieces == PIECES) {
        take_fragment(client, session, in, flags & LAST_FLAG, now);
    } else if (id == RESET) {
        ask(client, now); // what was on its way is lost, objects among it
    }
}

// Each submessage begins at a multiple of 4 (8.3.4); DATA of length 0 is all the rest, as the agent sends what is longer than
// the length can say.
static void take_body(struct xrce_client *client, uint8_t session, const uint8_t *body, uint32_t count, enum pieces pieces,
                      uint32_t now)
{
    for (uint32_t at = 0; at + HEADER <= count;) {
        uint8_t id = body[at], flags = body[at + 1];
        uint32_t length = body[at + 2] | (uint32_t)body[at + 3] << 8;
        at += HEADER;
        if (id == DATA && length == 0)
            length = count - at;
        if (at + length > count)
            return;
        struct cdr_reader in = {.begin = body + at, .count = length};
        take_submessage(client, session, id, flags, &in, pieces, now);
        at += (length + 3) / 4 * 4;
    }
}

static void take_reliable(struct xrce_client *client, uint16_t number, const uint8_t *body, uint32_t count)
{
    xrce_input_take(&client->input, number, body, count);
    client->owes_acknack = true;
}

// What is next in order, because it came, or because a HEARTBEAT says that what is missing before it will not come.
static void take_in_order(struct xrce_client *client, uint32_t now)
{
    const struct xrce_body *next;
    while (in_session(client) && (next = xrce_input_next(&client->input)))
        take_body(client, client->config->session_id, next->bytes, next->count, PIECES, now);
    if (in_session(client) && client->owes_acknack)
        send_acknack(client);
    client->owes_acknack = false;
}

static bool is_newer(uint16_t number, uint16_t than) { return (int16_t)(uint16_t)(number - than) > 0; }

static void take_message(struct xrce_client *client, const uint8_t *message, uint32_t count, uint32_t now)
{
    if (count < HEADER)
        return;
    uint8_t session = message[0], stream = message[1];
    uint16_t number = (uint16_t)(message[2] | message[3] << 8);
    const uint8_t *body = message + HEADER;
    count -= HEADER;
    if (session != client->config->session_id && session != NO_SESSION)
        return;
    bool ours = in_session(client) && session == client->config->session_id;
    if (stream == NO_STREAM) {
        if (ours && count && body[0] != INFO) // which says itself whether there is a session
            note_heard(client, now);
        take_body(client, session, body, count, NO_PIECES, now);
    } else if (!ours) {
        return;
    } else if (stream >= RELIABLE) {
        note_heard(client, now);
        if (stream == RELIABLE)
            take_reliable(client, number, body, count);
    } else if (stream == BEST_EFFORT && is_newer(number, client->best_effort_in)) {
        note_heard(client, now);
        client->best_effort_in = number;
        take_body(client, session, body, count, NO_PIECES, now);
    }
}

void xrce_receive(struct xrce_client *client, uint8_t byte, uint32_t now)
{
    const uint8_t *payload;
    uint32_t count = xrce_frame_take(&client->reader, byte, &payload);
    if (!count)
        return;
    take_message(client, payload, count, now);
    take_in_order(client, now);
    go_on(client, now);
}

// --- Time

bool xrce_begin(struct xrce_client *client, const struct xrce_config *config, uint32_t now)
{
    if (config->endpoint_count > XRCE_MOST_ENDPOINTS)
        return false;
    client->config = config;
    client->reader.in_frame = 0;
    begin_streams(client);
    seek(client, now);
    return true;
}

void xrce_end(struct xrce_client *client, uint32_t now)
{
    if (in_session(client))
        send_delete_client(client);
    seek(client, now);
}

// Whether nothing will come of the session any more.
static bool is_lost(const struct xrce_client *client, uint32_t now)
{
    uint32_t most = client->config->times.lost;
    if (now - client->heard >= most || (client->output.count && now - client->output.since >= most))
        return true;
    return client->state == XRCE_CREATING && now - client->progressed >= most;
}

static void watch(struct xrce_client *client, uint32_t now)
{
    const struct xrce_times *times = &client->config->times;
    if (is_lost(client, now)) {
        seek(client, now);
        return;
    }
    if (xrce_output_beat(&client->output, now))
        send_heartbeat(client);
    if (due(client->due, now)) {
        client->due = now + times->quiet;
        send_ping(client, client->config->session_id);
    }
}

static uint32_t until(uint32_t when, uint32_t now) { return due(when, now) ? 0 : when - now; }

static uint32_t sooner(uint32_t one, uint32_t other) { return one < other ? one : other; }

static uint32_t wait_of(const struct xrce_client *client, uint32_t now)
{
    uint32_t wait = until(client->due, now);
    if (!in_session(client))
        return wait;
    wait = sooner(wait, until(client->heard + client->config->times.lost, now));
    return client->output.count ? sooner(wait, until(client->output.due, now)) : wait;
}

uint32_t xrce_advance(struct xrce_client *client, uint32_t now)
{
    const struct xrce_times *times = &client->config->times;
    if (in_session(client))
        watch(client, now);
    if (client->state == XRCE_ASKING && due(client->due, now)) {
        if (client->tries++ == TRIES) {
            seek(client, now);
        } else {
            client->due = now + times->retry;
            send_create_client(client);
        }
    }
    if (client->state == XRCE_SEEKING && due(client->due, now)) {
        client->due = now + times->ping;
        send_ping(client, NO_SESSION);
    }
    return wait_of(client, now);
}
