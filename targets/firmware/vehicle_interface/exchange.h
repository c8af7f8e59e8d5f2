// SPDX-License-Identifier: GPL-2.0-or-later
//
// What the two tasks and the interrupts share.

#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "vehicle_interface/kernel/kernel.h"

// The values go over both lines.
enum mode { MODE_EMERGENCY = 0, MODE_AUTOWARE = 1, MODE_MANUAL = 4 };

// What the simulator is told. In MODE_MANUAL `steering` is -1 to 1, `speed` the throttle and `acceleration` the brake, 0 to 1.
struct action {
    float steering;      // rad, to the left, times STEERING_FACTOR
    float steering_rate; // rad/s, likewise
    float speed;         // m/s
    float acceleration;  // m/s^2
    float jerk;          // m/s^3
    uint8_t mode;
};

// What the simulator says of the car.
struct status {
    float longitudinal; // m/s
    float lateral;      // m/s, to the left
    float heading_rate; // rad/s, to the left
    float steering;     // rad, to the left
};

struct exchange {
    struct action action; // what the driving stack wants; whoever touches it or the status holds the kernel's lock
    struct status status; // what the driving stack is told next
    enum mode mode;       // what the control task is in
    bool agent_online;    // the driving stack is there
    uint32_t status_tick; // when the latest status came
};

extern struct exchange exchange;

// Between the tasks, numbered as in the original's V1.
extern struct events events;

#define STACK_TO_AUTOWARE (1u << 1) // the driving stack's task has to take another mode over
#define STACK_TO_MANUAL (1u << 2)
#define STACK_TO_EMERGENCY (1u << 3)
#define CONTROL_TO_AUTOWARE (1u << 4) // the control task has to change its mode
#define CONTROL_TO_MANUAL (1u << 5)
#define NEW_STATUS (1u << 7)
#define NEW_ACTION (1u << 8)
#define AGENT_IS_ONLINE (1u << 9)
#define STACK_WAKE (1u << 10) // there is something to do for the driving stack's task (ours: the original polls)

// From interrupts to the control task: flags of its own, one of which has the number of STACK_TO_AUTOWARE.
extern struct events board_events;

#define BOARD_SWITCH (1u << 0)
#define BOARD_STATUS (1u << 1)
