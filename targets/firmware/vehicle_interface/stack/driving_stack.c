// SPDX-License-Identifier: GPL-2.0-or-later

#include "vehicle_interface/stack/driving_stack.h"

#include "vehicle_interface/board/stack_line.h"
#include "vehicle_interface/board/watchdog.h"
#include "vehicle_interface/exchange.h"
#include "vehicle_interface/numbers.h"
#include "vehicle_interface/options.h"
#include "vehicle_interface/stack/frames.h"
#include "vehicle_interface/stack/lamps.h"
#include "vehicle_interface/stack/messages.h"

#define REPORT_NOT_READY 6 // of ControlModeReport; the others are modes

static bool seeking = true;
static uint32_t pings, next_ping, heard_tick, next_report;
static struct frame_reader reader;
static struct stamp now;              // the latest clock
static uint8_t told = MODE_AUTOWARE; // the mode that is reported, and by which commands are handed on

void stack_line_silent(void) { events_set(&events, STACK_WAKE); }

// --- Sending

static void send(const struct board_message *message)
{
    uint8_t frame[MAX_FRAME];
    stack_line_send(frame, frame_make(frame, (const uint8_t *)message, message_bytes(message->id)));
}

static void report(enum message_id id, uint8_t value)
{
    send(&(struct board_message){.id = id, .report = {now, value}});
}

static void report_mode(uint32_t tick)
{
    report(MODE_REPORT, told);
    next_report = tick + REPORT_TICKS;
}

static void report_status(void)
{
    kernel_lock();
    struct status status = exchange.status;
    kernel_unlock();
    send(&(struct board_message){.id = VELOCITY_REPORT,
                                 .velocity = {now, status.longitudinal, status.lateral, status.heading_rate}});
    send(&(struct board_message){.id = STEERING_REPORT, .steering = {now, status.steering}});
    if (DEFECT_NO_LAMPS)
        return;
    report(TURN_REPORT, lamps_turn_report());
    report(HAZARD_REPORT, lamps_hazard_report());
}

// --- What the agent says

// The numbers as they go to the simulator.
static struct action action_of(const struct agent_message *message)
{
    return (struct action){
        .steering = (float)(message->control.tire_angle * STEERING_FACTOR),
        .steering_rate = (float)(message->control.tire_rotation_rate * STEERING_FACTOR),
        .speed = message->control.speed,
        .acceleration = message->control.acceleration,
        .jerk = message->control.jerk,
        .mode = MODE_AUTOWARE,
    };
}

static bool plausible(const struct action *action)
{
    return within(action->steering, 2.5f) && within(action->steering_rate, 50.0f) && within(action->speed, 150.0f) &&
           within(action->acceleration, 100.0f) && within(action->jerk, 1000.0f);
}

static void take_control(const struct agent_message *message)
{
    struct action action = action_of(message);
    if ((OWN_MODE ? told : exchange.mode) != MODE_AUTOWARE || !(DEFECT_H1 || plausible(&action)))
        return;
    kernel_lock();
    exchange.action = action;
    kernel_unlock();
    events_set(&events, NEW_ACTION);
}

// Both tasks are told, as in the original.
static bool order(uint8_t mode)
{
    if (!DEFECT_EMERGENCY_REQUESTS && exchange.mode == MODE_EMERGENCY)
        return false;
    if (mode == MODE_AUTOWARE) {
        events_set(&events, STACK_TO_AUTOWARE);
        events_set(&events, CONTROL_TO_AUTOWARE);
    } else if (mode == MODE_MANUAL) {
        events_set(&events, STACK_TO_MANUAL);
        events_set(&events, CONTROL_TO_MANUAL);
    }
    return mode == MODE_AUTOWARE || mode == MODE_MANUAL;
}

static void take_request(const struct agent_message *message)
{
    bool success = order(message->request.mode);
    send(&(struct board_message){.id = MODE_RESPONSE, .response = {message->request.sequence, success}});
}

static void take_message(const struct agent_message *message)
{
    switch (message->id) {
    case AGENT_ONLINE:
        seeking = false;
        break;
    case CLOCK:
        now = message->clock;
        break;
    case CONTROL_COMMAND:
        take_control(message);
        break;
    case MODE_REQUEST:
        take_request(message);
        break;
    case TURN_COMMAND:
        if (!DEFECT_NO_LAMPS)
            lamps_turn(message->lights.command, kernel_tick());
        break;
    case HAZARD_COMMAND:
        if (!DEFECT_NO_LAMPS)
            lamps_hazard(message->lights.command, kernel_tick());
        break;
    default:
        break;
    }
}

// Any sound frame is a sign of life. Without H9 it may come late, or again.
static bool hear(uint32_t tick)
{
    if (!exchange.agent_online && DEFECT_H9 && tick >= AGENT_TICKS)
        return false;
    heard_tick = tick;
    if (!exchange.agent_online) {
        exchange.agent_online = true;
        events_set(&events, AGENT_IS_ONLINE);
        report_mode(tick);
    }
    return true;
}

static void take_all(uint32_t tick)
{
    uint8_t byte;
    const uint8_t *payload;
    while (stack_line_get(&byte)) {
        uint32_t count = frame_take(&reader, byte, &payload);
        if (count && count == message_bytes(payload[0]) && hear(tick))
            take_message((const struct agent_message *)payload);
    }
}

// --- Whether it is there

static bool due(uint32_t when, uint32_t tick) { return (int32_t)(tick - when) >= 0; }

static void seek(uint32_t tick)
{
    seeking = seeking && pings < AGENT_PINGS;
    if (!seeking || !due(next_ping, tick))
        return;
    ++pings;
    next_ping += AGENT_PING_TICKS;
    send(&(struct board_message){.id = AGENT_PING});
}

static void miss(uint32_t tick)
{
    if (!DEFECT_H9 && tick - heard_tick >= AGENT_SILENCE_TICKS)
        exchange.agent_online = false;
}

// --- The mode

static uint8_t mode_of_flags(void)
{
    uint32_t flags = STACK_TO_AUTOWARE | STACK_TO_MANUAL | (DEFECT_EMERGENCY_KEPT ? 0 : STACK_TO_EMERGENCY);
    uint32_t set = events_wait(&events, flags, EVENTS_ANY, 0);
    if (set & STACK_TO_AUTOWARE)
        return MODE_AUTOWARE;
    if (set & STACK_TO_MANUAL)
        return MODE_MANUAL;
    return set ? MODE_EMERGENCY : told;
}

static void take_mode(uint32_t tick)
{
    uint8_t mode = OWN_MODE ? mode_of_flags() : (uint8_t)exchange.mode;
    if (mode == MODE_EMERGENCY)
        mode = DEFECT_EMERGENCY_MANUAL ? MODE_MANUAL : REPORT_NOT_READY;
    if (mode != told)
        next_report = tick;
    told = mode;
}

// --- The loop

static uint32_t sooner(uint32_t one, uint32_t other) { return one < other ? one : other; }

// Returns after how many ticks the next one is due, even if nobody wakes it.
static uint32_t turn(uint32_t tick)
{
    take_mode(tick);
    take_all(tick);
    take_mode(tick);
    seek(tick);
    miss(tick);
    if (events_wait(&events, NEW_STATUS, EVENTS_ANY, 0) && exchange.agent_online)
        report_status();
    if (exchange.agent_online && due(next_report, tick))
        report_mode(tick);
    uint32_t wait = sooner(ALIVE_TICKS, lamps_update(tick));
    if (exchange.agent_online)
        wait = sooner(wait, next_report - tick);
    return seeking ? sooner(wait, next_ping - tick) : wait;
}

void driving_stack_task(void)
{
    for (;;) {
        watchdog_alive(ALIVE_STACK);
        uint32_t wait = turn(kernel_tick());
        events_wait(&events, STACK_WAKE, EVENTS_ANY, wait);
    }
}
