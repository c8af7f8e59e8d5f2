// SPDX-License-Identifier: GPL-2.0-or-later
//
// The line from the GPS receiver: USART2 (RX PD6, TX PD5), 9600 8N1, as a NEO-6M is delivered. Nothing is sent to it.

#pragma once

#include <stdbool.h>
#include <stdint.h>

void gps_line_start(void);

// The next byte that came; false if there is none.
bool gps_line_get(uint8_t *byte);
