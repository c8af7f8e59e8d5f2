// SPDX-License-Identifier: GPL-2.0-or-later
//
// In each turn a request of the driving stack comes first, then a press of the joystick, then the blocks AUTOWARE, MANUAL and
// EMERGENCY: a mode that an earlier block has chosen is acted on in the same turn (V0, V1 StartTaskControl).

#include "vehicle_interface/control/control.h"

#include "vehicle_interface/board/joystick.h"
#include "vehicle_interface/board/lights.h"
#include "vehicle_interface/board/simulator_line.h"
#include "vehicle_interface/board/watchdog.h"
#include "vehicle_interface/control/inputs.h"
#include "vehicle_interface/control/stick.h"
#include "vehicle_interface/exchange.h"
#include "vehicle_interface/options.h"
#include "vehicle_interface/simulator/command.h"

static enum mode mode;
static uint32_t command_misses, status_misses;
static struct action sent; // last
static bool sent_any;

// --- Modes

static void take_over(enum mode next)
{
    if (next != mode && !DEFECT_H6)
        events_wait(&events, NEW_ACTION, EVENTS_ANY, 0); // meant for the mode before
    mode = exchange.mode = next;
}

// As far as the driving stack's task does not know already.
static void enter(enum mode next)
{
    static const uint32_t TELL[] = {
        [MODE_EMERGENCY] = STACK_TO_EMERGENCY, [MODE_AUTOWARE] = STACK_TO_AUTOWARE, [MODE_MANUAL] = STACK_TO_MANUAL};
    take_over(next);
    events_set(&events, TELL[next]);
    events_set(&events, STACK_WAKE);
}

static void show_mode(void)
{
    light_put(LIGHT_AUTOWARE, mode == MODE_AUTOWARE);
    light_put(LIGHT_MANUAL, mode == MODE_MANUAL);
    light_put(LIGHT_EMERGENCY, mode == MODE_EMERGENCY);
}

static void take_request(void)
{
    uint32_t asked = events_wait(&events, CONTROL_TO_AUTOWARE | CONTROL_TO_MANUAL, EVENTS_ANY, 0);
    if (asked == 0 || (mode == MODE_EMERGENCY && !DEFECT_EMERGENCY_REQUESTS))
        return;
    bool autoware = DEFECT_BOTH_AUTOWARE ? asked & CONTROL_TO_AUTOWARE : !(asked & CONTROL_TO_MANUAL);
    take_over(autoware ? MODE_AUTOWARE : MODE_MANUAL);
    events_set(&events, STACK_WAKE);
}

// In EMERGENCY a press is used up and does nothing.
static void take_press(void)
{
    if (!events_wait(&board_events, BOARD_SWITCH, EVENTS_ANY, 0))
        return;
    if (mode == MODE_AUTOWARE)
        enter(MODE_MANUAL);
    else if (mode == MODE_MANUAL && (DEFECT_H9 || exchange.agent_online))
        enter(MODE_AUTOWARE);
}

// --- What is sent

static void send_again(void)
{
    uint8_t frame[COMMAND_BYTES];
    command_make(frame, &sent);
    simulator_line_send(frame);
}

static void send(const struct action *action)
{
    sent = *action;
    sent_any = true;
    send_again();
}

static void send_command(void)
{
    kernel_lock();
    struct action action = exchange.action;
    kernel_unlock();
    send(&action);
}

// In the original there is one structure for all: what the driving stack has put there is overwritten.
static void send_own(struct action action)
{
    if (DEFECT_H6) {
        kernel_lock();
        exchange.action = action;
        kernel_unlock();
    }
    send(&action);
}

// What a buffer on the stack holds that nobody has filled; choice: what FreeRTOS fills stacks with.
static void send_uninitialised(void)
{
    uint8_t frame[COMMAND_BYTES];
    for (uint32_t i = 0; i < COMMAND_BYTES; ++i)
        frame[i] = 0xA5;
    simulator_line_send(frame);
}

// Instead of a command that is missing: stop, without turning the wheel.
static void send_for_missing(void)
{
    if (!sent_any) {
        if (DEFECT_H8)
            send_uninitialised();
    } else if (DEFECT_H7) {
        send_again();
    } else {
        send(&(struct action){.steering = sent.mode == MODE_AUTOWARE ? sent.steering : 0.0f, .mode = MODE_AUTOWARE});
    }
}

// --- Statuses of the simulator

// One that has waited for longer than it would have been waited for is no answer any more.
static bool wait_status(struct events *from)
{
    if (!DEFECT_UNWATCHED && kernel_tick() - exchange.status_tick > STATUS_TICKS)
        events_wait(&board_events, BOARD_STATUS, EVENTS_ANY, 0);
    return events_wait(from, BOARD_STATUS, EVENTS_ANY, STATUS_TICKS);
}

static void report_status(void)
{
    events_set(&events, NEW_STATUS);
    events_set(&events, STACK_WAKE);
}

// Returns whether as many were missed in a row as may be.
static bool count_status(bool came)
{
    if (came) {
        status_misses = 0;
        kernel_lock();
        exchange.status = status_received();
        kernel_unlock();
        report_status();
    } else if (++status_misses >= MISSES) {
        status_misses = 0;
        return true;
    }
    return false;
}

// The same behind a command that was sent.
static bool status_lost(bool came)
{
    bool lost = count_status(came);
    if (DEFECT_STALE_STATUS && !came && !lost)
        report_status();
    return lost;
}

// --- The blocks

static void miss_command(void)
{
    bool lost = !DEFECT_UNWATCHED && count_status(events_wait(&board_events, BOARD_STATUS, EVENTS_ANY, 0));
    if (++command_misses >= MISSES) {
        command_misses = 0;
        enter(lost ? MODE_EMERGENCY : MODE_MANUAL);
    } else if (lost) {
        enter(MODE_EMERGENCY);
    } else {
        send_for_missing();
    }
}

static void autoware(void)
{
    show_mode();
    if (!events_wait(&events, NEW_ACTION, EVENTS_ANY, COMMAND_TICKS)) {
        miss_command();
        return;
    }
    command_misses = 0;
    send_command();
    if (status_lost(wait_status(&board_events)))
        enter(MODE_EMERGENCY);
}

static void manual(void)
{
    show_mode();
    send_own(stick_action(joystick_x(), joystick_y()));
    if (status_lost(wait_status(DEFECT_FLAG_CLASH ? &events : &board_events)))
        enter(MODE_EMERGENCY);
    watchdog_alive(ALIVE_CONTROL);
    task_delay(MANUAL_TICKS);
}

static void emergency(void)
{
    show_mode();
    send_own((struct action){.mode = MODE_EMERGENCY});
    if (!wait_status(&board_events))
        return;
    command_misses = status_misses = 0;
    enter(MODE_MANUAL);
}

// --- The task

// In steps, so that the watchdog is fed.
static bool wait_for_agent(void)
{
    for (uint32_t waited = 0; waited < AGENT_TICKS; waited += STATUS_TICKS) {
        watchdog_alive(ALIVE_CONTROL);
        if (events_wait(&events, AGENT_IS_ONLINE, EVENTS_ANY, STATUS_TICKS))
            return true;
    }
    return false;
}

void control_task(void)
{
    mode = MODE_AUTOWARE;
    if (!wait_for_agent())
        take_over(MODE_MANUAL);
    for (;;) {
        watchdog_alive(ALIVE_CONTROL);
        take_request();
        take_press();
        if (!DEFECT_H9 && !exchange.agent_online && mode == MODE_AUTOWARE)
            enter(MODE_MANUAL);
        if (mode == MODE_AUTOWARE)
            autoware();
        if (mode == MODE_MANUAL)
            manual();
        if (mode == MODE_EMERGENCY)
            emergency();
    }
}
