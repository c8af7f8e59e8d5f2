// SPDX-License-Identifier: GPL-2.0-or-later
//
// CRC-16/ARC: the polynomial 8005 hex, reflected, from 0; "123456789" gives BB3D.

#pragma once

#include <stdint.h>

uint16_t crc_add(uint16_t crc, uint8_t byte);
