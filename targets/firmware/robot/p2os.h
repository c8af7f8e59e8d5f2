// SPDX-License-Identifier: GPL-2.0-or-later
//
// A client of P2OS, the controller of Pioneer robots, for a program without an operating system: bytes and milliseconds
// in, bytes out. (Pioneer 2 / PeopleBot Operations Manual, client-server chapter.)

#pragma once

#include <stdbool.h>
#include <stdint.h>

#define P2OS_SONARS 16
#define P2OS_FAR_MM 5000u

enum p2os_state { P2OS_SYNC0, P2OS_SYNC1, P2OS_SYNC2, P2OS_OPEN, P2OS_CLOSING };

struct p2os {
    void (*send)(const uint8_t *data, uint32_t count);
    enum p2os_state state;
    uint32_t asked_ms;              // when the last CLOSE, SYNC or PULSE went out
    uint32_t opened_ms;             // when the session began
    uint32_t heard_ms;              // when the last good packet came
    uint8_t frame[3 + 255];         // what has come of the present packet
    uint32_t have;
    bool motors_on;                 // as it stands in the SIP
    uint32_t sonars_heard;          // bit n: sonar n was heard in this session; without it the two below say nothing
    uint16_t sonar_mm[P2OS_SONARS];
    uint32_t sonar_ms[P2OS_SONARS]; // when each was heard last
    int16_t speed, turn;            // as sent last
    uint32_t told_ms;
};

// Begins: a session that the robot may still be in is closed, then a new one is asked for.
void p2os_start(struct p2os *p2os, void (*send)(const uint8_t *data, uint32_t count), uint32_t now_ms);

// Takes one byte from the line.
void p2os_take(struct p2os *p2os, uint8_t byte, uint32_t now_ms);

// Does what is due: asks again, keeps the session alive, gives it up if the robot is silent.
void p2os_poll(struct p2os *p2os, uint32_t now_ms);

// Has the robot drive at a speed in mm/s and turn at a rate in degrees a second; sent when it changes, and now and then.
void p2os_drive(struct p2os *p2os, int16_t speed, int16_t turn, uint32_t now_ms);
