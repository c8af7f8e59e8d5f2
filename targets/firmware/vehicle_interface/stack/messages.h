// SPDX-License-Identifier: GPL-2.0-or-later
//
// The driving stack's messages as they lie in a payload: an id, then little-endian fields without gaps
// (docs/autoware/messages.md). Their types are those of autoware_auto_msgs; ids are a choice.

#pragma once

#include <stdint.h>

enum message_id {
    AGENT_ONLINE = 0x01,
    CLOCK = 0x02,
    CONTROL_COMMAND = 0x03,
    MODE_REQUEST = 0x04,
    TURN_COMMAND = 0x05,
    HAZARD_COMMAND = 0x06,
    AGENT_PING = 0x81,
    MODE_REPORT = 0x83,
    MODE_RESPONSE = 0x84,
    TURN_REPORT = 0x85,
    HAZARD_REPORT = 0x86,
    VELOCITY_REPORT = 0x87,
    STEERING_REPORT = 0x88,
};

// The core is little-endian and takes words at any address, so that a payload can be read where it lies.
struct __attribute__((packed)) stamp {
    int32_t sec;
    uint32_t nanosec;
};

struct __attribute__((packed)) agent_message {
    uint8_t id;
    union __attribute__((packed)) {
        struct stamp clock;
        struct __attribute__((packed)) {
            struct stamp stamp;
            float tire_angle, tire_rotation_rate, speed, acceleration, jerk;
        } control;
        struct __attribute__((packed)) {
            uint8_t sequence;
            struct stamp stamp;
            uint8_t mode;
        } request;
        struct __attribute__((packed)) {
            struct stamp stamp;
            uint8_t command;
        } lights; // of TURN_COMMAND and HAZARD_COMMAND
    };
};

struct __attribute__((packed)) board_message {
    uint8_t id;
    union __attribute__((packed)) {
        struct __attribute__((packed)) {
            struct stamp stamp;
            uint8_t value;
        } report; // of mode, turn indicators and hazard lights
        struct __attribute__((packed)) {
            uint8_t sequence, success;
        } response;
        struct __attribute__((packed)) {
            struct stamp stamp;
            float longitudinal, lateral, heading_rate;
        } velocity;
        struct __attribute__((packed)) {
            struct stamp stamp;
            float tire_angle;
        } steering;
    };
};

// How long the payload of a message is; 0 if there is none with this id.
uint32_t message_bytes(uint8_t id);
