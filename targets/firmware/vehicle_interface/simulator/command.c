// SPDX-License-Identifier: GPL-2.0-or-later

#include "vehicle_interface/simulator/command.h"

struct __attribute__((packed)) field {
    char letter;
    float value;
};

struct __attribute__((packed)) command {
    char start;
    struct field steering, steering_rate, speed, acceleration, jerk;
    char mode_letter;
    uint8_t mode;
    char end;
    char terminator; // of a C string, and sent with it
};

_Static_assert(sizeof(struct command) == COMMAND_BYTES, "a command has 29 bytes and a NUL");

void command_make(uint8_t frame[COMMAND_BYTES], const struct action *action)
{
    *(struct command *)frame = (struct command){
        .start = '#',
        .steering = {'S', action->steering},
        .steering_rate = {'W', action->steering_rate},
        .speed = {'V', action->speed},
        .acceleration = {'A', action->acceleration},
        .jerk = {'J', action->jerk},
        .mode_letter = 'M',
        .mode = action->mode,
        .end = '$',
    };
}
