// SPDX-License-Identifier: GPL-2.0-or-later
//
// The line to the driving stack: USART3 (TX PD8, RX PD9), which the board's ST-LINK makes a virtual COM port of; 921600 8N1, by
// DMA1 streams 1 and 0.

#pragma once

#include <stdbool.h>
#include <stdint.h>

void stack_line_start(void);

// The next byte that came; false if there is none.
bool stack_line_get(uint8_t *byte);

// Sends all of it, later; or, if there is no room for all of it, nothing: half a frame is worth nothing. Never waits.
void stack_line_send(const uint8_t *data, uint32_t count);

// To be defined by whoever reads; called from the interrupt when the line falls silent.
void stack_line_silent(void);
