// SPDX-License-Identifier: GPL-2.0-or-later
//
// DDS-XRCE in the place of the stand-in link: the same messages as samples and requests of topics and a service of ROS 2, with
// the names and types of the original (docs/autoware/messages.md). The build puts this before driving_stack.c, which so speaks
// to a micro-ROS agent without knowing it.

#pragma once

#include "vehicle_interface/board/stack_line.h"
#include "vehicle_interface/stack/frames.h"

#define stack_line_get micro_ros_get
#define frame_take micro_ros_take
#define frame_make micro_ros_make

// Lets the client do what is due. Whether a message has come; the byte means nothing.
bool micro_ros_get(uint8_t *byte);

// Fetches it, to `payload`; returns how long it is.
uint32_t micro_ros_take(struct frame_reader *reader, uint8_t byte, const uint8_t **payload);

// Writes a message, as far as there is a session and room; returns 0, as no frame is left to be sent.
uint32_t micro_ros_make(uint8_t frame[MAX_FRAME], const uint8_t *payload, uint32_t count);
