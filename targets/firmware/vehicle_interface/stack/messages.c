// SPDX-License-Identifier: GPL-2.0-or-later

#include "vehicle_interface/stack/messages.h"

#define BODY(type, member) (1 + sizeof(((struct type *)0)->member))

uint32_t message_bytes(uint8_t id)
{
    switch (id) {
    case AGENT_ONLINE:
    case AGENT_PING:
        return 1;
    case CLOCK:
        return BODY(agent_message, clock);
    case CONTROL_COMMAND:
        return BODY(agent_message, control);
    case MODE_REQUEST:
        return BODY(agent_message, request);
    case TURN_COMMAND:
    case HAZARD_COMMAND:
        return BODY(agent_message, lights);
    case MODE_REPORT:
    case TURN_REPORT:
    case HAZARD_REPORT:
        return BODY(board_message, report);
    case MODE_RESPONSE:
        return BODY(board_message, response);
    case VELOCITY_REPORT:
        return BODY(board_message, velocity);
    case STEERING_REPORT:
        return BODY(board_message, steering);
    default:
        return 0;
    }
}

_Static_assert(sizeof(struct agent_message) == 29, "the control command is the longest");
_Static_assert(sizeof(struct board_message) == 21, "the velocity report is the longest");
