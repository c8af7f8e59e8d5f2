// SPDX-License-Identifier: GPL-2.0-or-later

#include "vehicle_interface/stack/micro_ros.h"

#include "vehicle_interface/kernel/kernel.h"
#include "vehicle_interface/options.h"
#include "vehicle_interface/stack/messages.h"
#include "xrce/client.h"

#undef stack_line_get // here it is the line's

#define SEEK_TICKS 100u  // between pings once AGENT_PINGS of them were not answered (choice: the original gives up)
#define QUIET_TICKS 500u // of silence, after which the agent is asked whether it has the session still (choice)

#define CONTROL(name) "autoware_auto_control_msgs::msg::dds_::" name "_"
#define VEHICLE(name) "autoware_auto_vehicle_msgs::msg::dds_::" name "_"
#define SERVICE(name) "autoware_auto_vehicle_msgs::srv::dds_::" name "_"

enum { MODE, VELOCITY, STEERING, TIME, COMMANDS, MODES, TURN, HAZARD, TURNS, HAZARDS };

// The lamps' are the last, so that an image without them can leave them out.
static const struct xrce_endpoint ENDPOINTS[] = {
    [MODE] = {XRCE_WRITES, .topic = "rt/vehicle/status/control_mode", .type = VEHICLE("ControlModeReport")},
    [VELOCITY] = {XRCE_WRITES, .topic = "rt/vehicle/status/velocity_status", .type = VEHICLE("VelocityReport")},
    [STEERING] = {XRCE_WRITES, .topic = "rt/vehicle/status/steering_status", .type = VEHICLE("SteeringReport")},
    [TIME] = {XRCE_READS, .topic = "rt/clock", .type = "rosgraph_msgs::msg::dds_::Clock_"},
    [COMMANDS] = {XRCE_READS, .topic = "rt/control/command/control_cmd", .type = CONTROL("AckermannControlCommand")},
    [MODES] = {XRCE_SERVES,
               .service = "control/control_mode_request",
               .topic = "rq/control/control_mode_requestRequest",
               .type = SERVICE("ControlModeCommand_Request"),
               .reply_topic = "rr/control/control_mode_requestReply",
               .reply_type = SERVICE("ControlModeCommand_Response")},
    [TURN] = {XRCE_WRITES, .topic = "rt/vehicle/status/turn_indicators_status", .type = VEHICLE("TurnIndicatorsReport")},
    [HAZARD] = {XRCE_WRITES, .topic = "rt/vehicle/status/hazard_lights_status", .type = VEHICLE("HazardLightsReport")},
    [TURNS] = {XRCE_READS, .topic = "rt/control/command/turn_indicators_cmd", .type = VEHICLE("TurnIndicatorsCommand")},
    [HAZARDS] = {XRCE_READS, .topic = "rt/control/command/hazard_lights_cmd", .type = VEHICLE("HazardLightsCommand")},
};

_Static_assert(sizeof ENDPOINTS / sizeof *ENDPOINTS <= XRCE_MOST_ENDPOINTS, "the client has no bit for the last ones");

#define MOST_SAMPLE 64u // bytes of what is written
#define MOST_REPLIES 4u // that wait for room; a power of two

struct sample {
    uint8_t bytes[MOST_SAMPLE];
    uint32_t count;
};

static struct xrce_client client;

// What could not be sent yet: the newest mode, and replies. The other reports are worth nothing later.
static struct sample mode, replies[MOST_REPLIES];
static uint32_t replies_put, replies_got;

// --- What comes, as messages that wait to be fetched

#define MOST_WAITING 32u // a power of two

struct heard {
    struct agent_message message;
    uint8_t requester[XRCE_IDENTITY]; // of a request: who asks
};

static struct heard waiting[MOST_WAITING], fetched; // each request is answered before the next message is fetched
static uint32_t put, got;

static void wait(const struct heard *heard)
{
    if (put - got < MOST_WAITING)
        waiting[put++ % MOST_WAITING] = *heard;
}

static struct stamp stamp_in(struct cdr_reader *in)
{
    int32_t sec = (int32_t)cdr_get_u32(in);
    return (struct stamp){sec, cdr_get_u32(in)};
}

static void read_control(struct cdr_reader *in, struct agent_message *message)
{
    message->id = CONTROL_COMMAND;
    message->control.stamp = stamp_in(in);
    stamp_in(in); // of the lateral half
    message->control.tire_angle = cdr_get_float(in);
    message->control.tire_rotation_rate = cdr_get_float(in);
    stamp_in(in); // of the longitudinal one
    message->control.speed = cdr_get_float(in);
    message->control.acceleration = cdr_get_float(in);
    message->control.jerk = cdr_get_float(in);
}

static void read_request(struct cdr_reader *in, struct heard *heard)
{
    for (uint32_t i = 0; i < XRCE_IDENTITY; ++i)
        heard->requester[i] = cdr_get_u8(in);
    heard->message.id = MODE_REQUEST;
    heard->message.request.stamp = stamp_in(in);
    heard->message.request.mode = cdr_get_u8(in);
}

static void read_lights(struct cdr_reader *in, struct agent_message *message, enum message_id id)
{
    message->id = (uint8_t)id;
    message->lights.stamp = stamp_in(in);
    message->lights.command = cdr_get_u8(in);
}

static void hear(void *context, uint32_t endpoint, struct cdr_reader *in)
{
    (void)context;
    struct heard heard = {.message = {.id = CLOCK}};
    if (endpoint == TIME)
        heard.message.clock = stamp_in(in);
    else if (endpoint == COMMANDS)
        read_control(in, &heard.message);
    else if (endpoint == MODES)
        read_request(in, &heard);
    else
        read_lights(in, &heard.message, endpoint == TURNS ? TURN_COMMAND : HAZARD_COMMAND);
    if (!in->bad)
        wait(&heard);
}

// --- What goes

static void put_stamp(struct cdr_writer *out, const struct stamp *stamp)
{
    cdr_put_u32(out, (uint32_t)stamp->sec);
    cdr_put_u32(out, stamp->nanosec);
}

static void put_velocity(struct cdr_writer *out, const struct board_message *message)
{
    put_stamp(out, &message->velocity.stamp);
    cdr_put_text(out, "base_link");
    cdr_put_float(out, message->velocity.longitudinal);
    cdr_put_float(out, message->velocity.lateral);
    cdr_put_float(out, message->velocity.heading_rate);
}

// Returns the endpoint that a message is written at.
static uint32_t write_to(struct cdr_writer *out, const struct board_message *message)
{
    switch (message->id) {
    case MODE_RESPONSE:
        cdr_put_octets(out, fetched.requester, sizeof fetched.requester);
        cdr_put_u8(out, message->response.success);
        return MODES;
    case VELOCITY_REPORT:
        put_velocity(out, message);
        return VELOCITY;
    case STEERING_REPORT:
        put_stamp(out, &message->steering.stamp);
        cdr_put_float(out, message->steering.tire_angle);
        return STEERING;
    default:
        put_stamp(out, &message->report.stamp);
        cdr_put_u8(out, message->report.value);
        return message->id == MODE_REPORT ? MODE : message->id == TURN_REPORT ? TURN : HAZARD;
    }
}

static bool send_sample(uint32_t endpoint, const struct sample *sample)
{
    return xrce_write(&client, endpoint, sample->bytes, sample->count, kernel_tick());
}

static void send_kept(void)
{
    while (replies_got != replies_put && send_sample(MODES, &replies[replies_got % MOST_REPLIES]))
        ++replies_got;
    if (mode.count && send_sample(MODE, &mode))
        mode.count = 0;
}

static void send_frame(void *context, const uint8_t *frame, uint32_t count)
{
    (void)context;
    stack_line_send(frame, count);
}

// --- The session

static void change(void *context, enum xrce_state state)
{
    (void)context;
    if (state == XRCE_OPEN)
        wait(&(struct heard){.message = {.id = AGENT_ONLINE}});
}

static struct xrce_config config = {
    .key = {0x48, 0x42, 0x76, 0x69},
    .session_id = 0x81,
    .times = {.ping = AGENT_PING_TICKS, .retry = AGENT_PING_TICKS, .quiet = QUIET_TICKS, .lost = AGENT_SILENCE_TICKS},
    .endpoints = ENDPOINTS,
    .endpoint_count = DEFECT_NO_LAMPS ? TURN : sizeof ENDPOINTS / sizeof *ENDPOINTS,
    .send = send_frame,
    .heard = hear,
    .changed = change,
};

// With H9 an agent that is lost, or was not there in time, is not looked for again.
static bool has_given_up(uint32_t tick)
{
    static bool opened;
    opened |= client.state == XRCE_OPEN;
    return DEFECT_H9 && client.state == XRCE_SEEKING && (opened || tick >= AGENT_TICKS);
}

bool micro_ros_get(uint8_t *byte)
{
    uint32_t tick = kernel_tick();
    if (!client.config)
        xrce_begin(&client, &config, tick);
    if (has_given_up(tick))
        return false;
    if (tick >= AGENT_TICKS)
        config.times.ping = SEEK_TICKS;
    while (put == got && stack_line_get(byte))
        xrce_receive(&client, *byte, tick);
    xrce_advance(&client, tick);
    send_kept();
    return put != got;
}

uint32_t micro_ros_take(struct frame_reader *reader, uint8_t byte, const uint8_t **payload)
{
    (void)reader, (void)byte;
    fetched = waiting[got++ % MOST_WAITING];
    *payload = (const uint8_t *)&fetched.message;
    return message_bytes(fetched.message.id);
}

uint32_t micro_ros_make(uint8_t frame[MAX_FRAME], const uint8_t *payload, uint32_t count)
{
    (void)frame, (void)count;
    const struct board_message *message = (const struct board_message *)payload;
    struct sample sample;
    struct cdr_writer out = {.begin = sample.bytes, .most = sizeof sample.bytes};
    if (message->id == AGENT_PING) // the client has pings of its own
        return 0;
    uint32_t endpoint = write_to(&out, message);
    sample.count = out.count;
    if (endpoint == MODE)
        mode = sample;
    else if (endpoint != MODES)
        send_sample(endpoint, &sample);
    else if (replies_put - replies_got < MOST_REPLIES)
        replies[replies_put++ % MOST_REPLIES] = sample;
    send_kept();
    return 0;
}
