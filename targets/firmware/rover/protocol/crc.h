// SPDX-License-Identifier: GPL-2.0-or-later
//
// CRC-16/IBM-3740: polynomial 0x1021, begins with 0xFFFF, highest bit first, nothing inverted at the end.

#pragma once

#include <stdint.h>

uint16_t crc16(const uint8_t *data, uint32_t count);
