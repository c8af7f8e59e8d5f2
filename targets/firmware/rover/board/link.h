// SPDX-License-Identifier: GPL-2.0-or-later
//
// The line to the host: USART3 (TX PD8, RX PD9), which the board's ST-LINK makes a virtual COM port of; 8N1.

#pragma once

#include <stdbool.h>
#include <stdint.h>

void link_start(void);

// How many bytes have come and wait.
uint32_t link_waiting(void);

// The next byte that came; false if there is none.
bool link_get(uint8_t *byte);

// Sends all of it, later; or, if there is no room for all of it, nothing: half a frame is worth nothing. Never waits.
void link_send(const uint8_t *data, uint32_t count);
