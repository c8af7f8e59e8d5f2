// SPDX-License-Identifier: GPL-2.0-or-later
//
// The line to the simulator: USART2 (TX PD5, RX PA3), 921600 8N1, by DMA2 streams 2 and 1.

#pragma once

#include <stdint.h>

#define COMMAND_BYTES 30u // as they are sent
#define STATUS_BYTES 22u

void simulator_line_start(void);

// Sends a command; one that is still under way is finished first. Of several that wait the last one is sent.
void simulator_line_send(const uint8_t frame[COMMAND_BYTES]);

// To be defined by whoever reads; called from interrupts, with what has come since the last call, in order.
void simulator_line_received(const volatile uint8_t *bytes, uint32_t count);
